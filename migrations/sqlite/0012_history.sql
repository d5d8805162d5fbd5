-- What whiskers felt over time: what contacts add up to for each minute and hour.

-- What a whisker felt in a minute, written once when it is over. `start_us` is its begin; `contacts_used`, `_learning` and
-- `_unused` count its contacts by what they were used for. Over those used or learned from: mean, standard deviation, least
-- and greatest ln(measured / predicted sensitivity) (`residual_*`), mean strain by deflection, and mean contact ratio, which
-- that depends on. Over all contacts: estimated length and its standard deviation after the last one, mean length, pressure
-- and temperature. `compensation_error` is the error (Eq. 35) that was stated last of a compensation for this whisker.
-- What there was no contact for is NULL.
CREATE TABLE contact_minutes (
    whisker_id         INTEGER NOT NULL,
    start_us           INTEGER NOT NULL,
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
) WITHOUT ROWID;
-- The oldest ones are removed.
CREATE INDEX contact_minutes_by_start ON contact_minutes (start_us);

-- The same for each hour, kept for ever.
CREATE TABLE contact_hours (
    whisker_id         INTEGER NOT NULL,
    start_us           INTEGER NOT NULL,
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
) WITHOUT ROWID;

-- The minute and the hour of a whisker that are not over yet, as bytes; NULL before its first contact. It is written with the
-- whisker's state, and stays when the whisker leaves the robot, so that no minute or hour is written twice.
ALTER TABLE whiskers ADD COLUMN rollup BLOB;
