// Files of the API that the browser saves.

import { ask, has, takes, withQuery } from "./api.js";
import { h } from "./dom.js";
import { report } from "./notices.js";
import { token } from "./session.js";

/** A link that saves the answer of a path of the API under a name. */
export function saveLink(path, name, words, attributes = {}) {
  const href = path.replace(/^\//, "");
  // The browser sends no token with a plain link.
  const onclick = token() ? (event) => save(event, href, name) : null;
  return h("a", { href, download: name, onclick, ...attributes }, words);
}

async function save(event, path, name) {
  event.preventDefault();
  try {
    const href = URL.createObjectURL(await (await ask(path)).blob());
    h("a", { href, download: name }).click();
    URL.revokeObjectURL(href);
  } catch (problem) {
    report()(problem.message, "bad", true);
  }
}

/** A link that saves all rows of a list as CSV; null for a list that has no such format. */
export function csvLink(route, query) {
  if (!has("GET", route) || !takes(route, "format")) return null;
  const { cursor, limit, ...told } = query;
  const path = withQuery(route, { ...told, format: "csv" });
  const title = "All rows that the filters show, on this page and the others, as comma-separated values";
  return saveLink(path, `${route.split("/").at(-1)}.csv`, "Save as CSV", { id: "save-csv", title });
}
