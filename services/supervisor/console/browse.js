// A table of one list of the API with search, filters, order and pages. The address holds all of them, and the service
// does the work, so that a page costs the same for ten rows and for ten thousand.

import { change, changed, pathOf, stateOf } from "./address.js";
import { get } from "./api.js";
import { h } from "./dom.js";
import { csvLink } from "./save.js";
import { empty as nothingHere, table } from "./table.js";
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
  const known = [...filters.map(({ name }) => name), "q", "sort", "order", "cursor", "at"];

  return {
    /** Reads the page that the address asks for; `fixed` are parameters that the page itself sets. */
    async load(state, fixed = {}) {
      const asked = Object.fromEntries(Object.entries(state).filter(([name]) => known.includes(name)));
      // The number of the first row is for people; the service knows the cursor alone.
      const query = { limit: rows, ...asked, at: undefined, ...fixed };
      const page = await get(route, query);
      ASKED.set(page, [route, query]);
      return page;
    },

    /**
     * The tools, the table (or `body` for rows that are no table), and the links to other pages of the list. The page is
     * one of `load`. Without a caption the table tells its rows, of `total` if no filter narrows them. `actions` stand
     * beside the tools.
     */
    view(page, { caption, columns, key, empty, body = null, total = null, actions = null }) {
      const state = stateOf(location.hash);
      const isNarrowed = [...filters.map(({ name }) => name), "q"].some((name) => state[name]);
      const all = changed(Object.fromEntries(known.map((name) => [name, null])));
      const nothing = isNarrowed ? nothingHere(`No ${what} match.`, [`Show all ${what}`, all]) : empty;
      return [
        tools(page, state, isNarrowed, actions),
        body && page.items.length
          ? body
          : table({
              caption: caption ?? range(page, state, isNarrowed ? null : total),
              columns: (columns ?? []).map((column) => ({ ...column, heading: column.sort && heading(column, state) })),
              rows: page.items,
              key,
              empty: state.cursor ? `No more ${what}.` : nothing,
            }),
        pager(page, state),
      ];
    },
  };

  /** Which rows the page shows, and of how many if that is known: "2,088 whiskers, 51 to 100". */
  function range({ items, next_cursor: next }, { at, cursor }, total) {
    const first = cursor ? Number(at) : 1;
    const last = first + items.length - 1;
    const all = total ?? (next ? null : last);
    const name = (many) => (many === 1 ? what.slice(0, -1) : what);
    const capital = what[0].toUpperCase() + what.slice(1);
    const many = all ? `${all.toLocaleString("en")} ${name(all)}` : capital;
    const isWhole = !cursor && !next;
    return isWhole || !first ? many : `${many}, ${first.toLocaleString("en")} to ${last.toLocaleString("en")}`;
  }

  function tools(page, state, isNarrowed, actions) {
    return h(
      "form",
      { class: "tools", role: "search", "aria-label": `Find ${what}`, onsubmit: (event) => event.preventDefault() },
      search === null ? null : searchField(state, search),
      filters.map((filter) => (filter.time ? timeField : filter.text ? textField : choiceField)(filter, state)),
      isNarrowed
        ? h("a", { href: changed(Object.fromEntries(known.map((name) => [name, null]))) }, "Show all")
        : null,
      page.items.length ? csvLink(...ASKED.get(page)) : null,
      savedViews(),
      actions,
    );
  }

  /** A field for a text that must match exactly. */
  function textField({ name, label, maxlength = 64, placeholder, title, suggestions, clean }, state) {
    const told = (text) => (clean ? clean(text) : text.trim());
    const choose = (event) => change({ [name]: told(event.target.value), cursor: null, at: null });
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
    const choose = (event) => change({ [name]: told(event.target.value), since: null, cursor: null, at: null });
    const at = Date.parse(state[name]);
    const value = Number.isFinite(at) ? toField(at) : "";
    return h(
      "label",
      { class: "tool" },
      h("span", {}, label),
      h("input", { type: "datetime-local", id: `filter-${name}`, name, value, "data-of-address": true, onchange: choose }),
    );
  }

  function pager(page, state) {
    if (!page.next_cursor && !state.cursor) return null;
    const first = state.cursor ? Number(state.at ?? 1) : 1;
    return h(
      "nav",
      { class: "pager", "aria-label": `Pages of ${what}` },
      state.cursor ? h("a", { href: changed({ cursor: null, at: null }) }, "First page") : null,
      page.next_cursor
        ? h("a", { href: changed({ cursor: page.next_cursor, at: first + page.items.length }) }, "Next page")
        : null,
    );
  }
}

/** The field that searches while somebody types. A bare one shows its hint alone. */
export function searchField(state, hint, isBare = false) {
  let typing = 0;
  const start = (event) => {
    const q = event.target.value.trim();
    clearTimeout(typing);
    const path = pathOf(location.hash);
    typing = setTimeout(() => pathOf(location.hash) === path && change({ q, cursor: null, at: null }), TYPING_MS);
  };
  return h(
    "label",
    { class: "tool" },
    h("span", { class: isBare ? "unseen" : null }, isBare ? hint : "Search"),
    h("input", {
      id: "search",
      type: "search",
      name: "q",
      maxlength: 100,
      placeholder: hint,
      value: state.q ?? "",
      "data-of-address": true,
      oninput: start,
    }),
  );
}

/** A field with the options of a filter. */
export function choiceField({ name, label, options, empty = "all", isBare = false, clears = [] }, state) {
  const option = ([value, words]) => h("option", { value, selected: (state[name] ?? "") === value }, words);
  const cleared = Object.fromEntries(clears.map((other) => [other, null]));
  const choose = (event) => change({ ...cleared, [name]: event.target.value, cursor: null, at: null });
  return h(
    "label",
    { class: "tool" },
    h("span", { class: isBare ? "unseen" : null }, label),
    h(
      "select",
      { id: `filter-${name}`, name, "data-of-address": true, onchange: choose },
      [["", empty], ...options].map(option),
    ),
  );
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
      { href: changed({ sort, order, cursor: null, at: null }) },
      name,
      isSorting ? h("span", { "aria-hidden": "true" }, `\u00a0${arrow}`) : null,
    ),
  };
}

/** The number of rows that the filters select, if the page has all of them; otherwise null. */
export const shownOf = (page, state) => (page.next_cursor || state.cursor ? null : page.items.length);

/** Options of a filter from words of the API: `{ WORD: "label" }` or `{ WORD: ["label", ...] }`. */
export function optionsOf(words) {
  return Object.entries(words).map(([word, told]) => [word, Array.isArray(told) ? told[0] : told]);
}
