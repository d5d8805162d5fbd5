// Webhooks: targets that get events, with their states and queues.

import { get, has } from "../api.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { markOf } from "../marks.js";
import { createButton, PATH, testButton, wants } from "../parts/webhooks.js";
import { link } from "../places.js";
import { refusal } from "../rights.js";
import { table } from "../table.js";
import { WEBHOOK_STATES } from "../words.js";

const heading = () => h("h1", { tabindex: "-1" }, "Webhooks");

export default {
  async load() {
    if (!has("GET", PATH)) return { refused: "This service offers no webhooks." };
    const refused = refusal("GET", PATH);
    return refused ? { refused } : { webhooks: (await get(PATH)).items };
  },

  view({ refused, webhooks }, _, refresh) {
    if (refused) return [heading(), h("p", { class: "empty" }, refused)];
    return [
      heading(),
      h("p", { class: "summary" }, "Programs and people elsewhere that get alarms, trims, compensations and failed setpoints, over HTTP or by mail."),
      h("div", { class: "buttons" }, createButton(refresh)),
      table({
        caption: "Webhooks",
        rows: webhooks,
        columns: COLUMNS,
        key: (row) => `webhook-${row.webhook_id}`,
        empty: "No webhook yet.",
      }),
    ];
  },
};

const COLUMNS = [
  { name: "Name", head: true, cell: (row) => h("a", { href: link.webhook(row.webhook_id) }, row.name) },
  { name: "State", cell: (row) => h("span", { class: "marks" }, markOf(WEBHOOK_STATES, row.state)) },
  { name: "Events", cell: wants },
  { name: "Last answer", cell: lastAnswer },
  { name: "Waiting", numeric: true, cell: (row) => row.waiting.toLocaleString("en") },
  { name: "Dead letters", numeric: true, cell: (row) => row.dead_letters.toLocaleString("en") },
  { name: "Test", cell: testButton },
];

/** Result and time of the last attempt. */
export function lastAnswer(row) {
  if (!row.last_at) return "\u2013";
  return h("span", {}, row.last_problem ?? `answered ${row.last_status}`, ", ", time(row.last_at));
}
