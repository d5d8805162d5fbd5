// The trims of all fleets that were detected.

import { browser } from "../browse.js";
import { h } from "../dom.js";
import { interval, mm, time } from "../format.js";
import { boxLink } from "../parts/boxes.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { fromOf, SINCE } from "../parts/since.js";
import { link, whiskerName } from "../places.js";

const trims = (fleets) =>
  browser({
    route: "/v1/trims",
    what: "trims",
    filters: [...fleetFilter(fleets), SINCE, { name: "robot", label: "Robot", text: true }],
  });

const COLUMNS = [
  {
    name: "Detected",
    sort: "detected_at",
    descends: true,
    isDefault: true,
    head: true,
    cell: (row) => time(row.detected_at),
  },
  { name: "Robot", cell: (row) => h("a", { href: link.robot(row) }, `${row.fleet}, ${row.robot}`) },
  { name: "Whisker", cell: (row) => h("a", { href: link.whisker(row) }, whiskerName(row)) },
  { name: "Length before", numeric: true, cell: (row) => mm(row.length_before_mm) },
  {
    name: "Length after",
    sort: "length_after_mm",
    numeric: true,
    cell: (row) => interval(row.length_after_mm, row.length_after_low_mm, row.length_after_high_mm),
  },
  {
    name: "Contacts to detection",
    sort: "contacts_to_detect",
    descends: true,
    numeric: true,
    cell: (row) => row.contacts_to_detect,
  },
  { name: "Messages", cell: (row) => boxLink(row.black_box_id) ?? "\u2013" },
];

export default {
  async load(_, state) {
    const fleets = await fleetsOf();
    return { fleets, page: await trims(fleets).load(state, fromOf(state)) };
  },

  view({ fleets, page }) {
    return [
      h("h1", { tabindex: "-1" }, "Trims"),
      trims(fleets).view(page, {
        caption: "Detected trims",
        columns: COLUMNS,
        key: (row) => `trim-${row.trim_id}`,
        empty: "No trim has been detected yet.",
      }),
    ];
  },
};
