// All fleets, what needs attention first.

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
            "No fleet is known yet. A fleet appears when the service is told to supervise it, with --fleet.",
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

/** Who looks after a fleet. */
export function supervision(fleet) {
  return fleet.supervised
    ? mark(`supervised by ${fleet.holder ?? "somebody"}`, "good", "circle")
    : mark("nobody supervises it now", "bad", "gap");
}

/** The counts that call for attention, in words; the same for fleets and robots. */
export function health(row) {
  const marks = [
    row.whiskers_uncompensated && mark(`${row.whiskers_uncompensated} trimmed and not served`, "bad", "cross"),
    row.whiskers_faulty && mark(count(row.whiskers_faulty, "faulty whisker"), "bad", "cross"),
    row.whiskers_trimmed && mark(`${row.whiskers_trimmed} trimmed`, "warn", "stump"),
    row.proposals && mark(`${count(row.proposals, "proposal")} to answer`, "warn", "diamond"),
    row.alarms && mark(count(row.alarms, "alarm"), "bad", "bell"),
  ].filter(Boolean);
  return marks.length ? marks : [mark("nothing needs attention", "good", "circle")];
}
