// A webhook: its settings, its queue, and its dead letters.

import { get } from "../api.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { markOf } from "../marks.js";
import { letterActions, wants, webhookActions } from "../parts/webhooks.js";
import { api, link } from "../places.js";
import { facts, section, table, trail } from "../table.js";
import { ALARM_KINDS, EVENT_KINDS, say, WEBHOOK_STATES } from "../words.js";
import { lastAnswer } from "./webhooks.js";

/** Number of dead letters that the page lists. */
const SHOWN_MAX = 100;

export default {
  async load({ id }) {
    const path = api.webhook(id);
    const [webhook, letters] = await Promise.all([get(path), get(`${path}/dead-letters`)]);
    return { webhook, letters: letters.items };
  },

  view({ webhook, letters }, _, refresh) {
    const gone = () => (location.hash = link.webhooks());
    const shown = letters.slice(-SHOWN_MAX).reverse();
    return [
      trail(["Webhooks", link.webhooks()]),
      h("h1", { tabindex: "-1" }, `Webhook ${webhook.name}`),
      h("p", { class: "marks" }, markOf(WEBHOOK_STATES, webhook.state)),
      facts([
        ["URL", h("code", { class: "url" }, webhook.url)],
        ["Events", wants(webhook)],
        ["Waiting events", webhook.waiting.toLocaleString("en")],
        ["Oldest waiting event", webhook.oldest_at ? time(webhook.oldest_at) : null],
        ["Last answer", lastAnswer(webhook)],
        ["Last success", webhook.last_success_at ? time(webhook.last_success_at) : null],
        ["Next attempt", webhook.next_at && webhook.waiting ? time(webhook.next_at) : null],
        ["Delivered", webhook.delivered.toLocaleString("en")],
        ["Failed attempts", webhook.failed.toLocaleString("en")],
        ["Removed undelivered", webhook.lost ? webhook.lost.toLocaleString("en") : null],
        ["Old secret ends", webhook.previous_secret_until ? time(webhook.previous_secret_until) : null],
        ["Changed", h("span", {}, time(webhook.changed_at), ` by ${webhook.changed_by}`)],
      ]),
      h("div", { class: "buttons" }, webhookActions(webhook, refresh, gone)),
      section(
        "Dead letters",
        h("p", { class: "hint" }, "Events that the target has not taken after all attempts."),
        letters.length ? h("div", { class: "buttons" }, letterActions(webhook, letters, refresh, "all ")) : null,
        table({
          caption: letters.length > shown.length ? `The newest ${shown.length} of ${letters.length}` : "The newest first",
          rows: shown,
          columns: columns(webhook, refresh),
          key: (row) => `letter-${row.event_id}`,
          empty: "No dead letters.",
        }),
      ),
    ];
  },
};

const columns = (webhook, refresh) => [
  { name: "Time of the event", head: true, cell: (row) => time(row.event.timestamp) },
  { name: "Event", cell: (row) => what(row.event) },
  { name: "Subject", cell: (row) => subject(row.event.data) },
  { name: "Attempts", numeric: true, cell: (row) => row.attempts },
  { name: "Last answer", cell: (row) => row.problem },
  {
    name: "Actions",
    cell: (row) =>
      row.again ? "about to be delivered again" : h("span", { class: "buttons" }, letterActions(webhook, [row], refresh)),
  },
];

function what({ type, data }) {
  return data.alarm ? `${say(EVENT_KINDS, type)}: ${say(ALARM_KINDS, data.alarm.kind)}` : say(EVENT_KINDS, type);
}

function subject({ fleet, robot, array, whisker }) {
  if (array) return h("a", { href: link.whisker({ fleet, robot, array, whisker }) }, `${robot}, whisker ${array} ${whisker}`);
  return h("a", { href: link.robot({ fleet, robot }) }, `robot ${robot}`);
}
