// Addresses within the page, and paths of the API.

import { address } from "./address.js";
import { path } from "./api.js";

const part = encodeURIComponent;

/** Addresses within the page. */
export const link = {
  fleets: (state = {}) => address("/fleets", state),
  fleet: (fleet) => `#/fleets/${part(fleet)}`,
  robot: ({ fleet, robot }) => `#/fleets/${part(fleet)}/robots/${part(robot)}`,
  whisker: ({ fleet, robot, array, whisker }) =>
    `${link.robot({ fleet, robot })}/arrays/${part(array)}/whiskers/${whisker}`,
  whiskers: (state = {}) => address("/whiskers", state),
  compensations: (state = {}) => address("/compensations", state),
  bulk: (state = {}) => address("/bulk", state),
  bulkAction: (id) => `#/bulk/${part(id)}`,
  audit: (state = {}) => address("/audit", state),
  alarms: (state = {}) => address("/alarms", state),
  trims: (state = {}) => address("/trims", state),
  setpoints: (state = {}) => address("/setpoints", state),
  timeline: (state = {}) => address("/timeline", state),
  alarmStatistics: (state = {}) => address("/alarm-statistics", state),
  whatIf: (state = {}) => address("/what-if", state),
  calibrations: () => "#/calibrations",
  calibration: (id) => `#/calibrations/${part(id)}`,
  compensation: (id) => `#/compensations/${part(id)}`,
  policies: () => "#/policy",
  rollouts: (state = {}) => address("/rollouts", state),
  rollout: (id) => `#/rollouts/${part(id)}`,
  policy: (fleet) => `#/policy/${part(fleet)}`,
  webhooks: () => "#/webhooks",
  operations: () => "#/api",
  operation: (id) => `#/api/${part(id)}`,
  webhook: (id) => `#/webhooks/${part(id)}`,
  alarm: (id) => `#/alarms?alarm_id=${part(id)}`,
};

/** Paths of the API. */
export const api = {
  fleet: (fleet) => path`/v1/fleets/${fleet}`,
  robot: ({ fleet, robot }) => path`/v1/fleets/${fleet}/robots/${robot}`,
  whisker: ({ fleet, robot, array, whisker }) =>
    path`/v1/fleets/${fleet}/robots/${robot}/arrays/${array}/whiskers/${whisker}`,
  compensation: (id) => path`/v1/compensations/${id}`,
  alarm: (id) => path`/v1/alarms/${id}`,
  calibration: (id) => path`/v1/calibrations/${id}`,
  policy: (fleet) => path`/v1/fleets/${fleet}/policy`,
  webhook: (id) => path`/v1/webhooks/${id}`,
};

/** Route templates of the API, to check whether they exist. */
export const ROUTES = {
  whisker: "/v1/fleets/{}/robots/{}/arrays/{}/whiskers/{}",
  robot: "/v1/fleets/{}/robots/{}",
  policy: "/v1/fleets/{}/policy",
};

/** Display name of a whisker: "left 3". */
export const whiskerName = ({ array, whisker }) => `${array} ${whisker}`;

/** Path parameters of another whisker of the same array. */
export const names = (row, whisker) => ({ fleet: row.fleet, robot: row.robot, array: row.array, whisker });
