// The closed words of the API in plain English: [words, tone, shape]. A word that is not known is shown as it is.

/** What a whisker's mechanical condition is called. */
export const CONDITIONS = {
  LEARNING: ["learning", "info", "dots"],
  HEALTHY: ["healthy", "good", "circle"],
  SUSPECTED: ["suspected", "warn", "diamond"],
  TRIMMED: ["trimmed", "bad", "stump"],
  ERODING: ["eroding", "warn", "slope"],
  SENSITIVITY_LOSS: ["less sensitive", "warn", "down"],
};

export const FAULTS = {
  STALE: ["stale: no readings", "warn", "clock"],
  GAUGE_OPEN: ["gauge open", "bad", "cross"],
  GAUGE_SHORT: ["gauge shorted", "bad", "cross"],
  GAUGE_SATURATED: ["gauge saturated", "bad", "cross"],
  GAUGE: ["gauge faulty", "bad", "cross"],
  LEAK: ["leaking", "bad", "drop"],
  REGULATOR: ["regulator faulty", "bad", "cross"],
  SUPPLY_LOW: ["air supply low", "bad", "down"],
};

export const CONNECTIONS = {
  ONLINE: ["online", "good", "circle"],
  OFFLINE: ["offline", "off", "ring"],
  CONNECTION_BROKEN: ["connection broken", "bad", "gap"],
};

export const CASES = {
  SELF_COMPENSATION: "compensates for itself",
  SHORTER_FOR_LONGER: "a shorter one for a longer one",
  LONGER_FOR_SHORTER: "a longer one for a shorter one",
};

/** Why a candidate was not chosen. */
export const REFUSALS = {
  LEARNING: "it is still being learned",
  SUSPECTED: "it is itself suspected of being cut",
  TRIMMED: "it is trimmed itself",
  ERODING: "it is eroding",
  SENSITIVITY_LOSS: "it has lost sensitivity",
  STALE: "nothing is heard of it",
  GAUGE_FAULT: "its gauge is faulty",
  LEAKING: "its chamber leaks",
  SETPOINT_FAILED: "its last setpoint failed",
  HELD: "an operator holds it",
  CASE_NOT_ALLOWED: "the policy does not allow this case",
  NEEDS_BELOW_RANGE: "it would need less than 0 MPa",
  NEEDS_ABOVE_RANGE: "it would need more pressure than it may hold",
  ERROR_ABOVE_LIMIT: "the predicted error is above the policy's limit",
  CUT_INTO_CHAMBER: "it is cut into its chamber",
  COSTS_MORE: "another one costs less",
  OPERATOR_REFUSED: "an operator refused it",
};

export const END_REASONS = {
  LAYOUT_CHANGED: "the robot's layout changed",
  TARGET_TRIMMED_AGAIN: "the whisker was trimmed again",
  COMPENSATOR_BROKEN: "the one that served broke",
  REASSIGNED: "another one serves instead",
  SETPOINT_FAILED: "the setpoint failed",
  REPLACED: "the whisker was replaced",
  REFUSED: "an operator refused it",
  OPERATOR: "an operator set the pressure by hand",
};

export const SETPOINT_STATES = {
  PENDING: ["not answered yet", "info", "dots"],
  RECEIVED: ["received", "info", "dots"],
  APPLYING: ["being applied", "info", "dots"],
  APPLIED: ["applied", "good", "circle"],
  REJECTED: ["rejected by the robot", "bad", "cross"],
  FAILED: ["failed", "bad", "cross"],
  SUPERSEDED: ["superseded", "off", "ring"],
  EXPIRED: ["expired", "warn", "clock"],
  ABANDONED: ["abandoned", "off", "ring"],
};

export const SETPOINT_REASONS = {
  ...CASES,
  REFINEMENT: "refined by what was felt",
  RELEASE: "back to nominal",
  OPERATOR: "set by an operator",
};

export const LOOKS = {
  REFINED: "the pressure was refined",
  HELD_DITHER: "stays: the step would be within the regulator's dither",
  HELD_MARGIN: "stays: too little to gain",
  HELD_UNCERTAIN: "stays: not certain enough yet",
  HELD_STEPS: "stays: refined as often as is allowed",
  HELD_UNPREDICTABLE: "stays: what would come of it cannot be predicted",
};

export const ALARM_KINDS = {
  ...Object.fromEntries(Object.entries(FAULTS).map(([word, [words]]) => [word, words])),
  UNCOMPENSATED: "trimmed, and nobody can serve it",
  SETPOINT_FAILED: "a setpoint failed for good",
  SENSITIVITY_LOSS: "lost sensitivity, which no cut explains",
  ERODING: "eroding",
  ARRAY_SHIFT: "the whole array changed alike",
  BASELINE_DRIFT: "the gauge's baseline drifts",
  PROPOSED: "a compensation waits for approval",
};

export const ALARM_STATES = {
  UNACKNOWLEDGED: ["not acknowledged", "bad", "bell"],
  STANDING: ["standing", "bad", "bell"],
  ACKNOWLEDGED: ["acknowledged", "warn", "tick"],
  SHELVED: ["shelved", "off", "clock"],
  CLEARED: ["over", "good", "circle"],
};

export const APPROVALS = {
  AUTOMATIC: ["decided by the supervisor", "info", "circle"],
  PROPOSED: ["waits for approval", "warn", "diamond"],
  APPROVED: ["approved", "good", "tick"],
  REFUSED: ["refused", "off", "ring"],
};

export const ACTION_STATES = {
  PENDING: ["waiting for the fleet's supervisor", "info", "dots"],
  DONE: ["done", "good", "tick"],
  REFUSED: ["refused", "bad", "cross"],
  EXPIRED: ["expired", "warn", "clock"],
};

export const ACTION_KINDS = {
  APPROVE: "approve a compensation",
  REFUSE: "refuse a compensation",
  SETPOINT: "set a pressure",
  HOLD: "hold",
  RELEASE: "release",
  REPLACED: "whisker replaced",
  REBASELINE: "learn readings anew",
  POLICY: "change the policy",
  ACKNOWLEDGE: "acknowledge an alarm",
  SHELVE: "shelve an alarm",
  UNSHELVE: "unshelve an alarm",
};

export const ARRAY_TYPES = {
  TYPE_1: "whiskers that compensate for one another",
  TYPE_2: "single whiskers, each for itself",
};

/** The words for one of the API's words. */
export function say(words, word) {
  const known = words[word];
  return (Array.isArray(known) ? known[0] : known) ?? (word ? word.toLowerCase().replaceAll("_", " ") : "\u2013");
}
