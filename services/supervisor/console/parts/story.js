// The story of a whisker in one sentence, from recorded facts alone.

import { count, interval, mm, moment, mpa, percent } from "../format.js";
import { END_REASONS, FAULTS, REFUSALS, say, SETPOINT_ERRORS, SETPOINT_STATES } from "../words.js";

/** Width of the 95 % interval of a length from which on the length is in doubt, mm. */
const DOUBT_MM = 4;
/** Pressures that differ by less are the same, MPa: they are shown with four digits. */
const SAME_MPA = 0.00005;
/** States of setpoints that were not applied. */
const NOT_SET = ["REJECTED", "FAILED", "EXPIRED"];

const capital = (text) => `${text[0].toUpperCase()}${text.slice(1)}`;
const perHour = (value) => percent(value * 3600, 1);

/**
 * The sentence about a whisker: `{ tone, text }`. `whisker` is its row, `trim` its newest trim, `decision` its newest
 * decision
 * with candidates, `alarms` its standing alarms, all as in the API; those that there are not are null or empty.
 */
export function storyOf({ whisker, trim = null, decision = null, alarms = [] }) {
  const { tone, text } = conditionOf(whisker, trim, decision);
  const before = [vented(whisker, alarms), fault(whisker)].filter(Boolean);
  const after = whisker.held ? ["an operator holds it: nothing changes by itself"] : [];
  const sentence = [...before, text, ...after].map((part) => `${capital(part)}.`).join(" ");
  return { tone: before.length ? "bad" : tone, text: sentence };
}

function vented(whisker, alarms) {
  if (!alarms.some((one) => one.kind === "VENTED")) return null;
  return `vented by its robot and not filled again: the chamber has ${mpa(whisker.pressure_mpa ?? 0)} instead of ${mpa(whisker.nominal_pressure_mpa)}`;
}

function fault(whisker) {
  if (!whisker.fault) return null;
  if (whisker.fault !== "LEAK") return `${say(FAULTS, whisker.fault)}: its readings do not count`;
  const known = Number.isFinite(whisker.leak_per_s);
  const rate = known ? interval(whisker.leak_per_s, whisker.leak_low_per_s, whisker.leak_high_per_s, perHour) : null;
  return `leaking${rate ? `: it loses ${rate} of its pressure in an hour` : ""}`;
}

function conditionOf(whisker, trim, decision) {
  const length = `${mm(whisker.length_mm, 1)} of ${mm(whisker.whole_length_mm, 1)}`;
  const contacts = count(whisker.contacts, "contact");
  const doubt = inDoubt(whisker);
  const known = doubt ? `its length is in doubt: ${doubt}` : `its length is ${length}`;
  const isReplaced = decision?.end_reason === "REPLACED" && (!trim || trim.detected_at <= decision.ended_at);
  switch (whisker.condition) {
    case "LEARNING":
      return {
        tone: "info",
        text: isReplaced
          ? `replaced at ${moment(decision.ended_at)}: the new whisker is being learned, ${contacts} so far`
          : `being learned: ${contacts} so far, a cut is not detected yet`,
      };
    case "HEALTHY":
      return {
        tone: doubt ? "warn" : "good",
        text: isReplaced
          ? `replaced at ${moment(decision.ended_at)} and healthy since: ${known} after ${contacts}`
          : `healthy: ${known} after ${contacts}${trim ? "" : ", and no cut was found"}`,
      };
    case "SUSPECTED":
      return {
        tone: "warn",
        text: `perhaps cut: ${known}; ${doubt ? "readings do not tell a cut from another gain or a turn of the contacts, so measure it by a touch test, or let contacts state angle_deg" : "more contacts or a touch test decide"}`,
      };
    case "ERODING":
      return { tone: "warn", text: `wearing off: ${known}${left(whisker)}` };
    case "SENSITIVITY_LOSS":
      return { tone: "warn", text: `less sensitive than a cut explains: ${known}` };
    case "TRIMMED":
      return cut(whisker, trim, decision, doubt);
    default:
      return { tone: "info", text: `${whisker.condition.toLowerCase().replaceAll("_", " ")}: ${known}` };
  }
}

function inDoubt({ length_low_mm: low, length_high_mm: high }) {
  return high - low > DOUBT_MM ? `between ${mm(low, 1)} and ${mm(high, 1)}` : null;
}

function left({ contacts_left: contacts }) {
  return Number.isFinite(contacts) ? `, too short in about ${count(Math.round(contacts), "contact")}` : "";
}

function cut(whisker, trim, decision, doubt) {
  const lost = trim ? trim.length_before_mm - trim.length_after_mm : whisker.whole_length_mm - whisker.length_mm;
  const all = whisker.whole_length_mm - whisker.length_mm;
  const found = trim ? ` at ${moment(trim.detected_at)}, found after ${count(trim.contacts_to_detect, "contact")}` : "";
  const inAll = trim && all - lost > 1 ? ` (${mm(all, 1)} shorter in all)` : "";
  const head = `cut ${mm(lost, 1)}${found}${inAll}${doubt ? `, its length in doubt ${doubt}` : ""}`;
  const { tone, text } = remedy(whisker, decision);
  return { tone, text: `${head}; ${text}` };
}

function remedy(whisker, decision) {
  if (!decision) return { tone: "bad", text: whisker.held ? "not decided, because it is held" : "not decided yet" };
  if (decision.compensator_whisker === null) return { tone: "bad", text: `not compensated: ${whyNobody(decision)}` };
  const how = change(decision);
  if (decision.approval === "PROPOSED" && !decision.ended_at)
    return {
      tone: "warn",
      text: `waiting for approval: ${how}, predicted reading error ${errorOf(decision, "predicted_error")}`,
    };
  if (decision.approval === "REFUSED") return { tone: "bad", text: `not compensated: an operator refused ${how}` };
  if (decision.ended_at)
    return {
      tone: "bad",
      text: `not compensated any more: ${say(END_REASONS, decision.end_reason)} at ${moment(decision.ended_at)}`,
    };
  if (decision.setpoint_error === "IN_TASK")
    return { tone: "warn", text: `${say(SETPOINT_ERRORS, decision.setpoint_error)}: ${how}` };
  if (NOT_SET.includes(decision.setpoint_state))
    return { tone: "bad", text: `pressure not set, ${say(SETPOINT_STATES, decision.setpoint_state)}: ${how}` };
  return result(decision, how);
}

function result(decision, how) {
  const [name, contacts] = measured(decision);
  if (name === null)
    return {
      tone: "info",
      text: `${how}, reading error not measured yet, predicted ${errorOf(decision, "predicted_error")}`,
    };
  // By definition (Eq. 35) the error is 100 % if nothing is done.
  const error = decision[name];
  const tone = error < 0.5 ? "good" : "warn";
  const many = contacts ? `, measured over ${count(contacts, "contact")}` : "";
  return { tone, text: `${how}, reading error 100 to ${percent(error)}${many}` };
}

/** The error that readers of the robot get: with the gain, where the robot applies one. */
export function measured(decision) {
  const name = Number.isFinite(decision.measured_error) ? "measured_error" : null;
  return [name, decision.measured_contacts ?? null];
}

function errorOf(decision, name) {
  return interval(decision[name], decision[`${name}_low`], decision[`${name}_high`], percent);
}

/** Who serves, and what changes: "own pressure 0.1000 to 0.0064 MPa". */
export function change(decision) {
  const own = decision.compensator_whisker === decision.target_whisker;
  const who = own ? null : `${decision.array} ${decision.compensator_whisker} serves for it`;
  const before = decision.pressure_before_mpa;
  const after = decision.held_pressure_mpa ?? decision.pressure_mpa;
  if (Math.abs(after - before) < SAME_MPA)
    return [who, `the gain on the readings alone, ${own ? "own" : "its"} pressure stays ${mpa(before)}`]
      .filter(Boolean)
      .join(" by ");
  const pressure = `pressure ${before.toFixed(4)} to ${mpa(after)}`;
  return own ? `own ${pressure}` : `${who}, its ${pressure}`;
}

/** Why no candidate can serve: the most frequent reason first. */
export function whyNobody(decision) {
  const refused = decision.candidates?.filter((one) => one.refused) ?? [];
  if (!refused.length) return "there is no candidate";
  const reasons = [...Map.groupBy(refused, (one) => one.refused)].sort(
    ([, one], [, other]) => other.length - one.length,
  );
  return reasons
    .map(
      ([reason, rows]) =>
        `${rows.map((row) => `${decision.array} ${row.whisker}`).join(", ")}: ${say(REFUSALS, reason)}`,
    )
    .join("; ");
}

/** Why setpoints were not applied: "3 attempts expired". */
export function whyNotSet({
  failed_attempts: attempts,
  failed_state: state,
  failed_error: error,
  failed_pressure_mpa: pressure,
}) {
  if (!attempts) return null;
  const why = error ? `: ${say(SETPOINT_ERRORS, error)}` : "";
  return `${mpa(pressure)} not set: ${count(attempts, "attempt")} ${say(SETPOINT_STATES, state)}${why}`;
}
