-- The archive: contacts of a fleet as files on an object store, and the position up to which they are there.

-- Up to `archived_to_us` (by `received_us`) all contacts of the fleet are in files. `planned_to_us` is the end of the file that
-- is being written; its begin is `archived_to_us`, and its name follows from both. `next_contact_id` is only used by SQLite.
-- `files`, `contacts` and `bytes` count what was archived.
CREATE TABLE archives (
    fleet           TEXT   PRIMARY KEY,
    archived_to_us  INTEGER NOT NULL,
    planned_to_us   INTEGER,
    next_contact_id INTEGER NOT NULL DEFAULT 0,
    files           INTEGER NOT NULL DEFAULT 0,
    contacts        INTEGER NOT NULL DEFAULT 0,
    bytes           INTEGER NOT NULL DEFAULT 0
);

-- All contacts of a shard that will still be written have a `received_us` of at least `written_to_us`: the owner ensures it.
CREATE TABLE archive_horizons (
    fleet         TEXT   NOT NULL,
    shard         INTEGER NOT NULL,
    written_to_us INTEGER NOT NULL,
    PRIMARY KEY (fleet, shard)
);
