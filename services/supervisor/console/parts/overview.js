// A fleet at a glance: arrays of the robots that need attention first, changes of the last 24 hours, and the distribution
// of measured errors.

import { has } from "../api.js";
import { h, s } from "../dom.js";
import { count } from "../format.js";
import { isUncompensated, mark, shapeOf } from "../marks.js";
import { link } from "../places.js";
import { section } from "../table.js";
import { CONDITIONS, CONNECTIONS, FAULTS, say } from "../words.js";

export const OVERVIEW = "/v1/overview";

/** The sections of an overview; `fleet` if it concerns one fleet. */
export function overview(told, fleet) {
  if (!told) return null;
  return h(
    "div",
    { class: "overview" },
    section("Last 24 hours", changes(told, fleet)),
    section("Measured errors", errors(told.errors)),
    told.robots.length ? section("Arrays", arrays(told.robots, fleet)) : null,
  );
}

function changes(told, fleet) {
  const since = { since: "24h", fleet };
  const rows = [
    [told.trims, "trim", "found", link.trims(since), "stump"],
    [told.alarms, "alarm", "raised", link.alarms(since), "bell"],
    [told.setpoints_applied, "setpoint", "applied", link.setpoints({ ...since, state: "APPLIED" }), "dial"],
    [told.whiskers_replaced, "whisker", "replaced", link.audit({ ...since, kind: "REPLACED", state: "DONE" }), "tick"],
  ];
  const row = ([many, one, done, href, shape]) =>
    h(
      "li",
      { "data-key": one },
      h(
        "a",
        { href },
        shapeOf(shape),
        h("strong", {}, many.toLocaleString("en")),
        h("span", {}, ` ${many === 1 ? one : `${one}s`} ${done}`),
      ),
    );
  return h("ul", { class: "changes" }, rows.map(row));
}

const percents = (ratio) => Math.round(ratio * 100);

/** Words for a bin: "5 to 10 %". */
const range = ({ error_from: from, error_to: to }) =>
  to === null ? `${percents(from)}\u00a0% or more` : `${percents(from)} to ${percents(to)}\u00a0%`;

const WIDTH = 440;
const HEIGHT = 150;
const FOOT = 34;
const HEAD = 16;

/** A histogram. Its numbers are above the bars, and a text says the same. */
function errors(bins) {
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
      s("title", {}, `${range(bin)}: ${count(bin.compensations, "compensation")}`),
      s("rect", { x: index * step + 2, y: HEAD + high - size, width: step - 4, height: size, class: "bar" }),
      bin.compensations
        ? s("text", { x: (index + 0.5) * step, y: HEAD + high - size - 4, class: "many" }, bin.compensations)
        : null,
    );
  };
  const tick = (bin, index) => s("text", { x: Math.max(6, index * step), y: HEIGHT - FOOT + 14 }, percents(bin.error_from));
  const said = bins.filter((one) => one.compensations).map((one) => `${range(one)}: ${one.compensations}`);
  return h(
    "figure",
    { class: "histogram" },
    h("figcaption", {}, h("strong", {}, "Compensation error"), `, newest of ${count(total, "compensation")} in force`),
    s(
      "svg",
      { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `Compensations by error. ${said.join("; ")}` },
      s("line", { x1: 0, x2: WIDTH, y1: HEIGHT - FOOT, y2: HEIGHT - FOOT, class: "ground" }),
      bins.map(bar),
      bins.map(tick),
      s("text", { x: WIDTH / 2, y: HEIGHT - 4 }, "error in % (Eq. 35); the last bar has no upper bound"),
    ),
  );
}

function arrays(robots, fleet) {
  return [
    h("p", { class: "hint" }, "Robots that need attention first, at most 24. ", legend()),
    h("ul", { class: "arrays" }, robots.map((robot) => robotCard(robot, fleet))),
  ];
}

const STATES = {
  uncompensated: ["trimmed, not compensated", "bad", "cross"],
  faulty: ["faulty", "bad", "drop"],
  compensated: ["trimmed, compensated", "info", "tick"],
  worn: ["worn or suspected", "warn", "slope"],
  learning: ["being learned", "info", "dots"],
  healthy: ["healthy (no sign)", "good", null],
};

const legend = () =>
  h(
    "span",
    { class: "marks" },
    Object.values(STATES).map(([words, tone, shape]) => mark(words, tone, shape ?? "circle")),
  );

/** The state of a whisker: one of `STATES`, and its words. */
function stateOf(whisker) {
  if (isUncompensated(whisker)) return "uncompensated";
  if (whisker.fault) return "faulty";
  if (whisker.condition === "TRIMMED") return "compensated";
  return { HEALTHY: "healthy", LEARNING: "learning" }[whisker.condition] ?? "worn";
}

/** Few whiskers that are not healthy are named, many are counted by state. */
function unsound(whiskers) {
  const bad = whiskers.filter((whisker) => stateOf(whisker) !== "healthy");
  const words = (one) =>
    `${one.array} ${one.whisker} ${one.fault ? say(FAULTS, one.fault) : say(CONDITIONS, one.condition)}`;
  if (bad.length <= 3) return bad.map(words);
  const states = Object.entries(Object.groupBy(bad, stateOf));
  return states.map(([state, some]) => `${count(some.length, "whisker")} ${STATES[state][0]}`);
}

function robotCard(robot, fleet) {
  const rows = [...Map.groupBy(robot.whiskers, (whisker) => whisker.array)];
  const isAway = robot.connection !== "ONLINE";
  const said = [isAway ? say(CONNECTIONS, robot.connection) : null, ...unsound(robot.whiskers)].filter(Boolean);
  return h(
    "li",
    { "data-key": `array-${robot.fleet}-${robot.robot}`, class: isAway ? "away" : null },
    h(
      "a",
      { href: link.robot(robot) },
      h("span", { class: "who" }, fleet ? robot.robot : `${robot.fleet}, ${robot.robot}`),
      rows.map(([, whiskers]) => small(whiskers)),
      h("span", { class: "what" }, said.join("; ") || "all whiskers healthy"),
      robot.attention ? h("span", { class: "mark bad" }, shapeOf("bell"), count(robot.attention, "alarm")) : null,
    ),
  );
}

/** Width and height of a whisker in a small drawing, and the most in one line, so that all are equally large. */
const STEP = 12;
const TALL = 40;
const LINE = 24;

/** An array as a row of whiskers by position: solid the present length, dashed the whole one, and a sign for the state. */
function small(whiskers) {
  const sorted = [...whiskers].sort((one, other) => one.y_mm - other.y_mm || one.x_mm - other.x_mm);
  const longest = Math.max(...sorted.map((one) => one.whole_length_mm));
  const lines = Math.ceil(sorted.length / LINE);
  const width = Math.min(sorted.length, LINE) * STEP;
  const whisker = (one, index) => {
    const state = stateOf(one);
    const [, tone, shape] = STATES[state];
    const x = ((index % LINE) + 0.5) * STEP;
    const ground = (Math.floor(index / LINE) + 1) * (TALL + STEP) - STEP;
    const [whole, now] = [one.whole_length_mm, one.length_mm].map((length) => (TALL * Math.max(0, length)) / longest);
    const tip = ground - Math.min(now, TALL);
    return s(
      "g",
      { class: `one ${tone}` },
      s("path", { d: `M${x - 3.5} ${ground}L${x - 1} ${ground - whole}H${x + 1}L${x + 3.5} ${ground}Z`, class: "whole" }),
      s("path", { d: `M${x - 3.5} ${ground}L${x - 1.6} ${tip}H${x + 1.6}L${x + 3.5} ${ground}Z`, class: "body" }),
      shape ? sign(shape, x, ground + STEP / 2) : null,
    );
  };
  return s(
    "svg",
    {
      viewBox: `0 0 ${width} ${lines * (TALL + STEP)}`,
      width,
      height: lines * (TALL + STEP),
      "aria-hidden": "true",
      class: "small",
    },
    sorted.map(whisker),
  );
}

/** A sign of 9 units below a whisker. */
function sign(shape, x, y) {
  const drawn = shapeOf(shape);
  for (const [name, value] of Object.entries({ x: x - 4.5, y: y - 4.5, width: 9, height: 9 })) drawn.setAttribute(name, value);
  return drawn;
}

/** Whether the service has overviews. */
export const hasOverview = () => has("GET", OVERVIEW);
