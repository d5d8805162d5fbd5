-- The objective SHAPE: air for the shape over the contact ratio, and a gain on the readings for the level. Robots whose
-- factsheet does not say applies_gain have TIP instead. SQLite cannot change a column's CHECK, so the policies get a new table.
CREATE TABLE policies_of_all_objectives (
    fleet               TEXT    NOT NULL,
    version             INTEGER NOT NULL,
    mode                TEXT    NOT NULL CHECK (mode IN ('AUTOMATIC', 'ADVISE')),
    objective           TEXT    NOT NULL CHECK (objective IN ('TIP', 'MEAN', 'SHAPE')),
    longer_for_shorter  TEXT    NOT NULL CHECK (longer_for_shorter IN ('NEVER', 'LAST_RESORT', 'ALLOWED')),
    predicted_error_max REAL    NOT NULL,
    own_role_cost       REAL    NOT NULL,
    change_margin       REAL    NOT NULL,
    changed_us          INTEGER NOT NULL,
    changed_by          TEXT    NOT NULL,
    reason              TEXT,
    action_id           INTEGER NOT NULL REFERENCES actions,
    PRIMARY KEY (fleet, version)
);
INSERT INTO policies_of_all_objectives
    SELECT fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, change_margin, changed_us,
           changed_by, reason, action_id
    FROM policies;
DROP TABLE policies;
ALTER TABLE policies_of_all_objectives RENAME TO policies;
