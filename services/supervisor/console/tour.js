// The tour of three steps: the board, the story of the worst whisker, and its decision. It is offered once in a demo and on
// an installation that is still empty or learns its first robots, and each browser remembers its step.

import { get, has, list } from "./api.js";
import { h } from "./dom.js";
import { link } from "./places.js";

const KEY = "vibrissa-tour";
const ENDED = "ended";
/** Most robots of an installation in its first minutes. */
const FEW = 10;

/** Steps: title, words, words of the button, and the address to which it leads; null if there is nothing to show yet. */
const STEPS = [
  {
    title: "The board",
    words:
      "Each tile is a robot, and its letter and colour tell its worst state. Beside the tiles are the worst whiskers with how much is lost.",
    next: "Show the worst whisker",
    async find() {
      const { whiskers } = await get("/v1/board");
      // A fault alone leads to no decision.
      const worst = whiskers.find((one) => one.condition === "TRIMMED") ?? whiskers[0];
      return worst ? link.whisker(worst) : null;
    },
    missing: "No whisker is cut or faulty yet. In a demo, open a robot and cut one; then go on.",
  },
  {
    title: "Its story",
    words:
      "The sentence below the name tells when it was cut, how that was found, and how well it reads now. Below it is what happened, the newest first.",
    next: "Show its decision",
    async find() {
      const of = /^#\/fleets\/([^/]+)\/robots\/([^/]+)\/arrays\/([^/]+)\/whiskers\/(\d+)/.exec(location.hash);
      const [fleet, robot, array, whisker] = (of ?? []).slice(1).map(decodeURIComponent);
      const own = of ? await list("/v1/compensations", { fleet, robot, array, target_whisker: whisker, limit: 1 }) : [];
      const [newest] = own.length ? own : await list("/v1/compensations", { limit: 1 });
      return newest ? link.compensation(newest.compensation_id) : null;
    },
    missing: "Nothing was decided yet. A decision follows some seconds after a cut.",
  },
  {
    title: "Its decision",
    words:
      "It says what changes for the robot, how sure the prediction is, and which alternatives were refused and why. A change that was made can be undone here.",
    next: "End the tour",
  },
];

const stored = () => {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return ENDED;
  }
};

function store(value) {
  try {
    localStorage.setItem(KEY, value);
  } catch {
    // A browser that stores nothing is offered no tour.
  }
}

const place = () => document.getElementById("tour");

function end() {
  store(ENDED);
  const hadFocus = place().contains(document.activeElement);
  place().hidden = true;
  place().replaceChildren();
  if (hadFocus) document.getElementById("main").focus();
}

/** Leads to the next step, or says that there is nothing to show yet. */
async function go(number) {
  const step = STEPS[number];
  if (!step.find) return end();
  const address = await step.find().catch(() => null);
  if (address === null) return show(number, step.missing);
  show(number + 1);
  location.hash = address;
}

function show(number, note = null) {
  const { title, words, next } = STEPS[number];
  const isLast = number === STEPS.length - 1;
  store(String(number));
  place().hidden = false;
  const parts = [
    h("p", {}, h("strong", {}, `${title} `), h("small", {}, `step ${number + 1} of ${STEPS.length}`)),
    h("p", {}, words),
    note ? h("p", { class: "missing" }, note) : null,
    h(
      "div",
      { class: "buttons" },
      h("button", { type: "button", class: "primary", onclick: () => go(number) }, next),
      isLast ? null : h("button", { type: "button", class: "quiet", onclick: end }, "End the tour"),
    ),
  ];
  place().replaceChildren(...parts.filter(Boolean));
}

/** Whether it is a demo, or an installation in its first minutes. */
async function isNew() {
  if (has("POST", "/demo/incidents")) return true;
  if (!has("GET", "/v1/board")) return false;
  const states = (await get("/v1/board")).groups.flatMap((group) => Object.entries(group.states));
  const robots = states.reduce((sum, [, many]) => sum + many, 0);
  return robots <= FEW && states.every(([state, many]) => state === "LEARNING" || many === 0);
}

/** Goes on with a tour that this browser has begun, or begins one on the board of a new installation. */
export async function offerTour() {
  const step = stored();
  if (step === ENDED) return;
  if (step !== null) show(Math.min(Number(step) || 0, STEPS.length - 1));
  else if (/^(#\/?(fleets)?)?$/.test(location.hash) && (await isNew().catch(() => false))) show(0);
}

/** Makes the button that begins the tour, and Escape, which ends it unless it closes something else. */
export function startTour(button) {
  button.addEventListener("click", () => {
    location.hash = link.fleets();
    show(0);
    scrollTo(0, 0);
    place().querySelector("button").focus();
  });
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || event.defaultPrevented || place().hidden) return;
    if (!document.querySelector('dialog[open], details.menu[open], #menu[aria-expanded="true"]')) end();
  });
}
