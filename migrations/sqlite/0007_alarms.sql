-- What people say to alarms.

-- Who has seen an alarm, and what they made of it.
ALTER TABLE alarms ADD COLUMN acknowledged_us INTEGER;
ALTER TABLE alarms ADD COLUMN acknowledged_by TEXT;
ALTER TABLE alarms ADD COLUMN acknowledged_reason TEXT;

-- Alarms that shall be quiet for a while: those of a kind about a whisker, also ones that are raised meanwhile. Only the
-- newest row of a whisker and kind counts; one that was ended has its end in `until_us`.
CREATE TABLE alarm_shelves (
    alarm_shelf_id INTEGER PRIMARY KEY,
    whisker_id     INTEGER NOT NULL REFERENCES whiskers,
    kind           TEXT   NOT NULL,
    shelved_us     INTEGER NOT NULL,
    until_us       INTEGER NOT NULL,
    shelved_by     TEXT   NOT NULL,
    reason         TEXT   NOT NULL
);
CREATE INDEX alarm_shelves_of_whisker ON alarm_shelves (whisker_id, kind);
