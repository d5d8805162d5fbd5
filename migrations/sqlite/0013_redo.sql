-- Transactions that are committed, and whose rows are still to be written.

-- What leads to a setpoint is written here first, all of it, as the supervisor's own bytes: one short row, after whose commit the
-- setpoint goes out. Some milliseconds later it becomes the rows of all other tables, and this one is deleted with the same
-- commit. Whoever takes the fleet up begins with what is left here.
CREATE TABLE redo (
    fleet  TEXT    NOT NULL,
    number INTEGER NOT NULL,
    rows   BLOB    NOT NULL,
    PRIMARY KEY (fleet, number)
);
