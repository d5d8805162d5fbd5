-- Touch tests: touches that a robot makes on request, to measure a whisker's length or the error of a compensation.

-- A touch test, requested or proposed. `test_id` is its identifier on MQTT. `kind`: TIP sweeps an object over the tip, WALL
-- presses against a known surface. `reason`: why it was requested or proposed. `contacts`: number of requested touches. `state`:
-- PROPOSED waits for an operator; PENDING was requested and not answered; ACCEPTED, RUNNING, DONE, REJECTED, FAILED are the
-- robot's answers; EXPIRED had no answer or no end in time; ABANDONED belongs to an earlier boot or to a whisker that is not on
-- the robot any more; WITHDRAWN was proposed, and is requested now or not needed any more. `error`: why the robot rejected it.
-- `requested_us`, `updated_us`, `ended_us`: times of the request or proposal, of the last change, and of the end, by the
-- supervisor's clock. `touches` and `missed`: touches that came and touches that did not, received before the end. `length_mm`
-- and `length_sd_mm`: estimated length after a test that is DONE, and its standard deviation.
CREATE TABLE touch_tests (
    touch_test_id INTEGER PRIMARY KEY AUTOINCREMENT,
    test_id       TEXT NOT NULL UNIQUE,
    robot_id      INTEGER NOT NULL REFERENCES robots,
    whisker_id    INTEGER NOT NULL REFERENCES whiskers,
    kind          TEXT NOT NULL,
    reason        TEXT NOT NULL,
    contacts      INTEGER NOT NULL,
    state         TEXT NOT NULL,
    error         TEXT,
    requested_us  INTEGER NOT NULL,
    updated_us    INTEGER NOT NULL,
    ended_us      INTEGER,
    touches       INTEGER NOT NULL DEFAULT 0,
    missed        INTEGER NOT NULL DEFAULT 0,
    length_mm     REAL,
    length_sd_mm  REAL
);
CREATE INDEX touch_tests_of_whisker ON touch_tests (whisker_id, requested_us);

-- The touch test that an action TOUCH_TEST requested at once; NULL for other actions, and if the request had to wait: for the
-- robot, for a setpoint under way, or because of the limit per hour.
ALTER TABLE actions ADD COLUMN test_id TEXT;

-- A change of a touch test names its whisker. SQLite cannot change a column's CHECK, so the feed gets a new table; the numbers go
-- on after the last one.
CREATE TABLE changes_of_all_kinds (
    change_id   INTEGER PRIMARY KEY AUTOINCREMENT,
    tx          INTEGER NOT NULL DEFAULT 0,
    recorded_us INTEGER NOT NULL,
    fleet       TEXT   NOT NULL,
    kind        TEXT   NOT NULL
        CHECK (kind IN ('HEALTH', 'TRIM', 'COMPENSATION', 'SETPOINT', 'ERROR', 'ALARM', 'ACTION', 'POLICY', 'TOUCH_TEST')),
    robot_id    INTEGER,
    whisker_id  INTEGER,
    number      INTEGER,
    command_id  TEXT
);
INSERT INTO changes_of_all_kinds SELECT * FROM changes;
DELETE FROM sqlite_sequence WHERE name = 'changes_of_all_kinds';
INSERT INTO sqlite_sequence (name, seq) SELECT 'changes_of_all_kinds', seq FROM sqlite_sequence WHERE name = 'changes';
DROP TABLE changes;
ALTER TABLE changes_of_all_kinds RENAME TO changes;
CREATE INDEX changes_in_order ON changes (tx, change_id);
