// Lists of which a page shows the newest rows. They say so, and more rows are asked for through the address.

import { changed } from "../address.js";
import { h } from "../dom.js";

/** Rows that a list shows: at first, and after each request for more. A request of the API has at most 1000. */
const MANY = [20, 100, 900];

/** Number of rows that the lists of an address show. */
export const manyOf = ({ rows }) => MANY.find((many) => String(many) === rows) ?? MANY[0];

/** Number of rows to ask for: one more tells whether there are further ones. */
export const askedFor = (many) => many + 1;

/** `show(rows)` of the newest rows, and what is left out. */
export function newestOf(rows, many, show) {
  if (rows.length <= many) return show(rows);
  const next = MANY[MANY.indexOf(many) + 1];
  const more = next ? h("a", { href: changed({ rows: next }) }, `Show up to ${next}`) : null;
  return [show(rows.slice(0, many)), h("p", { class: "hint" }, `Only the newest ${many} are shown. `, more)];
}
