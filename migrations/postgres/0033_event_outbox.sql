-- Events that are published to a partitioned log.

-- The outbox: one row for each transaction with events, written in that transaction. `epoch` is that of the lease, `number` the
-- number of the transaction under it: both rise, so that (shard, epoch, number, index in `events`) names an event for good.
-- `events` are serialized. A row is deleted after the log has acknowledged all its events.
CREATE TABLE event_outbox (
    fleet  TEXT   NOT NULL,
    shard  BIGINT NOT NULL,
    epoch  BIGINT NOT NULL,
    number BIGINT NOT NULL,
    events BYTEA  NOT NULL,
    PRIMARY KEY (fleet, shard, epoch, number)
);

-- A row does not last.
ALTER TABLE event_outbox SET (
    autovacuum_vacuum_scale_factor = 0, autovacuum_vacuum_threshold = 2000,
    toast.autovacuum_vacuum_scale_factor = 0, toast.autovacuum_vacuum_threshold = 20000
);
