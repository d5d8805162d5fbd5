-- Messages that the database refuses.

-- A value in such a message leads to a row that no attempt can write. The supervisor writes everything else, keeps the message
-- here for people to look at, and receipts it, so that its robot does not send it again. The newest 1000 of each fleet are kept,
-- each up to 64 KiB. `code` is the database's own code of the error: an SQLSTATE, or SQLite's extended result code.
CREATE TABLE quarantine (
    quarantine_id  BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    fleet          TEXT    NOT NULL,
    robot          TEXT    NOT NULL,
    topic          TEXT    NOT NULL,
    boot_id        TEXT,
    seq            BIGINT ,
    received_us    BIGINT  NOT NULL,
    quarantined_us BIGINT  NOT NULL,
    cause          TEXT    NOT NULL CHECK (cause IN ('DATA', 'CONSTRAINT', 'SIZE')),
    code           TEXT    NOT NULL,
    payload        BYTEA   NOT NULL
);
CREATE INDEX quarantine_of_fleet ON quarantine (fleet, quarantine_id);
