-- What happened, in the order in which it was committed: what live pages follow. It is a feed, not a record: rows are
-- removed after a day.

-- `kind` is HEALTH, TRIM, COMPENSATION, SETPOINT, ERROR, ALARM, ACTION or POLICY; `number` that of the trim, compensation,
-- alarm or action, `command_id` that of a setpoint. `whisker_id` and `robot_id` are NULL where `number` or `command_id`
-- lead to them, or the whole fleet is meant. `tx` is the transaction: numbers are taken before the commit, so that of two
-- transactions at once the later number may be seen first; (tx, change_id) of transactions that all have ended is in order.
CREATE TABLE changes (
    change_id   INTEGER PRIMARY KEY AUTOINCREMENT,
    tx          INTEGER NOT NULL DEFAULT 0,
    recorded_us INTEGER NOT NULL,
    fleet       TEXT   NOT NULL,
    kind        TEXT   NOT NULL CHECK (kind IN ('HEALTH', 'TRIM', 'COMPENSATION', 'SETPOINT', 'ERROR', 'ALARM', 'ACTION', 'POLICY')),
    robot_id    INTEGER,
    whisker_id  INTEGER,
    number      INTEGER,
    command_id  TEXT
);
CREATE INDEX changes_in_order ON changes (tx, change_id);
