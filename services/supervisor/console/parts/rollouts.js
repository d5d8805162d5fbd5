// Staged roll-outs: buttons to begin one, its marks, and the buttons to pause, advance and roll it back.

import { get, has } from "../api.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { ago, count, percent } from "../format.js";
import { markOf } from "../marks.js";
import { api, link } from "../places.js";
import { MODES, ROLLOUT_STAGES, ROLLOUT_STATES, say } from "../words.js";

const ROUTE = "/v1/fleets/{}/rollouts";

const reasonOf = (values) => values.reason?.trim() || undefined;

const RULES = [
  {
    name: "robots",
    label: "Robots for a stage",
    hint: "Changed robots with a measured error that complete a stage. From 4 to 1000.",
    type: "number",
    min: 4,
    max: 1000,
    step: 1,
    required: true,
    value: 20,
  },
  {
    name: "level",
    label: "Level",
    hint: "Probability that a change without an effect is rolled back, at most. From 0.001 to 0.2.",
    type: "number",
    min: 0.001,
    max: 0.2,
    step: "any",
    required: true,
    value: 0.05,
  },
];

/** Share of the robots that each stage concerns. */
const SHARES = { FEW: 0.05, QUARTER: 0.25, ALL: 1 };

const WHAT =
  "5 % of the fleet's robots get the change, then 25 %, then all. After each stage the measured compensation errors of changed and unchanged robots are compared. If the changed ones are worse, they get what is in force now.";

/** The button that begins a roll-out in a fleet: `what` is a sentence, `change(values)` the policy or calibration. */
export function rolloutButton({ fleet, title, what, fields = [], change, words }, done) {
  if (!has("POST", ROUTE)) return null;
  const action = {
    title,
    what: [WHAT, what].filter(Boolean),
    fields: [...fields, ...RULES],
    button: "Begin the roll-out",
    grave: true,
    reason: "optional",
    path: `${api.fleet(fleet)}/rollouts`,
    body: ({ level, robots, ...values }) => ({
      ...change(values),
      level: Number(level),
      robots: Number(robots),
      reason: reasonOf(values),
    }),
  };
  // The dialog says whom the change concerns.
  const prepare = async () => {
    const { robots } = await get(api.fleet(fleet));
    return { ...action, what: [...action.what, concernedBy(robots)] };
  };
  return actionButton({ path: action.path, prepare }, done, words);
}

/** How many robots each stage concerns. */
function concernedBy(robots) {
  const few = Math.max(1, Math.round(SHARES.FEW * robots));
  const quarter = Math.max(few, Math.round(SHARES.QUARTER * robots));
  return `Fleet of ${count(robots, "robot")}: about ${count(few, "robot")} first, then ${quarter.toLocaleString("en")}, then all. A stage ends when enough changed robots have a measured error, so robots without a compensation do not speed it up.`;
}

/** The link to the list of roll-outs. */
export const rolloutsLink = (state) =>
  has("GET", "/v1/rollouts") ? h("a", { href: link.rollouts(state) }, "Roll-outs in stages") : null;

/** State and stage of a roll-out. */
export function rolloutMarks(row) {
  const isOpen = row.state === "RUNNING" || row.state === "PAUSED";
  return h(
    "span",
    { class: "marks" },
    markOf(ROLLOUT_STATES, row.state),
    h("span", {}, isOpen || row.state === "COMPLETED" ? say(ROLLOUT_STAGES, row.stage) : `at ${say(ROLLOUT_STAGES, row.stage)}`),
  );
}

/** What a roll-out changes, in words. */
export function changeOf({ kind, change }) {
  if (kind === "CALIBRATION")
    return h("a", { href: link.calibration(change.calibration_id) }, `calibration of ${change.calibration.name}`);
  return `policy: ${say(MODES, change.mode).split(":")[0]}, at most ${percent(change.predicted_error_max, 0)} predicted error`;
}

/** "median 12.0 % of 5 changed robots, 8.0 % of 79 unchanged ones". */
export function comparisonOf(row) {
  if (!row.changed_robots && !row.unchanged_robots) return "no errors measured in this stage yet";
  const group = (error, robots, noun) => `${error === null ? "no error" : percent(error)} of ${count(robots, noun)}`;
  return `median ${group(row.changed_error, row.changed_robots, "changed robot")}, ${group(row.unchanged_error, row.unchanged_robots, "unchanged robot")}`;
}

/** Whom a roll-out concerns now, of all robots of its fleet. */
export function concerned(row, robots) {
  if (!Number.isFinite(robots)) return null;
  const now = Math.min(robots, Math.max(1, Math.round((SHARES[row.stage] ?? 1) * robots)));
  return `about ${count(now, "robot")} now, ${robots.toLocaleString("en")} in all`;
}

/**
 * When the present stage is expected to end, from the robots that have a measured error so far; null once it has ended.
 */
export function expectedEnd(row, now = Date.now()) {
  if (row.state !== "RUNNING" || row.stage === "ALL") return null;
  const missing = row.robots - row.changed_robots;
  if (missing <= 0) return "at the next comparison";
  if (!row.changed_robots) return "not known yet: no changed robot has a measured error";
  const each = (now - Date.parse(row.stage_at)) / row.changed_robots;
  return `${ago(now + missing * each, now)}, at the pace so far: ${count(missing, "measured robot")} missing`;
}

const ORDERS = {
  pause: { button: "Pause", what: "Robots stay as they are, and errors are not compared until the roll-out is resumed." },
  resume: { button: "Resume", what: "Errors are compared again, and the next stage follows by itself." },
  advance: {
    button: "Advance",
    what: "The next stage begins now, whatever the errors say. After the stage of 25 % the change is in force in the whole fleet.",
    grave: true,
  },
  roll_back: {
    button: "Roll back",
    what: "The changed robots get what is in force in the fleet, and the roll-out ends. Robots may change pressures.",
    grave: true,
  },
};

/** Buttons for a roll-out that has not ended. */
export function rolloutActions(row, done) {
  if (row.state !== "RUNNING" && row.state !== "PAUSED") return [];
  const without = row.state === "RUNNING" ? "resume" : "pause";
  return Object.entries(ORDERS)
    .filter(([one]) => one !== without && has("POST", `/v1/rollouts/{}/${one}`))
    .map(([one, { button, what, grave }]) =>
      actionButton(
        {
          title: `${button}: roll-out ${row.rollout_id} of fleet ${row.fleet}`,
          what: [what],
          button,
          grave,
          reason: "optional",
          path: `/v1/rollouts/${encodeURIComponent(row.rollout_id)}/${one}`,
          body: (values) => ({ reason: reasonOf(values) }),
        },
        done,
      ),
    );
}
