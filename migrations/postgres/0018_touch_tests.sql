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
    touch_test_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    test_id       TEXT NOT NULL UNIQUE,
    robot_id      BIGINT NOT NULL REFERENCES robots,
    whisker_id    BIGINT NOT NULL REFERENCES whiskers,
    kind          TEXT NOT NULL,
    reason        TEXT NOT NULL,
    contacts      BIGINT NOT NULL,
    state         TEXT NOT NULL,
    error         TEXT,
    requested_us  BIGINT NOT NULL,
    updated_us    BIGINT NOT NULL,
    ended_us      BIGINT,
    touches       BIGINT NOT NULL DEFAULT 0,
    missed        BIGINT NOT NULL DEFAULT 0,
    length_mm     DOUBLE PRECISION,
    length_sd_mm  DOUBLE PRECISION
);
CREATE INDEX touch_tests_of_whisker ON touch_tests (whisker_id, requested_us);

-- The touch test that an action TOUCH_TEST requested at once; NULL for other actions, and if the request had to wait: for the
-- robot, for a setpoint under way, or because of the limit per hour.
ALTER TABLE actions ADD COLUMN test_id TEXT;

-- A change of a touch test names its whisker.
ALTER TABLE changes DROP CONSTRAINT changes_kind_check;
ALTER TABLE changes ADD CONSTRAINT changes_kind_check
    CHECK (kind IN ('HEALTH', 'TRIM', 'COMPENSATION', 'SETPOINT', 'ERROR', 'ALARM', 'ACTION', 'POLICY', 'TOUCH_TEST'));
