// What if a whisker were cut: the decisions that would follow, their candidates, and the predicted sensitivity.

import { change } from "../address.js";
import { get, list } from "../api.js";
import { whatIfChart } from "../charts/ratio.js";
import { h } from "../dom.js";
import { count, mpa } from "../format.js";
import { problemPanel } from "../notices.js";
import { candidatesTable, error } from "../parts/decisions.js";
import { fleetsOf } from "../parts/fleets.js";
import { api, link } from "../places.js";
import { section, table, trail } from "../table.js";
import { END_REASONS, OBJECTIVES, say, SETPOINT_REASONS } from "../words.js";

/** Most robots that the field for the robot suggests. */
const ROBOTS = 100;

export default {
  async load(_, state) {
    const fleets = await fleetsOf();
    const fleet = state.fleet ?? (fleets.length === 1 ? fleets[0] : undefined);
    const [robots, whiskers] = await Promise.all([
      fleet ? list("/v1/robots", { fleet, sort: "robot", limit: ROBOTS }) : [],
      fleet && state.robot ? list("/v1/whiskers", { fleet, robot: state.robot }) : [],
    ]);
    const chosen = { ...state, fleet };
    return { fleets, robots, whiskers, chosen, ...(await answerTo(chosen, whiskers)) };
  },

  view({ fleets, robots, whiskers, chosen, answer, problem }) {
    const own = subject(chosen, whiskers);
    return [
      own ? trail(["Fleets", link.fleets()], [`Robot ${own.robot}`, link.robot(own)], [`Whisker ${own.array} ${own.whisker}`, link.whisker(own)]) : null,
      h("h1", { tabindex: "-1" }, "What if"),
      h("p", { class: "summary" }, "The decisions and setpoints that would follow a cut. Nothing is sent, and nothing changes."),
      form(fleets, robots, whiskers, chosen, own),
      problem ? problemPanel(problem) : null,
      answer ? result(answer, own) : null,
    ];
  },
};

/** The chosen whisker, if the choice is complete. */
function subject({ array, whisker }, whiskers) {
  return whiskers.find((one) => one.array === array && String(one.whisker) === whisker) ?? null;
}

async function answerTo(chosen, whiskers) {
  const own = subject(chosen, whiskers);
  const length_mm = Number(chosen.length_mm);
  if (chosen.robot && !whiskers.length)
    return { problem: { title: "", message: `Fleet ${chosen.fleet} has no robot ${chosen.robot} with whiskers.` } };
  if (!own || !(length_mm > 0)) return {};
  try {
    return { answer: await get(`${api.whisker(own)}/what-if`, { length_mm }) };
  } catch (problem) {
    if (problem.isSilence || problem.status === 401) throw problem;
    return { problem };
  }
}

function form(fleets, robots, whiskers, chosen, own) {
  const arrays = [...new Set(whiskers.map((one) => one.array))];
  const numbers = whiskers.filter((one) => one.array === chosen.array).map((one) => String(one.whisker));
  const choose = (event) => change({ [event.target.name]: event.target.value.trim() });
  const cleared = { fleet: ["robot", "array", "whisker"], robot: ["array", "whisker"], array: ["whisker"] };
  const chooseAnew = (event) => {
    const { name, value } = event.target;
    change({ ...Object.fromEntries(cleared[name].map((one) => [one, null])), [name]: value.trim() });
  };
  const label = (words, control) => h("label", { class: "tool" }, h("span", {}, words), control);
  const select = (name, values, onchange) =>
    h(
      "select",
      { id: `what-if-${name}`, name, "data-of-address": true, onchange, disabled: !values.length },
      ["", ...values].map((value) => h("option", { value, selected: (chosen[name] ?? "") === value }, value || "choose")),
    );
  const field = (name, value, attributes) =>
    h("input", { id: `what-if-${name}`, name, value: value ?? "", "data-of-address": true, ...attributes });
  const present = own ? `Cut to, mm (now ${own.length_mm.toFixed(1)})` : "Cut to, mm";
  return h(
    "form",
    { class: "tools", "aria-label": "Cut", onsubmit: (event) => event.preventDefault() },
    label("Fleet", select("fleet", fleets, chooseAnew)),
    label("Robot", field("robot", chosen.robot, { list: "what-if-robots", maxlength: 64, onchange: chooseAnew })),
    h("datalist", { id: "what-if-robots" }, robots.map(({ robot }) => h("option", { value: robot }))),
    label("Array", select("array", arrays, chooseAnew)),
    label("Whisker", select("whisker", numbers, choose)),
    label(present, field("length_mm", chosen.length_mm, { type: "number", min: 1, max: 1000, step: "any", onchange: choose })),
  );
}

function result(answer, own) {
  const where = { fleet: own.fleet, robot: own.robot };
  return [
    section(
      "Consequences",
      h("ul", {}, answer.decisions.map(told), answer.ended.map(ended), answer.setpoints.map(setpoint)),
      answer.decisions.length
        ? null
        : h("p", { class: "empty" }, "No decision would be made: the whisker is held, or it has a fault."),
    ),
    answer.decisions.length ? section("The three objectives", objectivesTable(answer.by_objective)) : null,
    answer.by_ratio.length
      ? section(
          "Predicted sensitivity",
          whatIfChart(answer.by_ratio),
          h(
            "p",
            { class: "hint" },
            "Strain per mm of deflection at the contact (Eq. 31, averaged over the gauge's grid), each with the learned offset of its whisker. Before and after the cut the whisker has its nominal pressure; compensated is the reading of the compensator at the pressure of its setpoint, with its gain if the robot applies one.",
          ),
        )
      : null,
    answer.decisions.map((decision) =>
      section(
        `Candidates for whisker ${decision.array} ${decision.target_whisker}`,
        candidatesTable({ ...decision, ...where }, `${count(decision.candidates.length, "candidate")} with reasons`),
      ),
    ),
  ];
}

/** The compensation with each objective, the one in force marked. */
function objectivesTable(rows) {
  return table({
    caption: "Objectives of the policy",
    rows,
    key: (row) => row.objective,
    columns: [
      {
        name: "Objective",
        head: true,
        cell: (row) => [say(OBJECTIVES, row.objective), row.in_force ? h("strong", {}, " (in force)") : null],
      },
      { name: "Compensator", cell: (row) => (row.compensator_whisker === null ? "none is suitable" : `whisker ${row.compensator_whisker}`) },
      { name: "Pressure", numeric: true, cell: (row) => mpa(row.pressure_mpa) },
      { name: "Gain", numeric: true, cell: (row) => (row.reading_gain === null ? "none" : row.reading_gain.toFixed(3)) },
      { name: "Predicted error of the reading", numeric: true, cell: (row) => error(row, "predicted_error") },
    ],
  });
}

function told({ array, target_whisker: target, compensator_whisker: compensator }) {
  if (compensator === null) return h("li", {}, `Whisker ${array} ${target}: no candidate is suitable.`);
  const who = compensator === target ? "it compensates for itself" : `whisker ${compensator} compensates for it`;
  return h("li", {}, `Whisker ${array} ${target}: ${who}.`);
}

const ended = ({ compensation_id: id, reason }) =>
  h("li", {}, h("a", { href: link.compensation(id) }, "A compensation in force"), ` ends: ${say(END_REASONS, reason)}.`);

const setpoint = ({ array, whisker, pressure_mpa: pressure, reason }) =>
  h("li", {}, `Whisker ${array} ${whisker} is set to ${mpa(pressure)}: ${say(SETPOINT_REASONS, reason)}.`);
