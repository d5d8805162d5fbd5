// Events of a whisker that charts mark: trims, setpoints, alarms, holds, changes of temperature.

import { has, list } from "../api.js";
import { mm, mpa } from "../format.js";
import { link } from "../places.js";
import { AUDIT_KINDS, ALARM_KINDS, SETPOINT_REASONS, SETPOINT_STATES, say } from "../words.js";
import { named } from "./data.js";

/** Number of newest events of a kind that are considered. */
const MANY = 200;
/** Change of temperature that is an event, °C. */
const TEMPERATURE_STEP_C = 5;
/** A decision belongs to a trim if it follows within this time. */
const DECISION_WITHIN_MS = 10 * 60_000;

/** Kinds of events: words, tone and shape of their marks. */
export const KINDS = {
  trim: ["trim", "bad", "stump"],
  alarm: ["alarm", "warn", "bell"],
  setpoint: ["setpoint", "info", "dial"],
  hold: ["hold or release", "off", "hand"],
  temperature: ["temperature", "warn", "heat"],
};

/** The events in a window in order of time: `{ at, kind, words, href, to }`; `to` are the words of the link. */
export async function eventsOf(whisker, window, { rows, setpoints }) {
  const where = named(whisker);
  const { fleet, robot, array, whisker: number } = where;
  const newest = (route, query) => (has("GET", route) ? list(route, { ...query, limit: MANY }) : []);
  const decisions = { fleet, robot, array, target_whisker: number };
  const within = { from: new Date(window.from).toISOString(), to: new Date(window.to).toISOString() };
  const [trims, alarms, decided, actions] = await Promise.all([
    newest("/v1/trims", { ...where, ...within }),
    newest("/v1/alarms", where),
    newest("/v1/compensations", decisions),
    newest("/v1/audit", { fleet, robot, ...within }),
  ]);
  const events = [
    ...trims.map((one) => trim(one, decided)),
    ...alarms.flatMap(alarm),
    ...setpoints.within.map(setpoint),
    ...actions.filter((one) => isHold(one, where)).map(hold),
    ...temperatures(rows),
  ];
  return events.filter(({ at }) => at >= window.from && at <= window.to).sort((one, other) => one.at - other.at);
}

const toDecision = (id) =>
  id === null || id === undefined ? {} : { href: link.compensation(id), to: "decision" };

function trim(one, decided) {
  const at = Date.parse(one.detected_at);
  const after = decided
    .map((each) => [Date.parse(each.decided_at) - at, each])
    .filter(([wait]) => wait >= 0 && wait < DECISION_WITHIN_MS);
  const [, decision] = after.sort(([wait], [other]) => wait - other)[0] ?? [];
  const words = `trim detected: ${mm(one.length_before_mm, 1)} \u2192 ${mm(one.length_after_mm, 1)}`;
  return { at, kind: "trim", words, ...toDecision(decision?.compensation_id) };
}

function alarm(one) {
  const event = (at, what) => ({
    at: Date.parse(at),
    kind: "alarm",
    words: `alarm ${what}: ${say(ALARM_KINDS, one.kind)}`,
    href: link.alarm(one.alarm_id),
    to: "alarms",
  });
  return [event(one.raised_at, "raised"), ...(one.cleared_at ? [event(one.cleared_at, "cleared")] : [])];
}

function setpoint(one) {
  const words = `setpoint ${mpa(one.pressure_mpa)}: ${say(SETPOINT_REASONS, one.reason)}, ${say(SETPOINT_STATES, one.state)}`;
  return { at: Date.parse(one.issued_at), kind: "setpoint", words, ...toDecision(one.compensation_id) };
}

/** Whether an action that was executed holds or releases the whisker or its whole robot. */
function isHold(one, { array, whisker }) {
  if (one.state !== "DONE" || !["HOLD", "RELEASE", "SETPOINT"].includes(one.kind)) return false;
  return !one.array || (one.array === array && one.whisker === whisker);
}

function hold(one) {
  const words = `${say(AUDIT_KINDS, one.kind)}${one.array ? "" : " (whole robot)"} by ${one.actor ?? "unknown"}${one.reason ? `: \u201c${one.reason}\u201d` : ""}`;
  return { at: Date.parse(one.asked_at), kind: "hold", words, href: link.audit(), to: "audit log" };
}

/** Moments at which the temperature differs by a step from that of the last mark. */
function temperatures(rows) {
  const events = [];
  let last = null;
  for (const { at, temperature } of rows) {
    if (!Number.isFinite(temperature)) continue;
    last ??= temperature;
    if (Math.abs(temperature - last) < TEMPERATURE_STEP_C) continue;
    events.push({
      at,
      kind: "temperature",
      words: `temperature ${last.toFixed(1)} \u2192 ${temperature.toFixed(1)}\u00a0\u00b0C`,
    });
    last = temperature;
  }
  return events;
}

/** Events whose marks would overlap become one mark: `{ at, events }`. `gap` is the width of a mark in ms. */
export function clustered(events, gap) {
  const marks = [];
  for (const event of events) {
    const last = marks.at(-1);
    if (last && event.at - last.at < gap) last.events.push(event);
    else marks.push({ at: event.at, events: [event] });
  }
  return marks;
}
