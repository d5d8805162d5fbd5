// Views of a list that the user has saved by name: addresses, kept in this browser.

import { pathOf } from "./address.js";
import { h } from "./dom.js";
import { report } from "./notices.js";

const KEY = "vibrissa-views";
const VIEWS_MAX = 50;
const FULL = `This browser keeps ${VIEWS_MAX} views of all pages: delete one first.`;

/** Each page has names of its own. */
const isSame = (one, other) => one.name === other.name && pathOf(one.address) === pathOf(other.address);

/** All saved views: `[{ name, address }]`. Contents that this page did not write are ignored. */
function read() {
  try {
    const told = JSON.parse(localStorage.getItem(KEY) ?? "[]");
    const isView = (one) => typeof one?.name === "string" && typeof one?.address === "string" && one.address.startsWith("#/");
    return Array.isArray(told) ? told.filter(isView).slice(0, VIEWS_MAX) : [];
  } catch {
    return [];
  }
}

/** Stores the views and shows them. A browser may refuse, for example when its storage is full. */
function write(views, list) {
  try {
    localStorage.setItem(KEY, JSON.stringify(views));
    list.replaceChildren(...items(list));
  } catch {
    list.replaceChildren(h("li", {}, "This browser stores nothing: views cannot be saved."));
  }
}

/** The saved views of this page, and a field to save the present one. */
export function savedViews() {
  const list = h("ul", { class: "views" });
  list.append(...items(list));
  const save = (event) => {
    const field = event.target.closest("details").querySelector("input");
    const name = field.value.trim();
    if (!name) return field.focus();
    const shown = event.target.closest("details").querySelector("ul");
    const view = { name, address: location.hash };
    const others = read().filter((one) => !isSame(one, view));
    // The page builds the list anew with each refresh.
    if (others.length >= VIEWS_MAX) return report()(FULL, "bad", true);
    field.value = "";
    write([...others, view], shown);
  };
  const onEnter = (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    save(event);
  };
  return h(
    "details",
    { class: "saved", "data-key": "saved-views" },
    h("summary", {}, "Saved views"),
    list,
    h("label", {}, "Name of this view ", h("input", { id: "view-name", maxlength: 60, onkeydown: onEnter })),
    h("button", { type: "button", onclick: save }, "Save this view"),
  );
}

function items(list) {
  const here = read().filter((one) => pathOf(one.address) === pathOf(location.hash));
  if (!here.length) return [h("li", { class: "hint" }, "No saved views of this page.")];
  return here.map(({ name, address }) => {
    const remove = (event) =>
      write(
        read().filter((one) => !isSame(one, { name, address })),
        event.target.closest("ul") ?? list,
      );
    return h(
      "li",
      {},
      h("a", { href: address }, name),
      h("button", { type: "button", class: "quiet", "aria-label": `Delete the view ${name}`, onclick: remove }, "Delete"),
    );
  });
}
