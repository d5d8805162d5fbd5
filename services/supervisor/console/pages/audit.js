// The actions that people requested, and their results.

import { ifServed, list } from "../api.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { markOf } from "../marks.js";
import { link } from "../places.js";
import { table } from "../table.js";
import { ACTION_KINDS, ACTION_STATES, say } from "../words.js";

const ROWS = 200;

export default {
  load: () => ifServed("/v1/audit", () => list("/v1/audit", { limit: ROWS })),

  view(actions) {
    const heading = h("h1", { tabindex: "-1" }, "Audit");
    if (!actions) return [heading, h("p", { class: "empty" }, "This service offers no actions.")];
    return [
      heading,
      h("p", { class: "summary" }, `Requested actions, the newest first; at most ${ROWS}.`),
      table({
        caption: "Actions",
        rows: actions,
        key: (row) => `action-${row.action_id}`,
        empty: "No actions yet.",
        columns: [
          { name: "Time", head: true, cell: (row) => time(row.asked_at) },
          { name: "Actor", cell: (row) => row.actor ?? "\u2013" },
          { name: "Action", cell: (row) => [say(ACTION_KINDS, row.kind), details(row.parameters)] },
          { name: "Subject", cell: subject },
          {
            name: "Result",
            cell: (row) =>
              h(
                "span",
                { class: "marks" },
                markOf(ACTION_STATES, row.state),
                row.problem ? h("span", {}, row.problem) : null,
              ),
          },
          { name: "Reason", cell: (row) => row.reason ?? "\u2013" },
        ],
      }),
    ];
  },
};

function details(parameters) {
  const known = Object.entries(parameters).filter(([, value]) => value !== null);
  return known.length
    ? h(
        "span",
        { class: "hint" },
        ` (${known.map(([name, value]) => `${name.replaceAll("_", " ")}: ${value}`).join(", ")})`,
      )
    : null;
}

function subject(action) {
  const { fleet, robot, array, whisker, compensation_id: compensation } = action;
  if (compensation !== null && compensation !== undefined)
    return h("a", { href: link.compensation(compensation) }, `compensation no. ${compensation}`);
  if (array) return h("a", { href: link.whisker(action) }, `${robot}, whisker ${array} ${whisker}`);
  if (robot) return h("a", { href: link.robot(action) }, `robot ${robot}`);
  return fleet ? h("a", { href: link.fleet(fleet) }, `fleet ${fleet}`) : "\u2013";
}
