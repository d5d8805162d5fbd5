// Small charts without axes: a row of bars.

import { h, s } from "../dom.js";

const STEP = 5;
const HIGH = 20;

/** Numbers as small bars from the oldest to the newest; `label` says what they are. */
export function spark(values, label) {
  const most = Math.max(1, ...values);
  const bar = (value, index) => {
    const size = value ? Math.max(2, (HIGH * value) / most) : 1;
    return s("rect", { x: index * STEP, y: HIGH - size, width: STEP - 1, height: size, class: value ? "bar" : "none" });
  };
  return s(
    "svg",
    { viewBox: `0 0 ${values.length * STEP} ${HIGH}`, class: "spark", role: "img", "aria-label": label },
    values.map(bar),
  );
}

const percents = (ratio) => Math.round(ratio * 100);

/** Words for a bin of errors: "5 to 10 %". */
const range = ({ error_from: from, error_to: to }) =>
  to === null ? `${percents(from)}\u00a0% or more` : `${percents(from)} to ${percents(to)}\u00a0%`;

const WIDTH = 330;
const HEIGHT = 96;
const FOOT = 18;
const HEAD = 14;

/** The distribution of errors. Its numbers are above the bars, and a text says the same. */
export function distribution(bins) {
  const total = bins.reduce((sum, one) => sum + one.compensations, 0);
  if (!total) return h("p", { class: "empty" }, "No compensation in force has been measured yet.");
  const most = Math.max(...bins.map((one) => one.compensations));
  const step = WIDTH / bins.length;
  const high = HEIGHT - HEAD - FOOT;
  const bar = (bin, index) => {
    const size = (high * bin.compensations) / most;
    return s(
      "g",
      {},
      s("title", {}, `${range(bin)}: ${bin.compensations}`),
      s("rect", { x: index * step + 1, y: HEAD + high - size, width: step - 2, height: size, class: "bar" }),
      bin.compensations
        ? s("text", { x: (index + 0.5) * step, y: HEAD + high - size - 3, class: "many" }, bin.compensations)
        : null,
    );
  };
  const tick = (bin, index) => s("text", { x: Math.max(4, index * step), y: HEIGHT - 5 }, percents(bin.error_from));
  const said = bins.filter((one) => one.compensations).map((one) => `${range(one)}: ${one.compensations}`);
  return h(
    "div",
    { class: "histogram" },
    s(
      "svg",
      { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `Compensations by error. ${said.join("; ")}` },
      s("line", { x1: 0, x2: WIDTH, y1: HEIGHT - FOOT, y2: HEIGHT - FOOT, class: "ground" }),
      bins.map(bar),
      bins.map(tick),
    ),
    h(
      "p",
      { class: "hint" },
      `Newest error of ${total.toLocaleString("en")} in force, in % (Eq. 35). The last bar has no upper bound.`,
    ),
  );
}
