-- Staged roll-outs of a policy or a calibration within a fleet.

-- A roll-out. `rollout_id` is the number of the action that began it, and the seed of the order in which robots are changed.
-- `kind`: POLICY or CALIBRATION. `change`: the policy, or number and content of the calibration, as JSON. `state`: RUNNING, PAUSED,
-- ROLLED_BACK or COMPLETED. `stage`: FEW (5 % of the robots), QUARTER (25 %) or ALL. Robots whose place in the order is at most
-- `place_max` are changed. `level`: probability that a change without an effect is rolled back, at most. `robots`: number of changed
-- robots with a measured error that complete a stage. `looks`: comparisons in this stage so far. `probability`, `changed_robots`,
-- `unchanged_robots`, `changed_error`, `unchanged_error`: the newest comparison, with numbers of robots and median errors as ratios.
-- The fleet's owner writes the row in the transaction in which the robots change. A fleet has at most one roll-out that is
-- RUNNING or PAUSED.
CREATE TABLE rollouts (
    rollout_id       INTEGER NOT NULL PRIMARY KEY REFERENCES actions,
    fleet            TEXT   NOT NULL,
    kind             TEXT   NOT NULL CHECK (kind IN ('POLICY', 'CALIBRATION')),
    change           TEXT   NOT NULL,
    state            TEXT   NOT NULL CHECK (state IN ('RUNNING', 'PAUSED', 'ROLLED_BACK', 'COMPLETED')),
    stage            TEXT   NOT NULL CHECK (stage IN ('FEW', 'QUARTER', 'ALL')),
    place_max        INTEGER NOT NULL,
    level            REAL NOT NULL,
    robots           INTEGER NOT NULL,
    looks            INTEGER NOT NULL,
    probability      REAL,
    changed_robots   INTEGER NOT NULL,
    unchanged_robots INTEGER NOT NULL,
    changed_error    REAL,
    unchanged_error  REAL,
    started_us       INTEGER NOT NULL,
    stage_us         INTEGER NOT NULL,
    updated_us       INTEGER NOT NULL,
    started_by       TEXT   NOT NULL,
    reason           TEXT
);
CREATE UNIQUE INDEX rollouts_open ON rollouts (fleet) WHERE state IN ('RUNNING', 'PAUSED');

-- Events of roll-outs. `event`: STARTED, LOOKED, ADVANCED, PAUSED, RESUMED, ROLLED_BACK or COMPLETED. `actor` is a person or
-- token, or `supervisor` if it followed from the errors. `detail` says why, in words.
CREATE TABLE rollout_events (
    rollout_event_id INTEGER PRIMARY KEY,
    rollout_id       INTEGER NOT NULL REFERENCES rollouts,
    recorded_us      INTEGER NOT NULL,
    event            TEXT   NOT NULL,
    stage            TEXT   NOT NULL,
    actor            TEXT   NOT NULL,
    detail           TEXT   NOT NULL
);
CREATE INDEX rollout_events_of ON rollout_events (rollout_id);

-- A roll-out compares the compensations that were decided since its stage began.
CREATE INDEX compensations_decided ON compensations (decided_us);
