-- What happened to a fleet's robots since their states were written last.

-- One row for each transaction: what ordinary messages said, in the supervisor's own bytes. A robot's state is written some time
-- after its first contact that it does not contain, or at once where something is decided; until then it is its row in `robots`
-- and `whiskers`, given again what stands here. Rows that are in all states are deleted.
CREATE TABLE journal (
    fleet   TEXT    NOT NULL,
    number  INTEGER NOT NULL,
    entries BLOB    NOT NULL,
    PRIMARY KEY (fleet, number)
);

-- The journal's rows up to this number are in the robot's state.
ALTER TABLE robots ADD COLUMN journal_number INTEGER NOT NULL DEFAULT 0;
