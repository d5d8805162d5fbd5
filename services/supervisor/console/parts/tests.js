// Touch tests: their progress and results.

import { testActions } from "../actions.js";
import { h } from "../dom.js";
import { count, interval, time } from "../format.js";
import { markOf } from "../marks.js";
import { link } from "../places.js";
import { section, table } from "../table.js";
import { say, TEST_ERRORS, TEST_KINDS, TEST_REASONS, TEST_STATES } from "../words.js";

/** Touch tests of a whisker, the newest first. */
export function testsTable(rows, done) {
  return table({
    caption: "Touch tests, the newest first",
    rows,
    key: (row) => `test-${row.test_id}`,
    empty: "No touch test was requested yet.",
    columns: [
      { name: "Requested", head: true, cell: (row) => time(row.requested_at) },
      { name: "State", cell: (row) => h("span", { class: "marks" }, markOf(TEST_STATES, row.state)) },
      { name: "Touches", numeric: true, cell: touches },
      { name: "Result", cell: (row) => result(row, done) },
      { name: "Kind", cell: (row) => say(TEST_KINDS, row.kind) },
      { name: "Reason", cell: (row) => say(TEST_REASONS, row.reason) },
    ],
  });
}

/** The section of proposed touch tests; null without any. */
export function proposedTests(rows, done) {
  if (!rows.length) return null;
  const proposed = (row) =>
    h(
      "li",
      { class: "card warn", "data-key": `proposed-${row.test_id}` },
      h("h3", {}, h("a", { href: link.whisker(row) }, `Measure whisker ${row.array} ${row.whisker} by touches`)),
      h(
        "p",
        {},
        `Reason: ${say(TEST_REASONS, row.reason)}.`,
      ),
      h("div", { class: "buttons" }, testActions(row, done)),
    );
  return section("Proposed touch tests", h("ul", { class: "cards" }, rows.map(proposed)));
}

function touches(row) {
  const made = row.touches + row.missed;
  if (!made && !["RUNNING", "DONE"].includes(row.state)) return `${row.contacts} requested`;
  return `${made} of ${row.contacts}${row.missed ? `, ${row.missed} missed` : ""}`;
}

/** What came of a test: the length, or why there is none. */
function result(row, done) {
  if (row.length_mm !== null) return ["length ", interval(row.length_mm, row.length_low_mm, row.length_high_mm)];
  if (row.error) return say(TEST_ERRORS, row.error);
  if (row.state === "PROPOSED") return h("div", { class: "buttons" }, testActions(row, done));
  return row.ended_at ? `no result after ${count(row.touches + row.missed, "touch", "touches")}` : "\u2013";
}
