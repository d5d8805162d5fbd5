-- Who owns a fleet. With SQLite that is whoever holds the lock of the file, so `expires_us` stays NULL.

-- One row for each fleet. Every transaction of its owner begins by counting `commits` up: if the row is not the
-- owner's any more, nothing is written; if the count is there already, the transaction was committed before
-- although its answer was lost. `epoch` rises at each change of owner and orders setpoints: robots refuse lower
-- ones. `owner` names one start of one supervisor, `holder` the same for people.
CREATE TABLE leases (
    fleet      TEXT    PRIMARY KEY,
    epoch      INTEGER NOT NULL,
    owner      TEXT,
    holder     TEXT,
    commits    INTEGER NOT NULL DEFAULT 0,
    expires_us INTEGER
);

-- Every epoch that there was, and whose it was.
CREATE TABLE epochs (
    fleet    TEXT    NOT NULL,
    epoch    INTEGER NOT NULL,
    owner    TEXT    NOT NULL,
    holder   TEXT    NOT NULL,
    began_us INTEGER NOT NULL,
    PRIMARY KEY (fleet, epoch)
);

-- Epochs were counted over the whole database before.
INSERT INTO epochs (fleet, epoch, owner, holder, began_us)
SELECT fleet, epoch, s.boot_id, '', started_us FROM supervisors s CROSS JOIN (SELECT DISTINCT fleet FROM robots);
INSERT INTO leases (fleet, epoch) SELECT fleet, max(epoch) FROM epochs GROUP BY fleet;
DROP TABLE supervisors;

-- Supervisors that are there now.
CREATE TABLE supervisors (
    supervisor TEXT    PRIMARY KEY,
    holder     TEXT    NOT NULL,
    fleets     TEXT    NOT NULL,
    alive_us   INTEGER NOT NULL
);
