-- What supervisors know and did. Lengths in mm, pressures in MPa, strain in m/m, errors as ratios;
-- times are microseconds since 1970 UTC (_us), by the supervisor's clock unless the comment says the robot's:
-- to_timestamp(t_us / 1e6) makes a time of one.

-- One row for each start of a supervisor. The epoch orders setpoints across restarts: robots refuse lower ones.
CREATE TABLE supervisors (
    epoch      BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    boot_id    TEXT   NOT NULL,
    started_us BIGINT NOT NULL
);

-- A robot, with the bytes of its state in the core (all but its whiskers). The state is written in the same
-- transaction as the contacts it rests on, so a restart goes on exactly where the last commit was.
CREATE TABLE robots (
    robot_id   BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    fleet      TEXT   NOT NULL,
    robot      TEXT   NOT NULL,
    boot_id    TEXT,
    connection TEXT   NOT NULL DEFAULT 'OFFLINE' CHECK (connection IN ('ONLINE', 'OFFLINE', 'CONNECTION_BROKEN')),
    model      TEXT,
    updated_us BIGINT NOT NULL DEFAULT 0,
    state      BYTEA,
    UNIQUE (fleet, robot)
);

-- An array, from the newest factsheet.
CREATE TABLE arrays (
    array_id   BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    robot_id   BIGINT NOT NULL REFERENCES robots,
    "array"    TEXT   NOT NULL,
    array_type TEXT   NOT NULL CHECK (array_type IN ('TYPE_1', 'TYPE_2')),
    UNIQUE (robot_id, "array")
);

-- A whisker: what the factsheet says, what is estimated, and the bytes of its state in the core.
-- `position` is its index in the robot's state; NULL for a whisker that the newest factsheet does not have.
CREATE TABLE whiskers (
    whisker_id           BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    array_id             BIGINT           NOT NULL REFERENCES arrays,
    robot_id             BIGINT           NOT NULL REFERENCES robots,
    whisker              BIGINT           NOT NULL,
    position             BIGINT,
    x_mm                 DOUBLE PRECISION NOT NULL,
    y_mm                 DOUBLE PRECISION NOT NULL,
    model                TEXT             NOT NULL,
    whole_length_mm      DOUBLE PRECISION NOT NULL,
    nominal_pressure_mpa DOUBLE PRECISION NOT NULL,
    pressure_max_mpa     DOUBLE PRECISION NOT NULL,
    length_mm            DOUBLE PRECISION NOT NULL,
    length_sd_mm         DOUBLE PRECISION NOT NULL,
    condition            TEXT             NOT NULL,
    fault                TEXT,
    pressure_mpa         DOUBLE PRECISION,
    setpoint_mpa         DOUBLE PRECISION NOT NULL,
    contacts             BIGINT           NOT NULL DEFAULT 0,
    heard_us             BIGINT,
    state                BYTEA,
    UNIQUE (array_id, whisker)
);
CREATE INDEX whiskers_of_robot ON whiskers (robot_id, position);

-- A boot of a robot, so that contacts need not repeat its text.
CREATE TABLE boots (
    boot          BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    robot_id      BIGINT NOT NULL REFERENCES robots,
    boot_id       TEXT   NOT NULL,
    first_seen_us BIGINT NOT NULL,
    UNIQUE (robot_id, boot_id)
);

-- Every contact, once. (boot, seq, position) names it; the sequence state of the robot, written in the same
-- transaction, keeps duplicates out, so no unique index is paid for, nor foreign keys: its only writer takes the
-- numbers from those tables. `t_us` is the robot's clock;
-- `residual` is ln(measured / predicted sensitivity), NULL where the contact was not used, as `used` says.
CREATE TABLE contacts (
    contact_id    BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    whisker_id    BIGINT           NOT NULL,
    boot          BIGINT           NOT NULL,
    seq           BIGINT           NOT NULL,
    position      BIGINT           NOT NULL,
    t_us          BIGINT           NOT NULL,
    received_us   BIGINT           NOT NULL,
    ratio         DOUBLE PRECISION NOT NULL,
    deflection_mm DOUBLE PRECISION NOT NULL,
    strain        DOUBLE PRECISION NOT NULL,
    pressure_mpa  DOUBLE PRECISION NOT NULL,
    temperature_c DOUBLE PRECISION,
    used          TEXT             NOT NULL,
    residual      DOUBLE PRECISION,
    length_mm     DOUBLE PRECISION NOT NULL,
    length_sd_mm  DOUBLE PRECISION NOT NULL
);
CREATE INDEX contacts_of_whisker ON contacts (whisker_id, t_us);

-- A trim that was found. `contacts_to_detect` counts from the likeliest moment of the cut to the decision.
CREATE TABLE trims (
    trim_id            BIGINT           PRIMARY KEY,
    robot_id           BIGINT           NOT NULL REFERENCES robots,
    whisker_id         BIGINT           NOT NULL REFERENCES whiskers,
    detected_us        BIGINT           NOT NULL,
    length_before_mm   DOUBLE PRECISION NOT NULL,
    length_after_mm    DOUBLE PRECISION NOT NULL,
    length_after_sd_mm DOUBLE PRECISION NOT NULL,
    contacts_to_detect BIGINT           NOT NULL
);
CREATE INDEX trims_of_whisker ON trims (whisker_id, detected_us);

-- A decision about a broken whisker, and the compensation that follows if somebody can serve.
-- `compensation_case`, `compensator_whisker_id` and `pressure_mpa` are NULL where no one can.
CREATE TABLE compensations (
    compensation_id        BIGINT           PRIMARY KEY,
    robot_id               BIGINT           NOT NULL REFERENCES robots,
    target_whisker_id      BIGINT           NOT NULL REFERENCES whiskers,
    target_length_mm       DOUBLE PRECISION NOT NULL,
    target_pressure_mpa    DOUBLE PRECISION NOT NULL,
    compensator_whisker_id BIGINT           REFERENCES whiskers,
    compensation_case      TEXT             CHECK (compensation_case IN ('SELF_COMPENSATION', 'SHORTER_FOR_LONGER', 'LONGER_FOR_SHORTER')),
    pressure_before_mpa    DOUBLE PRECISION,
    pressure_mpa           DOUBLE PRECISION,
    predicted_error        DOUBLE PRECISION,
    decided_us             BIGINT           NOT NULL,
    ended_us               BIGINT,
    end_reason             TEXT
);
CREATE INDEX compensations_of_target ON compensations (target_whisker_id, decided_us);

-- Everyone who was asked: the pressure and error that Eq. 34 and 35 predict, or why it was not chosen.
-- `predicted_error_by_ratio` is a JSON array over the contact ratios 0.45, 0.50 .. 1.00.
CREATE TABLE compensation_candidates (
    compensation_id          BIGINT           NOT NULL REFERENCES compensations,
    ordinal                  BIGINT           NOT NULL,
    whisker_id               BIGINT           NOT NULL REFERENCES whiskers,
    compensation_case        TEXT             NOT NULL,
    length_mm                DOUBLE PRECISION NOT NULL,
    length_sd_mm             DOUBLE PRECISION NOT NULL,
    pressure_before_mpa      DOUBLE PRECISION NOT NULL,
    pressure_mpa             DOUBLE PRECISION,
    predicted_error          DOUBLE PRECISION,
    predicted_error_by_ratio TEXT,
    gives_up_own_role        BOOLEAN          NOT NULL,
    chosen                   BOOLEAN          NOT NULL,
    refused                  TEXT,
    PRIMARY KEY (compensation_id, ordinal)
);

-- Setpoints: the outbox. A row is written in the transaction of the decision behind it, and published after
-- the commit. `expires_us` is the robot's clock; `gain` a JSON array of [contact ratio, gain].
CREATE TABLE setpoints (
    command_id      TEXT             PRIMARY KEY,
    robot_id        BIGINT           NOT NULL REFERENCES robots,
    whisker_id      BIGINT           NOT NULL REFERENCES whiskers,
    compensation_id BIGINT           REFERENCES compensations,
    epoch           BIGINT           NOT NULL,
    version         BIGINT           NOT NULL,
    robot_boot_id   TEXT             NOT NULL,
    pressure_mpa    DOUBLE PRECISION NOT NULL CHECK (pressure_mpa BETWEEN 0 AND 0.2),
    slew_mpa_per_s  DOUBLE PRECISION NOT NULL,
    issued_us       BIGINT           NOT NULL,
    expires_us      BIGINT           NOT NULL,
    reason          TEXT             NOT NULL,
    gain            TEXT,
    state           TEXT             NOT NULL,
    error           TEXT,
    reached_mpa     DOUBLE PRECISION,
    UNIQUE (robot_id, epoch, version)
);
CREATE INDEX setpoints_of_whisker ON setpoints (whisker_id, issued_us);

-- The history of each setpoint.
CREATE TABLE setpoint_states (
    setpoint_state_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    command_id        TEXT             NOT NULL REFERENCES setpoints,
    recorded_us       BIGINT           NOT NULL,
    state             TEXT             NOT NULL,
    error             TEXT,
    pressure_mpa      DOUBLE PRECISION
);
CREATE INDEX setpoint_states_of_setpoint ON setpoint_states (command_id);

-- The three responses of Eq. 35 at each contact of a compensator, at the same contact ratio and deflection.
-- `after_strain` is measured; an origin says whether the other was averaged from contacts or is the model's.
CREATE TABLE compensation_responses (
    compensation_id BIGINT           NOT NULL REFERENCES compensations,
    t_us            BIGINT           NOT NULL,
    ratio           DOUBLE PRECISION NOT NULL,
    deflection_mm   DOUBLE PRECISION NOT NULL,
    after_strain    DOUBLE PRECISION NOT NULL,
    before_strain   DOUBLE PRECISION NOT NULL,
    before_origin   TEXT             NOT NULL,
    target_strain   DOUBLE PRECISION NOT NULL,
    target_origin   TEXT             NOT NULL
);
CREATE INDEX compensation_responses_of ON compensation_responses (compensation_id, t_us);

-- The measured compensation error, stated anew as contacts come in: the mean of Eq. 35 over contact-ratio
-- bins, as a ratio, with a 95 % interval.
CREATE TABLE compensation_errors (
    compensation_error_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    compensation_id       BIGINT           NOT NULL REFERENCES compensations,
    recorded_us           BIGINT           NOT NULL,
    contacts              BIGINT           NOT NULL,
    bins                  BIGINT           NOT NULL,
    error                 DOUBLE PRECISION NOT NULL,
    error_low             DOUBLE PRECISION NOT NULL,
    error_high            DOUBLE PRECISION NOT NULL
);
CREATE INDEX compensation_errors_of ON compensation_errors (compensation_id, recorded_us);

-- Its bins: sensitivities in strain per mm of deflection.
CREATE TABLE compensation_error_bins (
    compensation_error_id BIGINT           NOT NULL REFERENCES compensation_errors,
    ratio                 DOUBLE PRECISION NOT NULL,
    contacts              BIGINT           NOT NULL,
    after_per_mm          DOUBLE PRECISION NOT NULL,
    before_per_mm         DOUBLE PRECISION NOT NULL,
    before_origin         TEXT             NOT NULL,
    target_per_mm         DOUBLE PRECISION NOT NULL,
    target_origin         TEXT             NOT NULL,
    error                 DOUBLE PRECISION NOT NULL,
    error_low             DOUBLE PRECISION NOT NULL,
    error_high            DOUBLE PRECISION NOT NULL,
    PRIMARY KEY (compensation_error_id, ratio)
);

-- Changes of condition (LEARNING, HEALTHY, SUSPECTED, TRIMMED, ERODING, SENSITIVITY_LOSS) and of fault.
CREATE TABLE health_changes (
    health_change_id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    whisker_id       BIGINT NOT NULL REFERENCES whiskers,
    recorded_us      BIGINT NOT NULL,
    kind             TEXT   NOT NULL CHECK (kind IN ('CONDITION', 'FAULT')),
    was              TEXT,
    becomes          TEXT
);
CREATE INDEX health_changes_of_whisker ON health_changes (whisker_id, recorded_us);

-- What people were told.
CREATE TABLE alarms (
    alarm_id   BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    whisker_id BIGINT NOT NULL REFERENCES whiskers,
    raised_us  BIGINT NOT NULL,
    kind       TEXT   NOT NULL
);
CREATE INDEX alarms_of_whisker ON alarms (whisker_id, raised_us);
