-- Calibrations of whisker models that were uploaded as measurements, and which of them are in force.

-- `version` counts from 1 for each model, the name that factsheets use. `measurements` is the JSON that was uploaded,
-- `fit` what came of it (parameters with intervals, residuals), and `calibration` the numbers in force once it is active.
CREATE TABLE calibrations (
    calibration_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    model          TEXT   NOT NULL,
    version        BIGINT NOT NULL,
    measurements   TEXT   NOT NULL,
    fit            TEXT   NOT NULL,
    calibration    TEXT   NOT NULL,
    uploaded_us    BIGINT NOT NULL,
    uploaded_by    TEXT   NOT NULL,
    UNIQUE (model, version)
);

-- The calibration of a model that a fleet works with; without a row it is the configuration's.
CREATE TABLE active_calibrations (
    fleet          TEXT   NOT NULL,
    model          TEXT   NOT NULL,
    calibration_id BIGINT NOT NULL REFERENCES calibrations,
    activated_us   BIGINT NOT NULL,
    activated_by   TEXT   NOT NULL,
    PRIMARY KEY (fleet, model)
);
