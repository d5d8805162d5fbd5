// All fleets, those that need attention first.

import { list } from "../api.js";
import { h } from "../dom.js";
import { count } from "../format.js";
import { mark } from "../marks.js";
import { link } from "../places.js";
import { proposals, proposalsOf } from "../parts/proposals.js";

export default {
  async load() {
    const [fleets, waiting] = await Promise.all([
      list("/v1/fleets", { sort: "attention", order: "descending" }),
      proposalsOf({}),
    ]);
    return { fleets, waiting };
  },

  view({ fleets, waiting }, _, refresh) {
    return [
      h("h1", { tabindex: "-1" }, "Fleets"),
      h("p", { class: "summary" }, summary(fleets)),
      proposals(waiting, refresh),
      fleets.length
        ? h("ul", { class: "cards" }, fleets.map(card))
        : h(
            "p",
            { class: "empty" },
            "No fleet is known yet. Start the service with --fleet to supervise one.",
          ),
    ];
  },
};

function summary(fleets) {
  const troubled = fleets.filter((fleet) => fleet.attention > 0).length;
  if (!fleets.length) return "";
  return troubled
    ? `${count(troubled, "fleet")} of ${fleets.length} ${troubled === 1 ? "needs" : "need"} attention.`
    : "Nothing needs attention.";
}

function card(fleet) {
  return h(
    "li",
    { class: "card", "data-key": `fleet-${fleet.fleet}` },
    h("h2", {}, h("a", { href: link.fleet(fleet.fleet) }, fleet.fleet)),
    h("p", { class: "marks" }, supervision(fleet), health(fleet)),
    h(
      "p",
      {},
      `${count(fleet.robots, "robot")}, ${fleet.robots_online} online. ${count(fleet.whiskers, "whisker")[0].toUpperCase()}${count(fleet.whiskers, "whisker").slice(1)}, ${fleet.whiskers_healthy} healthy.`,
    ),
  );
}

/** The mark for a fleet's supervisor. */
export function supervision(fleet) {
  return fleet.supervised
    ? mark(`supervised by ${fleet.holder ?? "an unnamed supervisor"}`, "good", "circle")
    : mark("no supervisor now", "bad", "gap");
}

/** Marks for the counts that need attention, of a fleet or a robot. */
export function health(row) {
  const marks = [
    row.whiskers_uncompensated && mark(`${row.whiskers_uncompensated} without compensator`, "bad", "cross"),
    row.whiskers_faulty && mark(count(row.whiskers_faulty, "faulty whisker"), "bad", "cross"),
    row.whiskers_trimmed && mark(`${row.whiskers_trimmed} trimmed`, "warn", "stump"),
    row.proposals && mark(`${count(row.proposals, "proposal")} waiting for approval`, "warn", "diamond"),
    row.alarms && mark(count(row.alarms, "alarm"), "bad", "bell"),
  ].filter(Boolean);
  return marks.length ? marks : [mark("nothing needs attention", "good", "circle")];
}
