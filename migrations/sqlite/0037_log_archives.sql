-- The archive that is written from the partitioned log instead of the table of contacts: one position for each shard.

-- The records of `topic` before `next_offset` are archived. `planned_to` is the offset after the last record of the files that
-- are being written; NULL between files. `seen` has the messages that the files up to `next_offset` contain, as JSON, because
-- the log may have a message twice. All records that the log received before `archived_to_us` are archived, µs since 1970 UTC. `files`, `contacts` and `bytes` count the archived ones.
CREATE TABLE log_archives (
    fleet       TEXT   NOT NULL,
    shard       BIGINT NOT NULL,
    topic       TEXT   NOT NULL,
    next_offset BIGINT NOT NULL,
    planned_to  BIGINT,
    seen        TEXT   NOT NULL,
    archived_to_us BIGINT NOT NULL,
    files       BIGINT NOT NULL DEFAULT 0,
    contacts    BIGINT NOT NULL DEFAULT 0,
    bytes       BIGINT NOT NULL DEFAULT 0,
    PRIMARY KEY (fleet, shard)
);
