// The range of time that charts show. It is part of the page's address: `?range=24h`, or `?from=...&to=...`.

const MINUTE_MS = 60_000;
const HOUR_MS = 60 * MINUTE_MS;
const DAY_MS = 24 * HOUR_MS;

/** Ranges that end now: name in the address, words, and length. */
export const RANGES = [
  ["1h", "1 hour", HOUR_MS],
  ["24h", "24 hours", DAY_MS],
  ["7d", "7 days", 7 * DAY_MS],
  ["30d", "30 days", 30 * DAY_MS],
];
/** Limits of a chosen range: hours are read in at most five pages of 1000. */
const SPAN_MS = { least: 1_000, most: 200 * DAY_MS };

const queryOf = (hash) => new URLSearchParams(hash.split("?")[1] ?? "");

/** The range in an address: `{ name }`, `{ from, to }` in ms since 1970, or null. */
export function rangeOf(hash) {
  const query = queryOf(hash);
  const name = query.get("range");
  if (RANGES.some(([known]) => known === name)) return { name };
  const [from, to] = ["from", "to"].map((end) => Date.parse(query.get(end)));
  return from < to ? limited({ from, to }) : null;
}

/** A range that is neither too short nor too long, around the same middle. */
export function limited({ from, to }) {
  const span = Math.min(Math.max(to - from, SPAN_MS.least), SPAN_MS.most);
  const middle = (from + to) / 2;
  return { from: Math.round(middle - span / 2), to: Math.round(middle + span / 2) };
}

/** Writes a range into the address, as a step of the browser's history; null removes it. */
export function showRange(range) {
  const [page] = location.hash.split("?");
  const query = queryOf(location.hash);
  ["range", "from", "to"].forEach((name) => query.delete(name));
  if (range?.name) query.set("range", range.name);
  else if (range) for (const end of ["from", "to"]) query.set(end, new Date(range[end]).toISOString());
  const told = query.toString();
  history.pushState(null, "", told ? `${page}?${told}` : page);
}

/**
 * Begin and end of a range at present. A range that ends now includes the newest contact, also if the robot's clock is
 * ahead. Without a range: the shortest one that contains the newest contact, and the newest event if it is at most a day older.
 */
export function windowOf(range, newest, now = Date.now(), event = null) {
  if (range?.from !== undefined) return range;
  const isNear = event !== null && newest !== null && newest - event < DAY_MS;
  const needed = isNear ? Math.min(newest, event) : newest;
  const fitting = ([name, , ms]) => (range ? name === range.name : now - needed < ms);
  const [, , span] = RANGES.find(fitting) ?? RANGES.at(newest === null ? 0 : -1);
  const to = Math.max(now, newest === null ? 0 : newest + 1);
  return { from: to - span, to };
}

/** Shortest window around data, and shortest time before an event, ms. */
const LEAST_MS = 60_000;
const BEFORE_MS = 30_000;

/**
 * The part of a window that has data: with the newest event in its first third if there is one, and else all of it. The margins
 * keep the first and the last point off the frame.
 */
export function fitted(window, rows, event) {
  const inside = rows.filter(({ at }) => at >= window.from && at <= window.to);
  if (!inside.length) return window;
  const [first, last] = [inside[0].at, inside.at(-1).at];
  const isInside = event !== null && event > first && event <= last;
  const begin = isInside ? Math.max(first, event - Math.max(BEFORE_MS, (last - event) / 2)) : first;
  const span = Math.max(last - begin, LEAST_MS);
  return { from: Math.round(last - 1.03 * span), to: Math.round(last + 0.02 * span) };
}

/** Resolution of the data in a window: `contacts` (single ones, or means of equal intervals), `minute` or `hour`. */
export function resolutionOf({ from, to }) {
  if (to - from <= 3 * HOUR_MS) return "contacts";
  return to - from <= 2 * DAY_MS ? "minute" : "hour";
}

/** Length of the resolution's steps. */
export const STEP_MS = { minute: MINUTE_MS, hour: HOUR_MS };

/** Quantity of the sensitivity in the address: the first of the known ones unless it names another. */
export function shownQuantity(known) {
  const told = queryOf(location.hash).get("sensitivity");
  return known.includes(told) ? told : known[0];
}

/** Writes the quantity of the sensitivity into the address. */
export function showQuantity(quantity) {
  const [page] = location.hash.split("?");
  const query = queryOf(location.hash);
  query.set("sensitivity", quantity);
  history.replaceState(null, "", `${page}?${query}`);
}
