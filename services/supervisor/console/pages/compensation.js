// A compensation: candidates, compensator, errors, and the buttons for a proposal.

import { get } from "../api.js";
import { errorChart } from "../charts/ratio.js";
import { proposalActions } from "../actions.js";
import { h } from "../dom.js";
import { mm, mpa, time } from "../format.js";
import { markOf } from "../marks.js";
import { api, link, names } from "../places.js";
import { candidatesTable, error, looksTable, server, standing } from "../parts/decisions.js";
import { facts, section, table, trail } from "../table.js";
import { APPROVALS } from "../words.js";

export default {
  load: ({ id }) => get(api.compensation(id)),

  view(decision, { id }, refresh) {
    const { fleet, robot, array, target_whisker: target } = decision;
    const actions = proposalActions(decision, refresh);
    return [
      trail(
        ["Fleets", link.fleets()],
        [`Fleet ${fleet}`, link.fleet(fleet)],
        [`Robot ${robot}`, link.robot(decision)],
        [`Whisker ${array} ${target}`, link.whisker(names(decision, target))],
      ),
      h("h1", { tabindex: "-1" }, `Compensation for whisker ${array} ${target} of ${robot}`),
      h(
        "p",
        { class: "marks" },
        decision.approval ? markOf(APPROVALS, decision.approval) : null,
        decision.approval === "PROPOSED" ? null : standing(decision),
      ),
      actions.length ? h("div", { class: "buttons" }, actions) : null,
      facts([
        [
          "Target",
          h(
            "a",
            { href: link.whisker(names(decision, target)) },
            `whisker ${array} ${target}, whole length ${mm(decision.target_length_mm, 1)}, at ${mpa(decision.target_pressure_mpa)}`,
          ),
        ],
        ["Compensator", server(decision)],
        ["Number", id],
        ["Decided", time(decision.decided_at)],
        ["Pressure before", mpa(decision.pressure_before_mpa)],
        ["Pressure decided", mpa(decision.pressure_mpa)],
        ["Pressure held now", mpa(decision.held_pressure_mpa)],
        ["Predicted error", error(decision, "predicted_error")],
        [
          "Measured error",
          `${error(decision, "measured_error")}${decision.measured_contacts ? `, ${decision.measured_contacts.toLocaleString("en")} contacts` : ""}`,
        ],
        decision.measured_air_error === null
          ? ["Measured error with gain", error(decision, "measured_error_with_gain")]
          : ["Measured error by air alone", error(decision, "measured_air_error")],
      ]),
      section("Candidates", candidatesTable(decision, "Candidates and reasons")),
      section("Error by contact ratio", errorChart(decision), ratiosTable(decision.errors_by_ratio ?? [])),
      section("Pressure reviews", looksTable(decision.looks ?? [])),
    ];
  },
};

function ratiosTable(bins) {
  return table({
    caption: "Measured error by contact ratio",
    rows: bins,
    empty: "No measurements yet: they need contacts after the setpoint was applied.",
    columns: [
      { name: "Contact ratio", head: true, cell: (row) => row.ratio.toFixed(2) },
      { name: "Contacts", numeric: true, cell: (row) => row.contacts },
      { name: "Error", numeric: true, cell: (row) => error(row, "error") },
      {
        name: "Compared with",
        cell: (row) => (row.target_origin === "MEASURED" ? "measured while whole" : "predicted by the model"),
      },
    ],
  });
}
