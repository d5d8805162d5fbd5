// The filter by fleet, which several pages have.

import { list } from "../api.js";

/** The names of the fleets, in order. */
export async function fleetsOf() {
  return (await list("/v1/fleets", { sort: "fleet" })).map(({ fleet }) => fleet);
}

/** Most characters of a filter: 100 names and patterns of 64 characters, and commas. */
const LENGTH_MAX = 6499;
/** What may be written into a field for fleets. */
export const FLEETS_RULE = "Names separated by commas. * stands for any characters: hall-* means all halls.";

/** The API takes no spaces between names. */
const withoutSpaces = (text) => text.replace(/\s+/g, "");

/** The filter for names and patterns; none if there is no choice. */
export function fleetFilter(fleets) {
  if (fleets.length < 2) return [];
  const field = { name: "fleet", label: "Fleets", text: true, maxlength: LENGTH_MAX, clean: withoutSpaces };
  return [{ ...field, placeholder: "all, or hall-*", title: FLEETS_RULE, suggestions: fleets }];
}
