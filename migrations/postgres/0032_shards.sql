-- Shards: the parts of a fleet that different supervisors can own. Most fleets have one.

-- `shard` is the number of the part, from 0. `shards` is the number of the fleet's shards, the same in all its rows;
-- `shards_wanted` is the number that it shall get. It changes when all shards are without an owner and the journal is empty.
ALTER TABLE leases
    ADD COLUMN shard         BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN shards        BIGINT NOT NULL DEFAULT 1,
    ADD COLUMN shards_wanted BIGINT NOT NULL DEFAULT 1;
ALTER TABLE leases DROP CONSTRAINT leases_pkey;
ALTER TABLE leases ADD PRIMARY KEY (fleet, shard);

ALTER TABLE epochs ADD COLUMN shard BIGINT NOT NULL DEFAULT 0;
ALTER TABLE epochs DROP CONSTRAINT epochs_pkey;
ALTER TABLE epochs ADD PRIMARY KEY (fleet, shard, epoch);

ALTER TABLE journal ADD COLUMN shard BIGINT NOT NULL DEFAULT 0;
ALTER TABLE journal DROP CONSTRAINT journal_pkey;
ALTER TABLE journal ADD PRIMARY KEY (fleet, shard, number);

ALTER TABLE redo ADD COLUMN shard BIGINT NOT NULL DEFAULT 0;
ALTER TABLE redo DROP CONSTRAINT redo_pkey;
ALTER TABLE redo ADD PRIMARY KEY (fleet, shard, number);

-- Hash of the robot's name, whose remainder by `shards` is its shard. NULL in rows from before this column, in fleets with
-- one shard.
ALTER TABLE robots ADD COLUMN shard_hash BIGINT;

-- An action on a whole fleet is executed by its first shard. The others execute actions of their own, with the first one's as
-- `parent_id`, as soon as that is DONE; `shard` is their shard, and NULL in all other actions.
ALTER TABLE actions ADD COLUMN shard BIGINT;
