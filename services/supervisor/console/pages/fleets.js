// All fleets, those that need attention first.

import { get, list } from "../api.js";
import { h } from "../dom.js";
import { count } from "../format.js";
import { mark } from "../marks.js";
import { link } from "../places.js";
import { hasOverview, overview, OVERVIEW } from "../parts/overview.js";
import { proposals, proposalsOf } from "../parts/proposals.js";
import { readiness, shortcomings } from "../parts/readiness.js";

export default {
  async load() {
    const [fleets, waiting, told, ready] = await Promise.all([
      list("/v1/fleets", { sort: "attention", order: "descending" }),
      proposalsOf({}),
      hasOverview() ? get(OVERVIEW) : null,
      readiness(),
    ]);
    return { fleets, waiting, told, ready };
  },

  view({ fleets, waiting, told, ready }, _, refresh) {
    return [
      h("h1", { tabindex: "-1" }, "Fleets"),
      h("p", { class: "summary" }, summary(fleets)),
      shortcomings(ready),
      proposals(waiting, refresh),
      fleets.length
        ? h("ul", { class: "cards" }, fleets.map(card))
        : h(
            "p",
            { class: "empty" },
            "No fleet is known yet. Start the service with --fleet to supervise one.",
          ),
      fleets.length ? overview(told) : null,
    ];
  },
};

function summary(fleets) {
  const troubled = fleets.filter((fleet) => fleet.attention > 0).length;
  if (!fleets.length) return "";
  const alarms = shelved(fleets.reduce((sum, fleet) => sum + fleet.alarms_shelved, 0), " ", ".");
  if (troubled) return `${count(troubled, "fleet")} of ${fleets.length} ${troubled === 1 ? "needs" : "need"} attention.`;
  return fleets.some(isTroubled) ? `No alarm waits, but not all whiskers are well.${alarms}` : `Nothing needs attention.${alarms}`;
}

/** Whether whiskers are out of order, although perhaps no alarm says so any more. */
const isTroubled = (row) => row.whiskers_uncompensated > 0 || row.whiskers_faulty > 0;

/** Words for alarms that people have shelved: what they concern is still there. */
const shelved = (alarms, before, after) => (alarms ? `${before}${count(alarms, "alarm")} ${alarms === 1 ? "is" : "are"} shelved${after}` : "");

/** How many robots are there, in words. */
export const present = (fleet) =>
  `${count(fleet.robots, "robot")}, ${fleet.robots_online} online${fleet.robots_silent ? `, ${fleet.robots_silent} silent` : ""}`;

function card(fleet) {
  return h(
    "li",
    { class: "card", "data-key": `fleet-${fleet.fleet}` },
    h("h2", {}, h("a", { href: link.fleet(fleet.fleet) }, fleet.fleet)),
    h("p", { class: "marks" }, supervision(fleet), health(fleet)),
    h(
      "p",
      {},
      `${present(fleet)}. ${count(fleet.whiskers, "whisker")[0].toUpperCase()}${count(fleet.whiskers, "whisker").slice(1)}, ${fleet.whiskers_healthy} healthy.`,
    ),
  );
}

/** The mark for a fleet's supervisor. */
export function supervision(fleet) {
  return fleet.supervised
    ? mark(`supervised by ${fleet.holder ?? "an unnamed supervisor"}`, "good", "circle")
    : mark("no supervisor now", "bad", "gap");
}

/** Marks for the whiskers of a fleet or a robot by state, each whisker in one of them, and for what waits for people. */
export function health(row) {
  const marks = [
    row.whiskers_uncompensated && mark(`${row.whiskers_uncompensated} trimmed, not compensated`, "bad", "stump"),
    row.whiskers_faulty && mark(count(row.whiskers_faulty, "faulty whisker"), "bad", "cross"),
    row.whiskers_compensated && mark(`${row.whiskers_compensated} trimmed, compensated`, "info", "propped"),
    row.whiskers_worn && mark(`${row.whiskers_worn} worn or suspected`, "warn", "slope"),
    row.whiskers_learning && mark(`${row.whiskers_learning} being learned`, "info", "dots"),
    row.proposals && mark(`${count(row.proposals, "proposal")} waiting for approval`, "warn", "diamond"),
    row.alarms && mark(count(row.alarms, "alarm"), "bad", "bell"),
    row.alarms_shelved && mark(`${count(row.alarms_shelved, "alarm")} shelved`, "off", "clock"),
  ].filter(Boolean);
  if (row.attention > 0 || isTroubled(row) || row.alarms_shelved) return marks;
  if (isAway(row)) return marks.length ? marks : [mark("nothing is known while it is not connected", "off", "gap")];
  return [...marks, mark("nothing needs attention", "good", "circle")];
}

/** Whether it is a robot that is not connected, of whose present state nothing is known. */
const isAway = (row) => row.connection !== undefined && row.connection !== "ONLINE";
