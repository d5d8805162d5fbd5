// Values formatted for people: numbers with units and sensible digits, relative and absolute times.

import { h } from "./dom.js";
import { dateFormat, zoneName } from "./zone.js";

/** Between a number and its unit. */
const GAP = "\u00a0";
const NONE = "\u2013";

function number(value, digits, unit) {
  return Number.isFinite(value) ? `${value.toFixed(digits)}${GAP}${unit}` : NONE;
}

/** 64.88 mm */
export const mm = (value, digits = 2) => number(value, digits, "mm");
/** 0.0472 MPa */
export const mpa = (value, digits = 4) => number(value, digits, "MPa");
/** 16.0 %, from a ratio. */
export const percent = (ratio, digits = 1) => number(Number.isFinite(ratio) ? ratio * 100 : NaN, digits, "%");

/** A value with its 95 % interval: "64.88 mm (64.31 to 65.45)". */
export function interval(value, low, high, unit = mm) {
  if (!Number.isFinite(value)) return NONE;
  if (!Number.isFinite(low) || !Number.isFinite(high)) return unit(value);
  const bare = (bound) => unit(bound).split(GAP)[0];
  // The line breaks before the interval only.
  return `${unit(value)} (${bare(low)}${GAP}to${GAP}${bare(high)})`;
}

/** "1 whisker", "3 whiskers", "no whiskers". */
export function count(many, one, more = `${one}s`) {
  if (many === 0) return `no ${more}`;
  return many === 1 ? `1 ${one}` : `${many.toLocaleString("en")} ${more}`;
}

const UNITS = [
  ["day", 86_400],
  ["hour", 3_600],
  ["minute", 60],
];
const relative = new Intl.RelativeTimeFormat("en", { numeric: "always" });

/** "5 minutes ago", "in 2 hours". */
export function ago(at, now = Date.now()) {
  const seconds = Math.round((new Date(at).getTime() - now) / 1000);
  if (Math.abs(seconds) < 5) return "just now";
  const unit = UNITS.find(([, size]) => Math.abs(seconds) >= size);
  return unit ? relative.format(Math.trunc(seconds / unit[1]), unit[0]) : relative.format(seconds, "second");
}

const AGES = [
  ["d", 86_400],
  ["h", 3_600],
  ["min", 60],
  ["s", 1],
];

const DAY = { dateStyle: "medium" };
const CLOCK = { timeStyle: "medium" };
const YEAR = { year: "numeric" };
const SHORT = { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" };

/** A moment in the console's time zone: "10:15:03 CET", with the date unless it is today. */
export function moment(at) {
  const when = new Date(at);
  const isToday = dateFormat(DAY).format(when) === dateFormat(DAY).format(Date.now());
  const clock = dateFormat(isToday ? CLOCK : { ...DAY, ...CLOCK }).format(when);
  return `${clock} ${zoneName(when)}`;
}

/** A time, short: the clock of today, or the day with hour and minute. The tooltip has all of it, with age and zone. */
export function time(at) {
  if (!at) return NONE;
  const when = new Date(at);
  const isToday = dateFormat(DAY).format(when) === dateFormat(DAY).format(Date.now());
  const isThisYear = dateFormat(YEAR).format(when) === dateFormat(YEAR).format(Date.now());
  return stamped(at, dateFormat(isToday ? CLOCK : isThisYear ? SHORT : { ...SHORT, ...YEAR }).format(when));
}

/** The age of a time, short: "5 min". The tooltip has the time. */
export function age(at, now = Date.now()) {
  if (!at) return NONE;
  const seconds = Math.max(0, Math.round((now - new Date(at).getTime()) / 1000));
  const [many, unit] = AGES.map(([word, size]) => [Math.trunc(seconds / size), word]).find(([many]) => many > 0) ?? [0, "s"];
  return stamped(at, `${many}${GAP}${unit}`);
}

const stamped = (at, words) =>
  h("time", { datetime: at, title: `${moment(at)}, ${ago(at)}; ${at} (UTC)` }, words.replaceAll(" ", GAP));

/** A value, or a dash for a missing one. */
export const orNone = (value) => value ?? NONE;
