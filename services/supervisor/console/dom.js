// Elements without a framework: created from values, and morphed into new ones, so that the page keeps its focus,
// scroll position and open parts when new data arrive.

const SVG = "http://www.w3.org/2000/svg";
const HANDLERS = Symbol("handlers");

/** An HTML element: `h("a", { href, onclick }, "text", [more])`. Null, false and undefined are omitted. */
export function h(name, properties, ...children) {
  return fill(document.createElement(name), properties, children);
}

/** An SVG element. */
export function s(name, properties, ...children) {
  return fill(document.createElementNS(SVG, name), properties, children);
}

function fill(element, properties, children) {
  for (const [name, value] of Object.entries(properties ?? {})) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") listen(element, name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  append(element, children);
  return element;
}

function append(element, children) {
  for (const child of children) {
    if (child === null || child === undefined || child === false) continue;
    if (Array.isArray(child)) append(element, child);
    else element.append(child instanceof Node ? child : String(child));
  }
}

function listen(element, type, handler) {
  element[HANDLERS] ??= {};
  const known = type in element[HANDLERS];
  element[HANDLERS][type] = handler;
  // The handler is looked up at the time of the event, because `morph` replaces it.
  if (!known) element.addEventListener(type, (event) => element[HANDLERS][type]?.call(element, event));
}

/**
 * Turns the children of `old` into those of `next`, changing only differences. Children that have disappeared go first: otherwise
 * all later ones would be moved or made anew, and lose the focus and what somebody types.
 */
export function morphChildren(old, next) {
  const all = [...next.childNodes];
  const keys = new Set(all.map(keyOf));
  const kept = new Map();
  for (const child of [...old.children]) {
    if (!keyOf(child)) continue;
    if (keys.has(keyOf(child))) kept.set(keyOf(child), child);
    else child.remove();
  }
  let place = old.firstChild;
  for (const [at, wanted] of all.entries()) {
    const named = kept.get(keyOf(wanted));
    while (place && !keyOf(place) && !all.slice(at).some((one) => isAlike(place, one) && classOf(place) === classOf(one))) {
      if (!named && isAlike(place, wanted)) break;
      const gone = place;
      place = place.nextSibling;
      gone.remove();
    }
    const match = named ?? (place && !keyOf(place) && isAlike(place, wanted) ? place : null);
    if (!match) {
      old.insertBefore(wanted, place);
      continue;
    }
    if (match === place) place = place.nextSibling;
    else old.insertBefore(match, place);
    morph(match, wanted);
  }
  while (place) {
    const after = place.nextSibling;
    place.remove();
    place = after;
  }
}

function keyOf(node) {
  return node.nodeType === Node.ELEMENT_NODE ? node.id || node.getAttribute("data-key") : null;
}

const classOf = (node) => (node.nodeType === Node.ELEMENT_NODE ? node.getAttribute("class") : null);

function isAlike(one, other) {
  return one.nodeName === other.nodeName && !keyOf(other);
}

function morph(old, next) {
  if (old.nodeName !== next.nodeName) return void old.replaceWith(next);
  if (old.nodeType !== Node.ELEMENT_NODE) {
    if (old.data !== next.data) old.data = next.data;
    return;
  }
  // A part that somebody has opened stays open.
  const own = old.nodeName === "DETAILS" ? ["open"] : [];
  for (const { name } of [...old.attributes]) {
    if (!next.hasAttribute(name) && !own.includes(name)) old.removeAttribute(name);
  }
  for (const { name, value } of next.attributes) {
    if (old.getAttribute(name) !== value && !own.includes(name)) old.setAttribute(name, value);
  }
  for (const [type, handler] of Object.entries(next[HANDLERS] ?? {})) listen(old, type, handler);
  // A custom element fills itself.
  if (!old.localName.includes("-")) morphChildren(old, next);
  // A field that shows the address follows it, unless somebody is typing.
  if ("ofAddress" in old.dataset && old !== document.activeElement) old.value = next.value;
}
