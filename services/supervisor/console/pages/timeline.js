// The timeline: what happened between two times, with filters by robot, whisker, person and kind in the address.

import { changed, stateOf } from "../address.js";
import { has } from "../api.js";
import { browser, optionsOf } from "../browse.js";
import { h } from "../dom.js";
import { moment } from "../format.js";
import { entriesList } from "../parts/entries.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { fromOf, SINCE } from "../parts/since.js";
import { AUDIT_KINDS, TIMELINE_KINDS } from "../words.js";
import { fromField, toField } from "../zone.js";

const ROUTE = "/v1/timeline";
/** Lines of a page: each is one row. */
const ROWS = 200;
const HOUR_MS = 3_600_000;

const timeline = (fleets) =>
  browser({
    route: ROUTE,
    what: "events",
    rows: ROWS,
    filters: [
      { ...SINCE, empty: "last 24 hours", clears: ["from", "to"] },
      { name: "from", label: "From", time: true },
      { name: "to", label: "To", time: true },
      ...fleetFilter(fleets),
      { name: "robot", label: "Robot", text: true },
      { name: "array", label: "Array", text: true },
      { name: "whisker", label: "Whisker", text: true, maxlength: 5, clean: (text) => text.replace(/\D/g, "") },
      { name: "kind", label: "Kind", options: optionsOf({ ...TIMELINE_KINDS, ACTION: "action of a person" }) },
      { name: "action", label: "Action", options: optionsOf(AUDIT_KINDS) },
      { name: "actor", label: "Person", text: true, maxlength: 200 },
    ],
  });

/** Spans in one click: names, and begin and end as moments. */
function spans(now) {
  const midnight = (at) => fromField(`${toField(at).slice(0, 10)}T00:00`);
  const today = midnight(now);
  // Days have 23 to 25 hours.
  const yesterday = midnight(today - 12 * HOUR_MS);
  return [
    ["Last hour", now - HOUR_MS, null],
    ["Last night", today - 4 * HOUR_MS, today + 8 * HOUR_MS],
    ["Today", today, null],
    ["Yesterday", yesterday, today],
  ];
}

export default {
  async load(_, state) {
    if (!has("GET", ROUTE)) return null;
    const fleets = await fleetsOf();
    const from = state.from ?? fromOf(state).from;
    return { fleets, page: await timeline(fleets).load(state, { since: undefined, from }) };
  },

  view(data) {
    const heading = h("h1", { tabindex: "-1" }, "Timeline");
    if (!data) return [heading, h("p", { class: "empty" }, "This service has no timeline.")];
    const { fleets, page } = data;
    const iso = (at) => (at === null ? null : new Date(at).toISOString());
    const quick = ([words, from, to]) =>
      h("a", { href: changed({ from: iso(from), to: iso(to), since: null, cursor: null }) }, words);
    return [
      heading,
      h("p", { class: "summary" }, spanOf(stateOf(location.hash))),
      h("p", { class: "links" }, spans(Date.now()).map(quick)),
      timeline(fleets).view(page, {
        body: entriesList(page.items, { withFleet: fleets.length > 1, empty: "" }),
        empty:
          "Nothing happened in this time. The log keeps trims, alarms and compensations for a week, and other events for a day.",
      }),
    ];
  },
};

function spanOf({ from, to, since }) {
  const begin = from ? moment(from) : `${SINCE.options.find(([name]) => name === since)?.[1] ?? "last 24 hours"}`;
  if (!from && !to) return `What happened in the ${begin}, the newest first.`;
  return `What happened ${from ? `from ${begin}` : "in the day"} ${to ? `to ${moment(to)}` : "until now"}, the newest first.`;
}
