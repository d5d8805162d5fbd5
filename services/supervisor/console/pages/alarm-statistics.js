// Statistics of alarms by ISA-18.2: whether people can answer all of them, and which ones to mend first.

import { get, has } from "../api.js";
import { change } from "../address.js";
import { h } from "../dom.js";
import { count, time } from "../format.js";
import { mark } from "../marks.js";
import { link, whiskerName } from "../places.js";
import { fromOf, SINCE } from "../parts/since.js";
import { section, table, trail } from "../table.js";
import { ALARM_KINDS, ALARM_LEVELS, say } from "../words.js";

const ROUTE = "/v1/alarms/statistics";
/**
 * Alarms in an hour that one person can answer, and those beyond which nobody can: ISA-18.2's figures of 150 and 300 a
 * day.
 */
const RATES = [6, 12];
const SPANS = SINCE.options;

export default {
  async load(_, state) {
    if (!has("GET", ROUTE)) return null;
    const since = state.since ?? "7d";
    return { since, found: await get(ROUTE, { from: fromOf({ since }).from, fleet: state.fleet }) };
  },

  view(data) {
    const heading = h("h1", { tabindex: "-1" }, "Statistics of alarms");
    const way = trail(["Alarms", link.alarms()]);
    if (!data) return [way, heading, h("p", { class: "empty" }, "This service has no statistics of alarms.")];
    const { found, since } = data;
    return [
      way,
      heading,
      h("p", { class: "summary" }, verdict(found)),
      span(since),
      h("ul", { class: "figures" }, figures(found)),
      section("Levels", levels(found)),
      section(
        "Most alarms",
        subjects(
          found.top,
          "The ten whiskers or robots and kinds with the most alarms",
          "No alarms in this time.",
          found.alarms,
        ),
      ),
      section(
        "Chattering",
        subjects(
          found.chattering,
          "Alarms that came three times or more within ten minutes",
          "None: no alarm came and went three times within ten minutes.",
        ),
      ),
      section("Standing for more than a day", stale(found)),
      found.is_limited ? h("p", { class: "hint" }, "Only the newest 100,000 alarms of this time are counted.") : null,
    ];
  },
};

function verdict({ alarms, alarms_per_hour: rate, floods }) {
  if (!alarms) return "No alarms in this time.";
  const load =
    rate < RATES[0]
      ? "one person can answer all of them"
      : rate < RATES[1]
        ? "one person can hardly answer all of them"
        : "more than one person can answer";
  return `${count(alarms, "alarm")}, ${rateWords(rate)}: ${load}${floods ? `, and ${count(floods, "flood")} of more than 10 in ten minutes` : ""}.`;
}

const rateWords = (rate) => `${rate.toFixed(rate < 1 ? 2 : 1)} in an hour`;

function span(since) {
  const options = SPANS.map(([value, words]) => h("option", { value, selected: value === since }, words));
  return h(
    "form",
    { class: "tools", onsubmit: (event) => event.preventDefault() },
    h(
      "label",
      { class: "tool" },
      h("span", {}, "Time"),
      h(
        "select",
        {
          id: "filter-since",
          name: "since",
          "data-of-address": true,
          onchange: (event) => change({ since: event.target.value }),
        },
        options,
      ),
    ),
  );
}

function figures(found) {
  const one = (value, words, tone = null) => h("li", { class: tone }, h("strong", {}, value), h("span", {}, words));
  const rate = found.alarms_per_hour;
  return [
    one(
      rate.toFixed(rate < 1 ? 2 : 1),
      "alarms in an hour",
      rate < RATES[0] ? "good" : rate < RATES[1] ? "warn" : "bad",
    ),
    one(
      found.busiest_ten_minutes.toLocaleString("en"),
      "at most in ten minutes",
      found.busiest_ten_minutes > 10 ? "bad" : "good",
    ),
    one(duration(found.median_duration_s), "median duration"),
    one(duration(found.longest_duration_s), "longest duration"),
    one(found.standing.toLocaleString("en"), "standing now"),
    one(
      found.standing_over_a_day.toLocaleString("en"),
      "standing for more than a day",
      found.standing_over_a_day ? "warn" : "good",
    ),
  ];
}

/** "42 s", "3.5 min", "2.1 h", "4 days". */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "\u2013";
  const [value, unit] =
    seconds < 90
      ? [seconds, "s"]
      : seconds < 5_400
        ? [seconds / 60, "min"]
        : seconds < 172_800
          ? [seconds / 3_600, "h"]
          : [seconds / 86_400, "days"];
  return `${value.toFixed(value < 10 && unit !== "s" ? 1 : 0)}\u00a0${unit}`;
}

/** The worst level first, each as a part of all. */
function levels({ levels: rows, alarms }) {
  if (!alarms) return h("p", { class: "empty" }, "No alarms in this time.");
  const row = ({ level, alarms: many }) => {
    const [words, tone, shape] = ALARM_LEVELS[level];
    return h(
      "li",
      { class: tone },
      mark(words.split(":")[0], tone, shape),
      h("meter", { min: 0, max: alarms, value: many, "aria-label": `${words.split(":")[0]}: ${many} of ${alarms}` }),
      h("span", {}, `${many.toLocaleString("en")} (${Math.round((100 * many) / alarms)}\u00a0%)`),
    );
  };
  return h("ul", { class: "levels" }, [...rows].reverse().map(row));
}

const place = (row) =>
  row.array === null
    ? h("a", { href: link.robot(row) }, `${row.fleet}, ${row.robot}`)
    : h("a", { href: link.whisker(row) }, `${row.robot}, whisker ${whiskerName(row)}`);

function subjects(rows, caption, empty, all = null) {
  return table({
    caption,
    rows,
    empty,
    key: (row) => `${caption[0]}-${row.kind}-${row.fleet}-${row.robot}-${row.array}-${row.whisker}`,
    columns: [
      { name: "Alarm", head: true, cell: (row) => say(ALARM_KINDS, row.kind) },
      { name: "Where", cell: place },
      {
        name: "Alarms",
        numeric: true,
        cell: (row) =>
          `${row.alarms.toLocaleString("en")}${all ? ` (${Math.round((100 * row.alarms) / all)}\u00a0%)` : ""}`,
      },
      { name: "Chattering", numeric: true, cell: (row) => row.chattering || "\u2013" },
      { name: "Last raised", cell: (row) => time(row.last_raised_at) },
    ],
  });
}

function stale({ stale: rows, standing_over_a_day: many }) {
  return [
    table({
      caption: many > rows.length ? `The ${rows.length} oldest of ${many.toLocaleString("en")}` : "The oldest first",
      rows,
      empty: "None.",
      key: (row) => `stale-${row.alarm_id}`,
      columns: [
        { name: "Alarm", head: true, cell: (row) => say(ALARM_KINDS, row.kind) },
        { name: "Where", cell: place },
        { name: "Raised", cell: (row) => time(row.raised_at) },
      ],
    }),
  ];
}
