// The range of charts: buttons, and the range in words.

import { h } from "../dom.js";
import { count, moment } from "../format.js";
import { RANGES, showQuantity, shownQuantity } from "./range.js";
import { QUANTITIES } from "./series.js";

const RESOLUTIONS = {
  contacts: "single contacts",
  means: "means of equal intervals",
  minute: "means of minutes",
  hour: "means of hours",
};

/** `on` has `choose(range)`, `scale(factor)`, `move(part of the range)` and `quantity()`. */
export class Toolbar {
  quantity = shownQuantity(Object.keys(QUANTITIES));
  #status = h("p", { class: "hint" });
  #ranges;
  #newest;

  constructor(on) {
    const button = (words, onclick, label = null) =>
      h("button", { type: "button", "aria-label": label, onclick }, words);
    this.#ranges = RANGES.map(([name, words]) => [name, button(words, () => on.choose({ name }))]);
    this.#newest = button("Newest", () => on.choose(null));
    const choice = ([name, { label }]) => h("option", { value: name, selected: name === this.quantity }, label);
    const select = h(
      "select",
      { id: "quantity", onchange: () => this.#choose(select.value, on) },
      Object.entries(QUANTITIES).map(choice),
    );
    this.element = h(
      "div",
      { class: "toolbar" },
      h(
        "div",
        { class: "buttons", role: "group", "aria-label": "Range" },
        this.#newest,
        this.#ranges.map(([, one]) => one),
      ),
      h(
        "div",
        { class: "buttons", role: "group", "aria-label": "Move and zoom" },
        button("\u2039", () => on.move(-0.5), "Earlier"),
        button("\u203a", () => on.move(0.5), "Later"),
        button("+", () => on.scale(0.5), "Zoom in"),
        button("\u2212", () => on.scale(2), "Zoom out"),
      ),
      h("p", { class: "inline-field" }, h("label", { for: "quantity" }, "Sensitivity as"), select),
      this.#status,
      h(
        "p",
        { class: "hint" },
        "Drag over a chart to zoom, double-click for the newest. + and \u2212 keep the right end, or the cursor's place. With the keyboard: arrow keys, Home and End move the cursor, + and \u2212 zoom, 0 shows the newest.",
      ),
    );
  }

  #choose(quantity, on) {
    this.quantity = quantity;
    showQuantity(quantity);
    on.quantity();
  }

  /** Shows the range, and how much data is in it. */
  show(range, window, { rows, resolution }) {
    for (const [one, button] of this.#ranges) button.setAttribute("aria-pressed", String(one === range?.name));
    this.#newest.setAttribute("aria-pressed", String(range === null));
    const inside = rows.filter(({ at }) => at >= window.from && at <= window.to);
    const contacts = inside.reduce((sum, row) => sum + row.contacts, 0);
    const kept = range?.from === undefined ? "follows new data" : "chosen range; new data appear if they lie in it";
    this.#status.textContent = `${moment(window.from)} to ${moment(window.to)} (${kept}). ${count(contacts, "contact")}, ${RESOLUTIONS[resolution]}.`;
  }
}
