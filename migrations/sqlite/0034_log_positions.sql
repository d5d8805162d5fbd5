-- Positions in a partitioned log that robots' contacts come from.

-- `log_next` is the first record of the shard's partition whose effects are not committed; it changes with each transaction.
-- NULL before the first. `log_topic` is the topic that it belongs to.
ALTER TABLE leases ADD COLUMN log_next INTEGER;
ALTER TABLE leases ADD COLUMN log_topic TEXT;
