// The compensation policy of a fleet, and the dialog to change it.

import { ask, has, ifServed, list } from "../api.js";
import { confirm } from "../dialog.js";
import { h } from "../dom.js";
import { percent, time } from "../format.js";
import { api, link, ROUTES } from "../places.js";
import { facts, section, table, trail } from "../table.js";
import { say } from "../words.js";

const MODES = {
  AUTOMATIC: "automatic: compensations start at once",
  ADVISE: "advise: an operator approves each compensation",
};
const OBJECTIVES = { TIP: "equal sensitivity at the tip (Eq. 34)", MEAN: "least mean error over contact ratios" };
const LONGER = { NEVER: "never", LAST_RESORT: "as a last resort", ALLOWED: "whenever it costs least" };
const NUMBERS = [
  ["predicted_error_max", "Maximum predicted error", "As a ratio from 0 to 10; 1 means no better than doing nothing."],
  ["own_role_cost", "Cost of losing an own role", "In units of mean error, 0 to 10."],
  ["change_margin", "Minimum gain of a change", "In units of mean error, 0 to 10."],
];

export default {
  async load({ fleet }) {
    const fleets = fleet ? [{ fleet }] : await list("/v1/fleets", { sort: "fleet" });
    if (!has("GET", ROUTES.policy)) return { fleets, policies: null };
    return { fleets, policies: await Promise.all(fleets.map((one) => policyOf(one.fleet))) };
  },

  view({ policies }, { fleet }, refresh) {
    const heading = h("h1", { tabindex: "-1" }, fleet ? `Policy of fleet ${fleet}` : "Policy");
    if (!policies)
      return [heading, h("p", { class: "empty" }, "The policy of this service is only in its configuration.")];
    return [
      fleet ? trail(["Fleets", link.fleets()], [`Fleet ${fleet}`, link.fleet(fleet)]) : null,
      heading,
      h("p", { class: "summary" }, "Rules for decisions about trimmed whiskers."),
      policies.map((policy) => section(`Fleet ${policy.fleet}`, ...part(policy, refresh))),
    ];
  },
};

async function policyOf(fleet) {
  const [answer, history] = await Promise.all([
    ask(api.policy(fleet)),
    ifServed(`${ROUTES.policy}/history`, () => list(`${api.policy(fleet)}/history`, { limit: 20 }), []),
  ]);
  return { fleet, tag: answer.headers.get("ETag"), history, now: await answer.json() };
}

const shown = (policy) => [
  ["Mode", say(MODES, policy.mode)],
  ["Objective of the setpoint", say(OBJECTIVES, policy.objective)],
  ["Longer whisker for a shorter one", say(LONGER, policy.longer_for_shorter)],
  ["Maximum predicted error", percent(policy.predicted_error_max, 0)],
  ["Cost of losing an own role", policy.own_role_cost],
  ["Minimum gain of a change", policy.change_margin],
];

function part(policy, refresh) {
  return [
    facts(shown(policy.now)),
    has("PUT", ROUTES.policy)
      ? h(
          "div",
          { class: "buttons" },
          h(
            "button",
            { type: "button", onclick: () => confirm(change(policy), refresh) },
            `Change the policy of ${policy.fleet} \u2026`,
          ),
        )
      : null,
    policy.history.length ? historyTable(policy) : null,
  ];
}

function change({ fleet, tag, now }) {
  const choice = (name, label, words) => ({
    name,
    label,
    options: Object.entries(words),
    value: now[name],
    required: true,
  });
  const number = ([name, label, hint]) => ({
    name,
    label,
    hint,
    type: "number",
    min: 0,
    max: 10,
    step: "any",
    required: true,
    value: now[name],
  });
  return {
    title: `Change the policy of fleet ${fleet}`,
    what: [
      "The new policy applies to all later decisions, and refused proposals may come again. Switching to automatic starts all waiting proposals: robots will change pressures. Present setpoints stay.",
    ],
    fields: [
      choice("mode", "Mode", MODES),
      choice("objective", "Objective of the setpoint", OBJECTIVES),
      choice("longer_for_shorter", "Longer whisker for a shorter one", LONGER),
      ...NUMBERS.map(number),
    ],
    reason: "optional",
    button: "Change the policy",
    grave: true,
    path: api.policy(fleet),
    method: "PUT",
    headers: tag ? { "If-Match": tag } : {},
    body: ({ reason, ...values }) => {
      const numbers = Object.fromEntries(NUMBERS.map(([name]) => [name, Number(values[name])]));
      return { ...values, ...numbers, reason: reason.trim() || undefined };
    },
  };
}

function historyTable({ fleet, history }) {
  return table({
    caption: `Changes of the policy of ${fleet}, the newest first`,
    rows: history,
    empty: "",
    columns: [
      { name: "Time", head: true, cell: (row) => time(row.changed_at) },
      { name: "Actor", cell: (row) => row.changed_by },
      { name: "Mode", cell: (row) => say({ AUTOMATIC: "automatic", ADVISE: "advise" }, row.mode) },
      { name: "Objective", cell: (row) => say({ TIP: "tip", MEAN: "mean" }, row.objective) },
      { name: "Longer for shorter", cell: (row) => say(LONGER, row.longer_for_shorter) },
      { name: "Maximum error", numeric: true, cell: (row) => percent(row.predicted_error_max, 0) },
      { name: "Reason", cell: (row) => row.reason ?? "\u2013" },
    ],
  });
}
