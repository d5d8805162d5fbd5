// `<whisker-charts>`: sensitivity, length, pressure and error of a whisker over one range of time, with its events.
//
// Attributes: `fleet`, `robot`, `array`, `whisker`, `whole` (whole length, mm),
// `nominal` (nominal pressure, MPa), `event` (time of the newest event, ms since 1970). New data are loaded when `version` changes,
// and the charts are built again when `whole` or `nominal` does: the whisker was replaced.

import { problemPanel } from "../notices.js";
import { h } from "../dom.js";
import { onZone } from "../zone.js";
import { EventLane } from "./lane.js";
import { errorsOf, newestOf, rowsOf, setpointsOf } from "./data.js";
import { eventsOf, KINDS } from "./events.js";
import { Plot } from "./plot.js";
import { fitted, limited, rangeOf, resolutionOf, showRange, windowOf } from "./range.js";
import { dataOf, specs } from "./series.js";
import { Toolbar } from "./toolbar.js";
import { ValueTables } from "./values.js";

/** Shortest time between two loads that new data cause, by resolution: coarse data change slowly. */
const PAUSE_MS = { contacts: 1_000, means: 1_000, minute: 5_000, hour: 15_000 };

class WhiskerCharts extends HTMLElement {
  static observedAttributes = ["version", "whole", "nominal"];
  #range = null;
  #window = { from: 0, to: 1 };
  /** Time of the newest contact, in ms since 1970; null if there is none. */
  #newest = null;
  #found = null;
  #plots = [];
  #cursor = null;
  #state = "idle";
  #loadedAt = 0;
  #timer = 0;
  #stop = new AbortController();
  #spoken = h("p", { class: "unseen", "aria-live": "polite" });
  #problem = h("div", { role: "alert" });
  #body = h("div", { class: "charts" });
  #toolbar = new Toolbar({
    choose: (range) => this.#choose(range),
    scale: (factor) => this.#scale(factor),
    move: (part) => this.#move(part),
    quantity: () => this.#rebuild(),
  });
  #lane = new EventLane(() => this.#draw());
  #values = new ValueTables();

  connectedCallback() {
    if (!this.#body.isConnected) this.append(this.#body);
    this.#range = rangeOf(location.hash);
    this.#rebuild();
    this.#stop = new AbortController();
    const { signal } = this.#stop;
    // A link, or a step back in the browser's history.
    addEventListener("popstate", () => this.#addressed(), { signal });
    addEventListener("hashchange", () => this.#addressed(), { signal });
    matchMedia("(prefers-color-scheme: dark)").addEventListener(
      "change",
      () => this.#plots.forEach((plot) => plot.redraw()),
      { signal },
    );
    signal.addEventListener(
      "abort",
      onZone(() => this.#rezoned()),
    );
    this.#load();
  }

  disconnectedCallback() {
    this.#stop.abort();
    clearTimeout(this.#timer);
    this.#plots.forEach((plot) => plot.close());
    this.#plots = [];
  }

  attributeChangedCallback(name, before, after) {
    if (!this.isConnected || !this.#loadedAt || before === after) return;
    if (name === "version") this.#loadSoon();
    else this.#rebuild();
  }

  get #whisker() {
    const [fleet, robot, array, whisker] = ["fleet", "robot", "array", "whisker"].map((name) =>
      this.getAttribute(name),
    );
    return { fleet, robot, array, whisker: Number(whisker) };
  }

  /** Time of the newest event, in ms since 1970; null without one. */
  get #event() {
    return this.hasAttribute("event") ? Number(this.getAttribute("event")) : null;
  }

  /** Builds the charts, which depend on the quantity of the sensitivity. */
  #rebuild() {
    this.#plots.forEach((plot) => plot.close());
    const about = { whole: Number(this.getAttribute("whole")), nominal: Number(this.getAttribute("nominal")) };
    const on = {
      cursor: (x) => this.#follow(x),
      spoken: (text) => (this.#spoken.textContent = text),
      zoom: (range) => this.#choose(limited(range)),
      reset: () => this.#choose(null),
      scale: (factor) => this.#scale(factor),
    };
    this.#plots = specs(about, this.#toolbar.quantity).map((spec) => new Plot(spec, on));
    this.#body.replaceChildren(
      this.#toolbar.element,
      this.#problem,
      this.#lane.element,
      ...this.#plots.map((plot) => plot.element),
      this.#values.element,
      this.#spoken,
    );
    if (this.#found) this.#draw();
  }

  #rezoned() {
    this.#plots.forEach((plot) => plot.redraw());
    if (this.#found) this.#draw();
  }

  #addressed() {
    const range = rangeOf(location.hash);
    if (JSON.stringify(range) === JSON.stringify(this.#range)) return;
    this.#range = range;
    this.#changed();
  }

  #choose(range) {
    this.#range = range;
    showRange(range);
    this.#changed();
  }

  /** Shows what is known of the new range, and loads the rest. */
  #changed() {
    this.#cursor = null;
    // Without a range the data decide about the window.
    if (this.#range) this.#window = windowOf(this.#range, this.#newest);
    if (this.#found) this.#draw();
    this.#load();
  }

  #scale(factor) {
    const { from, to } = this.#window;
    // The cursor keeps its place; without one, the right end, where new data appear.
    const kept = this.#cursor ?? to;
    this.#choose(limited({ from: kept - (kept - from) * factor, to: kept + (to - kept) * factor }));
  }

  #move(part) {
    const by = part * (this.#window.to - this.#window.from);
    this.#choose({ from: Math.round(this.#window.from + by), to: Math.round(this.#window.to + by) });
  }

  #loadSoon() {
    const pause = PAUSE_MS[this.#found?.resolution] ?? PAUSE_MS.contacts;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#load(), Math.max(0, this.#loadedAt + pause - Date.now()));
  }

  async #load() {
    if (this.#state !== "idle") {
      this.#state = "again";
      return;
    }
    this.#state = "loading";
    this.#body.setAttribute("aria-busy", "true");
    const [whisker, range] = [this.#whisker, this.#range];
    try {
      this.#newest = await newestOf(whisker);
      const whole = windowOf(range, this.#newest, Date.now(), this.#event);
      const all = range ? null : await rowsOf(whisker, whole);
      const window = range ? whole : fitted(whole, all.rows, this.#event);
      if (range === this.#range) this.#window = window;
      // A shorter window may have finer data.
      const isFine = all && resolutionOf(whole) === resolutionOf(window) && all.resolution !== "means";
      const [{ rows, resolution }, errors, setpoints] = await Promise.all([
        isFine ? all : rowsOf(whisker, window),
        errorsOf(whisker, window),
        setpointsOf(whisker, window),
      ]);
      const { events, cut } = await eventsOf(whisker, window, { rows, setpoints });
      this.#found = { rows, resolution, errors, setpoints, events, cut };
      this.#problem.replaceChildren();
      // New data may have arrived meanwhile, but another range makes these data useless.
      if (range === this.#range && this.isConnected) await this.#draw();
      this.#body.dataset.state = "drawn";
    } catch (problem) {
      this.#problem.replaceChildren(problemPanel(problem, () => this.#load()));
      this.#body.dataset.state = "failed";
    }
    this.#loadedAt = Date.now();
    this.#body.removeAttribute("aria-busy");
    const isOutdated = this.#state === "again";
    this.#state = "idle";
    if (!isOutdated || !this.isConnected) return;
    if (range === this.#range) this.#loadSoon();
    else this.#load();
  }

  async #draw() {
    const [found, window] = [this.#found, this.#window];
    this.#toolbar.show(this.#range, window, found);
    this.#lane.show(found.events, found.cut, window);
    this.#values.show(found, window);
    // Changes of temperature are many where days are warmer than nights: only selected ones have a line.
    const told = found.events.map((event) => ({ ...event, isSelected: this.#lane.isSelected(event) }));
    const lines = told
      .filter(({ kind, isSelected }) => isSelected || kind !== "temperature")
      .map(({ at, kind, isSelected }) => ({ at, tone: KINDS[kind][1], isSelected }));
    const data = dataOf(found, window, Number(this.getAttribute("nominal")), this.#toolbar.quantity);
    await Promise.all(this.#plots.map((plot, index) => plot.set(data[index], window, lines)));
    if (this.#cursor !== null) this.#follow(this.#cursor);
  }

  #follow(x) {
    this.#cursor = x;
    this.#plots.forEach((plot) => plot.follow(x));
  }
}

customElements.define("whisker-charts", WhiskerCharts);

/** The charts of a whisker; `event` is the time of its newest event, in ms since 1970 or null, and `now` is the time of the page's last look, so that ranges which end now move on. */
export function whiskerCharts(whisker, event = null, now = Date.now()) {
  const { fleet, robot, array, whisker: number } = whisker;
  const version = [
    whisker.contacts,
    whisker.setpoint_mpa,
    whisker.pressure_mpa,
    whisker.condition,
    whisker.held,
    Math.floor(now / 10_000),
  ];
  return h("whisker-charts", {
    "data-key": "charts",
    fleet,
    robot,
    array,
    whisker: number,
    whole: whisker.whole_length_mm,
    nominal: whisker.nominal_pressure_mpa,
    event,
    version: version.join(" "),
  });
}
