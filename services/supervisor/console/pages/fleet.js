// A fleet with its robots, those that need attention first.

import { get, has, list } from "../api.js";
import { h } from "../dom.js";
import { count, time } from "../format.js";
import { markOf } from "../marks.js";
import { api, link, ROUTES } from "../places.js";
import { proposals, proposalsOf } from "../parts/proposals.js";
import { table, trail } from "../table.js";
import { CONNECTIONS } from "../words.js";
import { health, supervision } from "./fleets.js";

export default {
  async load({ fleet }) {
    const [about, robots, waiting] = await Promise.all([
      get(api.fleet(fleet)),
      list("/v1/robots", { fleet, sort: "attention", order: "descending" }),
      proposalsOf({ fleet }),
    ]);
    return { about, robots, waiting };
  },

  view({ about, robots, waiting }, { fleet }, refresh) {
    return [
      trail(["Fleets", link.fleets()]),
      h("h1", { tabindex: "-1" }, `Fleet ${fleet}`),
      h("p", { class: "marks" }, supervision(about), health(about)),
      h(
        "p",
        {},
        `${count(about.robots, "robot")}, ${about.robots_online} online; ${count(about.whiskers, "whisker")}, ${about.whiskers_healthy} healthy.`,
      ),
      has("GET", ROUTES.policy) ? h("p", {}, h("a", { href: link.policy(fleet) }, "Policy")) : null,
      proposals(waiting, refresh),
      table({
        caption: "Robots, those that need attention first",
        rows: robots,
        key: (row) => `robot-${row.robot}`,
        empty: "No robot of this fleet is known yet.",
        columns: [
          { name: "Robot", head: true, cell: (row) => h("a", { href: link.robot(row) }, row.robot) },
          { name: "Connection", cell: (row) => markOf(CONNECTIONS, row.connection) },
          { name: "Needs attention", cell: (row) => h("span", { class: "marks" }, health(row)) },
          {
            name: "Whiskers",
            cell: (row) => `${row.whiskers_healthy} of ${row.whiskers} healthy, in ${count(row.arrays, "array")}`,
          },
          { name: "Last message", cell: (row) => time(row.updated_at) },
        ],
      }),
    ];
  },
};
