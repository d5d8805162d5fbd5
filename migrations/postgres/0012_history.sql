-- What whiskers felt over time: contacts in a table for each day, and what they add up to for each minute and hour.

-- Contacts that were received on one day (UTC, by the supervisor's clock) are a partition of `contacts`, which is made
-- ahead and dropped as a whole once it is too old: contacts_20261121 has those of that day. Rows are written by `COPY` and
-- have neither a number of their own nor a unique index: (boot, seq, position) names a contact, and the state of its robot,
-- written in the same transaction, keeps duplicates out. A day that is over gets an index by whisker and time; today's has
-- one that tells which pages a time is in (BRIN), which costs next to nothing to write.
ALTER TABLE contacts RENAME TO contacts_before;
ALTER TABLE contacts_before DROP COLUMN contact_id;
-- As above.
CREATE TABLE contacts (LIKE contacts_before) PARTITION BY RANGE (received_us);

-- Contacts of before stay where they are, as the partition of all time until the end of this day, or of the newest
-- contact's if a clock was ahead. Nothing is written anew, but all of it is read to find that out.
DO $$
DECLARE
    newest_us BIGINT := (SELECT max(received_us) FROM contacts_before);
    end_us    BIGINT := (greatest(newest_us, clock_us()) / 86400000000 + 1) * 86400000000;
BEGIN
    IF newest_us IS NULL THEN
        DROP TABLE contacts_before;
    ELSE
        EXECUTE format('ALTER TABLE contacts ATTACH PARTITION contacts_before FOR VALUES FROM (MINVALUE) TO (%s)', end_us);
    END IF;
END $$;

-- Contacts of a day that nobody has made a partition for, so that no commit ever fails for it.
CREATE TABLE contacts_default PARTITION OF contacts DEFAULT;
CREATE INDEX contacts_default_of_whisker ON contacts_default (whisker_id, t_us);

-- What a whisker felt in a minute, written once when it is over. `start_us` is its begin; `contacts_used`, `_learning` and
-- `_unused` count its contacts by what they were used for. Over those used or learned from: mean, standard deviation, least
-- and greatest ln(measured / predicted sensitivity) (`residual_*`), mean strain by deflection, and mean contact ratio, which
-- that depends on. Over all contacts: estimated length and its standard deviation after the last one, mean length, pressure
-- and temperature. `compensation_error` is the error (Eq. 35) that was stated last of a compensation for this whisker.
-- What there was no contact for is NULL.
CREATE TABLE contact_minutes (
    whisker_id         BIGINT  NOT NULL,
    start_us           BIGINT  NOT NULL,
    contacts_used      INTEGER NOT NULL,
    contacts_learning  INTEGER NOT NULL,
    contacts_unused    INTEGER NOT NULL,
    residual_mean      REAL,
    residual_sd        REAL,
    residual_min       REAL,
    residual_max       REAL,
    sensitivity_per_mm REAL,
    ratio              REAL,
    length_mm          REAL,
    length_sd_mm       REAL,
    length_mean_mm     REAL,
    pressure_mpa       REAL,
    temperature_c      REAL,
    compensation_error REAL,
    PRIMARY KEY (whisker_id, start_us)
) PARTITION BY RANGE (start_us);

-- Minutes that nobody has made a partition for: their partitions are of 30 days.
CREATE TABLE contact_minutes_default PARTITION OF contact_minutes DEFAULT;

-- The same for each hour, kept for ever.
CREATE TABLE contact_hours (LIKE contact_minutes INCLUDING INDEXES);

-- The minute and the hour of a whisker that are not over yet, as bytes; NULL before its first contact. It is written with the
-- whisker's state, and stays when the whisker leaves the robot, so that no minute or hour is written twice.
ALTER TABLE whiskers ADD COLUMN rollup BYTEA;
