// The whiskers of all fleets: find one by name, condition or fault.

import { list } from "../api.js";
import { browser, optionsOf, shownOf } from "../browse.js";
import { h } from "../dom.js";
import { age, interval, mm, mpa } from "../format.js";
import { marksOf } from "../marks.js";
import { link, whiskerName } from "../places.js";
import { fleetFilter } from "../parts/fleets.js";
import { whiskersActions } from "../parts/bulk.js";
import { LABEL_FILTER } from "../parts/labels.js";
import { CONDITIONS } from "../words.js";

const yesOrNo = (yes, no) => [
  ["true", yes],
  ["false", no],
];

const whiskers = (fleets) =>
  browser({
    route: "/v1/whiskers",
    what: "whiskers",
    search: "robot or array",
    filters: [
      ...fleetFilter(fleets),
      { name: "condition", label: "Condition", options: optionsOf(CONDITIONS) },
      { name: "faulty", label: "Fault", options: yesOrNo("with a fault", "without") },
      { name: "held", label: "Held", options: yesOrNo("held", "not held") },
      { name: "model", label: "Model", text: true },
      LABEL_FILTER,
    ],
  });

const COLUMNS = [
  {
    name: "Whisker",
    sort: "whisker_id",
    isDefault: true,
    head: true,
    cell: (row) => h("a", { href: link.whisker(row) }, whiskerName(row)),
  },
  {
    name: "Robot",
    sort: "robot",
    cell: (row) => h("a", { href: link.robot(row) }, `${row.fleet}, ${row.robot}`),
  },
  { name: "State", sort: "condition", cell: marksOf },
  {
    name: "Length",
    sort: "length_mm",
    numeric: true,
    cell: (row) => interval(row.length_mm, row.length_low_mm, row.length_high_mm),
  },
  { name: "Whole", numeric: true, cell: (row) => mm(row.whole_length_mm, 1) },
  { name: "Pressure", numeric: true, cell: (row) => mpa(row.pressure_mpa) },
  { name: "Contacts", sort: "contacts", descends: true, numeric: true, cell: (row) => row.contacts.toLocaleString("en") },
  { name: "Last message", cell: (row) => age(row.heard_at) },
];

/** The filters of the address as conditions of a bulk action. */
function filterOf({ fleet, condition, faulty, held, model, label, q }) {
  const flag = (word) => (word ? word === "true" : undefined);
  const filter = { fleet, condition, faulty: flag(faulty), held: flag(held), model, label, q };
  return Object.fromEntries(Object.entries(filter).filter(([, value]) => value !== undefined && value !== ""));
}

export default {
  async load(_, state) {
    const all = await list("/v1/fleets", { sort: "fleet" });
    const fleets = all.map(({ fleet }) => fleet);
    const total = all.reduce((sum, { whiskers }) => sum + whiskers, 0);
    return { fleets, total, state, page: await whiskers(fleets).load(state) };
  },

  view({ fleets, total, state, page }, _, refresh) {
    return [
      h("h1", { tabindex: "-1" }, "Whiskers"),
      whiskers(fleets).view(page, {
        total,
        actions: page.items.length ? whiskersActions(filterOf(state), shownOf(page, state), refresh) : null,
        columns: COLUMNS,
        key: (row) => `whisker-${row.fleet}-${row.robot}-${row.array}-${row.whisker}`,
        empty: "No whisker is known yet.",
      }),
    ];
  },
};
