--
-- PostgreSQL database dump
--


-- Dumped from database version 15.18 (Debian 15.18-0+deb12u1)
-- Dumped by pg_dump version 15.18 (Debian 15.18-0+deb12u1)

SET statement_timeout = 0;
SET lock_timeout = 0;
SET idle_in_transaction_session_timeout = 0;
SET client_encoding = 'UTF8';
SET standard_conforming_strings = on;
SELECT pg_catalog.set_config('search_path', '', false);
SET check_function_bodies = false;
SET xmloption = content;
SET client_min_messages = warning;
SET row_security = off;

--
-- Name: clock_us(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.clock_us() RETURNS bigint
    LANGUAGE sql
    AS $$SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::BIGINT$$;


SET default_tablespace = '';

SET default_table_access_method = heap;

--
-- Name: _sqlx_migrations; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public._sqlx_migrations (
    version bigint NOT NULL,
    description text NOT NULL,
    installed_on timestamp with time zone DEFAULT now() NOT NULL,
    success boolean NOT NULL,
    checksum bytea NOT NULL,
    execution_time bigint NOT NULL
);


--
-- Name: actions; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.actions (
    action_id bigint NOT NULL,
    fleet text,
    robot text,
    "array" text,
    whisker bigint,
    compensation_id bigint,
    alarm_id bigint,
    kind text NOT NULL,
    parameters text NOT NULL,
    reason text,
    actor text NOT NULL,
    role text NOT NULL,
    request_id text NOT NULL,
    idempotency_key text,
    asked_us bigint NOT NULL,
    expires_us bigint NOT NULL,
    state text NOT NULL,
    problem text,
    done_us bigint,
    CONSTRAINT actions_state_check CHECK ((state = ANY (ARRAY['PENDING'::text, 'DONE'::text, 'REFUSED'::text, 'EXPIRED'::text])))
);


--
-- Name: actions_action_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.actions ALTER COLUMN action_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.actions_action_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: active_calibrations; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.active_calibrations (
    fleet text NOT NULL,
    model text NOT NULL,
    calibration_id bigint NOT NULL,
    activated_us bigint NOT NULL,
    activated_by text NOT NULL
);


--
-- Name: alarm_shelves; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.alarm_shelves (
    alarm_shelf_id bigint NOT NULL,
    whisker_id bigint NOT NULL,
    kind text NOT NULL,
    shelved_us bigint NOT NULL,
    until_us bigint NOT NULL,
    shelved_by text NOT NULL,
    reason text NOT NULL
);


--
-- Name: alarm_shelves_alarm_shelf_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.alarm_shelves ALTER COLUMN alarm_shelf_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.alarm_shelves_alarm_shelf_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: alarms; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.alarms (
    alarm_id bigint NOT NULL,
    whisker_id bigint NOT NULL,
    raised_us bigint NOT NULL,
    kind text NOT NULL,
    cleared_us bigint,
    acknowledged_us bigint,
    acknowledged_by text,
    acknowledged_reason text
);


--
-- Name: alarms_alarm_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.alarms ALTER COLUMN alarm_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.alarms_alarm_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: allowed_robots; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.allowed_robots (
    fleet text NOT NULL,
    version bigint NOT NULL,
    robots text,
    changed_us bigint NOT NULL,
    changed_by text NOT NULL,
    reason text,
    action_id bigint NOT NULL
);


--
-- Name: api_tokens; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.api_tokens (
    token_id text NOT NULL,
    name text NOT NULL,
    role text NOT NULL,
    fleets text,
    secret_hash bytea NOT NULL,
    created_us bigint NOT NULL,
    created_by text NOT NULL,
    expires_us bigint NOT NULL,
    revoked_us bigint,
    CONSTRAINT api_tokens_role_check CHECK ((role = ANY (ARRAY['VIEWER'::text, 'OPERATOR'::text, 'ENGINEER'::text, 'ADMIN'::text])))
);


--
-- Name: arrays; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.arrays (
    array_id bigint NOT NULL,
    robot_id bigint NOT NULL,
    "array" text NOT NULL,
    array_type text NOT NULL,
    CONSTRAINT arrays_array_type_check CHECK ((array_type = ANY (ARRAY['TYPE_1'::text, 'TYPE_2'::text])))
);


--
-- Name: arrays_array_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.arrays ALTER COLUMN array_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.arrays_array_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: boots; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.boots (
    boot bigint NOT NULL,
    robot_id bigint NOT NULL,
    boot_id text NOT NULL,
    first_seen_us bigint NOT NULL
);


--
-- Name: boots_boot_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.boots ALTER COLUMN boot ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.boots_boot_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: calibrations; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.calibrations (
    calibration_id bigint NOT NULL,
    model text NOT NULL,
    version bigint NOT NULL,
    measurements text NOT NULL,
    fit text NOT NULL,
    calibration text NOT NULL,
    uploaded_us bigint NOT NULL,
    uploaded_by text NOT NULL
);


--
-- Name: calibrations_calibration_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.calibrations ALTER COLUMN calibration_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.calibrations_calibration_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: changes; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.changes (
    change_id bigint NOT NULL,
    tx bigint DEFAULT ((pg_current_xact_id())::text)::bigint NOT NULL,
    recorded_us bigint NOT NULL,
    fleet text NOT NULL,
    kind text NOT NULL,
    robot_id bigint,
    whisker_id bigint,
    number bigint,
    command_id text,
    CONSTRAINT changes_kind_check CHECK ((kind = ANY (ARRAY['HEALTH'::text, 'TRIM'::text, 'COMPENSATION'::text, 'SETPOINT'::text, 'ERROR'::text, 'ALARM'::text, 'ACTION'::text, 'POLICY'::text])))
);


--
-- Name: changes_change_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.changes ALTER COLUMN change_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.changes_change_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: compensation_candidates; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.compensation_candidates (
    compensation_id bigint NOT NULL,
    ordinal bigint NOT NULL,
    whisker_id bigint NOT NULL,
    compensation_case text NOT NULL,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL,
    pressure_before_mpa double precision NOT NULL,
    pressure_mpa double precision,
    predicted_error double precision,
    predicted_error_by_ratio text,
    gives_up_own_role boolean NOT NULL,
    chosen boolean NOT NULL,
    refused text,
    predicted_error_low double precision,
    predicted_error_high double precision
);


--
-- Name: compensation_error_bins; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.compensation_error_bins (
    compensation_error_id bigint NOT NULL,
    ratio double precision NOT NULL,
    contacts bigint NOT NULL,
    after_per_mm double precision NOT NULL,
    before_per_mm double precision NOT NULL,
    before_origin text NOT NULL,
    target_per_mm double precision NOT NULL,
    target_origin text NOT NULL,
    error double precision NOT NULL,
    error_low double precision NOT NULL,
    error_high double precision NOT NULL
);


--
-- Name: compensation_errors; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.compensation_errors (
    compensation_error_id bigint NOT NULL,
    compensation_id bigint NOT NULL,
    recorded_us bigint NOT NULL,
    contacts bigint NOT NULL,
    bins bigint NOT NULL,
    error double precision NOT NULL,
    error_low double precision NOT NULL,
    error_high double precision NOT NULL,
    pressure_mpa double precision,
    error_with_gain double precision,
    error_with_gain_low double precision,
    error_with_gain_high double precision
);


--
-- Name: compensation_errors_compensation_error_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.compensation_errors ALTER COLUMN compensation_error_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.compensation_errors_compensation_error_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: compensation_refinements; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.compensation_refinements (
    compensation_refinement_id bigint NOT NULL,
    compensation_id bigint NOT NULL,
    recorded_us bigint NOT NULL,
    contacts bigint NOT NULL,
    outcome text NOT NULL,
    pressure_from_mpa double precision NOT NULL,
    pressure_best_mpa double precision,
    error double precision NOT NULL,
    error_low double precision NOT NULL,
    error_high double precision NOT NULL,
    error_best double precision,
    error_best_low double precision,
    error_best_high double precision,
    error_with_gain double precision NOT NULL,
    error_with_own_gain double precision NOT NULL,
    gain_published boolean NOT NULL
);


--
-- Name: compensation_refinements_compensation_refinement_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.compensation_refinements ALTER COLUMN compensation_refinement_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.compensation_refinements_compensation_refinement_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: compensation_responses; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.compensation_responses (
    compensation_id bigint NOT NULL,
    t_us bigint NOT NULL,
    ratio double precision NOT NULL,
    deflection_mm double precision NOT NULL,
    after_strain double precision NOT NULL,
    before_strain double precision NOT NULL,
    before_origin text NOT NULL,
    target_strain double precision NOT NULL,
    target_origin text NOT NULL
);


--
-- Name: compensations; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.compensations (
    compensation_id bigint NOT NULL,
    robot_id bigint NOT NULL,
    target_whisker_id bigint NOT NULL,
    target_length_mm double precision NOT NULL,
    target_pressure_mpa double precision NOT NULL,
    compensator_whisker_id bigint,
    compensation_case text,
    pressure_before_mpa double precision,
    pressure_mpa double precision,
    predicted_error double precision,
    decided_us bigint NOT NULL,
    ended_us bigint,
    end_reason text,
    predicted_error_low double precision,
    predicted_error_high double precision,
    approval text DEFAULT 'AUTOMATIC'::text NOT NULL,
    CONSTRAINT compensations_approval_check CHECK ((approval = ANY (ARRAY['AUTOMATIC'::text, 'PROPOSED'::text, 'APPROVED'::text, 'REFUSED'::text]))),
    CONSTRAINT compensations_compensation_case_check CHECK ((compensation_case = ANY (ARRAY['SELF_COMPENSATION'::text, 'SHORTER_FOR_LONGER'::text, 'LONGER_FOR_SHORTER'::text])))
);


--
-- Name: contact_hours; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contact_hours (
    whisker_id bigint NOT NULL,
    start_us bigint NOT NULL,
    contacts_used integer NOT NULL,
    contacts_learning integer NOT NULL,
    contacts_unused integer NOT NULL,
    residual_mean real,
    residual_sd real,
    residual_min real,
    residual_max real,
    sensitivity_per_mm real,
    ratio real,
    length_mm real,
    length_sd_mm real,
    length_mean_mm real,
    pressure_mpa real,
    temperature_c real,
    compensation_error real
);


--
-- Name: contact_minutes; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contact_minutes (
    whisker_id bigint NOT NULL,
    start_us bigint NOT NULL,
    contacts_used integer NOT NULL,
    contacts_learning integer NOT NULL,
    contacts_unused integer NOT NULL,
    residual_mean real,
    residual_sd real,
    residual_min real,
    residual_max real,
    sensitivity_per_mm real,
    ratio real,
    length_mm real,
    length_sd_mm real,
    length_mean_mm real,
    pressure_mpa real,
    temperature_c real,
    compensation_error real
)
PARTITION BY RANGE (start_us);


--
-- Name: contact_minutes_20261103; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contact_minutes_20261103 (
    whisker_id bigint NOT NULL,
    start_us bigint NOT NULL,
    contacts_used integer NOT NULL,
    contacts_learning integer NOT NULL,
    contacts_unused integer NOT NULL,
    residual_mean real,
    residual_sd real,
    residual_min real,
    residual_max real,
    sensitivity_per_mm real,
    ratio real,
    length_mm real,
    length_sd_mm real,
    length_mean_mm real,
    pressure_mpa real,
    temperature_c real,
    compensation_error real
);


--
-- Name: contact_minutes_20261203; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contact_minutes_20261203 (
    whisker_id bigint NOT NULL,
    start_us bigint NOT NULL,
    contacts_used integer NOT NULL,
    contacts_learning integer NOT NULL,
    contacts_unused integer NOT NULL,
    residual_mean real,
    residual_sd real,
    residual_min real,
    residual_max real,
    sensitivity_per_mm real,
    ratio real,
    length_mm real,
    length_sd_mm real,
    length_mean_mm real,
    pressure_mpa real,
    temperature_c real,
    compensation_error real
);


--
-- Name: contact_minutes_default; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contact_minutes_default (
    whisker_id bigint NOT NULL,
    start_us bigint NOT NULL,
    contacts_used integer NOT NULL,
    contacts_learning integer NOT NULL,
    contacts_unused integer NOT NULL,
    residual_mean real,
    residual_sd real,
    residual_min real,
    residual_max real,
    sensitivity_per_mm real,
    ratio real,
    length_mm real,
    length_sd_mm real,
    length_mean_mm real,
    pressure_mpa real,
    temperature_c real,
    compensation_error real
);


--
-- Name: contacts; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contacts (
    whisker_id bigint NOT NULL,
    boot bigint NOT NULL,
    seq bigint NOT NULL,
    "position" bigint NOT NULL,
    t_us bigint NOT NULL,
    received_us bigint NOT NULL,
    ratio double precision NOT NULL,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL
)
PARTITION BY RANGE (received_us);


--
-- Name: contacts_20261123; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contacts_20261123 (
    whisker_id bigint NOT NULL,
    boot bigint NOT NULL,
    seq bigint NOT NULL,
    "position" bigint NOT NULL,
    t_us bigint NOT NULL,
    received_us bigint NOT NULL,
    ratio double precision NOT NULL,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL
);


--
-- Name: contacts_20261124; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contacts_20261124 (
    whisker_id bigint NOT NULL,
    boot bigint NOT NULL,
    seq bigint NOT NULL,
    "position" bigint NOT NULL,
    t_us bigint NOT NULL,
    received_us bigint NOT NULL,
    ratio double precision NOT NULL,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL
);


--
-- Name: contacts_default; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contacts_default (
    whisker_id bigint NOT NULL,
    boot bigint NOT NULL,
    seq bigint NOT NULL,
    "position" bigint NOT NULL,
    t_us bigint NOT NULL,
    received_us bigint NOT NULL,
    ratio double precision NOT NULL,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL
);


--
-- Name: epochs; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.epochs (
    fleet text NOT NULL,
    epoch bigint NOT NULL,
    owner text NOT NULL,
    holder text NOT NULL,
    began_us bigint NOT NULL
);


--
-- Name: health_changes; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.health_changes (
    health_change_id bigint NOT NULL,
    whisker_id bigint NOT NULL,
    recorded_us bigint NOT NULL,
    kind text NOT NULL,
    was text,
    becomes text,
    CONSTRAINT health_changes_kind_check CHECK ((kind = ANY (ARRAY['CONDITION'::text, 'FAULT'::text])))
);


--
-- Name: health_changes_health_change_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.health_changes ALTER COLUMN health_change_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.health_changes_health_change_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: journal; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.journal (
    fleet text NOT NULL,
    number bigint NOT NULL,
    entries bytea NOT NULL
)
WITH (autovacuum_vacuum_scale_factor='0', autovacuum_vacuum_threshold='2000', toast.autovacuum_vacuum_scale_factor='0', toast.autovacuum_vacuum_threshold='50000');
ALTER TABLE ONLY public.journal ALTER COLUMN entries SET STORAGE EXTERNAL;


--
-- Name: leases; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.leases (
    fleet text NOT NULL,
    epoch bigint NOT NULL,
    owner text,
    holder text,
    commits bigint DEFAULT 0 NOT NULL,
    expires_us bigint
)
WITH (fillfactor='10');


--
-- Name: policies; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.policies (
    fleet text NOT NULL,
    version bigint NOT NULL,
    mode text NOT NULL,
    objective text NOT NULL,
    longer_for_shorter text NOT NULL,
    predicted_error_max double precision NOT NULL,
    own_role_cost double precision NOT NULL,
    change_margin double precision NOT NULL,
    changed_us bigint NOT NULL,
    changed_by text NOT NULL,
    reason text,
    action_id bigint NOT NULL,
    CONSTRAINT policies_longer_for_shorter_check CHECK ((longer_for_shorter = ANY (ARRAY['NEVER'::text, 'LAST_RESORT'::text, 'ALLOWED'::text]))),
    CONSTRAINT policies_mode_check CHECK ((mode = ANY (ARRAY['AUTOMATIC'::text, 'ADVISE'::text]))),
    CONSTRAINT policies_objective_check CHECK ((objective = ANY (ARRAY['TIP'::text, 'MEAN'::text])))
);


--
-- Name: quarantine; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.quarantine (
    quarantine_id bigint NOT NULL,
    fleet text NOT NULL,
    robot text NOT NULL,
    topic text NOT NULL,
    boot_id text,
    seq bigint,
    received_us bigint NOT NULL,
    quarantined_us bigint NOT NULL,
    cause text NOT NULL,
    code text NOT NULL,
    payload bytea NOT NULL,
    CONSTRAINT quarantine_cause_check CHECK ((cause = ANY (ARRAY['DATA'::text, 'CONSTRAINT'::text, 'SIZE'::text])))
);


--
-- Name: quarantine_quarantine_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.quarantine ALTER COLUMN quarantine_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.quarantine_quarantine_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: redo; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.redo (
    fleet text NOT NULL,
    number bigint NOT NULL,
    rows bytea NOT NULL
)
WITH (autovacuum_vacuum_scale_factor='0', autovacuum_vacuum_threshold='2000', toast.autovacuum_vacuum_scale_factor='0', toast.autovacuum_vacuum_threshold='20000');
ALTER TABLE ONLY public.redo ALTER COLUMN rows SET STORAGE EXTERNAL;


--
-- Name: robots; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.robots (
    robot_id bigint NOT NULL,
    fleet text NOT NULL,
    robot text NOT NULL,
    boot_id text,
    connection text DEFAULT 'OFFLINE'::text NOT NULL,
    model text,
    updated_us bigint DEFAULT 0 NOT NULL,
    state bytea,
    held boolean DEFAULT false NOT NULL,
    journal_number bigint DEFAULT 0 NOT NULL,
    CONSTRAINT robots_connection_check CHECK ((connection = ANY (ARRAY['ONLINE'::text, 'OFFLINE'::text, 'CONNECTION_BROKEN'::text])))
)
WITH (fillfactor='50', toast_tuple_target='8160');


--
-- Name: robots_robot_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.robots ALTER COLUMN robot_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.robots_robot_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: setpoint_states; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.setpoint_states (
    setpoint_state_id bigint NOT NULL,
    command_id text NOT NULL,
    recorded_us bigint NOT NULL,
    state text NOT NULL,
    error text,
    pressure_mpa double precision
);


--
-- Name: setpoint_states_setpoint_state_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.setpoint_states ALTER COLUMN setpoint_state_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.setpoint_states_setpoint_state_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: setpoints; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.setpoints (
    command_id text NOT NULL,
    robot_id bigint NOT NULL,
    whisker_id bigint NOT NULL,
    compensation_id bigint,
    epoch bigint NOT NULL,
    version bigint NOT NULL,
    robot_boot_id text NOT NULL,
    pressure_mpa double precision NOT NULL,
    slew_mpa_per_s double precision NOT NULL,
    issued_us bigint NOT NULL,
    expires_us bigint NOT NULL,
    reason text NOT NULL,
    gain text,
    state text NOT NULL,
    error text,
    reached_mpa double precision,
    CONSTRAINT setpoints_pressure_mpa_check CHECK (((pressure_mpa >= (0)::double precision) AND (pressure_mpa <= (0.2)::double precision)))
);


--
-- Name: supervisors; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.supervisors (
    supervisor text NOT NULL,
    holder text NOT NULL,
    fleets text NOT NULL,
    alive_us bigint NOT NULL,
    deaf text DEFAULT ''::text NOT NULL,
    heard text DEFAULT ''::text NOT NULL
)
WITH (fillfactor='50');


--
-- Name: trims; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.trims (
    trim_id bigint NOT NULL,
    robot_id bigint NOT NULL,
    whisker_id bigint NOT NULL,
    detected_us bigint NOT NULL,
    length_before_mm double precision NOT NULL,
    length_after_mm double precision NOT NULL,
    length_after_sd_mm double precision NOT NULL,
    contacts_to_detect bigint NOT NULL
);


--
-- Name: turned_away; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.turned_away (
    fleet text NOT NULL,
    robot text NOT NULL,
    tries bigint NOT NULL,
    first_us bigint NOT NULL,
    last_us bigint NOT NULL
);


--
-- Name: whiskers; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.whiskers (
    whisker_id bigint NOT NULL,
    array_id bigint NOT NULL,
    robot_id bigint NOT NULL,
    whisker bigint NOT NULL,
    "position" bigint,
    x_mm double precision NOT NULL,
    y_mm double precision NOT NULL,
    model text NOT NULL,
    whole_length_mm double precision NOT NULL,
    nominal_pressure_mpa double precision NOT NULL,
    pressure_max_mpa double precision NOT NULL,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL,
    condition text NOT NULL,
    fault text,
    pressure_mpa double precision,
    setpoint_mpa double precision NOT NULL,
    contacts bigint DEFAULT 0 NOT NULL,
    heard_us bigint,
    state bytea,
    leak_per_s double precision,
    leak_low_per_s double precision,
    leak_high_per_s double precision,
    erosion_mm_per_contact double precision,
    erosion_low_mm_per_contact double precision,
    erosion_high_mm_per_contact double precision,
    contacts_left double precision,
    contacts_left_low double precision,
    contacts_left_high double precision,
    held boolean DEFAULT false NOT NULL,
    rollup bytea
)
WITH (fillfactor='50', toast_tuple_target='8160');


--
-- Name: whiskers_whisker_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.whiskers ALTER COLUMN whisker_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.whiskers_whisker_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: contact_minutes_20261103; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_minutes ATTACH PARTITION public.contact_minutes_20261103 FOR VALUES FROM ('1793664000000000') TO ('1796256000000000');


--
-- Name: contact_minutes_20261203; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_minutes ATTACH PARTITION public.contact_minutes_20261203 FOR VALUES FROM ('1796256000000000') TO ('1798848000000000');


--
-- Name: contact_minutes_default; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_minutes ATTACH PARTITION public.contact_minutes_default DEFAULT;


--
-- Name: contacts_20261123; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contacts ATTACH PARTITION public.contacts_20261123 FOR VALUES FROM ('1795392000000000') TO ('1795478400000000');


--
-- Name: contacts_20261124; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contacts ATTACH PARTITION public.contacts_20261124 FOR VALUES FROM ('1795478400000000') TO ('1795564800000000');


--
-- Name: contacts_default; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contacts ATTACH PARTITION public.contacts_default DEFAULT;


--
-- Data for Name: _sqlx_migrations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public._sqlx_migrations (version, description, installed_on, success, checksum, execution_time) FROM stdin;
1	0001_supervision	2026-11-23 04:20:58.879572+00	t	\\x1869762749e8bfdfe8dc03857ab2aa3b907a68c6ebd02714c30a5295bb8eb9efb475b3bbfe3a8f64b1cc8d0fd52b3d19	231684386
2	0002_leases	2026-11-23 04:20:59.113983+00	t	\\xcc36bf8273e4aba03c0806d4885cffdaaf037e2eb065701406c5f8fd2e03267ac6580227d9b4f09f1e0cec289f029683	45656193
3	0003_closed_loop	2026-11-23 04:20:59.160384+00	t	\\x5693773b033ed3c946205fd6afe7fef978ddb6cbf00d36c728390a013fda6b93349a75a89c9526f1291e7b956e8e177f	13302329
4	0004_rates	2026-11-23 04:20:59.17415+00	t	\\x730a83afcb22b5f61f546991006c34b860510ac1862a26e22ff60badbeac73e51543dfbbeac95662bc297d423503f3e0	1440929
5	0005_actions	2026-11-23 04:20:59.175947+00	t	\\xfc59122ac596454595cafc7d3af068ec84bd1ba834fd8cc18c4d3df4a42dd883541772f0cf1731a1b8d847830aa32755	23072371
6	0006_access	2026-11-23 04:20:59.199542+00	t	\\x504d14543c03f1dc787db4e20f28daa838a5b64ac87185bc5ebe4f7a828cbb4d29673be8baecc6b8cd8d7d753d367725	3146157
7	0007_alarms	2026-11-23 04:20:59.203337+00	t	\\x0653af71e05ebafac1ca2d75ad45f2542882715421957046e570a523b74d9518396f282050d273d5d0e5c18f3c09f6de	19571617
8	0008_changes	2026-11-23 04:20:59.223514+00	t	\\x0eb619d0a7e8439887faffedfcce5b5faa1a5a516d805632a8949736bdc78f3fa62350afb0bfc800e0acc9069323b0f2	9967347
9	0009_calibrations	2026-11-23 04:20:59.233959+00	t	\\xb5d0080ef17a10496fdee5add696e98665c5ab72c8af2828caa65683f694055401a3e5c6303ac00bd71fefd3d41fa9f8	15181889
10	0010_inline_states	2026-11-23 04:20:59.251705+00	t	\\x55fd90560d370defa4ff830d5861be2c45354b860203b4e35fd1e5e20aedcb637296d60bf9846ef736f89aa8e8d46ebd	1171602
11	0011_journal	2026-11-23 04:20:59.253212+00	t	\\x3c3975810f8d480c53ccbdb004c5c19cb5a8fcecdb728109afe413f4f43056228afecf1a193bf9f851982052d7db9c34	7811011
12	0012_history	2026-11-23 04:20:59.261524+00	t	\\x7c5cc25af5bd778e61de9af28030e39bb9a91c45daff53073543448845959a159a115ff87aa891a6f3fcc1afbff953e6	19111339
13	0013_redo	2026-11-23 04:20:59.281225+00	t	\\x4545e25cfd96bd0bad5d7f793ea7a54050b7dafb61c45164fa84ec9153a47fe1bc9b857ae114fe98f2f57831ae71bf0e	3478344
14	0014_quarantine	2026-11-23 04:20:59.285084+00	t	\\x0df715a4c3f7201f440dde5772ab55428d235e1f7a5076045766ebd185ebacadda6ea497be4989dfa47ee204ea275519	13338709
15	0015_allowed_robots	2026-11-23 04:20:59.299359+00	t	\\x7c85f14b198e1157f4e8c732ad9210819b335076ab4e3c904f1efb4ee8d7b045a2365150a7d14d8b9d10fdfcc421ce31	7675023
16	0016_supervisor_hearing	2026-11-23 04:20:59.307244+00	t	\\x3ff5dbc870cfa8ccd8a3af998b192cb90c82307e6b2d3aff49156549d03080c68111fb9573d6f5d2ae304b4583f76092	1015722
\.


--
-- Data for Name: actions; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.actions (action_id, fleet, robot, "array", whisker, compensation_id, alarm_id, kind, parameters, reason, actor, role, request_id, idempotency_key, asked_us, expires_us, state, problem, done_us) FROM stdin;
1	f	crawler-1	left	2	\N	\N	SETPOINT	{"pressure_mpa":0.05}	a setpoint under way	local	ADMIN	f0e99182-abf9-4afb-8fff-968e429bdfaf	\N	1795407677360123	1795407687360123	PENDING	\N	\N
\.


--
-- Data for Name: active_calibrations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.active_calibrations (fleet, model, calibration_id, activated_us, activated_by) FROM stdin;
\.


--
-- Data for Name: alarm_shelves; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.alarm_shelves (alarm_shelf_id, whisker_id, kind, shelved_us, until_us, shelved_by, reason) FROM stdin;
\.


--
-- Data for Name: alarms; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.alarms (alarm_id, whisker_id, raised_us, kind, cleared_us, acknowledged_us, acknowledged_by, acknowledged_reason) FROM stdin;
\.


--
-- Data for Name: allowed_robots; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.allowed_robots (fleet, version, robots, changed_us, changed_by, reason, action_id) FROM stdin;
\.


--
-- Data for Name: api_tokens; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.api_tokens (token_id, name, role, fleets, secret_hash, created_us, created_by, expires_us, revoked_us) FROM stdin;
\.


--
-- Data for Name: arrays; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.arrays (array_id, robot_id, "array", array_type) FROM stdin;
1	1	left	TYPE_1
2	2	front	TYPE_2
\.


--
-- Data for Name: boots; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.boots (boot, robot_id, boot_id, first_seen_us) FROM stdin;
1	1	sim-3a7c5e9241daeced	1795407659512920
2	2	sim-6dba15089f34dec0	1795407659524744
\.


--
-- Data for Name: calibrations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.calibrations (calibration_id, model, version, measurements, fit, calibration, uploaded_us, uploaded_by) FROM stdin;
\.


--
-- Data for Name: changes; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.changes (change_id, tx, recorded_us, fleet, kind, robot_id, whisker_id, number, command_id) FROM stdin;
1	802	1795407664530630	f	HEALTH	\N	3	\N	\N
2	802	1795407664530630	f	HEALTH	\N	2	\N	\N
3	802	1795407664530630	f	HEALTH	\N	1	\N	\N
4	802	1795407664496596	f	HEALTH	\N	4	\N	\N
5	802	1795407664496596	f	HEALTH	\N	6	\N	\N
6	802	1795407664496596	f	HEALTH	\N	5	\N	\N
7	870	1795407676411478	f	HEALTH	\N	2	\N	\N
8	870	1795407676295526	f	HEALTH	\N	4	\N	\N
9	876	1795407676951213	f	TRIM	\N	2	4294967296	\N
10	876	1795407676951213	f	HEALTH	\N	2	\N	\N
11	876	1795407676951213	f	COMPENSATION	\N	2	4294967296	\N
12	876	1795407676951213	f	SETPOINT	\N	2	\N	b159d947-f214-5737-bb9c-af64e84e2d64
13	877	1795407676959904	f	TRIM	\N	4	8589934592	\N
14	877	1795407676959904	f	HEALTH	\N	4	\N	\N
15	877	1795407676959904	f	COMPENSATION	\N	4	8589934592	\N
16	877	1795407676959904	f	SETPOINT	\N	4	\N	61dd82ac-f237-57fb-a04f-ebf3609d0f38
\.


--
-- Data for Name: compensation_candidates; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_candidates (compensation_id, ordinal, whisker_id, compensation_case, length_mm, length_sd_mm, pressure_before_mpa, pressure_mpa, predicted_error, predicted_error_by_ratio, gives_up_own_role, chosen, refused, predicted_error_low, predicted_error_high) FROM stdin;
4294967296	0	2	SELF_COMPENSATION	64.90966889598208	0.29193475813217634	0.1	0.047235049160940866	0.20318518497103122	[0.5059536565620649,0.43783951166219387,0.3692006663063884,0.3042611781029401,0.24496843722000058,0.19206031716024566,0.14564267239970521,0.10550336164157191,0.07128322198400462,0.04256861069004883,0.018940585923207787,2.24905666366502e-15]	f	t	\N	0.14805552336027242	0.31042119551623343
4294967296	1	1	SHORTER_FOR_LONGER	69.99869210988841	0.09983386718516184	0.1	0.10221351947991379	0.0380654991494017	[0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,0.07613099808972328,2.0908013292464044e-10]	t	f	COSTS_MORE	0	1.8768854036842038
4294967296	2	3	LONGER_FOR_SHORTER	70.00728492054355	0.09984562787767277	0.1	0.10233846967906815	0.5006420221638979	[1.3660597662653138,1.3660597662653138,1.3660597662653138,1.3660597662653138,1.3660597662653138,0.13586630002893962,0.13586630002893962,0.13586630002893962,0.13586630002893962,0.13586630002893962,0.13586630002893962,1.974402633197217e-10]	t	f	ERROR_ABOVE_LIMIT	0	1.668921980468379
8589934592	0	4	SELF_COMPENSATION	62.359937554869795	0.2939400572014005	0.1	0.02378523609646522	0.18131084313781518	[0.4541413398712627,0.3939537005345455,0.33174794082125353,0.2724282949566248,0.21826648015726033,0.1701374276368528,0.12819147472669284,0.09221864879450614,0.0618451740427632,0.036638356002721396,0.016161280109298015,7.110936134049586e-16]	f	t	\N	0.13088787022922072	0.27131085718531295
\.


--
-- Data for Name: compensation_error_bins; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_error_bins (compensation_error_id, ratio, contacts, after_per_mm, before_per_mm, before_origin, target_per_mm, target_origin, error, error_low, error_high) FROM stdin;
\.


--
-- Data for Name: compensation_errors; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_errors (compensation_error_id, compensation_id, recorded_us, contacts, bins, error, error_low, error_high, pressure_mpa, error_with_gain, error_with_gain_low, error_with_gain_high) FROM stdin;
\.


--
-- Data for Name: compensation_refinements; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_refinements (compensation_refinement_id, compensation_id, recorded_us, contacts, outcome, pressure_from_mpa, pressure_best_mpa, error, error_low, error_high, error_best, error_best_low, error_best_high, error_with_gain, error_with_own_gain, gain_published) FROM stdin;
\.


--
-- Data for Name: compensation_responses; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_responses (compensation_id, t_us, ratio, deflection_mm, after_strain, before_strain, before_origin, target_strain, target_origin) FROM stdin;
\.


--
-- Data for Name: compensations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, target_pressure_mpa, compensator_whisker_id, compensation_case, pressure_before_mpa, pressure_mpa, predicted_error, decided_us, ended_us, end_reason, predicted_error_low, predicted_error_high, approval) FROM stdin;
4294967296	1	2	70	0.1	2	SELF_COMPENSATION	0.1	0.047235049160940866	0.20318518497103122	1795407676951213	\N	\N	0.14805552336027242	0.31042119551623343	AUTOMATIC
8589934592	2	4	70	0.1	4	SELF_COMPENSATION	0.1	0.02378523609646522	0.18131084313781518	1795407676959904	\N	\N	0.13088787022922072	0.27131085718531295	AUTOMATIC
\.


--
-- Data for Name: contact_hours; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contact_hours (whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, temperature_c, compensation_error) FROM stdin;
\.


--
-- Data for Name: contact_minutes_20261103; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contact_minutes_20261103 (whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, temperature_c, compensation_error) FROM stdin;
2	1795407600000000	0	13	0	-0.0016993709	0.03172326	-0.046565775	0.056764346	0.010350038	0.66196924	70.00171	0.09996279	69.99996	0.10015385	24	\N
3	1795407600000000	0	13	0	0.002550919	0.04005476	-0.0721074	0.084026	0.008041241	0.77546155	70.00022	0.099979825	69.99997	0.099876925	24	\N
1	1795407600000000	0	14	0	0.015338175	0.048630834	-0.059138164	0.12229687	0.00943506	0.73229283	70.00002	0.099976815	69.999275	0.09968571	24	\N
6	1795407600000000	0	13	0	0.005868991	0.034841537	-0.038409635	0.06870558	0.008501018	0.7636923	69.99906	0.09996661	69.99949	0.09978461	24	\N
4	1795407600000000	0	13	0	0.008041091	0.053858317	-0.09237868	0.08978564	0.007406018	0.78326154	69.99795	0.09997772	69.99862	0.099876925	24	\N
5	1795407600000000	0	14	0	0.0028969946	0.06293732	-0.15580213	0.08864971	0.013522871	0.6769214	65.00004	0.09997798	64.9998	0.100114286	24	\N
\.


--
-- Data for Name: contact_minutes_20261203; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contact_minutes_20261203 (whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, temperature_c, compensation_error) FROM stdin;
\.


--
-- Data for Name: contact_minutes_default; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contact_minutes_default (whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, temperature_c, compensation_error) FROM stdin;
\.


--
-- Data for Name: contacts_20261123; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contacts_20261123 (whisker_id, boot, seq, "position", t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) FROM stdin;
3	1	35	4	1795407663456231	1795407663507734	0.5754	4.1001	0.05180145	0.0996	24	LEARNING	-0.0011627146038377411	70.00630994112477	0.09978098257030002
3	1	35	8	1795407663496315	1795407663507734	0.5413	3.1308	0.04573972	0.0996	24	LEARNING	0.02627563121450566	70.00633936499077	0.09978122036421322
3	1	36	0	1795407663521219	1795407663622339	0.8697	0.9295	0.00482908	0.0996	24	LEARNING	-0.031562971170596886	70.00608525843461	0.09978054192539426
3	1	36	3	1795407663545063	1795407663622339	0.6935	4.6859	0.04149668	0.0996	24	LEARNING	0.016653597296920845	70.00612603332864	0.09978076812005955
3	1	36	6	1795407663597509	1795407663622339	0.5504	4.0029	0.05659836	0.0996	24	LEARNING	0.02471675249852214	70.00613155735547	0.09978097708907879
3	1	37	1	1795407663627742	1795407663730809	0.9647	2.0128	0.00883091	0.0996	24	LEARNING	0.03468533569786787	70.00633158803451	0.09978121475235831
3	1	37	2	1795407663665063	1795407663730809	0.4559	0.3634	0.00676995	0.0996	24	LEARNING	-0.05139694916131917	70.00629771539646	0.09978136142627209
3	1	37	7	1795407663688132	1795407663730809	0.7383	0.7303	0.0052357	0.0996	24	LEARNING	-0.06306656217837672	70.0060514714884	0.09978100702128392
3	1	37	8	1795407663718461	1795407663730809	0.5826	0.6235	0.00847397	0.0996	24	LEARNING	0.09813864838424104	70.00621464447646	0.09978135352881644
3	1	38	3	1795407663774906	1795407663847405	0.5826	2.6287	0.03498015	0.0996	24	LEARNING	0.07424114485901961	70.006355652389	0.09978168493773679
3	1	38	5	1795407663790955	1795407663847405	0.8347	4.7357	0.02674396	0.0996	24	LEARNING	-0.04080692444171768	70.00608001405077	0.09978108159706676
3	1	38	9	1795407663825399	1795407663847405	0.7416	4.1185	0.03266663	0.0996	24	LEARNING	0.04527936350609677	70.00630647185385	0.0997813572798645
3	1	39	2	1795407663873569	1795407663965140	0.5879	4.5497	0.06047682	0.0996	24	LEARNING	0.08934176676964124	70.00651066097417	0.09978172943979612
3	1	39	5	1795407663905420	1795407663965140	0.6394	5.9037	0.06338057	0.0996	24	LEARNING	0.04140043124052851	70.00667892563243	0.09978199410880444
3	1	39	7	1795407663917082	1795407663965140	0.7905	1.7525	0.01182105	0.0996	24	LEARNING	0.018723045947367362	70.0068244403377	0.09978190778218263
3	1	39	9	1795407663945309	1795407663965140	0.9282	5.683	0.02493759	0.0996	24	LEARNING	-0.05516968076793235	70.00635177256903	0.09978070775634268
3	1	40	2	1795407663978564	1795407664067894	0.6253	5.1545	0.05922954	0.0996	24	LEARNING	0.06403601713166704	70.006582798217	0.09978105716043416
3	1	40	7	1795407664041347	1795407664067894	0.8408	1.3272	0.00743071	0.0996	24	LEARNING	-0.03209954929255061	70.0062757012467	0.0997800231042037
3	1	40	8	1795407664049888	1795407664067894	0.5124	1.3624	0.021459	0.0996	24	LEARNING	-0.009218292892647095	70.00625347877458	0.09978013071484305
3	1	41	2	1795407664079631	1795407664174430	0.6529	2.7958	0.02932867	0.0996	24	LEARNING	0.059799212332709795	70.00648631488798	0.09978047150540025
3	1	41	6	1795407664134190	1795407664174430	0.6528	1.8319	0.01787566	0.0996	24	LEARNING	-0.013254806395867673	70.0064284791507	0.0997804217333873
3	1	41	9	1795407664167547	1795407664174430	0.8177	0.4763	0.00294205	0.0996	24	LEARNING	0.007418772656721918	70.00650974259015	0.09977974582050268
3	1	42	1	1795407664190337	1795407664290027	0.575	3.4885	0.04649765	0.0996	24	LEARNING	0.04518963571651193	70.00659596937658	0.0997800263448656
3	1	42	4	1795407664216770	1795407664290027	0.7862	2.8012	0.01798445	0.0996	24	LEARNING	-0.0428132307181036	70.00635720289083	0.0997795932015088
3	1	42	8	1795407664246483	1795407664290027	0.9402	1.8681	0.00846279	0.0996	24	LEARNING	0.009405394331071456	70.00643762783463	0.0997793907034965
3	1	43	1	1795407664294800	1795407664410719	0.7895	2.337	0.0157051	0.0996	24	LEARNING	0.012272888902002779	70.00650042173166	0.0997794922869878
3	1	43	2	1795407664314195	1795407664410719	0.8094	3.461	0.02242757	0.0996	24	LEARNING	0.02967737473525414	70.00663596829533	0.09977972657578377
3	1	43	7	1795407664373247	1795407664410719	0.5614	2.8556	0.03975238	0.0996	24	LEARNING	0.041392268181733194	70.00666726065114	0.09977996708612659
3	1	44	0	1795407664399647	1795407664530630	0.8357	5.1496	0.03027616	0.0996	24	LEARNING	0.002098800788308295	70.00667602275777	0.09978007463453228
3	1	44	3	1795407664431629	1795407664530630	0.9625	5.533	0.02410599	0.0996	24	LEARNING	0.023584739833655402	70.00678357895396	0.0997802965740501
3	1	44	5	1795407664470977	1795407664530630	0.8078	1.9505	0.01198426	0.0996	24	LEARNING	-0.028193442713662312	70.0066852718191	0.09978026664430986
3	1	44	7	1795407664482639	1795407664530630	0.6288	4.9382	0.05097326	0.0996	24	LEARNING	-0.03385150228786988	70.00667720957965	0.09978045605513895
2	1	35	5	1795407663458771	1795407663507734	0.777	1.0408	0.00669393	0.0996	24	LEARNING	-0.0681686205910371	69.99989029579935	0.09985183798147167
2	1	35	7	1795407663490058	1795407663507734	0.756	5.1182	0.03813428	0.0996	24	LEARNING	0.019569635931498085	70.00015338339588	0.09985134296158449
2	1	36	1	1795407663531408	1795407663622339	0.7347	1.6383	0.01294662	0.1008	24	LEARNING	0.015987875326166533	70.00035989930188	0.09985085660294094
2	1	36	5	1795407663555765	1795407663622339	0.498	1.7052	0.02932398	0.1008	24	LEARNING	0.02147803903667431	70.0005217112017	0.09985079746676631
2	1	36	7	1795407663601632	1795407663622339	0.7957	3.0702	0.01968744	0.0996	24	LEARNING	-0.020851575007786106	70.0002778746297	0.09984989710469863
2	1	36	9	1795407663617603	1795407663622339	0.9314	0.8483	0.0038951	0.1008	24	LEARNING	-0.0038898818855848216	70.00022665512093	0.0998492214736485
2	1	37	4	1795407663671988	1795407663730809	0.7774	4.6289	0.03283125	0.1008	24	LEARNING	0.027152911355072838	70.00049758636533	0.0998492343524719
2	1	37	6	1795407663684555	1795407663730809	0.6838	4.4358	0.03868403	0.1008	24	LEARNING	-0.035780438899084145	70.00020282838531	0.09984855145578186
2	1	38	0	1795407663726818	1795407663847405	0.8078	4.6446	0.02938348	0.0996	24	LEARNING	-0.0015513393940440434	70.00018860305715	0.09984833588850563
2	1	38	2	1795407663773634	1795407663847405	0.922	3.9042	0.01826396	0.1008	24	LEARNING	-0.011276584544221934	70.00009057492268	0.09984807886826204
2	1	38	6	1795407663801751	1795407663847405	0.7992	5.1898	0.03296731	0.1008	24	LEARNING	-0.023347843030052794	69.99991645138137	0.09984774681018208
2	1	38	8	1795407663820792	1795407663847405	0.8763	3.423	0.01718329	0.0996	24	LEARNING	-0.05217603746288713	69.99957473509798	0.09984709778834167
2	1	39	1	1795407663860035	1795407663965140	0.4637	3.9774	0.07703661	0.0996	24	LEARNING	0.00823016967639928	69.99961400961193	0.09984717051080522
2	1	39	4	1795407663886351	1795407663965140	0.6846	3.6723	0.03279645	0.1008	24	LEARNING	-0.00857085257426232	69.9995606643787	0.0998471000480991
2	1	39	6	1795407663910665	1795407663965140	0.7808	4.0499	0.0272025	0.0996	24	LEARNING	-0.014037718960036964	69.99948087076658	0.09984704768715565
2	1	40	1	1795407663971289	1795407664067894	0.9848	3.0592	0.01278536	0.0996	24	LEARNING	0.03495957544370908	69.99960967264228	0.0998473540182558
2	1	40	4	1795407663992139	1795407664067894	0.817	3.0569	0.01874466	0.0996	24	LEARNING	-0.007026187863484655	69.99957388521219	0.09984740900699643
2	1	40	6	1795407664041030	1795407664067894	0.8449	5.282	0.0317164	0.1008	24	LEARNING	0.042730713463778845	69.99976071892176	0.09984773673682285
2	1	40	9	1795407664059968	1795407664067894	0.7316	2.7891	0.02054175	0.1008	24	LEARNING	-0.06342929114021498	69.99945653486031	0.0998472361675334
2	1	41	1	1795407664078984	1795407664174430	0.6284	5.6467	0.06239867	0.0996	24	LEARNING	0.03268303303709969	69.99962386850356	0.09984749699530703
2	1	41	5	1795407664127726	1795407664174430	0.6337	3.0007	0.03103144	0.0996	24	LEARNING	-0.016916435726624712	69.99953936287189	0.09984743790615075
2	1	41	8	1795407664149936	1795407664174430	0.5256	3.3112	0.05248774	0.0996	24	LEARNING	0.0438639114854012	69.99970043952523	0.0998477456355968
2	1	42	0	1795407664178660	1795407664290027	0.9051	1.7913	0.0092369	0.0996	24	LEARNING	0.04878654562205961	69.99998509313261	0.0998480790367038
2	1	42	5	1795407664222253	1795407664290027	0.7994	2.5676	0.01705899	0.1008	24	LEARNING	0.022332101062207194	70.0001440091413	0.09984824994641474
2	1	42	7	1795407664246355	1795407664290027	0.769	3.3691	0.02364451	0.1008	24	LEARNING	-0.006661194749630881	70.00010225774837	0.09984821827631757
2	1	42	9	1795407664278399	1795407664290027	0.5989	1.1663	0.01405574	0.0996	24	LEARNING	0.023482104479602153	70.00019646924162	0.09984845311599312
2	1	43	3	1795407664323376	1795407664410719	0.4976	3.9294	0.06548147	0.0996	24	LEARNING	-0.010775401080220388	70.00016415393168	0.0998485520657273
2	1	43	5	1795407664355177	1795407664410719	0.9701	1.3922	0.00566378	0.0996	24	LEARNING	-0.028587624279549036	70.00007878331984	0.09984859206379185
2	1	43	8	1795407664385921	1795407664410719	0.6828	4.632	0.04098666	0.1008	24	LEARNING	-0.023933020678618893	69.99999979397865	0.09984862444257714
2	1	44	2	1795407664431566	1795407664530630	0.9665	3.3911	0.01458427	0.0996	24	LEARNING	0.017784539642333223	70.00002420974673	0.09984886011758975
2	1	44	4	1795407664461042	1795407664530630	0.6278	5.2209	0.05537951	0.0996	24	LEARNING	-0.010965212739318532	70.00000511327262	0.09984902814546842
2	1	44	8	1795407664489587	1795407664530630	0.724	2.5907	0.02114258	0.0996	24	LEARNING	0.019606642012038464	70.00003256867122	0.09984926815612502
1	1	35	6	1795407663476570	1795407663507734	0.6192	4.4115	0.04450658	0.0996	24	LEARNING	-0.09487374740791078	70.00813316279705	0.09983655584634604
1	1	35	9	1795407663500836	1795407663507734	0.787	3.6791	0.0250702	0.0996	24	LEARNING	0.012701192629975443	70.00830729734585	0.09983603720798044
1	1	36	2	1795407663533341	1795407663622339	0.8462	2.3641	0.01335425	0.0996	24	LEARNING	-0.016028182232238238	70.00808655132376	0.0998349872045672
1	1	36	4	1795407663545082	1795407663622339	0.9172	0.8826	0.00407957	0.0996	24	LEARNING	-0.03441213422071628	70.00762318279669	0.09983351453101619
1	1	36	8	1795407663606418	1795407663622339	0.5081	1.5634	0.02518735	0.0996	24	LEARNING	-0.010957578899012443	70.00755462180128	0.0998333318703927
1	1	37	0	1795407663621216	1795407663730809	0.478	4.9123	0.09145723	0.0996	24	LEARNING	0.019098055685950327	70.00765540978337	0.09983346058182037
1	1	37	3	1795407663670801	1795407663730809	0.5118	1.5613	0.02596851	0.1008	24	LEARNING	0.03318187854462054	70.00783137892778	0.09983368668543023
1	1	37	5	1795407663683813	1795407663730809	0.6405	4.619	0.04691935	0.1008	24	LEARNING	-0.02119024039668273	70.00768133329471	0.09983338079309202
1	1	37	9	1795407663722158	1795407663730809	0.9164	1.5013	0.00718008	0.0996	24	LEARNING	-0.0015284511904449741	70.0076660841992	0.09983316902345318
1	1	38	1	1795407663757857	1795407663847405	0.8832	4.8733	0.0253652	0.0996	24	LEARNING	-0.0011666750600247441	70.00765619319864	0.09983308219233976
1	1	38	4	1795407663785053	1795407663847405	0.9571	3.012	0.01314848	0.1008	24	LEARNING	0.004498308705696357	70.00769038077713	0.09983313711734015
1	1	38	7	1795407663813602	1795407663847405	0.7751	3.2792	0.02204043	0.0996	24	LEARNING	-0.033616184832748044	70.00751469214158	0.09983292821884947
1	1	39	0	1795407663858098	1795407663965140	0.4951	2.3553	0.03741268	0.0996	24	LEARNING	-0.07430416231732305	70.00733700212118	0.09983276673297087
1	1	39	3	1795407663877658	1795407663965140	0.7911	3.1903	0.02274941	0.0996	24	LEARNING	0.07029330594221368	70.00786093128616	0.0998330986747408
1	1	39	8	1795407663940741	1795407663965140	0.5521	1.1156	0.01463264	0.0996	24	LEARNING	-0.05661230148629961	70.00751866676914	0.09983244280943095
1	1	40	0	1795407663949401	1795407664067894	0.5625	3.2926	0.041803	0.0996	24	LEARNING	-0.05214742020979421	70.00716929414985	0.09983172672756346
1	1	40	3	1795407663986683	1795407664067894	0.99	4.3734	0.01848391	0.0996	24	LEARNING	0.05370212329195728	70.00791989137798	0.09983165453432442
1	1	40	5	1795407664034510	1795407664067894	0.5507	5.0385	0.07116195	0.0996	24	LEARNING	0.01441037529631519	70.0080336587721	0.09983156765290392
1	1	41	0	1795407664070423	1795407664174430	0.8548	2.7396	0.01447869	0.0996	24	LEARNING	-0.060479381529676454	70.00719773121912	0.0998290831513386
1	1	41	3	1795407664106911	1795407664174430	1	5.9472	0.02293002	0.0996	24	LEARNING	-0.01487322272648208	70.00694841367739	0.09982759622088448
1	1	41	4	1795407664117244	1795407664174430	0.9676	0.7909	0.00333783	0.0996	24	LEARNING	-0.0011341660682963558	70.00693049056234	0.09982661596186375
1	1	41	7	1795407664148367	1795407664174430	0.8241	3.977	0.02447681	0.0996	24	LEARNING	0.011964132002448835	70.00708896972984	0.09982615792928144
1	1	42	2	1795407664208241	1795407664290027	0.6169	4.8053	0.05167102	0.0996	24	LEARNING	-0.03543461934986861	70.00679425985862	0.09982543167896356
1	1	42	3	1795407664212332	1795407664290027	0.7777	4.1272	0.02653111	0.0996	24	LEARNING	-0.07023036013355426	70.00599909543796	0.09982330402362713
1	1	42	6	1795407664245426	1795407664290027	0.4579	2.5111	0.05163113	0.0996	24	LEARNING	0.04292686295564521	70.00630219422419	0.09982342785767129
1	1	43	0	1795407664280410	1795407664410719	0.4814	2.1612	0.03818841	0.0996	24	LEARNING	-0.01683305205938268	70.00618150996056	0.09982300848703145
1	1	43	4	1795407664329967	1795407664410719	0.7459	1.1039	0.00845835	0.0996	24	LEARNING	0.016897542012305967	70.0063902300142	0.09982264485707014
1	1	43	6	1795407664363621	1795407664410719	0.7588	1.311	0.00941919	0.0996	24	LEARNING	-0.011170600136661483	70.00625722564547	0.09982188957000175
1	1	43	9	1795407664391080	1795407664410719	0.9391	5.3426	0.02396463	0.0996	24	LEARNING	-0.009752073826187055	70.00612774580237	0.09982109474308874
1	1	44	1	1795407664418586	1795407664530630	0.6955	1.4084	0.01232881	0.0996	24	LEARNING	0.003467604568714752	70.00615897120463	0.09982089968961946
1	1	44	6	1795407664474665	1795407664530630	0.7232	3.5009	0.02679861	0.0996	24	LEARNING	-0.04936545211452803	70.00573125016372	0.09981992127111074
1	1	44	9	1795407664499975	1795407664530630	0.8117	3.9832	0.0244921	0.0996	24	LEARNING	-0.021145306603391704	70.00550116403353	0.09981917166166321
4	2	35	5	1795407663447784	1795407663507735	0.5608	2.2094	0.02949082	0.0996	24	LEARNING	-0.001634749757114342	69.99106840100148	0.09977324260851289
4	2	35	9	1795407663501467	1795407663507735	0.4586	4.3402	0.08708538	0.0996	24	LEARNING	0.025209872841750254	69.9907933168268	0.09977197974060317
4	2	36	0	1795407663524551	1795407663638683	0.7424	2.722	0.0215764	0.1008	24	LEARNING	0.04384914756407091	69.98963945230744	0.09976724007291828
4	2	36	3	1795407663547519	1795407663638683	0.4563	1.1908	0.02130385	0.1008	24	LEARNING	-0.10101425956896495	69.9906354077323	0.09976849806169148
4	2	36	7	1795407663599107	1795407663638683	0.529	5.5129	0.07764089	0.1008	24	LEARNING	-0.061054802883301965	69.99123090249984	0.09976897189745881
4	2	37	1	1795407663627899	1795407663753431	0.5244	4.2618	0.06654305	0.0996	24	LEARNING	0.027905392093916157	69.99099250109903	0.09976822934992934
4	2	37	3	1795407663661287	1795407663753431	0.4802	2.0821	0.0356298	0.0996	24	LEARNING	-0.046965926841298904	69.99131624830059	0.09976850574529884
4	2	37	5	1795407663680630	1795407663753431	0.6606	1.1725	0.01118947	0.0996	24	LEARNING	-0.00977591848182352	69.99145031459764	0.09976760570765572
4	2	38	0	1795407663741479	1795407663873552	0.9661	3.8427	0.01592293	0.1008	24	LEARNING	-0.020866230997844695	69.99207838495713	0.09976431364930644
4	2	38	1	1795407663745710	1795407663873552	0.6801	4.5414	0.04070825	0.1008	24	LEARNING	-0.01449511489064764	69.99230407737218	0.09976327479535742
4	2	38	4	1795407663788071	1795407663873552	0.6912	5.1247	0.04473662	0.1008	24	LEARNING	-0.007511394480915688	69.99243022551902	0.09976186135904973
4	2	38	7	1795407663819587	1795407663873552	0.6771	2.827	0.02594705	0.1008	24	LEARNING	0.00018183022465494478	69.99242713378975	0.09976019891616617
4	2	39	0	1795407663848972	1795407663965141	0.579	1.3406	0.01684391	0.1008	24	LEARNING	0.0006459676969024304	69.99241853744884	0.09975907023709076
4	2	39	5	1795407663900306	1795407663965141	0.7608	4.5535	0.03343199	0.1008	24	LEARNING	0.02037129977369043	69.99194600615796	0.09975567502075482
4	2	39	6	1795407663912840	1795407663965141	0.5665	3.7032	0.04535658	0.1008	24	LEARNING	-0.06733685928739393	69.99287651712889	0.09975622041456925
4	2	39	9	1795407663948362	1795407663965141	0.7161	1.0219	0.00801316	0.1008	24	LEARNING	-0.04172683704942187	69.9936417014455	0.09975576395779985
4	2	40	4	1795407664004431	1795407664067895	0.7466	2.2083	0.01686143	0.0996	24	LEARNING	0.02248006169307485	69.99320036471322	0.09975317060356453
4	2	40	7	1795407664031188	1795407664067895	0.7039	0.714	0.00602437	0.0996	24	LEARNING	-0.001910799504284046	69.99323408892838	0.09975148729517815
4	2	41	0	1795407664063130	1795407664174431	0.5377	1.397	0.02149287	0.0996	24	LEARNING	0.062446490525418126	69.99254844772629	0.09975002980052348
4	2	41	2	1795407664103840	1795407664174431	0.5908	2.1661	0.02785274	0.0996	24	LEARNING	0.06542884247514211	69.99176777917424	0.0997484508667522
4	2	41	6	1795407664136219	1795407664174431	0.7695	1.0028	0.00688576	0.0996	24	LEARNING	-0.020741543887753615	69.99212608475467	0.0997474586285868
4	2	41	8	1795407664154295	1795407664174431	0.9082	3.7174	0.01838035	0.0996	24	LEARNING	0.01744940594635695	69.99167874427806	0.09974371924417832
4	2	42	0	1795407664182212	1795407664289605	0.7619	2.5176	0.01814552	0.0996	24	LEARNING	0.007052155022216913	69.9915498189873	0.09974178467876156
4	2	42	5	1795407664242423	1795407664289605	0.8097	2.3721	0.014714	0.0996	24	LEARNING	-0.011970368759936541	69.99180786485189	0.09973981353028802
4	2	42	8	1795407664274608	1795407664289605	0.8813	1.0489	0.00548981	0.1008	24	LEARNING	0.0021382045448353542	69.99175381127091	0.0997366384059696
4	2	42	9	1795407664280102	1795407664289605	0.9131	0.8527	0.00405866	0.1008	24	LEARNING	-0.012964323677427635	69.99211049326013	0.09973358305721317
4	2	43	2	1795407664315535	1795407664389307	0.5587	3.2042	0.04324706	0.0996	24	LEARNING	0.004006921559937866	69.99206134055649	0.099732564564868
4	2	43	6	1795407664357912	1795407664389307	0.7417	1.8871	0.01451869	0.0996	24	LEARNING	0.015297489886888716	69.99173336613175	0.09972972986942702
4	2	43	8	1795407664386609	1795407664389307	0.6125	5.439	0.06083932	0.0996	24	LEARNING	-0.00307381723364432	69.99178242744803	0.09972827430081656
4	2	44	1	1795407664411371	1795407664496596	0.7534	5.0225	0.03479217	0.0996	24	LEARNING	-0.05632005967779125	69.99313063226889	0.09972792730902937
4	2	44	4	1795407664444451	1795407664496596	0.8324	0.7213	0.00453416	0.0996	24	LEARNING	0.06152371425061667	69.99164298175033	0.09972387299266788
4	2	44	7	1795407664486732	1795407664496596	0.5819	2.5226	0.03088463	0.1008	24	LEARNING	-0.015722174186088494	69.99181061993464	0.09972347204941472
6	2	35	4	1795407663445179	1795407663507735	0.8478	3.8198	0.02165066	0.0996	24	LEARNING	0.010823248809367348	69.9939012258019	0.09983670933579131
6	2	35	7	1795407663477577	1795407663507735	0.9885	5.6804	0.02369138	0.0996	24	LEARNING	0.057943390647511604	69.99408457183821	0.09983702415981435
6	2	36	2	1795407663539322	1795407663638683	0.58	3.5145	0.04324538	0.0996	24	LEARNING	-0.008624513870644114	69.99407029230619	0.0998371992405639
6	2	36	5	1795407663557346	1795407663638683	0.8661	3.6891	0.01918592	0.0996	24	LEARNING	-0.02867865334896368	69.99394849090403	0.09983713872708647
6	2	36	8	1795407663605408	1795407663638683	0.5898	2.5053	0.02776704	0.0996	24	LEARNING	-0.07991758786962365	69.99388007469305	0.0998372094417058
6	2	36	9	1795407663623589	1795407663638683	0.504	4.793	0.08356941	0.1008	24	LEARNING	0.06906473728394699	69.99402348852364	0.0998375347811855
6	2	37	2	1795407663645083	1795407663753431	0.5396	3.536	0.05056111	0.1008	24	LEARNING	-0.000414723455546508	69.9940221995523	0.09983767800783956
6	2	37	7	1795407663708326	1795407663753431	0.6919	5.6071	0.04716462	0.0996	24	LEARNING	-0.03184687102603225	69.99388138963467	0.09983755160311969
6	2	37	8	1795407663729382	1795407663753431	0.884	1.3082	0.00631151	0.0996	24	LEARNING	-0.057385405424836354	69.99346928702003	0.09983669072785818
6	2	38	3	1795407663766254	1795407663873552	0.6764	3.6663	0.03342179	0.0996	24	LEARNING	0.0022354015180658226	69.9934807603539	0.09983676829036475
6	2	38	5	1795407663793868	1795407663873552	0.8762	0.3614	0.00181937	0.0996	24	LEARNING	-0.036120409766077916	69.99318655388764	0.09983611875659573
6	2	38	9	1795407663842631	1795407663873552	0.7883	2.9125	0.01942584	0.1008	24	LEARNING	0.01113351648455053	69.99326080104835	0.09983620121174343
6	2	39	2	1795407663864117	1795407663965141	0.5881	4.2652	0.05205443	0.1008	24	LEARNING	0.009528939625055282	69.99328577249986	0.09983640381322524
6	2	39	3	1795407663893757	1795407663965141	0.5913	4.9307	0.05562052	0.1008	24	LEARNING	-0.05859577666157619	69.9931669944551	0.09983638125096438
6	2	39	7	1795407663932833	1795407663965141	0.4769	0.5786	0.01046019	0.0996	24	LEARNING	0.002107159597962568	69.99317021811727	0.0998365754749516
6	2	40	1	1795407663967575	1795407664067895	0.9433	3.9418	0.01712078	0.0996	24	LEARNING	-0.01166921526496779	69.99310258693797	0.09983654699768842
6	2	40	3	1795407663991624	1795407664067895	0.7782	1.9597	0.01350707	0.0996	24	LEARNING	0.019007471565219466	69.99317131711621	0.09983678901543186
6	2	40	5	1795407664017838	1795407664067895	0.5402	0.9276	0.01350311	0.1008	24	LEARNING	0.020323789531031724	69.99318451630857	0.09983700847163084
6	2	40	8	1795407664051970	1795407664067895	0.7116	1.2559	0.01037704	0.1008	24	LEARNING	0.007136988850630261	69.99319824412314	0.09983722309515734
6	2	41	3	1795407664109131	1795407664174431	0.9124	5.8634	0.02747816	0.0996	24	LEARNING	-0.012579305764717288	69.99317192161655	0.09983738120599413
6	2	41	5	1795407664123992	1795407664174431	0.9892	4.4831	0.01762664	0.1008	24	LEARNING	-0.0023482015293843656	69.99316897550497	0.09983758345850764
6	2	41	7	1795407664149205	1795407664174431	0.7828	3.9136	0.02619532	0.1008	24	LEARNING	-0.00029284035027296487	69.99316892559678	0.09983778421851051
6	2	42	2	1795407664206215	1795407664289605	0.7762	2.1212	0.01399635	0.0996	24	LEARNING	-0.030297859493531084	69.99320334443777	0.09983802245770033
6	2	42	3	1795407664215442	1795407664289605	0.6163	3.6886	0.03951728	0.0996	24	LEARNING	-0.02529888443024402	69.9932623237597	0.09983825072999025
6	2	42	6	1795407664249600	1795407664289605	0.4637	2.3642	0.04365662	0.0996	24	LEARNING	-0.02897276406926889	69.99332571084977	0.09983847965247483
6	2	43	1	1795407664308119	1795407664389307	0.8314	0.6531	0.00366177	0.0996	24	LEARNING	-0.043030804155284944	69.99340672074163	0.09983878366648764
6	2	43	4	1795407664328917	1795407664389307	0.7486	1.2921	0.00977559	0.0996	24	LEARNING	0.029589373989658087	69.99334858210057	0.09983886896271237
6	2	43	5	1795407664356800	1795407664389307	0.9773	1.2274	0.00489222	0.0996	24	LEARNING	-0.013827791201643857	69.99338196008429	0.09983906111736848
6	2	43	9	1795407664388841	1795407664389307	0.7284	0.7691	0.00573766	0.0996	24	LEARNING	-0.04272055520747911	69.99350362859971	0.09983938906872653
6	2	44	2	1795407664414326	1795407664496596	0.6351	5.3942	0.05858943	0.1008	24	LEARNING	0.047900557585550896	69.99336995050659	0.09983935656602239
6	2	44	5	1795407664453493	1795407664496596	0.5193	2.2939	0.03449443	0.1008	24	LEARNING	-0.02268073833955533	69.99342512521864	0.09983956275387572
6	2	44	8	1795407664487178	1795407664496596	0.5247	3.3887	0.05438009	0.1008	24	LEARNING	0.06246899718161837	69.99325073485781	0.0998394783969123
5	2	35	6	1795407663470543	1795407663507735	0.7647	2.1433	0.01901383	0.0996	24	LEARNING	0.060811532047563975	64.99715107830376	0.0999292376860913
5	2	35	8	1795407663483130	1795407663507735	0.9707	1.2506	0.00612103	0.0996	24	LEARNING	-0.023724045840283363	64.99708756044458	0.09992932308026271
5	2	36	1	1795407663538921	1795407663638683	0.6935	3.1826	0.03307087	0.0996	24	LEARNING	0.02023513605862825	64.99706142403473	0.09992946089965637
5	2	36	4	1795407663552295	1795407663638683	0.5242	3.0763	0.05562182	0.0996	24	LEARNING	0.034342038657647185	64.99697558607878	0.09992946407870189
5	2	36	6	1795407663593184	1795407663638683	0.4636	0.3274	0.00710387	0.1008	24	LEARNING	-0.011543619208659163	64.99699478738616	0.09992964726808604
5	2	37	0	1795407663627030	1795407663753431	0.8393	1.0697	0.00753919	0.1008	24	LEARNING	0.021225068636447037	64.99697322694115	0.09992980170818024
5	2	37	4	1795407663671381	1795407663753431	0.8487	2.6455	0.01853446	0.1008	24	LEARNING	0.04022439731625445	64.99689743120747	0.09992987794620252
5	2	37	6	1795407663702530	1795407663753431	0.4896	3.0215	0.06091635	0.1008	24	LEARNING	0.016003248937538763	64.99685261380894	0.09992991028642319
5	2	37	9	1795407663741132	1795407663753431	0.6821	5.2449	0.05880905	0.0996	24	LEARNING	0.062289047482174786	64.99659706771499	0.09992969710705563
5	2	38	2	1795407663748327	1795407663873552	0.7022	5.0457	0.04912127	0.0996	24	LEARNING	-0.021429774964291055	64.99664492269281	0.09992991930860382
5	2	38	6	1795407663806428	1795407663873552	0.7267	5.6337	0.05413869	0.0996	24	LEARNING	0.03525617675188917	64.9965520183237	0.09992993097929678
5	2	38	8	1795407663841062	1795407663873552	0.9533	2.0424	0.0108672	0.0996	24	LEARNING	0.020241916151819653	64.99653513678061	0.09993009740073072
5	2	39	1	1795407663858553	1795407663965141	0.7086	0.7941	0.00778615	0.0996	24	LEARNING	0.0018736184509730615	64.99652937198316	0.09993018951093335
5	2	39	4	1795407663895341	1795407663965141	0.7101	2.2905	0.02363962	0.0996	24	LEARNING	0.05887310914054375	64.99628262990991	0.0999299803622155
5	2	39	8	1795407663939961	1795407663965141	0.5538	1.8079	0.03084571	0.0996	24	LEARNING	0.07608369984261953	64.99604711987595	0.09992982216028161
5	2	40	0	1795407663954479	1795407664067895	0.7222	4.9057	0.04540996	0.0996	24	LEARNING	-0.01650063263971684	64.99605356963863	0.0999300290674597
5	2	40	2	1795407663986997	1795407664067895	0.7938	5.4086	0.04123181	0.0996	24	LEARNING	-0.015360264875257589	64.9960584968728	0.09993023364703164
5	2	40	6	1795407664028949	1795407664067895	0.6582	2.5786	0.03000968	0.0996	24	LEARNING	0.026269849710323	64.99599800432874	0.09993029016878685
5	2	40	9	1795407664061160	1795407664067895	0.9861	3.534	0.01672687	0.0996	24	LEARNING	-0.020097587892939316	64.99600797228699	0.09993050245162884
5	2	41	1	1795407664080289	1795407664174431	0.5254	1.8488	0.03289378	0.0996	24	LEARNING	0.017717216523099395	64.99595352165976	0.09993051054149342
5	2	41	4	1795407664118351	1795407664174431	0.783	0.9047	0.0074714	0.1008	24	LEARNING	0.03159854586165821	64.99588035908056	0.09993056213151462
5	2	41	9	1795407664159124	1795407664174431	0.6314	3.3899	0.04264214	0.1008	24	LEARNING	0.019863623564873777	64.99580780899794	0.09993052816112842
5	2	42	1	1795407664196758	1795407664289605	0.8038	1.2206	0.0093768	0.0996	24	LEARNING	0.0168569918155143	64.99574727459853	0.09993052697911708
5	2	42	4	1795407664219378	1795407664289605	0.9259	2.2651	0.01261516	0.0996	24	LEARNING	0.0011201463083236928	64.99574272287553	0.09993058250218566
5	2	42	7	1795407664272449	1795407664289605	0.5235	3.4969	0.05958195	0.0996	24	LEARNING	-0.032995576970710684	64.9959094613276	0.09993079884676058
5	2	43	0	1795407664299071	1795407664389307	0.986	3.2436	0.01541349	0.0996	24	LEARNING	-0.016406852239161048	64.99600676164201	0.09993091391793128
5	2	43	3	1795407664320342	1795407664389307	0.5836	3.4449	0.04632853	0.0996	24	LEARNING	-0.06399644971539974	64.9964121551765	0.09993152894189938
5	2	43	7	1795407664359964	1795407664389307	0.7861	0.4292	0.00354773	0.0996	24	LEARNING	0.04024663540849404	64.99624634966841	0.0999313907317512
5	2	44	0	1795407664408240	1795407664496596	0.6952	1.8702	0.01904178	0.0996	24	LEARNING	0.0011514577608480034	64.99624070383341	0.09993137248703693
5	2	44	3	1795407664423512	1795407664496596	0.8105	3.2393	0.02368412	0.0996	24	LEARNING	-0.01364829255734219	64.99631470055931	0.09993146641239418
5	2	44	6	1795407664475284	1795407664496596	0.9256	0.5479	0.00324858	0.0996	24	LEARNING	0.0575259882258392	64.99602394854665	0.09993120451815556
5	2	44	9	1795407664492152	1795407664496596	0.5602	1.1398	0.01809628	0.0996	24	LEARNING	0.024126527000603422	64.99591552778506	0.09993104841731276
2	1	141	6	1795407675257145	1795407675291395	0.6861	0.95	0.00820736	0.0996	24	USED	-0.03183365684120255	69.99927198429988	0.09991223263835461
2	1	141	9	1795407675287534	1795407675291395	0.5754	0.4486	0.00548614	0.0996	24	USED	-0.0349721158448287	69.99925995423038	0.09991241620266882
2	1	142	4	1795407675340224	1795407675419880	0.5269	5.347	0.07647493	0.0996	24	USED	-0.049134533253884276	69.99926656394994	0.09991262634094149
2	1	142	6	1795407675356155	1795407675419880	0.466	5.3456	0.10351276	0.0996	24	USED	0.024633454966951098	69.99927310058389	0.0999128363747488
2	1	143	0	1795407675400981	1795407675530430	0.831	5.6422	0.03282091	0.0996	24	USED	-0.023003919737342775	69.99927437252632	0.09991303890233291
2	1	143	2	1795407675417636	1795407675530430	0.4644	0.6816	0.01304563	0.0996	24	USED	0.007181005376716972	69.99927776919014	0.09991324445877822
2	1	143	6	1795407675472877	1795407675530430	0.9921	1.8951	0.00780163	0.0996	24	USED	0.03334449401195882	69.99922613161596	0.09991336040353899
2	1	143	8	1795407675506505	1795407675530430	0.9389	1.7227	0.0082595	0.0996	24	USED	0.057521194817185095	69.99919617876414	0.09991351841631708
2	1	144	0	1795407675512472	1795407675627363	0.5009	3.8802	0.06829046	0.0996	24	USED	0.06325009187642228	69.99919587164949	0.09991371869086522
2	1	144	3	1795407675562484	1795407675627363	0.7355	5.8893	0.04744799	0.0996	24	USED	0.04140802999836721	69.99919555600388	0.09991391895284733
2	1	144	6	1795407675583819	1795407675627363	0.8405	3.8803	0.0235422	0.0996	24	USED	0.043686626467903555	69.99919467203067	0.09991411840424633
2	1	144	9	1795407675617179	1795407675627363	0.6272	5.4377	0.05746478	0.1008	24	USED	-0.014768647114679507	69.9991927559384	0.09991431638390444
2	1	145	4	1795407675665402	1795407675719854	0.8103	0.733	0.00450564	0.0996	24	USED	-0.02140092669946039	69.99917319450911	0.09991448363400214
2	1	145	7	1795407675691168	1795407675719854	0.4962	4.3968	0.08272839	0.0996	24	USED	0.11201088587081133	69.99917483633686	0.09991468668472615
2	1	145	8	1795407675713738	1795407675719854	0.8537	2.4225	0.01378531	0.0996	24	USED	0.014090962863528856	69.99917556248707	0.09991488842974872
2	1	146	2	1795407675771089	1795407675863251	0.9107	4.4926	0.02329742	0.0996	24	USED	0.06529036076038557	69.99913821013507	0.09991503589432768
2	1	146	4	1795407675781677	1795407675863251	0.7222	1.933	0.01571265	0.0996	24	USED	0.01213240439951746	69.99914004766467	0.09991523922258799
2	1	146	7	1795407675813285	1795407675863251	0.4907	3.2312	0.05517021	0.0996	24	USED	-0.006383680069477342	69.99913965142089	0.09991543936633981
2	1	147	0	1795407675847946	1795407675966247	0.8371	2.428	0.01369772	0.0996	24	USED	-0.03807906208162839	69.99913538008622	0.09991563398597242
2	1	147	5	1795407675899757	1795407675966247	0.6928	1.049	0.0087477	0.0996	24	USED	-0.04768314598705931	69.99912227851425	0.09991581601842056
2	1	147	8	1795407675938609	1795407675966247	0.5804	1.1256	0.01408047	0.0996	24	USED	0.0033363833348819855	69.99912208484888	0.09991601644968205
2	1	148	0	1795407675959550	1795407676080103	0.737	2.6568	0.02164053	0.0996	24	USED	0.05652617140166757	69.99912779262985	0.09991622529258892
2	1	148	3	1795407675994114	1795407676080103	0.6142	1.8245	0.02137802	0.0996	24	USED	0.048812329686281686	69.99912172387496	0.0999164173485619
2	1	148	5	1795407676011139	1795407676080103	0.5184	1.1677	0.01853249	0.0996	24	USED	0.02387381891114116	69.99912212591205	0.0999166186277374
2	1	148	9	1795407676065409	1795407676080103	0.6996	0.2125	0.00177673	0.1008	24	USED	-0.022433722006098143	69.99906751465373	0.09991670246654184
2	1	149	2	1795407676087860	1795407676189399	0.9872	3.929	0.01558972	0.1008	24	USED	-0.020276547144520467	69.99909325653535	0.09991692871221884
2	1	149	6	1795407676132043	1795407676189399	0.9233	2.4072	0.01090402	0.0996	24	USED	-0.038405189866181404	69.99911311748059	0.09991715772665638
2	1	149	7	1795407676169153	1795407676189399	0.894	4.6442	0.02461316	0.0996	24	USED	0.045247899503227405	69.99909475639093	0.09991733225948908
2	1	150	1	1795407676199309	1795407676308720	0.5502	4.6876	0.06961479	0.0996	24	USED	0.07034549229020971	69.99907902958641	0.099917510547311
2	1	150	4	1795407676227988	1795407676308720	0.9004	2.7087	0.0154018	0.0996	24	USED	0.13188603265022042	69.99905885287853	0.09991768249274756
2	1	150	7	1795407676257406	1795407676308720	0.8193	4.7902	0.03345662	0.0996	24	USED	0.12791312586083578	69.99905865552084	0.09991788291465567
2	1	151	0	1795407676294490	1795407676411478	0.8348	0.3018	0.00206872	0.0996	24	USED	0.15744078738358136	69.99909535795024	0.09991813035589128
4	2	141	4	1795407675235971	1795407675291396	0.8832	1.9554	0.01028361	0.1008	24	USED	0.013537439696482639	69.99204320940099	0.09960054996857236
4	2	141	6	1795407675243689	1795407675291396	0.9896	4.4617	0.01809209	0.1008	24	USED	0.016887184924718038	69.99189955212843	0.09960016921078588
4	2	141	9	1795407675277873	1795407675291396	0.7272	0.596	0.00473694	0.1008	24	USED	0.002583863456114467	69.99189135256432	0.0996002918939722
4	2	142	2	1795407675313505	1795407675398218	0.5261	5.5413	0.08487454	0.0996	24	USED	0.012417288166951633	69.99184670694517	0.0996003186494394
4	2	142	5	1795407675350818	1795407675398218	0.4498	1.3506	0.02689877	0.0996	24	USED	-0.01871405869824263	69.99188835456235	0.099600528126108
4	2	142	8	1795407675377082	1795407675398218	0.7635	3.9318	0.03062133	0.0996	24	USED	0.08907247170373343	69.99141291697023	0.09959988289788674
4	2	143	2	1795407675436347	1795407675525115	0.7302	1.8618	0.01511518	0.0996	24	USED	0.03547042571675749	69.99124346679663	0.09959969540933301
4	2	143	4	1795407675444029	1795407675525115	0.7009	0.8289	0.00698844	0.0996	24	USED	-0.013022210113401472	69.99129506843616	0.09959986288036615
4	2	143	8	1795407675504710	1795407675525115	0.9932	5.1765	0.02046675	0.0996	24	USED	0.003363012540360436	69.9912645498873	0.09959958520342893
4	2	144	0	1795407675519132	1795407675627364	0.6791	2.1765	0.01910886	0.1008	24	USED	-0.03977752370685516	69.99143171253984	0.09959989809703447
4	2	144	4	1795407675544262	1795407675627364	0.9861	1.4688	0.0059419	0.1008	24	USED	0.005223272578685437	69.9913950665819	0.09959978515124988
4	2	144	8	1795407675596454	1795407675627364	0.572	5.1522	0.06794451	0.0996	24	USED	0.024668897375518792	69.99129578139133	0.0995997129064047
4	2	145	0	1795407675617034	1795407675741526	0.6009	4.9417	0.0582033	0.0996	24	USED	0.008801726680089498	69.9912582789403	0.0995997217863772
4	2	145	2	1795407675652694	1795407675741526	0.5486	0.5289	0.00760022	0.0996	24	USED	0.02852491255609877	69.99117388449447	0.0995997319726454
4	2	145	7	1795407675685584	1795407675741526	0.8907	1.1731	0.00586558	0.0996	24	USED	-0.015398637651550705	69.99125763829949	0.09959988304497498
4	2	146	0	1795407675733187	1795407675858267	0.6076	0.4576	0.00467972	0.0996	24	USED	-0.11122693584060551	69.9915819066776	0.09960047240453304
4	2	146	1	1795407675752031	1795407675858267	0.977	2.1247	0.00848477	0.0996	24	USED	-0.025843624406986416	69.99178114055498	0.0996006347524342
4	2	146	5	1795407675797508	1795407675858267	0.5176	0.9128	0.01387505	0.0996	24	USED	-0.026405032452571985	69.99185996750793	0.09960086289467635
4	2	146	7	1795407675813698	1795407675858267	0.6791	4.052	0.03732883	0.0996	24	USED	0.010932347387693263	69.99180899132934	0.09960084161909892
4	2	147	0	1795407675843850	1795407675966248	0.6097	5.2403	0.05714063	0.0996	24	USED	-0.03911320698073208	69.99197518616297	0.0996011365849545
4	2	147	3	1795407675897964	1795407675966248	0.8577	1.2409	0.00663072	0.1008	24	USED	-0.03647544337493927	69.99214296824496	0.09960145061906849
4	2	147	6	1795407675916418	1795407675966248	0.5053	0.3588	0.0057334	0.0996	24	USED	-0.02196455999593199	69.99219057234559	0.09960167408648307
4	2	147	9	1795407675946316	1795407675966248	0.572	5.087	0.06549049	0.0996	24	USED	0.0009964759657917245	69.99218667141248	0.09960174129600964
4	2	148	4	1795407675997340	1795407676059159	0.963	3.5464	0.01475373	0.0996	24	USED	-0.018580675445620646	69.99233304516454	0.09960181283192639
4	2	148	5	1795407676013952	1795407676059159	0.7939	4.8985	0.03155626	0.0996	24	USED	-0.016340088944104034	69.99242238594091	0.09960195520419932
4	2	148	8	1795407676047338	1795407676059159	0.638	3.6342	0.03673394	0.0996	24	USED	-0.02356044214307256	69.99252551256987	0.09960216171308024
4	2	149	3	1795407676096573	1795407676189400	0.715	4.1505	0.03372734	0.1008	24	USED	-0.009624166439342276	69.99256857023082	0.09960228936152318
4	2	149	5	1795407676115340	1795407676189400	0.8698	2.1774	0.01188459	0.0996	24	USED	0.019556497046514264	69.99245474037534	0.09960213489413121
4	2	149	8	1795407676158258	1795407676189400	0.8823	4.0675	0.01970622	0.0996	24	USED	-0.06751729650183011	69.99288514560975	0.09960271229325708
4	2	150	2	1795407676200064	1795407676295526	0.8692	1.0485	0.00794432	0.0996	24	USED	0.34600046789918437	69.99288347572896	0.09960291124614869
4	2	150	5	1795407676240335	1795407676295526	0.9585	4.8576	0.02849777	0.0996	24	USED	0.31460788245235427	69.99288098898677	0.09960310904933348
4	2	150	7	1795407676274625	1795407676295526	0.7379	3.7146	0.03750021	0.0996	24	USED	0.27628799812827465	69.9928796236467	0.09960330842988341
2	1	151	4	1795407676332141	1795407676411478	0.5238	2.3867	0.04314215	0.1008	24	USED	0.17138351700368915	69.99910500721937	0.0999183448124414
2	1	151	5	1795407676351557	1795407676411478	0.7941	2.3112	0.017855	0.1008	24	USED	0.15860336631007338	69.99911240081693	0.09991855605355181
2	1	151	9	1795407676405307	1795407676411478	0.5827	1.1339	0.01727487	0.0996	24	USED	0.2071730991806138	69.99911232633026	0.0999187566491303
2	1	152	2	1795407676429117	1795407676507737	0.4631	1.8665	0.03915254	0.1008	24	USED	-0.032780448364670416	65.5792506041895	0.5835731754553692
2	1	152	4	1795407676444822	1795407676507737	0.5531	3.6369	0.06305967	0.1008	24	USED	0.10792123878231895	65.04715265030792	0.5383843206934427
2	1	152	9	1795407676491744	1795407676507737	0.7285	5.1474	0.04523271	0.1008	24	USED	-0.049177670726201245	65.32900971076387	0.49116704513363635
2	1	153	0	1795407676516686	1795407676650955	0.4643	3.7223	0.08233143	0.0996	24	USED	0.02267092981496327	65.26260506224625	0.47185940977523977
2	1	153	3	1795407676555113	1795407676650955	0.6827	3.0797	0.03512587	0.0996	24	USED	0.08974692649746761	64.88660892353059	0.440519654839516
2	1	153	6	1795407676578523	1795407676650955	0.6806	2.539	0.02605403	0.0996	24	USED	-0.03385973521532968	65.01201079127566	0.41699460480809697
2	1	153	9	1795407676620233	1795407676650955	0.9304	3.6549	0.02095538	0.0996	24	USED	0.043658184401920985	64.81670401988602	0.38530462160395185
2	1	154	2	1795407676650493	1795407676738106	0.5303	3.79	0.06671396	0.0996	24	USED	0.02300477932306178	64.7681291622541	0.37458430738484383
2	1	154	7	1795407676705278	1795407676738106	0.9484	3.7275	0.01939021	0.1008	24	USED	-0.022957667718469344	64.85325123820556	0.35234454343070576
2	1	155	0	1795407676727516	1795407676845118	0.7946	5.0133	0.03844754	0.0996	24	USED	-0.01023538008605038	64.88157309416758	0.33816906570502975
2	1	155	2	1795407676764097	1795407676845118	0.9164	5.882	0.03354596	0.0996	24	USED	5.93423998458667e-05	64.881400518673	0.3231867151732834
2	1	155	4	1795407676797641	1795407676845118	0.5586	0.8618	0.01386977	0.0996	24	USED	0.03335422681033708	64.82987995609793	0.3168365538874081
2	1	155	8	1795407676824574	1795407676845118	0.4859	0.2202	0.00468684	0.0996	24	USED	0.054987938261366796	64.76194351887754	0.3120500831793519
2	1	156	1	1795407676865025	1795407676951213	0.5856	2.2148	0.03177981	0.1008	24	USED	0.002391057277979349	64.75835709103178	0.3062306754616899
2	1	156	5	1795407676908639	1795407676951213	0.5115	0.4568	0.00782671	0.1008	24	USED	-0.07289767558884111	64.84629602815644	0.30195966252112066
2	1	156	8	1795407676937610	1795407676951213	0.9189	4.2186	0.02328368	0.0996	24	USED	-0.027716614542205927	64.90966889598208	0.29193475813217634
1	1	147	3	1795407675894296	1795407675966247	0.475	0.8388	0.01540906	0.0996	24	USED	0.004609586165515747	69.99926371791624	0.09982956433685859
1	1	147	6	1795407675937637	1795407675966247	0.9351	1.8171	0.00784637	0.1008	24	USED	-0.056554568462306554	69.9990501827008	0.09982938854963337
1	1	148	1	1795407675970966	1795407676080103	0.9338	1.4762	0.0068993	0.0996	24	USED	0.02317377288530972	69.99912208179302	0.09982964160137292
1	1	148	4	1795407675997257	1795407676080103	0.5142	1.7081	0.02595291	0.0996	24	USED	-0.036822157977743776	69.99908316321284	0.09982977589657512
1	1	148	7	1795407676041552	1795407676080103	0.4774	2.1537	0.03819389	0.0996	24	USED	-0.02134034479932762	69.99905937664039	0.09982993174296141
1	1	149	0	1795407676066241	1795407676189399	0.6025	2.0379	0.02240278	0.0996	24	USED	-0.053271866302552526	69.99898192327258	0.09983000559241201
1	1	149	3	1795407676091346	1795407676189399	0.6453	5.1016	0.05228397	0.0996	24	USED	0.013910823344338664	69.99900817239529	0.09983022152772836
1	1	149	5	1795407676117703	1795407676189399	0.6281	5.3521	0.05662122	0.1008	24	USED	-0.01069687422116513	69.99898566415187	0.09983036245700591
1	1	149	9	1795407676176216	1795407676189399	0.727	5.7226	0.04483905	0.0996	24	USED	-0.009370394772104615	69.99896024151954	0.09983048249757245
1	1	150	2	1795407676201748	1795407676308720	0.6558	3.5027	0.03407458	0.0996	24	USED	-0.005480866135508123	69.99894954016447	0.0998306458189842
1	1	150	5	1795407676240342	1795407676308720	0.9554	1.406	0.0060236	0.1008	24	USED	-0.014527939500583634	69.99890007522637	0.0998307204714403
1	1	150	8	1795407676257407	1795407676308720	0.7045	5.0209	0.04080491	0.1008	24	USED	-0.04067355865933556	69.9987817863942	0.09983070273742954
1	1	151	1	1795407676304592	1795407676411478	0.9531	2.8278	0.01223839	0.0996	24	USED	-0.006715477744055582	69.99876055486776	0.09983082317365183
1	1	151	2	1795407676310503	1795407676411478	0.7269	4.7694	0.03789721	0.0996	24	USED	0.00454213876492103	69.99877272949493	0.09983099674005758
1	1	151	7	1795407676376985	1795407676411478	0.7805	3.9547	0.02809182	0.1008	24	USED	0.04066689901735277	69.99892045726742	0.09983133538039549
1	1	152	0	1795407676410239	1795407676507737	0.5932	4.7807	0.0578928	0.1008	24	USED	0.01108549941181366	69.99893995197021	0.09983154169293916
1	1	152	3	1795407676438258	1795407676507737	0.476	1.5953	0.02857133	0.1008	24	USED	-0.017718715625080858	69.99891707036146	0.09983169325076653
1	1	152	5	1795407676451299	1795407676507737	0.8084	1.5602	0.0095273	0.1008	24	USED	-0.03470066874281739	69.99879103199333	0.09983164215852694
1	1	152	7	1795407676480789	1795407676507737	0.546	3.7101	0.05320717	0.0996	24	USED	0.020576335203039448	69.99881403885075	0.09983186462361934
1	1	153	1	1795407676523921	1795407676650955	0.5878	2.4739	0.02976499	0.0996	24	USED	-0.011527805493660384	69.99879891404805	0.09983203280801657
1	1	153	4	1795407676555909	1795407676650955	0.7614	5.4617	0.03876413	0.0996	24	USED	-0.01050570620833238	69.99876742517857	0.09983213864045717
1	1	153	7	1795407676606509	1795407676650955	0.682	0.8662	0.00818262	0.1008	24	USED	0.04338733716796267	69.99886768878196	0.09983244876392
1	1	154	1	1795407676633480	1795407676738106	0.5707	2.257	0.02851636	0.0996	24	USED	-0.02048367675539602	69.99884343371879	0.09983260394765389
1	1	154	3	1795407676657542	1795407676738106	0.8978	1.9209	0.00937798	0.0996	24	USED	-0.02308460622943675	69.99876619252574	0.09983263906887532
1	1	154	5	1795407676683719	1795407676738106	0.9299	1.6694	0.00750656	0.0996	24	USED	-0.025065484871544204	69.99868841779099	0.09983267902342946
1	1	154	9	1795407676720431	1795407676738106	0.5394	1.315	0.01832296	0.1008	24	USED	-0.03311030355671963	69.99864556441723	0.09983280774666081
1	1	155	1	1795407676750826	1795407676845118	0.9719	2.4981	0.00999384	0.1008	24	USED	-0.04295224254423381	69.99850053871185	0.09983274644943949
1	1	155	6	1795407676809926	1795407676845118	0.9358	4.3922	0.02010232	0.1008	24	USED	0.004008196845213914	69.99851605803511	0.0998328968652865
1	1	155	7	1795407676813075	1795407676845118	0.7808	0.9178	0.00656498	0.0996	24	USED	0.051883226400182385	69.99865414891758	0.0998332551848856
1	1	156	2	1795407676874139	1795407676951213	0.7469	0.4765	0.00360414	0.0996	24	USED	0.013257593208962424	69.99868005649041	0.09983347060861385
1	1	156	3	1795407676896514	1795407676951213	0.6162	0.544	0.00626549	0.0996	24	USED	0.03851538429377004	69.9987233127477	0.09983372188594469
1	1	156	6	1795407676918016	1795407676951213	0.4983	2.7479	0.04454873	0.0996	24	USED	-0.031021809989817902	69.99869210988841	0.09983386718516184
3	1	147	7	1795407675938292	1795407675966247	0.8183	1.1281	0.00723314	0.1008	24	USED	0.03971050876080216	70.00759743402162	0.09984005175854563
3	1	147	9	1795407675958089	1795407675966247	0.9502	4.1376	0.01784546	0.1008	24	USED	-0.021135147422378008	70.00758468494318	0.09984023426679495
3	1	148	2	1795407675988402	1795407676080103	0.9787	2.6399	0.01057237	0.0996	24	USED	-0.02237322007054479	70.00757800503622	0.09984042553401842
3	1	148	6	1795407676034647	1795407676080103	0.8701	0.8026	0.00407294	0.1008	24	USED	-0.05795064857926475	70.0074007875513	0.09984030932500612
3	1	148	8	1795407676063706	1795407676080103	0.5913	1.4802	0.01823212	0.1008	24	USED	0.01903099455394455	70.00739987985239	0.099840508921976
3	1	149	1	1795407676081985	1795407676189399	0.7835	2.7926	0.01971976	0.1008	24	USED	0.041711257535183434	70.00743594230083	0.09984075628062938
3	1	149	4	1795407676113736	1795407676189399	0.9116	2.5193	0.01248398	0.0996	24	USED	0.0261797811345175	70.00745586177133	0.09984098034820883
3	1	149	8	1795407676171401	1795407676189399	1	0.8663	0.00341552	0.1008	24	USED	0.010952972839563969	70.00748760936239	0.09984117683885885
3	1	150	0	1795407676180380	1795407676308720	0.5448	0.7803	0.01083674	0.1008	24	USED	-0.02044607569058886	70.0074851068202	0.09984137413299748
3	1	150	3	1795407676220724	1795407676308720	0.552	5.4409	0.07464751	0.1008	24	USED	-0.007662994488346592	70.00748867038327	0.09984158018027954
3	1	150	6	1795407676245541	1795407676308720	0.9468	2.2965	0.00989585	0.1008	24	USED	-0.029877281823520226	70.0074559030304	0.09984172822091884
3	1	150	9	1795407676287927	1795407676308720	0.7994	4.1202	0.02714055	0.0996	24	USED	0.01817289903786007	70.00746211837907	0.09984193809356812
3	1	151	3	1795407676322108	1795407676411478	0.5393	5.0211	0.07654642	0.0996	24	USED	0.0543642225886546	70.00742433118674	0.09984207889200099
3	1	151	6	1795407676357921	1795407676411478	0.8151	5.3695	0.03372993	0.0996	24	USED	0.01292303114145706	70.00742806895161	0.09984228518842488
3	1	151	8	1795407676381746	1795407676411478	0.5281	1.0351	0.01562425	0.0996	24	USED	0.00421332851974129	70.00742679705203	0.09984248425598682
3	1	152	1	1795407676411953	1795407676507737	0.7707	5.3564	0.03553835	0.1008	24	USED	-0.056418146295188244	70.00739749650612	0.09984264288128489
3	1	152	6	1795407676467965	1795407676507737	0.5917	5.1638	0.06038466	0.0996	24	USED	-0.03025265816054359	70.00741726519186	0.09984286672621302
3	1	152	8	1795407676482345	1795407676507737	0.7777	2.6874	0.01788495	0.0996	24	USED	-0.030897566788321805	70.0074032895811	0.09984304746266784
3	1	153	2	1795407676532195	1795407676650955	0.7337	3.3562	0.02535765	0.0996	24	USED	-0.028042103312184832	70.00740023488389	0.09984324395628154
3	1	153	5	1795407676571055	1795407676650955	0.9313	5.1443	0.02356105	0.0996	24	USED	-0.0035352806123989744	70.00739988290862	0.09984344434913821
3	1	153	8	1795407676606819	1795407676650955	0.8911	2.0349	0.01035423	0.0996	24	USED	0.001242713685289634	70.00740109928628	0.09984364142395138
3	1	154	0	1795407676621760	1795407676738106	0.7774	1.3251	0.0084568	0.0996	24	USED	-0.07315488602080061	70.0073252570591	0.0998437273193902
3	1	154	4	1795407676673822	1795407676738106	0.7745	3.0835	0.02106407	0.0996	24	USED	-0.01333900320966754	70.00732056779599	0.09984392145351546
3	1	154	6	1795407676699807	1795407676738106	0.8907	3.8368	0.02017503	0.0996	24	USED	0.03306860764318883	70.0073349050432	0.09984414303688542
3	1	154	8	1795407676715345	1795407676738106	0.5962	4.8042	0.05388596	0.1008	24	USED	-0.05834560328822005	70.00735600011218	0.09984437437036738
3	1	155	3	1795407676774726	1795407676845118	0.7681	5.8973	0.04104792	0.0996	24	USED	-0.012502847177944441	70.007354934509	0.09984457373111867
3	1	155	5	1795407676808452	1795407676845118	0.8113	3.1823	0.01961031	0.0996	24	USED	-0.01583620714430626	70.00734730923232	0.09984476362736555
3	1	155	9	1795407676841112	1795407676845118	0.8537	2.0854	0.01175364	0.0996	24	USED	0.0074220543047750056	70.00735404361991	0.09984496866042458
3	1	156	0	1795407676863204	1795407676951213	0.911	4.8287	0.02332292	0.0996	24	USED	-0.0008116746101422669	70.00735386483085	0.09984516929944356
3	1	156	4	1795407676901241	1795407676951213	0.9651	0.8288	0.00341787	0.0996	24	USED	-0.024077420477843215	70.0072888910831	0.09984523181399524
3	1	156	7	1795407676924191	1795407676951213	0.665	1.8254	0.01734042	0.0996	24	USED	-0.0025755343993072947	70.00728901587877	0.09984543289009994
3	1	156	9	1795407676948086	1795407676951213	0.7732	4.9444	0.03337477	0.0996	24	USED	-0.028869246197445634	70.00728492054355	0.09984562787767277
4	2	150	9	1795407676283327	1795407676295526	0.7276	1.8826	0.01814861	0.0996	24	USED	0.2004012240933868	69.99287870442296	0.09960350843769311
4	2	151	3	1795407676332917	1795407676411479	0.6411	5.6966	0.0748969	0.0996	24	USED	0.24933657838723244	69.99287759371553	0.09960370817568137
4	2	151	5	1795407676345686	1795407676411479	0.6191	5.1302	0.07148822	0.0996	24	USED	-0.016773628224486758	61.781005722212086	0.7375651231055569
4	2	152	0	1795407676394294	1795407676537734	0.5723	2.4938	0.03893385	0.0996	24	USED	-0.047129295460415416	62.15183481207478	0.6495055849204847
4	2	152	1	1795407676410951	1795407676537734	0.9807	4.8512	0.02670054	0.0996	24	USED	0.026595441768170434	61.898920578394375	0.5291060549926135
4	2	152	5	1795407676459155	1795407676537734	0.8125	3.9779	0.03169126	0.0996	24	USED	-0.019825815049280014	62.020566720133964	0.4758088236007752
4	2	152	9	1795407676508275	1795407676537734	0.534	2.1776	0.03960969	0.1008	24	USED	-0.017598778466859748	62.079095740614584	0.4540531268066617
4	2	153	0	1795407676524335	1795407676631008	0.89	1.9589	0.01360737	0.0996	24	USED	0.04302106219171817	61.8636026645394	0.41603042076350255
4	2	153	4	1795407676554742	1795407676631008	0.8112	3.3017	0.02533707	0.0996	24	USED	-0.06187938115291926	62.105903481087296	0.39164052738647287
4	2	153	7	1795407676585292	1795407676631008	0.5374	5.3316	0.09547904	0.0996	24	USED	-0.017571300526957503	62.145055877186664	0.3802947845330848
4	2	154	0	1795407676635392	1795407676738105	0.7193	2.4092	0.02482997	0.0996	24	USED	-0.004411843965505861	62.15782533876015	0.3647172445802178
4	2	154	4	1795407676676351	1795407676738105	0.4703	1.3061	0.02899055	0.0996	24	USED	-0.044675336884593325	62.22941175901002	0.35770857932319017
4	2	154	5	1795407676684543	1795407676738105	0.5798	5.218	0.08568942	0.0996	24	USED	0.04239996615351942	62.14545685098359	0.34855053365118016
4	2	154	8	1795407676722459	1795407676738105	0.7994	4.0988	0.03328597	0.1008	24	USED	-0.028538723803022133	62.221386113698145	0.33552527248064945
4	2	155	2	1795407676776342	1795407676845117	0.9397	5.0612	0.02974337	0.0996	24	USED	-0.0005252097169298557	62.22287980395331	0.32140650194245896
4	2	155	6	1795407676803404	1795407676845117	0.5346	0.5997	0.01056773	0.0996	24	USED	-0.03993643251909305	62.278809573567656	0.31604873310904846
4	2	155	7	1795407676810668	1795407676845117	0.7228	2.0215	0.02131828	0.0996	24	USED	0.0327806718780313	62.21621039740139	0.30826706216320476
4	2	156	0	1795407676857122	1795407676959904	0.5232	3.6284	0.07334637	0.0996	24	USED	0.05747369315937223	62.146232876904634	0.3040199218497065
4	2	156	5	1795407676909743	1795407676959904	0.5857	4.017	0.05714678	0.0996	24	USED	-0.08462411699867188	62.26024252991954	0.29916158581843133
4	2	156	6	1795407676914720	1795407676959904	0.6408	5.1173	0.06205373	0.1008	24	USED	-0.06894015898056545	62.359937554869795	0.2939400572014005
\.


--
-- Data for Name: contacts_20261124; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contacts_20261124 (whisker_id, boot, seq, "position", t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) FROM stdin;
\.


--
-- Data for Name: contacts_default; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contacts_default (whisker_id, boot, seq, "position", t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) FROM stdin;
\.


--
-- Data for Name: epochs; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.epochs (fleet, epoch, owner, holder, began_us) FROM stdin;
f	1795407659415	sfa7cd17ef69a562fa8991c0440d050f9	vm	1795407659414839
\.


--
-- Data for Name: health_changes; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.health_changes (health_change_id, whisker_id, recorded_us, kind, was, becomes) FROM stdin;
1	3	1795407664530630	CONDITION	LEARNING	HEALTHY
2	2	1795407664530630	CONDITION	LEARNING	HEALTHY
3	1	1795407664530630	CONDITION	LEARNING	HEALTHY
4	4	1795407664496596	CONDITION	LEARNING	HEALTHY
5	6	1795407664496596	CONDITION	LEARNING	HEALTHY
6	5	1795407664496596	CONDITION	LEARNING	HEALTHY
7	2	1795407676411478	CONDITION	HEALTHY	SUSPECTED
8	4	1795407676295526	CONDITION	HEALTHY	SUSPECTED
9	2	1795407676951213	CONDITION	SUSPECTED	TRIMMED
10	4	1795407676959904	CONDITION	SUSPECTED	TRIMMED
\.


--
-- Data for Name: journal; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.journal (fleet, number, entries) FROM stdin;
f	37	\\x01000000000000005906c9ece960060001010000000000000098000000000000000a000000000000007f89c7ece96006002497ff907efbe23fe5f21fd26f1f13405505590520a4ad3f20d26f5f07ceb93f0000000000003840000002003190c7ece9600600d3dee00b93a9e83f772d211ff46c154049f201261532a23f20d26f5f07ceb93f0000000000003840000001003dd3c7ece960060033c4b12e6ea3dd3f77be9f1a2fddfd3f0eeeb53dcd0ba43f20d26f5f07ceb93f000000000000384000000000f2f6c7ece9600600105839b4c876de3fd8f0f44a5986f93fde19d07fcd419d3f20d26f5f07ceb93f0000000000003840000001009610c8ece9600600fb5c6dc5feb2e13f4694f6065f180d40a7b758b4ad24b03f20d26f5f07ceb93f000000000000384000000000e329c8ece9600600cac342ad69dee93fd881734694f6f83f777b5a8f0c83833f20d26f5f07ceb93f000000000000384000000200fd6ac8ece9600600e561a1d634efe23fd656ec2fbba71440c399c2f7bceaae3f567daeb6627fb93f000000000000384000000000159dc8ece960060046b6f3fdd478e13fe71da7e848ae0d40d41b205ef83dab3f567daeb6627fb93f00000000000038400000020029a3c8ece9600600a52c431cebe2e83fc7293a92cb7f0540fdc45cad6e50923f567daeb6627fb93f000000000000384000000100e0c7c8ece96006001d5a643bdf4fe73fbbb88d06f0961440b7a351e4bd28a73f20d26f5f07ceb93f00000000000038400100000000000000cb35cbece960060001010000000000000099000000000000000a000000000001004e29c9ece96006006519e25817b7dd3fd734ef3845c70d40016d482fac13b53f567daeb6627fb93f0000000000003840000000009145c9ece960060073d712f241cfe23f5f984c158cca0340a38b76aab67a9e3f567daeb6627fb93f000000000000384000000200e365c9ece96006000a68226c787ae73f7daeb6627fd90a40dd4bd0155bf7993f567daeb6627fb93f00000000000038400000010069bfc9ece96006009b559fabadd8e53ffaedebc039a308400f7fc99d04fca13f567daeb6627fb93f00000000000038400000000085c2c9ece9600600af946588635de83fb84082e2c7d81540af3d375de4d8a33f567daeb6627fb93f000000000000384000000200affdc9ece96006003e7958a835cded3f4f401361c39314406872d64c6320983f567daeb6627fb93f000000000000384000000100db1acaece96006000f0bb5a679c7e53f1d5a643bdf4f0440eeb21d5be8ad9a3f567daeb6627fb93f0000000000003840000000002d88caece96006006de7fba9f1d2e53f4772f90fe9b7eb3f2f615daa0cc2803f20d26f5f07ceb93f0000000000003840000002006389caece960060032e6ae25e483ec3f0f0bb5a6794700403556cd399934853f567daeb6627fb93f000000000000384000000100c9bdcaece96006004b598638d6c5ed3f053411363c3d0d40c9db19bf5375953f567daeb6627fb93f000000000000384001000000000000001de2cbece9600600000100000000000000a333ccece96006000201000000000000001d32ccece96006000300000000000000567daeb6627fb93f9a9999999999b93f00000000010020d26f5f07ceb93f9a9999999999b93f000000000200567daeb6627fb93f9a9999999999b93f000001000000000000003a8accece96006000101000000000000009a000000000000000a00000000000200c0c3caece9600600ff21fdf675e0e83fa4dfbe0e9c33f53f68356e7bcc51813f567daeb6627fb93f00000000000038400000000088f1caece96006006c787aa52c43e23f75931804560e0240bb62678664339d3f567daeb6627fb93f000000000000384000000100fd33cbece96006009c33a2b437f8e03f52b81e85eb510e40a3fb62842a14b13f567daeb6627fb93f000000000000384000000000864fcbece96006005f29cb10c7baec3fb22e6ea301bcfe3ffb67382bc334833f567daeb6627fb93f0000000000003840000002001e8fcbece960060062105839b4c8e83f5eba490c02ab0840832615cfd191953f567daeb6627fb93f000000000000384000000000c7b5cbece9600600e09c11a5bdc1ed3f12143fc6dcb5fa3f459249db32bf7e3f567daeb6627fb93f0000000000003840000002009ff4cbece9600600aa8251499d80ec3fa857ca32c4b10e4025eb2e58c3a8943f567daeb6627fb93f000000000000384000000100fe09ccece960060045d8f0f44a59ee3f52b81e85ebd10d40eb1240f706db933f20d26f5f07ceb93f0000000000003840000002005131ccece9600600a301bc051214e33fd6c56d3480371340aebed3c7f096ab3f20d26f5f07ceb93f0000000000003840000000002f45ccece9600600fbcbeec9c342e13f0ad7a3703d0af53f2019dd0741c3923f20d26f5f07ceb93f000000000000384001000000000000003e2cceece96006000101000000000000009b000000000000000a00000000000100dc60ccece9600600e8d9acfa5c6de93faf25e4839e0d144008c4d25d65afa33f567daeb6627fb93f000000000000384000000000eabbccece9600600d26f5f07ce19ef3fce1951da1bfc03402e10b17fa677843f20d26f5f07ceb93f000000000000384000000100c1efccece9600600a5bdc1172653ed3fba490c022b87174032d139a2ef2ca13f567daeb6627fb93f0000000000003840000002004619cdece9600600dcd781734694e83f9fcdaacfd5961740be09f0a33b04a53f567daeb6627fb93f000000000000384000000100c972cdece96006008e75711b0de0e13f6b2bf697dd93eb3f3ea16c04c1678c3f567daeb6627fb93f000000000000384000000200049dcdece960060067d5e76a2bf6e93f857cd0b359750940fa2a75a0b914943f567daeb6627fb93f000000000000384000000000c6a2cdece9600600fc1873d712f2ed3ffdf675e09c9111409e18e5dbb395943f20d26f5f07ceb93f00000000000038400000000013afcdece960060007f0164850fce83f029a081b9e5eed3fc2de6166e1e37a3f567daeb6627fb93f000000000000384000000100fedbcdece9600600f0164850fc18df3f3a234a7b832fcc3f236958088232733f567daeb6627fb93f000000000000384000000200981cceece9600600e10b93a98251eb3f90a0f831e6ae00407a8b45db4a12883f567daeb6627fb93f00000000000038400100000000000000d5b1cfece9600600000200000000000000867bc9ece960060001020000000000000098000000000000000a00000000000000364bc7ece96006008e06f0164850e23f4f1e166a4df30340592cea3823efa33f567daeb6627fb93f000000000000384000000000478cc7ece96006008bfd65f7e461ef3fba6b09f9a0671340c19757e862579b3f567daeb6627fb93f0000000000003840000001002abcc7ece96006004f401361c3d3e13f931804560e2df33f2351263d254a933f567daeb6627fb93f00000000000038400000020030cec7ece96006001283c0caa145e23fb459f5b9da8a0640dff069eb33a9a13f20d26f5f07ceb93f000000000000384000000100cd2ec8ece96006007b14ae47e17ae23f158c4aea04340640331e42e8e267a43f567daeb6627fb93f0000000000003840000000009348c8ece9600600000000000000ea3f3411363cbdd20f40b0be893ad639a03f567daeb6627fb93f0000000000003840000002001788c8ece9600600448b6ce7fba9eb3fb6f3fdd478e90d409435a8054897933f567daeb6627fb93f0000000000003840000001005b9fc8ece9600600da1b7c613255ee3f4703780b2428054070d743e2bb208c3f567daeb6627fb93f00000000000038400000020018e8c8ece960060085eb51b81e85e93f69006f8104c5d33f4ec27dcb3904603f567daeb6627fb93f0000000000003840000000007308c9ece96006004a0c022b8716e13f24287e8cb96b01409c344fa6b847a43f20d26f5f07ceb93f00000000000038400200000000000000e0e7caece960060001020000000000000099000000000000000a000000000000002f47c9ece96006007b14ae47e17aec3f8126c286a757ff3f3c9a13492ede8b3f567daeb6627fb93f000000000000384000000100706ac9ece9600600d95f764f1e16e23f1b9e5e29cb10144072188a434f2db33f20d26f5f07ceb93f0000000000003840000002005b87c9ece9600600da1b7c613255ee3fb537f8c2646a1240609c6cc15ace943f567daeb6627fb93f00000000000038400000020014a0c9ece96006003d2cd49ae61deb3fc8073d9b559ffa3f9f166aeac8d3823f567daeb6627fb93f000000000000384000000000f6bdc9ece9600600857cd0b359f5e93f27a089b0e1690a400b191bfcf5f1993f567daeb6627fb93f00000000000038400000010074ffc9ece960060088f4dbd78173ea3f083d9b559fab14403296023529c3a23f20d26f5f07ceb93f000000000000384000000200a427caece96006004ed1915cfe43ee3f696ff085c954ff3f829d309bdfb4813f567daeb6627fb93f0000000000003840000000004c35caece960060051da1b7c6132e13f166a4df38e531540cbe3407a5071b83f567daeb6627fb93f0000000000003840000001002f79caece9600600228e75711b0dec3fd93d7958a8350e40a26acbeb4e98983f20d26f5f07ceb93f00000000000038400000020029a4caece9600600fb5c6dc5feb2e33f1895d409682214404f3a36a73748ad3f567daeb6627fb93f000000000000384002000000000000001de2cbece9600600000200000000000000398accece96006000102000000000000009a000000000000000a0000000000000000f9caece9600600dc68006f8104e73f832f4ca60a46034026517114076d993f567daeb6627fb93f000000000000384000000100c7facaece9600600de718a8ee4f2e33f9c33a2b437b8164038a29ce41e7db33f567daeb6627fb93f000000000000384000000100f23fcbece96006001d5a643bdf4fe13f7dd0b359f5b90840fdfa9dfdb3acaa3f567daeb6627fb93f000000000000384000000200e483cbece96006005f07ce1951dae13f20d26f5f07ce00403ae1a970990d993f567daeb6627fb93f000000000000384000000000ff98cbece960060061c3d32b6519de3fbde3141dc9e5f43f6f7c92e0b2af9d3f567daeb6627fb93f000000000000384000000000ffb8cbece9600600cb10c7bab88de23fac1c5a643bdf14409f6183e8bdefb53f567daeb6627fb93f00000000000038400000010009bfcbece960060018265305a392e23f7ffb3a70ce88f23f1c721a3fe0c3913f567daeb6627fb93f0000000000003840000002005503ccece96006003bdf4f8d976ee83f3333333333b30b409f84466e552b9a3f567daeb6627fb93f0000000000003840000000001b4dccece96006004d840d4faf94e93f1361c3d32b651040309b21d1db0aa13f20d26f5f07ceb93f000000000000384000000100eb55ccece96006000f9c33a2b437e43fe0be0e9c33a2f13fdaa63eb1ca5c8b3f20d26f5f07ceb93f00000000000038400200000000000000f2dcccece96006000202000000000000005cdbccece9600600030000000000000020d26f5f07ceb93f9a9999999999b93f00000000010020d26f5f07ceb93f9a9999999999b93f000000000200567daeb6627fb93f9a9999999999b93f000002000000000000003d2cceece96006000102000000000000009b000000000000000a00000000000200b293ccece9600600711b0de02d90e03f4703780b2428ce3fa7bd356e39b06f3f567daeb6627fb93f00000000000038400000010099baccece9600600a4dfbe0e9c33de3fb37bf2b0506bf53f63c3689061999f3f20d26f5f07ceb93f000000000000384000000000961fcdece96006006ea301bc0512ee3f910f7a36ab3e1440b3f9b0c50b759e3f567daeb6627fb93f000000000000384000000200b61fcdece96006009ca223b9fc87e03f3e7958a8354d0340a95e861812a4a23f567daeb6627fb93f0000000000003840000001002f63cdece96006008048bf7d1d38df3f3a92cb7f48bffb3f219a50f31b47a23f567daeb6627fb93f0000000000003840000002000b7ccdece96006009f3c2cd49ae6e93fbf0e9c33a2b4f13f061e8c960bae7c3f567daeb6627fb93f0000000000003840000000004c89cdece960060096218e75711be13f8d28ed0dbe30e33f0194f1b588a4853f567daeb6627fb93f000000000000384000000000aca5cdece9600600c58f31772d21e73f79e92631082c0040f9bca08d75d4953f567daeb6627fb93f0000000000003840000001003ae5cdece9600600917efb3a70cee63f39454772f9cf1440f365b33401d0aa3f567daeb6627fb93f000000000000384000000200ee1aceece96006002e90a0f831e6e23f098a1f63ee1a1340bdf1fff4b061ad3f20d26f5f07ceb93f00000000000038400200000000000000d5b1cfece960060000
\.


--
-- Data for Name: leases; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.leases (fleet, epoch, owner, holder, commits, expires_us) FROM stdin;
f	1795407659415	sfa7cd17ef69a562fa8991c0440d050f9	vm	41	1795407679367680
\.


--
-- Data for Name: policies; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.policies (fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, change_margin, changed_us, changed_by, reason, action_id) FROM stdin;
\.


--
-- Data for Name: quarantine; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.quarantine (quarantine_id, fleet, robot, topic, boot_id, seq, received_us, quarantined_us, cause, code, payload) FROM stdin;
\.


--
-- Data for Name: redo; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.redo (fleet, number, rows) FROM stdin;
f	40	\\x0100000000020000000100000000000000011400000073696d2d33613763356539323431646165636564060000004f4e4c494e4500c723d6ece96006002800000000000000d6010000050097c1a206a201000000011400000073696d2d3361376335653932343164616563656401078abbd4e69e9d980301dfec910ce30601c9f6950bd107019fcda009b30601f18ea907a1040185f4b105d90601bfb5bb03890b0181e9c3018b06010000001400000073696d2d33613763356539323431646165636564a00000000000000000000000000000000000000000000000000001000000040000006c656674000100000000000000010000000100000000acbb3ddef801ca3f9d9be303383a50409a9999999999b93f0b0dbe3e312fa83f00000000000000000000000000005593af1f0fafd23f00000000000000000000000000000000000000000000000000000000000ad7a3703d0ab73f0000000000000000000000000000000000000000000000000ad7a3703d0ad73f0000000000000000000000000000000000000000000000007c14ae47e17a843f8e774b3a3cc5ed3fc5ebde4510feed3fcd6f357e2c3eee3feaa3e16af47fee3f344b0dc32cc0ee3f654ecfd6fafcee3f935380145335ef3f194a2d7ca468ef3f65b20259a696ef3f178cf3bc39bfef3fb3afc5a056e2ef3ffcffffffffffef3f000000000000000000000000000200000000000000010000000100000000000000000000000000000200000000000000011400000073696d2d36646261313530383966333464656330060000004f4e4c494e45001424d6ece96006002800000000000000d7010000050097c1a206a201000000011400000073696d2d366462613135303839663334646563300107a6b6d4e69e9d980301c9c0910c83060197cf940b870701ffa49d09cf0e0187c1a607df090195abaf05d10601e1a1b703a50e019d97be01c304010000001400000073696d2d36646261313530383966333464656330a000000000000000000000000000000000000000000000000000010000000500000066726f6e74010100000000000000000000000000000000f7f2d7963135c73f4d620d6f122e4f409a9999999999b93f02d8a52c285b983f000000000000000000000000000046852af5e9cfd23f00000000000000000000000000000000000000000000000000000000000ad7a3703d0ab73f0000000000000000000000000000000000000000000000000ad7a3703d0ad73f0000000000000000000000000000000000000000000000007c14ae47e17a843fa4913f9c89f4ec3f0a4019abbe3ced3f07c2b7545092ed3fcdec5ae71ceced3fd0bb2452d044ee3f7deb68aa4e99ee3fef790cd2cce7ee3f67627b45492fef3fc8acba4d3b6fef3ff2ac1bb761a7ef3f07ef4c33a4d7ef3ffeffffffffffef3f0000000000000000000000000001000000000000000100000001000000000000000000000000000006000000010000000000000000000000000000007b82a827ea7f51402f1fca14d18eb93f070000004845414c5448590001567daeb6627fb93f9a9999999999b93f1502000000000000018a1dd5ece9600600000000000000ac0300000000000001010b6e677579656e2d32303231010181f6e042c19a0c81b51801a1940c0081f6e0424db0413df2959b3d60c89fb7e2e4f2b584e95537431d9d3683e49236e2e24ab21c95db38c0591136d89a0eb301830836596f6fae6e9a552f99ed5a3f3008ff4346c6bf41baf1f4404628773f1763973d20fc033ace83c439eca90a3dc45485413dd34c3dbd53333d556bc1421d4412429624604153926c42df0fd54201b325436b195242e30fc0cccc1ccc0ed6926c3d24ce11bd411f803f528f0839045c4fbd3c16949d3d930c803fa6af1db8240bcc3f40c47bd83fa0311042671a283b7c9d6e0542233ebbc08c08f9425e39d53c4015ba15411b916240f14a8042a3669e3b7190d81ec4d6d247c49eb765c1e77dd742ff028d7a65c5b686c4c5df4c40c39bcd834300533624d2c3c19102c4dfa8ffc07ad8a242f61da83f72da4747530d29c3e3d35c4087be8f464ff5574301e1783f7e2f664cae201b45e215ee3db103eb4e7e9324473dbd7b3dadba944ddc983f46db9e653ef7e13754e6c6a2c7370ea83de21ce356f8ca07c7eb45ad3db74ee35629b0764755f9b03e4a639253643ad4c8df47e63e1565dc3eab1c604109ee63b997cb4b4a08827c4437faab48001e91e6d3ece9600600024a28fd3c16fb4b3ebbac1e00000000fb4a8441031f1243763ffe8b09410000a842d26c1b3ffff0853f0000a642bd99c53ed6f7333e0080a742000000000000000000c0a642000000000000000000c0a642eee20300000000ffbc8541051f82a6ccbc79f4f2420000a64298c6ff3fb08008420000a6421ffe70becdde32400000a64260b6febd75d1dd3d0040a642e24de5bc7a50c13c00a0a6420000803fd81501419394413f6fa07c387efae4340000504111e5aa355b61123f91073f383f4c79318fc7f508a0abcd3daa8610415e98cc3d090102da4dcd3d6c7208414ba6e9ba2000f7ff6200c9ffa500d4ffe800deff2b01d4ff6e01cfffb101d1fff101d0ff000000ff0005108afeff8a906200f8901501ef8ea801c78eff00be8b3c019d89faff7f8cc300a58d0602b08e1b01c48b8a019789b800788f6000de8f2200db8c9900ac8fce00e2010200a5f80700808146b643003d92b00c0000e246c5b9043db1af0700408f46dc8f243df2f00d000018475e430f3de1ee0b00800947fc6bdf3ca8d10c00401d47d38c5e3dd6ed09000004470140483dc7ce0a00c01147b7b26f3d9baf0b008027470d905e3d8cf10800c006477bb46c3d97d00e000066473dac803deba7050000a4466fcea63d95048a1dd5ece960060017e8e247b5000000018598c801017f0100008800000000000000282982fcc27770bfecf2d6268ebfe43f0aebeabd63d6e13ddb9bb55090741340452575029a6377402443d84e65bde140b1b20c71aceb4940000000000054c84051ff8b428976cc3d00249c0700017f0100009600000000000000519f6bbf28c56cbfe6dbdbd843e5e53f0aebeabdc876fa3d7f733a23d3fb13406d9a779ca207784032437efbe437e240ccd85f764f9e4a400000000000fcc84051ff8b428976cc3d00020000000000000001000000000000009d9be303383a50405593af1f0fafd23f070000005452494d4d45440001302aa913d044b83f0b0dbe3e312fa83f0b02000000000000018a1dd5ece96006000000000000008f03000000b20200010200020b6e677579656e2d3230323181e1eb170181f6e042c19a0c81b51803a1c90b000b0dbe3e312fa83f0281f6e042025d4b3dfd33bc3d099f9abd686950b7b24b373b6c3970363272bd365d5f62b249a33d3b8cffa135671906b31eed9e379b8a75b0e2d2802f872a703f6026e64300000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000cccccccccc000f0000000000000000000000000000000000e688efcfbdbab0060000000000057782410000c908783faf5dd340503332bf34d17e3f9045d6bdc8c9793c4e1955bd5acd333b00000000000000000000000000049e83410000803adbbc99fdfc4233b716405b58f44104bb8cbfaf6a8540a2ca443e62b92c3f50c3713c22c2993c0000803fc9d88541d760e740fd5c4dba1e51b33400006041730ce137e81f5142979cb9bb0fbe2435000000ff0003108a00009389b3ff8688c900778e9200d48881007690b601fd8f0602ef897401808c7601bc883b027f8aa000948cb701bc8a68019d8f7a00eb8ec501e489a9018c030200a6f6040000234601eae93bb9f1090000b1468dfe283deece0a0000d546204efd3cb6d2080080ba46fc734b3dd4b10d00401d47d7bc133dad8e0a0080f9461ab5323df08f090080ec462129493da5d00b00801f472c79733db68f0a00401247178f7d3ddbd20b00802f47cab5823d98900b00002e47febf8e3db88503000047465552a73d8b048a1dd5ece9600600713a4f4700000040a06ba93f000000a07f86b73f0b0dbe3e312fa83f00000100000000018e774b3a3cc5ed3fc5ebde4510feed3fcd6f357e2c3eee3feaa3e16af47fee3f344b0dc32cc0ee3f654ecfd6fafcee3f935380145335ef3f194a2d7ca468ef3f65b20259a696ef3f178cf3bc39bfef3fb3afc5a056e2ef3ffcffffffffffef3f97c1a206a2010000000000000000000001000000000000001400000073696d2d336137633565393234316461656365640b0dbe3e312fa83f7b14ae47e17a943fadcacfece960060027a190ede960060000000100000000018e774b3a3cc5ed3fc5ebde4510feed3fcd6f357e2c3eee3feaa3e16af47fee3f344b0dc32cc0ee3f654ecfd6fafcee3f935380145335ef3f194a2d7ca468ef3f65b20259a696ef3f178cf3bc39bfef3fb3afc5a056e2ef3ffcffffffffffef3f022d4feeece9600600012d4feeece9600600b5000000018598c8010175010000890000000a0000006f0e1c90a6ab5e3f06d8e0764aebeb3f5a3bd5bd2f25543e2f6d84c4a3dc124088d2dee00b2d77406f89af758db5e140f31b7c6132f54940000000000060c840c0d181427978953e00249c07000175010000960000000a0000006ac406c550375d3fb979bd8f8b4fec3f5a3bd5bd2f25543ed634cf5f6b661340daf97e6abcb67740baf0a6714d27e24022ce1951da9b4a400000000000fcc840c0d181427978953e0003000000000000000200000000000000dbd8310e7680514074041d9b9a8fb93f070000004845414c544859000120d26f5f07ceb93f9a9999999999b93f1602000000000000018a1dd5ece96006000100000000001804000040b002000201010b6e677579656e2d3230323181c2d72f0181f6e042c19a0c81b5180181a70c0081f6e0423f064a3d0a12923d99dcd738b7cd07b7ec1563371a6d87364f2f913635506bb2681b1e39eca20f36b20822b3d9820836da5e672ff9467a2f12ff873f44510044d070034232348241282bf24002af223f3f130f3b3cdfd23933942e3d53a72f413b192f3df68b4a3d0c97ac423984084248e0e941927371437c11cf4357467e4294accb41e10f00c0cccccc0811231d3d583bbebb2b01803fa433e9b780036b159f43c15d2543709ec043a3c2403e148f63783f629ed93e3704a041bed5a039007c9e6d12c415b313c5e13591c1bfd7dd4280034c81adc51a7939c630891ec3baed8c4326e219a9c2db8949c3ea9e33bf233516420a3e2ec4c00039e1bfe1f1bdbc3ddc1f414b12e73f8c9ab0461c4a4dc382b71b40c89cb046c6574dc3ea52eb3ffe9ab046ab684dc3f2ddfa3d861eb250cd05b0473089823f0869fd4aa61b44c4f0be843fb269fd4af13d44c41f37aa3fce02a954bdfc42cae900093f8858d856f1c905cb716c6b3f6ba2ce5180a2c7c86eba803f9443474e1fa2be454a97133ea8b27c3e56000041d3225eb9057fe148b5a4c7c36d92a7476c7ee14830b3c7c32d92a7471975e148b8c7c7c3168ca747001eb651d2ece960060006f0a20f3f87851a3f85d91100000000fb4a8441031f57d402bdc0ef17410000a6426b26d23b2a28b83d0000a74200000000000000000080a64200000000000000000080a64200000000000000000080a642bce1140000000056198641061f1888793f02f2d4420000a842370a6f405dfff3410000a842e9c39d3fa05804400080a7421ebdb03e06bb8e3e0080a6425dedef3da44eb53c0060a6420000803f63807c417821bf40a6384a39f7921735000050418ca3ad37f5b20e42b4fa963a73bd1f33e398bc0132b7cd3dfb9fa23ff163cc3d020101bdf6cc3dac2b3f3f72f06fbb0f000000000000ff0008108ca100cf8c0d01da8dfc00e88dac00f68aac00aa8b6000c5884700858989ff9d8cc501d0889a018a874c007d89b8009a8a8200a48d2d01f187ad017d8df100ee010200d7b90600801846af30823ce2b209000077467854083dabaf0a00809246b3a4553dc9d00c0000c74601c9063d9bd00c00c0d546f47e473dbaaf0c00c0d9461ead5f3d92900d00c0fe4654aa3a3d88900e00200c47f99b553dc3cf080080b84683f35c3dd0ef0b00400247fc397e3dc8900b0000fc469083873dcce90400006746da0d853d96048a1dd5ece96006000773b8479a9999999999a93f03000097c1a206a2010000010000000000000002000000000000001400000073696d2d336137633565393234316461656365649a9999999999a93f7b14ae47e17a943f9c20d6ece96006000fdb94ede9600600030000001ca5f4ece9600600011ca5f4ece9600600b5000000018598c801018001000089000000000000001be803fde369463fa00ae0df40e3ea3fa968fcbde505da3d814ed2e1434e13409db20c71ac737740b9cf935836cfe140d55b2041f1034a4000000000006cc840b0038c42d57ccc3d00249c070001800100009600000000000000e764013025e7473f9a19c9385581eb3fa968fcbde505da3da4c515674fb913403ba2b437f81478401e2b6655f640e24006ecc03923aa4a40000000000008c940b0038c42d57ccc3d00040000000000000000000000000000004d620d6f122e4f4046852af5e9cfd23f070000005452494d4d45440001302aa913d044b83f02d8a52c285b983f0b0200000000000001261bd5ece96006000000000000009a03000000b202000001010b6e677579656e2d32303231010181f6e042c19a0c81b51803a1c90b0002d8a52c285b983f0281f6e042fe4a3d3d84ac893d1eb1ecbd39d7d6357abcbe3b42eb2336b796bc36267e45b2f2c6c13b4f1b3735d177fab2132ba1376661f5b02e8f702f5695733f138ed84300000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000cccccccccc000f0000000000000000000000000000000000a8bbefcfbdbab00600000000004db2824100009a52763fd584d54089f3c53d19c8f53f09cd75bc09cd753975917cbc75917c39000000000000000000000000009274834100005238793fe26fd4422d3f58bf53333b42f1d696bede117a40891edebeacb3a63ea2ad3dbdd0929e3b0000803f0de387411662ed40e7fab9bac8866435000060412683e637c31e5c428a742cbc971c0736000000ff010d2c7e3decc0a340780b243f00000006108afd00928ac400998908018c8adbfe9b891e00848be100ad8a02009b8e4e00db882c00818a9b00928fb400f68d8f00ca8b4800a38c9500b68e3601de8ed5ffe1030200f2b70500802d46432c543cbc910600805e462b59063dc5b10b0040e34639e7373dfbaf0c00c0024711fd223dc8b1070000a646574c3e3d9a8f080000cb467232263dd1d00b00001a47ccef523d8aae080080dd46da18503df1ee0900c0094709be833d87d10c00003d4701eb4f3db2b10900c00d47cc1d733d80a70400808a46bde4923d8b04261bd5ece960060037b75347000000c05fa9a73f000000809035b13f02d8a52c285b983f0000010000000001a4913f9c89f4ec3f0a4019abbe3ced3f07c2b7545092ed3fcdec5ae71ceced3fd0bb2452d044ee3f7deb68aa4e99ee3fef790cd2cce7ee3f67627b45492fef3fc8acba4d3b6fef3ff2ac1bb761a7ef3f07ef4c33a4d7ef3ffeffffffffffef3f97c1a206a2010000000000000000000000000000000000001400000073696d2d3664626131353038396633346465633002d8a52c285b983f7b14ae47e17a943fa0eccfece96006000ea7a2ede96006000000010000000001a4913f9c89f4ec3f0a4019abbe3ced3f07c2b7545092ed3fcdec5ae71ceced3fd0bb2452d044ee3f7deb68aa4e99ee3fef790cd2cce7ee3f67627b45492fef3fc8acba4d3b6fef3ff2ac1bb761a7ef3f07ef4c33a4d7ef3ffeffffffffffef3f022071eeece9600600012071eeece9600600b5000000018598c8010175010000890000000a00000034ce3bfe4a8d673fb57faefd42b2f13ff3cae3bdf926b13ebf4ff83bfa8412404a9d8026c25f7740183a96ee66aae140f71b7c6132f54940000000000060c84093707942507f963e00249c07000175010000960000000a000000bb6e3f7b979a683f0af9693c3942f23ff3cae3bdf926b13e774afcfe90e71240eec9c342ad02784095085e5b261ce24029ac1c5a649b4a400000000000fcc84093707942507f963e000500000000000000010000000000000059768506aa3f5040335537e6f498b93f070000004845414c5448590001567daeb6627fb93f9a9999999999b93f160200000000000001261bd5ece9600600000000000000cf030000000000010200020b6e677579656e2d3230323181e1eb170181c9fe3dc19a0c81b51801a1940c0081c9fe3d5c77583d9d86983d7e4fa9b8af820a374d405f37e276eb35e7bba336d7442fb24862e138ba241936ffd1deb2f8d41e363b165d2e7002612f7a396f3fa4d5fa43f1796c43880e40430dc8774276a2013f4ea7103b55e3dd3920ad233db18f3f40818b713c2896373defb0d743d7429c436279804392ef844105fc544241529243316ea843e30f11c0cccccc15ca98a33ddfa20cbefdc07f3f092ff738163d94ad3dba3be6bd85be7f3f1985dd38800366948943d2d3bcc1dd60be436509743ec00127b98942efa245c2052c3f434342c13d3f7602ef40611758c199a47b4252215b3c39d1458bc2d4971e434df6ed3f57c359428003febe95c43023b3c558b0924223e976438a01b0796340a26f6543f0ae1441206be64251acd783c11ab38343f9725c405d7e9242ebe8d3400b2d874781d622c4b4e78f41b72e87473af922c43b801e414a457d4768d71cc45da50d3fba45d9506a82a9c73454313fcbeea84fc0a28ec733d52c40573d6e4daca5afc698b9383e7d0e0853b328ae4975a64e3e715bef56a9689eca8f32c43f1be017551b93424ad3e93440016fdd534d8af34958ae413fc5bb23bf91eca7416a04043b7221563f7ce446bf98eaaf41e2bd0b3b509f264b5d1eabc5c17f364968a0264bee52abc54c81364965af104b4d3a98c52b03274900162989d3ece960060004768a253e16fbcb3ea9841b00000000f93c8441031fb1ea753f1834d3400000a84212f1603ff540893f0000a8429310eebd6baf763c0080a64222cc54bd3d8c333b0040a642000000000000000000a0a642f4ad0a000000006bf98541061ff3a800bd0879f9420000a642faec26bfc57044420000a64272d5d1bebe592b400000a64262cdd23e4e62183f0080a7425b851b3c33f2c23c0020a742cbaced1026fecc3d302a8b412c6dcd3d090104560ecd3dfe188741a6b2a1394400faffcb00fdff4f01eaffd201eeff5702ebffdc02f3ff6203f8ffe503f2ff000000ff000c108a4400908ee300d38f3b01e08ba8019f8adf008a8a2901948b7300a188be017889ee007c8d7401b68be0019d8cc9ffb3904202f9886f01798db401c58e3401db0102009c99040000f9456f7de63bdbf20b0080c546c165c63cb8b0090000b046eafa2b3db9f0070000a04634b72b3d83910b0000f446b7046a3d93ce0c0080124730825b3d80cf080000d54695f4863db4b00d00802f476388603dc4b30c00c02a47b642703de4b10c008030476c6c7d3dc58f1000c06e473ac48b3dbdc804008087468bd4973d9604261bd5ece96006006f85bc47b5000000018598c80101800100008800000000000000b5fe0beb5cfc5a3f5b7776d46e0ae63fb90fdebd3d5de73d46c7df11754015404ffc1873d72578403ed4f10dbf80e040e21951da1bfc4940000000000060c84050fd8142a7c7cc3d00249c0700018001000096000000000000003b8ca59fce855b3f9c888f0673b0e73f988a1fbe3d5de73d1e9a783852021640b4f3fdd478bd78400d9ce7f67ef2e04052234a7b83af4a40000000000008c94050fd8142a7c7cc3d0006000000000000000200000000000000f8e64324857f514091116c10d293b93f070000004845414c5448590001567daeb6627fb93f9a9999999999b93f150200000000000001261bd5ece9600600000000000000e10300000000000201010b6e677579656e2d3230323181c2d72f0181f6e042c19a0c81b51801a1940c0081f6e0428f361e3dd7ec8b3dd3aae0b886dd4c36e7a95737d1723d36542e9136cd2a53b29b33f33897910f36d0dd01b39abe0836ff55d52db975682f87d3883f856dd643d492cc43dd6a0f4114a8fd3f76bc2b3d7ba7453ae2b21c3a182e663d22396f41270b443f91adb23d3a2df242ff2e12423cd1c841f5c3a14279f4264375c99742c5411f42e70f20cccc1cccd40295e7a53f2fbb2a3faf8c7e3f84b4483a029862f13b4cf4e53bfcfc7f3f5b314f37071a9ee03ca06c313d72f47f3f708a92b6ff02d7898b43768ce6426ad5be43db1d4b3e7d61bcee41e013fc40a3b0f9424275c43c2cb23f6b40c6df2140aeea2f4200d7863b70b8e1d5c394558741c2e84e4003e2d14251cdb66dc326e95042b54ae23f92409b42ff02f0c457c5ce1363c5d665fc41223689433fe7a310c39281f3414a028e3fc784734277f0bf400580c948142c9ec48b84933fd185ad46b78ac7c232b4fb3fe918cc455967c842f0a7ec3eab0fd0501d6481c78bab383effadca4e5273f7465baca53e2f45a74cae0ad945c130c23e10da4e54ae7148c9b44b903fef60a55344a136c9b577123e24dddd5657381d4a8796e73ea48e23539f44d9c8fb8559430301ac421d77a9435b6a313e01aea93d8f86883e69fbdf4030f28eb6e35ba3506a328bc6a232814cc7129c48d0132f439cca8c4700169b96d1ece96006000728461e3f46b6333f8dba0b00000000f93c8441031ffb16d1bc5040b3400000a6424c4787bc802cfe3f0000a6420386dd3d0c05803c0000a74200000000000000000080a64200000000000000000080a642d68517000000006cd98541051f3f2401bda06909430000a642a23dcdc02a2118420000a6424292e7bfc64286400000a742f55cbebde21d253e0000a742fbdec73cb4cb0e3c00a0a642afe2dd101945cc3d6f218a41f163cc3d090104b020cd3d51e98541cc4f893b42000d00c600040049011a00cc01120051021d00d302100058030c00dc030200000000ff01a54db33c341192404260653f000000031087f1ff848bf400ce89800097885a00858cf6ffe58bceffc18ba200c08d0801f989aaff9d896b01968afe00a58dcf00f88677017a8d4b01f98902009b8c3d00e40102008eb7040000f9457d3667bc81900900c08e4602f3fa3cf2900a0040af46de4ae93cdeef090000bb465bcdcd3ccdf0070000a046333b483d8dd0080000bb467d92fa3cb08f090080d146a47c393d948e0a0080f846df83483df48f0c00001d4784c6333d958f0a00c002475c4c3e3d92ce070080d346424c523d8b86070000cc468f0c6c3d9504261bd5ece9600600289dc447b5000000018598c801017f010000890000000000000092644e6fc8f1123f1c43c653e1c9ea3f9aec0ebe4b23013ed62aa64b3cb3124060764f1e16c57740f724d0838ec5e140ecf753e3a5fb4940000000000060c84029fc8b42919ecc3d00249c0700017f01000096000000000000007936263def002c3f6c518cb0b444eb3f9aec0ebe4b23013ed0dcacad6624134062a1d634ef6378405533794d4e37e2407227a089b0a14a400000000000fcc84029fc8b42919ecc3d0000000000000000000000000006000000052400000062313539643934372d663231342d353733372d626239632d616636346538346532643634fe0bd0ece96006000800000052454345495645440000052400000062313539643934372d663231342d353733372d626239632d616636346538346532643634ff0bd0ece9600600080000004150504c59494e470000042400000032626236633732652d363166612d353364392d626164642d326436646236396662336561010000000000000003000000000000000097c1a206a201000001000000000000001400000073696d2d336137633565393234316461656365649a9999999999a93f7b14ae47e17a943f9c20d6ece96006000fdb94ede9600600080000004f50455241544f5201020000005b5d052400000036316464383261632d663233372d353766622d613034662d6562663336303964306633389d0fd0ece96006000800000052454345495645440000052400000036316464383261632d663233372d353766622d613034662d6562663336303964306633389e0fd0ece9600600080000004150504c59494e4700000d010000000000000004000000444f4e4500c022d6ece96006000000
\.


--
-- Data for Name: robots; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.robots (robot_id, fleet, robot, boot_id, connection, model, updated_us, state, held, journal_number) FROM stdin;
1	f	crawler-1	sim-3a7c5e9241daeced	ONLINE	simulated	1795407676952492	\\x050097c1a206a201000000011400000073696d2d336137633565393234316461656365640107ad95bfe69e9d980301a5a1e70be306018fabeb0ad10701e581f608b30601b7c3fe06a10401cba88705d9060185ea9003890b01c79d99018b06010000001400000073696d2d336137633565393234316461656365649d0000000000000000000000000000000000000000000000000001000000040000006c656674000100000000000000010000000100000000acbb3ddef801ca3f9d9be303383a50409a9999999999b93f0b0dbe3e312fa83f00000000000000000000000000005593af1f0fafd23f00000000000000000000000000000000000000000000000000000000000ad7a3703d0ab73f0000000000000000000000000000000000000000000000000ad7a3703d0ad73f0000000000000000000000000000000000000000000000007c14ae47e17a843f8e774b3a3cc5ed3fc5ebde4510feed3fcd6f357e2c3eee3feaa3e16af47fee3f344b0dc32cc0ee3f654ecfd6fafcee3f935380145335ef3f194a2d7ca468ef3f65b20259a696ef3f178cf3bc39bfef3fb3afc5a056e2ef3ffcffffffffffef3f00000000000000000000000000010000000000000001000000010000000000000000000000000000	f	38
2	f	crawler-2	sim-6dba15089f34dec0	ONLINE	simulated	1795407676960971	\\x050097c1a206a201000000011400000073696d2d366462613135303839663334646563300107a0d9bfe69e9d980301bd86e80b8306018b95eb0a870701f3eaf308cf0e01fb86fd06df090189f18505d10601d5e78d03a50e0191dd9401ab06010000001400000073696d2d366462613135303839663334646563309d00000000000000000000000000000000000000000000000000010000000500000066726f6e74010100000000000000000000000000000000f7f2d7963135c73f4d620d6f122e4f409a9999999999b93f02d8a52c285b983f000000000000000000000000000046852af5e9cfd23f00000000000000000000000000000000000000000000000000000000000ad7a3703d0ab73f0000000000000000000000000000000000000000000000000ad7a3703d0ad73f0000000000000000000000000000000000000000000000007c14ae47e17a843fa4913f9c89f4ec3f0a4019abbe3ced3f07c2b7545092ed3fcdec5ae71ceced3fd0bb2452d044ee3f7deb68aa4e99ee3fef790cd2cce7ee3f67627b45492fef3fc8acba4d3b6fef3ff2ac1bb761a7ef3f07ef4c33a4d7ef3ffeffffffffffef3f00000000000000000000000000010000000000000001000000010000000000000000000000000000	f	39
\.


--
-- Data for Name: setpoint_states; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.setpoint_states (setpoint_state_id, command_id, recorded_us, state, error, pressure_mpa) FROM stdin;
1	b159d947-f214-5737-bb9c-af64e84e2d64	1795407676951213	PENDING	\N	\N
2	61dd82ac-f237-57fb-a04f-ebf3609d0f38	1795407676959904	PENDING	\N	\N
\.


--
-- Data for Name: setpoints; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.setpoints (command_id, robot_id, whisker_id, compensation_id, epoch, version, robot_boot_id, pressure_mpa, slew_mpa_per_s, issued_us, expires_us, reason, gain, state, error, reached_mpa) FROM stdin;
b159d947-f214-5737-bb9c-af64e84e2d64	1	2	4294967296	1795407659415	0	sim-3a7c5e9241daeced	0.047235049160940866	0.02	1795407676951213	1795407689589031	SELF_COMPENSATION	[[0.45,0.9303265703745056],[0.5,0.9372636189140101],[0.55,0.9450895752920531],[0.6,0.9531194770362366],[0.65,0.9609588441474899],[0.7,0.968381328153964],[0.75,0.9752593422332317],[0.8,0.9815237450914679],[0.85,0.9871398676383022],[0.9,0.9920929613548449],[0.95,0.9963791980821867],[1.0,0.9999999999999996]]	PENDING	\N	\N
61dd82ac-f237-57fb-a04f-ebf3609d0f38	2	4	8589934592	1795407659415	0	sim-6dba15089f34dec0	0.02378523609646522	0.02	1795407676959904	1795407690770190	SELF_COMPENSATION	[[0.45,0.9048507739758418],[0.5,0.9136651365060982],[0.55,0.9241105703968636],[0.6,0.9350723761230256],[0.65,0.9459001163830809],[0.7,0.9562142685239078],[0.75,0.9657959082140318],[0.8,0.9745222432203037],[0.85,0.9823280828617493],[0.9,0.9891823364572743],[0.95,0.9950734140361143],[1.0,0.9999999999999998]]	PENDING	\N	\N
\.


--
-- Data for Name: supervisors; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.supervisors (supervisor, holder, fleets, alive_us, deaf, heard) FROM stdin;
sfa7cd17ef69a562fa8991c0440d050f9	vm	f	1795407679168411		
\.


--
-- Data for Name: trims; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.trims (trim_id, robot_id, whisker_id, detected_us, length_before_mm, length_after_mm, length_after_sd_mm, contacts_to_detect) FROM stdin;
4294967296	1	2	1795407676951213	69.99911232633026	64.90966889598208	0.29193475813217634	23
8589934592	2	4	1795407676959904	69.99287759371553	62.26024252991954	0.29916158581843133	22
\.


--
-- Data for Name: turned_away; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.turned_away (fleet, robot, tries, first_us, last_us) FROM stdin;
\.


--
-- Data for Name: whiskers; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.whiskers (whisker_id, array_id, robot_id, whisker, "position", x_mm, y_mm, model, whole_length_mm, nominal_pressure_mpa, pressure_max_mpa, length_mm, length_sd_mm, condition, fault, pressure_mpa, setpoint_mpa, contacts, heard_us, state, leak_per_s, leak_low_per_s, leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact, erosion_high_mm_per_contact, contacts_left, contacts_left_low, contacts_left_high, held, rollup) FROM stdin;
1	1	1	0	0	0	0	nguyen-2021	70	0.1	0.2	69.99869210988841	0.09983386718516184	HEALTHY	\N	0.0996	0.1	523	1795407676951213	\\x0000000001010b6e677579656e2d32303231010181f6e042c19a0c81b51801a1940c0081f6e042e538413d68aea03d45bc9cb722c6e6b579fc56376a7e9d36baec923620864bb2655dde38036e1136abc70fb3dd810836b9c971ae3a46532f9295593f688cfa4344b9a9415e9a22410f78bb402dbc4a3f9cd6823b37c5133a9875843d76fe0f41de7c3d3fc818c93de592af42adcf1042aefb944183ae1342c38aa642ef8f414391c88642e30f00c0cc1ccc048ab4173ce3e483bda006803f5485193901b6936a3bc319dfbce500803f5972dc321ad0d1bc3f526cfa3ede32d0418298573b72a130e141486a17c11ddfe44234b7e53c368eb3d2403fb4cc3fd36958428cbdc33b671ee100c48f7c27c4474f45c107bbc342f502305355c556fcbcc592e83bc36af17d43004975f0a4c3b4f9d2c320cdcec05f048f42c04fc83f82564f46677f14c31e110440a25b4f46aa8914c3283c0940085d4f46599614c3f0f6a23f2bf3044570050b42a4d27a3f7f15af4bfc24f0449bbb0e3e31deb64e5dfc264717c8ea3d0b60334dbaa83f46bfb83e3e62de215412298e4879f5933d1885df56784d43497df5d43df8b6df5609155b4999ec023fd47f7353ce3711c87c657d3cbe4614beb00180409a1f1b39352c08478ce108c2ac7e7c46cf2a08474afb08c2a27d7c4630230847fa3409c291737c46001e1d32ccece96006000b56281a3f96b28c3f000000000005778241021f19131cbd6d82f3400000a642e0b01b3fa52b863f0000a64243f0c53ea346343e0080a742000000000000000000c0a642000000000000000000c0a642c6db18000000008f5d83410b1f6b79cbbc427eef420000a642222d004068ae08420000a642e9973e3eeed727400080a742542793bd1b9cd83d0000a742bbcbd5bc92b6c13c00e0a6420000803fd81501419394413f6fa07c387efae4340000504111e5aa355b61123f91073f383f4c7931a7f5b708a0abcd3d6c720841da4dcd3d100101f063cc3d383f00414193ccbb0f0000003000eeff5200c3ff7200cfff9400cfffb600d9ffd700e4fff800d9ff1a01c9ff3b01dfff5d01d0ff7e01ceffa001cfffc201d4ffe201d3ff000000ff000c10892800798e5000ce8adc008b8b6600968ea300c28d6601ae8b3c0092909c00e5909e00ed8afeff8a906200f8901501ef8ea801c78eff00be8b3c019d89faff7f01020083d80700007a462871033d92b00c0000e246c5b9043dedee0600c0844657ce263d85d10d004015470106103de1ee0b00800947fc6bdf3ccab10c00001a470bb15b3db6cd0900800047bd43493db2ae0a00400e479ea0733d9baf0b008027470d905e3d95d10800c002478a2c6f3db5b00e000062474e8d813deba7050000a4466fcea63d8b04adcacfece96006009f529647	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018598c8010175010000880000000000000067b28cce784671bfa40d656f063ee43f0aebeabd63d6e13d0dff8736da191340da24068195ee7640cc47a6ace565e14091e92631086c49400000000000dcc74055ff8b42b375cc3d00249c070001750100009600000000000000dd230ca21f436ebfa3c1bfce9164e53f0aebeabdc876fa3db1d60c091da11340029a081b9e927740da474c5965e0e140ac0f7a36ab1e4a40000000000084c84055ff8b42b375cc3d00
2	1	1	1	1	25	0	nguyen-2021	70	0.1	0.2	64.90966889598208	0.29193475813217634	TRIMMED	\N	0.0996	0.1	523	1795407676951213	\\x00b20200010200020b6e677579656e2d3230323181e1eb170181f6e042c19a0c81b51801a1940c0081f6e042025d4b3dfd33bc3d099f9abd686950b7ed9355376c3970363272bd365d5f62b247a5e5388cffa135671906b31eed9e379b8a75b0e2d2802f872a703f6026e643f007874106188a41bbc07941a32e343dd578283a722c043a5651573d3fec5041a1f1de3f3540b63d26b37e41f7087c412912724131f97b4149437f41d5598041bf918141e30f00c0cc1cc10fd76f0b3c88f2a03c2f6d5f3e850578b702e860de3848468d3cf75d633f14ca0d371091da513da82ab73ea9f60c41ed1c65390000103ce1b83f01db634268373f43418b7e41000000e94ec23fd9232146c34a08c3546c0140ab352146c6a208c3e1e91a4078422146321909c30e1b29405e7bbe45cc9cff42c95ea23f8a47be45ad82ff4209e77f3f61e3ca49209cc84186947f3f48e3ca492010c84177227d3fdce2ca498025c64166b9763ff9c4aa4feade0447903b7e3f4ac6aa4fceea04475cdc803fdbc6aa4faff00447f50f843fc8c7aa4f53fc0447698d073d3677b03ebb6a16416fec8039df99a449ec717b435e1190478699a4496ada7a43281390478097a449e8db79435b13904700164e29c9ece96006000e62bc3b40fd18b33f9ea3180000000005778241021fc908783faf5dd3400000a842503332bf34d17e3f0000a7429045d6bdc8c9793c0080a6424e1955bd5acd333b0040a642000000000000000000a0a642f8b03300000000049e83410b1f803adbbc99fdfc420000a64233b716405b58f4410000a84204bb8cbfaf6a85400000a642a2ca443e62b92c3f0040a64250c3713c22c2993c00e0a642b7da9b10570ecd3dc9d88541580ecd3d1002021720cc3df0fd7e41057872bb2000eeff6200f8ffa400e1ffe600f6ff2701fdff6b01f3ffad01f0ffed01f5ff2f02deff7202e4ffb502e7fff602f3ff3703e8ff7903eaffbb03e7ff000000ff0003108a00009389b3ff8688c900778e9200d48881007690b601fd8f0602ef897401808c7601bc883b027f8aa000948cb701bc8a68019d8f7a00eb8ec501e489a9018c030200a6f6040000234601eae93bb9f1090000b1468dfe283deece0a0000d546204efd3cb6d2080080ba46fc734b3dd4b10d00401d47d7bc133dad8e0a0080f9461ab5323df08f090080ec462129493da5d00b00801f472c79733db68f0a00401247178f7d3ddbd20b00802f47cab5823d98900b00002e47febf8e3db88503000047465552a73d8b04adcacfece9600600713a4f47000000207e60a93f000000a02defb73f0b0dbe3e312fa83f00000100000000018e774b3a3cc5ed3fc5ebde4510feed3fcd6f357e2c3eee3feaa3e16af47fee3f344b0dc32cc0ee3f654ecfd6fafcee3f935380145335ef3f194a2d7ca468ef3f65b20259a696ef3f178cf3bc39bfef3fb3afc5a056e2ef3ffcffffffffffef3f97c1a206a2010000000000000000000001000000000000001400000073696d2d336137633565393234316461656365640b0dbe3e312fa83f7b14ae47e17a943fadcacfece960060027a190ede960060000000100000000018e774b3a3cc5ed3fc5ebde4510feed3fcd6f357e2c3eee3feaa3e16af47fee3f344b0dc32cc0ee3f654ecfd6fafcee3f935380145335ef3f194a2d7ca468ef3f65b20259a696ef3f178cf3bc39bfef3fb3afc5a056e2ef3ffcffffffffffef3f002d4feeece9600600012d4feeece9600600	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018598c801017501000089000000000000006f0e1c90a6ab5e3f06d8e0764aebeb3f5a3bd5bd2f25543e2f6d84c4a3dc124088d2dee00b2d774063179c5d6a64e140d04082e2c77849400000000000e8c740c0d181427978953e00249c0700017501000096000000000000006ac406c550375d3fb979bd8f8b4fec3f5a3bd5bd2f25543ed634cf5f6b661340daf97e6abcb67740ae7e93592ad6e140fff21fd26f1f4a40000000000084c840c0d181427978953e00
4	2	2	0	0	0	0	nguyen-2021	70	0.1	0.2	62.359937554869795	0.2939400572014005	TRIMMED	\N	0.1008	0.1	523	1795407676959904	\\x00b202000001010b6e677579656e2d32303231010181f6e042c19a0c81b5180181a70c0081f6e042fe4a3d3d84ac893d1eb1ecbd39d7d6357e4d4b3742eb2336b796bc36267e45b2b807dc384f1b3735d177fab2132ba1376661f5b02e8f702f5695733f138ed843e3c41541154e6740fb6e1e3f0a69023d37b2183bf92cfe3a5526803e3c23ab41deeb52429d682b3f94be8d41df498941569b7441f10292416f689041e1968f417eeb8d41e50fcccccc0cc2122128d63b78adcbbb86c7a33d62b118b702f637003b40ffeebc20276a3f245c7eb612d84b9b3df4cc21bfb0fd1941b2d83c380000123c13f6be38bef540af680c431ae78f410000002250b83f981286459915684279de3a42eff094453bc13f4344307b3feee5da49619bed44e0b4713ffde4da496a96ed44ad13523f82e1da494284ed440f29823fb0d8824e101987c6ba70803f70d8824ebc1787c67a1c7f3f50d8824e0e1787c6ef797b3f0cd8824eb11587c60016961fcdece960060006ddf0d33ef54a193ff39002000000004db28241021f9a52763fd584d5400000a84289f3c53d19c8f53f0000a74209cd75bc09cd75390080a64275917cbc75917c390080a642000000000000000000c0a64294f21000000000927483410b1f5238793fe26fd4420000a8422d3f58bf53333b420000a642f1d696bede117a400080a642891edebeacb3a63e0040a642a2ad3dbdd0929e3b0040a642a586ba10b1bfcc3d0de387410d71cc3d1002021945cc3d5d7681413f1289ba1f00faff6200ffffa5001300e80000002a010f006c010a00af01fcfff301f9ff3702f5ff7902f8ffbb02f0fffe02eaff4003f1ff8303edffc703f6ff000000ff010d2c7e3decc0a340780b243f00000006108afd00928ac400998908018c8adbfe9b891e00848be100ad8a02009b8e4e00db882c00818a9b00928fb400f68d8f00ca8b4800a38c9500b68e3601de8ed5ffe1030200f2b70500802d46432c543cbc910600805e462b59063dc5b10b0040e34639e7373dfbaf0c00c0024711fd223dc8b1070000a646574c3e3d9a8f080000cb467232263dd1d00b00001a47ccef523d8aae080080dd46da18503df1ee0900c0094709be833d87d10c00003d4701eb4f3db2b10900c00d47cc1d733d80a70400808a46bde4923d8b04a0eccfece960060037b753470000008032c2a73f000000606d81b03f02d8a52c285b983f0000010000000001a4913f9c89f4ec3f0a4019abbe3ced3f07c2b7545092ed3fcdec5ae71ceced3fd0bb2452d044ee3f7deb68aa4e99ee3fef790cd2cce7ee3f67627b45492fef3fc8acba4d3b6fef3ff2ac1bb761a7ef3f07ef4c33a4d7ef3ffeffffffffffef3f97c1a206a2010000000000000000000000000000000000001400000073696d2d3664626131353038396633346465633002d8a52c285b983f7b14ae47e17a943fa0eccfece96006000ea7a2ede96006000000010000000001a4913f9c89f4ec3f0a4019abbe3ced3f07c2b7545092ed3fcdec5ae71ceced3fd0bb2452d044ee3f7deb68aa4e99ee3fef790cd2cce7ee3f67627b45492fef3fc8acba4d3b6fef3ff2ac1bb761a7ef3f07ef4c33a4d7ef3ffeffffffffffef3f002071eeece9600600012071eeece9600600	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018598c8010175010000890000000000000034ce3bfe4a8d673fb57faefd42b2f13ff3cae3bdf926b13ebf4ff83bfa8412404a9d8026c25f77409e9880c0735ce1402824287e8c7949400000000000e8c74093707942507f963e00249c070001750100009600000000000000bb6e3f7b979a683f0af9693c3942f23ff3cae3bdf926b13e774afcfe90e71240eec9c342ad0278401b67482d33cee1405ab4c876be1f4a40000000000084c84093707942507f963e00
5	2	2	1	1	25	0	nguyen-2021	65	0.1	0.2	64.99475810401324	0.09998812628317079	HEALTHY	\N	0.0996	0.1	523	1795407676959904	\\x000000010200020b6e677579656e2d3230323181e1eb170181c9fe3dc19a0c81b51801a1940c0081c9fe3deac1583d2568973d7621a9b8150396363d4260376c39d835b5b6a33640fb30b270c6e638e43619361eafe3b24ad31e3656bb5a2e233c632f78f16b3f285bf843142129430f51204305a5814351060b4253a3813b48ef183a6d065b3d196e433f2ef2d93aa49d593d162ea94312c86743a6563c4386e63942690e2f43d9c32b4382a0b942e70f1120cccccc0ad6ef2a3d3570debd04e07f3f220496360b7f343f3d0374aabd78dd7f3f7de001b706ee7dcb3c202e50bcf4ed7f3f88df91b6f5025bd68443a7c396c1d1efb843b7bb5b3eb5018d767b4284cb37c20c3f344367819f3d34d697aa40e6503dc1f1bf4f425100e03b2e91554fc29f65bf42e8f7913fcf393342f50215338cc4836abfc5cf2f8c42aa5272437ff1f03d42a05ebe427940f5406066d64246d1981f41df7f334318f11b40213c8042b86ba1403e97054722edffc3a0e58241069b0547fdfcffc32e0f484208f4e74646f9f2c37ab14841c73b9a4601debac34e3be53e4865c9500cc455c7d10e0a3fba238f4fa77049c76aaa064066db034d127460c61a243c3f9407f9511c7d6c482b333d3faa96dd5617b523cbe10e733fb5f3ef54d20c0a49aab8583f8ecb735374d5ae4857463e3e5851733dc6f61f4140f34d374c02693e108f49bdc6f42f41a07a8c3712e97f3d8bb9823e04f9bf402ca466b786d4af49ba7539c50ac2344862daaf499d8139c506c83448f92d86496a2f1bc5d2441848025373488db272c4ba677347001609bfcbece9600600092784843fb003673fa6f108000000004db28241021f8445763f1982d3400000a8422644613fa673893f0000a8428068eebd870a773c0080a642ba1a55bd8dce333b0040a642000000000000000000a0a642c69b1d00000000d37083410b1f2047fabc0510f6420000a642797ccebe34a844420000a8421eb975bb5f5420400000a7423a45b83e8708183f00c0a6420bb4f73bc760c33c00e0a6428b84af1026fecc3dfe188741560ecd3d10020203e7cc3d36d880414199feba2100faff6600fbffaa00ffffec00fcff2e01e4ff7001f0ffb101fcfff301e1ff3602e4ff7702f2ffba02e7fffd02ffff4103f2ff8303feffc403f3ff000000ff000710899f00878aa8ff8b8aa8008e8a5600938fe100f28a4400908ee300d38f3b01e08ba8019f8adf008a8a2901948b7300a188be017889ee007c8d7401b68be0019d0102009c99040000f9456f7de63bdbf20b0080c546c165c63ce7d0080080a1469283343df9d00700009b460c7b2e3d83910b0000f446b7046a3d93ce0c0080124730825b3d80cf080000d54695f4863db4b00d00802f476388603dc4b30c00c02a47b642703de4b10c008030476c6c7d3dc5ef0f00006b479d338c3dbdc804008087468bd4973d8b04a0eccfece96006005cb66747	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018598c8010175010000880000000000000029183cf404e3583f0d99e2a33f83e53fb90fdebd3d5de73dbb220af61bbe14402f2aa913d0a877408d52b4e46027e04085d712f2416f49400000000000dcc74051fd814293c6cc3d00249c070001750100009600000000000000f11d1cffbc7d593f3e6e436e4d29e73f988a1fbe3d5de73d93f5a21cf97f154094218e75714078405c1aaacd2099e040f5e00b93a9224a40000000000084c84051fd814293c6cc3d00
3	1	1	2	2	50	0	nguyen-2021	70	0.1	0.2	70.00728492054355	0.09984562787767277	HEALTHY	\N	0.0996	0.1	524	1795407676951213	\\x0000000201010b6e677579656e2d3230323181c2d72f0181f6e042c19a0c81b51801a1940c0081f6e042e2e3483d0941923d683dda383b9adab6115b643710b08136772f9136e37c6bb27ce22239b6ac0f36ca7627b37a810836c0b6682f332f792fdbef873fc2a9fb43d093854143f25f40d0f2593f63f5b03dcee44f3a691f093ab8ca503d99e99842882dec3e9c339a3d177e7742fafcb3410a0777419e214843bc7fa44383055b42d3627441e207cccccc1ccc1181e4bc3dcc38843ee007803fcc6570b8f602780f9a433e2735437f9cbb4375e53a3e0a678e8e3ecd947b3f6d0420417fa0463900720de8ecc3596c2dc5377b8ac1c938cb42f60274c0a6c51d824ac6de751cc38ed588431cb89041c2e38397c39e7fe6be6bf5dd417c65d6402d6d5f47f357ee435f24d03d3a87a750b27de247eda4773fcb1ca749719d8744f118643f5d1ca749bd9c8744fb6f923fbcb698541db828ca78fcde3e1991d2566f59e2cac1db703f12aa6051111e92c8001e6389caece96006000d5f260d4054e3a53ff4a20d0000000005778241021fa00d03bd473218410000a6427082d23bcd78b83d0000a74200000000000000000080a64200000000000000000080a64200000000000000000080a642a6d4290000000026b083410c1f602cc5bcdd69cb420000a642b98f5f406f0cf4410000a6426f1a8c3f00a103400000a6423423b03e280d8f3e0040a642f93f083e21b7b33c00e0a6420000803f63807c417821bf40a6384a39f7921735000050418ca3ad37f5b20e42b4fa963a73bd1f33bdf77d32b7cd3dac2b3f3fbdf6cc3d01010132b7cd3d05a56a3e00000000000000ff0186b75c3d02bc994090a0183f0000000e10892800978b5b00c68b5a00bb8df700ed8cff00e38badffc68ba100c58c8001e389b5ff988ba200c48ca100cf8c0d01da8dfc00e88dac00f68aac00aa8b6000c5010200d7b90600801846af30823ce2b209000077467854083dabaf0a00809246b3a4553de3900c0000be46a9ff0d3d9bd00c00c0d546f47e473dbaaf0c00c0d9461ead5f3de5af0c0040ee460a0f3e3dd7d00d00a00647352c5e3dc3cf080080b84683f35c3df5af0b0080f84610137b3df7f00a0080f546fed4873dcce90400006746da0d853d8c04adcacfece960060095788347	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018598c80101760100008900000000000000245493ed4e2f413fccd54225984fea3fa968fcbde505da3dbf8e88330fda1240f7164850fc09774032d8a908b477e140b94e4013618349400000000000f4c740bb038c42dd7bcc3d00249c070001760100009600000000000000302490460cd5423fb5a65df7bcedea3fa968fcbde505da3de205ccb81a4513409506f01648ab774097337c0574e9e140eadee00b93294a40000000000090c840bb038c42dd7bcc3d00
6	2	2	2	2	50	0	nguyen-2021	70	0.1	0.2	69.99254487371994	0.09991012942980826	HEALTHY	\N	0.0996	0.1	524	1795407676959904	\\x0000000201010b6e677579656e2d3230323181c2d72f0181f6e042c19a0c81b51801a1940c0081f6e0425b9a1d3d21968d3dc45cdfb8a3de773638815837be9c3d36922b9136f2ea53b2cf05f938b58a0f36f78703b361bd08365679d62d2097662fc101893f28f3d14358b6bc43cb017e4013db813fc470803edb725a3b217bd8395287353d48c46b42007f143fe7d36c3d9b16d6423d1fde41f9808e4197548142624518433540a44290b81f42e30fc0cccc1ccccb022e2ba43f89d9233fd1927e3fb8ff4a3a1368ce833d06c43dbc93ea7f3fd6a66139f6027f138743f130c0425c5dba438f66503e74056dcf41f98713bf99bee742248ed53c231d8c1140a86de8bea3f40b424a859d3b6738caadc3b008a5431ae822407a3fc042484fd431c3f2fb8c4314d8a03f34858942f6025a004dc59d8137c50e1df04137f78443368d42c3c273594f432b94353fedef4f424a09b5401f8ac7488a3b9bc4bc178a4095b45f479e48db43095ee13e24d6c250d8f04cc773b9353e08b7a14e32fb11477043ab3e2a62254c26020a46c072b23e9e493a54f9b608c963688b3f77d48e531de207c91033303e8237da56be57494a11a20e3f3a0b0853246990c82220514371da874299fea443165b363e06a497506cb499c5ebd0784c00165b87c9ece96006000fc95646405cb1bf3f82d01a000000004db28241021f3464d1bc8482b3400000a642437987bc608afe3f0000a642d4d7dd3d5434803c0000a74200000000000000000080a64200000000000000000080a642dca33200000000a8ad83410c1fdd5efbbc9db007430000a64288a0cdc0ae6d10420000a642f30ae8bfc28886400000a742086c15be519a223e0040a6429947ca3ce1150f3c00c0a642afa59d101945cc3d51e98541b020cd3d1002021d6acc3dd8407f413f72b8372100010062001900a5000b00e700fdff28011e006a011600ab010b00ec0118003002260072021300b2021100f4020f003703040078031300ba030400000000ff01fb22023ceb73953ff31f423f0000000a1089b7ff928cf4ffdc8b6800cb8d0a01f28c7300d88df500f189fb009d8835fe8e8757018487f1ff848bf400ce89800097885a00858cf6ffe58bceffc18ba200c00102008eb7040000f9457d3667bcdaef0800008b465736ef3cb8d00900c0a6469e92073dbecf090080b646a87fc63ccdf0070000a046333b483d8dd0080000bb467d92fa3cb08f090080d146a47c393d96ee090000f3461ab34a3de4cf0b000017475bdf383d958f0a00c002475c4c3e3d928e070080c64669564f3d8b86070000cc468f0c6c3d8c04a0eccfece960060009d58a47	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018598c80101760100008900000000000000b365dc88f3d70ebf33ab03ed4e50ea3f9aec0ebe4b23013e6775b2d3366012408816d9cef7587740d2dbbcabd076e1400d64cc5d4b8849400000000000f4c7402ffc8b42af9dcc3d00249c07000176010000960000000000000060b160b95621173ff2b6f8c44acbea3f9aec0ebe4b23013e6127b93561d112408a4160e5d0f7774030ea657590e8e14093931804562e4a40000000000090c8402ffc8b42af9dcc3d00
\.


--
-- Name: actions_action_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.actions_action_id_seq', 1, true);


--
-- Name: alarm_shelves_alarm_shelf_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.alarm_shelves_alarm_shelf_id_seq', 1, false);


--
-- Name: alarms_alarm_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.alarms_alarm_id_seq', 1, false);


--
-- Name: arrays_array_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.arrays_array_id_seq', 2, true);


--
-- Name: boots_boot_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.boots_boot_seq', 2, true);


--
-- Name: calibrations_calibration_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.calibrations_calibration_id_seq', 1, false);


--
-- Name: changes_change_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.changes_change_id_seq', 16, true);


--
-- Name: compensation_errors_compensation_error_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.compensation_errors_compensation_error_id_seq', 1, false);


--
-- Name: compensation_refinements_compensation_refinement_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.compensation_refinements_compensation_refinement_id_seq', 1, false);


--
-- Name: health_changes_health_change_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.health_changes_health_change_id_seq', 10, true);


--
-- Name: quarantine_quarantine_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.quarantine_quarantine_id_seq', 1, false);


--
-- Name: robots_robot_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.robots_robot_id_seq', 2, true);


--
-- Name: setpoint_states_setpoint_state_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.setpoint_states_setpoint_state_id_seq', 2, true);


--
-- Name: whiskers_whisker_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.whiskers_whisker_id_seq', 6, true);


--
-- Name: _sqlx_migrations _sqlx_migrations_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public._sqlx_migrations
    ADD CONSTRAINT _sqlx_migrations_pkey PRIMARY KEY (version);


--
-- Name: actions actions_actor_idempotency_key_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.actions
    ADD CONSTRAINT actions_actor_idempotency_key_key UNIQUE (actor, idempotency_key);


--
-- Name: actions actions_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.actions
    ADD CONSTRAINT actions_pkey PRIMARY KEY (action_id);


--
-- Name: active_calibrations active_calibrations_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.active_calibrations
    ADD CONSTRAINT active_calibrations_pkey PRIMARY KEY (fleet, model);


--
-- Name: alarm_shelves alarm_shelves_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.alarm_shelves
    ADD CONSTRAINT alarm_shelves_pkey PRIMARY KEY (alarm_shelf_id);


--
-- Name: alarms alarms_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.alarms
    ADD CONSTRAINT alarms_pkey PRIMARY KEY (alarm_id);


--
-- Name: allowed_robots allowed_robots_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.allowed_robots
    ADD CONSTRAINT allowed_robots_pkey PRIMARY KEY (fleet, version);


--
-- Name: api_tokens api_tokens_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.api_tokens
    ADD CONSTRAINT api_tokens_pkey PRIMARY KEY (token_id);


--
-- Name: arrays arrays_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.arrays
    ADD CONSTRAINT arrays_pkey PRIMARY KEY (array_id);


--
-- Name: arrays arrays_robot_id_array_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.arrays
    ADD CONSTRAINT arrays_robot_id_array_key UNIQUE (robot_id, "array");


--
-- Name: boots boots_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.boots
    ADD CONSTRAINT boots_pkey PRIMARY KEY (boot);


--
-- Name: boots boots_robot_id_boot_id_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.boots
    ADD CONSTRAINT boots_robot_id_boot_id_key UNIQUE (robot_id, boot_id);


--
-- Name: calibrations calibrations_model_version_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.calibrations
    ADD CONSTRAINT calibrations_model_version_key UNIQUE (model, version);


--
-- Name: calibrations calibrations_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.calibrations
    ADD CONSTRAINT calibrations_pkey PRIMARY KEY (calibration_id);


--
-- Name: changes changes_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.changes
    ADD CONSTRAINT changes_pkey PRIMARY KEY (change_id);


--
-- Name: compensation_candidates compensation_candidates_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_candidates
    ADD CONSTRAINT compensation_candidates_pkey PRIMARY KEY (compensation_id, ordinal);


--
-- Name: compensation_error_bins compensation_error_bins_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_error_bins
    ADD CONSTRAINT compensation_error_bins_pkey PRIMARY KEY (compensation_error_id, ratio);


--
-- Name: compensation_errors compensation_errors_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_errors
    ADD CONSTRAINT compensation_errors_pkey PRIMARY KEY (compensation_error_id);


--
-- Name: compensation_refinements compensation_refinements_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_refinements
    ADD CONSTRAINT compensation_refinements_pkey PRIMARY KEY (compensation_refinement_id);


--
-- Name: compensations compensations_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensations
    ADD CONSTRAINT compensations_pkey PRIMARY KEY (compensation_id);


--
-- Name: contact_hours contact_hours_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_hours
    ADD CONSTRAINT contact_hours_pkey PRIMARY KEY (whisker_id, start_us);


--
-- Name: contact_minutes contact_minutes_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_minutes
    ADD CONSTRAINT contact_minutes_pkey PRIMARY KEY (whisker_id, start_us);


--
-- Name: contact_minutes_20261103 contact_minutes_20261103_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_minutes_20261103
    ADD CONSTRAINT contact_minutes_20261103_pkey PRIMARY KEY (whisker_id, start_us);


--
-- Name: contact_minutes_20261203 contact_minutes_20261203_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_minutes_20261203
    ADD CONSTRAINT contact_minutes_20261203_pkey PRIMARY KEY (whisker_id, start_us);


--
-- Name: contact_minutes_default contact_minutes_default_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contact_minutes_default
    ADD CONSTRAINT contact_minutes_default_pkey PRIMARY KEY (whisker_id, start_us);


--
-- Name: epochs epochs_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.epochs
    ADD CONSTRAINT epochs_pkey PRIMARY KEY (fleet, epoch);


--
-- Name: health_changes health_changes_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.health_changes
    ADD CONSTRAINT health_changes_pkey PRIMARY KEY (health_change_id);


--
-- Name: journal journal_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.journal
    ADD CONSTRAINT journal_pkey PRIMARY KEY (fleet, number);


--
-- Name: leases leases_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.leases
    ADD CONSTRAINT leases_pkey PRIMARY KEY (fleet);


--
-- Name: policies policies_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.policies
    ADD CONSTRAINT policies_pkey PRIMARY KEY (fleet, version);


--
-- Name: quarantine quarantine_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.quarantine
    ADD CONSTRAINT quarantine_pkey PRIMARY KEY (quarantine_id);


--
-- Name: redo redo_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.redo
    ADD CONSTRAINT redo_pkey PRIMARY KEY (fleet, number);


--
-- Name: robots robots_fleet_robot_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.robots
    ADD CONSTRAINT robots_fleet_robot_key UNIQUE (fleet, robot);


--
-- Name: robots robots_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.robots
    ADD CONSTRAINT robots_pkey PRIMARY KEY (robot_id);


--
-- Name: setpoint_states setpoint_states_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.setpoint_states
    ADD CONSTRAINT setpoint_states_pkey PRIMARY KEY (setpoint_state_id);


--
-- Name: setpoints setpoints_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.setpoints
    ADD CONSTRAINT setpoints_pkey PRIMARY KEY (command_id);


--
-- Name: setpoints setpoints_robot_id_epoch_version_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.setpoints
    ADD CONSTRAINT setpoints_robot_id_epoch_version_key UNIQUE (robot_id, epoch, version);


--
-- Name: supervisors supervisors_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.supervisors
    ADD CONSTRAINT supervisors_pkey PRIMARY KEY (supervisor);


--
-- Name: trims trims_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.trims
    ADD CONSTRAINT trims_pkey PRIMARY KEY (trim_id);


--
-- Name: turned_away turned_away_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.turned_away
    ADD CONSTRAINT turned_away_pkey PRIMARY KEY (fleet, robot);


--
-- Name: whiskers whiskers_array_id_whisker_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.whiskers
    ADD CONSTRAINT whiskers_array_id_whisker_key UNIQUE (array_id, whisker);


--
-- Name: whiskers whiskers_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.whiskers
    ADD CONSTRAINT whiskers_pkey PRIMARY KEY (whisker_id);


--
-- Name: actions_pending; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX actions_pending ON public.actions USING btree (fleet, action_id) WHERE (state = 'PENDING'::text);


--
-- Name: alarm_shelves_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarm_shelves_of_whisker ON public.alarm_shelves USING btree (whisker_id, kind);


--
-- Name: alarms_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarms_of_whisker ON public.alarms USING btree (whisker_id, raised_us);


--
-- Name: alarms_standing; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarms_standing ON public.alarms USING btree (whisker_id, kind) WHERE (cleared_us IS NULL);


--
-- Name: changes_in_order; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX changes_in_order ON public.changes USING btree (tx, change_id);


--
-- Name: compensation_errors_of; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensation_errors_of ON public.compensation_errors USING btree (compensation_id, recorded_us);


--
-- Name: compensation_refinements_of; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensation_refinements_of ON public.compensation_refinements USING btree (compensation_id, recorded_us);


--
-- Name: compensation_responses_of; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensation_responses_of ON public.compensation_responses USING btree (compensation_id, t_us);


--
-- Name: compensations_of_target; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensations_of_target ON public.compensations USING btree (target_whisker_id, decided_us);


--
-- Name: contacts_20261123_pages; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX contacts_20261123_pages ON public.contacts_20261123 USING brin (t_us) WITH (autosummarize='on');


--
-- Name: contacts_20261124_pages; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX contacts_20261124_pages ON public.contacts_20261124 USING brin (t_us) WITH (autosummarize='on');


--
-- Name: contacts_default_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX contacts_default_of_whisker ON public.contacts_default USING btree (whisker_id, t_us);


--
-- Name: health_changes_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX health_changes_of_whisker ON public.health_changes USING btree (whisker_id, recorded_us);


--
-- Name: quarantine_of_fleet; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX quarantine_of_fleet ON public.quarantine USING btree (fleet, quarantine_id);


--
-- Name: setpoint_states_of_setpoint; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX setpoint_states_of_setpoint ON public.setpoint_states USING btree (command_id);


--
-- Name: setpoints_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX setpoints_of_whisker ON public.setpoints USING btree (whisker_id, issued_us);


--
-- Name: trims_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX trims_of_whisker ON public.trims USING btree (whisker_id, detected_us);


--
-- Name: whiskers_of_robot; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX whiskers_of_robot ON public.whiskers USING btree (robot_id, "position");


--
-- Name: contact_minutes_20261103_pkey; Type: INDEX ATTACH; Schema: public; Owner: -
--

ALTER INDEX public.contact_minutes_pkey ATTACH PARTITION public.contact_minutes_20261103_pkey;


--
-- Name: contact_minutes_20261203_pkey; Type: INDEX ATTACH; Schema: public; Owner: -
--

ALTER INDEX public.contact_minutes_pkey ATTACH PARTITION public.contact_minutes_20261203_pkey;


--
-- Name: contact_minutes_default_pkey; Type: INDEX ATTACH; Schema: public; Owner: -
--

ALTER INDEX public.contact_minutes_pkey ATTACH PARTITION public.contact_minutes_default_pkey;


--
-- Name: active_calibrations active_calibrations_calibration_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.active_calibrations
    ADD CONSTRAINT active_calibrations_calibration_id_fkey FOREIGN KEY (calibration_id) REFERENCES public.calibrations(calibration_id);


--
-- Name: alarm_shelves alarm_shelves_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.alarm_shelves
    ADD CONSTRAINT alarm_shelves_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: alarms alarms_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.alarms
    ADD CONSTRAINT alarms_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: allowed_robots allowed_robots_action_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.allowed_robots
    ADD CONSTRAINT allowed_robots_action_id_fkey FOREIGN KEY (action_id) REFERENCES public.actions(action_id);


--
-- Name: arrays arrays_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.arrays
    ADD CONSTRAINT arrays_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: boots boots_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.boots
    ADD CONSTRAINT boots_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: compensation_candidates compensation_candidates_compensation_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_candidates
    ADD CONSTRAINT compensation_candidates_compensation_id_fkey FOREIGN KEY (compensation_id) REFERENCES public.compensations(compensation_id);


--
-- Name: compensation_candidates compensation_candidates_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_candidates
    ADD CONSTRAINT compensation_candidates_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: compensation_error_bins compensation_error_bins_compensation_error_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_error_bins
    ADD CONSTRAINT compensation_error_bins_compensation_error_id_fkey FOREIGN KEY (compensation_error_id) REFERENCES public.compensation_errors(compensation_error_id);


--
-- Name: compensation_errors compensation_errors_compensation_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_errors
    ADD CONSTRAINT compensation_errors_compensation_id_fkey FOREIGN KEY (compensation_id) REFERENCES public.compensations(compensation_id);


--
-- Name: compensation_refinements compensation_refinements_compensation_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_refinements
    ADD CONSTRAINT compensation_refinements_compensation_id_fkey FOREIGN KEY (compensation_id) REFERENCES public.compensations(compensation_id);


--
-- Name: compensation_responses compensation_responses_compensation_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensation_responses
    ADD CONSTRAINT compensation_responses_compensation_id_fkey FOREIGN KEY (compensation_id) REFERENCES public.compensations(compensation_id);


--
-- Name: compensations compensations_compensator_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensations
    ADD CONSTRAINT compensations_compensator_whisker_id_fkey FOREIGN KEY (compensator_whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: compensations compensations_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensations
    ADD CONSTRAINT compensations_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: compensations compensations_target_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.compensations
    ADD CONSTRAINT compensations_target_whisker_id_fkey FOREIGN KEY (target_whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: health_changes health_changes_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.health_changes
    ADD CONSTRAINT health_changes_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: policies policies_action_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.policies
    ADD CONSTRAINT policies_action_id_fkey FOREIGN KEY (action_id) REFERENCES public.actions(action_id);


--
-- Name: setpoint_states setpoint_states_command_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.setpoint_states
    ADD CONSTRAINT setpoint_states_command_id_fkey FOREIGN KEY (command_id) REFERENCES public.setpoints(command_id);


--
-- Name: setpoints setpoints_compensation_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.setpoints
    ADD CONSTRAINT setpoints_compensation_id_fkey FOREIGN KEY (compensation_id) REFERENCES public.compensations(compensation_id);


--
-- Name: setpoints setpoints_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.setpoints
    ADD CONSTRAINT setpoints_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: setpoints setpoints_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.setpoints
    ADD CONSTRAINT setpoints_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: trims trims_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.trims
    ADD CONSTRAINT trims_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: trims trims_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.trims
    ADD CONSTRAINT trims_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: whiskers whiskers_array_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.whiskers
    ADD CONSTRAINT whiskers_array_id_fkey FOREIGN KEY (array_id) REFERENCES public.arrays(array_id);


--
-- Name: whiskers whiskers_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.whiskers
    ADD CONSTRAINT whiskers_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- PostgreSQL database dump complete
--


