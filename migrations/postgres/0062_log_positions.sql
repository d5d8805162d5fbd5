-- A fleet reads all partitions of its topic. Until now each shard of a fleet read the partition of its number.

-- The first record of a partition whose effects are not committed, by the fleet that reads it. It changes in the
-- transaction of the effects. A partition without a row is read from its first record.
CREATE TABLE log_positions (
    fleet         TEXT   NOT NULL,
    topic         TEXT   NOT NULL,
    log_partition BIGINT NOT NULL,
    next          BIGINT NOT NULL,
    PRIMARY KEY (fleet, topic, log_partition)
);
INSERT INTO log_positions (fleet, topic, log_partition, next)
SELECT fleet, log_topic, shard, log_next FROM leases WHERE log_topic IS NOT NULL AND log_next IS NOT NULL;
ALTER TABLE leases DROP COLUMN log_next, DROP COLUMN log_topic;
