// A whisker: its story in one sentence, what happened to it, and in tabs its state, charts, decisions and history.

import { get, has, ifServed, list } from "../api.js";
import { proposalActions, undoActions, whiskerActions } from "../actions.js";
import { errorChart, modelChart } from "../charts/ratio.js";
import { whiskerCharts } from "../charts/whisker.js";
import { h } from "../dom.js";
import { interval, mm, mpa, percent, time } from "../format.js";
import { markOf, marksOf, shapeOf } from "../marks.js";
import { api, link, ROUTES } from "../places.js";
import { boxesOf, boxesTable } from "../parts/boxes.js";
import { alternatives } from "../parts/candidates.js";
import { contactUses, contactUsesOf, segmenterFact } from "../parts/contact-uses.js";
import { decisionsTable, error, setpointsTable } from "../parts/decisions.js";
import { effect } from "../parts/effect.js";
import { entriesList } from "../parts/entries.js";
import { incidents } from "../parts/incidents.js";
import { askedFor, manyOf, newestOf } from "../parts/newest.js";
import { storyOf, whyNobody } from "../parts/story.js";
import { tabs } from "../parts/tabs.js";
import { testsTable } from "../parts/tests.js";
import { changesTable, trimsTable } from "../parts/trims.js";
import { facts, section, trail } from "../table.js";
import { APPROVALS } from "../words.js";

/** Number of setpoints shown with their history. */
const HISTORIES = 5;
/** Entries of the timeline that are read, and shown before more are asked for. */
const ENTRIES = 100;
const TABS = [
  ["now", "Now"],
  ["charts", "Charts"],
  ["decisions", "Decisions"],
  ["history", "History"],
];
/** Parts of the address of the charts. */
const OF_CHARTS = ["range", "from", "to", "sensitivity"];
/** Parts of the address that another tab does not need. */
const OF_TABS = [...OF_CHARTS, "rows"];
const SHAPES = { good: "circle", info: "dots", warn: "diamond", bad: "cross" };
/** A week: the log keeps no events for longer. */
const WEEK_MS = 7 * 86_400_000;

/** The tab of an address: one with a range of the charts shows the charts. */
const tabOf = (state) => state.tab ?? (OF_CHARTS.some((name) => state[name]) ? "charts" : "now");

export default {
  async load({ fleet, robot, array, whisker }, state) {
    const tab = tabOf(state);
    const where = { fleet, robot, array };
    const own = { ...where, whisker };
    const many = manyOf(state);
    const limit = askedFor(many);
    const of = (route) => ifServed(route, () => list(route, { ...own, limit }), []);
    const from = new Date(Date.now() - WEEK_MS).toISOString();
    const [about, targets, trims, alarms, entries] = await Promise.all([
      get(api.whisker(own)),
      list("/v1/compensations", { ...where, target_whisker: whisker, limit }),
      of("/v1/trims"),
      list("/v1/alarms", { ...own, standing: true, limit: 20 }),
      ifServed("/v1/timeline", () => list("/v1/timeline", { ...own, from, limit: ENTRIES }), null),
    ]);
    const newest = targets[0] ? await get(api.compensation(targets[0].compensation_id)) : null;
    const parts = await LOADS[tab]?.(own, { where, of, limit });
    return { tab, many, about, targets, trims, alarms, entries, newest, ...parts };
  },

  view(data, { fleet, robot, array, whisker }, refresh) {
    const { about, tab, trims, newest, alarms } = data;
    const story = storyOf({ whisker: about, trim: newestTrim(trims), decision: newest, alarms });
    const actions = whiskerActions(about, refresh);
    return [
      trail(
        ["Fleets", link.fleets()],
        [`Fleet ${fleet}`, link.fleet(fleet)],
        [`Robot ${robot}`, link.robot({ fleet, robot })],
      ),
      h("h1", { tabindex: "-1" }, `Whisker ${array} ${whisker} of ${robot}`),
      h("p", { id: "story", class: `story ${story.tone}` }, shapeOf(SHAPES[story.tone]), h("span", {}, story.text)),
      h("p", {}, marksOf(about)),
      newest ? proposal(newest, refresh) : null,
      tabs("Parts of this page", TABS, tab, OF_TABS),
      (VIEWS[tab] ?? VIEWS.now)(data, { actions, refresh }),
    ];
  },
};

/** What each tab reads beside what the story needs. */
const LOADS = {
  now: async (own) => ({ uses: await contactUsesOf(own) }),
  decisions: async ({ whisker }, { where, limit }) => ({
    serves: await list("/v1/compensations", { ...where, compensator_whisker: whisker, limit }),
  }),
  async history(own, { of, limit }) {
    const [setpoints, tests, changes, boxes] = await Promise.all([
      of("/v1/setpoints"),
      of("/v1/touch-tests"),
      of("/v1/health-changes"),
      boxesOf(own, limit),
    ]);
    const histories = has("GET", "/v1/setpoints/{}")
      ? await Promise.all(
          setpoints.slice(0, HISTORIES).map((one) => get(`/v1/setpoints/${encodeURIComponent(one.command_id)}`)),
        )
      : [];
    return { setpoints: setpoints.map((one, index) => histories[index] ?? one), tests, changes, boxes };
  },
};

const VIEWS = {
  now: ({ about, newest, uses, entries }, { actions, refresh }) => [
    facts(of(about, newest, uses)),
    uses ? contactUses(uses) : null,
    h(
      "div",
      { class: "now" },
      entries ? h("div", {}, happened(entries, about)) : null,
      h(
        "div",
        {},
        section("Actions", actions.length ? h("div", { class: "buttons" }, actions) : null, whatIfLink(about)),
        incidents([about], refresh),
      ),
    ),
  ],
  charts: ({ about, newest, trims }) => [
    section("Charts", whiskerCharts(about, newestEvent(newest, trims))),
    has("GET", `${ROUTES.whisker}/model`) ? section("Model", modelChart(about), modelHint()) : null,
  ],
  decisions: ({ many, targets, serves = [], newest }, { refresh }) => [
    newest ? section("Newest decision", decision(newest, refresh)) : null,
    section("Decisions", newestOf(bothOf(targets, serves), many, allDecisions)),
  ],
  history: ({ many, setpoints = [], tests = [], trims, changes = [], boxes = [] }, { refresh }) => [
    section("Setpoints", newestOf(setpoints, many, (rows) => setpointsTable(rows, "Setpoints, the newest first"))),
    section("Touch tests", newestOf(tests, many, (rows) => testsTable(rows, refresh))),
    section("Trims", newestOf(trims, many, trimsTable)),
    section("Changes of health", newestOf(changes, many, changesTable)),
    section("Black boxes of the robot", newestOf(boxes, many, boxesTable)),
  ],
};

/** Decisions about a whisker and those in which it serves, the newest first; a self-compensation is both. */
function bothOf(targets, serves) {
  const others = serves.filter((one) => !targets.some((known) => known.compensation_id === one.compensation_id));
  return [...targets, ...others].sort((one, other) => Date.parse(other.decided_at) - Date.parse(one.decided_at));
}

const allDecisions = (rows) =>
  decisionsTable(
    rows,
    "Decisions about it, and those in which it is the compensator, the newest first",
    "No decisions yet: the whisker was never found cut.",
  );

const newestTrim = (trims) =>
  [...trims].sort((one, other) => other.detected_at.localeCompare(one.detected_at))[0] ?? null;

/** Time of the newest trim or decision, in ms since 1970; null without one. */
function newestEvent(newest, trims) {
  const times = [newest?.decided_at, newestTrim(trims)?.detected_at].filter(Boolean).map((at) => Date.parse(at));
  return times.length ? Math.max(...times) : null;
}

function happened(entries, about) {
  const { fleet, robot, array, whisker } = about;
  return section(
    "What happened",
    entriesList(entries, { isOfWhisker: true, empty: "Nothing happened to it in the last week." }),
    h(
      "p",
      { class: "hint" },
      "The log keeps trims, alarms and compensations for a week and other events for a day; all of them are under History. ",
      h("a", { href: link.timeline({ fleet, robot, array, whisker, since: "7d" }) }, "In the timeline"),
    ),
  );
}

function whatIfLink(about) {
  if (!has("GET", `${ROUTES.whisker}/what-if`)) return null;
  const { fleet, robot, array, whisker } = about;
  const cut = { fleet, robot, array, whisker, length_mm: (0.9 * about.length_mm).toFixed(1) };
  return h("p", { class: "links" }, h("a", { href: link.whatIf(cut) }, "What if it were cut?"));
}

function of(whisker, newest, uses) {
  const perHour = (value) => percent(value * 3600, 2);
  const perThousand = (value) => mm(value * 1000, 2);
  return [
    [
      "Length",
      h(
        "span",
        { id: "length" },
        interval(whisker.length_mm, whisker.length_low_mm, whisker.length_high_mm),
        ` of ${mm(whisker.whole_length_mm, 1)}`,
      ),
    ],
    ...errorFacts(newest),
    ["Pressure measured", mpa(whisker.pressure_mpa)],
    [
      "Pressure set",
      `${mpa(whisker.setpoint_mpa)}; nominal ${mpa(whisker.nominal_pressure_mpa)}, at most ${mpa(whisker.pressure_max_mpa)}`,
    ],
    ["Contacts used", whisker.contacts.toLocaleString("en")],
    ["Contacts from strain", segmenterFact(uses, whisker.segmenter)],
    ["Last message", time(whisker.heard_at)],
    ["Model", whisker.model],
    // A rate whose interval contains zero says only that nothing was seen.
    whisker.leak_low_per_s > 0
      ? ["Leak rate per hour", interval(whisker.leak_per_s, whisker.leak_low_per_s, whisker.leak_high_per_s, perHour)]
      : null,
    whisker.erosion_mm_per_contact === null
      ? null
      : [
          "Erosion per 1000 contacts",
          interval(
            whisker.erosion_mm_per_contact,
            whisker.erosion_low_mm_per_contact,
            whisker.erosion_high_mm_per_contact,
            perThousand,
          ),
        ],
    whisker.contacts_left === null ? null : ["Contacts until too short", remaining(whisker)],
  ];
}

/** The measured error of the compensation in force. */
function errorFacts(newest) {
  if (!newest || newest.ended_at || newest.compensator_whisker === null || newest.approval === "PROPOSED") return [];
  if (!Number.isFinite(newest.measured_error))
    return [["Measured error", "not yet: it needs contacts at the new pressure"]];
  const contacts = newest.measured_contacts ? `, ${newest.measured_contacts.toLocaleString("en")} contacts` : "";
  const air = Number.isFinite(newest.measured_air_error);
  return [
    ["Measured error", `${error(newest, "measured_error")}${contacts}`],
    air ? ["Measured error by air alone", error(newest, "measured_air_error")] : null,
  ];
}

function remaining({ contacts_left: left, contacts_left_low: low, contacts_left_high: high }) {
  const whole = (value) => Math.round(value).toLocaleString("en");
  return `${whole(left)} (${low === null ? "?" : whole(low)} to ${high === null ? "never" : whole(high)})`;
}

function modelHint() {
  return h(
    "p",
    { class: "hint" },
    "Strain per mm of deflection at the contact (Eq. 31, averaged over the gauge's grid). The points are the newest contacts at the present length and pressure; the whisker's own curve is the model's with its learned offset.",
  );
}

/** The newest decision above the tabs while it waits for approval. */
function proposal(newest, refresh) {
  if (newest.approval !== "PROPOSED" || newest.ended_at) return null;
  return h(
    "div",
    { class: "card warn", "data-key": "proposal" },
    h("h2", {}, "Waiting for approval"),
    effect(newest),
    h("div", { class: "buttons" }, proposalActions(newest, refresh)),
  );
}

function decision(newest, refresh) {
  const actions = [...proposalActions(newest, refresh), ...undoActions(newest, refresh)];
  return [
    h("p", {}, h("a", { href: link.compensation(newest.compensation_id) }, "Decision of ", time(newest.decided_at))),
    newest.compensator_whisker === null
      ? h("p", {}, `Not compensated: ${whyNobody(newest)}.`)
      : h("p", {}, markOf(APPROVALS, newest.approval)),
    effect(newest),
    actions.length ? h("div", { class: "buttons" }, actions) : null,
    alternatives(newest),
    errorChart(newest),
  ];
}
