// The page: shows the view of its address, and keeps it up to date.

import { pathOf } from "./address.js";
import { learn } from "./api.js";
import { h, morphChildren } from "./dom.js";
import { Live } from "./live.js";
import { mark } from "./marks.js";
import { navigation, startMenu } from "./menu.js";
import { problemPanel, report } from "./notices.js";
import { heard, isOn as isNotifying, startNotifications, tellSignedOut } from "./notify.js";
import { openAlarms } from "./parts/alarm-count.js";
import { badge, forget, identify, isKnown, isSession } from "./rights.js";
import { find } from "./router.js";
import { offersSignIn, signInForm, signOut, token } from "./session.js";
import { startShortcuts } from "./shortcuts.js";
import { offerTour, startTour } from "./tour.js";
import { showZoneChoice } from "./zone-choice.js";
import { onZone } from "./zone.js";

const main = document.getElementById("main");
/** States of the connection: a word, tone and shape, and what else there is room for on a wide screen. */
const STATES = {
  live: ["live", "good", "circle", ""],
  polling: ["live", "good", "circle", ", polled every 2 seconds"],
  reconnecting: ["reconnecting", "warn", "dots", ""],
  offline: ["offline", "bad", "gap", ": the page may be outdated"],
};

/** Interval at which a page out of sight asks for the number in its title. */
const TITLE_MS = 60_000;

/** Open alarms, null while their number is unknown. */
let alarms = null;

/** The present view; its number reveals answers that came too late. */
let shown = { number: 0, page: null, parts: null };
let isLoading = false;
let isDirty = false;

const live = new Live(
  () => refresh(),
  (state) => {
    const [words, tone, shape, more] = STATES[state];
    const told = mark(words, tone, shape);
    if (more) told.append(h("span", { class: "wide-only" }, more));
    document.getElementById("connection").replaceChildren(told);
  },
  heard,
);

/** Whether the page of an address is shown, in whatever state (search, order). */
const isShown = (address) => main.dataset.address !== undefined && pathOf(main.dataset.address) === pathOf(address);

async function show(isNavigation) {
  // The browser's address can be the next page's when the answer comes, before the event that tells its change.
  const address = location.hash;
  const { page, parts, state } = find(address);
  const number = isNavigation ? shown.number + 1 : shown.number;
  if (isNavigation) {
    shown = { number, page, parts };
    showAlarms(address);
    if (!isShown(address)) main.setAttribute("aria-busy", "true");
  }
  let content;
  try {
    await Promise.all([learn(), identify()]);
    const [data, open] = await Promise.all([page.load(parts, state), openAlarms()]);
    // One failed answer does not mean that there are none.
    alarms = open ?? alarms;
    upToDate();
    content = page.view(data, parts, refresh);
    live.told(true);
  } catch (problem) {
    if (number !== shown.number) return;
    live.told(!problem.isSilence);
    content = await failed(problem, isNavigation);
  }
  if (number === shown.number && content) put(content, address);
}

async function failed(problem, isNavigation) {
  if (problem.status === 401) {
    live.stop();
    tellSignedOut();
    const wasKnown = isKnown();
    forget();
    return signInForm(problem, { isOffered: await offersSignIn(), wasKnown }, start);
  }
  if (problem.status === undefined) console.error(problem);
  // Keep the view while the service does not answer: the connection's state is shown. It may hold what somebody types.
  if (!isNavigation && problem.isSilence) return null;
  if (!isNavigation && problem.isPassing) return outdated(problem);
  return [h("h1", { tabindex: "-1" }, "Cannot show this page"), problemPanel(problem, () => show(true))];
}

/** The message that the view is outdated, while it is. */
let outdatedNotice = null;

function outdated(problem) {
  outdatedNotice ??= report();
  outdatedNotice(`The page may be outdated: ${problem.message}`, "warn", false);
}

function upToDate() {
  outdatedNotice?.("The page is up to date again.", "good", true);
  outdatedNotice = null;
}

/** Shows the menu of an address with the number of open alarms. */
function showAlarms(address) {
  morphChildren(document.getElementById("nav"), h("nav", {}, navigation(address, alarms)));
  const count = document.getElementById("menu-count");
  count.hidden = !alarms;
  count.textContent = alarms ? alarms.toLocaleString("en") : "";
}

function showTitle() {
  const heading = main.querySelector("h1")?.textContent ?? "";
  document.title = `${alarms ? `(${alarms.toLocaleString("en")}) ` : ""}${heading} \u2013 vibrissa`;
}

function put(content, address) {
  const next = h("main", {}, content);
  const isSameAddress = isShown(address);
  const hadFocus = main.contains(document.activeElement);
  if (isSameAddress) morphChildren(main, next);
  else main.replaceChildren(...next.childNodes);
  main.removeAttribute("aria-busy");
  const heading = main.querySelector("h1");
  showTitle();
  showAlarms(address);
  document.getElementById("user").replaceChildren(...badge());
  document.getElementById("sign-out").hidden = token() === null && !isSession();
  // After a link, focus the heading, so that screen readers announce the new page. The first page has no predecessor. A refresh
  // may show the new page first.
  if (!isSameAddress && main.dataset.address !== undefined) {
    heading?.focus({ preventScroll: true });
    scrollTo(0, 0);
  } else if (hadFocus && !main.contains(document.activeElement)) {
    // The focused element has disappeared.
    heading?.focus({ preventScroll: true });
  }
  main.dataset.address = address;
  main.dataset.shows = String(Number(main.dataset.shows ?? 0) + 1);
}

async function refresh() {
  if (isLoading) {
    isDirty = true;
    return;
  }
  isLoading = true;
  await show(false).finally(() => (isLoading = false));
  if (isDirty) {
    isDirty = false;
    refresh();
  }
}

async function start() {
  forget();
  alarms = null;
  await show(true);
  live.start();
  if (isKnown()) offerTour();
}

const pageOf = (url) => pathOf(new URL(url).hash);

document.getElementById("sign-out").addEventListener("click", async () => {
  let place;
  try {
    place = await signOut(isSession());
  } catch (problem) {
    report()(`You are still signed in: ${problem.message}. Sign out again.`, "bad", true);
    return;
  }
  document.getElementById("notices").replaceChildren();
  document.querySelector("dialog")?.close();
  // Otherwise the next person at this browser would be signed in again without a password.
  if (place) location.assign(place);
  else start();
});
// The fragment of the address selects the view, so the skip link must not change it.
document.getElementById("skip").addEventListener("click", (event) => {
  event.preventDefault();
  main.focus();
});
addEventListener("hashchange", ({ oldURL, newURL }) => {
  // A dialog belongs to the page on which it was opened. A search or a filter changes the address but not the page.
  if (pageOf(oldURL) !== pageOf(newURL)) document.querySelector("dialog")?.close();
  show(true);
});
startNotifications(document.getElementById("notifications"));
startTour(document.getElementById("tour-button"));
startMenu(document.getElementById("menu"));
startShortcuts(document.getElementById("shortcuts"));
showZoneChoice(document.getElementById("zone"));
onZone(() => refresh());
// Drawings fit the width of the window. The height changes whenever a phone hides its address bar.
let [width, resizing] = [innerWidth, 0];
addEventListener("resize", () => {
  if (innerWidth === width) return;
  width = innerWidth;
  clearTimeout(resizing);
  resizing = setTimeout(refresh, 200);
});
addEventListener("online", () => live.hurry());
document.addEventListener("visibilitychange", () => {
  if (!document.hidden) live.hurry();
  else if (!isNotifying()) live.rest();
});
// Out of sight the title is all that people see of the page.
setInterval(async () => {
  if (!document.hidden || !isKnown()) return;
  alarms = (await openAlarms().catch(() => null)) ?? alarms;
  showTitle();
}, TITLE_MS);
start();
