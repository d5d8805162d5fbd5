// The first page: how all robots are, in one look.

import { list } from "../api.js";
import { h } from "../dom.js";
import { count } from "../format.js";
import { mark } from "../marks.js";
import { board, boardOf, boardTools, verdict } from "../parts/board.js";
import { proposals, proposalsOf } from "../parts/proposals.js";
import { readiness, shortcomings } from "../parts/readiness.js";
import { empty } from "../table.js";

/** Most fleets without a supervisor that are named above the board. */
const LEFT_MAX = 5;

export default {
  async load(_, state) {
    const [fleets, waiting, told, ready] = await Promise.all([
      list("/v1/fleets", { sort: "attention", order: "descending" }),
      proposalsOf({}),
      boardOf(state),
      readiness(),
    ]);
    return { fleets, waiting, told, ready, isPart: Boolean(state.label || state.q) };
  },

  view({ fleets, waiting, told, ready, isPart }, _, refresh) {
    const left = fleets.filter((fleet) => !fleet.supervised);
    const of = new Map(fleets.map((fleet) => [fleet.fleet, fleet]));
    return [
      h(
        "div",
        { class: "headline" },
        h("h1", { tabindex: "-1" }, "Fleets"),
        fleets.length ? h("p", { class: "summary" }, summary(fleets, told, isPart)) : null,
        fleets.length ? boardTools(told) : null,
      ),
      shortcomings(ready),
      left.length
        ? h(
            "p",
            { class: "marks" },
            left.slice(0, LEFT_MAX).map((fleet) => mark(`no supervisor of ${fleet.fleet}`, "bad", "gap")),
          )
        : null,
      proposals(waiting, refresh),
      fleets.length
        ? board(told, { more: (group) => (of.get(group)?.supervised === false ? supervision(of.get(group)) : null) })
        : empty("No fleet is known yet. Start the service with --fleet and a name, and let a robot connect."),
    ];
  },
};

function summary(fleets, told, isPart) {
  const sum = (name) => fleets.reduce((sum, fleet) => sum + fleet[name], 0);
  const [alarms, shelved] = [sum("alarms"), sum("alarms_shelved")];
  const open = alarms ? ` ${count(alarms, "alarm")} open` : " No alarms are open";
  // The numbers of alarms are those of all robots.
  const where = isPart && told ? " in all" : "";
  return `${told ? verdict(told, isPart) : ""}${open}${shelved ? `, ${count(shelved, "alarm")} shelved` : ""}${where}.`;
}

/** Whether whiskers are out of order, although perhaps no alarm says so any more. */
const isTroubled = (row) => row.whiskers_uncompensated > 0 || row.whiskers_faulty > 0;

/** How many robots are there, in words. */
export const present = (fleet) =>
  `${count(fleet.robots, "robot")}, ${fleet.robots_online} online${fleet.robots_silent ? `, ${fleet.robots_silent} silent` : ""}`;

/** The mark for a fleet's supervisor. */
export function supervision(fleet) {
  return fleet.supervised
    ? mark(`supervised by ${fleet.holder ?? "an unnamed supervisor"}`, "good", "circle")
    : mark("no supervisor now", "bad", "gap");
}

/** Marks for what waits for people. */
export const waits = (row) =>
  [
    row.proposals && mark(`${count(row.proposals, "proposal")} waiting for approval`, "warn", "diamond"),
    row.alarms && mark(count(row.alarms, "alarm"), "bad", "bell"),
    row.alarms_shelved && mark(`${count(row.alarms_shelved, "alarm")} shelved`, "off", "clock"),
  ].filter(Boolean);

/** Marks for the whiskers of a robot by state, each whisker in one of them, and for what waits for people. */
export function health(row) {
  const marks = [
    row.whiskers_uncompensated && mark(`${row.whiskers_uncompensated} trimmed, not compensated`, "bad", "stump"),
    // The whiskers of a silent robot have no fault of their own.
    row.whiskers_faulty && row.connection !== "SILENT" && mark(count(row.whiskers_faulty, "faulty whisker"), "bad", "cross"),
    row.whiskers_compensated && mark(`${row.whiskers_compensated} trimmed, compensated`, "info", "propped"),
    row.whiskers_worn && mark(`${row.whiskers_worn} worn or suspected`, "warn", "slope"),
    row.whiskers_learning && mark(`${row.whiskers_learning} being learned`, "info", "dots"),
    ...waits(row),
  ].filter(Boolean);
  if (row.attention > 0 || isTroubled(row) || row.alarms_shelved) return marks;
  if (isAway(row)) return marks.length ? marks : [mark("nothing is known while it is not connected", "off", "gap")];
  return [...marks, mark("nothing needs attention", "good", "circle")];
}

/** Whether it is a robot that is not connected, of whose present state nothing is known. */
const isAway = (row) => row.connection !== undefined && row.connection !== "ONLINE";
