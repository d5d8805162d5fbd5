// Staged roll-outs of policies and calibrations, the newest first.

import { has } from "../api.js";
import { browser, optionsOf } from "../browse.js";
import { h } from "../dom.js";
import { time } from "../format.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { changeOf, comparisonOf, rolloutMarks } from "../parts/rollouts.js";
import { link } from "../places.js";
import { trail } from "../table.js";
import { ROLLOUT_STATES } from "../words.js";

const rollouts = (fleets) =>
  browser({
    route: "/v1/rollouts",
    what: "roll-outs",
    filters: [...fleetFilter(fleets), { name: "state", label: "State", options: optionsOf(ROLLOUT_STATES) }],
  });

const COLUMNS = [
  {
    name: "Began",
    sort: "rollout_id",
    descends: true,
    isDefault: true,
    head: true,
    cell: (row) => h("a", { href: link.rollout(row.rollout_id) }, time(row.started_at)),
  },
  { name: "Fleet", cell: (row) => h("a", { href: link.fleet(row.fleet) }, row.fleet) },
  { name: "Change", cell: changeOf },
  { name: "State", cell: rolloutMarks },
  { name: "Measured errors", cell: comparisonOf },
  { name: "Actor", cell: (row) => row.started_by },
];

export default {
  async load(_, state) {
    if (!has("GET", "/v1/rollouts")) return null;
    const fleets = await fleetsOf();
    return { fleets, page: await rollouts(fleets).load(state) };
  },

  view(data) {
    const heading = h("h1", { tabindex: "-1" }, "Roll-outs");
    if (!data) return [heading, h("p", { class: "empty" }, "This service offers no roll-outs.")];
    return [
      trail(["Policy", link.policies()]),
      heading,
      h(
        "p",
        { class: "summary" },
        "Policies and calibrations that 5 % of a fleet's robots get first, then 25 %, then all. Begin one on the page of the policy or of a calibration.",
      ),
      rollouts(data.fleets).view(data.page, {
        caption: "Roll-outs",
        columns: COLUMNS,
        key: (row) => `rollout-${row.rollout_id}`,
        empty: "No roll-outs yet.",
      }),
    ];
  },
};
