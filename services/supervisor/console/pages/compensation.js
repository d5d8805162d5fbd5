// A decision: its effect on the robot, the certainty of the prediction, the alternatives, and the buttons to approve,
// refuse or
// undo it.

import { get } from "../api.js";
import { errorChart } from "../charts/ratio.js";
import { proposalActions, undoActions } from "../actions.js";
import { h } from "../dom.js";
import { mm, mpa, time } from "../format.js";
import { markOf } from "../marks.js";
import { api, link, names } from "../places.js";
import { alternatives } from "../parts/candidates.js";
import { error, looksTable, server, standing } from "../parts/decisions.js";
import { effect, targetLink } from "../parts/effect.js";
import { whyNobody } from "../parts/story.js";
import { facts, section, table, trail } from "../table.js";
import { APPROVALS } from "../words.js";

export default {
  load: ({ id }) => get(api.compensation(id)),

  view(decision, { id }, refresh) {
    const { fleet, robot, array, target_whisker: target } = decision;
    const way = trail(
      ["Fleets", link.fleets()],
      [`Fleet ${fleet}`, link.fleet(fleet)],
      [`Robot ${robot}`, link.robot(decision)],
      [`Whisker ${array} ${target}`, link.whisker(names(decision, target))],
    );
    return [way, ...(decision.compensator_whisker === null ? nobody(decision, id) : somebody(decision, id, refresh))];
  },
};

const targetFact = (decision) => [
  "Target",
  h(
    "span",
    {},
    "whisker ",
    targetLink(decision),
    `, whole length ${mm(decision.target_length_mm, 1)}, at ${mpa(decision.target_pressure_mpa)}`,
  ),
];

/** A decision that found no compensator: why, and what to do. */
function nobody(decision, id) {
  const { robot, array, target_whisker: target } = decision;
  return [
    h("h1", { tabindex: "-1" }, `Whisker ${array} ${target} of ${robot} is not compensated`),
    h("p", { class: "marks" }, standing(decision)),
    h("p", { class: "summary" }, sentence(whyNobody(decision))),
    h(
      "p",
      {},
      "Do not rely on its readings. Mend what keeps the others from serving, or replace the whisker and mark it as replaced on ",
      h("a", { href: link.whisker(names(decision, target)) }, "its page"),
      ".",
    ),
    facts([targetFact(decision), ["Decided", time(decision.decided_at)], ["Number", id]]),
    section("Candidates", alternatives(decision)),
  ];
}

const sentence = (text) => `${text[0].toUpperCase()}${text.slice(1)}.`;

function somebody(decision, id, refresh) {
  const { robot, array, target_whisker: target } = decision;
  const actions = [...proposalActions(decision, refresh), ...undoActions(decision, refresh)];
  const air = decision.measured_air_error === null;
  return [
    h("h1", { tabindex: "-1" }, `Compensation for whisker ${array} ${target} of ${robot}`),
    h(
      "p",
      { class: "marks" },
      decision.approval ? markOf(APPROVALS, decision.approval) : null,
      decision.approval === "PROPOSED" ? null : standing(decision),
    ),
    effect(decision),
    actions.length ? h("div", { class: "buttons" }, actions) : null,
    facts([
      targetFact(decision),
      ["Compensator", server(decision)],
      ["Decided", time(decision.decided_at)],
      ["Pressure before", mpa(decision.pressure_before_mpa)],
      ["Pressure decided", mpa(decision.pressure_mpa)],
      decision.held_pressure_mpa === null ? null : ["Pressure held now", mpa(decision.held_pressure_mpa)],
      ["Predicted error", error(decision, "predicted_error")],
      [
        "Measured error",
        decision.measured_error === null
          ? "not yet"
          : `${error(decision, "measured_error")}${decision.measured_contacts ? `, ${decision.measured_contacts.toLocaleString("en")} contacts` : ""}`,
      ],
      air && decision.measured_error_with_gain !== null
        ? ["Measured error with gain", error(decision, "measured_error_with_gain")]
        : null,
      air ? null : ["Measured error by air alone", error(decision, "measured_air_error")],
      ["Number", id],
    ]),
    section("Alternatives", alternatives(decision)),
    section("Error by contact ratio", errorChart(decision), ratiosTable(decision.errors_by_ratio ?? [])),
    section("Pressure reviews", looksTable(decision.looks ?? [])),
  ];
}

function ratiosTable(bins) {
  return table({
    caption: "Measured error by contact ratio",
    rows: bins,
    empty: "No measurements yet: they need contacts after the setpoint was applied.",
    columns: [
      { name: "Contact ratio", head: true, cell: (row) => row.ratio.toFixed(2) },
      { name: "Contacts", numeric: true, cell: (row) => row.contacts },
      { name: "Error", numeric: true, cell: (row) => error(row, "error") },
      {
        name: "Compared with",
        cell: (row) => (row.target_origin === "MEASURED" ? "measured while whole" : "predicted by the model"),
      },
    ],
  });
}
