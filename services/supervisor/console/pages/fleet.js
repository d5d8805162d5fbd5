// A fleet with its robots, those that need attention first.

import { get, has } from "../api.js";
import { browser, optionsOf, shownOf } from "../browse.js";
import { h } from "../dom.js";
import { age, count } from "../format.js";
import { markOf } from "../marks.js";
import { api, link, ROUTES } from "../places.js";
import { board, boardOf, verdict } from "../parts/board.js";
import { robotsActions } from "../parts/bulk.js";
import { LABEL_COLUMN, LABEL_FILTER } from "../parts/labels.js";
import { proposals, proposalsOf } from "../parts/proposals.js";
import { trail } from "../table.js";
import { CONNECTIONS } from "../words.js";
import { health, present, supervision, waits } from "./fleets.js";

const robots = browser({
  route: "/v1/robots",
  what: "robots",
  search: "robot or model",
  filters: [
    { name: "connection", label: "Connection", options: optionsOf(CONNECTIONS) },
    {
      name: "attention",
      label: "Attention",
      options: [
        ["true", "needed"],
        ["false", "not needed"],
      ],
    },
    LABEL_FILTER,
  ],
});

const COLUMNS = [
  { name: "Robot", sort: "robot", head: true, cell: (row) => h("a", { href: link.robot(row) }, row.robot) },
  { name: "Connection", sort: "connection", cell: (row) => markOf(CONNECTIONS, row.connection) },
  {
    name: "Needs attention",
    sort: "attention",
    descends: true,
    isDefault: true,
    cell: (row) => h("span", { class: "marks" }, health(row)),
  },
  {
    name: "Whiskers",
    cell: (row) => `${row.whiskers_healthy} of ${row.whiskers} healthy, in ${count(row.arrays, "array")}`,
  },
  LABEL_COLUMN,
  { name: "Last message", cell: (row) => age(row.updated_at) },
];

/** The filters of the address as conditions of a bulk action. */
function filterOf(fleet, { connection, attention, label, q }) {
  const filter = { fleet, connection, attention: attention && attention === "true", label, q };
  return Object.fromEntries(Object.entries(filter).filter(([, value]) => value !== undefined && value !== ""));
}

export default {
  async load({ fleet }, state) {
    const [about, page, waiting, told] = await Promise.all([
      get(api.fleet(fleet)),
      robots.load(state, { fleet }),
      proposalsOf({ fleet }),
      boardOf({ ...state, label: undefined, q: undefined }, fleet),
    ]);
    return { about, page, waiting, told, state };
  },

  view({ about, page, waiting, told, state }, { fleet }, refresh) {
    return [
      trail(["Fleets", link.fleets()]),
      h(
        "div",
        { class: "headline" },
        h("h1", { tabindex: "-1" }, `Fleet ${fleet}`),
        told ? h("p", { class: "summary" }, verdict(told)) : null,
      ),
      h("p", { class: "marks" }, supervision(about), waits(about)),
      h(
        "p",
        {},
        `${present(about)}; ${count(about.whiskers, "whisker")}, ${about.whiskers_healthy} healthy.`,
      ),
      h(
        "p",
        { class: "links" },
        h("a", { href: link.whiskers({ fleet }) }, "Whiskers"),
        h("a", { href: link.compensations({ fleet }) }, "Compensations"),
        has("GET", ROUTES.policy) ? h("a", { href: link.policy(fleet) }, "Policy") : null,
      ),
      proposals(waiting, refresh),
      about.robots ? board(told, { fleet }) : null,
      robots.view(page, {
        columns: COLUMNS,
        key: (row) => `robot-${row.robot}`,
        total: about.robots,
        actions: page.items.length ? robotsActions(filterOf(fleet, state), shownOf(page, state), refresh) : null,
        empty: "No robot of this fleet is known yet.",
      }),
    ];
  },
};
