// Keyboard shortcuts: single keys, or `g` and a second key for a page. They can be switched off, because speech input and
// slips of a finger may press single keys.

import { h } from "./dom.js";
import { BY_KEY } from "./menu.js";

const KEY = "vibrissa-shortcuts";
/** Time within which the second key must follow. */
const PAIR_MS = 1_500;

const isOn = () => {
  try {
    return localStorage.getItem(KEY) !== "off";
  } catch {
    return true;
  }
};

function switchTo(on) {
  try {
    localStorage.setItem(KEY, on ? "on" : "off");
  } catch {
    // A browser that stores nothing keeps them on.
  }
}

const isTyping = (element) =>
  element.matches?.("input:not([type=checkbox]), select, textarea") || element.isContentEditable;

let begunAt = -Infinity;

/** Handles a key; it does nothing while somebody types, in a dialog, or with Ctrl, Alt or Meta. */
function pressed(event) {
  const { key, target } = event;
  if (key === "Escape" && target.id === "search") {
    // The browser would empty the field.
    event.preventDefault();
    return void target.blur();
  }
  if (event.ctrlKey || event.altKey || event.metaKey || event.isComposing || event.defaultPrevented) return;
  if (!isOn() || isTyping(target) || document.querySelector("dialog[open]")) return;
  const isSecond = event.timeStamp - begunAt < PAIR_MS;
  begunAt = -Infinity;
  if (isSecond && BY_KEY[key]) location.hash = BY_KEY[key][1];
  else if (key === "g") begunAt = event.timeStamp;
  else if (key === "?") showShortcuts();
  else if (key === "/" && document.getElementById("search")) document.getElementById("search").focus();
  else return;
  event.preventDefault();
}

/** Shows the list of shortcuts in a dialog. */
export function showShortcuts() {
  const keys = (...names) => names.map((name) => [h("kbd", {}, name), " "]);
  const row = ([told, words]) => h("div", {}, h("dt", {}, told), h("dd", {}, words));
  const rows = [
    [keys("?"), "Show this list"],
    [keys("/"), "Search in the table of the page"],
    ...Object.entries(BY_KEY).map(([key, [words]]) => [keys("g", key), words]),
    [keys("Esc"), "Leave the search, close a dialog or a menu, end the tour"],
  ];
  const dialog = h(
    "dialog",
    { "aria-labelledby": "shortcuts-title", onclose: () => dialog.remove() },
    h("h2", { id: "shortcuts-title" }, "Keyboard shortcuts"),
    h("dl", { class: "shortcuts" }, rows.map(row)),
    h(
      "label",
      { class: "check" },
      h("input", { type: "checkbox", checked: isOn(), onchange: (event) => switchTo(event.target.checked) }),
      " Use keyboard shortcuts",
    ),
    h("div", { class: "buttons" }, h("button", { type: "button", onclick: () => dialog.close() }, "Close")),
  );
  document.body.append(dialog);
  dialog.showModal();
}

/** Begins to listen to the keyboard, and to the button that shows the list. */
export function startShortcuts(button) {
  document.addEventListener("keydown", pressed);
  button.addEventListener("click", showShortcuts);
}
