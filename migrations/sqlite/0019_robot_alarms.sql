-- Alarms about a robot as a whole. SQLite cannot make a column nullable, so both tables are built anew.

-- An alarm concerns a whisker, or a robot as a whole: exactly one of `whisker_id` and `robot_id` is set. Of a robot's alarms of
-- one kind at most one stands.
CREATE TABLE alarms_19 (
    alarm_id            INTEGER PRIMARY KEY,
    whisker_id          INTEGER REFERENCES whiskers,
    raised_us           INTEGER NOT NULL,
    kind                TEXT    NOT NULL,
    cleared_us          INTEGER,
    acknowledged_us     INTEGER,
    acknowledged_by     TEXT,
    acknowledged_reason TEXT,
    robot_id            INTEGER REFERENCES robots,
    CHECK ((whisker_id IS NULL) <> (robot_id IS NULL))
);
INSERT INTO alarms_19 (alarm_id, whisker_id, raised_us, kind, cleared_us, acknowledged_us, acknowledged_by, acknowledged_reason)
    SELECT alarm_id, whisker_id, raised_us, kind, cleared_us, acknowledged_us, acknowledged_by, acknowledged_reason FROM alarms;
DROP TABLE alarms;
ALTER TABLE alarms_19 RENAME TO alarms;
CREATE INDEX alarms_of_whisker ON alarms (whisker_id, raised_us);
CREATE INDEX alarms_standing ON alarms (whisker_id, kind) WHERE cleared_us IS NULL;
CREATE INDEX alarms_of_robot ON alarms (robot_id, raised_us) WHERE robot_id IS NOT NULL;
CREATE INDEX alarms_standing_of_robot ON alarms (robot_id, kind) WHERE cleared_us IS NULL AND robot_id IS NOT NULL;

-- The list of alarms begins with the newest.
CREATE INDEX alarms_in_order ON alarms (raised_us, alarm_id);

-- Shelved are the alarms of a kind about a whisker, or about a robot as a whole. Only the newest row of a whisker or robot and
-- kind counts; one that was ended has its end in `until_us`.
CREATE TABLE alarm_shelves_19 (
    alarm_shelf_id INTEGER PRIMARY KEY,
    whisker_id     INTEGER REFERENCES whiskers,
    kind           TEXT    NOT NULL,
    shelved_us     INTEGER NOT NULL,
    until_us       INTEGER NOT NULL,
    shelved_by     TEXT    NOT NULL,
    reason         TEXT    NOT NULL,
    robot_id       INTEGER REFERENCES robots,
    CHECK ((whisker_id IS NULL) <> (robot_id IS NULL))
);
INSERT INTO alarm_shelves_19 (alarm_shelf_id, whisker_id, kind, shelved_us, until_us, shelved_by, reason)
    SELECT alarm_shelf_id, whisker_id, kind, shelved_us, until_us, shelved_by, reason FROM alarm_shelves;
DROP TABLE alarm_shelves;
ALTER TABLE alarm_shelves_19 RENAME TO alarm_shelves;
CREATE INDEX alarm_shelves_of_whisker ON alarm_shelves (whisker_id, kind);
CREATE INDEX alarm_shelves_of_robot ON alarm_shelves (robot_id, kind) WHERE robot_id IS NOT NULL;
