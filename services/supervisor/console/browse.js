// A table of one list of the API with search, filters, order and pages. The address holds all of them, and the service
// does the work, so that a page costs the same for ten rows and for ten thousand.

import { change, changed, pathOf, stateOf } from "./address.js";
import { get } from "./api.js";
import { h } from "./dom.js";
import { csvLink } from "./save.js";
import { table } from "./table.js";
import { savedViews } from "./views.js";
import { fromField, toField } from "./zone.js";

/** Rows of a page. */
const ROWS = 50;
/** Time without typing after which a search starts. */
const TYPING_MS = 300;

/** The route and the parameters of each page that is shown, for its rows as a file. */
const ASKED = new WeakMap();

/**
 * A list of the API as a table: `{ route, what, filters, search, rows }`. `what` names the rows in the plural,
 * `filters` are `{ name, label, options: [[value, words]] }` with the API's parameter as name, or `{ name, label, text: true }`
 * for a text, with `suggestions` of it, and `clean` to normalise it, or `{ name, label, time: true }` for a time; `clears` names
 * filters that a choice replaces; `empty` names the choice of no filter. And `search` is the hint
 * of the search field, or null without one. A column of the table with `sort` (the API's sort key) can order it;
 * `descends` makes the greatest value first at the first click.
 */
export function browser({ route, what, filters = [], search = null, rows = ROWS }) {
  const known = [...filters.map(({ name }) => name), "q", "sort", "order", "cursor"];

  return {
    /** Reads the page that the address asks for; `fixed` are parameters that the page itself sets. */
    async load(state, fixed = {}) {
      const asked = Object.fromEntries(Object.entries(state).filter(([name]) => known.includes(name)));
      const query = { limit: rows, ...asked, ...fixed };
      const page = await get(route, query);
      ASKED.set(page, [route, query]);
      return page;
    },

    /** The tools, the table (or `body` for rows that are no table), and the links to other pages of the list. The page is one of `load`. */
    view(page, { caption, columns, key, empty, body = null }) {
      const state = stateOf(location.hash);
      const isNarrowed = [...filters.map(({ name }) => name), "q"].some((name) => state[name]);
      const nothing = isNarrowed ? `No ${what} match.` : empty;
      return [
        tools(page, state, isNarrowed),
        body && page.items.length
          ? body
          : table({
              caption,
              columns: (columns ?? []).map((column) => ({ ...column, heading: column.sort && heading(column, state) })),
              rows: page.items,
              key,
              empty: state.cursor ? `No more ${what}.` : nothing,
            }),
        pager(page, state),
      ];
    },
  };

  function tools(page, state, isNarrowed) {
    return h(
      "form",
      { class: "tools", role: "search", "aria-label": `Find ${what}`, onsubmit: (event) => event.preventDefault() },
      search === null ? null : searchField(state),
      filters.map((filter) => (filter.time ? timeField(filter, state) : filter.text ? textField(filter, state) : choice(filter, state))),
      isNarrowed
        ? h("a", { href: changed(Object.fromEntries(known.map((name) => [name, null]))) }, "Show all")
        : null,
      page.items.length ? csvLink(...ASKED.get(page)) : null,
      savedViews(),
    );
  }

  function searchField(state) {
    let typing = 0;
    const start = (event) => {
      const q = event.target.value.trim();
      clearTimeout(typing);
      const path = pathOf(location.hash);
      typing = setTimeout(() => pathOf(location.hash) === path && change({ q, cursor: null }), TYPING_MS);
    };
    return h(
      "label",
      { class: "tool" },
      h("span", {}, "Search"),
      h("input", {
        id: "search",
        type: "search",
        name: "q",
        maxlength: 100,
        placeholder: search,
        value: state.q ?? "",
        "data-of-address": true,
        oninput: start,
      }),
    );
  }

  /** A field for a text that must match exactly. */
  function textField({ name, label, maxlength = 64, placeholder, title, suggestions, clean }, state) {
    const told = (text) => (clean ? clean(text) : text.trim());
    const choose = (event) => change({ [name]: told(event.target.value), cursor: null });
    const id = `filter-${name}`;
    const listed = suggestions ? `${id}-suggestions` : null;
    const value = state[name] ?? "";
    const attributes = { id, name, maxlength, placeholder, title, list: listed, value, "data-of-address": true };
    return h(
      "label",
      { class: "tool" },
      h("span", {}, label),
      h("input", { ...attributes, onchange: choose }),
      suggestions ? h("datalist", { id: listed }, suggestions.map((value) => h("option", { value }))) : null,
    );
  }

  /** A field for a date and a time in the console's time zone; the address has them in UTC. */
  function timeField({ name, label }, state) {
    const told = (text) => (text ? new Date(fromField(text)).toISOString() : null);
    const choose = (event) => change({ [name]: told(event.target.value), since: null, cursor: null });
    const at = Date.parse(state[name]);
    const value = Number.isFinite(at) ? toField(at) : "";
    return h(
      "label",
      { class: "tool" },
      h("span", {}, label),
      h("input", { type: "datetime-local", id: `filter-${name}`, name, value, "data-of-address": true, onchange: choose }),
    );
  }

  function choice({ name, label, options, empty = "all", clears = [] }, state) {
    const option = ([value, words]) => h("option", { value, selected: (state[name] ?? "") === value }, words);
    const cleared = Object.fromEntries(clears.map((other) => [other, null]));
    const choose = (event) => change({ ...cleared, [name]: event.target.value, cursor: null });
    return h(
      "label",
      { class: "tool" },
      h("span", {}, label),
      h(
        "select",
        { id: `filter-${name}`, name, "data-of-address": true, onchange: choose },
        [["", empty], ...options].map(option),
      ),
    );
  }

  function pager(page, state) {
    if (!page.next_cursor && !state.cursor) return null;
    return h(
      "nav",
      { class: "pager", "aria-label": `Pages of ${what}` },
      state.cursor ? h("a", { href: changed({ cursor: null }) }, "First page") : null,
      page.next_cursor ? h("a", { href: changed({ cursor: page.next_cursor }) }, "Next page") : null,
    );
  }
}

/** The heading of a column as a link that sorts by it, or turns its order round. */
function heading({ name, sort, descends = false, isDefault = false }, state) {
  const isSorting = state.sort ? state.sort === sort : isDefault;
  const isDescending = isSorting && (state.order ? state.order === "descending" : descends);
  const next = isSorting ? !isDescending : descends;
  const order = next ? "descending" : "ascending";
  const arrow = isDescending ? "\u25be" : "\u25b4";
  return {
    order: isSorting ? (isDescending ? "descending" : "ascending") : null,
    content: h(
      "a",
      { href: changed({ sort, order, cursor: null }) },
      name,
      isSorting ? h("span", { "aria-hidden": "true" }, `\u00a0${arrow}`) : null,
    ),
  };
}

/** Options of a filter from words of the API: `{ WORD: "label" }` or `{ WORD: ["label", ...] }`. */
export function optionsOf(words) {
  return Object.entries(words).map(([word, told]) => [word, Array.isArray(told) ? told[0] : told]);
}
