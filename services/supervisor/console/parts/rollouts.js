// Staged roll-outs: buttons to begin one, its marks, and the buttons to pause, advance and roll it back.

import { has } from "../api.js";
import { actionButton } from "../dialog.js";
import { h } from "../dom.js";
import { count, percent } from "../format.js";
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
  return actionButton(action, done, words);
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
