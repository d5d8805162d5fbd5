// Entries of the timeline in words, with steps of one setpoint and repeated measurements in one line.

import { h } from "../dom.js";
import { ago, count, mm, mpa, percent } from "../format.js";
import { shapeOf } from "../marks.js";
import { link, whiskerName } from "../places.js";
import {
  ACTION_STATES,
  ALARM_KINDS,
  AUDIT_KINDS,
  CASES,
  CONDITIONS,
  END_REASONS,
  FAULTS,
  LOOKS,
  REFUSALS,
  ROLLOUT_STAGES,
  ROLLOUT_STATES,
  say,
  SETPOINT_ERRORS,
  SETPOINT_REASONS,
  SETPOINT_STATES,
  TEST_STATES,
  TIMELINE_KINDS,
} from "../words.js";
import { dateFormat, zoneName } from "../zone.js";

/** Most parameters of an action in its line; the audit log has all. */
const PARAMETERS = 3;
/** Parameters of actions that say nothing to people. */
const SILENT = ["parent_id", "which", "expected_version"];
/** Most whiskers that a tooltip names. */
const NAMED_MAX = 30;

/** Words, tone and shape of each kind of entry. */
const KINDS = {
  TRIM: ({ trim }) => [
    "bad",
    "stump",
    `cut found: ${mm(trim.length_before_mm, 1)} to ${mm(trim.length_after_mm, 1)} after ${count(trim.contacts_to_detect, "contact")}`,
  ],
  ALARM_RAISED: (_, { word }) => ["warn", "bell", `alarm: ${say(ALARM_KINDS, word)}`],
  ALARM_CLEARED: (_, { word }) => ["good", "bell", `alarm over: ${say(ALARM_KINDS, word)}`],
  CONDITION_CHANGED: ({ condition }) => [
    "info",
    "slope",
    `${say(CONDITIONS, condition.was)} to ${say(CONDITIONS, condition.becomes)}`,
  ],
  FAULT_CHANGED: ({ fault: { was, becomes } }, { many }) => [
    becomes ? "bad" : "good",
    becomes ? "cross" : "circle",
    `${becomes ? `found: ${say(FAULTS, becomes)}` : `over: ${say(FAULTS, was)}`}${many > 1 ? `, after ${count(many - 1, "change")}` : ""}`,
  ],
  WHISKER_GONE: ({ gone }) => ["off", "ring", `whisker ${gone.array} ${gone.whisker} is not on the robot any more`],
  DECISION: decided,
  COMPENSATION_BEGUN: ({ compensation: one }, { array }) => [
    "good",
    "propped",
    `compensation begun: ${one.case === "SELF_COMPENSATION" ? say(CASES, one.case) : `${array} ${one.compensator_whisker}, ${say(CASES, one.case)}`}${one.pressure_mpa === null ? "" : `, to ${mpa(one.pressure_mpa)}`}`,
  ],
  COMPENSATION_ENDED: ({ compensation }) => [
    "warn",
    "ring",
    `compensation ended: ${say(END_REASONS, compensation.end_reason)}`,
  ],
  PROPOSAL_ENDED: ({ compensation }) => ["off", "ring", `proposal ended: ${say(END_REASONS, compensation.end_reason)}`],
  SETPOINT: setpoint,
  SETPOINT_STATE: setpoint,
  SETPOINT_FAILED: setpoint,
  ERROR: ({ error }, { many }) => [
    "info",
    "dial",
    `reading error ${percent(error.error)} at ${mpa(error.pressure_mpa)}${many > 1 ? `, measured ${count(many, "time")}` : ""}`,
  ],
  REFINEMENT: ({ refinement: one }) => [
    "info",
    "dial",
    `pressure reviewed: ${say(LOOKS, one.outcome)}${one.outcome === "REFINED" ? `, ${one.pressure_from_mpa.toFixed(4)} to ${mpa(one.pressure_best_mpa)}` : ""}`,
  ],
  TOUCH_TEST: ({ touch_test: test }) => ["info", "hand", `touch test: ${say(TEST_STATES, test.state)}`],
  POLICY: ({ policy }) => ["info", "hand", `policy ${policy.version} in force`],
  CALIBRATION: ({ calibration }) => ["info", "hand", `calibration of ${calibration.model} in force`],
  ROLLOUT: ({ rollout }) => [
    "info",
    "dots",
    `roll-out ${rollout.rollout_id}: ${say(ROLLOUT_STATES, rollout.state)}, ${say(ROLLOUT_STAGES, rollout.stage)}`,
  ],
  QUARANTINED: ({ quarantine }) => [
    "warn",
    "gap",
    `a message of ${quarantine.robot} was put into quarantine: ${quarantine.topic}`,
  ],
  ACTION: acted,
};

function decided({ decision }, { array }) {
  const chosen = decision.candidates.find((one) => one.chosen);
  if (!chosen) {
    const [first] = decision.candidates.map((one) => one.refused).filter(Boolean);
    const why = first ? `: ${say(REFUSALS, first)}${decision.candidates.length > 1 ? " ..." : ""}` : "";
    return ["bad", "cross", `not compensated: none of ${count(decision.candidates.length, "candidate")} can serve${why}`];
  }
  const own = chosen.case === "SELF_COMPENSATION";
  const what = `${own ? "itself" : `${array} ${chosen.whisker}`} to ${mpa(chosen.pressure_mpa)}, predicted error ${percent(chosen.predicted_error)}`;
  return decision.proposed ? ["warn", "diamond", `proposed: ${what}`] : ["info", "tick", `decided: ${what}`];
}

function setpoint({ setpoint: one }, { steps = [] }) {
  const known = { APPLIED: "good", REJECTED: "bad", FAILED: "bad", EXPIRED: "bad" }[one.state] ?? "info";
  const tone = one.rejection === "IN_TASK" ? "info" : known;
  const why = one.rejection ? `: ${say(SETPOINT_ERRORS, one.rejection)}` : "";
  const reason = one.reason ? `, ${say(SETPOINT_REASONS, one.reason)}` : "";
  const span = steps.length > 1 ? (Date.parse(steps[0].at) - Date.parse(steps.at(-1).at)) / 1000 : 0;
  const after = span > 0 ? ` after ${span.toFixed(span < 10 ? 1 : 0)}\u00a0s` : "";
  return [tone, "dial", `setpoint ${mpa(one.pressure_mpa)} ${say(SETPOINT_STATES, one.state)}${after}${why}${reason}`];
}

function acted(parameters, { word, actor, reason, state }) {
  const known = Object.entries(parameters).filter(
    ([name, value]) => value !== null && typeof value !== "object" && !SILENT.includes(name),
  );
  const shown = known
    .slice(0, PARAMETERS)
    .map(([name, value]) => `${name.replaceAll("_", " ")} ${String(value).slice(0, 60)}`);
  const told = [...shown, ...(known.length > PARAMETERS ? ["..."] : [])].join(", ");
  const result = state === "DONE" ? "" : `, ${say(ACTION_STATES, state)}`;
  return [
    state === "REFUSED" || state === "EXPIRED" ? "warn" : "off",
    "hand",
    `${actor}: ${say(AUDIT_KINDS, word)}${told ? ` (${told})` : ""}${reason ? `, \u201c${reason}\u201d` : ""}${result}`,
  ];
}

/** An entry in words: `{ tone, shape, words }`. A kind of a newer service is named by its own word. */
export function toldOf(entry) {
  const known = KINDS[entry.kind];
  const [tone, shape, words] = known ? known(entry.data, entry) : ["off", "ring", say(TIMELINE_KINDS, entry.kind)];
  return { tone, shape, words };
}

/** Changes of one kind within this time are one line. */
const TOGETHER_MS = 60_000;

/**
 * What a line stands for: steps of one setpoint, measurements of one compensation, a fault that comes and goes, and whiskers
 * that change in the same way are one line.
 */
function keyOf({ kind, data, fleet, robot, array, whisker }) {
  if (kind === "FAULT_CHANGED") return `${fleet}/${robot}/${array}/${whisker} fault`;
  if (kind === "CONDITION_CHANGED") return `${fleet} ${data.condition.was} ${data.condition.becomes}`;
  if (data.setpoint) return `${fleet}/${robot} ${data.setpoint.command_id}`;
  return kind === "ERROR" ? `${fleet}/${robot} error ${data.error.compensation_id}` : null;
}

/**
 * Entries that another one of the same moment tells, too: the condition after a cut, and the begin of what was decided.
 */
function repeated(entries) {
  const where = ({ at, fleet, robot, array, whisker }) => `${at} ${fleet}/${robot}/${array}/${whisker}`;
  const of = (kind) => new Set(entries.filter((one) => one.kind === kind).map(where));
  const [trims, decisions] = [of("TRIM"), of("DECISION")];
  return (one) =>
    (one.kind === "CONDITION_CHANGED" && one.data.condition.becomes === "TRIMMED" && trims.has(where(one))) ||
    (one.kind === "COMPENSATION_BEGUN" && decisions.has(where(one)));
}

/**
 * Entries, the newest first, with those of one setpoint and repeated measurements folded into the newest of them, and
 * without
 * those that another one of the same moment tells.
 */
export function folded(entries) {
  const isRepeated = repeated(entries);
  const lines = [];
  const known = new Map();
  let lastError = null;
  for (const entry of entries.filter((one) => !isRepeated(one))) {
    const key = keyOf(entry);
    const isError = entry.kind === "ERROR";
    const isChange = ["FAULT_CHANGED", "CONDITION_CHANGED"].includes(entry.kind);
    const isLate = isChange && Date.parse(known.get(key)?.at) - Date.parse(entry.at) > TOGETHER_MS;
    // A measurement is folded only into the line before it: other entries between them are worth their place.
    const line = isLate ? null : isError
      ? lastError?.key === key && lines.at(-1) === lastError.line
        ? lastError.line
        : null
      : key && known.get(key);
    if (line) {
      line.many += 1;
      line.steps.push(entry);
      // Only the decision of a setpoint knows its reason.
      if (entry.data.setpoint)
        line.data = { ...line.data, setpoint: { ...entry.data.setpoint, ...present(line.data.setpoint) } };
      continue;
    }
    const next = { ...entry, many: 1, steps: [entry] };
    lines.push(next);
    if (isError) lastError = { key, line: next };
    else if (key) known.set(key, next);
  }
  return lines;
}

const present = (part) => Object.fromEntries(Object.entries(part).filter(([, value]) => value !== null));

function placeOf({ kind, data, action_id: action, word }) {
  const compensation =
    data.decision?.compensation_id ??
    data.compensation?.compensation_id ??
    data.error?.compensation_id ??
    data.refinement?.compensation_id ??
    data.setpoint?.compensation_id;
  if (compensation !== null && compensation !== undefined) return [link.compensation(compensation), "decision"];
  if (kind.startsWith("ALARM")) return [link.alarms(), "alarms"];
  if (kind === "ROLLOUT") return [link.rollout(data.rollout.rollout_id), "roll-out"];
  if (action !== null && !/SIGN_/.test(word)) return [link.audit(), "audit"];
  return null;
}

function subject(entry, withFleet) {
  if (!entry.fleet) return null;
  if (entry.kind === "CONDITION_CHANGED" && entry.many > 1) return several(entry);
  const fleet = withFleet && entry.robot ? h("a", { href: link.fleet(entry.fleet) }, entry.fleet) : null;
  return [fleet, named(entry)];
}

/** The whiskers that have changed together; a tooltip names them. */
function several({ fleet, steps }) {
  const robots = new Set(steps.map(({ robot }) => robot));
  const whiskers = new Set(steps.map((one) => `${one.robot} ${whiskerName(one)}`));
  const title = [...whiskers].slice(0, NAMED_MAX).join(", ") + (whiskers.size > NAMED_MAX ? " \u2026" : "");
  const [robot] = robots;
  const href = robots.size === 1 ? link.robot({ fleet, robot }) : link.fleet(fleet);
  const where = robots.size === 1 ? robot : count(robots.size, "robot");
  return h("a", { href, title }, `${where}, ${count(whiskers.size, "whisker")}`);
}

function named(entry) {
  if (entry.array !== null && entry.array !== undefined)
    return [
      h("a", { href: link.robot(entry) }, entry.robot),
      h("a", { href: link.whisker(entry) }, `whisker ${whiskerName(entry)}`),
    ];
  return entry.robot
    ? h("a", { href: link.robot(entry) }, entry.robot)
    : h("a", { href: link.fleet(entry.fleet) }, `fleet ${entry.fleet}`);
}

const CLOCK = { timeStyle: "medium" };
const DAY = { dateStyle: "full" };

/** The clock of an entry; its day is above it. */
function clock(at) {
  return h("time", { datetime: at, title: `${at} (UTC), ${ago(at)}` }, dateFormat(CLOCK).format(new Date(at)));
}

/**
 * The list of entries. `isOfWhisker` leaves their subject out, because the page names it; `withFleet` names the fleet,
 * where there
 * are several.
 */
export function entriesList(entries, { isOfWhisker = false, withFleet = false, empty }) {
  const lines = folded(entries);
  if (!lines.length) return h("p", { class: "empty" }, empty);
  let day = null;
  const line = (entry) => {
    const own = `${dateFormat(DAY).format(new Date(entry.at))}, ${zoneName(new Date(entry.at))}`;
    const heading = own === day ? null : h("li", { class: "day", "data-key": `day-${own}` }, own);
    day = own;
    const { tone, shape, words } = toldOf(entry);
    const place = placeOf(entry);
    const told = h(
      "li",
      { "data-key": `entry-${entry.steps.at(-1).entry_id}`, "data-kind": entry.kind },
      clock(entry.at),
      h("span", { class: `sign ${tone}` }, shapeOf(shape)),
      h(
        "span",
        { class: "what" },
        isOfWhisker ? null : h("span", { class: "who" }, subject(entry, withFleet)),
        h("span", {}, words),
      ),
      place ? h("a", { class: "to", href: place[0] }, place[1]) : null,
    );
    return [heading, told];
  };
  return h("ol", { class: "entries" }, lines.map(line));
}
