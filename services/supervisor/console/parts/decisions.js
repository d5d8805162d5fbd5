// Tables of decisions and setpoints, which several pages show.

import { h } from "../dom.js";
import { count, interval, mm, mpa, orNone, percent, time } from "../format.js";
import { mark, markOf } from "../marks.js";
import { link, names } from "../places.js";
import { table } from "../table.js";
import { decisionPicture } from "./effect.js";
import { APPROVALS, CASES, END_REASONS, LOOKS, REFUSALS, say, SETPOINT_ERRORS, SETPOINT_REASONS, SETPOINT_STATES } from "../words.js";

/** A predicted or measured error with its interval. */
export const error = (row, name) => interval(row[name], row[`${name}_low`], row[`${name}_high`], percent);

/** State of a decision: ended, waiting, active, or without compensator. */
export function standing(row) {
  if (row.ended_at)
    return h(
      "span",
      { class: "marks" },
      mark(`ended: ${say(END_REASONS, row.end_reason)}`, "off", "ring"),
      time(row.ended_at),
    );
  if (row.approval === "PROPOSED" || row.approval === "REFUSED") return markOf(APPROVALS, row.approval);
  if (row.compensator_whisker === null) return mark("not compensated", "bad", "cross");
  if (row.setpoint_error === "IN_TASK") return mark(say(SETPOINT_ERRORS, row.setpoint_error), "warn", "clock");
  return row.setpoint_state ? markOf(SETPOINT_STATES, row.setpoint_state) : mark("active", "good", "circle");
}

/** The columns of a table of decisions. */
export function decisionColumns() {
  return [
    {
      name: "Decision",
      head: true,
      cell: (row) => h("a", { href: link.compensation(row.compensation_id) }, `${row.array} ${row.target_whisker}`),
    },
    { name: "Decided", sort: "decided_at", descends: true, isDefault: true, cell: (row) => time(row.decided_at) },
    { name: "Compensator", cell: (row) => server(row) },
    {
      name: "Pressure",
      numeric: true,
      cell: (row) =>
        row.pressure_mpa === null
          ? "\u2013"
          : `${mpa(row.pressure_before_mpa)} \u2192 ${mpa(row.held_pressure_mpa ?? row.pressure_mpa)}`,
    },
    { name: "Predicted and measured error", cell: errors, isWide: true },
    { name: "State", cell: standing },
  ];
}

/** Both errors as a picture with the newest of them in words. */
function errors(row) {
  if (row.compensator_whisker === null) return "\u2013";
  const newest =
    row.measured_error === null
      ? `${percent(row.predicted_error)} predicted`
      : `${percent(row.measured_error)} measured`;
  return h("span", { class: "outlook" }, decisionPicture(row), h("span", {}, newest));
}

/** Decisions, the newest first. */
export function decisionsTable(rows, caption, empty) {
  return table({ caption, rows, empty, key: (row) => `decision-${row.compensation_id}`, columns: decisionColumns() });
}

/** The compensator of a decision, and the case. */
export function server(row) {
  if (row.compensator_whisker === null) return "none available";
  const whisker = h(
    "a",
    { href: link.whisker(names(row, row.compensator_whisker)) },
    `whisker ${row.compensator_whisker}`,
  );
  return h("span", { class: "mixed" }, whisker, `: ${say(CASES, row.case)}`);
}

/** The candidates of a decision with reasons. */
export function candidatesTable(decision, caption) {
  const verdict = (row) =>
    row.chosen
      ? mark("chosen", "good", "tick")
      : mark(row.refused ? say(REFUSALS, row.refused) : "not needed", "off", "ring");
  return table({
    caption,
    rows: decision.candidates,
    empty: "No candidates.",
    columns: [
      {
        name: "Candidate",
        head: true,
        cell: (row) => h("a", { href: link.whisker(names(decision, row.whisker)) }, `whisker ${row.whisker}`),
      },
      { name: "Result", cell: verdict },
      { name: "Case", cell: (row) => say(CASES, row.case) },
      {
        name: "Length",
        numeric: true,
        cell: (row) =>
          interval(row.length_mm, row.length_mm - 1.96 * row.length_sd_mm, row.length_mm + 1.96 * row.length_sd_mm, mm),
      },
      {
        name: "Pressure",
        numeric: true,
        cell: (row) =>
          row.pressure_mpa === null ? "\u2013" : `${mpa(row.pressure_before_mpa)} \u2192 ${mpa(row.pressure_mpa)}`,
      },
      { name: "Predicted error", numeric: true, cell: (row) => error(row, "predicted_error") },
      { name: "Own role", cell: (row) => (row.gives_up_own_role ? "loses its own role" : "keeps its own role") },
    ],
  });
}

/** Reviews of the present setpoint with their outcomes. */
export function looksTable(looks) {
  return table({
    caption: "What the supervisor found after more contacts",
    rows: looks,
    empty: "No reviews yet: the first follows after 200 contacts.",
    columns: [
      { name: "Time", head: true, cell: (row) => time(row.recorded_at) },
      { name: "Contacts", numeric: true, cell: (row) => row.contacts },
      {
        name: "Outcome",
        cell: (row) => say(LOOKS, row.outcome) + (row.gain_published ? "; new gain sent" : ""),
      },
      {
        name: "Pressure",
        numeric: true,
        cell: (row) =>
          `${mpa(row.pressure_from_mpa)}${row.outcome === "REFINED" ? ` \u2192 ${mpa(row.pressure_best_mpa)}` : ""}`,
      },
      { name: "Measured error", numeric: true, cell: (row) => error(row, "error") },
      { name: "Expected error at best", numeric: true, cell: (row) => error(row, "error_best") },
      { name: "Error with gain", numeric: true, cell: (row) => percent(row.error_with_gain) },
    ],
  });
}

/** Setpoints, the newest first; `history` holds the states of the newest ones. */
export function setpointsTable(rows, caption) {
  return table({
    caption,
    rows,
    empty: "No setpoint was sent to this whisker. A neighbour that serves for it has its own.",
    key: (row) => row.command_id,
    columns: [
      { name: "Sent", head: true, cell: (row) => time(row.issued_at) },
      { name: "Pressure", numeric: true, cell: (row) => mpa(row.pressure_mpa) },
      {
        name: "State",
        cell: (row) =>
          h(
            "span",
            { class: "marks" },
            markOf(SETPOINT_STATES, row.state),
            row.error ? h("span", {}, say(SETPOINT_ERRORS, row.error)) : null,
          ),
      },
      { name: "Reached", numeric: true, cell: (row) => mpa(row.reached_mpa) },
      { name: "Reason", cell: (row) => say(SETPOINT_REASONS, row.reason) },
      {
        name: "Decision",
        cell: (row) =>
          row.compensation_id === null
            ? "\u2013"
            : h("a", { href: link.compensation(row.compensation_id) }, "decision"),
      },
      { name: "History", cell: (row) => steps(row.history) },
    ],
  });
}

function steps(history) {
  if (!history) return orNone(null);
  const step = (one) =>
    h("li", {}, say(SETPOINT_STATES, one.state), one.error ? ` (${say(SETPOINT_ERRORS, one.error)})` : "", " ", time(one.at));
  return h("details", {}, h("summary", {}, count(history.length, "step")), h("ol", {}, history.map(step)));
}
