-- A fleet has one owner: one lease, one journal, one outbox. Until now it could have several shards, each with its own.

-- Number of shards of the fleets that have several.
CREATE TABLE divided AS SELECT fleet, max(shards) AS shards FROM leases GROUP BY fleet HAVING count(*) > 1;

-- Robots refuse setpoints of an epoch below the highest that they know, so the fleet goes on above the highest of its shards.
UPDATE leases l SET epoch = m.epoch, owner = NULL, holder = NULL, commits = 0, expires_us = 0
    FROM (SELECT fleet, max(epoch) AS epoch FROM leases GROUP BY fleet) m JOIN divided d USING (fleet) WHERE m.fleet = l.fleet;
DELETE FROM leases WHERE shard > 0;
ALTER TABLE leases DROP COLUMN shard, DROP COLUMN shards, DROP COLUMN shards_wanted;
ALTER TABLE leases ADD PRIMARY KEY (fleet);

DELETE FROM epochs e USING epochs o
    WHERE o.fleet = e.fleet AND o.epoch = e.epoch AND (o.began_us, o.shard) < (e.began_us, e.shard);
ALTER TABLE epochs DROP COLUMN shard;
ALTER TABLE epochs ADD PRIMARY KEY (fleet, epoch);

-- The numbers of a shard's transactions become those of the fleet, in their order: times the number of shards, plus the shard. The
-- same holds for the last number that a robot's checkpoint contains; each robot is in one shard. A shard had the Kafka partition
-- of its number, so `log_partition` is the one to which ranges without their own partition refer.
ALTER TABLE journal DROP CONSTRAINT journal_pkey;
UPDATE journal j SET number = j.number * d.shards + j.shard FROM divided d WHERE d.fleet = j.fleet;
ALTER TABLE journal RENAME COLUMN shard TO log_partition;
ALTER TABLE journal ADD PRIMARY KEY (fleet, number);
UPDATE robots r SET journal_number = r.journal_number * d.shards + coalesce(r.shard_hash, 0) % d.shards
    FROM divided d WHERE d.fleet = r.fleet;
ALTER TABLE robots DROP COLUMN shard_hash;

-- The outbox may have rows of more shards than the fleet had at the end.
ALTER TABLE event_outbox DROP CONSTRAINT event_outbox_pkey;
UPDATE event_outbox o SET number = o.number * m.shards + o.shard
    FROM (SELECT fleet, max(shard) + 1 AS shards FROM event_outbox GROUP BY fleet) m WHERE m.fleet = o.fleet;
ALTER TABLE event_outbox DROP COLUMN shard;
ALTER TABLE event_outbox ADD PRIMARY KEY (fleet, epoch, number);

-- Horizons of former shards beyond the number of shards do not count. The lowest one holds for the fleet.
DELETE FROM archive_horizons h WHERE shard >= coalesce((SELECT shards FROM divided d WHERE d.fleet = h.fleet), 1);
UPDATE archive_horizons h SET written_to_us = m.written_to_us
    FROM (SELECT fleet, min(written_to_us) AS written_to_us FROM archive_horizons GROUP BY fleet) m WHERE m.fleet = h.fleet;
DELETE FROM archive_horizons h USING archive_horizons o WHERE o.fleet = h.fleet AND o.shard < h.shard;
ALTER TABLE archive_horizons DROP COLUMN shard;
ALTER TABLE archive_horizons ADD PRIMARY KEY (fleet);

DROP TABLE divided;

-- Shards repeated an action on the whole fleet. The owner puts the fleet's policy, and the stage of its roll-out, in force for all
-- robots when it takes the fleet up, and executes a pending action for all of them: these repetitions end. That of an executed
-- calibration makes whiskers relearn their baselines: one for each stays pending, as an action on the fleet. The column stays,
-- because the audit log keeps what it has.
UPDATE actions a SET state = 'REFUSED', done_us = clock_us(),
    problem = 'ONE_OWNER: the fleet has one owner now, which does this for all its robots'
    WHERE state = 'PENDING' AND shard IS NOT NULL AND NOT (
        kind = 'CALIBRATION'
        AND EXISTS (SELECT FROM actions p WHERE p.action_id = a.parent_id AND p.state = 'DONE')
        AND NOT EXISTS (SELECT FROM actions o WHERE o.parent_id = a.parent_id AND o.state = 'PENDING'
            AND o.shard IS NOT NULL AND o.action_id < a.action_id)
    );
