// A robot: each array drawn to scale, with the same data in a table.

import { get, ifServed, list } from "../api.js";
import { robotActions } from "../actions.js";
import { h } from "../dom.js";
import { drawing } from "../drawing.js";
import { count, interval, mm, mpa, time } from "../format.js";
import { attention, markOf, marksOf } from "../marks.js";
import { api, link } from "../places.js";
import { boxesOf, boxesTable } from "../parts/boxes.js";
import { decisionsTable } from "../parts/decisions.js";
import { incidents } from "../parts/incidents.js";
import { labelActions, labelChips } from "../parts/labels.js";
import { maintenanceOf, maintenanceLine } from "../parts/maintenance.js";
import { firstAndMenu } from "../parts/menu.js";
import { askedFor, manyOf, newestOf } from "../parts/newest.js";
import { notesOf, robotNotes } from "../parts/notes.js";
import { proposals } from "../parts/proposals.js";
import { refusalsOf, refusalsPart } from "../parts/refusals.js";
import { proposedTests } from "../parts/tests.js";
import { facts, section, table, trail } from "../table.js";
import { ARRAY_TYPES, CONNECTIONS, say } from "../words.js";
import { health } from "./fleets.js";

export default {
  async load({ fleet, robot }, state) {
    const many = manyOf(state);
    const [about, whiskers, decisions, tests, boxes, notes, refusals, windows] = await Promise.all([
      get(api.robot({ fleet, robot })),
      list("/v1/whiskers", { fleet, robot }),
      list("/v1/compensations", { fleet, robot, active: true }),
      ifServed("/v1/touch-tests", () => list("/v1/touch-tests", { fleet, robot, state: "PROPOSED" }), []),
      boxesOf({ fleet, robot }, askedFor(many)),
      notesOf({ fleet, robot }),
      refusalsOf({ fleet, robot }),
      maintenanceOf(),
    ]);
    return { many, about, whiskers, decisions, tests, boxes, notes, refusals, windows };
  },

  view({ many, about, whiskers, decisions, tests, boxes, notes, refusals, windows }, { fleet, robot }, refresh) {
    const waiting = decisions.filter((one) => one.approval === "PROPOSED");
    const decided = decisions.filter((one) => one.approval !== "PROPOSED");
    const running = decided.filter((one) => one.compensator_whisker !== null);
    const without = decided.filter((one) => one.compensator_whisker === null);
    const arrays = Map.groupBy(whiskers, (whisker) => whisker.array);
    return [
      trail(["Fleets", link.fleets()], [`Fleet ${fleet}`, link.fleet(fleet)]),
      h(
        "div",
        { class: "headline" },
        h("h1", { tabindex: "-1" }, `Robot ${robot}`),
        firstAndMenu([...robotActions(about, refresh), ...labelActions(about, refresh)]),
      ),
      h("p", { class: "marks" }, markOf(CONNECTIONS, about.connection), health(about)),
      facts([
        ["Model", about.model],
        ["Programs", programs(about.software)],
        ["Last message", time(about.updated_at)],
        ["Maintenance", maintenanceLine(windows, about)],
        ["Labels", h("div", { class: "of-labels" }, labelChips(about.labels))],
        ["Whiskers", `${count(about.whiskers, "whisker")}, ${about.whiskers_healthy} healthy`],
      ]),
      incidents(whiskers, refresh),
      proposals(waiting, refresh),
      proposedTests(tests, refresh),
      whiskers.length ? null : h("p", { class: "empty" }, "The robot has not sent a factsheet yet."),
      [...arrays].map(([array, row]) => arrayPart(array, row, running)),
      without.length
        ? section(
            "Trimmed, not compensated",
            decisionsTable(without, "Decisions that found no compensator", ""),
          )
        : null,
      section(
        "Active compensations",
        decisionsTable(running, "With predicted and measured errors", "No active compensations."),
      ),
      refusalsPart(refusals),
      robotNotes(notes, about, refresh),
      section("Black boxes", newestOf(boxes, many, boxesTable)),
    ];
  },
};

/** The programs that the robot has named: agent, drivers and firmware. */
function programs(software) {
  const told = software.map(({ kind, name, version }) => `${name} ${version} (${kind.toLowerCase()})`);
  return told.length ? told.join(", ") : null;
}

function arrayPart(array, whiskers, running) {
  const serving = running.filter((one) => one.array === array && one.compensator_whisker !== null);
  const sorted = [...whiskers].sort((one, other) => attention(other) - attention(one) || one.whisker - other.whisker);
  return section(
    `Array ${array}`,
    h("p", {}, `${count(whiskers.length, "whisker")}: ${say(ARRAY_TYPES, whiskers[0].array_type)}.`),
    h(
      "div",
      { class: "beside" },
      h("div", { class: "drawings" }, drawing(whiskers, serving, widthOfDrawing()), legend()),
      whiskersTable(array, sorted, running),
    ),
  );
}

/** Space inside the frame of a drawing, in px: at least what a phone of 360 px has. */
function widthOfDrawing() {
  const main = document.getElementById("main");
  const { paddingLeft, paddingRight } = getComputedStyle(main);
  const frame = 26;
  return Math.max(300, main.clientWidth - parseFloat(paddingLeft) - parseFloat(paddingRight) - frame);
}

function legend() {
  return h(
    "p",
    { class: "hint" },
    "To scale, in mm. Dashed: whole length. Bar at the tip: 95 % interval of the length. Arrow: from compensator to target. Tick or cross: trimmed, with or without a compensation. Below: state, and pressure in MPa.",
  );
}

function whiskersTable(array, whiskers, running) {
  return table({
    caption: `Whiskers of ${array}, those that need attention first`,
    rows: whiskers,
    key: (row) => `whisker-${array}-${row.whisker}`,
    empty: "",
    columns: [
      { name: "Whisker", head: true, cell: (row) => h("a", { href: link.whisker(row) }, `${array} ${row.whisker}`) },
      { name: "State", cell: marksOf },
      { name: "Length", numeric: true, cell: (row) => interval(row.length_mm, row.length_low_mm, row.length_high_mm) },
      { name: "Whole", numeric: true, cell: (row) => mm(row.whole_length_mm, 1) },
      { name: "Pressure", numeric: true, cell: (row) => mpa(row.pressure_mpa) },
      { name: "Compensation", cell: (row) => roles(row, running) },
    ],
  });
}

/** The compensator of a whisker, and its target if it is a compensator. */
function roles(whisker, running) {
  const decision = (id) => running.find((one) => one.compensation_id === id);
  const said = [];
  const [by, in_] = [decision(whisker.compensated_by), decision(whisker.serves_in)];
  if (by && by === in_) said.push([by, "by itself"]);
  else {
    if (by) said.push([by, `by ${by.compensator_whisker}`]);
    if (in_) said.push([in_, `for ${in_.target_whisker}`]);
  }
  return said.length
    ? said.map(([one, words]) => h("a", { href: link.compensation(one.compensation_id) }, words))
    : "\u2013";
}
