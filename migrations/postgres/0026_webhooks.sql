-- Webhooks: events that programs elsewhere receive over HTTP.

-- A target. `fleets` and `kinds`: those of its events, separated by commas; NULL for all. `level`: its least urgent events.
-- `secret` signs the requests; until `previous_until_us` the secret before it signs them, too. Neither is ever shown again.
-- (`done_tx`, `done_place`, `done_event`) names the last event of `webhook_events` that the target has taken, or that was given
-- up or does not concern it. `attempts`: failed attempts of the event after that one; `streak`: failed attempts since the last
-- success. No attempt is made before `next_us`. `holder` is the supervisor that delivers, until `held_until_us`. `last_*`: the
-- newest attempt, its status or its problem. `delivered`, `failed`: numbers of attempts; `lost`: number of events that were
-- removed undelivered, because the queue or the list of dead letters was full.
CREATE TABLE webhooks (
    webhook_id        BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    name              TEXT    NOT NULL UNIQUE,
    url               TEXT    NOT NULL,
    fleets            TEXT,
    kinds             TEXT,
    level             TEXT    NOT NULL,
    enabled           BOOLEAN NOT NULL,
    secret            BYTEA    NOT NULL,
    previous_secret   BYTEA,
    previous_until_us BIGINT ,
    created_us        BIGINT  NOT NULL,
    changed_us        BIGINT  NOT NULL,
    changed_by        TEXT    NOT NULL,
    done_tx           BIGINT  NOT NULL,
    done_place        BIGINT  NOT NULL DEFAULT 0,
    done_event        BIGINT  NOT NULL,
    attempts          BIGINT  NOT NULL DEFAULT 0,
    streak            BIGINT  NOT NULL DEFAULT 0,
    next_us           BIGINT  NOT NULL DEFAULT 0,
    holder            TEXT,
    held_until_us     BIGINT  NOT NULL DEFAULT 0,
    last_us           BIGINT ,
    last_status       BIGINT ,
    last_problem      TEXT,
    last_success_us   BIGINT ,
    delivered         BIGINT  NOT NULL DEFAULT 0,
    failed            BIGINT  NOT NULL DEFAULT 0,
    lost              BIGINT  NOT NULL DEFAULT 0
);

-- The outbox: events that targets may want, in the order of their commits. The triggers below write an event in the transaction
-- of the row that it is about, whichever statement writes that row; without targets they write nothing. `word` is the kind of an
-- alarm, the end reason of a compensation, the state of a setpoint, or the new condition of a whisker; `number` is the alarm, the
-- trim, the compensation or the change of health; `command_id` is the setpoint.
-- `tx` is the transaction; (tx, place, event_id) of transactions that all have ended is in order, as in `changes`. `place` is 16
-- times `occurred_us` plus a rank of the kind: a statement that writes several tables does so in no certain order.
-- Rows are removed after a week, and beyond the newest 20,000.
CREATE TABLE webhook_events (
    event_id    BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    tx          BIGINT  NOT NULL DEFAULT (pg_current_xact_id()::text::bigint),
    place       BIGINT  NOT NULL DEFAULT 0,
    occurred_us BIGINT  NOT NULL,
    kind        TEXT    NOT NULL CHECK (kind IN ('ALARM_RAISED', 'ALARM_CLEARED', 'TRIM', 'CONDITION_CHANGED',
        'COMPENSATION_BEGUN', 'COMPENSATION_ENDED', 'SETPOINT_FAILED')),
    word        TEXT,
    fleet       TEXT    NOT NULL,
    robot_id    BIGINT  NOT NULL,
    whisker_id  BIGINT ,
    number      BIGINT ,
    command_id  TEXT
);
CREATE INDEX webhook_events_in_order ON webhook_events (tx, place, event_id);

-- Dead letters: events that a target has not taken after all attempts. `attempts`: number of failed attempts; `status` and
-- `problem`: result of the last one; `again`: whether an operator wants it delivered again. Each target keeps the newest 1,000.
CREATE TABLE webhook_dead_letters (
    webhook_id BIGINT  NOT NULL REFERENCES webhooks ON DELETE CASCADE,
    event_id   BIGINT  NOT NULL,
    attempts   BIGINT  NOT NULL,
    dead_us    BIGINT  NOT NULL,
    status     BIGINT ,
    problem    TEXT    NOT NULL,
    again      BOOLEAN NOT NULL DEFAULT FALSE,
    PRIMARY KEY (webhook_id, event_id)
);

-- Writes an event, unless there are no targets.
CREATE FUNCTION webhook_event(
    rank BIGINT, event_kind TEXT, event_word TEXT, at_us BIGINT, of_robot BIGINT, of_whisker BIGINT, of_number BIGINT, of_command TEXT
) RETURNS VOID LANGUAGE sql AS $$
    INSERT INTO webhook_events (place, occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT at_us * 16 + rank, at_us, event_kind, event_word, r.fleet, r.robot_id, of_whisker, of_number, of_command FROM robots r
        WHERE r.robot_id = coalesce(of_robot, (SELECT w.robot_id FROM whiskers w WHERE w.whisker_id = of_whisker))
        AND EXISTS (SELECT 1 FROM webhooks)
$$;

-- One trigger for each way in which an event comes about.
CREATE FUNCTION webhook_alarm_raised() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(5, 'ALARM_RAISED', NEW.kind, NEW.raised_us, NEW.robot_id, NEW.whisker_id, NEW.alarm_id, NULL);
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_alarm_raised AFTER INSERT ON alarms FOR EACH ROW
    EXECUTE FUNCTION webhook_alarm_raised();
CREATE FUNCTION webhook_alarm_cleared() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(6, 'ALARM_CLEARED', NEW.kind, NEW.cleared_us, NEW.robot_id, NEW.whisker_id, NEW.alarm_id, NULL);
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_alarm_cleared AFTER UPDATE OF cleared_us ON alarms FOR EACH ROW
    WHEN (OLD.cleared_us IS NULL AND NEW.cleared_us IS NOT NULL)
    EXECUTE FUNCTION webhook_alarm_cleared();
CREATE FUNCTION webhook_trim() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(1, 'TRIM', NULL, NEW.detected_us, NEW.robot_id, NEW.whisker_id, NEW.trim_id, NULL);
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_trim AFTER INSERT ON trims FOR EACH ROW
    EXECUTE FUNCTION webhook_trim();
CREATE FUNCTION webhook_condition() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(0, 'CONDITION_CHANGED', NEW.becomes, NEW.recorded_us, NULL, NEW.whisker_id, NEW.health_change_id, NULL);
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_condition AFTER INSERT ON health_changes FOR EACH ROW
    WHEN (NEW.kind = 'CONDITION')
    EXECUTE FUNCTION webhook_condition();
CREATE FUNCTION webhook_begun() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(3, 'COMPENSATION_BEGUN', NULL, NEW.decided_us, NEW.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL);
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_begun AFTER INSERT ON compensations FOR EACH ROW
    WHEN (NEW.compensator_whisker_id IS NOT NULL AND NEW.approval = 'AUTOMATIC')
    EXECUTE FUNCTION webhook_begun();
CREATE FUNCTION webhook_approved() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(3, 'COMPENSATION_BEGUN', NULL, (extract(epoch FROM clock_timestamp()) * 1000000)::bigint, NEW.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL);
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_approved AFTER UPDATE OF approval ON compensations FOR EACH ROW
    WHEN (OLD.approval = 'PROPOSED' AND NEW.approval = 'APPROVED')
    EXECUTE FUNCTION webhook_approved();
CREATE FUNCTION webhook_ended() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(2, 'COMPENSATION_ENDED', NEW.end_reason, NEW.ended_us, NEW.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL);
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_ended AFTER UPDATE OF ended_us ON compensations FOR EACH ROW
    WHEN (OLD.ended_us IS NULL AND NEW.ended_us IS NOT NULL AND NEW.compensator_whisker_id IS NOT NULL AND NEW.approval IN ('AUTOMATIC', 'APPROVED'))
    EXECUTE FUNCTION webhook_ended();
CREATE FUNCTION webhook_setpoint_failed() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM webhook_event(4, 'SETPOINT_FAILED', NEW.state, NEW.recorded_us, s.robot_id, s.whisker_id, NULL, NEW.command_id) FROM setpoints s
        WHERE s.command_id = NEW.command_id;
    RETURN NULL;
END $$;
CREATE TRIGGER webhook_setpoint_failed AFTER INSERT ON setpoint_states FOR EACH ROW
    WHEN (NEW.state IN ('REJECTED', 'FAILED', 'EXPIRED'))
    EXECUTE FUNCTION webhook_setpoint_failed();
