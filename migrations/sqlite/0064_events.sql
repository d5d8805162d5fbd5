-- One log of events for all readers: live pages, webhooks and Kafka. The program writes each event in the transaction of its
-- fact. It replaces the feed of changes, the outbox of webhooks with its triggers, and the outbox of Kafka.

-- `version` is that of `data`, a JSON object. `word` is the kind of an alarm or the state of a setpoint. `audience` says who may
-- read the event: KAFKA alone (contacts), PROGRAMS also live pages, PEOPLE also webhooks. `robot_id` and `whisker_id` are NULL where
-- a whole fleet or robot is concerned.
-- SQLite commits one transaction after the other, so `event_id` is in order; `tx` is 0.
CREATE TABLE events (
    event_id    INTEGER PRIMARY KEY AUTOINCREMENT,
    tx          INTEGER NOT NULL DEFAULT 0,
    recorded_us INTEGER NOT NULL,
    version     INTEGER NOT NULL,
    kind        TEXT    NOT NULL,
    audience    TEXT    NOT NULL CHECK (audience IN ('KAFKA', 'PROGRAMS', 'PEOPLE')),
    word        TEXT,
    fleet       TEXT    NOT NULL,
    robot_id    INTEGER,
    whisker_id  INTEGER,
    data        TEXT    NOT NULL
);
CREATE INDEX events_in_order ON events (tx, event_id) WHERE audience <> 'KAFKA';
CREATE INDEX events_for_webhooks ON events (tx, event_id) WHERE audience = 'PEOPLE';
CREATE INDEX events_of_fleet ON events (fleet, tx, event_id);

-- Events up to this position of a fleet are in Kafka. `seen_us` is the newest sign of the publisher: after a week without one,
-- no event waits for it.
CREATE TABLE event_positions (
    fleet    TEXT    PRIMARY KEY,
    tx       INTEGER NOT NULL,
    event_id INTEGER NOT NULL,
    seen_us  INTEGER NOT NULL
);

-- Events that wait for webhooks keep their numbers, which targets and dead letters name.
INSERT INTO events (event_id, recorded_us, version, kind, audience, word, fleet, robot_id, whisker_id, data)
SELECT e.event_id, e.occurred_us, 2, e.kind, 'PEOPLE',
    CASE WHEN e.kind IN ('ALARM_RAISED', 'ALARM_CLEARED', 'SETPOINT_FAILED') THEN e.word END, e.fleet, e.robot_id, e.whisker_id,
    CASE e.kind
        WHEN 'TRIM' THEN json_object('trim', json_object('trim_id', e.number, 'length_before_mm', t.length_before_mm,
            'length_after_mm', t.length_after_mm, 'length_after_sd_mm', t.length_after_sd_mm,
            'contacts_to_detect', t.contacts_to_detect))
        WHEN 'CONDITION_CHANGED' THEN json_object('condition', json_object('was', h.was, 'becomes', e.word))
        WHEN 'COMPENSATION_BEGUN' THEN json_object('compensation', json_object('compensation_id', e.number,
            'case', c.compensation_case, 'compensator_whisker', v.whisker, 'pressure_mpa', c.pressure_mpa,
            'predicted_error', c.predicted_error, 'end_reason', NULL))
        WHEN 'COMPENSATION_ENDED' THEN json_object('compensation', json_object('compensation_id', e.number,
            'case', c.compensation_case, 'compensator_whisker', v.whisker, 'pressure_mpa', c.pressure_mpa,
            'predicted_error', c.predicted_error, 'end_reason', e.word))
        WHEN 'SETPOINT_FAILED' THEN json_object('setpoint', json_object('command_id', e.command_id, 'state', e.word,
            'pressure_mpa', s.pressure_mpa, 'rejection', s.error, 'compensation_id', s.compensation_id, 'reason', s.reason))
        ELSE '{}'
    END
FROM webhook_events e LEFT JOIN trims t ON e.kind = 'TRIM' AND t.trim_id = e.number
LEFT JOIN health_changes h ON e.kind = 'CONDITION_CHANGED' AND h.health_change_id = e.number
LEFT JOIN compensations c ON e.kind IN ('COMPENSATION_BEGUN', 'COMPENSATION_ENDED') AND c.compensation_id = e.number
LEFT JOIN whiskers v ON v.whisker_id = c.compensator_whisker_id LEFT JOIN setpoints s ON s.command_id = e.command_id
ORDER BY e.event_id;
DELETE FROM sqlite_sequence WHERE name = 'events';
INSERT INTO sqlite_sequence (name, seq) SELECT 'events', seq FROM sqlite_sequence WHERE name = 'webhook_events';

-- Events that wait for Kafka. A row has those of a transaction: for each the version 1 and the robot's name, then 1 for contacts,
-- else 0, and a JSON object. Each text has its length before it, 4 bytes with the lowest first.
WITH RECURSIVE fields (fleet, epoch, number, nth, rest, bytes) AS (
    SELECT fleet, epoch, number, 0, events, ('[0x' || hex(substr(events, 5, 1)) || hex(substr(events, 4, 1))
        || hex(substr(events, 3, 1)) || hex(substr(events, 2, 1)) || ']') ->> 0
    FROM event_outbox WHERE length(events) > 0
    UNION ALL
    SELECT fleet, epoch, number, nth + 1, substr(rest, 6 + bytes), ('[0x' || hex(substr(rest, 10 + bytes, 1))
        || hex(substr(rest, 9 + bytes, 1)) || hex(substr(rest, 8 + bytes, 1)) || hex(substr(rest, 7 + bytes, 1)) || ']') ->> 0
    FROM fields WHERE length(rest) > 5 + bytes
), waiting AS (
    SELECT fleet, epoch, number, nth, CAST(substr(rest, 6, bytes) AS TEXT) AS body FROM fields WHERE nth % 2 = 1
)
INSERT INTO events (recorded_us, version, kind, audience, word, fleet, robot_id, whisker_id, data)
SELECT CAST(round(unixepoch(body ->> 'timestamp', 'subsec') * 1e6) AS INTEGER), 2,
    CASE WHEN body ->> 'type' = 'COMPENSATION_APPROVED' THEN 'COMPENSATION_BEGUN'
        WHEN body ->> '$.setpoint.state' IN ('REJECTED', 'FAILED', 'EXPIRED') THEN 'SETPOINT_FAILED' ELSE body ->> 'type' END,
    CASE WHEN body ->> 'type' IN ('CONTACTS', 'CONTACTS_LEFT_OUT') THEN 'KAFKA' ELSE 'PROGRAMS' END,
    coalesce(body ->> '$.alarm.kind', body ->> '$.setpoint.state'), w.fleet, r.robot_id, k.whisker_id,
    json_remove(body, '$.type', '$.version', '$.timestamp', '$.fleet', '$.robot', '$.array', '$.whisker', '$.alarm')
FROM waiting w LEFT JOIN robots r ON r.fleet = w.fleet AND r.robot = body ->> 'robot'
LEFT JOIN arrays a ON a.robot_id = r.robot_id AND a."array" = body ->> 'array'
LEFT JOIN whiskers k ON k.array_id = a.array_id AND k.whisker = body ->> 'whisker'
ORDER BY epoch, number, nth;

-- Kafka has all events of a fleet before those that wait for it; without any, all.
INSERT INTO event_positions (fleet, tx, event_id, seen_us)
SELECT fleet, 0, (SELECT coalesce(max(seq), 0) FROM sqlite_sequence WHERE name = 'webhook_events'),
    CAST(unixepoch() AS INTEGER) * 1000000 FROM (SELECT DISTINCT fleet FROM event_outbox);

DROP TABLE event_outbox;
DROP TABLE changes;
DROP TRIGGER webhook_alarm_raised;
DROP TRIGGER webhook_alarm_cleared;
DROP TRIGGER webhook_trim;
DROP TRIGGER webhook_condition;
DROP TRIGGER webhook_begun;
DROP TRIGGER webhook_approved;
DROP TRIGGER webhook_ended;
DROP TRIGGER webhook_setpoint_failed;
DROP TABLE webhook_events;
ALTER TABLE webhooks DROP COLUMN done_place;
