// Gaps of a line: where nothing was measured for long, and where a series begins anew.

/**
 * A series `{ x, y, low, high, of }` with an empty point in each gap: between points that are further apart than `widest`, and
 * between points of different subjects `of`, if the series has them.
 */
export function broken(series, widest) {
  const { x, y, low, high, of } = series;
  const isGap = (place) => place > 0 && (x[place] - x[place - 1] > widest || (of && of[place] !== of[place - 1]));
  if (!x.some((_, place) => isGap(place))) return series;
  const spread = (values, empty) =>
    values?.flatMap((value, place) => (isGap(place) ? [empty(place), value] : [value]));
  const none = () => null;
  return {
    x: spread(x, (place) => (x[place - 1] + x[place]) / 2),
    y: spread(y, none),
    low: spread(low, none),
    high: spread(high, none),
  };
}

/** Places of a column's values between two gaps: no line leads to them. Places of other series are undefined. */
export function isAlone(column) {
  const known = [];
  column.forEach((value, place) => value !== undefined && known.push([value, place]));
  const isEmpty = (one) => one === undefined || one[0] === null;
  return known
    .filter((one, at) => !isEmpty(one) && isEmpty(known[at - 1]) && isEmpty(known[at + 1]))
    .map(([, place]) => place);
}
