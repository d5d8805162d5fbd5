// The setpoints that were sent to the robots of all fleets.

import { browser, optionsOf } from "../browse.js";
import { h } from "../dom.js";
import { mpa, time } from "../format.js";
import { markOf } from "../marks.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { fromOf, SINCE } from "../parts/since.js";
import { link, whiskerName } from "../places.js";
import { say, SETPOINT_ERRORS, SETPOINT_REASONS, SETPOINT_STATES } from "../words.js";

const setpoints = (fleets) =>
  browser({
    route: "/v1/setpoints",
    what: "setpoints",
    filters: [
      ...fleetFilter(fleets),
      SINCE,
      { name: "state", label: "State", options: optionsOf(SETPOINT_STATES) },
      { name: "robot", label: "Robot", text: true },
    ],
  });

const COLUMNS = [
  {
    name: "Sent",
    sort: "issued_at",
    descends: true,
    isDefault: true,
    head: true,
    cell: (row) => time(row.issued_at),
  },
  { name: "Robot", cell: (row) => h("a", { href: link.robot(row) }, `${row.fleet}, ${row.robot}`) },
  { name: "Whisker", cell: (row) => h("a", { href: link.whisker(row) }, whiskerName(row)) },
  { name: "Pressure", sort: "pressure_mpa", numeric: true, cell: (row) => mpa(row.pressure_mpa) },
  { name: "Reached", numeric: true, cell: (row) => mpa(row.reached_mpa) },
  {
    name: "State",
    cell: (row) => [markOf(SETPOINT_STATES, row.state), row.error ? ` ${say(SETPOINT_ERRORS, row.error)}` : null],
  },
  { name: "Reason", cell: (row) => say(SETPOINT_REASONS, row.reason) },
];

export default {
  async load(_, state) {
    const fleets = await fleetsOf();
    return { fleets, page: await setpoints(fleets).load(state, fromOf(state)) };
  },

  view({ fleets, page }) {
    return [
      h("h1", { tabindex: "-1" }, "Setpoints"),
      setpoints(fleets).view(page, {
        caption: "Setpoints",
        columns: COLUMNS,
        key: (row) => `setpoint-${row.command_id}`,
        empty: "No setpoint was sent yet.",
      }),
    ];
  },
};
