-- Events that are published to a partitioned log.

-- The outbox: one row for each transaction with events, written in that transaction. `epoch` is that of the lease, `number` the
-- number of the transaction under it: both rise, so that (shard, epoch, number, index in `events`) names an event for good.
-- `events` are serialized. A row is deleted after the log has acknowledged all its events.
CREATE TABLE event_outbox (
    fleet  TEXT    NOT NULL,
    shard  INTEGER NOT NULL,
    epoch  INTEGER NOT NULL,
    number INTEGER NOT NULL,
    events BLOB    NOT NULL,
    PRIMARY KEY (fleet, shard, epoch, number)
);
