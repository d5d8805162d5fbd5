-- The closed loop: how sure a prediction is, what a gain leaves of the error, and every look at a setpoint.

-- The 95 % interval of `predicted_error`: what is not known of the chamber's calibration (10 %, and which
-- formulation holds), of the whiskers' offsets and of the compensator's length. NULL in rows of before.
ALTER TABLE compensations ADD COLUMN predicted_error_low DOUBLE PRECISION;
ALTER TABLE compensations ADD COLUMN predicted_error_high DOUBLE PRECISION;
ALTER TABLE compensation_candidates ADD COLUMN predicted_error_low DOUBLE PRECISION;
ALTER TABLE compensation_candidates ADD COLUMN predicted_error_high DOUBLE PRECISION;

-- The pressure that the error is measured at; and the error with the gain in force applied to the compensator's
-- strain, over all contact ratios, from contacts since that gain was published, with a 95 % interval. NULL while
-- these contacts are too few, and in rows of before.
ALTER TABLE compensation_errors ADD COLUMN pressure_mpa DOUBLE PRECISION;
ALTER TABLE compensation_errors ADD COLUMN error_with_gain DOUBLE PRECISION;
ALTER TABLE compensation_errors ADD COLUMN error_with_gain_low DOUBLE PRECISION;
ALTER TABLE compensation_errors ADD COLUMN error_with_gain_high DOUBLE PRECISION;

-- Every look at the setpoint of a compensation, with what came of it: REFINED, or why the pressure stays
-- (HELD_DITHER, HELD_MARGIN, HELD_UNCERTAIN, HELD_STEPS, HELD_UNPREDICTABLE). `contacts` counts at
-- `pressure_from_mpa`; `pressure_best_mpa` is the best pressure by what was felt, and where the setpoint moves if
-- REFINED. `error` is the mean of Eq. 35 as felt, through smoothed responses, `error_best` what is expected at the
-- best pressure, each with a 95 % interval; `error_with_gain` what the published gain leaves and
-- `error_with_own_gain` what a gain from these contacts would. `gain_published`: whether a new gain went out.
CREATE TABLE compensation_refinements (
    compensation_refinement_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    compensation_id            BIGINT           NOT NULL REFERENCES compensations,
    recorded_us                BIGINT           NOT NULL,
    contacts                   BIGINT           NOT NULL,
    outcome                    TEXT             NOT NULL,
    pressure_from_mpa          DOUBLE PRECISION NOT NULL,
    pressure_best_mpa          DOUBLE PRECISION,
    error                      DOUBLE PRECISION NOT NULL,
    error_low                  DOUBLE PRECISION NOT NULL,
    error_high                 DOUBLE PRECISION NOT NULL,
    error_best                 DOUBLE PRECISION,
    error_best_low             DOUBLE PRECISION,
    error_best_high            DOUBLE PRECISION,
    error_with_gain            DOUBLE PRECISION NOT NULL,
    error_with_own_gain        DOUBLE PRECISION NOT NULL,
    gain_published             BOOLEAN          NOT NULL
);
CREATE INDEX compensation_refinements_of ON compensation_refinements (compensation_id, recorded_us);
