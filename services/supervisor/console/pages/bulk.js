// Bulk actions: every request with its progress.

import { browser } from "../browse.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { bulkLink, progressOf } from "../parts/bulk.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { link } from "../places.js";
import { trail } from "../table.js";
import { AUDIT_KINDS, say } from "../words.js";

const requests = (fleets) =>
  browser({ route: "/v1/bulk-actions", what: "requests", filters: [...fleetFilter(fleets)] });

const COLUMNS = [
  { name: "Time", sort: "action_id", descends: true, isDefault: true, head: true, cell: (row) => h("a", { href: link.bulkAction(row.action_id) }, time(row.asked_at)) },
  { name: "Action", cell: (row) => say(AUDIT_KINDS, row.kind) },
  { name: "Fleet", cell: (row) => (row.fleet ? h("a", { href: link.fleet(row.fleet) }, row.fleet) : "several") },
  { name: "Progress", cell: (row) => bar(row) },
  { name: "Actor", cell: (row) => row.actor },
  { name: "Reason", cell: (row) => row.reason ?? "\u2013" },
];

/** The progress as a bar with words. */
export function bar(row) {
  const answered = row.subjects - row.pending;
  return h(
    "span",
    { class: "progress" },
    h("progress", { max: Math.max(row.subjects, 1), value: answered, "aria-label": "Progress" }),
    h("span", {}, progressOf(row)),
  );
}

export default {
  async load(_, state) {
    if (!bulkLink()) return null;
    const fleets = await fleetsOf();
    return { fleets, page: await requests(fleets).load(state) };
  },

  view(data) {
    const heading = h("h1", { tabindex: "-1" }, "Bulk actions");
    if (!data) return [heading, h("p", { class: "empty" }, "This service offers no bulk actions.")];
    return [
      trail(["Audit", link.audit()]),
      heading,
      h("p", { class: "summary" }, "Requests that concern all robots, whiskers, alarms or fleets that met conditions."),
      requests(data.fleets).view(data.page, {
        caption: "Requests",
        columns: COLUMNS,
        key: (row) => `bulk-${row.action_id}`,
        empty: "No requests yet.",
      }),
    ];
  },
};
