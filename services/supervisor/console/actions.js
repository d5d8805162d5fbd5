// Operators' actions, each with its effect on the robot.

import { ask, has } from "./api.js";
import { actionButton } from "./dialog.js";
import { h } from "./dom.js";
import { count, mpa } from "./format.js";
import { ventedAction } from "./parts/bulk.js";
import { api, ROUTES, whiskerName } from "./places.js";
import { ALARM_KINDS, say } from "./words.js";
import { fromField, toField, zone } from "./zone.js";

const withReason = (values) => ({ reason: values.reason?.trim() || undefined });

const offered = (base, name) => has("POST", `${base}/${name}`);

/** Each action on a whisker, made when it is needed: an alarm's whisker has its names only. */
function whiskerWork(whisker) {
  const name = `whisker ${whiskerName(whisker)} of ${whisker.robot}`;
  const nominal = whisker.nominal_pressure_mpa === undefined ? "" : ` of ${mpa(whisker.nominal_pressure_mpa)}`;
  return {
    setpoint: () => ({ title: `Set the pressure of ${name}`, moves: whisker, ...setpoint(whisker) }),
    hold: () => ({
      title: `Hold ${name}`,
      what: [
        "This whisker gets no automatic setpoints, and no decisions are made about it, until it is released. Its pressure does not change.",
        "Other whiskers may replace it as compensator.",
      ],
      button: "Hold",
    }),
    release: () => ({
      title: `Release ${name}`,
      moves: whisker,
      what: [
        `The supervisor takes over again: the chamber returns to the pressure of its compensation, or to its nominal pressure${nominal}, and decisions are made again.`,
      ],
      button: "Release",
    }),
    touch_test: () => ({
      title: `Measure the length of ${name} by touches`,
      what: [
        "The robot touches the whisker near its tip on request. Touches that come and touches that do not give the length: a cut is called, or a suspicion is refuted. A proposed test is started.",
        "The pressure does not change. A robot whose factsheet names no touch test refuses.",
      ],
      button: "Touch test",
    }),
    replaced: () => ({
      title: `Mark ${name} as replaced`,
      what: [
        "Use this only after a new whisker, as described in the robot's factsheet, was installed. Everything learned about the old one is forgotten, compensations for it end, and the compensators' chambers return to their nominal pressure.",
      ],
      button: "Mark as replaced",
      grave: true,
    }),
    rebaseline: () => ({
      title: `Relearn the baseline of ${name}`,
      what: [
        "Use this if the readings have changed but the whisker has not, for example after its gauge was glued again. The estimated length stays; offset, noise and baseline are learned from the next contacts. Until then a cut is not detected.",
        "The pressure does not change.",
      ],
      button: "Relearn baseline",
      grave: true,
    }),
    retry: () => ({
      title: `Try the setpoint of ${name} again`,
      moves: whisker,
      what: ["Use this once the cause is removed. The supervisor decides anew, and sends the robot the pressure that follows."],
      button: "Try again",
    }),
  };
}

/** Buttons for these actions on a whisker, as far as the service offers them. */
function buttonsFor(whisker, names, done) {
  const all = whiskerWork(whisker);
  return names
    .filter((one) => offered(ROUTES.whisker, one))
    .map((one) =>
      actionButton({ reason: "optional", path: `${api.whisker(whisker)}/${one}`, body: withReason, ...all[one]() }, done),
    );
}

/** Buttons for the actions on a whisker that the service offers. */
export function whiskerActions(whisker, done) {
  // A release also fills a whisker again that its robot has vented.
  const isEmpty = whisker.setpoint_mpa === 0 && whisker.nominal_pressure_mpa > 0;
  // Only an alarm says that a setpoint has failed.
  const isShown = { hold: !whisker.held, release: whisker.held !== false || isEmpty, retry: false };
  const shown = Object.keys(whiskerWork(whisker)).filter((one) => isShown[one] ?? true);
  return buttonsFor(whisker, shown, done);
}

/** What to do about each kind of alarm of a whisker, the best first. */
const WORK = {
  SETPOINT_FAILED: ["retry", "hold"],
  VENTED: ["release"],
  UNCOMPENSATED: ["touch_test", "replaced"],
  LEAK: ["hold", "replaced"],
  REGULATOR: ["hold"],
  GAUGE_OPEN: ["replaced"],
  GAUGE_SHORT: ["replaced"],
  GAUGE_SATURATED: ["rebaseline", "replaced"],
  GAUGE: ["replaced"],
  STALE: ["touch_test"],
  REACH_LOST: ["touch_test", "replaced"],
  SENSITIVITY_LOSS: ["touch_test", "rebaseline"],
  ERODING: ["replaced"],
  BASELINE_DRIFT: ["rebaseline"],
};

/** Buttons that mend the cause of a standing alarm of a whisker. */
export function workActions(alarm, done) {
  if (alarm.cleared_at !== null || alarm.array === null) return [];
  return buttonsFor(alarm, WORK[alarm.kind] ?? [], done);
}

function setpoint(whisker) {
  const limit = Math.min(whisker.pressure_max_mpa, 0.2);
  return {
    what: [
      `The robot moves the chamber to this pressure now, and the whisker is held: it gets no automatic setpoints until it is released. If it is a compensator, that compensation ends.`,
      `Present pressure: ${mpa(whisker.pressure_mpa ?? whisker.setpoint_mpa)}.`,
    ],
    button: "Set the pressure",
    grave: true,
    fields: [
      {
        name: "pressure_mpa",
        label: "Pressure in MPa",
        hint: `From 0 to ${limit} MPa; nominal is ${whisker.nominal_pressure_mpa} MPa.`,
        type: "number",
        min: 0,
        max: limit,
        step: "any",
        inputmode: "decimal",
        required: true,
        value: Number(whisker.setpoint_mpa.toFixed(4)),
      },
    ],
    body: (values) => ({ pressure_mpa: Number(values.pressure_mpa), ...withReason(values) }),
  };
}

/** Buttons to start or refuse a proposed touch test. */
export function testActions(test, done) {
  if (test.state !== "PROPOSED") return [];
  const name = `whisker ${whiskerName(test)} of ${test.robot}`;
  const start = {
    title: `Measure the length of ${name} by touches`,
    what: ["The robot touches the whisker near its tip on request. The pressure does not change."],
    button: "Start the test",
  };
  const refuse = {
    title: `Refuse the touch test of ${name}`,
    what: ["Nothing is sent. The test is not proposed again for the same reason until there is new evidence."],
    button: "Refuse the test",
    grave: true,
  };
  return [
    ["touch_test", start],
    ["touch_test/refuse", refuse],
  ]
    .filter(([one]) => offered(ROUTES.whisker, one))
    .map(([one, action]) =>
      actionButton({ reason: "optional", path: `${api.whisker(test)}/${one}`, body: withReason, ...action }, done),
    );
}

/** Buttons for the actions on a robot. */
export function robotActions(robot, done) {
  const at = api.robot(robot);
  const hold = {
    title: `Hold all whiskers of ${robot.robot}`,
    what: ["No whisker of this robot gets automatic setpoints until the robot is released. Pressures do not change."],
    button: "Hold the robot",
  };
  const release = {
    title: `Release ${robot.robot}`,
    what: [
      "Automatic setpoints are sent again, and decisions are made again. Whiskers that are held individually stay held.",
    ],
    button: "Release the robot",
  };
  const leave = {
    title: `Decommission ${robot.robot}`,
    what: [
      "Use this for a robot that has left for good, and is switched off. It leaves all lists, its alarms end, and what was learned about its whiskers is forgotten. Its history stays.",
      "If it starts again, it is registered anew, unless the fleet's list of allowed robots excludes it.",
    ],
    button: "Decommission",
    grave: true,
    method: "DELETE",
    path: at,
    reason: "optional",
    body: withReason,
  };
  const leaving = robot.connection !== "ONLINE" && has("DELETE", ROUTES.robot) ? [actionButton(leave, done)] : [];
  return [
    ["hold", hold],
    ["release", release],
  ]
    .filter(([one]) => offered(ROUTES.robot, one) && (robot.held === undefined || (one === "hold") !== robot.held))
    .map(([one, action]) => actionButton({ reason: "optional", path: `${at}/${one}`, body: withReason, ...action }, done))
    .concat(leaving);
}

/** Buttons to approve or refuse a proposed compensation. */
export function proposalActions(proposal, done) {
  if (proposal.approval !== "PROPOSED" || !has("POST", "/v1/compensations/{}/approve")) return [];
  const at = api.compensation(proposal.compensation_id);
  const who = `whisker ${proposal.array} ${proposal.compensator_whisker} of ${proposal.robot}`;
  const whom =
    proposal.compensator_whisker === proposal.target_whisker ? "itself" : `whisker ${proposal.target_whisker}`;
  const approve = {
    moves: { ...proposal, whisker: proposal.compensator_whisker },
    title: `Approve ${who} as compensator of ${whom}`,
    what: [
      `The robot moves the chamber of ${who} from ${mpa(proposal.pressure_before_mpa)} to ${mpa(proposal.pressure_mpa)} at once. The supervisor then refines the pressure from measured contacts.`,
    ],
    button: "Approve",
  };
  const refuse = {
    title: `Refuse ${who} as compensator of ${whom}`,
    what: [
      `Nothing is sent. This whisker is not proposed again for whisker ${proposal.target_whisker} until that one is trimmed again or replaced, or the policy changes. Another whisker may be proposed.`,
    ],
    button: "Refuse",
    grave: true,
  };
  const complete = (action, name) => ({ reason: "optional", path: `${at}/${name}`, body: withReason, ...action });
  return [actionButton(complete(approve, "approve"), done), actionButton(complete(refuse, "refuse"), done)];
}

/** A button that takes a compensation in force back; the robot's chamber returns to its pressure from before. */
export function undoActions(decision, done) {
  const { compensator_whisker: whisker, ended_at: ended, approval, pressure_before_mpa: before } = decision;
  const isInForce = whisker !== null && !ended && (approval === "AUTOMATIC" || approval === "APPROVED");
  if (!isInForce || !offered(ROUTES.whisker, "setpoint")) return [];
  const subject = { ...decision, whisker };
  const name = `whisker ${whiskerName(subject)} of ${decision.robot}`;
  const action = {
    title: `Take the compensation by ${name} back`,
    moves: subject,
    what: [
      `The chamber returns to ${mpa(before)}, its pressure from before, and the compensation ends. The robot feels the cut again.`,
      "The whisker is held, so that the supervisor does not decide the same again. Release it on its page.",
    ],
    button: "Undo",
    grave: true,
    reason: "optional",
    path: `${api.whisker(subject)}/setpoint`,
    body: (values) => ({ pressure_mpa: before, ...withReason(values) }),
  };
  return [actionButton(action, done)];
}

/** Buttons to acknowledge, shelve and unshelve an alarm. */
export function alarmActions(alarm, done) {
  const at = api.alarm(alarm.alarm_id);
  const whose = alarm.array === null ? `robot ${alarm.robot}` : `whisker ${whiskerName(alarm)} of ${alarm.robot}`;
  const name = `the alarm of ${whose}`;
  const actions = [];
  const add = (one, action) =>
    has("POST", `/v1/alarms/{}/${one}`) &&
    actions.push(
      actionButton({ path: `${at}/${one}`, body: withReason, reason: "optional", ...action }, done, action.short),
    );
  if (alarm.state === "UNACKNOWLEDGED") add("acknowledge", { title: `Acknowledge ${name}`, ...ACKNOWLEDGE });
  if (alarm.state === "UNACKNOWLEDGED" || alarm.state === "ACKNOWLEDGED") add("shelve", shelve(name));
  const isShelvedByPerson = alarm.state === "SHELVED" && alarm.maintenance_id === null;
  if (isShelvedByPerson) add("unshelve", { title: `Unshelve ${name}`, ...UNSHELVE });
  return actions;
}

const ACKNOWLEDGE = {
  what: ["This records that you have seen the alarm. It stands until its cause is gone; the robot is not affected."],
  button: "Acknowledge",
};

const UNSHELVE = { what: ["The alarm is listed among the standing alarms again."], button: "Unshelve" };

/**
 * Buttons for all alarms that the filters show, on all pages. The dialog lists the alarms that the service would change.
 * `alarms` and `open` are the numbers of alarms and of those that are not acknowledged.
 */
export function alarmsActions(filter, { alarms, open }, done) {
  const actions = [];
  const add = (one, many, action) => {
    if (!many || !has("POST", `/v1/alarms/${one}`)) return;
    actions.push(atOnce(one, filter, action, done));
  };
  const isShelved = filter.state === "SHELVED";
  if (!isShelved) add("acknowledge", open, { ...ACKNOWLEDGE, verb: "Acknowledge", many: open });
  if (!isShelved) add("shelve", alarms, { ...shelve(""), verb: "Shelve", many: alarms });
  if (filter.kind === "VENTED" && has("POST", "/v1/whiskers/release")) actions.push(ventedAction(filter, done));
  if (isShelved) add("unshelve", alarms, { ...UNSHELVE, verb: "Unshelve", many: alarms });
  return actions;
}

/** A button that asks the service which alarms it would change, and then opens the dialog with their list. */
function atOnce(one, filter, action, done) {
  const path = `/v1/alarms/${one}`;
  const values = (which) => (told) => ({ ...action.body?.(told), ...withReason(told), which });
  const prepare = async () => {
    // A dry run of shelving needs an end and a reason, too.
    const tried = one === "shelve" ? { until: new Date(Date.now() + 3_600_000).toISOString(), reason: "dry run" } : {};
    const answer = await ask(path, { method: "POST", body: { which: { filter }, dry_run: true, ...tried } });
    const told = await answer.json();
    const which = { filter, up_to_alarm_id: told.newest_alarm_id ?? 0 };
    const title = `${action.verb} ${count(told.alarms, "alarm")}`;
    return { reason: "optional", ...action, title, path, button: action.verb, body: values(which), list: concerned(told) };
  };
  return actionButton({ path, prepare }, done, `${action.verb} all ${action.many.toLocaleString("en")}`);
}

/** The alarms that a dry run found, in a box. */
function concerned({ items, more }) {
  const where = (row) => (row.array === null ? row.robot : `${row.robot}, whisker ${whiskerName(row)}`);
  const item = (row) => h("li", {}, `${say(ALARM_KINDS, row.kind)}: ${row.fleet}, ${where(row)}`);
  return [
    h(
      "div",
      { class: "concerned", role: "region", "aria-label": "Alarms concerned", tabindex: "0" },
      h("ol", {}, items.map(item)),
    ),
    more ? h("p", { class: "hint" }, "More alarms match: repeat this for them.") : null,
  ];
}

function shelve(name) {
  return {
    title: `Shelve ${name}`,
    what: [
      "The alarm is silenced until then. Afterwards it stands again if its cause still exists. The robot is not affected.",
    ],
    button: "Shelve",
    reason: "required",
    fields: [
      {
        name: "until",
        label: "Until",
        hint: `Date and time in the time zone ${zone()}.`,
        type: "datetime-local",
        required: true,
        value: toField(Date.now() + 3_600_000),
      },
    ],
    body: (values) => ({ until: new Date(fromField(values.until)).toISOString(), ...withReason(values) }),
  };
}
