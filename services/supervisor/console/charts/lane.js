// The marks of events above the charts. A mark is a button; it tells its events, with links to their decision or alarm.

import { h } from "../dom.js";
import { count, moment, time } from "../format.js";
import { mark, shapeOf } from "../marks.js";
import { clustered, KINDS, leftOut } from "./events.js";
import { LEFT_PX, RIGHT_PX } from "./plot.js";

/** Width of a mark with its distance to the next one. */
const MARK_PX = 30;

export class EventLane {
  #onSelect;
  #events = [];
  #cut = new Set();
  #window = null;
  /** The selected event, by its time, kind and words: new data may contain it again. */
  #selected = null;
  #marks = h("ul", { class: "lane", "aria-label": "Events" });
  #told = h("div", { class: "told", "aria-live": "polite" });
  element = h("div", { class: "events" }, this.#marks, this.#told);

  constructor(onSelect) {
    this.#onSelect = onSelect;
    let width = 0;
    new ResizeObserver(() => {
      if (this.#window && this.#marks.clientWidth !== width) this.show(this.#events, this.#cut, this.#window);
      width = this.#marks.clientWidth;
    }).observe(this.#marks);
  }

  isSelected(event) {
    return this.#selected?.includes(keyOf(event)) ?? false;
  }

  /** Shows events; `cut` has the kinds of which there are more. */
  show(events, cut, window) {
    [this.#events, this.#cut, this.#window] = [events, cut, window];
    const width = Math.max(1, this.#marks.clientWidth - LEFT_PX - RIGHT_PX);
    const perPx = (window.to - window.from) / width;
    const marks = clustered(
      events.filter(({ at }) => at >= window.from && at <= window.to),
      MARK_PX * perPx,
    );
    const focused = this.#marks.contains(document.activeElement) ? document.activeElement.dataset.event : null;
    this.#marks.replaceChildren(...marks.map((one) => this.#mark(one, (one.at - window.from) / perPx)));
    if (focused) [...this.#marks.querySelectorAll("button")].find((one) => one.dataset.event === focused)?.focus();
    this.#tell(marks);
  }

  #mark({ at, events }, left) {
    const kinds = new Set(events.map(({ kind }) => kind));
    // The first kind in the declaration is the most important one.
    const [, tone, shape] = KINDS[Object.keys(KINDS).find((kind) => kinds.has(kind))];
    const words = events.length === 1 ? events[0].words : count(events.length, "event");
    const isPressed = events.some((event) => this.isSelected(event));
    const button = h(
      "button",
      {
        type: "button",
        class: `event ${tone}`,
        "data-event": keyOf(events[0]),
        "aria-pressed": String(isPressed),
        "aria-label": `${words}, ${moment(at)}`,
        title: `${words}, ${moment(at)}`,
        onclick: () => this.#select(isPressed ? null : events.map(keyOf)),
      },
      shapeOf(shape),
      events.length > 1 ? h("span", {}, events.length) : null,
    );
    const item = h("li", {}, button);
    item.style.insetInlineStart = `${LEFT_PX + left}px`;
    return item;
  }

  #select(keys) {
    this.#selected = keys;
    this.show(this.#events, this.#cut, this.#window);
    this.#onSelect();
  }

  /** The selected events, or how to select one. */
  #tell(marks) {
    const chosen = this.#events.filter((event) => this.isSelected(event));
    const next = chosen.length
      ? h("ul", {}, chosen.map(item))
      : h(
          "p",
          { class: "hint" },
          marks.length
            ? `${count(this.#events.length, "event")}: select a mark for details. `
            : "No events in this range. ",
          leftOut(this.#cut),
        );
    if (this.#told.textContent !== next.textContent) this.#told.replaceChildren(next);
  }
}

const keyOf = ({ at, kind, words }) => `${at} ${kind} ${words}`;

function item({ at, kind, words, href, to }) {
  const [, tone, shape] = KINDS[kind];
  return h(
    "li",
    {},
    mark(words, tone, shape),
    " ",
    time(new Date(at).toISOString()),
    href ? [" ", h("a", { href }, to)] : null,
  );
}
