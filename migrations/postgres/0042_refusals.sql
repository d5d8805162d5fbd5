-- Counts of each robot's refusals.

-- A contact or another entry with a wrong value is left out of its message, and a message that cannot be used is left out as a
-- whole. `topic`: topic of the message below the robot's level. `reason`: a word of the metric vibrissa_messages_refused_total.
-- `refused`: number of refused messages and entries. `problem`: the newest refusal in words. A robot has at most one row for
-- each topic and reason.
CREATE TABLE refusals (
    refusal_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    robot_id   BIGINT NOT NULL REFERENCES robots,
    topic      TEXT    NOT NULL,
    reason     TEXT    NOT NULL,
    refused    BIGINT NOT NULL,
    first_us   BIGINT NOT NULL,
    refused_us BIGINT NOT NULL,
    problem    TEXT    NOT NULL,
    UNIQUE (robot_id, topic, reason)
);
