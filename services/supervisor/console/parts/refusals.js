// Refusals of a robot, by topic and reason.

import { ifServed, list } from "../api.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { api, ROUTES } from "../places.js";
import { section, table } from "../table.js";

/** Counts of the robot's refused messages and contacts, the newest first. */
export function refusalsOf(robot) {
  return ifServed(`${ROUTES.robot}/refusals`, () => list(`${api.robot(robot)}/refusals`), []);
}

/** The counts as a table; nothing if nothing was refused. */
export function refusalsPart(refusals) {
  if (!refusals.length) return null;
  return section(
    "Refused",
    h("p", {}, "These messages and contacts were not recorded. The other contacts of their messages were."),
    table({
      caption: "Refused messages and contacts, the newest first",
      rows: refusals,
      key: (row) => `refusal-${row.topic}-${row.reason}`,
      empty: "",
      columns: [
        { name: "Topic", head: true, cell: (row) => row.topic },
        { name: "Reason", cell: (row) => row.reason },
        { name: "Number", numeric: true, cell: (row) => String(row.refused) },
        { name: "Newest", cell: (row) => time(row.refused_at) },
        { name: "Newest in words", cell: (row) => h("span", { class: "note" }, row.problem) },
      ],
    }),
  );
}
