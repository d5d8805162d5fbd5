// One bulk action: its conditions, its progress, why subjects were refused, and each subject.

import { get, has } from "../api.js";
import { browser, optionsOf } from "../browse.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { count, time } from "../format.js";
import { markOf } from "../marks.js";
import { link, whiskerName } from "../places.js";
import { facts, section, table, trail } from "../table.js";
import { ACTION_STATES, AUDIT_KINDS, say } from "../words.js";
import { bar } from "./bulk.js";

const parts = browser({
  route: "/v1/audit",
  what: "subjects",
  filters: [{ name: "state", label: "Result", options: optionsOf(ACTION_STATES) }],
});

const COLUMNS = [
  { name: "Subject", head: true, cell: subject },
  {
    name: "Result",
    cell: (row) =>
      h("span", { class: "marks" }, markOf(ACTION_STATES, row.state), row.problem ? h("span", {}, row.problem) : null),
  },
  { name: "Answered", cell: (row) => time(row.done_at) },
];

export default {
  async load({ id }, state) {
    const [told, page] = await Promise.all([
      get(`/v1/bulk-actions/${encodeURIComponent(id)}`),
      parts.load(state, { parent_id: id, order: "ascending" }),
    ]);
    return { ...told, page };
  },

  view({ request, refusals, page }, _, refresh) {
    return [
      trail(["Audit", link.audit()], ["Bulk actions", link.bulk()]),
      h("h1", { tabindex: "-1" }, `Action ${request.action_id}: ${say(AUDIT_KINDS, request.kind)}`),
      facts([
        ["Progress", bar(request)],
        ["Conditions", conditions(request.parameters.which)],
        ["Requested", time(request.asked_at)],
        ["Actor", request.actor],
        ["Reason", request.reason],
      ]),
      request.pending ? h("div", { class: "buttons" }, stop(request, refresh)) : null,
      refusals.length ? section("Why subjects were refused", refusalsTable(refusals)) : null,
      section(
        "Subjects",
        parts.view(page, { caption: "Subjects", columns: COLUMNS, key: (row) => `part-${row.action_id}`, empty: "None." }),
      ),
    ];
  },
};

function conditions(which) {
  const filter = Object.entries(which?.filter ?? which ?? {}).filter(([, value]) => typeof value !== "object");
  return filter.length ? filter.map(([name, value]) => `${name.replaceAll("_", " ")}: ${value}`).join(", ") : "all";
}

function subject(row) {
  if (row.array) return h("a", { href: link.whisker(row) }, `${row.robot}, whisker ${whiskerName(row)}`);
  if (row.robot) return h("a", { href: link.robot(row) }, `${row.fleet}, ${row.robot}`);
  return h("a", { href: link.fleet(row.fleet) }, `fleet ${row.fleet}`);
}

function refusalsTable(refusals) {
  return table({
    caption: "Reasons, the most frequent first",
    rows: refusals,
    empty: "",
    columns: [
      { name: "Reason", head: true, cell: (row) => row.problem },
      { name: "Subjects", numeric: true, cell: (row) => row.subjects.toLocaleString("en") },
    ],
  });
}

function stop(request, done) {
  if (!has("POST", "/v1/bulk-actions/{}/stop")) return null;
  const action = {
    title: `Stop action ${request.action_id}`,
    what: [`${count(request.pending, "subject")} that wait are not concerned any more. What is done stays done.`],
    button: "Stop",
    grave: true,
    reason: "optional",
    path: `/v1/bulk-actions/${encodeURIComponent(request.action_id)}/stop`,
    body: (values) => ({ reason: values.reason?.trim() || undefined }),
  };
  return actionButton(action, done);
}
