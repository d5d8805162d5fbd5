// The four charts of a whisker: their texts, and their columns from the loaded data.

import { interval, mm, moment, mpa, percent } from "../format.js";

/** The paper's measured mean error of case 1 and self-compensation, in percent. */
const PAPER_PERCENT = 20.385;

const plain = (digits) => (value) => value.toFixed(digits);
const points100 = (value, low, high) => interval(value / 100, low / 100, high / 100, percent);

/** What the first chart can show: words, unit, digits, and the least range of its axis. */
export const QUANTITIES = {
  agreement: {
    label: "measured / predicted",
    title: "Sensitivity against the model",
    unit: "measured / predicted; 1 agrees with the model",
    atLeast: [0.95, 1.05],
    say: plain(3),
    level: { y: 1, name: "as predicted" },
  },
  perMm: {
    label: "strain per mm",
    title: "Sensitivity",
    unit: "strain per mm of deflection, 1/mm; it depends on the contact ratio",
    atLeast: [0, 0],
    say: (value) => `${value.toFixed(5)}\u00a0/mm`,
    level: null,
  },
};

/** The charts of a whisker with its whole length in mm and its nominal pressure in MPa. */
export function specs({ whole, nominal }, quantity) {
  const time = { isTime: true, cursorWords: moment };
  const { title, unit, atLeast, say, level } = QUANTITIES[quantity];
  return [
    {
      ...time,
      key: "sensitivity",
      title,
      unit,
      atLeast,
      level,
      series: [{ name: "contacts", tone: "a", look: "points", say }],
    },
    {
      ...time,
      key: "length",
      title: "Estimated length",
      unit: "mm, with its 95 % interval",
      atLeast: [whole - 1, whole + 0.5],
      level: { y: whole, name: `whole ${mm(whole, 1)}` },
      series: [{ name: "length", tone: "a", look: "line", say: (value, low, high) => interval(value, low, high, mm) }],
    },
    {
      ...time,
      key: "pressure",
      title: "Pressure",
      unit: "MPa",
      atLeast: [0, nominal],
      level: null,
      series: [
        { name: "set", tone: "b", look: "step", dash: [8, 4], say: (value) => mpa(value) },
        { name: "measured", tone: "a", look: "points", say: (value) => mpa(value) },
      ],
    },
    {
      ...time,
      key: "error",
      title: "Compensation error",
      unit: "% (Eq. 35), with its 95 % interval",
      atLeast: [0, 25],
      level: { y: PAPER_PERCENT, name: "the paper's mean, 20.4\u00a0%" },
      series: [
        { name: "measured", tone: "a", look: "line", say: points100 },
        { name: "with gain", tone: "c", look: "line", dash: [3, 3], say: points100 },
      ],
    },
  ];
}

/** The columns of the charts, in the order of `specs`. */
export function dataOf({ rows, errors, setpoints }, window, nominal, quantity) {
  const known = (name) => rows.filter((row) => Number.isFinite(row[name]));
  const column = (from, name, factor = 1) => from.map((row) => (row[name] === null ? null : row[name] * factor));
  const of = (name) => ({ x: column(known(name), "at"), y: column(known(name), name) });
  const lengths = known("length");
  const gains = errors.filter((row) => Number.isFinite(row.withGain));
  return [
    [of(quantity)],
    [{ ...of("length"), low: column(lengths, "low"), high: column(lengths, "high") }],
    [setpointSteps(setpoints, rows, window, nominal), of("pressure")],
    [
      {
        x: column(errors, "at"),
        of: errors.map((row) => row.compensation),
        y: column(errors, "error", 100),
        low: column(errors, "low", 100),
        high: column(errors, "high", 100),
      },
      { x: column(gains, "at"), of: gains.map((row) => row.compensation), y: column(gains, "withGain", 100) },
    ],
  ];
}

/** Setpoints hold until the next one; before the first one the nominal pressure is set. */
function setpointSteps({ before, within }, rows, { from, to }, nominal) {
  // Without data, a whisker may not have existed yet.
  if (!rows.length && !within.length) return { x: [], y: [] };
  const begin = before ? from : Math.max(from, Math.min(rows[0]?.at ?? to, Date.parse(within[0]?.issued_at ?? to)));
  const end = Math.max(begin, Math.min(to, Date.now()));
  const steps = [
    [begin, before?.pressure_mpa ?? nominal],
    ...within.map((one) => [Date.parse(one.issued_at), one.pressure_mpa]),
  ];
  steps.push([end, steps.at(-1)[1]]);
  const ordered = steps.filter(([at]) => at >= from && at <= to);
  return { x: ordered.map(([at]) => at), y: ordered.map(([, pressure]) => pressure) };
}
