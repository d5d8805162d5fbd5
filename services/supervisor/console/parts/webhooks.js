// Actions on webhooks, and what their pages share.

import { ask } from "../api.js";
import { actionButton, tell } from "../dialog.js";
import { h } from "../dom.js";
import { count } from "../format.js";
import { notice, refused, report } from "../notices.js";
import { api } from "../places.js";
import { refusal } from "../rights.js";
import { ALARM_LEVELS, EVENT_KINDS, say } from "../words.js";
import { FLEETS_RULE } from "./fleets.js";

export const PATH = "/v1/webhooks";
/** What a webhook wants, in a few words. */
export function wants(webhook) {
  const kinds = webhook.kinds ? webhook.kinds.map((kind) => say(EVENT_KINDS, kind)).join(", ") : "all events";
  const fleets = webhook.fleets ? `of ${webhook.fleets.join(", ")}` : "of all fleets";
  const level = webhook.level === "WARNING" ? "" : `, ${webhook.level.toLowerCase()} and above`;
  return `${kinds} ${fleets}${level}`;
}

const withReason = (values) => values.reason?.trim() || undefined;

function settings(values) {
  const kinds = Object.keys(values)
    .filter((name) => name.startsWith("kinds:"))
    .map((name) => name.slice("kinds:".length));
  const fleets = values.fleets.split(/[\s,]+/).filter(Boolean);
  return {
    name: values.name,
    url: values.url,
    fleets: fleets.length ? fleets : null,
    kinds: kinds.length === eventKinds().length && !isMail(values.url) ? null : kinds,
    level: values.level,
    enabled: values.enabled === "yes",
    reason: withReason(values),
  };
}

const isMail = (url) => url.trim().startsWith("mailto:");

/** Kinds that people get by mail, unless they choose others. */
const MAIL_KINDS = ["ALARM_RAISED", "ALARM_CLEARED"];

/** Chooses the usual events once the URL is that of a mail, or not any more. */
function presetKinds() {
  let wasMail = false;
  return ({ target }) => {
    if (isMail(target.value) === wasMail) return;
    wasMail = !wasMail;
    for (const box of target.form.querySelectorAll("[name^='kinds:']"))
      box.checked = !wasMail || MAIL_KINDS.includes(box.name.slice("kinds:".length));
  };
}

const eventKinds = () => Object.entries(EVENT_KINDS).filter(([kind]) => kind !== "TEST");

const fields = (webhook) => [
  { name: "name", label: "Name", required: true, maxlength: 100, value: webhook?.name },
  {
    name: "url",
    label: "URL",
    type: "url",
    required: true,
    maxlength: 2000,
    hint: "https://... or http://..., or mailto:NAME@HOST for mails. Private addresses need webhooks.allowed_hosts, mails need mail.url.",
    value: webhook?.url,
    oninput: webhook ? null : presetKinds(),
  },
  {
    name: "fleets",
    label: "Fleets",
    hint: `${FLEETS_RULE} Patterns include future fleets. Empty for all fleets.`,
    value: webhook?.fleets?.join(", "),
  },
  {
    name: "kinds",
    label: "Events",
    checks: eventKinds().map(([kind, words]) => [kind, words, !webhook?.kinds || webhook.kinds.includes(kind)]),
  },
  {
    name: "level",
    label: "Least severity",
    options: Object.keys(ALARM_LEVELS).map((level) => [level, say(ALARM_LEVELS, level)]),
    value: webhook?.level ?? "WARNING",
    required: true,
  },
  {
    name: "enabled",
    label: "Delivery",
    options: [
      ["yes", "deliver"],
      ["no", "keep events waiting"],
    ],
    value: webhook?.enabled === false ? "no" : "yes",
    required: true,
  },
];

/** Shows a secret; the service never shows it again. */
function showSecret({ webhook, secret }) {
  if (!secret) return;
  const copy = async () => {
    await navigator.clipboard.writeText(secret);
    notice("Copied.");
  };
  tell(
    `Secret of ${webhook.name}`,
    h("p", {}, "The receiver verifies requests with this secret. It is shown only now."),
    h("code", { class: "secret", tabindex: "0" }, secret),
    navigator.clipboard ? h("p", {}, h("button", { type: "button", onclick: copy }, "Copy")) : null,
  );
}

/** The button that creates a webhook. */
export function createButton(done) {
  return actionButton(
    {
      title: "Create a webhook",
      what: ["The target gets events from now on. Requests are signed with a secret that is shown once; mails are not signed."],
      fields: fields(null),
      reason: "optional",
      button: "Create a webhook",
      path: PATH,
      body: settings,
      after: showSecret,
    },
    done,
  );
}

/** Webhooks whose test waits for its answer. A refresh of the page makes their buttons anew. */
const tested = new Set();

/** A button that sends a test and shows the target's answer. */
export function testButton(webhook) {
  const { webhook_id: id } = webhook;
  const path = `${api.webhook(id)}/test`;
  const reason = refusal("POST", path);
  const test = async () => {
    if (reason) return refused(reason);
    if (tested.has(id)) return;
    tested.add(id);
    const said = report();
    said(`Test of ${webhook.name}: waiting for the answer.`, "good", false);
    try {
      const told = await (await ask(path, { method: "POST" })).json();
      const words = told.delivered ? `taken in ${told.duration_ms} ms, status ${told.status}` : told.problem;
      said(`Test of ${webhook.name}: ${words}.`, told.delivered ? "good" : "bad", true);
    } catch (problem) {
      said(`Test of ${webhook.name}: ${problem.message}`, "bad", true);
    } finally {
      tested.delete(id);
    }
  };
  const attributes = { type: "button", "aria-disabled": reason ? "true" : null, title: reason, onclick: test };
  return h("button", attributes, "Send a test");
}

/** The buttons of a webhook's page. */
export function webhookActions(webhook, done, gone) {
  const path = api.webhook(webhook.webhook_id);
  const action = (one) => actionButton({ reason: "optional", body: (values) => ({ reason: withReason(values) }), ...one }, done);
  return [
    testButton(webhook),
    action({
      title: `Change ${webhook.name}`,
      what: ["Waiting events are tried at once with the new settings."],
      fields: fields(webhook),
      button: "Change",
      path,
      method: "PUT",
      body: settings,
    }),
    webhook.url.startsWith("mailto:") ? null : action({
      title: `Renew the secret of ${webhook.name}`,
      what: ["Requests have the signatures of both secrets until the old one ends, so that the receiver can change its secret."],
      fields: [
        {
          name: "overlap",
          label: "The old secret ends",
          options: [
            ["86400", "in a day"],
            ["604800", "in a week"],
            ["0", "at once: it has leaked"],
          ],
          value: "86400",
          required: true,
        },
      ],
      button: "Renew the secret",
      path: `${path}/secret`,
      body: (values) => ({ overlap_s: Number(values.overlap), reason: withReason(values) }),
      after: showSecret,
    }),
    actionButton(
      {
        title: `Remove ${webhook.name}`,
        what: [`Its waiting events and dead letters are removed: ${webhook.waiting} and ${webhook.dead_letters}.`],
        button: "Remove",
        grave: true,
        reason: "optional",
        path,
        method: "DELETE",
        body: (values) => ({ reason: withReason(values) }),
      },
      gone,
    ),
  ];
}

/** The buttons for all dead letters of a webhook, or for one of them. */
export function letterActions(webhook, letters, done, all = "") {
  const path = `${api.webhook(webhook.webhook_id)}/dead-letters`;
  const which = letters.map((letter) => letter.event_id);
  const body = (values) => ({ event_ids: which, reason: withReason(values) });
  const many = count(letters.length, "dead letter");
  const redeliver = {
    title: `Deliver ${many} again`,
    what: ["They are sent before newer events, and out of order: their times are those of the events."],
    button: "Deliver again",
  };
  const discard = { title: `Discard ${many}`, what: ["They are deleted undelivered."], button: "Discard", grave: true };
  return [
    ["redeliver", `Deliver ${all}again`, redeliver],
    ["discard", `Discard ${all}`.trim(), discard],
  ].map(([one, words, action]) => {
    return actionButton({ reason: "optional", path: `${path}/${one}`, body, ...action }, done, words);
  });
}
