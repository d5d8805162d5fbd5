-- Who owns a fleet. Leases run by this database's clock, which is the only one that all supervisors share.

-- The database's clock now, not that of the transaction's begin: microseconds since 1970 UTC.
CREATE FUNCTION clock_us() RETURNS BIGINT LANGUAGE SQL VOLATILE
    AS 'SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::BIGINT';

-- One row for each fleet, free from `expires_us` on. Every transaction of its owner begins by counting `commits`
-- up and moving `expires_us` on: if the row is not the owner's any more, nothing is written; if the count is there
-- already, the transaction was committed before although its answer was lost. `epoch` rises at each change of
-- owner and orders setpoints: robots refuse lower ones. `owner` names one start of one supervisor, `holder` the
-- same for people.
CREATE TABLE leases (
    fleet      TEXT   PRIMARY KEY,
    epoch      BIGINT NOT NULL,
    owner      TEXT,
    holder     TEXT,
    commits    BIGINT NOT NULL DEFAULT 0,
    expires_us BIGINT
) WITH (fillfactor = 10);

-- Every epoch that there was, and whose it was.
CREATE TABLE epochs (
    fleet    TEXT   NOT NULL,
    epoch    BIGINT NOT NULL,
    owner    TEXT   NOT NULL,
    holder   TEXT   NOT NULL,
    began_us BIGINT NOT NULL,
    PRIMARY KEY (fleet, epoch)
);

-- Epochs were counted over the whole database before.
INSERT INTO epochs (fleet, epoch, owner, holder, began_us)
SELECT fleet, epoch, s.boot_id, '', started_us FROM supervisors s CROSS JOIN (SELECT DISTINCT fleet FROM robots) f;
INSERT INTO leases (fleet, epoch, expires_us) SELECT fleet, max(epoch), 0 FROM epochs GROUP BY fleet;
DROP TABLE supervisors;

-- Supervisors that are there now: until `alive_us` by this database's clock. `fleets` are those that it may own,
-- separated by commas.
CREATE TABLE supervisors (
    supervisor TEXT   PRIMARY KEY,
    holder     TEXT   NOT NULL,
    fleets     TEXT   NOT NULL,
    alive_us   BIGINT NOT NULL
) WITH (fillfactor = 50);

-- Rows that are written again with nearly every commit: room beside each keeps its indices out of it.
ALTER TABLE robots SET (fillfactor = 50);
ALTER TABLE whiskers SET (fillfactor = 50);
