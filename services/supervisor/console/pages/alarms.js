// Alarms: the standing ones by robot and array, the most urgent first, with storms folded; and the cleared ones.
// The address holds filters and page; the service groups, orders and counts.

import { changed } from "../address.js";
import { get, has, list } from "../api.js";
import { alarmActions, alarmsActions, workActions } from "../actions.js";
import { browser, optionsOf } from "../browse.js";
import { h } from "../dom.js";
import { count } from "../format.js";
import { mark } from "../marks.js";
import { alarmGroups, shelved, storms } from "../parts/alarms.js";
import { fleetFilter, fleetsOf } from "../parts/fleets.js";
import { LABEL_FILTER } from "../parts/labels.js";
import { maintenanceOf, maintenancePart } from "../parts/maintenance.js";
import { fromOf, SINCE } from "../parts/since.js";
import { api, link } from "../places.js";
import { section } from "../table.js";
import { ALARM_KINDS, ALARM_LEVELS } from "../words.js";

const STATES = [
  ["UNACKNOWLEDGED", "not acknowledged"],
  ["ACKNOWLEDGED", "acknowledged"],
  ["SHELVED", "shelved"],
  ["CLEARED", "cleared"],
];

const RAISED = "Alarms that were raised in this time, the newest first, whether they still stand or not.";

/** Most shelved alarms below the others. */
const SHELVED = 20;

const FILTERS = ["fleet", "robot", "array", "kind", "level", "state", "label", "q"];

const alarms = (fleets, route) =>
  browser({
    route,
    what: "alarms",
    search: "robot, array, kind or comment",
    filters: [
      ...fleetFilter(fleets),
      { name: "level", label: "Level", options: optionsOf(ALARM_LEVELS).reverse() },
      { name: "kind", label: "Kind", options: optionsOf(ALARM_KINDS) },
      { name: "state", label: "State", empty: "standing, not shelved", options: STATES },
      { ...SINCE, label: "Raised", empty: "any time" },
      { name: "robot", label: "Robot", text: true },
      LABEL_FILTER,
    ],
  });

/** The filters of an address as parameters of the API. */
function filterOf(state) {
  const filter = Object.fromEntries(FILTERS.filter((name) => state[name]).map((name) => [name, state[name]]));
  return filter.state ? filter : { ...filter, open: true };
}

export default {
  async load(_, state) {
    const [told, linked] = await Promise.all([listed(state), linkedOf(state)]);
    return { ...told, linked };
  },

  view({ fleets, page, filter, counts, silenced = [], windows, members, since, linked }, _, refresh) {
    const actions = (row) => ({ work: workActions(row, refresh), alarm: alarmActions(row, refresh) });
    return [
      h("h1", { tabindex: "-1" }, "Alarms"),
      has("GET", "/v1/alarms/statistics") ? h("p", { class: "links" }, h("a", { href: link.alarmStatistics() }, "Statistics")) : null,
      linked && section("Alarm of the link", linkedPart(linked, actions)),
      counts ? summary(counts, filter) : h("p", { class: "summary" }, since ? RAISED : "Alarms whose cause is over, the newest first."),
      alarms(fleets, "").view(page, {
        body: [
          counts ? atOnce(counts, filter, refresh) : null,
          page.items.length ? alarmGroups(page.items, members, actions) : null,
        ],
        empty: none(filter),
      }),
      shelved(silenced.slice(0, SHELVED), silenced.length > SHELVED && changed({ state: "SHELVED" }), actions),
      maintenancePart(windows, fleets, refresh),
    ];
  },
};

/** The alarm that a link names, standing or cleared: its own list may be far from it. */
async function linkedOf({ alarm_id: id }) {
  if (!id || !has("GET", "/v1/alarms/{}")) return null;
  return get(api.alarm(id)).catch((problem) => {
    if (![404, 422].includes(problem.status)) throw problem;
    return { alarm_id: id, isUnknown: true };
  });
}

function linkedPart(linked, actions) {
  return [
    linked.isUnknown
      ? h("p", { class: "empty" }, `Alarm ${linked.alarm_id} is not stored any more.`)
      : alarmGroups([linked], new Map(), actions),
    h("p", {}, h("a", { href: changed({ alarm_id: null }) }, "Show only the list below")),
  ];
}

async function listed(state) {
  const fleets = await fleetsOf();
  const filter = filterOf(state);
  if (state.since) {
    // All alarms of that time, whether they stand or not.
    const fixed = { ...fromOf(state), sort: "raised_at" };
    const page = await alarms(fleets, "/v1/alarms").load(state, fixed);
    return { fleets, page, filter, counts: null, members: new Map(), since: state.since };
  }
  if (state.state === "CLEARED") {
    const page = await alarms(fleets, "/v1/alarms").load(state, { standing: false, sort: "raised_at" });
    return { fleets, page, filter, counts: null, members: new Map() };
  }
  const isFlat = state.fold === "no";
  const route = isFlat ? "/v1/alarms" : "/v1/alarms/folded";
  const fixed = { ...filter, ...(isFlat ? { standing: true, sort: "urgency" } : { sort: undefined, order: undefined }) };
  const { open, ...conditions } = filter;
  const isFirst = open && !state.cursor;
  const [page, counts, silenced, windows] = await Promise.all([
    alarms(fleets, route).load(state, fixed),
    list("/v1/alarms/counts", filter),
    isFirst ? list("/v1/alarms", { ...conditions, state: "SHELVED", standing: true, sort: "urgency", limit: SHELVED + 1 }) : [],
    isFirst ? maintenanceOf() : null,
  ]);
  return { fleets, page, filter, counts, silenced, windows, members: await storms(page.items, filter, state.storm) };
}

/** Words without an alarm: others may stand that a filter leaves out. */
function none(filter) {
  const isFiltered = Object.entries(filter).some(([name, value]) => name !== "open" && value);
  return isFiltered ? "No standing alarms match." : "No standing alarms.";
}

function summary(counts, filter) {
  const total = sum(counts, "alarms");
  if (!total) return h("p", { class: "summary" }, none(filter));
  const open = sum(counts, "unacknowledged");
  const levels = Object.keys(ALARM_LEVELS).reverse();
  const kinds = Map.groupBy(counts, (one) => one.level);
  const marks = levels.map((level) => {
    const [words, tone, shape] = ALARM_LEVELS[level];
    const alarms = sum(kinds.get(level) ?? [], "alarms");
    if (!alarms) return null;
    const isChosen = filter.level === level;
    const href = changed({ level: isChosen ? null : level, cursor: null });
    const shown = mark(`${alarms.toLocaleString("en")} ${words.split(":")[0]}`, tone, shape);
    return h("a", { class: "level", href, "aria-current": isChosen ? "true" : null }, shown);
  });
  return [
    h(
      "p",
      { class: "summary" },
      `${count(total, "alarm")}${open ? `, ${open === total ? "none" : `${(total - open).toLocaleString("en")} of them`} acknowledged` : ", all acknowledged"}.`,
    ),
    h("p", { class: "marks" }, marks),
  ];
}

/** Buttons for everything that the filters show, on this page and the others. */
function atOnce(counts, filter, refresh) {
  // One alarm has its own buttons.
  if (sum(counts, "alarms") < 2) return null;
  const buttons = alarmsActions(filter, { alarms: sum(counts, "alarms"), open: sum(counts, "unacknowledged") }, refresh);
  return buttons.length ? h("div", { class: "buttons" }, buttons) : null;
}

const sum = (rows, name) => rows.reduce((sum, row) => sum + row[name], 0);
