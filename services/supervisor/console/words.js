// The API's enumerations in plain English: [words, tone, shape]. An unknown word is shown unchanged.
//
// The service makes declared.js of its own declaration of words (services/edge/src/words): [words, tone], or the
// words alone. Here are the shapes of its marks, and the words that only the API has.

import * as declared from "./declared.js";

export {
  ALARM_KINDS,
  ARRAY_TYPES,
  AUDIT_KINDS,
  CASES,
  END_REASONS,
  EVENT_KINDS,
  LONGER_FOR_SHORTER,
  LOOKS,
  MODES,
  OBJECTIVES,
  REFUSALS,
  ROLLOUT_STAGES,
  SETPOINT_REASONS,
  TEST_KINDS,
  TEST_REASONS,
  TIMELINE_KINDS,
} from "./declared.js";

/** The shape of a tone, for words without a shape of their own. */
const SHAPES = { good: "circle", info: "dots", warn: "diamond", bad: "cross", off: "ring" };

function marked(words, shapes = {}) {
  const entries = Object.entries(words);
  return Object.fromEntries(entries.map(([word, [text, tone]]) => [word, [text, tone, shapes[word] ?? SHAPES[tone]]]));
}

/** Mechanical conditions of a whisker. */
export const CONDITIONS = marked(declared.CONDITIONS, { TRIMMED: "stump", ERODING: "slope", SENSITIVITY_LOSS: "down" });

export const FAULTS = marked(declared.FAULTS, { STALE: "clock", LEAK: "drop", SUPPLY_LOW: "down" });

/** How far contacts that a robot finds in samples of strain can be relied on. */
export const SEGMENTERS = marked(declared.SEGMENTERS, { LOST: "gap", NOISY: "heat" });

export const CONNECTIONS = marked(declared.CONNECTIONS, { CONNECTION_BROKEN: "gap", SILENT: "clock" });

/** States of a robot on the board, the worst first: words, tone and the letter of its tile. */
export const ROBOT_STATES = {
  UNCOMPENSATED: ["trimmed, not compensated", "bad", "X"],
  FAULTY: ["faulty", "bad", "F"],
  CONNECTION_BROKEN: ["connection broken", "bad", "B"],
  SILENT: ["silent", "bad", "S"],
  ALARM: ["other alarm", "warn", "A"],
  WORN: ["worn or suspected", "warn", "W"],
  OFFLINE: ["offline", "off", "O"],
  COMPENSATED: ["trimmed, compensated", "info", "C"],
  LEARNING: ["being learned", "info", "L"],
  HEALTHY: ["healthy", "good", "\u00b7"],
};

export const SETPOINT_STATES = marked(declared.SETPOINT_STATES, { EXPIRED: "clock" });

export const TEST_STATES = marked(declared.TEST_STATES, { EXPIRED: "clock" });

/** Why a robot rejects a setpoint. */
export const SETPOINT_ERRORS = {
  NOT_READY: "the robot cannot change the pressure at the moment",
  IN_TASK: "waits: the robot is in a task",
  STALE: "the robot has a newer setpoint",
  EXPIRED: "the setpoint reached the robot too late",
  UNKNOWN_WHISKER: "the robot has no such whisker",
  WRONG_BOOT: "the robot has restarted since the setpoint",
  OUT_OF_RANGE: "the pressure is out of the robot's range",
};

/** Why a robot rejects a touch test. */
export const TEST_ERRORS = {
  ...SETPOINT_ERRORS,
  NOT_READY: "the robot cannot do it at the moment",
  STALE: "the robot has a newer request or setpoint",
  EXPIRED: "the request reached the robot too late",
  WRONG_BOOT: "the robot has restarted since the request",
  OUT_OF_RANGE: "the request is out of the robot's range",
};

/** How soon somebody must act on an alarm, the least urgent first. */
export const ALARM_LEVELS = marked(declared.ALARM_LEVELS, { WARNING: "slope", URGENT: "diamond", CRITICAL: "cross" });

export const ALARM_STATES = {
  UNACKNOWLEDGED: ["not acknowledged", "info", "bell"],
  STANDING: ["standing", "bad", "bell"],
  ACKNOWLEDGED: ["acknowledged", "warn", "tick"],
  SHELVED: ["shelved", "off", "clock"],
  CLEARED: ["cleared", "good", "circle"],
};

export const APPROVALS = {
  AUTOMATIC: ["automatic", "info", "circle"],
  PROPOSED: ["waiting for approval", "warn", "diamond"],
  APPROVED: ["approved", "good", "tick"],
  REFUSED: ["refused", "off", "ring"],
};

export const ACTION_STATES = {
  PENDING: ["waiting for the fleet's supervisor", "info", "dots"],
  DONE: ["done", "good", "tick"],
  REFUSED: ["refused", "bad", "cross"],
  EXPIRED: ["expired", "warn", "clock"],
};

export const BLACK_BOX_STATES = {
  RECORDING: ["recording", "info", "dots"],
  COMPLETE: ["complete", "good", "tick"],
  PARTIAL: ["messages are missing", "warn", "gap"],
};

export const ROLLOUT_STATES = {
  RUNNING: ["running", "info", "dots"],
  PAUSED: ["paused", "warn", "hand"],
  ROLLED_BACK: ["rolled back", "bad", "cross"],
  COMPLETED: ["in force everywhere", "good", "tick"],
};

export const ROLLOUT_EVENTS = {
  STARTED: "begun",
  LOOKED: "errors compared",
  ADVANCED: "next stage",
  PAUSED: "paused",
  RESUMED: "resumed",
  ROLLED_BACK: "rolled back",
  COMPLETED: "completed",
};

/** States of a webhook. */
export const WEBHOOK_STATES = {
  NEW: ["nothing sent yet", "info", "dots"],
  WORKING: ["working", "good", "circle"],
  FAILING: ["failing", "bad", "cross"],
  DISABLED: ["disabled", "off", "ring"],
};

/** The words for one of the API's words. */
export function say(words, word) {
  const known = words[word];
  return (Array.isArray(known) ? known[0] : known) ?? (word ? word.toLowerCase().replaceAll("_", " ") : "\u2013");
}
