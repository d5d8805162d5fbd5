-- Webhooks: events that programs elsewhere receive over HTTP.

-- A target. `fleets` and `kinds`: those of its events, separated by commas; NULL for all. `level`: its least urgent events.
-- `secret` signs the requests; until `previous_until_us` the secret before it signs them, too. Neither is ever shown again.
-- (`done_tx`, `done_place`, `done_event`) names the last event of `webhook_events` that the target has taken, or that was given
-- up or does not concern it. `attempts`: failed attempts of the event after that one; `streak`: failed attempts since the last
-- success. No attempt is made before `next_us`. `holder` is the supervisor that delivers, until `held_until_us`. `last_*`: the
-- newest attempt, its status or its problem. `delivered`, `failed`: numbers of attempts; `lost`: number of events that were
-- removed undelivered, because the queue or the list of dead letters was full.
CREATE TABLE webhooks (
    webhook_id        INTEGER PRIMARY KEY AUTOINCREMENT,
    name              TEXT    NOT NULL UNIQUE,
    url               TEXT    NOT NULL,
    fleets            TEXT,
    kinds             TEXT,
    level             TEXT    NOT NULL,
    enabled           INTEGER NOT NULL,
    secret            BLOB    NOT NULL,
    previous_secret   BLOB,
    previous_until_us INTEGER,
    created_us        INTEGER NOT NULL,
    changed_us        INTEGER NOT NULL,
    changed_by        TEXT    NOT NULL,
    done_tx           INTEGER NOT NULL,
    done_place        INTEGER NOT NULL DEFAULT 0,
    done_event        INTEGER NOT NULL,
    attempts          INTEGER NOT NULL DEFAULT 0,
    streak            INTEGER NOT NULL DEFAULT 0,
    next_us           INTEGER NOT NULL DEFAULT 0,
    holder            TEXT,
    held_until_us     INTEGER NOT NULL DEFAULT 0,
    last_us           INTEGER,
    last_status       INTEGER,
    last_problem      TEXT,
    last_success_us   INTEGER,
    delivered         INTEGER NOT NULL DEFAULT 0,
    failed            INTEGER NOT NULL DEFAULT 0,
    lost              INTEGER NOT NULL DEFAULT 0
);

-- The outbox: events that targets may want, in the order of their commits. The triggers below write an event in the transaction
-- of the row that it is about, whichever statement writes that row; without targets they write nothing. `word` is the kind of an
-- alarm, the end reason of a compensation, the state of a setpoint, or the new condition of a whisker; `number` is the alarm, the
-- trim, the compensation or the change of health; `command_id` is the setpoint.
-- SQLite commits one transaction after the other, so `event_id` is in order; `tx` and `place` are 0.
-- Rows are removed after a week, and beyond the newest 20,000.
CREATE TABLE webhook_events (
    event_id    INTEGER PRIMARY KEY AUTOINCREMENT,
    tx          INTEGER NOT NULL DEFAULT 0,
    place       INTEGER NOT NULL DEFAULT 0,
    occurred_us INTEGER NOT NULL,
    kind        TEXT    NOT NULL CHECK (kind IN ('ALARM_RAISED', 'ALARM_CLEARED', 'TRIM', 'CONDITION_CHANGED',
        'COMPENSATION_BEGUN', 'COMPENSATION_ENDED', 'SETPOINT_FAILED')),
    word        TEXT,
    fleet       TEXT    NOT NULL,
    robot_id    INTEGER NOT NULL,
    whisker_id  INTEGER,
    number      INTEGER,
    command_id  TEXT
);
CREATE INDEX webhook_events_in_order ON webhook_events (tx, place, event_id);

-- Dead letters: events that a target has not taken after all attempts. `attempts`: number of failed attempts; `status` and
-- `problem`: result of the last one; `again`: whether an operator wants it delivered again. Each target keeps the newest 1,000.
CREATE TABLE webhook_dead_letters (
    webhook_id INTEGER NOT NULL REFERENCES webhooks ON DELETE CASCADE,
    event_id   INTEGER NOT NULL,
    attempts   INTEGER NOT NULL,
    dead_us    INTEGER NOT NULL,
    status     INTEGER,
    problem    TEXT    NOT NULL,
    again      INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (webhook_id, event_id)
);

-- One trigger for each way in which an event comes about. A migration that builds one of these tables anew must create its
-- triggers again.
CREATE TRIGGER webhook_alarm_raised AFTER INSERT ON alarms
    WHEN EXISTS (SELECT 1 FROM webhooks)
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT NEW.raised_us, 'ALARM_RAISED', NEW.kind, r.fleet, r.robot_id, NEW.whisker_id, NEW.alarm_id, NULL
            FROM robots r
            WHERE r.robot_id = coalesce(NEW.robot_id, (SELECT robot_id FROM whiskers WHERE whisker_id = NEW.whisker_id));
END;
CREATE TRIGGER webhook_alarm_cleared AFTER UPDATE OF cleared_us ON alarms
    WHEN EXISTS (SELECT 1 FROM webhooks)
        AND OLD.cleared_us IS NULL AND NEW.cleared_us IS NOT NULL
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT NEW.cleared_us, 'ALARM_CLEARED', NEW.kind, r.fleet, r.robot_id, NEW.whisker_id, NEW.alarm_id, NULL
            FROM robots r
            WHERE r.robot_id = coalesce(NEW.robot_id, (SELECT robot_id FROM whiskers WHERE whisker_id = NEW.whisker_id));
END;
CREATE TRIGGER webhook_trim AFTER INSERT ON trims
    WHEN EXISTS (SELECT 1 FROM webhooks)
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT NEW.detected_us, 'TRIM', NULL, r.fleet, r.robot_id, NEW.whisker_id, NEW.trim_id, NULL
            FROM robots r
            WHERE r.robot_id = NEW.robot_id;
END;
CREATE TRIGGER webhook_condition AFTER INSERT ON health_changes
    WHEN EXISTS (SELECT 1 FROM webhooks)
        AND NEW.kind = 'CONDITION'
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT NEW.recorded_us, 'CONDITION_CHANGED', NEW.becomes, r.fleet, r.robot_id, NEW.whisker_id, NEW.health_change_id, NULL
            FROM robots r
            WHERE r.robot_id = (SELECT robot_id FROM whiskers WHERE whisker_id = NEW.whisker_id);
END;
CREATE TRIGGER webhook_begun AFTER INSERT ON compensations
    WHEN EXISTS (SELECT 1 FROM webhooks)
        AND NEW.compensator_whisker_id IS NOT NULL AND NEW.approval = 'AUTOMATIC'
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT NEW.decided_us, 'COMPENSATION_BEGUN', NULL, r.fleet, r.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL
            FROM robots r
            WHERE r.robot_id = NEW.robot_id;
END;
CREATE TRIGGER webhook_approved AFTER UPDATE OF approval ON compensations
    WHEN EXISTS (SELECT 1 FROM webhooks)
        AND OLD.approval = 'PROPOSED' AND NEW.approval = 'APPROVED'
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT CAST((julianday('now') - 2440587.5) * 86400000 AS INTEGER) * 1000, 'COMPENSATION_BEGUN', NULL, r.fleet, r.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL
            FROM robots r
            WHERE r.robot_id = NEW.robot_id;
END;
CREATE TRIGGER webhook_ended AFTER UPDATE OF ended_us ON compensations
    WHEN EXISTS (SELECT 1 FROM webhooks)
        AND OLD.ended_us IS NULL AND NEW.ended_us IS NOT NULL AND NEW.compensator_whisker_id IS NOT NULL AND NEW.approval IN ('AUTOMATIC', 'APPROVED')
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT NEW.ended_us, 'COMPENSATION_ENDED', NEW.end_reason, r.fleet, r.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL
            FROM robots r
            WHERE r.robot_id = NEW.robot_id;
END;
CREATE TRIGGER webhook_setpoint_failed AFTER INSERT ON setpoint_states
    WHEN EXISTS (SELECT 1 FROM webhooks)
        AND NEW.state IN ('REJECTED', 'FAILED', 'EXPIRED')
BEGIN
    INSERT INTO webhook_events (occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT NEW.recorded_us, 'SETPOINT_FAILED', NEW.state, r.fleet, r.robot_id, s.whisker_id, NULL, NEW.command_id
            FROM setpoints s JOIN robots r ON r.robot_id = s.robot_id WHERE s.command_id = NEW.command_id;
END;
