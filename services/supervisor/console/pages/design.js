// All parts of the console in all states, for people who change them. Only debug builds of the service have this page.

import { h } from "../dom.js";
import { age, interval, mm, mpa, percent, time } from "../format.js";
import { mark, markOf, marksOf } from "../marks.js";
import { firstAndMenu, menu } from "../parts/menu.js";
import { distribution, spark } from "../parts/spark.js";
import { empty, facts, section, table, trail } from "../table.js";
import * as words from "../words.js";

const LISTS = [
  words.CONDITIONS,
  words.FAULTS,
  words.CONNECTIONS,
  words.ALARM_LEVELS,
  words.ALARM_STATES,
  words.APPROVALS,
  words.ACTION_STATES,
  words.SETPOINT_STATES,
  words.WEBHOOK_STATES,
];
const AT = "2026-11-29T03:04:05.000Z";

const whisker = (whisker, more) => ({
  fleet: "hall-1",
  robot: "crawler-with-a-long-name-17",
  array: "left",
  whisker,
  connection: "ONLINE",
  condition: "HEALTHY",
  fault: null,
  held: false,
  compensated_by: null,
  length_mm: 64.88,
  ...more,
});

const WHISKERS = [
  whisker(0, { condition: "TRIMMED" }),
  whisker(1, { condition: "TRIMMED", compensated_by: 7 }),
  whisker(2, { fault: "LEAK" }),
  whisker(3, { condition: "ERODING", held: true }),
  whisker(4, { connection: "SILENT", fault: "STALE" }),
  whisker(5, {}),
];

const button = (words, properties = {}) => h("button", { type: "button", ...properties }, words);

export default {
  load: async () => null,

  view: () => [
    trail(["Fleets", "#/fleets"], ["Fleet hall-1", "#/fleets/hall-1"]),
    h(
      "div",
      { class: "headline" },
      h("h1", { tabindex: "-1" }, "Design"),
      h("p", { class: "summary" }, "All parts in all states."),
      firstAndMenu([button("First action \u2026"), button("Second \u2026"), button("Grave \u2026", { class: "grave" })]),
    ),
    section(
      "Type",
      h(
        "p",
        {},
        "Text with ",
        h("a", { href: "#/design" }, "a link"),
        ", ",
        h("code", {}, "code"),
        " and ",
        h("kbd", {}, "g"),
        ".",
      ),
      h("p", { class: "hint" }, "Hints and times are small or grey: ", time(AT), ", ", age(AT), "."),
    ),
    section("Tiles", tiles()),
    section(
      "Marks",
      LISTS.map((list) => h("p", { class: "marks" }, Object.keys(list).map((word) => markOf(list, word)))),
    ),
    section(
      "Buttons",
      h(
        "div",
        { class: "buttons" },
        button("Primary", { class: "primary" }),
        button("Normal"),
        button("Grave", { class: "grave" }),
        button("Not allowed", { "aria-disabled": "true" }),
        button("Quiet", { class: "quiet" }),
        h("a", { class: "button", href: "#/design" }, "Link"),
        menu("Menu", [button("One"), button("Two")]),
      ),
    ),
    section(
      "Fields",
      h(
        "form",
        { class: "tools", onsubmit: (event) => event.preventDefault() },
        h("label", { class: "tool" }, h("span", {}, "Search"), h("input", { type: "search", placeholder: "robot or model" })),
        h("label", { class: "tool" }, h("span", {}, "State"), h("select", {}, h("option", {}, "all"))),
        h("label", { class: "check" }, h("input", { type: "checkbox", checked: true }), h("span", {}, "a choice")),
      ),
    ),
    section("Facts", facts([["Length", interval(64.88, 64.31, 65.45)], ["Pressure", mpa(0.0472)], ["Heard", time(AT)]])),
    section("Table", rows(WHISKERS), rows([])),
    section("Nothing to show", empty("No robots match.", ["Show all robots", "#/design"])),
    section(
      "Messages",
      h("div", { class: "problem" }, h("p", {}, "A problem with its reason.")),
      h("div", { class: "card warn" }, h("h3", {}, "A card"), h("p", {}, "It waits for people.")),
    ),
    section(
      "Small charts",
      h("div", { class: "changes" }, spark([0, 2, 5, 0, 0, 9, 3, 1], "eight hours")),
      distribution([0.05, 0.1, null].map((to, at) => ({ error_from: at * 0.05, error_to: to, compensations: [12, 3, 1][at] }))),
    ),
  ],
};

function tiles() {
  const all = Object.entries(words.ROBOT_STATES);
  const chip = ([, [text, tone, letter]]) =>
    h(
      "li",
      {},
      h(
        "span",
        { class: "chip" },
        h("span", { class: `tile ${tone}`, "aria-hidden": "true" }, letter),
        h("strong", {}, "3"),
        ` ${text}`,
      ),
    );
  return h("ul", { class: "chips" }, all.map(chip));
}

function rows(some) {
  return table({
    caption: `${some.length} whiskers`,
    rows: some,
    key: (row) => `design-${row.whisker}`,
    empty: "No whisker is known yet.",
    columns: [
      { name: "Whisker", head: true, cell: (row) => h("a", { href: "#/design" }, `${row.array} ${row.whisker}`) },
      { name: "Robot", cell: (row) => h("a", { href: "#/design" }, row.robot) },
      { name: "State", cell: marksOf },
      { name: "Length", numeric: true, cell: (row) => mm(row.length_mm) },
      { name: "Error", numeric: true, cell: () => percent(0.0123) },
      { name: "Mark", cell: () => mark("held by an operator", "info", "hand") },
      { name: "Heard", cell: () => age(AT) },
    ],
  });
}
