// What operators may do, and what each does to the robot.

import { has } from "./api.js";
import { confirm } from "./dialog.js";
import { h } from "./dom.js";
import { mpa } from "./format.js";
import { api, ROUTES, whiskerName } from "./places.js";

const withReason = (values) => ({ reason: values.reason?.trim() || undefined });

/** A button that opens the dialog of an action. */
function button(action, done, words = action.button) {
  return h(
    "button",
    { type: "button", class: action.grave ? "grave" : null, onclick: () => confirm(action, done) },
    `${words} \u2026`,
  );
}

const offered = (base, name) => has("POST", `${base}/${name}`);

/** What may be done with a whisker: buttons, those that the service has. */
export function whiskerActions(whisker, done) {
  const name = `whisker ${whiskerName(whisker)} of ${whisker.robot}`;
  const at = api.whisker(whisker);
  const all = {
    setpoint: () => ({ title: `Set the pressure of ${name}`, ...setpoint(whisker) }),
    hold: () => ({
      title: `Hold ${name}`,
      what: [
        "No automatic setpoint goes to this whisker any more, and nothing is decided about it until it is released. The pressure stays as it is.",
        "Others may be asked to serve instead of it.",
      ],
      button: "Hold",
    }),
    release: () => ({
      title: `Release ${name}`,
      what: [
        "The supervisor takes over again: the chamber goes back to the pressure of its compensation, or to its nominal pressure of " +
          mpa(whisker.nominal_pressure_mpa) +
          ", and decisions are taken anew.",
      ],
      button: "Release",
    }),
    replaced: () => ({
      title: `Say that ${name} was replaced`,
      what: [
        "Only if somebody has put a new whisker there, as the robot's factsheet describes it. What was learned of the old one is forgotten, compensations for it end, and chambers that served it go back to their nominal pressure.",
      ],
      button: "It was replaced",
      grave: true,
    }),
    rebaseline: () => ({
      title: `Learn the readings of ${name} anew`,
      what: [
        "For a whisker whose readings have changed while the whisker has not: its gauge was glued anew, say. The length stays as estimated; offset, noise and baseline are learned again from the next contacts, and until then a cut of it is not found.",
        "The pressure does not change.",
      ],
      button: "Learn anew",
      grave: true,
    }),
  };
  const shown =
    whisker.held === undefined
      ? Object.keys(all)
      : Object.keys(all).filter((one) => one !== (whisker.held ? "hold" : "release"));
  return shown
    .filter((one) => offered(ROUTES.whisker, one))
    .map((one) => button({ reason: "optional", path: `${at}/${one}`, body: withReason, ...all[one]() }, done));
}

function setpoint(whisker) {
  const limit = Math.min(whisker.pressure_max_mpa, 0.2);
  return {
    what: [
      `The robot moves the chamber to this pressure now, and the whisker is held: no automatic setpoint goes to it until it is released. A compensation that it serves in ends.`,
      `It holds ${mpa(whisker.pressure_mpa ?? whisker.setpoint_mpa)} now.`,
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

/** What may be done with a whole robot. */
export function robotActions(robot, done) {
  const at = api.robot(robot);
  const hold = {
    title: `Hold all whiskers of ${robot.robot}`,
    what: ["No automatic setpoint goes to any whisker of this robot until it is released. Pressures stay as they are."],
    button: "Hold the robot",
  };
  const release = {
    title: `Release ${robot.robot}`,
    what: [
      "Automatic setpoints go out again, and decisions are taken anew. Whiskers that are held one by one stay held.",
    ],
    button: "Release the robot",
  };
  return [
    ["hold", hold],
    ["release", release],
  ]
    .filter(([one]) => offered(ROUTES.robot, one) && (robot.held === undefined || (one === "hold") !== robot.held))
    .map(([one, action]) => button({ reason: "optional", path: `${at}/${one}`, body: withReason, ...action }, done));
}

/** Approve and refuse a proposed compensation. */
export function proposalActions(proposal, done) {
  if (proposal.approval !== "PROPOSED" || !has("POST", "/v1/compensations/{}/approve")) return [];
  const at = api.compensation(proposal.compensation_id);
  const who = `whisker ${proposal.array} ${proposal.compensator_whisker} of ${proposal.robot}`;
  const whom =
    proposal.compensator_whisker === proposal.target_whisker ? "itself" : `whisker ${proposal.target_whisker}`;
  const approve = {
    title: `Approve that ${who} compensates for ${whom}`,
    what: [
      `The robot moves the chamber of ${who} from ${mpa(proposal.pressure_before_mpa)} to ${mpa(proposal.pressure_mpa)} at once. The supervisor then refines the pressure by what is felt.`,
    ],
    button: "Approve",
  };
  const refuse = {
    title: `Refuse that ${who} compensates for ${whom}`,
    what: [
      `Nothing is sent. This whisker is not proposed again for whisker ${proposal.target_whisker} until that is trimmed again or replaced, or the policy changes; another one may be.`,
    ],
    button: "Refuse",
    grave: true,
  };
  const complete = (action, name) => ({ reason: "optional", path: `${at}/${name}`, body: withReason, ...action });
  return [button(complete(approve, "approve"), done), button(complete(refuse, "refuse"), done)];
}

/** Acknowledge, shelve and unshelve an alarm. */
export function alarmActions(alarm, done) {
  const at = api.alarm(alarm.alarm_id);
  const name = `the alarm of whisker ${whiskerName(alarm)} of ${alarm.robot}`;
  const actions = [];
  const add = (one, action) =>
    has("POST", `/v1/alarms/{}/${one}`) &&
    actions.push(button({ path: `${at}/${one}`, body: withReason, reason: "optional", ...action }, done, action.short));
  if (alarm.state === "UNACKNOWLEDGED") {
    add("acknowledge", {
      title: `Acknowledge ${name}`,
      what: ["It says that you have seen it. The alarm stands until its cause is over; the robot is not touched."],
      button: "Acknowledge",
    });
  }
  if (alarm.state === "UNACKNOWLEDGED" || alarm.state === "ACKNOWLEDGED") add("shelve", shelve(name));
  if (alarm.state === "SHELVED") {
    add("unshelve", {
      title: `Take ${name} off the shelf`,
      what: ["It stands among the others again."],
      button: "Unshelve",
    });
  }
  return actions;
}

function shelve(name) {
  const inAnHour = new Date(Date.now() + 3_600_000 - new Date().getTimezoneOffset() * 60_000)
    .toISOString()
    .slice(0, 16);
  return {
    title: `Shelve ${name}`,
    what: [
      "It is put aside until then and does not call for attention; afterwards it stands again if its cause is still there. The robot is not touched.",
    ],
    button: "Shelve",
    reason: "required",
    fields: [
      {
        name: "until",
        label: "Until",
        hint: "Date and time where you are.",
        type: "datetime-local",
        required: true,
        value: inAnHour,
      },
    ],
    body: (values) => ({ until: new Date(values.until).toISOString(), ...withReason(values) }),
  };
}
