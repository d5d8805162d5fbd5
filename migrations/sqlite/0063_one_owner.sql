-- A fleet has one owner: one lease, one journal, one outbox. Until now it could have several shards, each with its own.

-- Number of shards of the fleets that have several.
CREATE TABLE divided AS SELECT fleet, max(shards) AS shards FROM leases GROUP BY fleet HAVING count(*) > 1;

-- The lease of a fleet. Robots refuse setpoints of an epoch below the highest that they know, so a divided fleet goes on above the
-- highest of its shards.
CREATE TABLE leases_new (
    fleet      TEXT    NOT NULL PRIMARY KEY,
    epoch      INTEGER NOT NULL,
    owner      TEXT,
    holder     TEXT,
    commits    INTEGER NOT NULL DEFAULT 0,
    expires_us INTEGER
);
INSERT INTO leases_new (fleet, epoch, owner, holder, commits, expires_us)
    SELECT fleet, epoch, owner, holder, commits, expires_us FROM leases WHERE shard = 0;
UPDATE leases_new SET epoch = (SELECT max(epoch) FROM leases l WHERE l.fleet = leases_new.fleet),
    owner = NULL, holder = NULL, commits = 0, expires_us = 0 WHERE fleet IN (SELECT fleet FROM divided);
DROP TABLE leases;
ALTER TABLE leases_new RENAME TO leases;

-- Every epoch that there was, and whose it was.
CREATE TABLE epochs_new (
    fleet    TEXT    NOT NULL,
    epoch    INTEGER NOT NULL,
    owner    TEXT    NOT NULL,
    holder   TEXT    NOT NULL,
    began_us INTEGER NOT NULL,
    PRIMARY KEY (fleet, epoch)
);
INSERT INTO epochs_new (fleet, epoch, owner, holder, began_us)
    SELECT fleet, epoch, owner, holder, began_us FROM (SELECT fleet, epoch, owner, holder, began_us,
        row_number() OVER (PARTITION BY fleet, epoch ORDER BY began_us, shard) AS place FROM epochs) WHERE place = 1;
DROP TABLE epochs;
ALTER TABLE epochs_new RENAME TO epochs;

-- Events since the checkpoints. The numbers of a shard's transactions become those of the fleet, in their order: times the number
-- of shards, plus the shard. The same holds for the last number that a robot's checkpoint contains; each robot is in one shard. A
-- shard had the Kafka partition of its number, so `log_partition` is the one to which ranges without their own partition refer.
CREATE TABLE journal_new (
    fleet         TEXT    NOT NULL,
    number        INTEGER NOT NULL,
    entries       BLOB    NOT NULL,
    log_partition INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (fleet, number)
);
INSERT INTO journal_new (fleet, number, entries, log_partition)
    SELECT fleet, number * coalesce(shards, 1) + shard, entries, shard FROM journal LEFT JOIN divided USING (fleet);
DROP TABLE journal;
ALTER TABLE journal_new RENAME TO journal;
UPDATE robots SET journal_number = journal_number * d.shards + coalesce(shard_hash, 0) % d.shards
    FROM divided d WHERE d.fleet = robots.fleet;
ALTER TABLE robots DROP COLUMN shard_hash;

-- Events that wait for Kafka. There may be rows of more shards than the fleet had at the end.
CREATE TABLE event_outbox_new (
    fleet  TEXT    NOT NULL,
    epoch  INTEGER NOT NULL,
    number INTEGER NOT NULL,
    events BLOB    NOT NULL,
    PRIMARY KEY (fleet, epoch, number)
);
INSERT INTO event_outbox_new (fleet, epoch, number, events)
    SELECT fleet, epoch, number * shards + shard, events FROM event_outbox
    JOIN (SELECT fleet, max(shard) + 1 AS shards FROM event_outbox GROUP BY fleet) USING (fleet);
DROP TABLE event_outbox;
ALTER TABLE event_outbox_new RENAME TO event_outbox;

-- All contacts of a fleet that will still be written have a `received_us` of at least `written_to_us`: the owner ensures it. Of
-- several shards the lowest one holds; former shards beyond the number of shards do not count.
CREATE TABLE archive_horizons_new (
    fleet         TEXT    NOT NULL PRIMARY KEY,
    written_to_us INTEGER NOT NULL
);
INSERT INTO archive_horizons_new (fleet, written_to_us)
    SELECT fleet, min(written_to_us) FROM archive_horizons LEFT JOIN divided USING (fleet)
    WHERE shard < coalesce(shards, 1) GROUP BY fleet;
DROP TABLE archive_horizons;
ALTER TABLE archive_horizons_new RENAME TO archive_horizons;

DROP TABLE divided;

-- Shards repeated an action on the whole fleet. The owner puts the fleet's policy, and the stage of its roll-out, in force for all
-- robots when it takes the fleet up, and executes a pending action for all of them: these repetitions end. That of an executed
-- calibration makes whiskers relearn their baselines: one for each stays pending, as an action on the fleet. The column stays,
-- because the audit log keeps what it has.
UPDATE actions SET state = 'REFUSED', done_us = CAST(strftime('%s', 'now') AS INTEGER) * 1000000,
    problem = 'ONE_OWNER: the fleet has one owner now, which does this for all its robots'
    WHERE state = 'PENDING' AND shard IS NOT NULL AND NOT (
        kind = 'CALIBRATION'
        AND EXISTS (SELECT 1 FROM actions p WHERE p.action_id = actions.parent_id AND p.state = 'DONE')
        AND NOT EXISTS (SELECT 1 FROM actions o WHERE o.parent_id = actions.parent_id AND o.state = 'PENDING'
            AND o.shard IS NOT NULL AND o.action_id < actions.action_id)
    );
