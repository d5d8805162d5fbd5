-- The closed loop: how sure a prediction is, what a gain leaves of the error, and every look at a setpoint.

-- The 95 % interval of `predicted_error`: what is not known of the chamber's calibration (10 %, and which
-- formulation holds), of the whiskers' offsets and of the compensator's length. NULL in rows of before.
ALTER TABLE compensations ADD COLUMN predicted_error_low REAL;
ALTER TABLE compensations ADD COLUMN predicted_error_high REAL;
ALTER TABLE compensation_candidates ADD COLUMN predicted_error_low REAL;
ALTER TABLE compensation_candidates ADD COLUMN predicted_error_high REAL;

-- The pressure that the error is measured at; and the error with the gain in force applied to the compensator's
-- strain, over all contact ratios, from contacts since that gain was published, with a 95 % interval. NULL while
-- these contacts are too few, and in rows of before.
ALTER TABLE compensation_errors ADD COLUMN pressure_mpa REAL;
ALTER TABLE compensation_errors ADD COLUMN error_with_gain REAL;
ALTER TABLE compensation_errors ADD COLUMN error_with_gain_low REAL;
ALTER TABLE compensation_errors ADD COLUMN error_with_gain_high REAL;

-- Every look at the setpoint of a compensation, with what came of it: REFINED, or why the pressure stays
-- (HELD_DITHER, HELD_MARGIN, HELD_UNCERTAIN, HELD_STEPS, HELD_UNPREDICTABLE). `contacts` counts at
-- `pressure_from_mpa`; `pressure_best_mpa` is the best pressure by what was felt, and where the setpoint moves if
-- REFINED. `error` is the mean of Eq. 35 as felt, through smoothed responses, `error_best` what is expected at the
-- best pressure, each with a 95 % interval; `error_with_gain` what the published gain leaves and
-- `error_with_own_gain` what a gain from these contacts would. `gain_published`: whether a new gain went out.
CREATE TABLE compensation_refinements (
    compensation_refinement_id INTEGER PRIMARY KEY,
    compensation_id            INTEGER NOT NULL REFERENCES compensations,
    recorded_us                INTEGER NOT NULL,
    contacts                   INTEGER NOT NULL,
    outcome                    TEXT    NOT NULL,
    pressure_from_mpa          REAL    NOT NULL,
    pressure_best_mpa          REAL,
    error                      REAL    NOT NULL,
    error_low                  REAL    NOT NULL,
    error_high                 REAL    NOT NULL,
    error_best                 REAL,
    error_best_low             REAL,
    error_best_high            REAL,
    error_with_gain            REAL    NOT NULL,
    error_with_own_gain        REAL    NOT NULL,
    gain_published             INTEGER NOT NULL
);
CREATE INDEX compensation_refinements_of ON compensation_refinements (compensation_id, recorded_us);
