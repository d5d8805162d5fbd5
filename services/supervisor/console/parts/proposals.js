// Compensations that wait for approval (policy mode ADVISE).

import { has, list } from "../api.js";
import { proposalActions } from "../actions.js";
import { h } from "../dom.js";
import { link } from "../places.js";
import { section } from "../table.js";
import { effect } from "./effect.js";

/** Most proposals that a page shows. */
const SHOWN_MAX = 20;

/** Waiting proposals of a fleet or a robot; empty if the service has no approvals. */
export async function proposalsOf(where) {
  if (!has("POST", "/v1/compensations/{}/approve")) return [];
  return list("/v1/compensations", { ...where, active: true, approval: "PROPOSED", limit: SHOWN_MAX + 1 });
}

/** The section of waiting proposals with their buttons; null without proposals. */
export function proposals(rows, refresh) {
  if (!rows.length) return null;
  return section(
    "Waiting for approval",
    h(
      "ul",
      { class: "cards" },
      rows.slice(0, SHOWN_MAX).map((row) => proposal(row, refresh)),
    ),
    rows.length > SHOWN_MAX
      ? h("p", {}, h("a", { href: link.compensations({ approval: "PROPOSED", active: "true" }) }, "All proposals"))
      : null,
  );
}

function proposal(row, refresh) {
  const { robot, array, compensator_whisker: by, target_whisker: target } = row;
  const what = by === target ? `${array} ${by} serves for itself` : `${array} ${by} takes over from ${array} ${target}`;
  return h(
    "li",
    { class: "card warn", "data-key": `proposal-${row.compensation_id}` },
    h(
      "h3",
      {},
      h(
        "a",
        { href: link.compensation(row.compensation_id) },
        `${robot}: ${what}`,
      ),
    ),
    effect(row),
    h("div", { class: "buttons" }, proposalActions(row, refresh)),
  );
}
