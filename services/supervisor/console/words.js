// The API's enumerations in plain English: [words, tone, shape]. An unknown word is shown unchanged.

/** Mechanical conditions of a whisker. */
export const CONDITIONS = {
  LEARNING: ["learning", "info", "dots"],
  HEALTHY: ["healthy", "good", "circle"],
  SUSPECTED: ["suspected", "warn", "diamond"],
  TRIMMED: ["trimmed", "bad", "stump"],
  ERODING: ["eroding", "warn", "slope"],
  SENSITIVITY_LOSS: ["less sensitive", "warn", "down"],
};

export const FAULTS = {
  STALE: ["stale: no contacts", "warn", "clock"],
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
  SHORTER_FOR_LONGER: "shorter for longer",
  LONGER_FOR_SHORTER: "longer for shorter",
};

/** Reasons for not choosing a candidate. */
export const REFUSALS = {
  LEARNING: "it is still being learned",
  SUSPECTED: "it may be cut itself",
  TRIMMED: "it is trimmed itself",
  ERODING: "it is eroding",
  SENSITIVITY_LOSS: "it has lost sensitivity",
  STALE: "it is silent",
  GAUGE_FAULT: "its gauge is faulty",
  LEAKING: "its chamber leaks",
  SETPOINT_FAILED: "its last setpoint failed",
  HELD: "an operator holds it",
  CASE_NOT_ALLOWED: "the policy does not allow this case",
  NEEDS_BELOW_RANGE: "it would need less than 0 MPa",
  NEEDS_ABOVE_RANGE: "it would need more than its maximum pressure",
  ERROR_ABOVE_LIMIT: "the predicted error is above the policy's limit",
  CUT_INTO_CHAMBER: "it is cut into its chamber",
  COSTS_MORE: "another candidate costs less",
  OPERATOR_REFUSED: "an operator refused it",
};

export const END_REASONS = {
  LAYOUT_CHANGED: "the robot's layout changed",
  TARGET_TRIMMED_AGAIN: "the whisker was trimmed again",
  COMPENSATOR_BROKEN: "the compensator broke",
  REASSIGNED: "another compensator took over",
  SETPOINT_FAILED: "the setpoint failed",
  REPLACED: "the whisker was replaced",
  REFUSED: "an operator refused it",
  OPERATOR: "an operator set the pressure",
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
  REFINEMENT: "refined from measured contacts",
  RELEASE: "back to nominal",
  OPERATOR: "set by an operator",
};

export const LOOKS = {
  REFINED: "the pressure was refined",
  HELD_DITHER: "kept: the step would be within the regulator's dither",
  HELD_MARGIN: "kept: too little to gain",
  HELD_UNCERTAIN: "kept: not certain enough yet",
  HELD_STEPS: "kept: maximum number of refinements reached",
  HELD_UNPREDICTABLE: "kept: the effect cannot be predicted",
};

export const ALARM_KINDS = {
  ...Object.fromEntries(Object.entries(FAULTS).map(([word, [words]]) => [word, words])),
  UNCOMPENSATED: "trimmed, no compensator available",
  SETPOINT_FAILED: "a setpoint failed for good",
  SENSITIVITY_LOSS: "sensitivity loss not explained by a cut",
  ERODING: "eroding",
  ARRAY_SHIFT: "shift shared by the whole array",
  BASELINE_DRIFT: "baseline drift of the gauge",
  PROPOSED: "a compensation waits for approval",
};

export const ALARM_STATES = {
  UNACKNOWLEDGED: ["not acknowledged", "bad", "bell"],
  STANDING: ["standing", "bad", "bell"],
  ACKNOWLEDGED: ["acknowledged", "warn", "tick"],
  SHELVED: ["shelved", "off", "clock"],
  CLEARED: ["cleared", "good", "circle"],
};

export const APPROVALS = {
  AUTOMATIC: ["started without approval", "info", "circle"],
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

export const ACTION_KINDS = {
  APPROVE: "approve a compensation",
  REFUSE: "refuse a compensation",
  SETPOINT: "set a pressure",
  HOLD: "hold",
  RELEASE: "release",
  REPLACED: "whisker replaced",
  REBASELINE: "relearn baseline",
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
