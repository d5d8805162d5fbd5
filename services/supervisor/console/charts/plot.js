// One chart, drawn by uPlot in the page's colours: lines with 95 % bands, steps, points with bars, and a level. The
// values at the cursor are text beside it, and the keyboard moves the cursor.

import { h } from "../dom.js";
import { broken, isAlone } from "./gaps.js";
import { labels, nearest, numberLabels, reachOf } from "./scale.js";

/** Height of a chart, and width of the vertical axis, which is the same in all charts so that their times align. */
const HEIGHT_PX = 200;
export const LEFT_PX = 64;
/** Half a label of the axis of time, so that the last one is whole. */
export const RIGHT_PX = 34;
/** A value is shown at the cursor if it is this near, as a part of the chart's width. */
const NEAR = 0.05;

let library = null;
/** Loads uPlot when the first chart is shown. After a failure the next chart tries again. */
async function loaded() {
  library ??= import("../vendor/uPlot.esm.js").then((module) => module.default);
  try {
    return await library;
  } catch (problem) {
    library = null;
    throw problem;
  }
}

/**
 * `spec`: `{ key, title, unit, isTime, across, series, atLeast, level, cursorWords(x) }`. A series is `{ name, tone,
 * look, dash, say(value, low, high) }`, its look is "line", "step" or "points". `on` has `cursor(x)`, `spoken(text)`,
 * and for charts over time `zoom({ from, to })`, `reset()` and `scale(factor)`.
 */
export class Plot {
  #spec;
  #on;
  #chart = null;
  #library = null;
  #data = [];
  #window = { from: 0, to: 1 };
  #events = [];
  #values = h("p", { class: "values" });
  #nothing = h("p", { class: "nothing", hidden: true }, "no values in this range");
  #area;
  #isFollowing = false;
  #isClosed = false;
  #sizes = new ResizeObserver(() => this.#resize());

  constructor(spec, on) {
    this.#spec = spec;
    this.#on = on;
    this.#area = h("div", {
      class: "plot",
      role: "application",
      tabindex: "0",
      "aria-roledescription": "chart",
      "aria-label": `${spec.title}. Arrow keys move the cursor.`,
      onkeydown: (event) => this.#key(event),
    });
    this.element = h(
      "figure",
      { class: "chart", "data-chart": spec.key },
      h("figcaption", {}, h("strong", {}, spec.title), spec.unit ? `, ${spec.unit}` : null),
      this.#values,
      h("div", { class: "frame" }, this.#area, this.#nothing),
    );
  }

  /** Shows data: for each series `{ x, y, low, high }`, in a window of the horizontal axis. */
  async set(data, window, events = []) {
    [this.#data, this.#window, this.#events] = [data, window, events];
    this.#library = await loaded();
    if (this.#isClosed) return;
    this.#nothing.hidden = data.some(({ x }) => x.some((one) => one >= window.from && one <= window.to));
    if (this.#chart) this.#chart.setData(this.#columns());
    else this.#draw();
    this.follow(null);
  }

  /** Draws again, because colours or the time zone have changed. */
  redraw() {
    this.#chart?.redraw(true, true);
  }

  close() {
    this.#isClosed = true;
    this.#sizes.disconnect();
    this.#chart?.destroy();
    this.#chart = null;
  }

  /** Shows the cursor at a position; null removes it, and the newest values are shown. */
  follow(x) {
    if (this.#chart) {
      this.#isFollowing = true;
      const left = x === null ? -10 : this.#chart.valToPos(x, "x");
      this.#chart.setCursor({ left, top: x === null ? -10 : 1 });
      this.#isFollowing = false;
    }
    this.#values.replaceChildren(...this.#legend(x));
  }

  /** The values at a position in words. */
  words(x) {
    const told = this.#spec.series.map((series, index) => [series, this.#at(index, x)]).filter(([, value]) => value);
    const texts = told.map(([series, value]) => `${series.name} ${value}`);
    return `${this.#spec.title}: ${texts.join(", ") || "no value"}`;
  }

  #at(index, x) {
    const { say, look } = this.#spec.series[index];
    const { x: xs, y, low, high } = this.#data[index] ?? { x: [] };
    const place = x === null ? xs.length - 1 : nearest(xs, x, look === "step");
    if (place < 0 || place >= xs.length || !Number.isFinite(y[place])) return null;
    const isFar = Math.abs(xs[place] - x) > NEAR * (this.#window.to - this.#window.from);
    if (x !== null && look !== "step" && isFar) return null;
    return say(y[place], low?.[place], high?.[place]);
  }

  #legend(x) {
    const { series, level, cursorWords } = this.#spec;
    // Over numbers there is no newest value.
    const at = x === null && !this.#spec.isTime ? undefined : x;
    const key = (tone, look, words) =>
      h("span", { class: "key" }, h("span", { class: `swatch ${tone} ${look}` }), words);
    return [
      at === undefined || (at === null && !this.#data.some((one) => one.x.length))
        ? null
        : h("span", { class: "at" }, at === null ? "newest" : cursorWords(at)),
      ...series.map((one, index) => {
        const value = at === undefined ? null : this.#at(index, at);
        return key(one.tone, one.dash ? "dash" : one.look, value ? [`${one.name} `, h("b", {}, value)] : one.name);
      }),
      level ? key("m", "dash", level.name) : null,
    ].filter(Boolean);
  }

  #columns() {
    const { isTime, series } = this.#spec;
    // Where the cursor finds no value between two points, the line has a gap.
    const widest = isTime ? 2 * NEAR * (this.#window.to - this.#window.from) : Infinity;
    const shown = this.#data.map((one, index) => (series[index].look === "line" ? broken(one, widest) : one));
    return this.#library.join(shown.map(({ x, y, low, high }) => (low ? [x, y, low, high] : [x, y])));
  }

  #draw() {
    const series = [{}];
    const bands = [];
    const color = (tone) => () => this.#color(`--chart-${tone}`);
    this.#spec.series.forEach(({ tone, look, dash }, index) => {
      const stroke = color(tone);
      const paths = { step: this.#library.paths.stepped({ align: 1 }), points: () => null }[look];
      const points = {
        show: () => look === "points" || this.#isSparse(index),
        filter: (chart, place, isShown) => (isShown || look !== "line" ? null : isAlone(chart.data[place])),
        size: 5,
        fill: stroke,
        stroke,
        width: 0,
      };
      series.push({ stroke, paths, dash, width: 2, spanGaps: look !== "line", points, auto: false });
      if (!this.#data[index].low) return;
      // The bounds have no line: a band or bars show them.
      const bound = {
        stroke: null,
        width: 0,
        points: { show: false },
        spanGaps: look !== "line",
        paths: look === "points" ? () => null : undefined,
      };
      series.push({ ...bound }, { ...bound });
      if (look !== "points")
        bands.push({ series: [series.length - 1, series.length - 2], fill: () => this.#color(`--chart-${tone}-band`) });
    });
    const axis = { stroke: () => this.#color("--soft"), font: "12px system-ui, sans-serif" };
    const grid = { stroke: () => this.#color("--faint"), width: 1 };
    const options = {
      width: this.#area.clientWidth,
      height: HEIGHT_PX,
      ms: 1,
      padding: [8, RIGHT_PX, 0, 0],
      legend: { show: false },
      tzDate: (at) => labels.inZone(this.#library, at),
      scales: {
        x: { time: this.#spec.isTime, range: () => [this.#window.from, this.#window.to] },
        y: { range: () => reachOf(this.#data, this.#spec, this.#window) },
      },
      series,
      bands,
      axes: [
        {
          ...axis,
          grid,
          ticks: grid,
          size: this.#spec.isTime ? 44 : 32,
          space: 70,
          values: this.#spec.isTime ? labels.times : numberLabels,
        },
        { ...axis, grid, ticks: grid, size: LEFT_PX, space: 32, values: numberLabels },
      ],
      cursor: {
        y: false,
        drag: { x: Boolean(this.#on.zoom), y: false, setScale: false, dist: 6 },
        points: { size: 9 },
        bind: { dblclick: () => () => this.#on.reset?.() },
      },
      hooks: {
        draw: [(chart) => this.#marks(chart)],
        setCursor: [(chart) => this.#moved(chart)],
        setSelect: [(chart) => this.#selected(chart)],
      },
    };
    this.#chart = new this.#library(options, this.#columns(), this.#area);
    this.#sizes.observe(this.#area);
  }

  /** Whether a line has so few points in the window that each is worth a dot: a single one has no line. */
  #isSparse(index) {
    const { from, to } = this.#window;
    return this.#data[index].x.filter((x) => x >= from && x <= to).length <= 30;
  }

  #color(name) {
    return getComputedStyle(this.#area).getPropertyValue(name).trim();
  }

  #resize() {
    const width = this.#area.clientWidth;
    if (this.#chart && width > 0 && width !== this.#chart.width) this.#chart.setSize({ width, height: HEIGHT_PX });
  }

  #moved(chart) {
    // uPlot calls hooks in a later microtask, even after `close`.
    if (this.#isFollowing || this.#isClosed) return;
    this.#on.cursor(chart.cursor.left < 0 ? null : chart.posToVal(chart.cursor.left, "x"));
  }

  #selected(chart) {
    const { left, width } = chart.select;
    if (!this.#on.zoom || width < 1) return;
    const [from, to] = [left, left + width].map((place) => chart.posToVal(place, "x"));
    chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.#on.zoom({ from, to });
  }

  /** The level, the bars of points, and a line for each event. */
  #marks(chart) {
    const { ctx, bbox } = chart;
    const [x, y] = ["x", "y"].map((scale) => (value) => chart.valToPos(value, scale, true));
    const line = (tone, dash, from, to) => {
      ctx.strokeStyle = this.#color(tone);
      ctx.setLineDash(dash.map((one) => one * devicePixelRatio));
      ctx.beginPath();
      ctx.moveTo(...from);
      ctx.lineTo(...to);
      ctx.stroke();
    };
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineWidth = 1.2 * devicePixelRatio;
    const { level, series } = this.#spec;
    if (level) line("--chart-m", [7, 4], [bbox.left, y(level.y)], [bbox.left + bbox.width, y(level.y)]);
    series.forEach(({ look, tone }, index) => {
      const { x: xs, low, high } = this.#data[index];
      if (look !== "points" || !low) return;
      xs.forEach((at, place) => line(`--chart-${tone}`, [], [x(at), y(low[place])], [x(at), y(high[place])]));
    });
    for (const { at, tone, isSelected } of this.#events)
      line(`--${tone}`, isSelected ? [] : [2, 3], [x(at), bbox.top], [x(at), bbox.top + bbox.height]);
    ctx.restore();
  }

  #key(event) {
    const { key } = event;
    const zoom = { "+": 0.5, "=": 0.5, "-": 2 }[key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (zoom && this.#on.scale) this.#on.scale(zoom);
    else if ((key === "Escape" || key === "0") && this.#on.reset) this.#on.reset();
    else if (
      !this.#step({ ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10, Home: -Infinity, End: Infinity }[key])
    )
      return;
    event.preventDefault();
  }

  /** Moves the cursor by points of the chart; from nowhere, it begins at the newest one. */
  #step(by) {
    if (by === undefined) return false;
    const { from, to } = this.#window;
    const all = this.#data.flatMap(({ x }) => x).filter((one) => one >= from && one <= to);
    const xs = [...new Set(all)].sort((one, other) => one - other);
    if (!xs.length) return true;
    const left = this.#chart?.cursor.left ?? -1;
    const now = left < 0 ? xs.length - (by < 0 ? 0 : 1) : nearest(xs, this.#chart.posToVal(left, "x"));
    const x = xs[Math.min(Math.max(now + by, 0), xs.length - 1)];
    this.#on.cursor(x);
    this.#on.spoken(`${this.#spec.cursorWords(x)}. ${this.words(x)}`);
    return true;
  }
}
