// The actions that people requested, and their results.

import { has } from "../api.js";
import { browser, optionsOf } from "../browse.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { markOf } from "../marks.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { bulkLink } from "../parts/bulk.js";
import { fromOf, SINCE } from "../parts/since.js";
import { link } from "../places.js";
import { ACTION_STATES, AUDIT_KINDS, say } from "../words.js";

const audit = (fleets) =>
  browser({
    route: "/v1/audit",
    what: "actions",
    search: "robot, actor, reason ...",
    filters: [
      ...fleetFilter(fleets),
      SINCE,
      { name: "kind", label: "Action", options: optionsOf(AUDIT_KINDS) },
      { name: "state", label: "Result", options: optionsOf(ACTION_STATES) },
    ],
  });

const COLUMNS = [
  {
    name: "Time",
    sort: "action_id",
    descends: true,
    isDefault: true,
    head: true,
    cell: (row) => time(row.asked_at),
  },
  { name: "Actor", cell: (row) => row.actor },
  { name: "Action", cell: (row) => [say(AUDIT_KINDS, row.kind), details(row.parameters)] },
  { name: "Subject", cell: subject },
  {
    name: "Result",
    cell: (row) =>
      h("span", { class: "marks" }, markOf(ACTION_STATES, row.state), row.problem ? h("span", {}, row.problem) : null),
  },
  { name: "Reason", cell: (row) => row.reason ?? "\u2013" },
];

export default {
  async load(_, state) {
    if (!has("GET", "/v1/audit")) return null;
    const fleets = await fleetsOf();
    return { fleets, page: await audit(fleets).load(state, fromOf(state)) };
  },

  view(data) {
    const heading = h("h1", { tabindex: "-1" }, "Audit");
    if (!data) return [heading, h("p", { class: "empty" }, "This service offers no actions.")];
    return [
      heading,
      h("p", { class: "summary" }, "The actions that people requested, and their results."),
      h("p", { class: "links" }, bulkLink()),
      audit(data.fleets).view(data.page, {
        caption: "Actions",
        columns: COLUMNS,
        key: (row) => `action-${row.action_id}`,
        empty: "No actions yet.",
      }),
    ];
  },
};

function details(parameters) {
  const known = Object.entries(parameters).filter(([, value]) => value !== null && typeof value !== "object");
  return known.length
    ? h(
        "span",
        { class: "hint" },
        ` (${known.map(([name, value]) => `${name.replaceAll("_", " ")}: ${short(value)}`).join(", ")})`,
      )
    : null;
}

/** A long text, such as a note, with its beginning only. */
function short(value) {
  const text = String(value);
  return text.length > 100 ? `${text.slice(0, 100)} ...` : text;
}

function subject(action) {
  const { fleet, robot, array, whisker, compensation_id: compensation } = action;
  if (compensation !== null && compensation !== undefined)
    return h("a", { href: link.compensation(compensation) }, `compensation of ${robot}`);
  if (array) return h("a", { href: link.whisker(action) }, `${robot}, whisker ${array} ${whisker}`);
  if (robot) return h("a", { href: link.robot(action) }, `robot ${robot}`);
  return fleet ? h("a", { href: link.fleet(fleet) }, `fleet ${fleet}`) : "\u2013";
}
