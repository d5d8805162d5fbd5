// The main pages: their words, addresses and keys, so that each page of the menu can be reached by `g` and a key.

import { pathOf } from "./address.js";
import { h } from "./dom.js";

/** Pages of the menu: words, address, first part of their addresses, and the key after `g`. */
const MAIN = [
  ["Fleets", "#/fleets", "fleets", "f"],
  ["Alarms", "#/alarms", "alarms", "a"],
  ["Timeline", "#/timeline", "timeline", "t"],
  ["Whiskers", "#/whiskers", "whiskers", "w"],
  ["Compensations", "#/compensations", "compensations", "c"],
  ["What if", "#/what-if", "what-if", "i"],
  ["Calibrations", "#/calibrations", "calibrations", "k"],
  ["Policy", "#/policy", "policy", "p"],
  ["Webhooks", "#/webhooks", "webhooks", "h"],
  ["Audit", "#/audit", "audit", "u"],
];

/** Pages that others lead to. */
const BESIDE = [
  ["Trims", "#/trims", "trims", "m"],
  ["Setpoints", "#/setpoints", "setpoints", "s"],
  ["Bulk actions", "#/bulk", "bulk", "b"],
  ["Roll-outs", "#/rollouts", "rollouts", "r"],
  ["API", "#/api", "api", "o"],
];

/** Words and address of a page by its key. */
export const BY_KEY = Object.fromEntries([...MAIN, ...BESIDE].map(([words, address, , key]) => [key, [words, address]]));

/** Links to the main pages; the present one is marked. `alarms` is the number of open alarms, null if it is unknown. */
export function navigation(hash, alarms) {
  const path = pathOf(hash);
  const first = path.replace(/^\/?/, "").split("/")[0] || "fleets";
  const current = (target, address) => (target !== first ? null : pathOf(address) === path ? "page" : "true");
  const many = (target) =>
    target === "alarms" && alarms
      ? [" ", h("span", { class: "count" }, alarms.toLocaleString("en"), h("span", { class: "unseen" }, " open"))]
      : null;
  const item = ([words, address, target]) =>
    h("li", {}, h("a", { href: address, "aria-current": current(target, address) }, words, many(target)));
  return h("ul", {}, MAIN.map(item));
}

/** The button that shows the menu on a narrow screen, and what closes the menu again. */
export function startMenu(button) {
  const open = (isOpen) => button.setAttribute("aria-expanded", String(isOpen));
  button.addEventListener("click", () => open(button.getAttribute("aria-expanded") !== "true"));
  addEventListener("hashchange", () => open(false));
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    if (button.getAttribute("aria-expanded") === "true") {
      open(false);
      button.focus();
    }
    closeMenus(null);
  });
  document.addEventListener("click", (event) => closeMenus(event.target));
}

/** Closes the open menus of buttons, except one in which something was pressed. The focus returns to the closed one. */
function closeMenus(target) {
  for (const menu of document.querySelectorAll("details.menu[open]")) {
    const isInside = target !== null && menu.contains(target);
    if (isInside && !target.closest(".items")) continue;
    if (menu.contains(document.activeElement)) menu.querySelector("summary").focus();
    menu.open = false;
  }
}
