-- What operators do: who asked for what, what became of it, and what it changed.

-- Everything that people asked for; once answered, a row is not changed any more, and none is removed. What concerns a
-- fleet waits as PENDING for the fleet's owner, who carries it out in the order of `action_id` and answers in the
-- transaction that has its effects: DONE, REFUSED with the reason in `problem`, or EXPIRED if that was not before
-- `expires_us`. `fleet` is NULL where no fleet is concerned; `array` and `whisker` go together. `kind` says what was
-- asked, `parameters` is a JSON object with its details, `reason` is why, in the person's words. `actor` and `role`
-- are who asked, `request_id` is the request that it came with. An actor's `idempotency_key` names one action only,
-- however often it is sent; rows without one are never the same.
CREATE TABLE actions (
    action_id       INTEGER PRIMARY KEY AUTOINCREMENT,
    fleet           TEXT,
    robot           TEXT,
    "array"         TEXT,
    whisker         INTEGER,
    compensation_id INTEGER,
    alarm_id        INTEGER,
    kind            TEXT    NOT NULL,
    parameters      TEXT    NOT NULL,
    reason          TEXT,
    actor           TEXT    NOT NULL,
    role            TEXT    NOT NULL,
    request_id      TEXT    NOT NULL,
    idempotency_key TEXT,
    asked_us        INTEGER NOT NULL,
    expires_us      INTEGER NOT NULL,
    state           TEXT    NOT NULL CHECK (state IN ('PENDING', 'DONE', 'REFUSED', 'EXPIRED')),
    problem         TEXT,
    done_us         INTEGER,
    UNIQUE (actor, idempotency_key)
);
CREATE INDEX actions_pending ON actions (fleet, action_id) WHERE state = 'PENDING';

-- The policies that operators have set: in force is the highest version of a fleet, and without a row what the
-- configuration says. `mode` is AUTOMATIC or ADVISE, where compensations wait for approval; the others are as in the
-- configuration. `action_id` is the action that asked for it.
CREATE TABLE policies (
    fleet               TEXT    NOT NULL,
    version             INTEGER NOT NULL,
    mode                TEXT    NOT NULL CHECK (mode IN ('AUTOMATIC', 'ADVISE')),
    objective           TEXT    NOT NULL CHECK (objective IN ('TIP', 'MEAN')),
    longer_for_shorter  TEXT    NOT NULL CHECK (longer_for_shorter IN ('NEVER', 'LAST_RESORT', 'ALLOWED')),
    predicted_error_max REAL    NOT NULL,
    own_role_cost       REAL    NOT NULL,
    change_margin       REAL    NOT NULL,
    changed_us          INTEGER NOT NULL,
    changed_by          TEXT    NOT NULL,
    reason              TEXT,
    action_id           INTEGER NOT NULL REFERENCES actions,
    PRIMARY KEY (fleet, version)
);

-- Whether an operator holds it: no automatic setpoint goes to a held whisker, nor to any of a held robot's.
ALTER TABLE robots ADD COLUMN held INTEGER NOT NULL DEFAULT 0;
ALTER TABLE whiskers ADD COLUMN held INTEGER NOT NULL DEFAULT 0;

-- AUTOMATIC: nobody was asked. PROPOSED: it waits for an operator, and nothing was sent; if it has ended meanwhile,
-- nobody answered. APPROVED or REFUSED: what the operator said.
ALTER TABLE compensations ADD COLUMN approval TEXT NOT NULL DEFAULT 'AUTOMATIC'
    CHECK (approval IN ('AUTOMATIC', 'PROPOSED', 'APPROVED', 'REFUSED'));

-- An alarm stands until its cause is over, at `cleared_us`; of a whisker's alarms of one kind at most one stands.
-- Alarms of before were moments: they are over.
ALTER TABLE alarms ADD COLUMN cleared_us INTEGER;
UPDATE alarms SET cleared_us = raised_us;
CREATE INDEX alarms_standing ON alarms (whisker_id, kind) WHERE cleared_us IS NULL;
