// State of a page in its address: `#/fleets/lab?q=crawler&sort=robot`. A reload, a bookmark and the back button keep
// search, filters, order and page.

/** Path and state of an address, both as texts without `#`. */
function split(hash) {
  const text = hash.replace(/^#/, "");
  const mark = text.indexOf("?");
  return mark < 0 ? [text, ""] : [text.slice(0, mark), text.slice(mark + 1)];
}

/** The path of an address: it names the page. */
export const pathOf = (hash) => split(hash)[0];

/** The state of an address: an object of texts. */
export const stateOf = (hash) => Object.fromEntries(new URLSearchParams(split(hash)[1]));

/** An address with a state; empty values are left out. */
export function address(path, state) {
  const told = Object.entries(state).filter(([, value]) => value !== undefined && value !== null && value !== "");
  const query = new URLSearchParams(told).toString();
  return `#${path}${query ? `?${query}` : ""}`;
}

/** The present address with changes of its state. */
export const changed = (changes) => address(pathOf(location.hash), { ...stateOf(location.hash), ...changes });

/** Changes the state of the present address without a new entry in the browser's history. */
export function change(changes) {
  const next = changed(changes);
  if (next !== location.hash) location.replace(next);
}
