// Compensations that wait for somebody's approval (policy mode ADVISE).

import { has, list } from "../api.js";
import { proposalActions } from "../actions.js";
import { h } from "../dom.js";
import { interval, mpa, percent } from "../format.js";
import { link } from "../places.js";
import { section } from "../table.js";

/** Those that wait, of a fleet or a robot; none if the service knows no approval. */
export async function proposalsOf(where) {
  if (!has("POST", "/v1/compensations/{}/approve")) return [];
  const rows = await list("/v1/compensations", { ...where, active: true });
  return rows.filter((row) => row.approval === "PROPOSED");
}

/** They, with what may be answered; nothing if there are none. */
export function proposals(rows, refresh) {
  if (!rows.length) return null;
  return section(
    "Waiting for approval",
    h(
      "ul",
      { class: "cards" },
      rows.map((row) => proposal(row, refresh)),
    ),
  );
}

function proposal(row, refresh) {
  const whom = row.compensator_whisker === row.target_whisker ? "itself" : `whisker ${row.target_whisker}`;
  return h(
    "li",
    { class: "card warn", "data-key": `proposal-${row.compensation_id}` },
    h(
      "h3",
      {},
      h(
        "a",
        { href: link.compensation(row.compensation_id) },
        `${row.robot}: whisker ${row.array} ${row.compensator_whisker} shall compensate for ${whom}`,
      ),
    ),
    h(
      "p",
      {},
      `From ${mpa(row.pressure_before_mpa)} to ${mpa(row.pressure_mpa)}; predicted error ${interval(row.predicted_error, row.predicted_error_low, row.predicted_error_high, percent)}.`,
    ),
    h("div", { class: "buttons" }, proposalActions(row, refresh)),
  );
}
