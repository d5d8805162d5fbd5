// All decisions about trimmed whiskers.

import { browser, optionsOf } from "../browse.js";
import { h } from "../dom.js";
import { decisionColumns } from "../parts/decisions.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { link } from "../places.js";
import { APPROVALS, CASES } from "../words.js";

const compensations = (fleets) =>
  browser({
    route: "/v1/compensations",
    what: "compensations",
    search: "robot or array",
    filters: [
      ...fleetFilter(fleets),
      {
        name: "active",
        label: "State",
        options: [
          ["true", "active"],
          ["false", "ended"],
        ],
      },
      { name: "approval", label: "Approval", options: optionsOf(APPROVALS) },
      { name: "case", label: "Case", options: optionsOf(CASES) },
    ],
  });

const ROBOT = {
  name: "Robot",
  sort: "robot",
  cell: (row) => h("a", { href: link.robot(row) }, `${row.fleet}, ${row.robot}`),
};

export default {
  async load(_, state) {
    const fleets = await fleetsOf();
    return { fleets, page: await compensations(fleets).load(state) };
  },

  view({ fleets, page }) {
    const [decision, ...others] = decisionColumns();
    return [
      h("h1", { tabindex: "-1" }, "Compensations"),
      h(
        "p",
        { class: "summary" },
        "Each decision about a trimmed whisker: the compensator, its pressure, and the error that was predicted and measured.",
      ),
      compensations(fleets).view(page, {
        caption: "Compensations",
        columns: [decision, ROBOT, ...others],
        key: (row) => `decision-${row.compensation_id}`,
        empty: "No whisker has been compensated yet.",
      }),
    ];
  },
};
