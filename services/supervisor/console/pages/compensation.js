// A decision about a broken whisker: who was asked, who serves, how well, and what may be answered.

import { get } from "../api.js";
import { proposalActions } from "../actions.js";
import { h } from "../dom.js";
import { mm, mpa, time } from "../format.js";
import { markOf } from "../marks.js";
import { api, link, names } from "../places.js";
import { candidatesTable, error, looksTable, ratioPlot, server, standing } from "../parts/decisions.js";
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
          "For",
          h(
            "a",
            { href: link.whisker(names(decision, target)) },
            `whisker ${array} ${target}, ${mm(decision.target_length_mm, 1)} while whole, at ${mpa(decision.target_pressure_mpa)}`,
          ),
        ],
        ["Who compensates", server(decision)],
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
        ["Measured with the gain", error(decision, "measured_error_with_gain")],
      ]),
      section("Candidates", candidatesTable(decision, "Everyone who was asked, and why each was refused")),
      section("Error by contact ratio", ratioPlot(decision), ratiosTable(decision.errors_by_ratio ?? [])),
      section("Looks", looksTable(decision.looks ?? [])),
    ];
  },
};

function ratiosTable(bins) {
  return table({
    caption: "Measured error by contact ratio",
    rows: bins,
    empty: "Nothing was measured yet: that takes contacts after the setpoint was applied.",
    columns: [
      { name: "Contact ratio", head: true, cell: (row) => row.ratio.toFixed(2) },
      { name: "Contacts", numeric: true, cell: (row) => row.contacts },
      { name: "Error", numeric: true, cell: (row) => error(row, "error") },
      {
        name: "Compared with",
        cell: (row) => (row.target_origin === "MEASURED" ? "what it felt while whole" : "the model"),
      },
    ],
  });
}
