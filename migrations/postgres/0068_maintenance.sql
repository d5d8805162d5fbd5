-- Windows of maintenance of a fleet, or of one robot (`robot_id`): from `begins_us` for `lasts_us`, again each `repeat_us`
-- (NULL: once). None begins from `ended_us` on, and one that is under way ends then (NULL: without such a time). Alarms that
-- are raised in a window are shelved, and notify nobody. `told_us`: end of the last window whose alarms that still stood
-- were told again.
CREATE TABLE maintenance (
    maintenance_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    fleet          TEXT    NOT NULL,
    robot_id       BIGINT REFERENCES robots,
    begins_us      BIGINT NOT NULL,
    lasts_us       BIGINT NOT NULL,
    repeat_us      BIGINT,
    ended_us       BIGINT,
    told_us        BIGINT NOT NULL,
    reason         TEXT    NOT NULL,
    set_by         TEXT    NOT NULL,
    set_us         BIGINT NOT NULL
);
