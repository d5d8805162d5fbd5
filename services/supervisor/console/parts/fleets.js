// The filter by fleet, which several pages have.

import { list } from "../api.js";

/** The names of the fleets, in order. */
export async function fleetsOf() {
  return (await list("/v1/fleets", { sort: "fleet" })).map(({ fleet }) => fleet);
}

/** The filter; none if there is no choice. */
export function fleetFilter(fleets) {
  return fleets.length > 1 ? [{ name: "fleet", label: "Fleet", options: fleets.map((fleet) => [fleet, fleet]) }] : [];
}
