// Tabs of a page: links that change the address, so that a reload and a link to somebody else show the same tab.

import { changed } from "../address.js";
import { h } from "../dom.js";

/**
 * The tabs `[[name, words]]`; the first one is the default. `cleared` are parts of the address that another tab does
 * not need.
 */
export function tabs(label, all, current, cleared = []) {
  const without = Object.fromEntries(cleared.map((name) => [name, null]));
  const item = ([name, words]) =>
    h(
      "li",
      {},
      h(
        "a",
        {
          href: changed({ ...without, tab: name === all[0][0] ? null : name }),
          "aria-current": name === current ? "true" : null,
        },
        words,
      ),
    );
  return h("nav", { class: "tabs", "aria-label": label }, h("ul", {}, all.map(item)));
}
