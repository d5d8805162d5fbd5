// The compensation policy of a fleet, and the dialog to change it.

import { ask, has, ifServed, list, schema } from "../api.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { percent, time } from "../format.js";
import { prepared } from "../parts/bulk.js";
import { askedFor, manyOf, newestOf } from "../parts/newest.js";
import { rolloutButton, rolloutsLink } from "../parts/rollouts.js";
import { api, link, ROUTES } from "../places.js";
import { facts, section, table, trail } from "../table.js";
import { LONGER_FOR_SHORTER, MODES, OBJECTIVES, say } from "../words.js";

/** The policy's numbers, as the OpenAPI document declares them. */
const numbers = () =>
  Object.entries(schema("NewPolicy")?.properties ?? {})
    .filter(([, one]) => one.type === "number")
    .map(([name, one]) => ({ name, ...one, label: one["x-label"] ?? name, percent: one["x-unit"] === "ratio" }));

/** Most fleets whose policies are on one page: each takes two requests at each refresh. */
const SHOWN_MAX = 10;

export default {
  async load({ fleet }, state) {
    const fleets = fleet ? [{ fleet }] : await list("/v1/fleets", { sort: "fleet" });
    if (!has("GET", ROUTES.policy)) return { fleets, policies: null };
    const shown = fleets.length > SHOWN_MAX ? fleets.slice(0, 1) : fleets;
    return { fleets, policies: await Promise.all(shown.map((one) => policyOf(one.fleet, manyOf(state)))) };
  },

  view({ fleets, policies }, { fleet }, refresh) {
    const heading = h("h1", { tabindex: "-1" }, fleet ? `Policy of fleet ${fleet}` : "Policy");
    if (!policies)
      return [heading, h("p", { class: "empty" }, "The policy of this service is only in its configuration.")];
    return [
      fleet ? trail(["Fleets", link.fleets()], [`Fleet ${fleet}`, link.fleet(fleet)]) : null,
      heading,
      h("p", { class: "summary" }, "Rules for decisions about trimmed whiskers."),
      h("p", { class: "links" }, rolloutsLink(fleet ? { fleet } : {})),
      atOnce(fleets, policies, refresh),
      fleets.length > SHOWN_MAX
        ? section("Fleets", h("ul", {}, fleets.map((one) => h("li", {}, h("a", { href: link.policy(one.fleet) }, one.fleet)))))
        : policies.map((policy) => section(`Fleet ${policy.fleet}`, ...part(policy, refresh))),
    ];
  },
};

async function policyOf(fleet, many) {
  const [answer, history] = await Promise.all([
    ask(api.policy(fleet)),
    ifServed(`${ROUTES.policy}/history`, () => list(`${api.policy(fleet)}/history`, { limit: askedFor(many) }), []),
  ]);
  return { fleet, many, tag: answer.headers.get("ETag"), history, now: await answer.json() };
}

const shown = (policy) => [
  ["Mode", say(MODES, policy.mode)],
  ["Objective of the setpoint", say(OBJECTIVES, policy.objective)],
  ["Longer whisker for a shorter one", say(LONGER_FOR_SHORTER, policy.longer_for_shorter)],
  ...numbers().map((one) => [one.label, one.percent ? percent(policy[one.name], 0) : policy[one.name]]),
];

function part(policy, refresh) {
  return [
    facts(shown(policy.now)),
    has("PUT", ROUTES.policy)
      ? h(
          "div",
          { class: "buttons" },
          actionButton(change(policy), refresh, `Change the policy of ${policy.fleet}`),
          inStages(policy, refresh),
        )
      : null,
    newestOf(policy.history, policy.many, (rows) => (rows.length ? historyTable(policy.fleet, rows) : null)),
  ];
}

/** The button that rolls a policy out in stages. */
function inStages(policy, refresh) {
  const { fields, body } = change(policy);
  const told = (values) => ({ policy: { ...body({ ...values, reason: "" }) } });
  const action = {
    fleet: policy.fleet,
    title: `Roll a policy out in fleet ${policy.fleet}`,
    what: "Meanwhile the fleet's policy cannot be changed otherwise.",
    fields,
    change: told,
    words: "Roll a policy out in stages",
  };
  return rolloutButton(action, refresh);
}

/** The button that sets one policy in all fleets. */
function atOnce(fleets, policies, refresh) {
  const path = "/v1/policies";
  if (fleets.length < 2 || !has("POST", path)) return null;
  const { what, fields, body } = change(policies[0]);
  const prepare = () =>
    prepared({
      path,
      noun: "fleet",
      verb: "Change the policy of",
      what,
      grave: true,
      fields,
      body: { filter: {}, policy: body({ ...fieldValues(fields), reason: "" }) },
      values: (told) => ({ policy: body(told) }),
    });
  return h("div", { class: "buttons" }, actionButton({ path, prepare, grave: true }, refresh, "Change the policy of all fleets"));
}

const fieldValues = (fields) => Object.fromEntries(fields.map(({ name, value }) => [name, value]));

function change({ fleet, tag, now }) {
  const choice = (name, label, words) => ({
    name,
    label,
    options: Object.entries(words),
    value: now[name],
    required: true,
  });
  const number = ({ name, label, description, minimum, maximum }) => ({
    name,
    label,
    hint: `${description} From ${minimum} to ${maximum}.`,
    type: "number",
    min: minimum,
    max: maximum,
    step: "any",
    required: true,
    value: now[name],
  });
  return {
    title: `Change the policy of fleet ${fleet}`,
    what: [
      "The new policy applies to all later decisions. Refused compensations may be proposed again, or start by themselves in mode automatic: robots then change pressures. Switching to automatic starts the proposed touch tests. Proposed compensations still wait for approval. Present setpoints stay.",
    ],
    fields: [
      choice("mode", "Mode", MODES),
      choice("objective", "Objective of the setpoint", OBJECTIVES),
      choice("longer_for_shorter", "Longer whisker for a shorter one", LONGER_FOR_SHORTER),
      ...numbers().map(number),
    ],
    reason: "optional",
    button: "Change the policy",
    grave: true,
    path: api.policy(fleet),
    method: "PUT",
    headers: tag ? { "If-Match": tag } : {},
    body: ({ reason, ...values }) => {
      const told = Object.fromEntries(numbers().map(({ name }) => [name, Number(values[name])]));
      return { ...values, ...told, reason: reason.trim() || undefined };
    },
  };
}

function historyTable(fleet, rows) {
  return table({
    caption: `Changes of the policy of ${fleet}, the newest first`,
    rows,
    empty: "",
    columns: [
      { name: "Time", head: true, cell: (row) => time(row.changed_at) },
      { name: "Actor", cell: (row) => row.changed_by },
      { name: "Mode", cell: (row) => say({}, row.mode) },
      { name: "Objective", cell: (row) => say({}, row.objective) },
      { name: "Longer for shorter", cell: (row) => say(LONGER_FOR_SHORTER, row.longer_for_shorter) },
      { name: "Maximum error", numeric: true, cell: (row) => percent(row.predicted_error_max, 0) },
      { name: "Reason", cell: (row) => row.reason ?? "\u2013" },
    ],
  });
}
