// A whisker: estimated length, health, pressure, plots, decisions and setpoints.

import { get, has, ifServed, list } from "../api.js";
import { proposalActions, whiskerActions } from "../actions.js";
import { errorChart, modelChart } from "../charts/ratio.js";
import { whiskerCharts } from "../charts/whisker.js";
import { h } from "../dom.js";
import { count, interval, mm, mpa, percent, time } from "../format.js";
import { markOf, marksOf } from "../marks.js";
import { api, link, ROUTES } from "../places.js";
import { boxesOf, boxesTable, boxLink } from "../parts/boxes.js";
import { contactUses, contactUsesOf } from "../parts/contact-uses.js";
import { candidatesTable, decisionsTable, setpointsTable } from "../parts/decisions.js";
import { incidents } from "../parts/incidents.js";
import { testsTable } from "../parts/tests.js";
import { facts, section, table, trail } from "../table.js";
import { APPROVALS, CONDITIONS, FAULTS, say } from "../words.js";

/** Number of setpoints shown with their history. */
const HISTORIES = 5;

export default {
  async load({ fleet, robot, array, whisker }) {
    const where = { fleet, robot, array };
    const [about, targets, serves, setpoints, tests, trims, changes, boxes, uses] = await Promise.all([
      get(api.whisker({ ...where, whisker })),
      list("/v1/compensations", { ...where, target_whisker: whisker, limit: 20 }),
      list("/v1/compensations", { ...where, compensator_whisker: whisker, limit: 20 }),
      ifServed("/v1/setpoints", () => list("/v1/setpoints", { ...where, whisker, limit: 20 }), []),
      ifServed("/v1/touch-tests", () => list("/v1/touch-tests", { ...where, whisker, limit: 20 }), []),
      ifServed("/v1/trims", () => list("/v1/trims", { ...where, whisker, limit: 20 }), []),
      ifServed("/v1/health-changes", () => list("/v1/health-changes", { ...where, whisker, limit: 20 }), []),
      boxesOf({ fleet, robot }),
      contactUsesOf({ ...where, whisker }),
    ]);
    const [newest, histories] = await Promise.all([
      targets[0] ? get(api.compensation(targets[0].compensation_id)) : null,
      has("GET", "/v1/setpoints/{}")
        ? Promise.all(
            setpoints.slice(0, HISTORIES).map((one) => get(`/v1/setpoints/${encodeURIComponent(one.command_id)}`)),
          )
        : [],
    ]);
    return {
      about,
      targets,
      serves,
      setpoints: setpoints.map((one, index) => histories[index] ?? one),
      tests,
      trims,
      changes,
      boxes,
      uses,
      newest,
    };
  },

  view(
    { about, targets, serves, setpoints, tests, trims, changes, boxes, uses, newest },
    { fleet, robot, array, whisker },
    refresh,
  ) {
    const others = serves.filter((one) => !targets.some((known) => known.compensation_id === one.compensation_id));
    const actions = whiskerActions(about, refresh);
    const cut = { fleet, robot, array, whisker, length_mm: (0.9 * about.length_mm).toFixed(1) };
    return [
      trail(
        ["Fleets", link.fleets()],
        [`Fleet ${fleet}`, link.fleet(fleet)],
        [`Robot ${robot}`, link.robot({ fleet, robot })],
      ),
      h("h1", { tabindex: "-1" }, `Whisker ${array} ${whisker} of ${robot}`),
      h("p", {}, marksOf(about)),
      has("GET", `${ROUTES.whisker}/what-if`)
        ? h("p", { class: "links" }, h("a", { href: link.whatIf(cut) }, "What if it were cut?"))
        : null,
      facts(of(about)),
      contactUses(uses),
      actions.length ? section("Actions", h("div", { class: "buttons" }, actions)) : null,
      incidents([about], refresh),
      section("Charts", whiskerCharts(about)),
      has("GET", `${ROUTES.whisker}/model`) ? section("Model", modelChart(about), modelHint()) : null,
      newest ? section("Newest decision", decision(newest, refresh)) : null,
      section(
        "All decisions",
        decisionsTable(
          [...targets, ...others],
          "Decisions about it, and those in which it is the compensator",
          "No decisions yet.",
        ),
      ),
      section("Setpoints", setpointsTable(setpoints, "Setpoints, the newest first")),
      section("Touch tests", testsTable(tests, refresh)),
      section("Trims", trimsTable(trims)),
      section("Changes of health", changesTable(changes)),
      section("Black boxes of the robot", boxesTable(boxes)),
    ];
  },
};

function of(whisker) {
  const perHour = (value) => percent(value * 3600, 2);
  const perThousand = (value) => mm(value * 1000, 2);
  return [
    [
      "Length",
      h(
        "span",
        { id: "length" },
        interval(whisker.length_mm, whisker.length_low_mm, whisker.length_high_mm),
        ` of ${mm(whisker.whole_length_mm, 1)}`,
      ),
    ],
    ["Pressure measured", mpa(whisker.pressure_mpa)],
    [
      "Pressure set",
      `${mpa(whisker.setpoint_mpa)}; nominal ${mpa(whisker.nominal_pressure_mpa)}, at most ${mpa(whisker.pressure_max_mpa)}`,
    ],
    ["Contacts used", whisker.contacts.toLocaleString("en")],
    ["Last message", time(whisker.heard_at)],
    ["Model", whisker.model],
    // A rate whose interval contains zero says only that nothing was seen.
    whisker.leak_low_per_s > 0
      ? ["Leak rate per hour", interval(whisker.leak_per_s, whisker.leak_low_per_s, whisker.leak_high_per_s, perHour)]
      : null,
    whisker.erosion_mm_per_contact === null
      ? null
      : [
          "Erosion per 1000 contacts",
          interval(
            whisker.erosion_mm_per_contact,
            whisker.erosion_low_mm_per_contact,
            whisker.erosion_high_mm_per_contact,
            perThousand,
          ),
        ],
    whisker.contacts_left === null ? null : ["Contacts until too short", remaining(whisker)],
  ];
}

function remaining({ contacts_left: left, contacts_left_low: low, contacts_left_high: high }) {
  const whole = (value) => Math.round(value).toLocaleString("en");
  return `${whole(left)} (${low === null ? "?" : whole(low)} to ${high === null ? "never" : whole(high)})`;
}

function modelHint() {
  return h(
    "p",
    { class: "hint" },
    "Strain per mm of deflection at the contact (Eq. 31, averaged over the gauge's grid). The points are the newest contacts at the present length and pressure; the whisker's own curve is the model's with its learned offset.",
  );
}

function decision(newest, refresh) {
  const actions = proposalActions(newest, refresh);
  return [
    h(
      "p",
      {},
      h("a", { href: link.compensation(newest.compensation_id) }, "Decision of ", time(newest.decided_at)),
    ),
    newest.approval ? h("p", {}, markOf(APPROVALS, newest.approval)) : null,
    actions.length ? h("div", { class: "buttons" }, actions) : null,
    candidatesTable(
      newest,
      `${count(newest.candidates.length, "candidate")[0].toUpperCase()}${count(newest.candidates.length, "candidate").slice(1)} and reasons`,
    ),
    errorChart(newest),
  ];
}

function trimsTable(trims) {
  return table({
    caption: "Detected trims, the newest first",
    rows: [...trims].sort((one, other) => other.detected_at.localeCompare(one.detected_at)),
    key: (row) => `trim-${row.trim_id}`,
    empty: "None detected.",
    columns: [
      { name: "Detected", head: true, cell: (row) => time(row.detected_at) },
      { name: "Length before", numeric: true, cell: (row) => mm(row.length_before_mm) },
      {
        name: "Length after",
        numeric: true,
        cell: (row) => interval(row.length_after_mm, row.length_after_low_mm, row.length_after_high_mm),
      },
      { name: "Contacts to detection", numeric: true, cell: (row) => row.contacts_to_detect },
      { name: "Messages", cell: (row) => boxLink(row.black_box_id) ?? "\u2013" },
    ],
  });
}

function changesTable(changes) {
  const word = (row, value) => (value === null ? "none" : say(row.kind === "FAULT" ? FAULTS : CONDITIONS, value));
  return table({
    caption: "Changes of condition and of faults, the newest first",
    rows: [...changes].sort((one, other) => other.recorded_at.localeCompare(one.recorded_at)),
    key: (row) => `change-${row.health_change_id}`,
    empty: "None.",
    columns: [
      { name: "Time", head: true, cell: (row) => time(row.recorded_at) },
      { name: "Kind", cell: (row) => (row.kind === "FAULT" ? "fault" : "condition") },
      { name: "Before", cell: (row) => word(row, row.was) },
      { name: "After", cell: (row) => word(row, row.becomes) },
    ],
  });
}
