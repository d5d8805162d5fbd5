// Charts over the contact ratio: `<model-chart>`, the sensitivity of a whisker and of its model, and `<error-chart>`, the
// error of a compensation.

import { get } from "../api.js";
import { h } from "../dom.js";
import { interval, mm, mpa, percent } from "../format.js";
import { problemPanel } from "../notices.js";
import { api } from "../places.js";
import { table } from "../table.js";
import { Plot } from "./plot.js";

const perMm = (value) => `${value.toFixed(5)}\u00a0/mm`;
const ofPercent = (value, low, high) => interval(value / 100, low / 100, high / 100, percent);
const across = { isTime: false, cursorWords: (ratio) => `contact ratio ${ratio.toFixed(2)}` };
/** Contact ratios of the horizontal axis: the paper's 0.45 to 1.00, with a margin. */
const RATIOS = { from: 0.425, to: 1.025 };

/** An element with one chart, drawn again when its attributes change; `load` gives `{ spec, data, table }`. */
class RatioChart extends HTMLElement {
  #plot = null;
  #key = null;
  #turn = 0;
  #stop = new AbortController();
  #body = h("div", {});
  #spoken = h("p", { class: "unseen", "aria-live": "polite" });

  connectedCallback() {
    if (!this.#body.isConnected) this.append(this.#body);
    this.#stop = new AbortController();
    const scheme = matchMedia("(prefers-color-scheme: dark)");
    scheme.addEventListener("change", () => this.#plot?.redraw(), { signal: this.#stop.signal });
    this.#draw();
  }

  disconnectedCallback() {
    this.#stop.abort();
    this.#plot?.close();
    this.#plot = null;
    this.#key = null;
  }

  attributeChangedCallback() {
    if (this.isConnected) this.#draw();
  }

  async #draw() {
    this.#turn += 1;
    const turn = this.#turn;
    try {
      const { spec, data, values } = await this.load();
      if (turn !== this.#turn || !this.isConnected) return;
      // Texts of the chart name the length and the pressure: when they change, it is another chart.
      const key = JSON.stringify(spec);
      if (key !== this.#key) this.#begin(spec, values, key);
      else this.#body.querySelector("details > div").replaceChildren(values);
      await this.#plot.set(data, spec.window ?? RATIOS);
      this.#body.dataset.state = "drawn";
    } catch (problem) {
      if (turn !== this.#turn) return;
      this.#plot?.close();
      this.#key = null;
      this.#body.dataset.state = "failed";
      this.#body.replaceChildren(problemPanel(problem, () => this.#draw()));
    }
  }

  #begin(spec, values, key) {
    this.#plot?.close();
    this.#key = key;
    const plot = new Plot(
      { ...across, ...spec },
      {
        cursor: (x) => plot.follow(x),
        spoken: (text) => (this.#spoken.textContent = text),
      },
    );
    this.#plot = plot;
    const isOpen = this.#body.querySelector("details")?.open ?? false;
    const details = h("details", { open: isOpen }, h("summary", {}, "Values as a table"), h("div", {}, values));
    this.#body.replaceChildren(this.#plot.element, details, this.#spoken);
  }
}

/** Attributes: `fleet`, `robot`, `array`, `whisker`, and `version`. */
class ModelChart extends RatioChart {
  static observedAttributes = ["version"];

  async load() {
    const [fleet, robot, array, whisker] = ["fleet", "robot", "array", "whisker"].map((name) =>
      this.getAttribute(name),
    );
    const model = await get(`${api.whisker({ fleet, robot, array, whisker })}/model`);
    const bins = model.by_ratio;
    const of = (name) => {
      const known = bins.filter((one) => one[name] !== null);
      return { x: known.map((one) => one.ratio), y: known.map((one) => one[name]) };
    };
    const recent = [...model.recent].sort((one, other) => one.ratio - other.ratio);
    const now = `${mm(model.length_mm, 1)} at ${mpa(model.pressure_mpa, 3)}`;
    const spec = {
      key: "model",
      title: "Sensitivity by contact ratio",
      unit: "strain per mm of deflection, 1/mm",
      atLeast: [0, 0],
      level: null,
      series: [
        { name: "recent contacts", tone: "b", look: "points", say: perMm },
        { name: `this whisker now, ${now}`, tone: "a", look: "line", say: perMm },
        { name: `model ${model.model} now`, tone: "c", look: "line", dash: [3, 3], say: perMm },
        {
          name: `model of the unbroken whisker, ${mm(model.whole_length_mm, 1)} at ${mpa(model.nominal_pressure_mpa, 3)}`,
          tone: "m",
          look: "line",
          dash: [8, 4],
          say: perMm,
        },
      ],
    };
    const points = { x: recent.map((one) => one.ratio), y: recent.map((one) => one.sensitivity_per_mm) };
    const data = [points, of("own_per_mm"), of("model_per_mm"), of("whole_per_mm")];
    return { spec, data, values: modelTable(bins) };
  }
}

function modelTable(bins) {
  const cell = (name) => (row) => (row[name] === null ? "\u2013" : row[name].toFixed(5));
  return table({
    caption: "Sensitivity by contact ratio, in strain per mm of deflection",
    rows: bins,
    empty: "None.",
    columns: [
      { name: "Contact ratio", head: true, cell: (row) => row.ratio.toFixed(2) },
      { name: "This whisker now", numeric: true, cell: cell("own_per_mm") },
      { name: "Model now", numeric: true, cell: cell("model_per_mm") },
      { name: "Unbroken", numeric: true, cell: cell("whole_per_mm") },
      { name: "Measured mean", numeric: true, cell: cell("measured_per_mm") },
      { name: "Contacts", numeric: true, cell: (row) => row.measured_contacts },
    ],
  });
}

/** Attributes: `measured` and `predicted`, lists of `[ratio, error, low, high]` as JSON. */
class ErrorChart extends RatioChart {
  static observedAttributes = ["measured", "predicted"];

  load() {
    const [measured, predicted] = ["measured", "predicted"].map((name) => JSON.parse(this.getAttribute(name)));
    const column = (rows, index, factor = 1) => rows.map((row) => row[index] * factor);
    const spec = {
      key: "error-by-ratio",
      title: "Error by contact ratio",
      unit: "% (Eq. 35), with 95 % intervals",
      atLeast: [0, 25],
      level: null,
      series: [
        { name: "measured", tone: "a", look: "points", say: ofPercent },
        { name: "predicted", tone: "b", look: "line", dash: [6, 3], say: (value) => percent(value / 100) },
      ],
    };
    const data = [
      {
        x: column(measured, 0),
        y: column(measured, 1, 100),
        low: column(measured, 2, 100),
        high: column(measured, 3, 100),
      },
      { x: column(predicted, 0), y: column(predicted, 1, 100) },
    ];
    return { spec, data, values: errorTable(measured, predicted) };
  }
}

function errorTable(measured, predicted) {
  const ratios = [...new Set([...measured, ...predicted].map(([ratio]) => ratio.toFixed(2)))].sort();
  const at = (rows, ratio) => rows.find(([own]) => own.toFixed(2) === ratio) ?? [];
  return table({
    caption: "Predicted and measured error by contact ratio",
    rows: ratios,
    empty: "None.",
    columns: [
      { name: "Contact ratio", head: true, cell: (ratio) => ratio },
      { name: "Predicted", numeric: true, cell: (ratio) => percent(at(predicted, ratio)[1]) },
      { name: "Measured", numeric: true, cell: (ratio) => intervalOf(at(measured, ratio)) },
    ],
  });
}

const intervalOf = ([, error, low, high]) => interval(error, low, high, percent);

/** Attribute: `rows`, the sensitivities of a what-if query as JSON. */
class WhatIfChart extends RatioChart {
  static observedAttributes = ["rows"];

  load() {
    const rows = JSON.parse(this.getAttribute("rows"));
    const of = (name) => {
      const known = rows.filter((one) => one[name] !== null);
      return { x: known.map((one) => one.ratio), y: known.map((one) => one[name]) };
    };
    const spec = {
      key: "what-if",
      title: "Sensitivity by contact ratio",
      unit: "strain per mm of deflection, 1/mm",
      atLeast: [0, 0],
      level: null,
      series: [
        { name: "before the cut", tone: "a", look: "line", say: perMm },
        { name: "after the cut", tone: "b", look: "line", dash: [3, 3], say: perMm },
        { name: "compensated", tone: "c", look: "line", dash: [8, 4], say: perMm },
      ],
    };
    const data = ["before_per_mm", "after_per_mm", "compensated_per_mm"].map(of);
    const cell = (name) => (row) => (row[name] === null ? "\u2013" : row[name].toFixed(5));
    const values = table({
      caption: "Predicted sensitivity by contact ratio, in strain per mm of deflection",
      rows,
      empty: "None.",
      columns: [
        { name: "Contact ratio", head: true, cell: (row) => row.ratio.toFixed(2) },
        { name: "Before the cut", numeric: true, cell: cell("before_per_mm") },
        { name: "After the cut", numeric: true, cell: cell("after_per_mm") },
        { name: "Compensated", numeric: true, cell: cell("compensated_per_mm") },
      ],
    });
    return { spec, data, values };
  }
}

/** Attribute: `fit`, `{ readings: [[pressure_mpa, k2]], curve: [[pressure_mpa, k2]] }` as JSON. */
class CalibrationChart extends RatioChart {
  static observedAttributes = ["fit"];

  load() {
    const { readings, curve } = JSON.parse(this.getAttribute("fit"));
    const series = (pairs) => ({ x: pairs.map(([x]) => x), y: pairs.map(([, y]) => y) });
    const say = (value) => value.toFixed(4);
    const most = curve.at(-1)[0];
    const spec = {
      key: "calibration",
      title: "Modulus of the chamber's wall, relative to the rubber's (k2), by pressure in MPa",
      unit: null,
      atLeast: [0, 0],
      level: null,
      window: { from: -0.02 * most, to: 1.02 * most },
      cursorWords: (pressure) => mpa(pressure),
      series: [
        { name: "readings", tone: "b", look: "points", say },
        { name: "fit c + a exp(-b Q)", tone: "a", look: "line", say },
      ],
    };
    const values = table({
      caption: "Readings",
      rows: readings,
      empty: "None.",
      columns: [
        { name: "Pressure", head: true, cell: ([pressure]) => mpa(pressure) },
        { name: "k2", numeric: true, cell: ([, k2]) => say(k2) },
      ],
    });
    return { spec, data: [series(readings), series(curve)], values };
  }
}

customElements.define("what-if-chart", WhatIfChart);
customElements.define("calibration-chart", CalibrationChart);
customElements.define("model-chart", ModelChart);
customElements.define("error-chart", ErrorChart);

/** The model's curve of a whisker with its recent contacts. */
export function modelChart(whisker) {
  const { fleet, robot, array, whisker: number } = whisker;
  const version = [whisker.contacts, whisker.setpoint_mpa, whisker.pressure_mpa, whisker.length_mm].join(" ");
  return h("model-chart", { "data-key": "model", fleet, robot, array, whisker: number, version });
}

/** The sensitivities before and after a cut, and of the compensator. */
export const whatIfChart = (rows) => h("what-if-chart", { "data-key": "what-if", rows: JSON.stringify(rows) });

/** Points of the curve of a calibration. */
const CURVE = 60;

/** Readings and fit of a calibration. */
export function calibrationChart({ measurements, fit }) {
  const pairs = measurements.rows.map((row, index) => [row.pressure_mpa, fit.residuals[index]?.k2 ?? null]);
  const readings = pairs.filter(([, k2]) => k2 !== null).sort(([one], [other]) => one - other);
  const most = Math.max(0.1, ...readings.map(([pressure]) => pressure));
  const k2 = (pressure) => fit.c.value + fit.a.value * Math.exp(-fit.b_per_mpa.value * pressure);
  const curve = Array.from({ length: CURVE + 1 }, (_, index) => (index * most) / CURVE).map((at) => [at, k2(at)]);
  return h("calibration-chart", { "data-key": "calibration", fit: JSON.stringify({ readings, curve }) });
}

/** Contact ratios of the predicted errors. */
const PREDICTED = Array.from({ length: 12 }, (_, index) => 0.45 + 0.05 * index);

/** The error of a decision by contact ratio; null without a compensator. */
export function errorChart(decision) {
  if (decision.compensator_whisker === null) return null;
  const chosen = decision.candidates.find((one) => one.chosen)?.predicted_error_by_ratio ?? [];
  const predicted = chosen.map((error, index) => [Number(PREDICTED[index].toFixed(2)), error]);
  const bins = decision.errors_by_ratio ?? [];
  const measured = bins.map((one) => [one.ratio, one.error, one.error_low, one.error_high]);
  return h("error-chart", {
    "data-key": "error-by-ratio",
    measured: JSON.stringify(measured),
    predicted: JSON.stringify(predicted),
  });
}
