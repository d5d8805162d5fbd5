// The time zone of the console: the browser's, or one that the user has chosen. Every time, chart and field uses it.

const KEY = "vibrissa-time-zone";
/** The choice that follows the browser. */
export const BROWSER = "browser";

const zoneOfBrowser = () => new Intl.DateTimeFormat().resolvedOptions().timeZone;

function isKnown(name) {
  try {
    new Intl.DateTimeFormat("en", { timeZone: name });
    return true;
  } catch {
    return false;
  }
}

function remembered() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    // The browser forbids this page to store anything.
    return null;
  }
}

const usable = (name) => (name && isKnown(name) ? name : BROWSER);

let choice = usable(remembered());
const listeners = new Set();

/** The user's choice: `BROWSER` or an IANA name. */
export const zoneChoice = () => choice;

/** IANA name of the time zone. */
export const zone = () => (choice === BROWSER ? zoneOfBrowser() : choice);

/** Calls `listener` after each change; returns a function that ends this. */
export function onZone(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function change(next) {
  choice = next;
  listeners.forEach((listener) => listener());
}

/** Sets the time zone, and remembers it in this browser. */
export function setZone(next) {
  try {
    if (next === BROWSER) localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, next);
  } catch {
    // It then holds until the page is closed.
  }
  change(usable(next));
}

// Another tab has changed it.
addEventListener("storage", (event) => {
  if (event.key === KEY) change(usable(event.newValue));
});

/** All choices: `[value, label]`. */
export function zoneChoices() {
  const named = Intl.supportedValuesOf("timeZone").filter((name) => name !== "UTC");
  return [[BROWSER, `Browser (${zoneOfBrowser()})`], ["UTC", "UTC"], ...named.map((name) => [name, name])];
}

const formats = new Map();

/** A formatter of dates in the time zone. */
export function dateFormat(options, locale = "en-GB") {
  const key = JSON.stringify([zone(), locale, options]);
  if (!formats.has(key)) formats.set(key, new Intl.DateTimeFormat(locale, { timeZone: zone(), ...options }));
  return formats.get(key);
}

/** Short name of the time zone at a moment, such as "CET" or "GMT+9". */
export function zoneName(at) {
  const parts = dateFormat({ timeZoneName: "short" }).formatToParts(at);
  return parts.find((part) => part.type === "timeZoneName").value;
}

const FIELD = { dateStyle: "short", timeStyle: "medium" };

/** The moment in the format of a `datetime-local` field. */
export function toField(at) {
  return dateFormat(FIELD, "sv-SE").format(at).slice(0, 16).replace(" ", "T");
}

/** Difference between the zone's clock and UTC at a moment, in ms. */
function offset(at) {
  const local = dateFormat(FIELD, "sv-SE").format(at).replace(" ", "T");
  return Date.parse(`${local}Z`) - Math.floor(at / 1000) * 1000;
}

/** The moment of a `datetime-local` field, in ms since 1970. A time that a change of clocks skips becomes the next one. */
export function fromField(text) {
  const asUtc = Date.parse(`${text}Z`);
  const first = asUtc - offset(asUtc);
  const second = asUtc - offset(first);
  return toField(second) === text.slice(0, 16) ? second : Math.max(first, second);
}
