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
      await this.#plot.set(data, RATIOS);
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
    this.#plot = new Plot(
      { ...across, ...spec },
      {
        cursor: (x) => this.#plot.follow(x),
        spoken: (text) => (this.#spoken.textContent = text),
      },
    );
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

customElements.define("model-chart", ModelChart);
customElements.define("error-chart", ErrorChart);

/** The model's curve of a whisker with its recent contacts. */
export function modelChart(whisker) {
  const { fleet, robot, array, whisker: number } = whisker;
  const version = [whisker.contacts, whisker.setpoint_mpa, whisker.pressure_mpa, whisker.length_mm].join(" ");
  return h("model-chart", { "data-key": "model", fleet, robot, array, whisker: number, version });
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
