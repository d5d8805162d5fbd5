// Events of a whisker that charts mark: trims, setpoints, alarms, holds, changes of temperature.

import { has, list } from "../api.js";
import { mm, mpa } from "../format.js";
import { link } from "../places.js";
import { AUDIT_KINDS, ALARM_KINDS, SETPOINT_REASONS, SETPOINT_STATES, say } from "../words.js";
import { named } from "./data.js";

/** Number of newest events of a kind before the end of the window that are considered. */
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

/**
 * The events in a window in order of time: `{ at, kind, words, href, to }`; `to` are the words of the link. `cut` has the kinds of
 * which there are more.
 */
export async function eventsOf(whisker, window, { rows, setpoints }) {
  const where = named(whisker);
  const { fleet, robot, array, whisker: number } = where;
  const cut = new Set(setpoints.areAll ? [] : ["setpoint"]);
  const newest = async (kind, route, query) => {
    const rows = has("GET", route) ? await list(route, { ...query, limit: MANY + 1 }) : [];
    // The oldest of them may lie before the window, and then all of the window are known.
    if (rows.length > MANY && Date.parse(rows[MANY].raised_at ?? query.from) >= window.from) cut.add(kind);
    return rows.slice(0, MANY);
  };
  const decisions = { fleet, robot, array, target_whisker: number };
  const [from, to] = [window.from, window.to].map((at) => new Date(at).toISOString());
  const until = new Date(window.to + DECISION_WITHIN_MS).toISOString();
  const [trims, alarms, decided, actions] = await Promise.all([
    newest("trim", "/v1/trims", { ...where, from, to }),
    newest("alarm", "/v1/alarms", { ...where, to }),
    newest("trim", "/v1/compensations", { ...decisions, from, to: until }),
    newest("hold", "/v1/audit", { fleet, robot, from, to }),
  ]);
  const events = [
    ...trims.map((one) => trim(one, decided)),
    ...alarms.flatMap(alarm),
    ...setpoints.within.map(setpoint),
    ...actions.filter((one) => isHold(one, where)).map(hold),
    ...temperatures(rows),
  ];
  const inside = events.filter(({ at }) => at >= window.from && at <= window.to);
  return { events: inside.sort((one, other) => one.at - other.at), cut };
}

/** Which kinds of events have marks for the newest ones only, in words; null if all have marks. */
export function leftOut(cut) {
  const kinds = [...cut].map((kind) => KINDS[kind][0]).join(", ");
  return kinds ? `Only the newest have marks: ${kinds}. A shorter range shows others.` : null;
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
