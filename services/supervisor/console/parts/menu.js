// A button that opens a menu of further buttons, so that a page shows one action and not ten.

import { h } from "../dom.js";

/** A menu of buttons; null without any. `key` tells the menus of a page apart. */
export function menu(words, buttons, key = words) {
  const items = buttons.filter(Boolean);
  if (!items.length) return null;
  return h(
    "details",
    { class: "menu", "data-key": `menu-${key}` },
    h("summary", { class: "button" }, words),
    h("div", { class: "items" }, items),
  );
}

/** The first button as it is, and a menu of the others. */
export const firstAndMenu = ([first, ...others], words = "More") =>
  first ? h("div", { class: "buttons" }, first, others.length === 1 ? others : menu(words, others)) : null;
