// Data of a whisker's charts in a window of time.

import { get, has, list } from "../api.js";
import { api, ROUTES } from "../places.js";
import { resolutionOf, STEP_MS } from "./range.js";

/** Maximum number of points from the route of contacts: more cannot be told apart on a screen. */
const POINTS = 1_000;
/** Number of points since the last complete minute or hour. */
const TAIL_POINTS = 60;
/** Number of intervals into which errors are grouped. */
const ERRORS = 500;

const iso = (at) => new Date(at).toISOString();
const between = ({ from, to }) => ({ from: iso(from), to: iso(to) });

/**
 * Rows in order of time: `{ at, contacts, agreement, perMm, length, low, high, pressure, temperature }`, and the
 * resolution. Where single contacts or minutes are not stored any more, the next coarser resolution replaces them.
 */
export async function rowsOf(whisker, window) {
  const wanted = resolutionOf(window);
  if (wanted === "contacts") {
    const rows = await contactsOf(whisker, window, POINTS);
    if (rows.length) return { rows, resolution: rows.some((row) => row.contacts > 1) ? "means" : "contacts" };
  }
  if (!has("GET", `${ROUTES.whisker}/history`))
    return { rows: await contactsOf(whisker, window, POINTS), resolution: "means" };
  const finest = wanted === "hour" ? "hour" : "minute";
  const rows = await aggregates(whisker, window, finest);
  if (finest === "minute") {
    const end = rows[0]?.from ?? window.to;
    if (end - window.from > STEP_MS.hour) {
      const hours = await aggregates(whisker, { from: window.from, to: end }, "hour");
      // The minutes tell the contacts of the hour in which they begin.
      rows.unshift(...hours.filter(({ until }) => !rows.length || until <= end));
    }
  }
  const since = rows.at(-1)?.until ?? window.from;
  if (since < window.to) rows.push(...(await contactsOf(whisker, { from: since, to: window.to }, TAIL_POINTS)));
  return { rows, resolution: finest };
}

/** Time of the newest contact by the robot's clock; null without contacts. */
export async function newestOf(whisker) {
  const { items } = await get(`${api.whisker(whisker)}/contacts`, { points: 1 });
  return items.length ? Date.parse(items[0].at) : null;
}

async function contactsOf(whisker, window, points) {
  const { items, bucket_s: bucket } = await get(`${api.whisker(whisker)}/contacts`, { ...between(window), points });
  const middle = (bucket ?? 0) * 500;
  return items.map((one) => ({
    at: Date.parse(one.at) + middle,
    contacts: one.contacts,
    agreement: one.residual === null ? null : Math.exp(one.residual),
    perMm: one.sensitivity_per_mm,
    length: one.length_mm,
    ...bounds(one.length_mm, one.length_sd_mm),
    pressure: one.pressure_mpa,
    temperature: one.temperature_c ?? null,
  }));
}

async function aggregates(whisker, window, resolution) {
  const step = STEP_MS[resolution];
  // Also the minute or hour in which the window begins.
  const query = { ...between({ from: Math.floor(window.from / step) * step, to: window.to }), resolution };
  const items = await list(`${api.whisker(whisker)}/history`, query);
  return items.reverse().map((one) => {
    const from = Date.parse(one.start_at);
    return {
      from,
      until: from + step,
      at: from + step / 2,
      contacts: one.contacts_used + one.contacts_learning + one.contacts_unused,
      agreement: one.residual_mean === null ? null : Math.exp(one.residual_mean),
      perMm: one.sensitivity_per_mm,
      length: one.length_mm,
      ...bounds(one.length_mm, one.length_sd_mm),
      pressure: one.pressure_mpa,
      temperature: one.temperature_c,
    };
  });
}

function bounds(length, sd) {
  const half = 1.959964 * sd;
  return length === null ? { low: null, high: null } : { low: length - half, high: length + half };
}

/** Most rows of single errors or setpoints. */
const SINGLE = 1_000;

/**
 * Measured errors of compensations for the whisker, as ratios in order of time:
 * `{ at, compensation, error, low, high, withGain, air }`. Means have no compensation.
 */
export async function errorsOf(whisker, window) {
  const where = { ...named(whisker), ...between(window) };
  const told = (at) => (one) => ({
    at: Date.parse(one[at]),
    compensation: one.compensation_id,
    error: one.error,
    low: one.error_low,
    high: one.error_high,
    withGain: one.error_with_gain,
    air: one.air_error,
  });
  if (resolutionOf(window) === "contacts" || !has("GET", "/v1/errors/by-time")) {
    const items = await list("/v1/errors", { ...where, limit: SINGLE });
    return items.reverse().map(told("recorded_at"));
  }
  const bucket = Math.max(60, Math.ceil((window.to - window.from) / ERRORS / 60_000) * 60);
  const { items } = await get("/v1/errors/by-time", { ...where, bucket_s: bucket });
  return items.map(told("at"));
}

/** Setpoints in the window in order of time, before them the one that was in force at its begin, and whether they are all. */
export async function setpointsOf(whisker, window) {
  const [within, before] = await Promise.all([
    list("/v1/setpoints", { ...named(whisker), ...between(window), limit: SINGLE }),
    list("/v1/setpoints", { ...named(whisker), to: iso(window.from), limit: 1 }),
  ]);
  return { within: within.reverse(), before: before[0] ?? null, areAll: within.length < SINGLE };
}

/** Filters that select a whisker in a list. */
export const named = ({ fleet, robot, array, whisker }) => ({ fleet, robot, array, whisker });
