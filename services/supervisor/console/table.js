// Tables with a caption and with headers tied to their cells; wide ones scroll in a box.

import { h } from "./dom.js";

/**
 * A table. `columns` are `{ name, cell(row), numeric, head }`; a row's `head` cell names it. `heading` of a column,
 * `{ content, order }`, replaces its name. Without rows, `empty` is shown instead.
 */
export function table({ caption, columns, rows, empty, key }) {
  if (!rows.length) return h("p", { class: "empty" }, empty);
  const heading = ({ name, numeric, heading: told }) =>
    h("th", { scope: "col", class: numeric ? "number" : null, "aria-sort": told?.order }, told?.content ?? name);
  const cell = (column, row) => {
    const attributes = { class: column.numeric ? "number" : null };
    return column.head
      ? h("th", { scope: "row", ...attributes }, column.cell(row))
      : h("td", attributes, column.cell(row));
  };
  const line = (row) =>
    h(
      "tr",
      { "data-key": key ? key(row) : null },
      columns.map((column) => cell(column, row)),
    );
  // The box can be focused, so that the keyboard can scroll it.
  return h(
    "div",
    { class: "scroll", role: "region", "aria-label": caption, tabindex: "0" },
    h(
      "table",
      {},
      h("caption", {}, caption),
      h("thead", {}, h("tr", {}, columns.map(heading))),
      h("tbody", {}, rows.map(line)),
    ),
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
