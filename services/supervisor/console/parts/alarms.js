// Alarms as cards by robot and array, each with what to do, and storms of alarms as one card.

import { changed } from "../address.js";
import { list, withQuery } from "../api.js";
import { h } from "../dom.js";
import { count, mm, time } from "../format.js";
import { mark, markOf } from "../marks.js";
import { link, whiskerName } from "../places.js";
import { boxLink } from "./boxes.js";
import { whyNotSet } from "./story.js";
import { ALARM_KINDS, ALARM_LEVELS, ALARM_STATES, REFUSALS, say } from "../words.js";

/** Most alarms of an unfolded storm that are shown on the page. */
const MEMBERS = 50;

const stormOf = (row) => `${row.fleet}:${row.kind}:${row.fold.first_raised_at}`;
const isStorm = (row) => row.fold !== undefined && row.fold.alarms > 1;

/** Whether a storm has this name, also after the end of its first alarms. */
function isNamed(row, name) {
  const start = `${row.fleet}:${row.kind}:`;
  return name.startsWith(start) && Date.parse(name.slice(start.length)) <= Date.parse(row.fold.last_raised_at);
}

/** The alarms of the unfolded storm by the storm's name; none of a storm that is not on the page. */
export async function storms(rows, filter, unfolded) {
  const row = unfolded && rows.find((one) => isStorm(one) && isNamed(one, unfolded));
  if (!row) return new Map();
  // `to` is exclusive, and times have microseconds.
  const to = new Date(new Date(row.fold.last_raised_at).getTime() + 1000).toISOString();
  const times = { from: row.fold.first_raised_at, to };
  const asked = { ...filter, fleet: row.fleet, kind: row.kind, standing: true, sort: "urgency", ...times, limit: MEMBERS };
  return new Map([[stormOf(row), await list("/v1/alarms", asked)]]);
}

/** Cards of alarms under the robot and array that neighbouring rows share. `actions` makes the buttons of an alarm. */
export function alarmGroups(rows, members, actions) {
  const groups = [];
  for (const row of rows) {
    const storm = `storm-${row.fleet}:${row.kind}:`;
    const stormKey = () => `${storm}${groups.filter((one) => one.key.startsWith(storm)).length}`;
    const key = isStorm(row) ? stormKey() : `${row.fleet}/${row.robot}/${row.array ?? ""}`;
    const last = groups.at(-1);
    if (last?.key === key && !isStorm(row)) last.rows.push(row);
    else groups.push({ key, rows: [row] });
  }
  const group = ({ key, rows: [first, ...others] }) =>
    h(
      "li",
      { class: "group", "data-key": `group-${key}` },
      isStorm(first) ? storm(first, members, actions) : [place(first), cards([first, ...others], actions)],
    );
  return h("ul", { class: "groups" }, groups.map(group));
}

/** The heading of a group: where its alarms are. */
function place(row) {
  const whole = row.array === null ? "whole robot" : `array ${row.array}`;
  return h(
    "h2",
    { class: "place" },
    h("a", { href: link.fleet(row.fleet) }, row.fleet),
    h("span", { "aria-hidden": "true" }, " \u203a "),
    h("a", { href: link.robot(row) }, row.robot),
    `, ${whole}`,
  );
}

function cards(rows, actions) {
  return h(
    "ul",
    { class: "alarms" },
    rows.map((row) => card(row, actions)),
  );
}

function card(row, actions) {
  return h(
    "li",
    { class: `alarm ${row.level.toLowerCase()}`, "data-key": `alarm-${row.alarm_id}`, "data-kind": row.kind },
    h(
      "div",
      { class: "about" },
      h("h3", {}, level(row), subject(row), howBad(row)),
      why(row),
      h("p", { class: "marks" }, state(row), h("span", {}, "raised ", time(row.raised_at)), cleared(row), boxLink(row.black_box_id)),
      row.cleared_at ? null : h("p", {}, row.hint),
      guidance(row),
    ),
    buttonsOf(actions(row)),
  );
}

/** The buttons that mend the cause, and then those about the alarm itself. */
function buttonsOf({ work, alarm }) {
  if (!work.length && !alarm.length) return null;
  return h("div", { class: "buttons work" }, work.length ? h("div", { class: "mend" }, work) : null, h("div", { class: "about-it" }, alarm));
}

/** How much of the whisker is missing. */
function howBad({ lost_mm: lost }) {
  return lost >= 0.5 ? h("span", { class: "how-bad" }, `${mm(lost, 1)} lost`) : null;
}

/** Why exactly: attempts at a setpoint, or reasons of a decision, with a link to it. */
function why(row) {
  const notSet = whyNotSet(row);
  const refused = row.refused ? `${count(row.refused_candidates, "candidate")} refused: ${say(REFUSALS, row.refused)}` : null;
  const words = notSet ?? refused;
  const isDecided = ["UNCOMPENSATED", "PROPOSED"].includes(row.kind) && row.compensation_id !== null;
  if (!words && !isDecided) return null;
  const to = row.kind === "PROPOSED" ? "Judge the proposal" : "Decision and alternatives";
  return h("p", { class: "why" }, words, words && isDecided ? " \u00b7 " : null, isDecided ? h("a", { href: link.compensation(row.compensation_id) }, to) : null);
}

/** The mark of an alarm's level with its kind as words. */
function level(row) {
  const [words, tone, shape] = ALARM_LEVELS[row.level] ?? [row.level, "off", "ring"];
  return [mark(words.split(":")[0], tone, shape), h("span", {}, say(ALARM_KINDS, row.kind))];
}

function subject(row) {
  if (row.array === null) return null;
  return h("a", { href: link.whisker(row) }, `whisker ${whiskerName(row)}`);
}

function cleared(row) {
  return row.cleared_at ? h("span", {}, "cleared ", time(row.cleared_at)) : null;
}

/** Likely causes and the runbook, on request. */
function guidance(row) {
  return h(
    "details",
    {},
    h("summary", {}, "Likely causes and runbook"),
    row.causes.length ? h("ol", {}, row.causes.map((cause) => h("li", {}, cause))) : null,
    h("p", {}, h("a", { href: runbook(row), target: "_blank", rel: "noreferrer" }, isOne(row) ? `Runbook for ${row.robot}` : "Runbook")),
  );
}

const isOne = (row) => !isStorm(row);

/** The address of the runbook; this service fills in the names of the alarm's subject. */
function runbook(row) {
  const { fleet, robot, array, whisker } = row;
  if (!row.runbook_url.startsWith("/")) return row.runbook_url;
  const own = row.runbook_url.replace(/^\/(.*\/)?(?=runbooks\/)/, "");
  return withQuery(own, isOne(row) ? { fleet, robot, array, whisker } : { fleet });
}

function state(alarm) {
  const by =
    {
      ACKNOWLEDGED: [alarm.acknowledged_by, alarm.acknowledged_reason],
      SHELVED: [alarm.shelved_by, alarm.shelved_reason],
    }[alarm.state] ?? [];
  const words = [by[0] && `by ${by[0]}`, by[1] && `\u201c${by[1]}\u201d`].filter(Boolean).join(": ");
  return [
    markOf(ALARM_STATES, alarm.state),
    alarm.maintenance_id ? h("span", {}, "in maintenance") : null,
    alarm.state === "SHELVED" && alarm.shelved_until ? h("span", {}, "until ", time(alarm.shelved_until)) : null,
    words ? h("span", {}, words) : null,
  ];
}

/** Shelved alarms, so that nobody forgets them; null without any. `more` is the address of all, if there are more. */
export function shelved(rows, more, actions) {
  if (!rows.length) return null;
  return [
    h("h2", {}, "Shelved"),
    h("p", { class: "hint" }, "Their causes still exist. They are silent until the time that somebody has set, and stand again then."),
    h("ul", { class: "alarms shelved" }, rows.map((row) => member(row, actions, say(ALARM_KINDS, row.kind)))),
    more ? h("p", {}, h("a", { href: more }, "All shelved alarms")) : null,
  ];
}

/** One card for all alarms of a storm, and its alarms once it is unfolded. */
function storm(row, members, actions) {
  const known = members.get(stormOf(row));
  const { alarms, robots, unacknowledged } = row.fold;
  const all = { fleet: row.fleet, kind: row.kind, storm: null, cursor: null };
  return [
    h(
      "h2",
      { class: "place" },
      h("a", { href: link.fleet(row.fleet) }, row.fleet),
      row.kind === "ROBOT_SILENT" ? `: ${count(robots, "robot")} silent or not connected` : `, ${count(robots, "robot")}: ${count(alarms, "alarm")} of one kind`,
    ),
    h(
      "div",
      { class: `alarm storm ${row.level.toLowerCase()}`, "data-kind": row.kind },
      h(
        "div",
        { class: "about" },
        h("h3", {}, level(row)),
        h(
          "p",
          { class: "marks" },
          h("span", {}, unacknowledged ? `${unacknowledged.toLocaleString("en")} not acknowledged` : "all acknowledged"),
          h("span", {}, "raised from ", time(row.fold.first_raised_at), " to ", time(row.fold.last_raised_at)),
        ),
        h("p", {}, row.hint),
        guidance(row),
      ),
      h(
        "div",
        { class: "buttons" },
        h(
          "a",
          {
            class: "button",
            href: changed({ storm: known ? null : stormOf(row) }),
            "aria-expanded": known ? "true" : "false",
            role: "button",
          },
          known ? "Fold" : `Show the ${count(alarms, "alarm")}`,
        ),
        h("a", { class: "button", href: changed(all) }, "Only these"),
      ),
    ),
    known ? cardsOfStorm(known, alarms, all, actions) : null,
  ];
}

function cardsOfStorm(rows, alarms, all, actions) {
  const more = alarms - rows.length;
  return [
    h("ul", { class: "alarms members" }, rows.map((row) => member(row, actions))),
    more > 0 ? h("p", {}, h("a", { href: changed({ ...all, fold: "no" }) }, `List all ${alarms.toLocaleString("en")}`)) : null,
  ];
}

/** An alarm of a storm: only where it is, because its kind and what to do are told once. */
function member(row, actions, kind = null) {
  const where =
    row.array === null
      ? h("a", { href: link.robot(row) }, row.robot)
      : h("a", { href: link.whisker(row) }, `${row.robot}, whisker ${whiskerName(row)}`);
  return h(
    "li",
    { class: "alarm", "data-key": `member-${row.alarm_id}` },
    h("div", { class: "about" }, h("p", { class: "marks" }, kind ? h("strong", {}, kind) : null, where, howBad(row), state(row), h("span", {}, time(row.raised_at)), boxLink(row.black_box_id))),
    buttonsOf(actions(row)),
  );
}
