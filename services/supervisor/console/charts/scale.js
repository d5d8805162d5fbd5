// Axes of charts: the range of the vertical axis, labels in the console's time zone, and the point nearest to the cursor.

import { dateFormat, zone } from "../zone.js";

/** Index of the value nearest to `x` in ascending values; with `isBefore` the last one that is not after it; or -1. */
export function nearest(values, x, isBefore = false) {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= x) low = middle + 1;
    else high = middle;
  }
  if (isBefore || low === 0) return isBefore ? low - 1 : Math.min(0, values.length - 1);
  return low < values.length && values[low] - x < x - values[low - 1] ? low : low - 1;
}

/** Range of the vertical axis for the values in a window. Bounds extend it by at most half the span of the values. */
export function reachOf(data, { atLeast, level }, { from, to }) {
  let [low, high] = atLeast;
  const bounds = [];
  for (const { x, y, low: lows, high: highs } of data) {
    x.forEach((at, index) => {
      if (at < from || at > to || !Number.isFinite(y[index])) return;
      [low, high] = [Math.min(low, y[index]), Math.max(high, y[index])];
      if (Number.isFinite(lows?.[index])) bounds.push([lows[index], highs[index]]);
    });
  }
  if (level) [low, high] = [Math.min(low, level.y), Math.max(high, level.y)];
  const span = Math.max(high - low, 1e-9);
  const [least, most] = [low - span / 2, high + span / 2];
  for (const [lower, upper] of bounds)
    [low, high] = [Math.min(low, Math.max(lower, least)), Math.max(high, Math.min(upper, most))];
  const margin = 0.05 * Math.max(high - low, 1e-9);
  return [low === 0 ? 0 : low - margin, high + margin];
}

const DAY_MS = 86_400_000;

/** Labels of the axis of time. */
export const labels = {
  /** A date whose local parts are those of the console's time zone, from which uPlot places its labels. */
  inZone: (uPlot, at) => uPlot.tzDate(new Date(at), zone()),

  /** Times of day, with the date below the first one of each day; or dates, if they are days apart. */
  times(_, splits, _axis, _space, step) {
    const date = dateFormat({ day: "numeric", month: "short" });
    if (step >= DAY_MS) return splits.map((at) => date.format(at));
    const digits = step >= 1_000 ? {} : { fractionalSecondDigits: step >= 100 ? 1 : 3 };
    const seconds = step < 60_000 ? { second: "2-digit", ...digits } : {};
    const clock = dateFormat({ hour: "2-digit", minute: "2-digit", ...seconds });
    let day = null;
    return splits.map((at) => {
      const own = date.format(at);
      const text = own === day ? clock.format(at) : `${clock.format(at)}\n${own}`;
      day = own;
      return text;
    });
  },
};

/** Labels with as many digits as the step between them needs. */
export function numberLabels(_, splits, _axis, _space, step) {
  let digits = 0;
  while (digits < 6 && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-6) digits += 1;
  return splits.map((value) => value.toFixed(digits));
}
