// A decision in words: what changes for the robot, how sure the prediction is, and the picture of its interval.

import { h, s } from "../dom.js";
import { interval, mpa, percent } from "../format.js";
import { names, link } from "../places.js";

/** Pressures that differ by less are the same, MPa: they are shown with four digits. */
const SAME_MPA = 0.00005;
/** Width of an interval from which on a prediction says little, as a ratio. */
const VAGUE = 0.5;
/** Error at the right end of a picture, as a ratio: beyond it an arrow stands. */
const END = 1.2;
const WIDTH = 240;
const HEIGHT = 30;

/** The pressure that a decision has led to, or would lead to. */
const after = (decision) => decision.held_pressure_mpa ?? decision.pressure_mpa;

/** Sentences about what changes for the robot; empty without a compensator. */
export function effectOf(decision) {
  const { array, compensator_whisker: compensator, target_whisker: target, pressure_before_mpa: before } = decision;
  if (compensator === null) return [];
  const own = compensator === target;
  const isSame = Math.abs(after(decision) - before) < SAME_MPA;
  const chosen = decision.candidates?.find((one) => one.chosen);
  const pressure = isSame
    ? `The pressure of ${array} ${compensator} stays ${mpa(before)}: only the gain on its readings changes.`
    : `The chamber of ${array} ${compensator} goes from ${before.toFixed(4)} to ${mpa(after(decision))}.`;
  const role = own
    ? `${array} ${target} feels at its own place again, as before the cut.`
    : `${array} ${compensator} feels for ${array} ${target}${chosen?.gives_up_own_role ? ", and its own place is lost" : ", and keeps its own place"}.`;
  return [pressure, `${role[0].toUpperCase()}${role.slice(1)}`];
}

/** How good the prediction is, in words. */
export function certaintyOf(decision) {
  const { predicted_error: error, predicted_error_low: low, predicted_error_high: high } = decision;
  if (!Number.isFinite(error)) return null;
  const words = `Predicted reading error ${interval(error, low, high, percent)}; 100 % if nothing is done.`;
  if (high >= 1)
    return {
      tone: "bad",
      words: `${words} It may be no better than doing nothing: measure by a touch test, or refuse.`,
    };
  if (high - low > VAGUE) return { tone: "warn", words: `${words} The prediction is vague.` };
  return { tone: "good", words };
}

/** Words of the picture for people who do not see it. */
function spoken(rows) {
  return rows.map(({ name, value, low, high }) => `${name} ${interval(value, low, high, percent)}`).join("; ");
}

/**
 * Errors with their 95 % intervals on one scale from 0 to 120 %: `rows` are `{ name, tone, value, low, high }`, `limit`
 * the
 * error that the policy allows. The line at 100 % is that of doing nothing.
 */
export function errorPicture(rows, { limit = null } = {}) {
  const known = rows.filter(({ value }) => Number.isFinite(value));
  if (!known.length) return null;
  const x = (error) => 6 + (Math.min(Math.max(error, 0), END) / END) * (WIDTH - 12);
  const line = (at, style) => s("line", { x1: x(at), x2: x(at), y1: 2, y2: HEIGHT - 13, class: style });
  const one = ({ tone, value, low, high }) => [
    Number.isFinite(low)
      ? s("line", { x1: x(low), x2: Math.max(x(high), x(low) + 1), y1: 9, y2: 9, class: `reach ${tone}` })
      : null,
    high > END ? s("path", { d: `M${x(END) - 5} 4l5 5l-5 5`, class: `more ${tone}` }) : null,
    s("circle", { cx: x(value), cy: 9, r: 4, class: `value ${tone}` }),
  ];
  const label = (at, words) => s("text", { x: x(at), y: HEIGHT - 2 }, words);
  return s(
    "svg",
    {
      viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
      width: WIDTH,
      height: HEIGHT,
      class: "errors",
      role: "img",
      "aria-label": spoken(known),
    },
    s("line", { x1: x(0), x2: x(END), y1: 9, y2: 9, class: "scale" }),
    line(0, "tick"),
    line(0.5, "tick"),
    line(1, "nothing-done"),
    limit === null ? null : line(limit, "limit"),
    known.map(one),
    [
      [0, "0"],
      [0.5, "50"],
      [1, "100\u00a0%"],
    ].map(([at, words]) => label(at, words)),
  );
}

/** Predicted and measured error of a decision as one picture. */
export function decisionPicture(decision) {
  const of = (name, words, tone) => ({
    name: words,
    tone,
    value: decision[name],
    low: decision[`${name}_low`],
    high: decision[`${name}_high`],
  });
  return errorPicture([of("predicted_error", "predicted", "b"), of("measured_error", "measured", "a")]);
}

/** What changes for the robot, with the picture of the prediction; null without a compensator. */
export function effect(decision) {
  const sentences = effectOf(decision);
  if (!sentences.length) return null;
  const certainty = certaintyOf(decision);
  return h(
    "div",
    { class: "effect" },
    h(
      "ul",
      { class: "what-changes" },
      sentences.map((words) => h("li", {}, words)),
    ),
    h(
      "div",
      { class: "outlook" },
      decisionPicture(decision),
      certainty ? h("p", { class: `certainty ${certainty.tone}` }, certainty.words) : null,
    ),
  );
}

/** A link to the target of a decision. */
export const targetLink = (decision) =>
  h(
    "a",
    { href: link.whisker(names(decision, decision.target_whisker)) },
    `${decision.array} ${decision.target_whisker}`,
  );
