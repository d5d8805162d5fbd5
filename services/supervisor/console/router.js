// Addresses within the page, and their views.

import { pathOf, stateOf } from "./address.js";
import alarmStatistics from "./pages/alarm-statistics.js";
import alarms from "./pages/alarms.js";
import audit from "./pages/audit.js";
import bulkAction from "./pages/bulk-action.js";
import bulk from "./pages/bulk.js";
import calibration from "./pages/calibration.js";
import calibrations from "./pages/calibrations.js";
import compensation from "./pages/compensation.js";
import compensations from "./pages/compensations.js";
import fleet from "./pages/fleet.js";
import fleets from "./pages/fleets.js";
import nowhere from "./pages/nowhere.js";
import operation from "./pages/operation.js";
import operations from "./pages/operations.js";
import policy from "./pages/policy.js";
import robot from "./pages/robot.js";
import rollout from "./pages/rollout.js";
import rollouts from "./pages/rollouts.js";
import setpoints from "./pages/setpoints.js";
import timeline from "./pages/timeline.js";
import trims from "./pages/trims.js";
import webhook from "./pages/webhook.js";
import webhooks from "./pages/webhooks.js";
import whatIf from "./pages/what-if.js";
import whisker from "./pages/whisker.js";
import whiskers from "./pages/whiskers.js";

const PAGES = [
  ["fleets", fleets],
  ["fleets/:fleet", fleet],
  ["fleets/:fleet/robots/:robot", robot],
  ["fleets/:fleet/robots/:robot/arrays/:array/whiskers/:whisker", whisker],
  ["whiskers", whiskers],
  ["alarms", alarms],
  ["alarm-statistics", alarmStatistics],
  ["timeline", timeline],
  ["compensations", compensations],
  ["compensations/:id", compensation],
  ["calibrations", calibrations],
  ["calibrations/:id", calibration],
  ["trims", trims],
  ["setpoints", setpoints],
  ["what-if", whatIf],
  ["audit", audit],
  ["bulk", bulk],
  ["bulk/:id", bulkAction],
  ["rollouts", rollouts],
  ["rollouts/:id", rollout],
  ["policy", policy],
  ["policy/:fleet", policy],
  ["webhooks", webhooks],
  ["webhooks/:id", webhook],
  ["api", operations],
  ["api/:id", operation],
];

/** The view of an address, its parameters by name, and its state (search, filters, order). */
export function find(hash) {
  const told = pathOf(hash).replace(/^\/?/, "").split("/");
  const state = stateOf(hash);
  if (told[0] === "") return { page: fleets, parts: {}, state };
  for (const [pattern, page] of PAGES) {
    const parts = match(pattern.split("/"), told);
    if (parts) return { page, parts, state };
  }
  return { page: told.join("/") === "design" ? design : nowhere, parts: {}, state };
}

/** The page of all parts in all states. Only debug builds of the service have its file. */
const design = {
  async load(parts, state) {
    const page = await import("./pages/design.js").then((module) => module.default, () => nowhere);
    return { page, told: await page.load(parts, state) };
  },

  view: ({ page, told }, parts, refresh) => page.view(told, parts, refresh),
};

function match(pattern, told) {
  if (pattern.length !== told.length) return null;
  const parts = {};
  for (const [index, part] of pattern.entries()) {
    if (part.startsWith(":")) parts[part.slice(1)] = decoded(told[index]);
    else if (part !== told[index]) return null;
  }
  return parts;
}

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}
