-- Transactions that are committed, and whose rows are still to be written.

-- What leads to a setpoint is written here first, all of it, as the supervisor's own bytes: one short row, after whose commit the
-- setpoint goes out. Some milliseconds later it becomes the rows of all other tables, and this one is deleted with the same
-- commit. Whoever takes the fleet up begins with what is left here.
CREATE TABLE redo (
    fleet  TEXT   NOT NULL,
    number BIGINT NOT NULL,
    rows   BYTEA  NOT NULL,
    PRIMARY KEY (fleet, number)
);

-- It does not last: neither compressing it nor keeping it out of the way would pay.
ALTER TABLE redo ALTER COLUMN rows SET STORAGE EXTERNAL;
ALTER TABLE redo SET (
    autovacuum_vacuum_scale_factor = 0, autovacuum_vacuum_threshold = 2000,
    toast.autovacuum_vacuum_scale_factor = 0, toast.autovacuum_vacuum_threshold = 20000
);
