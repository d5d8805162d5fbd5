// Tables with a caption and with headers tied to their cells. Where a table does not fit its box, its rows become cards;
// explicit roles keep it a table for screen readers then.

import { h } from "./dom.js";

/**
 * A table. `columns` are `{ name, cell(row), numeric, head }`; a row's `head` cell names it. `heading` of a column,
 * `{ content, order }`, replaces its name; `isWide` columns need the room of two. Without rows, `empty` is shown instead.
 */
export function table({ caption, columns, rows, empty: nothing, key }) {
  if (!rows.length) return empty(nothing);
  const room = columns.reduce((sum, { isWide }) => sum + (isWide ? 2 : 1), 0);
  const heading = ({ name, numeric, heading: told }) =>
    h(
      "th",
      { scope: "col", role: "columnheader", class: numeric ? "number" : null, "aria-sort": told?.order },
      told?.content ?? name,
    );
  const cell = (column, row) => {
    const attributes = { class: column.numeric ? "number" : null, "data-name": column.name };
    return column.head
      ? h("th", { scope: "row", role: "rowheader", ...attributes }, column.cell(row))
      : h("td", { role: "cell", ...attributes }, h("span", {}, column.cell(row)));
  };
  const line = (row) =>
    h(
      "tr",
      { role: "row", "data-key": key ? key(row) : null },
      columns.map((column) => cell(column, row)),
    );
  return h(
    "div",
    { class: `table ${room < 4 ? "few" : room < 7 ? "some" : "many"}` },
    h(
      "table",
      { role: "table" },
      h("caption", {}, caption),
      h("thead", { role: "rowgroup" }, h("tr", { role: "row" }, columns.map(heading))),
      h("tbody", { role: "rowgroup" }, rows.map(line)),
    ),
  );
}

/** Words where nothing is to be shown, and `[words, address]` of a button that leads on. Elements are shown as they are. */
export function empty(told, button) {
  if (told instanceof Node) return told;
  return h(
    "div",
    { class: "nothing-here" },
    h("p", { class: "empty" }, told),
    button ? h("a", { class: "button", href: button[1] }, button[0]) : null,
  );
}

/** Facts as terms and values; null values are omitted. */
export function facts(pairs) {
  const known = pairs.filter((pair) => pair && pair[1] !== null && pair[1] !== undefined);
  return h(
    "dl",
    { class: "facts" },
    known.map(([term, value]) => h("div", {}, h("dt", {}, term), h("dd", {}, value))),
  );
}

/** A section of a page with its heading. */
export function section(title, ...children) {
  const id = `part-${title.toLowerCase().replace(/[^a-z0-9]+/g, "-")}`;
  return h("section", { "aria-labelledby": id }, h("h2", { id }, title), children);
}

/** Breadcrumbs: links to the parent pages. */
export function trail(...links) {
  const items = links.map(([words, href]) => h("li", {}, h("a", { href }, words)));
  return h("nav", { class: "trail", "aria-label": "Breadcrumbs" }, h("ol", {}, items));
}
