-- Shards: the parts of a fleet that different supervisors can own. Most fleets have one.

-- `shard` is the number of the part, from 0. `shards` is the number of the fleet's shards, the same in all its rows;
-- `shards_wanted` is the number that it shall get. It changes when all shards are without an owner and the journal is empty.
CREATE TABLE leases_new (
    fleet         TEXT    NOT NULL,
    epoch         INTEGER NOT NULL,
    owner         TEXT,
    holder        TEXT,
    commits       INTEGER NOT NULL DEFAULT 0,
    expires_us    INTEGER,
    shard         INTEGER NOT NULL DEFAULT 0,
    shards        INTEGER NOT NULL DEFAULT 1,
    shards_wanted INTEGER NOT NULL DEFAULT 1,
    PRIMARY KEY (fleet, shard)
);
INSERT INTO leases_new (fleet, epoch, owner, holder, commits, expires_us)
    SELECT fleet, epoch, owner, holder, commits, expires_us FROM leases;
DROP TABLE leases;
ALTER TABLE leases_new RENAME TO leases;

-- Every epoch that there was, and whose it was.
CREATE TABLE epochs_new (
    fleet    TEXT    NOT NULL,
    epoch    INTEGER NOT NULL,
    owner    TEXT    NOT NULL,
    holder   TEXT    NOT NULL,
    began_us INTEGER NOT NULL,
    shard    INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (fleet, shard, epoch)
);
INSERT INTO epochs_new (fleet, epoch, owner, holder, began_us) SELECT fleet, epoch, owner, holder, began_us FROM epochs;
DROP TABLE epochs;
ALTER TABLE epochs_new RENAME TO epochs;

-- Events since the checkpoints, by shard.
CREATE TABLE journal_new (
    fleet   TEXT    NOT NULL,
    number  INTEGER NOT NULL,
    entries BLOB    NOT NULL,
    shard   INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (fleet, shard, number)
);
INSERT INTO journal_new (fleet, number, entries) SELECT fleet, number, entries FROM journal;
DROP TABLE journal;
ALTER TABLE journal_new RENAME TO journal;

-- The intent log, by shard.
CREATE TABLE redo_new (
    fleet  TEXT    NOT NULL,
    number INTEGER NOT NULL,
    rows   BLOB    NOT NULL,
    shard  INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (fleet, shard, number)
);
INSERT INTO redo_new (fleet, number, rows) SELECT fleet, number, rows FROM redo;
DROP TABLE redo;
ALTER TABLE redo_new RENAME TO redo;

-- Hash of the robot's name, whose remainder by `shards` is its shard. NULL in rows from before this column, in fleets with
-- one shard.
ALTER TABLE robots ADD COLUMN shard_hash INTEGER;

-- An action on a whole fleet is executed by its first shard. The others execute actions of their own, with the first one's as
-- `parent_id`, as soon as that is DONE; `shard` is their shard, and NULL in all other actions.
ALTER TABLE actions ADD COLUMN shard INTEGER;
