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


--
-- Name: webhook_alarm_cleared(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_alarm_cleared() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(6, 'ALARM_CLEARED', NEW.kind, NEW.cleared_us, NEW.robot_id, NEW.whisker_id, NEW.alarm_id, NULL);
    RETURN NULL;
END $$;


--
-- Name: webhook_alarm_raised(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_alarm_raised() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(5, 'ALARM_RAISED', NEW.kind, NEW.raised_us, NEW.robot_id, NEW.whisker_id, NEW.alarm_id, NULL);
    RETURN NULL;
END $$;


--
-- Name: webhook_approved(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_approved() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(3, 'COMPENSATION_BEGUN', NULL, (extract(epoch FROM clock_timestamp()) * 1000000)::bigint, NEW.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL);
    RETURN NULL;
END $$;


--
-- Name: webhook_begun(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_begun() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(3, 'COMPENSATION_BEGUN', NULL, NEW.decided_us, NEW.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL);
    RETURN NULL;
END $$;


--
-- Name: webhook_condition(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_condition() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(0, 'CONDITION_CHANGED', NEW.becomes, NEW.recorded_us, NULL, NEW.whisker_id, NEW.health_change_id, NULL);
    RETURN NULL;
END $$;


--
-- Name: webhook_ended(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_ended() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(2, 'COMPENSATION_ENDED', NEW.end_reason, NEW.ended_us, NEW.robot_id, NEW.target_whisker_id, NEW.compensation_id, NULL);
    RETURN NULL;
END $$;


--
-- Name: webhook_event(bigint, text, text, bigint, bigint, bigint, bigint, text); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_event(rank bigint, event_kind text, event_word text, at_us bigint, of_robot bigint, of_whisker bigint, of_number bigint, of_command text) RETURNS void
    LANGUAGE sql
    AS $$
    INSERT INTO webhook_events (place, occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id)
        SELECT at_us * 16 + rank, at_us, event_kind, event_word, r.fleet, r.robot_id, of_whisker, of_number, of_command FROM robots r
        WHERE r.robot_id = coalesce(of_robot, (SELECT w.robot_id FROM whiskers w WHERE w.whisker_id = of_whisker))
        AND EXISTS (SELECT 1 FROM webhooks)
$$;


--
-- Name: webhook_setpoint_failed(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_setpoint_failed() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(4, 'SETPOINT_FAILED', NEW.state, NEW.recorded_us, s.robot_id, s.whisker_id, NULL, NEW.command_id) FROM setpoints s
        WHERE s.command_id = NEW.command_id;
    RETURN NULL;
END $$;


--
-- Name: webhook_trim(); Type: FUNCTION; Schema: public; Owner: -
--

CREATE FUNCTION public.webhook_trim() RETURNS trigger
    LANGUAGE plpgsql
    AS $$
BEGIN
    PERFORM webhook_event(1, 'TRIM', NULL, NEW.detected_us, NEW.robot_id, NEW.whisker_id, NEW.trim_id, NULL);
    RETURN NULL;
END $$;


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
    test_id text,
    parent_id bigint,
    not_before_us bigint DEFAULT 0 NOT NULL,
    subjects bigint,
    shard bigint,
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
    whisker_id bigint,
    kind text NOT NULL,
    shelved_us bigint NOT NULL,
    until_us bigint NOT NULL,
    shelved_by text NOT NULL,
    reason text NOT NULL,
    robot_id bigint,
    CONSTRAINT alarm_shelves_subject CHECK (((whisker_id IS NULL) <> (robot_id IS NULL)))
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
    whisker_id bigint,
    raised_us bigint NOT NULL,
    kind text NOT NULL,
    cleared_us bigint,
    acknowledged_us bigint,
    acknowledged_by text,
    acknowledged_reason text,
    robot_id bigint,
    CONSTRAINT alarms_subject CHECK (((whisker_id IS NULL) <> (robot_id IS NULL)))
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
-- Name: archive_horizons; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.archive_horizons (
    fleet text NOT NULL,
    shard bigint NOT NULL,
    written_to_us bigint NOT NULL
);


--
-- Name: archives; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.archives (
    fleet text NOT NULL,
    archived_to_us bigint NOT NULL,
    planned_to_us bigint,
    next_contact_id bigint DEFAULT 0 NOT NULL,
    files bigint DEFAULT 0 NOT NULL,
    contacts bigint DEFAULT 0 NOT NULL,
    bytes bigint DEFAULT 0 NOT NULL
);


--
-- Name: arrays; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.arrays (
    array_id bigint NOT NULL,
    robot_id bigint NOT NULL,
    "array" text NOT NULL,
    array_type text NOT NULL,
    whiskers bigint DEFAULT 0 NOT NULL,
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
-- Name: black_boxes; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.black_boxes (
    black_box_id bigint NOT NULL,
    robot_id bigint NOT NULL,
    whisker_id bigint NOT NULL,
    cause text NOT NULL,
    event_us bigint NOT NULL,
    began_us bigint NOT NULL,
    ends_us bigint NOT NULL,
    last_us bigint NOT NULL,
    state text NOT NULL,
    messages bigint NOT NULL,
    left_out bigint NOT NULL,
    has_state boolean NOT NULL,
    bytes bigint NOT NULL,
    body bytea NOT NULL,
    CONSTRAINT black_boxes_state_check CHECK ((state = ANY (ARRAY['RECORDING'::text, 'COMPLETE'::text, 'PARTIAL'::text])))
);


--
-- Name: black_boxes_black_box_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.black_boxes ALTER COLUMN black_box_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.black_boxes_black_box_id_seq
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
    CONSTRAINT changes_kind_check CHECK ((kind = ANY (ARRAY['HEALTH'::text, 'TRIM'::text, 'COMPENSATION'::text, 'SETPOINT'::text, 'ERROR'::text, 'ALARM'::text, 'ACTION'::text, 'POLICY'::text, 'TOUCH_TEST'::text])))
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
-- Name: console_sessions; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.console_sessions (
    session_id bytea NOT NULL,
    actor text NOT NULL,
    sealed bytea NOT NULL,
    created_us bigint NOT NULL,
    expires_us bigint NOT NULL
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
    ratio double precision,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL,
    place text DEFAULT 'RATIO'::text NOT NULL,
    distance_mm double precision
)
PARTITION BY RANGE (received_us);


--
-- Name: contacts_20261128; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contacts_20261128 (
    whisker_id bigint NOT NULL,
    boot bigint NOT NULL,
    seq bigint NOT NULL,
    "position" bigint NOT NULL,
    t_us bigint NOT NULL,
    received_us bigint NOT NULL,
    ratio double precision,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL,
    place text DEFAULT NULL NOT NULL,
    distance_mm double precision
);


--
-- Name: contacts_20261129; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.contacts_20261129 (
    whisker_id bigint NOT NULL,
    boot bigint NOT NULL,
    seq bigint NOT NULL,
    "position" bigint NOT NULL,
    t_us bigint NOT NULL,
    received_us bigint NOT NULL,
    ratio double precision,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL,
    place text DEFAULT NULL NOT NULL,
    distance_mm double precision
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
    ratio double precision,
    deflection_mm double precision NOT NULL,
    strain double precision NOT NULL,
    pressure_mpa double precision NOT NULL,
    temperature_c double precision,
    used text NOT NULL,
    residual double precision,
    length_mm double precision NOT NULL,
    length_sd_mm double precision NOT NULL,
    place text DEFAULT 'RATIO'::text NOT NULL,
    distance_mm double precision
);


--
-- Name: epochs; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.epochs (
    fleet text NOT NULL,
    epoch bigint NOT NULL,
    owner text NOT NULL,
    holder text NOT NULL,
    began_us bigint NOT NULL,
    shard bigint DEFAULT 0 NOT NULL
);


--
-- Name: event_outbox; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.event_outbox (
    fleet text NOT NULL,
    shard bigint NOT NULL,
    epoch bigint NOT NULL,
    number bigint NOT NULL,
    events bytea NOT NULL
)
WITH (autovacuum_vacuum_scale_factor='0', autovacuum_vacuum_threshold='2000', toast.autovacuum_vacuum_scale_factor='0', toast.autovacuum_vacuum_threshold='20000');


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
    entries bytea NOT NULL,
    shard bigint DEFAULT 0 NOT NULL
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
    expires_us bigint,
    shard bigint DEFAULT 0 NOT NULL,
    shards bigint DEFAULT 1 NOT NULL,
    shards_wanted bigint DEFAULT 1 NOT NULL,
    log_next bigint,
    log_topic text
)
WITH (fillfactor='10');


--
-- Name: log_archives; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.log_archives (
    fleet text NOT NULL,
    shard bigint NOT NULL,
    topic text NOT NULL,
    next_offset bigint NOT NULL,
    planned_to bigint,
    seen text NOT NULL,
    archived_to_us bigint NOT NULL,
    files bigint DEFAULT 0 NOT NULL,
    contacts bigint DEFAULT 0 NOT NULL,
    bytes bigint DEFAULT 0 NOT NULL
);


--
-- Name: notes; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.notes (
    note_id bigint NOT NULL,
    robot_id bigint NOT NULL,
    written_us bigint NOT NULL,
    author text NOT NULL,
    text text NOT NULL,
    action_id bigint NOT NULL
);


--
-- Name: notes_note_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.notes ALTER COLUMN note_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.notes_note_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


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
    rows bytea NOT NULL,
    shard bigint DEFAULT 0 NOT NULL
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
    labels text DEFAULT ''::text NOT NULL,
    shard_hash bigint,
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
-- Name: rollout_events; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.rollout_events (
    rollout_event_id bigint NOT NULL,
    rollout_id bigint NOT NULL,
    recorded_us bigint NOT NULL,
    event text NOT NULL,
    stage text NOT NULL,
    actor text NOT NULL,
    detail text NOT NULL
);


--
-- Name: rollout_events_rollout_event_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.rollout_events ALTER COLUMN rollout_event_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.rollout_events_rollout_event_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: rollouts; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.rollouts (
    rollout_id bigint NOT NULL,
    fleet text NOT NULL,
    kind text NOT NULL,
    change text NOT NULL,
    state text NOT NULL,
    stage text NOT NULL,
    place_max bigint NOT NULL,
    level double precision NOT NULL,
    robots bigint NOT NULL,
    looks bigint NOT NULL,
    probability double precision,
    changed_robots bigint NOT NULL,
    unchanged_robots bigint NOT NULL,
    changed_error double precision,
    unchanged_error double precision,
    started_us bigint NOT NULL,
    stage_us bigint NOT NULL,
    updated_us bigint NOT NULL,
    started_by text NOT NULL,
    reason text,
    CONSTRAINT rollouts_kind_check CHECK ((kind = ANY (ARRAY['POLICY'::text, 'CALIBRATION'::text]))),
    CONSTRAINT rollouts_stage_check CHECK ((stage = ANY (ARRAY['FEW'::text, 'QUARTER'::text, 'ALL'::text]))),
    CONSTRAINT rollouts_state_check CHECK ((state = ANY (ARRAY['RUNNING'::text, 'PAUSED'::text, 'ROLLED_BACK'::text, 'COMPLETED'::text])))
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
-- Name: touch_tests; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.touch_tests (
    touch_test_id bigint NOT NULL,
    test_id text NOT NULL,
    robot_id bigint NOT NULL,
    whisker_id bigint NOT NULL,
    kind text NOT NULL,
    reason text NOT NULL,
    contacts bigint NOT NULL,
    state text NOT NULL,
    error text,
    requested_us bigint NOT NULL,
    updated_us bigint NOT NULL,
    ended_us bigint,
    touches bigint DEFAULT 0 NOT NULL,
    missed bigint DEFAULT 0 NOT NULL,
    length_mm double precision,
    length_sd_mm double precision
);


--
-- Name: touch_tests_touch_test_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.touch_tests ALTER COLUMN touch_test_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.touch_tests_touch_test_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


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
-- Name: webhook_dead_letters; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.webhook_dead_letters (
    webhook_id bigint NOT NULL,
    event_id bigint NOT NULL,
    attempts bigint NOT NULL,
    dead_us bigint NOT NULL,
    status bigint,
    problem text NOT NULL,
    again boolean DEFAULT false NOT NULL
);


--
-- Name: webhook_events; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.webhook_events (
    event_id bigint NOT NULL,
    tx bigint DEFAULT ((pg_current_xact_id())::text)::bigint NOT NULL,
    place bigint DEFAULT 0 NOT NULL,
    occurred_us bigint NOT NULL,
    kind text NOT NULL,
    word text,
    fleet text NOT NULL,
    robot_id bigint NOT NULL,
    whisker_id bigint,
    number bigint,
    command_id text,
    CONSTRAINT webhook_events_kind_check CHECK ((kind = ANY (ARRAY['ALARM_RAISED'::text, 'ALARM_CLEARED'::text, 'TRIM'::text, 'CONDITION_CHANGED'::text, 'COMPENSATION_BEGUN'::text, 'COMPENSATION_ENDED'::text, 'SETPOINT_FAILED'::text])))
);


--
-- Name: webhook_events_event_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.webhook_events ALTER COLUMN event_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.webhook_events_event_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
);


--
-- Name: webhooks; Type: TABLE; Schema: public; Owner: -
--

CREATE TABLE public.webhooks (
    webhook_id bigint NOT NULL,
    name text NOT NULL,
    url text NOT NULL,
    fleets text,
    kinds text,
    level text NOT NULL,
    enabled boolean NOT NULL,
    secret bytea NOT NULL,
    previous_secret bytea,
    previous_until_us bigint,
    created_us bigint NOT NULL,
    changed_us bigint NOT NULL,
    changed_by text NOT NULL,
    done_tx bigint NOT NULL,
    done_place bigint DEFAULT 0 NOT NULL,
    done_event bigint NOT NULL,
    attempts bigint DEFAULT 0 NOT NULL,
    streak bigint DEFAULT 0 NOT NULL,
    next_us bigint DEFAULT 0 NOT NULL,
    holder text,
    held_until_us bigint DEFAULT 0 NOT NULL,
    last_us bigint,
    last_status bigint,
    last_problem text,
    last_success_us bigint,
    delivered bigint DEFAULT 0 NOT NULL,
    failed bigint DEFAULT 0 NOT NULL,
    lost bigint DEFAULT 0 NOT NULL
);


--
-- Name: webhooks_webhook_id_seq; Type: SEQUENCE; Schema: public; Owner: -
--

ALTER TABLE public.webhooks ALTER COLUMN webhook_id ADD GENERATED ALWAYS AS IDENTITY (
    SEQUENCE NAME public.webhooks_webhook_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1
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
-- Name: contacts_20261128; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contacts ATTACH PARTITION public.contacts_20261128 FOR VALUES FROM ('1795824000000000') TO ('1795910400000000');


--
-- Name: contacts_20261129; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contacts ATTACH PARTITION public.contacts_20261129 FOR VALUES FROM ('1795910400000000') TO ('1795996800000000');


--
-- Name: contacts_default; Type: TABLE ATTACH; Schema: public; Owner: -
--

ALTER TABLE ONLY public.contacts ATTACH PARTITION public.contacts_default DEFAULT;


--
-- Data for Name: _sqlx_migrations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public._sqlx_migrations (version, description, installed_on, success, checksum, execution_time) FROM stdin;
1	0001_supervision	2026-11-28 20:58:33.830579+00	t	\\x1869762749e8bfdfe8dc03857ab2aa3b907a68c6ebd02714c30a5295bb8eb9efb475b3bbfe3a8f64b1cc8d0fd52b3d19	247773457
2	0002_leases	2026-11-28 20:58:34.08241+00	t	\\xcc36bf8273e4aba03c0806d4885cffdaaf037e2eb065701406c5f8fd2e03267ac6580227d9b4f09f1e0cec289f029683	36068111
3	0003_closed_loop	2026-11-28 20:58:34.119901+00	t	\\x5693773b033ed3c946205fd6afe7fef978ddb6cbf00d36c728390a013fda6b93349a75a89c9526f1291e7b956e8e177f	14597638
4	0004_rates	2026-11-28 20:58:34.138409+00	t	\\x730a83afcb22b5f61f546991006c34b860510ac1862a26e22ff60badbeac73e51543dfbbeac95662bc297d423503f3e0	4001358
5	0005_actions	2026-11-28 20:58:34.146407+00	t	\\xfc59122ac596454595cafc7d3af068ec84bd1ba834fd8cc18c4d3df4a42dd883541772f0cf1731a1b8d847830aa32755	32050569
6	0006_access	2026-11-28 20:58:34.182444+00	t	\\x504d14543c03f1dc787db4e20f28daa838a5b64ac87185bc5ebe4f7a828cbb4d29673be8baecc6b8cd8d7d753d367725	11967872
7	0007_alarms	2026-11-28 20:58:34.198419+00	t	\\x0653af71e05ebafac1ca2d75ad45f2542882715421957046e570a523b74d9518396f282050d273d5d0e5c18f3c09f6de	16009240
8	0008_changes	2026-11-28 20:58:34.218433+00	t	\\x0eb619d0a7e8439887faffedfcce5b5faa1a5a516d805632a8949736bdc78f3fa62350afb0bfc800e0acc9069323b0f2	15966206
9	0009_calibrations	2026-11-28 20:58:34.238411+00	t	\\xb5d0080ef17a10496fdee5add696e98665c5ab72c8af2828caa65683f694055401a3e5c6303ac00bd71fefd3d41fa9f8	23539664
10	0010_inline_states	2026-11-28 20:58:34.266424+00	t	\\x55fd90560d370defa4ff830d5861be2c45354b860203b4e35fd1e5e20aedcb637296d60bf9846ef736f89aa8e8d46ebd	4014328
11	0011_journal	2026-11-28 20:58:34.274431+00	t	\\x3c3975810f8d480c53ccbdb004c5c19cb5a8fcecdb728109afe413f4f43056228afecf1a193bf9f851982052d7db9c34	11991998
12	0012_history	2026-11-28 20:58:34.290407+00	t	\\x7c5cc25af5bd778e61de9af28030e39bb9a91c45daff53073543448845959a159a115ff87aa891a6f3fcc1afbff953e6	32220492
13	0013_redo	2026-11-28 20:58:34.326493+00	t	\\x4545e25cfd96bd0bad5d7f793ea7a54050b7dafb61c45164fa84ec9153a47fe1bc9b857ae114fe98f2f57831ae71bf0e	11982093
14	0014_quarantine	2026-11-28 20:58:34.338899+00	t	\\x0df715a4c3f7201f440dde5772ab55428d235e1f7a5076045766ebd185ebacadda6ea497be4989dfa47ee204ea275519	19542922
15	0015_allowed_robots	2026-11-28 20:58:34.359676+00	t	\\x7c85f14b198e1157f4e8c732ad9210819b335076ab4e3c904f1efb4ee8d7b045a2365150a7d14d8b9d10fdfcc421ce31	18796371
16	0016_supervisor_hearing	2026-11-28 20:58:34.382449+00	t	\\x3ff5dbc870cfa8ccd8a3af998b192cb90c82307e6b2d3aff49156549d03080c68111fb9573d6f5d2ae304b4583f76092	3972986
17	0017_contact_places	2026-11-28 20:58:34.390451+00	t	\\x955c570b190e6426d5c22255545adb995a198fc9f0ff8023bdd9f22200f328eaf87267d46ffbbb6efd61e21cd3f716de	3964894
18	0018_touch_tests	2026-11-28 20:58:34.398418+00	t	\\x79cef196cdcd852e4d502cdad13f4724c5acb10b1e3fbbe3d110e9e1cd3de24a7bc1fd50e6c040824f8034ca440ed33a	23997236
19	0019_robot_alarms	2026-11-28 20:58:34.426443+00	t	\\x9da0b70bd0a7817f992432f81eab3439b0925398bbe641c01ee92308365907e435955ab9d93f9371ca97b05ea26509e8	16019556
20	0020_list_indexes	2026-11-28 20:58:34.446466+00	t	\\x80d8f7f516ea156c200b56ae9b56ba85dce910b70396c08500e1e2f20c76d0daaedb59977be70c0c9eff2361cf1525e3	19995047
22	0022_overview_indexes	2026-11-28 20:58:34.467178+00	t	\\x275dbf0c8c8ff6553ab1a8707271043717aeeb2d83037133884723e23a3eb128011b2270c77f16beb9ce65d3c5de0d1a	28909562
23	0023_labels	2026-11-28 20:58:34.4972+00	t	\\xfcb5cc9f510dbbe519918cc655a5c5216e02798d400f2261f44b5a0ac243b95a5061d0afe127a4c26101be2a6c181e36	2090823
24	0024_bulk_actions	2026-11-28 20:58:34.502066+00	t	\\xc6dd90bafe19713c7963d6e773978a3e1fe8dd9bff64f708765ebaa030754d3aa459002fe1d7400bf3e56c5d7d69add0	13831057
25	0025_rollouts	2026-11-28 20:58:34.527022+00	t	\\xb8dadbdb4986c65a23387666db02b4066bcd01c1a23e34910785266a51a1c9291f024e0a09143e075a0fd812b86ad1a4	31479799
26	0026_webhooks	2026-11-28 20:58:34.561903+00	t	\\xd2a469dd4b03c2f421cc85df6afa0674824f5fc48996b08c17e5da22031eb9f03fedfac109384037d91abd112c186967	40551718
27	0027_sessions	2026-11-28 20:58:34.606425+00	t	\\x004f876b8f6c1cb79c87eeaf2aef9bbca7989c88251208e3d110383f7c8989df409cc3c0db56dacd3c8dfb51583e3ed2	12010726
28	0028_black_boxes	2026-11-28 20:58:34.622422+00	t	\\xd7df4dd6da9a1769d3ddc181b1ecec35ce35e7ea6c9ed551c5e4d98b59013b6045d3f2dc1d459157419eed06cd9b65a6	24032428
29	0029_notes	2026-11-28 20:58:34.650565+00	t	\\x3db54089e3f9bb0cc1b9f4e5282926e8d1c0e72342d252b112a26949b9005b2a7a2f720c9256383caf62742b3cc872a5	24648896
30	0030_setpoints_by_state	2026-11-28 20:58:34.678432+00	t	\\x374bb1a829fbac8b8886f9a1113ed030a775d991c1090b9ebf1cc3ee0af6ce68e8d41ab893782bb7e0821df01715ca91	8117959
32	0032_shards	2026-11-28 20:58:34.69044+00	t	\\xcab2fe39b5407e292877ce9436a872842933cb08ee0acd36401a4090ee2df0dd56dac9af5f7e800d32484ec80ce8ca20	32353790
33	0033_event_outbox	2026-11-28 20:58:34.726435+00	t	\\xd566429efa43247d4a8aee57824cfdcf8dd10ebfc20f403aafdd43fc3185b5cdab72a44492f66723a677b46e3943d678	15970533
34	0034_log_positions	2026-11-28 20:58:34.746621+00	t	\\x833295056479d6d4750c8bfa388821c4b68ed3223cd28c4b122b82f609f04c4235840b272ad0a1ec1f49bf6077c20f1b	3803735
35	0035_archives	2026-11-28 20:58:34.754424+00	t	\\xe75dc7288b6ab9b6f59fc77816bcc4111851d5d61a35b3710cd83b26e8068882ad9871599c2266d73032a29a094d0381	23982373
36	0036_array_whiskers	2026-11-28 20:58:34.782436+00	t	\\x71f6cc0ba002e95a7200e7b9e13b9acc10a0db9176b256aee480cd3d7969768da8dd0e412e89136b488c465570917ba9	3907539
37	0037_log_archives	2026-11-28 20:58:34.790488+00	t	\\x364fc4a8ba44331d222045a659b191f988dda425f6d5cd6a08c468af80bec79f8c943af873df72da327b8e7e636b2d40	15887389
\.


--
-- Data for Name: actions; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.actions (action_id, fleet, robot, "array", whisker, compensation_id, alarm_id, kind, parameters, reason, actor, role, request_id, idempotency_key, asked_us, expires_us, state, problem, done_us, test_id, parent_id, not_before_us, subjects, shard) FROM stdin;
1	\N	\N	\N	\N	\N	\N	TOKEN_CREATE	{"expires_at":"2027-02-26T20:58:35.160Z","fleets":"f","name":"reports","role":"VIEWER","token_id":"bc3dda9bf61d"}	\N	command line	ADMIN	command line	\N	1795899515160318	1795899515160318	DONE	\N	1795899515160318	\N	\N	0	\N	\N
2	f	\N	\N	\N	\N	\N	WEBHOOK_CREATE	{"enabled":true,"fleets":"f","kinds":null,"level":"WARNING","name":"tickets","origin":"http://127.0.0.1:1/…","url_hash":"63d3a2a6df5384e6","webhook_id":null}	nobody listens there	local	ADMIN	9b1875f0-4abc-4ae7-b46d-e8e579468c8b	\N	1795899515169048	1795899525169048	DONE	\N	1795899515169048	\N	\N	0	\N	\N
3	\N	\N	\N	\N	\N	\N	CALIBRATION_UPLOAD	{"calibration":{"a":5.255876425856451,"b_per_mpa":8.233259570471512,"c":2.778369447015907,"elongation_gain_mm":8.676619894902702,"name":"measured","youngs_modulus_mpa":0.12},"model":"measured"}	\N	local	ADMIN	c5a9c131-fcb2-4fd4-ab74-5e6f107fec73	\N	1795899515182645	1795899525182645	DONE	\N	1795899515182645	\N	\N	0	\N	\N
4	f	\N	\N	\N	\N	\N	CALIBRATION	{"calibration":{"a":5.255876425856451,"b_per_mpa":8.233259570471512,"c":2.778369447015907,"elongation_gain_mm":8.676619894902702,"name":"measured","youngs_modulus_mpa":0.12},"calibration_id":1}	new rubber	local	ADMIN	e312e90d-a1dd-4b61-bfdd-ed60f67ab53a	\N	1795899515190627	1795899525190627	DONE	\N	1795899515195404	\N	\N	0	\N	\N
5	f	crawler-1	\N	\N	\N	\N	LABEL_SET	{"key":"hall","value":"north"}	moved	local	ADMIN	91c48ac7-9924-4c43-a321-457378b3a8fb	\N	1795899515459579	1795899525459579	DONE	\N	1795899515459579	\N	\N	0	\N	\N
6	f	crawler-2	\N	\N	\N	\N	LABEL_SET	{"key":"hall","value":"south"}	\N	local	ADMIN	2d30e2a5-a5fa-4ecf-95fd-ad48628b4748	\N	1795899515471172	1795899525471172	DONE	\N	1795899515471172	\N	\N	0	\N	\N
7	f	crawler-1	\N	\N	\N	\N	NOTE_ADD	{"text":"The right array was cut at the gate.\\nIt awaits new whiskers."}	\N	local	ADMIN	44c9df4d-282a-4598-9b9d-a5cb0931da30	\N	1795899515485302	1795899525485302	DONE	\N	1795899515485302	\N	\N	0	\N	\N
8	f	crawler-2	\N	\N	\N	\N	NOTE_ADD	{"text":"The gauge of whisker 1 is open."}	\N	local	ADMIN	eb907ac7-0b78-45fa-bcb3-ca902ac1f087	\N	1795899515501812	1795899525501812	DONE	\N	1795899515501812	\N	\N	0	\N	\N
9	f	\N	\N	\N	\N	\N	ALLOWED_ROBOTS	{"expected_version":0,"list":"4314bafb-22ed-556b-a64c-ab2322689e01","robots":4}	this hall's robots	local	ADMIN	8a26c483-81ae-4db5-8c64-944f6adec3b6	\N	1795899515517974	1795899525517974	DONE	\N	1795899515517974	\N	\N	0	\N	\N
10	f	crawler-1	tail	1	\N	\N	TOUCH_TEST	{}	is it whole?	local	ADMIN	3bf53a3a-91da-48b7-89f1-058e875e8a7b	\N	1795899558185704	1795899568185704	DONE	\N	1795899558192917	\N	\N	0	\N	\N
11	f	crawler-1	left	0	\N	\N	SETPOINT	{"pressure_mpa":0.08}	a try	local	ADMIN	b947a5b8-b8b4-4fe9-a1ea-cf617a01baee	\N	1795899558344906	1795899568344906	DONE	\N	1795899558351208	\N	\N	0	\N	\N
12	f	crawler-2	front	2	\N	2	ALARM_SHELVE	{"until":"2026-12-27T20:59:20.436Z"}	a new gauge is ordered	local	ADMIN	9aa561ed-2b94-4ed6-ab45-54f823c87ebc	\N	1795899560440078	1795899570440078	DONE	\N	1795899560440078	\N	\N	0	\N	\N
13	f	crawler-2	front	1	\N	1	ALARM_ACKNOWLEDGE	{}	seen	local	ADMIN	aea618a0-daec-4a4d-8480-a57c1d8df9d5	\N	1795899560497072	1795899570497072	DONE	\N	1795899560497072	\N	\N	0	\N	\N
14	f	\N	\N	\N	\N	\N	POLICY	{"change_margin":0.1,"expected_version":0,"longer_for_shorter":"LAST_RESORT","mode":"ADVISE","objective":"TIP","own_role_cost":0.25,"predicted_error_max":0.5}	a shift without automatic changes	local	ADMIN	8f43a721-5bec-43eb-a0f9-784bb1de44ab	\N	1795899560530883	1795899570530883	DONE	\N	1795899560539434	\N	\N	0	\N	\N
15	f	\N	\N	\N	\N	\N	ROLLOUT_START	{"change":{"change_margin":0.2,"expected_version":1,"longer_for_shorter":"LAST_RESORT","mode":"ADVISE","objective":"TIP","own_role_cost":0.25,"predicted_error_max":0.5},"kind":"POLICY","level":0.05,"robots":4}	fewer changes	local	ADMIN	08e0ad2a-0340-405e-b622-4fe6a99e91f0	\N	1795899589301075	1795899599301075	DONE	\N	1795899589307522	\N	\N	0	\N	\N
16	f	\N	\N	\N	\N	\N	WEBHOOK_CHANGE	{"enabled":true,"fleets":"f","kinds":null,"level":"WARNING","name":"tickets","origin":"http://127.0.0.1:1/…","url_hash":"63d3a2a6df5384e6","webhook_id":1}	try now	local	ADMIN	5de81a14-fb8f-49de-9fc0-b97672b3b88a	\N	1795899589445532	1795899599445532	DONE	\N	1795899589445532	\N	\N	0	\N	\N
17	f	crawler-4	left	0	\N	\N	TOUCH_TEST	{}	is it whole?	local	ADMIN	d4cb71c3-a62f-4903-9cbe-3b61d006f8d9	\N	1795899602213236	1795899612213236	DONE	\N	1795899602219548	989aca66-e8c1-5a6e-ab68-10161aaf11f0	\N	0	\N	\N
\.


--
-- Data for Name: active_calibrations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.active_calibrations (fleet, model, calibration_id, activated_us, activated_by) FROM stdin;
f	measured	1	1795899515195385	local
\.


--
-- Data for Name: alarm_shelves; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.alarm_shelves (alarm_shelf_id, whisker_id, kind, shelved_us, until_us, shelved_by, reason, robot_id) FROM stdin;
1	3	UNCOMPENSATED	1795899560440078	4102444800000000	local	a new gauge is ordered	\N
\.


--
-- Data for Name: alarms; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.alarms (alarm_id, whisker_id, raised_us, kind, cleared_us, acknowledged_us, acknowledged_by, acknowledged_reason, robot_id) FROM stdin;
2	3	1795899543852206	UNCOMPENSATED	\N	\N	\N	\N	\N
3	\N	1795899560427879	ROBOT_SILENT	\N	\N	\N	\N	1
1	2	1795899535222999	GAUGE_OPEN	1795899560427879	1795899560497072	local	seen	\N
4	\N	1795899560429199	ROBOT_SILENT	\N	\N	\N	\N	2
5	10	1795899588874412	PROPOSED	\N	\N	\N	\N	\N
\.


--
-- Data for Name: allowed_robots; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.allowed_robots (fleet, version, robots, changed_us, changed_by, reason, action_id) FROM stdin;
f	1	crawler-1\ncrawler-2\ncrawler-3\ncrawler-4	1795899515517974	local	this hall's robots	9
\.


--
-- Data for Name: api_tokens; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.api_tokens (token_id, name, role, fleets, secret_hash, created_us, created_by, expires_us, revoked_us) FROM stdin;
bc3dda9bf61d	reports	VIEWER	f	\\x6cd9102c551409e95c5d458707b5d2ca3d61ba24f6bf24b5e4a9dd45df433de4	1795899515160318	command line	1803675515160318	\N
\.


--
-- Data for Name: archive_horizons; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.archive_horizons (fleet, shard, written_to_us) FROM stdin;
\.


--
-- Data for Name: archives; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.archives (fleet, archived_to_us, planned_to_us, next_contact_id, files, contacts, bytes) FROM stdin;
\.


--
-- Data for Name: arrays; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.arrays (array_id, robot_id, "array", array_type, whiskers) FROM stdin;
2	2	left	TYPE_1	2
3	2	right	TYPE_1	2
4	2	tail	TYPE_1	2
1	1	front	TYPE_2	3
5	3	left	TYPE_1	2
6	4	left	TYPE_2	1
\.


--
-- Data for Name: black_boxes; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.black_boxes (black_box_id, robot_id, whisker_id, cause, event_us, began_us, ends_us, last_us, state, messages, left_out, has_state, bytes, body) FROM stdin;
1	1	2	GAUGE_OPEN	1795899535222999	1795899533878003	1795899536222999	1795899536080660	COMPLETE	19	0	t	27511	\\x1f8b08000000000000ffcd7c59b3e2c6b2f5fbf73378a5bd5555aab123ee4369601648cce286c3c13c0810834080e3fcf72f4ab8dd08746cb7cfc6e7f2b0634b0848550e2b5766967ecd1da6e3e9f23c9dfc723ae6be4226081782e83a671c00fd4b2e0a77cb71ee6beebc1c1d96c7e3503b84a330fae9180da3a936d3c68761bc9e1e7e42b92fb9ddf0ba0e8793dcd75f73b3f0b01946b9aff04b6e3155a772a6342dec3aab706e4b29a551507f4bf5dda805a0836c52ef1516f58d13fbbdfaa67ef380f466e510f71a177af2655c5a9cf25e2df642430cb5c89c3a1539ce2ff272d634e7259d979de22df68d25be360c3728c9e119afbd5ad7f44acd604107b5fb6f76d49f315a47b576e7e6b703e8f76ce4df8c858f7cbd6e35dbf24f5fc9f724a20fb695f368eb19f2475e5eeac84afe786739ee5e16c65c1e6b5512f78b76519d3fcc6746d6f9aa68675efff8ca7dc9c58be531981e8eb9afff9b5bc69e9c27bf6d1b2622db497fbd1e2dc1d5b1ca17e9150d7132cc78103af351c797c362c79266722eb231757bdbddfc86486c99f8e21a717d9e087d5bd60119ac2f973a5bbac66a706ce01035a352f1787fbf6a578b105c43dc987aae6cfbf53e3add12d91a37af7e185e96f3319aceae462d4eaedfaf77e0da9eb447f763d32c36f9b5e777eb8de4438608b518b270edbb9789d6b39d2aa40e2bec70e442169719fe7eef26d583f66dbd3b150c75cbb16d4be918c6de8e99cbce55d48ea52cef2c294de9c652aab793574d83a3c31c8dc21e310771f394dc8709d0f1085de855ea88d48d7672523aab7ce13c328c13a34158bb6a776596b5c508c5dee894df554d7e6648d6ed4a7f0588d1ee71e49534add766dbc392d3c3b0e635667451b9e93ef00646abca903b8c78f7063c6c10cb5935a7deaa2745a7e04e3715b3331c534f5f51b7531f0cc38529fb5aaca9d755bbb5b19f1fcfc3850be2786689d6643f2677790e5de3a62f656f5aac04754db6d6d67a5218785c2bc42b905cc22a64e799f9529f2fa40717756f46578da046cc96c7ef375a6ec811078b430d78f5ab350b6ca36b137352ee68ee7db187ac92cf77aed02b8e9b1bd9740b409b7bde66b50dedf27d59c369c7cb978deeb95abef4afa52e1f198bd2c52a0cbb0d2fd1b5acc6e7822dadb57da958963718d62f950e5a75ecbede85e6fd5ef2d752c791c1c1d602cefbad6ac93c8d5d3037a516803d6a8bd968dd194673e46bbaef36db867f3340ff34cdcbfcdaf2eaedf170bfecb4fbd78ba74da727a7430ec1864f663bcbd606bdb5d9f5771b1dcc0bf63ad40a6860767bf68adb73a703b146aaeeb2b339ce4ec1b49c3f08b9092696d746b7465029dd16f8be4ec6d23147f94263dc748e8772a9d9117e2b08e57a0e6a71a930f63dff9bebf7f2fc28c4b09384225910a765c7b64ab8c3b4d1edecf7a05ad38d17f416a816d7fb0dac25c751d516ecd65ab84ab7e6c6db5cd71d86dac1adcca46d6ebcbb59de5fd5efc7cecaac7a9e37336e6c7c2e8e7bdba02c6575609e9b8176ce378b6d65fcd581d9ac94fcf3e1d42d5b5cceab03733467c306bc349b562ce3eac03cd6e9ceadace1ed164abf3a3097a3bc664f87c59b0556ab8a61dcc637c7f502c3a845959b05bcb67f310eabe1e01478529b69756904b21fdb8e6c1c0d3937ae72de91625e831a2e5b798dd70d97696a4d04dc6fbc3d1333eb42fd61d71438f0dc2edfec3a954acfe762799baebdf3b12e2d8ac7c3ae69b995babbd1835da752069b385fc1d58d77085aba75b516d58119e6d723d7a3c55d50997a2b998fc6e3a6fbb8567ff4aa1806974e3bb9dee5d2b8981e9f6968d9f7e4b61c55e48096b79ea1afa82d299ebb728c5c2db6aeab42c738866b57968b75d733d17286e5d6f7b11c9cea746eb1e9191b51599bcbc6d0d948934aaf2c49656eadcbfd61735cef04d6edbc9a7748b5dd2d9e7d507667fd9bd1e49549671406d7b210235924d353a179d017050b9d806cad31e816eb53bbe34eb5a3bc148fcd60a847b12748dd2ec4ce72d20c56acd5d69d83d7248bae28eaa32872a7b5b331be6d027bd8eb966da10f79895f476e733e2ff42c9d1ce2e6c2d95e8a218826eee8509487a2e6d8a35acd8fc55ad6ca9d71e1f20d7ae635ada0e1c894d2ac7a5ade5f00a7570c07d62428da1e9fc879e04caafdc82ad3c9cd63db60643b17b9e95a62bd1b796c59ea74ead1a653b0087480c7a24ad56ed4af4664455e687860e903502bf56e6b33320e6dafb7d98ded022bcbc8d83b85bdd7889c694716f2b82e4121da7b85625ceb98edd6d8d6f802e92ee89d2e96a0489435b7a1ad5cd43bf7da58bb2d0326a5fc9fdc97eff0e895a59c47a781de25831e8e9c95bc3a7e69412f63633e1bcdbd637168958bb0288bc62e8e65726eb784fe0dad06152ec216289edab17db4fc7b781db46aa765b9bf684fc32a1ea25a0935ea51ef7439dc432373ab5e3420d3597bdddcc773d4bb5d26c73bfcc5feb28158755eae07f972d1bc471900f0d4590604b4eec737bb7c70d69b42fb3758225dbb5b3fc4e589c5cb1b74b1cc68ba6ae8dea0e3c861cfeddc3f747f9d46d8e67c70009e778747958c789edff7acfc71c23d2ecb665585e7b9c5a5546fdfe39c4fc316391569740ad068593b26673d4159bd7f83d21acf7d4fdeb1b8846f9bd5b53aad7544772ecf6e12fe8cbc4342bedc2ea1dbf565ed8674521056a1df2e78cba0bcbbe5ed26c7f9603b29bac51564d67673d0e7621ded76de36deec57f9d68239e2e4ba3b6f79c30128f4291d189616553d7499ec41ddb3875db3218a27cf8b3439d33457d306726ca2db8a2fe215d6cc4397bbd79b3cb68344cc237086ee04188b76bbe56ad5abbf127ab48d3541286adc6536c3e55198bd25aeae4071bbcb8bc171a2b91cc1eeedfe1da2b2dbba0dc710ab9878f8d43ed9e5a85e34ac823cc1fb7d4bd3cab73469d0e6f55690dd2d0d6273ea33606f67e3c40ca534fda079cb4b392b5fb7634fccad73a119f83d6fd90fb10adb4a5604b466c331968756fdd2ab75cb637fed1f88a93bc4ba43a9b959188582347781ef95ccf3b134f486d5a16b1b13f772b943a94bb7965d6b47a5489e1cd96995c6a43a6edbe3fc583bc4ceb455d3ead5631385978b710ea8689ec7f90370bd8901342b9a8eda5ab4de05be06825894ead3513b5ead43db1f55e3b2368bb7664b84e86077dbe1ded16af1e9d07503e41df7de117b9ae1ec3b5dffb6338e3bab258ef9c3b8d1e90e3ac438869743c3ce57391d77c2eea2c4d7d7626b62f9de30f0e6c6a01b385b4c6391c8dfb832d33147eb2bb4c685eade3b885a2f680490f2fbfb95a9af8db4d8205db7244646f31899f3ceb1802a861b4d57ede686ac16e028d7d16271dadea1d9ece5f5fc4ab30ac8d7848bfd1434b31dd76ab7b03aaadca1f9582f881ada7b155f24c727766035b49c953aca67fe1c9af7d77efd6e5772827786d1ccb3a83fd64a7c4fd5b57bbb761aed3b5a278c579e27e52ea8748d7ea085534da874751754716550cd1f06a8eace0df5fefce46fc4a9cdabae34e7bba03adbeccacd9b7373dc2130579dd266718c852dcbe6deead7dd595b2c3af6f522cbb4ac642b8ea59c9b0729cb92c5b22e2dc7a067a1cb595f8b6549d3e28e4966c29127a6055e0d69a263ca580ea5d6d7fcd891b2ea5bfcaceda566256b9740f8d1008bf69507b46b76008e5dafd2da75aa2dab7f14ad255d7b6144641bef1484fbeda6e79ef5d5ae53990fb7322fcad58d170d767afbb65610dedd75c76e0b29081f8dda32ff17c1fb770837bb78fe0dc2ad8559456ebebb32b0712cef3c5999d684575c2f7b9a36c397b63c6c1ac1bc345e7581710b4943d64f75e459b5d5d091b7ed0eca46becc66243f9ff4b56b998c6563539acdcd82c28dcd3936cc2538364723dfb66e3a9ff7a2b03528c24de9e4d6d8d93008b53bc351fe160a320dcd56f9e634db8d45a1ad6fc1bc596cdcbac5a9bb69b87ed133aed5d5b233ac14ed40d0485ad601749bd140ee6e88b2783d59f36e51277bd39d5d9b063bf5d7c16856ef07e212f292c89bbbe6b9efccdb7a9579b3c5b5b62beeaae6c61d9f2a722110b2bbeb6dc5176bef19c2f36e02e12aee9359636937f6dc9f58d5d3b2e8895363d1a9836b58b00e98102fd6fba3c0c5b74dd7ba7031f2623cee046e6bb212d678e59c3dde3e166db7e5caa6a515f5a9b7406cdb298704424b0651c34393400395e9a1b5b6d0d51c7b97764b038dc1a9d5b46529e87bb36274b20d73b50f35b36032974cac5b3b2fbba75883ba53f28a6ead6c5b9541af299f217cfeca70e7e35abf16ff7b96bb18e395dbbbb0aa05aaaedbc21bfb6a4489db1aa7fc304f579756b9ce02746db79c229168bc76db77966b9e4d8660b01671a36916acb6cfe7e1f0ce722b0b1dd4fa95f37c8ed65aef58bbb3e219f1f8357f9eb5ef2c5756cee623cb955d7ae9a0d5526c5c0c8c11b8b35cb4d8565cb298340f77d696bc6a6816ac625e9e462996ab4501776fd7c5ed16cb7916cb2dd46e172b10a546406f2be43612398c45f9e8c1983976fd521949eb1eb32e57be77c7b3a3d5a6c361b971773d677caeaef4129320bfd92cadf3bc280dd004a5d6c08ad7edad57710efa8d79b39b6488eb7ea323c7ee0dcded3d94f3eaf8eaee37f3a105879b29b17a076fdf2c5ba4dda919a66c9afbdd61e01d786bdd7176e16c675a3a9f734de5dce5556905b441cb32dd53613e5b699be1ba7c67b98dd5c065b13938b6faaedd9ac63534163ad746fb861edd2171da1f6f58b72cd6e55b9e8eda73adb26be65dd4f02bbfc1777d61c873d345e51910aba8707177cbc3ec96774ce0dd7fc369d49ddb6d25bbf355b3e3a0a6464c373f58785a735a6adf75b2191a85589a0539b0c4a2538bea9582298a73db43443faceeca2e61cf8c2d578fb6236bd836eb17c789bb81d55f76ea77682eb9a101dc956c95da21ef4faef050341d30f4e605b76d3bc925c303ae373da3643823160bb83778df351d28ad69af78871aa3e984756babc58637d24edd607580facc367ae6ca7361bd192c10d54bf6d24353575be6c7c1d82b356696582f0bae6e8d5776c7b1275dc368f86dcfda9fb6b6584deb8712a27ce335f6e7adad358dc9b9543de7dbeea2e9820017f441bbb42a5a7977719880420d79f975b9ea69357775ea8cd6dd56adbdab962efbd005c5fe68dd09b7ed5d15c4abaa9bef2e26eb86bfdc562ab26ed7bdf5a6e0d955b7efd4cd6dbdceef1506a3379d0d356eac5c6fa462564d2cf613b3c88ce66fef43cb69698deeb2e2de6e6eb74dcb7430318ab0b3fdcdb6c7952ae75dd317ed5dc172c6e36ab135a88dd116b75bd582e1ccb82d2bb5da16f1d6d62a23ee75b816956565542b39c66fe1b1326cd95214ce51cd3d978e49f54f1ab351b836e4458879b0e4d88d4285eabba07a3b80133bed4a7b259f826367dbe2db5b05a8747217948b50df73239ad0df8e1ff04ac1794deadebd3830d17b55cfebcc1c76d0ce126fcfaaa2521d98b7aa9d77f5ee7c1cdcd97bdf37aeee6e191d6f3c399e698b8bbbb7b5850512f67e235edd5df190b7e384dd2ffc91b4bb79ff66e960bb330c128eeeecbd68fa370b04b5f2c590e666ee00476a9ad6946e5feb797647361cc3888d939cc7321fd784867d4b68bc61b89ac6a771072c8a1b6f5fe3e3f6a5e6eebb263887aeebe3fdae533e79be2fe6d669ed1d90492cb49bd0aed9edfbd83db3edae53b5c2b5cc376f8d8d77d06bb07dddd6ab03f33aedfaaedf81bba022174bfec3d00f3d3b4cd26f05fd17b3d28d8ba5d5c23730661559df3843699e96edd06058d4a47bad36e3a2bf8aca12e38b2dc766653f2f46f3229014875b59e9d5eb7149ac4a818cf02cd6f44d2d8ccd85827e8d8ccdb03921cd4eb762d56ee12a1e9e87ab41d15e1e97eee8d030a63e6e80c126dfb4c56e220b02756bcd3d6b86b7db807b8e4b2f97e27a0434777c738d9e4e4781ef37241784c8e2bab566cd55c12f5ba8c53cbf8977dd622f8eaaeeb0e59ac66a76b207e54b8b0b5ec5c589366d36c37cd4b2f4dac16be9954db7d80ff1c81dd2b55103d37e301a147ae52ce8dfff0efda06f2e402394e581b53eb72c4fcc5af38ee31c4a17abe52d74ef566e8fedbab5450b6b365acf3d16939eed1659a76bc54608bdd81495c0596f2e4dcb6eb9276f51dd9f3ad559b49c5871bb7df5569b951354a7434864ad5808bd0a5d8d8125bcb020e379afea358cc1dab656eebe208b6ec9f20cea3260f66ca3606c7939ef0dfbdb9e6debfb95509cf47f723fffeb5fffefd7bfdac2f8ad26ae9de163e3421b87dbed741c2dc36dba87310ac3e897a5ea5d1c979b9f883e146438a463301ccf18c6b92fb9e3749ffb8abee4a2e5667a8c869b5dee6b0e01447f82f027c4db087c25fcabce3f900e07ea72d532c97dcd35eab572ddce7d82e4b3e1383a2ea6d3e8ef080effb2e09b70325ddfbfedb41e46d349ee4b2edcfe723ceda687f3f2181e7e5987c763ee6baede70ca7559cb7dc90d0f87e155351f7ebdff9bfb9a9b1dc2ad1234baeed42ab47dd7fe05a53b15bf7e3bc87d055f72975f369bdc57f001bee4aedffffd26cc767eba4eb73f218060ee4b6e3dddcea34572154b2edb1da6c7e3e930fd65b31baa4fc2c753c3cbb7d3e84b6e3b5dce17a3f09448007ffed7970729e0372910f947c5005f505a10f44d10f28fafc7cffffa5919e269bcf8259a1ea3a4a3d493b5da67f95ea48cf8ef1830d7bfe47eff7c96a53d1a53f4241f654800f425771846cb50dd39d129fe929b4c67eb7b2cb8abfd83418295eb1e86cb6db2e2ba200463f6baa24008fa25174d37bbe96118a937c6b9af087f00a5c81f124d6021f0a36880b10cd130a5e249342484409f251a7a158d0182e1e3aa710cc48b68e043e86a6d1f440304eb10890c3b0480ffb868304334c4744c1f44130067299412c252a241f551cedfb96a5440fcb86a14a05785ea1f881198120dc3e41e3e47b0ac35630c41f0b866449017c1f007e7ca951f04439020c6dfe8038c7144f9e39271e5eeafee89687ac9908e0062fa1b45e33ad4716ad1307a5d34f201899e764fa4234ad4a56fd327c79062f818396086a1e10f2094bd3f884611d07580dfe8039c225d3c2a940bc833560d61f4b46a1440a46eeaaf478e3f02260c844002bc1798f05f05a68c851240d775f668f98939bf84588245daf201c554280cfb9c109b61f90232a102c177cba7192156ff60544f870b48754a197aa3e50bc8a178148d0015e65f4423e8d9f201c542c590b7019360482855fd2e1ae6af90493e30d7d392098609a7f49dfae488a4178d1194616a0c3f591a671cd24f8bb1594ef09b933ec458653e2f8b06c413982384295742bc4b340c2086903cfaa7603463d1745df9c6e3aa212e48560af4594e8081829cc718cb00cf4c1cc5534e8b10864287ef034d0c30e4faa342894059a686f153a601d48719799f7f622018078f892307e835aac10f1dabd32937c03f9a6eff2132e90071f513ef4426f2f729138608c054f8e75c01d56bb860caea1e170a038cd01be305863a417a8a97a83b7d89fe802a75a5800991cfe37219c6053124340d992a04bc64644c5789f7a34b02c430ff34bbcf5a3301387e8c16046642260769c9282284a8dcfc6dc1020a20f41495c30ab55ff30c8ed2900915b9cb0a169fa64fa40394e2e69493acec4ce7309dc6021d73aa92f1b7f90052a8990ab14465142f718c279ce0d1d488507efc3675228c9848d35f96196081aa253caa934041e83b7d00092ac8a3a5119c516ac11f9893e7b41133c0e13b2d4d30461ed5c94566b2cdf5a7a201028ce11f23e73fff212c09409562fe0496924feffe7d257a22e8984fc090cf94c470c8a71c63301af209d7f90c4f7efaf68b900008bf0156c284d486835ffe14e0b6d34b94fbcaa9da71b09ee4befeef9fdc15498a3e7f7257aa667ffa5b50abfcff59a7ba2058b0a792f71fb952b60a8fd368172eb7d1432df7309dabd27c7850fd856aee4b6e3e3ccd93664335f7679697ed5d9ff923ff3647fad11ff94395124ca9828d77e64ff43fc89f745d472af07d8f830cbd3207f2c1c9934713c4195105c4b761874a54547ded013b32600d7d40429fb083034ab298fd679154ac53fc54d74d0ab82f888bf073d60901ff4460cb08d11800a2b0f4a1e40c5f158a3f3051a7537c4b2744b1c6b7911a0ca9481529998059ab26743d9ddd010a005279c3dbd2014c194af51008cbb035fcc17590760355445244ed6d5e80992aa2a52b35af1914f8d05f080ea54c30f156d108481591b8c84c54287c2abd21c4581215dfa74fa183544acc01c86cbcc0976c1d09ac68cfdb1c9460c052a28944bf2f1197107555aae84cb8209f5774664c7021de0b4decef179db16a69a68a5a2c6954bc2c14a52f1d2a4ed0e7d19a2c1d5222444a345d7df38be523f4c4a075a4b3a471fa36cba740672a9dfb1ec9784690d53f30c569d13062186591fb4f8b171412c8d3051108333897104aed8f4e0980a23a6f5327453a49651a5428c778110c0afa54aa019043d5557e9f3a11a72960a254c9f062691028891fd50920c3ef158d43acd0f03b32e18cd29bfe41914a131f44638089a446fe368532c4404aa182643801fa605815661e150a39d53faf8e94e1044c572dd72f0fa1832a0c7d2d583e351100a182a0b74a46899ef6023da351ab7a7ff0a9e6ac80e9c72a5c3fff1130718693fae47f87dcf31f25f7fc2f917b02004f4a83ef845bfe57e136cb6718c62ab43cc06d5606cc80aa693f421a6182e2370e37602620558da007c9546af46298f7b99f94cf7046c83b7d86238e582a060a2c32077c9e382aa63ac4aacff9368eca9120a90a2747190ad5d548c853639c0b8e14397c5b78e6aa2df858e5174a49af1930535a7fcc8031c6bafe56c998c06a80ed61962ca3310e3f90fe341102180420abeff66965610129480d6c719ed1ad441f023e991a24885015b2dfe6a042a5b5a95543eaf045a17a3233934a870981f4ada2f13b3d38fc0e6a30a3918a3e2057a89f1ef1c138ab98fe69e510c1194e650202abbec26b3a4cd40044aac74b00ce1a0ff97b784bd478aefae5772293f80f88a01058278f6c8b2478f39a9e27a1f8d1f2b122356fec6f11800857e6f0903365d419a0a2aee96a1be490a2acf4fcb3cc8b0002b18aec0f1d2e15045e0b814849fc58d9852a817e23a0134004448f4e2960c638195151f569ee0e31c1547c7e9f688c5394ee70658ec562a6002ca55040d83bcb6d040280d3b9463257f9da7c432a6c3df22da2ab71c5f7c126813a84a9362f87197c0b7ef0642a35c5b79842ddf7c126814c30f65d34a8f61dbc8658f814fd01632cc9e4deb76482b1549d9ee9aa3b97314ff0341ea27ab0ef44730205a72055a687191567f481c9d3d822e4f43e41f559b884d4d68137b64351c6dda324c6fc5f6f87821fff11d7aeff1f6888129d52a20648ff3be45efc20b95741edaf907b8c741dbf378552a2fc5d724f10023435559b9969223dcdeddf580c266a0027dda76499033804a8042edd0ce440a1cbdb022052e966aade40338696d007644fd3b46aaceef3e67cb324139cab299a87b6567603f5699616104edf8ab26a9a3c9500509681192a3751beffc80075d5107f63d799e80824ea7b48d1159978ed526225f11b8c3f4b264a852ac63c64990ae55f126001549afccf38a4ceb8784894122bca4aca2985cf551940e0e70d0e6498bd2e7832cf71f87db992eef16be98329cda61c1230f0ce6d74044390de13c692e18517d174a03c354d00195465cccfe9e612ca1854fa7a2702c1bf3f6874df6a99aa11d18c08013f7832ca9aeeb1d1a485f9366fc4142535d087726466471e927fcc1909245451a53faba861f2e48cbaae8adeefc420827498ea13882ce2a27aa8cf20a423a867edd0f9b4504f74c6949b3d344b33b6c1e00ff134a34ddeb95c0c257b711ea67933583bfe4089a88f65180a59b235e07d46c69850aa7b18b65715a90cbb7f6ae00a08047ae7a651a28616521c3413b4c9074c5a567fa8c94f43218a214df5bb05ca2825930f9dab6a676a961deafcad2844294fefb1e522b36dc15549e3d125854e40d63e56f0f7183ba742577debff0ab94b460b7f88dca1bf46ee381558f554de09ade83f207794a1c4bcbe1b66b245f3954aa17429e99d618f329eec36f99e17f10c7a47d46ec0a7763217ec139d256bb93823cf3ddbccb915f0cfe13d5333cba9e63bc89c7566cf4f1640147395bbbc4f324c597a3faec898c2d33f50b2872ca548ceb9dac7f23645320e759eaed5bf4aa6b2b9f466b1779a3de36a5c3755a3cf1249074ffbaa5547e4ad63a784439434591e1c32438ff0433c89f64eabe73aa729cac94846634f3d7fe169b659a7544759b6f56960cf294e666d1f9f429235764755bdfb91ad300c18fc344455b52e4adffb6408e5dd7f9bd671c19304e27ba286151d7edd0921d414636ae7b9ca22df19b904ba6fd07f6003ca355f336fa876d0a4e687a9a0f09d44456090ec607d08f7190f1e411f20790ac43f53931258d7517ab954daffcaeb92d9bc7f2640084c71ba489c88f85a5d49362da5fa8a4011e1370608c1095176f338cc9c555614f829e74614e99cbc71d5284098a506e79322c1eb037774f2c43805c740f18677d91805980bd526791c79c91a3284243dc9f746c8a680e9c948e3e17be93af3f1445841537aee91f3773e9f820226586a2330d733b79c93649b4fea4958404f76e0fe1808fd7fc72223f8776b0000
3	1	1	TRIM	1795899543174917	1795899541300135	1795899544852206	1795899544785848	COMPLETE	35	0	t	40746	\\x1f8b08000000000000ffed7d57d3e248b2f6fdf733b8a50795371d712e4a062b40c2c3c64407de83f06663fffb8912d3db0834d366e0dd88f32d171d0de285a42a2bcd934fa6fe99d80efbc3e97138f872d8253e432ea9909212880180987e4aecd7c1b49ff89c384e7bdbe96ed735b6ebde7affdb6edfdd0f8d91d1df764f8be1f63794f89408ba97c5ba3b487cfe6762b4de2ebbfbc467f8293119ea971296b26ce21567ebb1a39452665aff9b2d05bd2a8045e4d052333d292d8ba776b3b42c5d7da0fc516db5cf54ceecd056a74c89d25de97a6a9beb76616919f3acea670f5b7fd5b0fcec6aeab6b3f353d134e8b667168a7935c02d7272d3e629e39e96878679fbcebafea78f167bb756bfb66b73d86e3aa87d35276dd4c625bb02d5771fe1e784a27756f9636fe59bea671e7ee499adffb106a76b7f719e9863b5730bf4d4ca3819fdfa00ec40dceb78aa625fbf7f243e254e93e96e3edcee129fff91989e7c350ebfdb312d445783d662d19b824bd1ce9d959f31e5c1b44e9d7571dcabb7553753b79515be862f75ea75ab666b86cbdea28c69294d4ae3f01b88df006c766a0c4ba85d6ed9ddc5b6bd43607560bbf0ba6dcd570c96bbc54ab9213beada434e26790dffd24b673db7771e9cfa683db17cf774137994ee5f8acd5eedf6dccaa0b3b834db8d5239bc6a163aa20ec7e352d3e3eabc728a05c88adc098ce4115eb2768f7cfbedeec29fda67b29c2c2cfd934f8ea354d1342b95b6f040d9b8d64e4ae53bb65296f24e4ae9cbe12357efb6dd55de6a1518a99eae87500ebbbf552754afec82120ef2f6ecf6e393c7a3380e7a9bc2568cd099dffededb72c3c54d36dd1859b91b9e72e9d506a40bb38d54db6efde8db4265664974553eb784b12a5764bb3e833cedecadc1b4dcf766a83fb341a128d356b3985cfa0d4cdb4eb6d1a3d422f92ef30deaed1d376b57f696d9124a78e2689cbcaa59f7c55e95fb47efd81d5d656fd99adf1623bdf2c7eeae38caee2bde30d9776a40b5b2c268948aa27c5343f7d065022af7d4221dfbb20e4a3ec8986be059a4364f86efc8b7fa8bbeb2edf5b6e7e5aeee768b0a7c2655b332b56ffb62d7fc41925bd94ccfb249b9ee5849673733fc52ba9bb3d7e13bfadea579b86c993cb9f60c578dd37552c67373799a36acdb89a2e7e5dcadabf98e1e456b330adc4c3f3d737c001773a718bea5352a99155ff5dac3cee2b46b1ddc6279deab07ca59b41afeedb7ccf1d4b41a9b6acf63492f53ef20d236ac6d80961eb5fc4cbddba339c3ca02cbf292dd72a6de2b506258fb427feab7ca87ec7cd8e995021b363bca5b39dd0954c751b0cf9ed31be591b6c8cc87eb656f65d5d2f2ea093fc8cf97236f94b61759fbe05dc6567151c8b4a6463ebd1a989ee8d60be95e65399f153619daf48ed37a21ddf52468158cc66ee719aad25938991177735545af5ede284c382ecaab54e36c237f3b5f3624b30b0f7669b7b2237620321618a7338d9de956c6ed4a20d25bfdfcd89bb895dd781508a77d3da5332adf9e0eaff9cbcd249445d6779275efd2f6b6066e85cb641dbabd85694d44011a19a1dcca542f5f30cfb7c88e09dc7567fa4c04f3dcbc7db8887cc6dd695d09e679db4c17a425d69bf2edfa9db1b1c6c1dc2d8f4fbbf0d92c3f4dfa7e7b2466edeeb11e6ca99353aad0b16aeb3539b2d3710e9cf0b93a1aade36a6cbbfafc153a96bb58d58f85e664abcf6761600d5a62e2f58c2b9bad152974ac9d615433e56ee66a4351126773536b953cff649bb7d7e8b15f3255f35228cf7d658c8c9232e7aa75728aaabc33d5d8bca8715dc9b10b0d92b3938628991e37167e8d1b179556beb5324757e3680cfac1a5b9f48312ac5eafa3226b58dbdd6ee0f5fc20a8e7d68aeca46d6f16fe92cd780d4c079b86356075c39be055502fb88dc53c69a6374b7f61fb9bd9b9d1da742ce7e42cbd5a7a12ccddaaebe76ee7ea471fc58979f693074f6f9227949a58c5daa93099db392503b553c3a4bb50963f3df7ad792e39545ec1cd286b34eb7ac6392703e54df3ad9389a6f65c2d73f38d2a2e5d3cb61af3e2d6600440d5cbe45b63abaefc9c9a6fc74e12f8c5ca6e705ecf2e4aa8ba2ad7cf99116867bd917131c5b0ba023df352ad4beaa97c69639b95ddb49dbbe2d66edcad8eda830cc890b9374c964dc39a6fea3dbe3a9de4813bb96d168f2afbf5d49fe1e3d66fe779203387d6a2e275dca365b90752ef8db2782d8d812a389b62a502aaa46ea3d55c0d2ac35d25332fef475eb790559779b20a7a073f77929371a956bb56fed075a5c6ae9136c8de52cab6fdb3489e9cd260d6a3762763099ff5dc43dd63ad5ec99e2cbb7bff323c06c033254bdbb291ecf9649d5ed44bec4a16f6ce360d5fce8ddedc5b38706f8fa4b8fa7853b1e7a5f3a269da32eb9ffdcb824e1c77d25ba5ad5e7539f70763d19e67d01874cc624e54fcce66b69c9be54527ad0ae346cf77337400ac4db71da8b2280ffd4cb2831dab3eab4a2dfaff243e25a6a7aa526d1d5e38965239b7b71cc061b371706bb953719631c970d752ed2c228e6b2ec717735f199be36ebfa872fab51cb53375391a6d065e87ac2dbe1a8a8e42a10a659d6cbbb79974da393cde36e87ecef6b359f7d02e0e2fe1f5f29ecfb68de668b9a64db79e2f1d9ba306bf99ddd15c8df6e3e6c6b2dbd5a6b93ede74b23fcf5ef3fbc6a0787b5e3eb0c22cdf99d4c1cdede4a605ebdaad7a8818e87851fe69db5a5f0f6955191a127572c77bedce940ccfb488011c530743da949f9cac7b06cac878dcf694528b7951a99c3274ecf43578da24c7dea1925ce6f936dfde96d9ed553e01d7c6f13226d83eacb37f840d079ab4f8b55d291ffbd72ddede44ec1d46e383404e6d8b8b4cb2e43ed7b4fc8b9d534ec910a3ba6196335d6f37540d3b68368a27bac98de75eaf4c928ea270dd96a75c25eb5573d574bde4e2d3c2728bc7b6df9cd9ae535c5d76a69d5b2db1bf31330ae4ecd1296be8875019b219e48c6aae51f1ae567e64272767b74f43814a732f33c340f9bd09ac19e945cb3166392abc93b93bdaf3f02d32570fbcd1da2466baeca372d6ae976a47dcb1cfde361d9a07653587974bd23ce564ed4a82f67a9c3c0f8c915fae9d376e3ffc8cb6d76447bbb9cafa0b53ce9db6df2be5eb20cf8ee3b5b8850c57677c4db694bf28c09dbf2fb647690f08c30fba4713dc7462dd1bcc2bdeda14c7e1e85c3997cafdde3990132b130c3a7e183299c595794e2bc7a9a02cb747e5ddfa5c3c2e8dba7548ae3a3797efcd2d56cf37eaeb8e52db62ab6ab5912b2ae3d30818f9dc6952b5e4a0d8f7fdd1f46494f3bc5c133bb30eea38d92286373be2aad5eb1a8ebbac6f55b2ea804ecd2fce72f516bb2e4f46418ebc4669c81ac52d1be7764600cb8b46a54c7222988c7a24599aa345a325ac9c08ea47564c7a4751ad637f5eedcf67abebde0eba73cb97ad45cf298e172e08cfa7b203606ec5c873f2f6d5ac67fce4b6d5778aab7551ddae97193bf698278a1d8f0f5afd4ab72de6f33d2f16f39e33f6eb95053f2eeb3bb598a9a1bbcaf7db7e5b9938990caec971e75a341029de74b8408343dd296465a3656f81818603bdaf4b7fdaa97217f43a42cb632dfda5bb512e73db8888f0f9c11f55b7783d9daeb972aca57f8b526f8f82b5f4d70c166f3a725df5a8694e44c0b2752350ab937eefc6c9257363aa8ea2e3e943b671dc8c65cd8d607feaf9ca52c1bc404d6825afb299f1c6a60ae6ae48c2aeacb777592fbcee7a53aedad7e2b5e8d5ebc1659e1e2f8b2769ab9c73ed5f8b5ef7424edaed5bea5af195a98a4059ca6ca8a1619053f662206189a341d4f16a4c7c8f1a27e0248fc981e95d8d82df5a19dc4fd391d11b5f835c79d3b18482dc2b543b41bdd0f0ab448e1a85853f65eb7e0d745cd6b0c468cbbc56fa1ad4f36409e6c94eb9b9f0d77ebd73a5cd7ea16355fae59de7ecafc1dc3db16a5b565adae5e7176a769746fcc0e3e2648b6044a41aeb7028cc238c915c0e3c96b1f233d96a9c54dac991861a352dc3b78eb309b0688eacd5b05b68fb766116f41525d7ae725161a5aceb6c0794589fe7aa6f794d3f0b6666dd443976515ea6b05656776612f34aae4be5ee4cb556a60ab642b5abe9026822642ac17ab96cb7b66f54b6697ea95d92fce467d64a6696c68e79bdea46d1a225e6ad49d757f23cca39cd4a5d565662b1a82105547fb4a0e90cc1b4e5f5af478559310bba86e04aa2b57093e955a7b2e5e3510d5dc178382e6dcc4c6e3920de087b2668ee77f3ae3e65927641ae58be88ca7ad40c66d89dfa854e4776d29dcea5e9754f561d88afd9ab5239cb507ec1fbb7db064be7e4941b2557dab3cc52fa22973e80d2096c2b761d5a7b5f9e7ac1bc3c4a33d3f640b7e3a363713e2f891219d8b9599ef9288fda4e390340c79e3b64e9e333a3c0dded9c926d647b457fd6ded640ce336703cbda99037fd6ccac410198bd86e5ce0a197fbcaa36e62a5fce76547e92467e7a741a01fb34a313c55a65e617d76dc331fd79069aff76db7f64d6e3e7cc7adc775beee921bb6e67565fb36bc0734baf563cd46c50eafa4d2ad2acb50f8fae150495329f9e27a8c4cec9baddae4c0385bae6a87acbae95bf0f105cf6c8b2dc0faa76ad3da8e2f22dbb56418bb8cde1558dd1a69abcbae1fbcd797600ceb332eedeb26b7338a982bbec5a95ebc336ec2d3b074f6ec1aaee9dad82cf5797e5f4c8fd6cae07bee9bcdbdb4caf27e35c0922d9b57975b8776927e1ec4fb2eb7279b2bc4ee9e434c6c7ee3473b86539a3ee788ee681bf2b9dfaf9f4f5f6e34e0b3af0068db93363db9942daf52b55cc0f5b35dce898b9e4869c4ac7cbb19e015591132553cc7755bfb8d9a32bc82c0f3b165433b81c9496d91993ad6a60123edcf9c59919ccd80194a93d9cedb6fede9e2f819329772bd6fe5a6ffa7c8b88e3059d4a60d958f886210cb12f9a1c35cbdea9d86036b3c759608c170770cb9eed0e75a6c2aecfbadd19f68f7e396997268607d85ed66ebfa390d9cd3d95dd2d4e6b8e070e3cd60d63743506fbde18dfde30ae4d673b3b38cf03cfad1d922e2824b1307c3737baed8bd53ff84501556135ee2cec15f4cbfe859f374ea9b32dfce19a32a56a69a754ad5741bd79c62fe702d5e6cd8ebfaf0d72f60d5a29b63a736fbe16aeb0ed5d3f573bab9e9a00cbace7d337776cee4e0ef0ea6adf8349d1ea57d6bd4cfd7a71fd55b6befc2303b7b367bfe25b44f9e54cbad82cef3ba374b558abf9ed4dcdd5219a3687c8bc5632e0a240267dea9ab9859a36cf85456b661bfd994fb32567ed9f2e6ed77254d2ebedd3dd29aefbcbfaace598ad73d9744ec566dadf17c6495be261c6f4dbe6cebb947176578372b6347d6b33ae5c725b3aab0124fb9352c66f8e2acda5d7b293e38592b55a7157bb64af46f64a2c353a3740cf82d5cd757d9d096a1ecf0dffb841d55dc51ccf486b9c34eb6a067ad5600c69dd1d4f9b256b32ca577c4226b5d94ddfb1eb0d8ee7746e75654d435a46cf2b797ecf4ff6ff4036869b51db6b275b7b27d9d8ac7ad96970326bd65a1ceacbfab1d9b08fddbaa82a6b5883ebaf009f55b8567caf3b86b51aebc8cc6dddb6cb25f5fdf5285fef704faa5cf8f58589359c41c33b67d4f82ac2e7c5592738da39d4adcdc38c39d3a6c7a3b92cf7aeb7e7f7aec92f74ac55b0be018396353ece9d4c96edfa839ad19446602965adfded289ddd4a3ca70d53296be54f6749734b7657d5d0a679e98f73e9c995775739720b3bb64d53d9141dca75a132b730636c4b75de4a3347ab33bfbfb44b7c4d3316d040aaefd7c51adb3368c9b45d6a7736c7022aa96b338dfb7d530cdc925735e16696e4d5fe496afb6900bbe80ddbb5ea2c39e2de8687a623bf026d232d83792eb3aacca5da1d56fe320fcd19595dba036b78c802af79d90520371a96815ce60e2b7f6cf1f495f5d8666041d6297a4b580be6ae6f76eb8235743865dab92b5cd658c772d7bee91dfde47a96946e7767540fcdbe775a5f96b6f041e174b33d91879df37b6512d87a936c4375c1e16a43d4ef41d56b70e08547bfed4fedb55aad933de50572729470ca1c1d99f7d568936f9face2140315ac7b17831fdcf3d85accaec434d6cb86ca4db333dfe253e29b416ece552e932f8d2d6f9ade1ac3b163a9f2b4a308043ba721ab82d055c9c9b2f5b959591669ee8a87dc1f99e5ec203311a7b137320e26e0ed49bd1ba0635b6c7322731905cdcaba7bacce10156a7806f941e650f4b35e9f9d4c90dd4fe75ddeb5eb52ac418ed60ab3caee94add9f8781daff6fb623a63adfac41b5d4b968fba17a7935e839c2404648cfea55e59b445cd46ea3c6ec14bae93e9b52775afddb61f5dfee69874b5ee9c40d1dd6ea98dfda1f093e3fca15eae24b70d7bbdaf9e7cb0ca6e9da2cc6c267633dd9cf9a7e171552f3673746017ac8deb83ed7aec1449266bdade34e8f980b78aa0482d256d584a9ffcedf1b89c6766057f61e68d19f20b9bb455cfae9b958e499664e50f56d332c80a2bbd301dde35fd766e77983b037f5cb1aebb22f583b5379fbbc3f36c601d33ddae9637f1fbbffef5fffef9a3e5923ff077e308ef8b24467fbd5a0dfbfbe97a15ad97f4d6ebfd97a9ae93eca6cbdf28ee4adaedb23ee8f6479c90c4a7c46eb8497c469f12fbe972b8db779741e2730201c47e83f037246a087ca6e2331629846147bf5d9767129f13e5929b2b398917483eeaf6f7bbc970b8ff15c1e10f0bbe5c0f868bdba71d16ddfd7090f89458afbeec0ec1707b9ceed6db2f8bf56e97f89c28958bb99272139f12ddedb67bd1858e7fdefe9bf89c186dd72b2de8fe12e855a8b53de70b8a5645fef9f549e233f894387f592e139f410a7c4a5cbefdf7ab30abf1e1325cfd860082894f89c57035de4fc277f1f06dc176b8db1db6c32fcba0abff12debfd43d7f7d197d4aac86d3f1a4b73e8412c0dffff5e94e0af8550a443f540cf0094505415f05a11fbe1ebfffeb77ad8887fee4cb7eb8db87d5aba672dd979c3d7d260ebb5f3a77ec5362fff0a5484a48c0834a3deadfbd8a3dae0a9092e9cfdf07ebe96a7fb756dbe158abfe7aabcf6f21f12931ee1ec6e1612e24f446fde997c0977c89e794fefa6bd0ab7ecbef7fb9a91c10c2bebba9e15f077f6e940692f5c50074c548600a61570c0521a0d7150381c5880c7efbfa8d900208bf6e38d5a2eb3af797ef2ac86a78d6756ec875a57b31487cfec75ffe2c4284a4f847fcc45e1bdc5f32b65a967f7fc0f7d4f249af11c4407e4a6cbbfbe95aef22c79c7c4a0c86a3c5cd71dd4c430a22aeb77cbfed4e57a10a104485e4f8cf94633f5c06c36d77af2ff4139f114981ef29f3b368182171279aa498c588860825f7a2d118930480f87999508c4c983048ef6522143dc9045354b0e872012628217f7a965e219a6084b2fb9d9400c72c17918c4744c31470a0cfde6b448b5332c104ba5f3581318c5b35cc6874d524e202c1772a998494e0fb0d85cfea0f539c91efe9d8cb361213c1f9fd9114e1273fc9240414d1d5129261f8ce238919a2fab0ddad96a44fa2a1140548be65b962940b338129bf5f2ea035e64926825844260029e558ca378a4608e422ba93cfca455282a38872018411e03fa5f57fe9841861589ff9b73a21f1a34e2846ad082508837bd345b4bd7e562ba937fa634e21e11811782f13d526fd4126900abde7fd214498482adea9559c4978af550ca3b8d542824445430c4001d91b178d0240e9bda167423cbb4792423c0c20ef7d10858491379a2e0a194528124dc48846530033f4161d8b938910a243a86f32b1e78d0429cc21fc286b4a09e5201245201d1a3c5b538870d49a4a8a4367f03ee59250b27b2b4121e731ca85b5c9bd938c2340880ec2df2619435c462355c2e3e39b4763c12886daa1be4dc518a650dc7b47226382689222227220e9cb9c8fe08242f09f4aecd04f2776f2c7123b09010bd7e39d3e55fe8dc48e11017458f1cd14331d1a3e9f160ca231b7b6e250670eefd3492901ff668aa106911ee4c22929b5b81f63f442ece1de3750ac5dc5d35a411e3d2580118ca5ce6cde665a387a38bf5ce874e5c96d61a283de7b8fca9184faa8bf6fd508922c1221111cb76adac3dd0b2620c43abf794d921ea35f9c5140238e02e0e73543290625fa28e08073067538f64d26419e9d97865f74fe1949ea088200bd71b904659c46b21422e2202001e57b4e64cc72098e800eb7bfc9047506f39c970b1d6ede8721406211e7517f6db962d45e704423ce9e131917b571a495ee7e2729e1711bf96b8e15410088d6f2777a2004fe465627380943b16fa14708e53c2f14d079d6c71c4321898c6401244c299f755d1bf56f2221880591fafcbe4dad24605c2ff71d5610b7568c3e2a1500e8756177cc364a0e89bc37f35447fe4f9249ac71e88fb10e9273a655e92e0316714e118a682e0711e5026a6d7b975344004000ee45231cc601c4dabe45c32e0004136fdc480420923a2db9d330ade54f9117a7447cd04e22405898f37e93896ba0f549268d6045978b3040b5817dd78144fae323951141709c688c3e04388853ca351ef6be9d941ce27bd1248bf1d830c51f92f49fb2ac7fe97c302412f377d660f5873f7f29d119ff2fd7606f3ff6bf35d83fdb5442854e70de1a51c05fcf69118408dd258ea12b8ab760f4214f138860adaf6f3364100aa11de03797046352489802345a480288d25b00f93ed11893911217d3d1fe93b3a42c5ab38150eaf4e86d9e126a577c2f1697da683e05160c3fd46d004514687bf736fb0a438ce9def4a398640da700c6eff194313221c43888c487482bf43310c0a295e79745d3315b8830e5fc1eeee73c0691c5a930d5bd87007471451f8fb7e93c6288458ae10cc784613445b9b627774a8f797cfaf8ba7d9410e842c75dc4a39f3ead1984e23da07fcc6a610c7924a515487ff973a1923c04ad4c52817fae3effd76105675c9371bee38186bbfd74a9198faf458bc9a7c43058f727df240a2f7f4a1c87db9de670ea77fc05b1517e06288559486cfce118e58e4ec7500a31fcef9716ebd3ed6598023a31f8e3e5c974fcc7db718ae85ca6bf5e0da621c7f473a25aaf7a8e5573ec442c2f6f1c6edc3f7eff9ed2de0b253514fb2c944c71192314073aeb8a0a9575945bcbb6ff8648282212a129aa2dca834884a4884ed11f45222cc508fdb575fafd05dafaa6d206fed9d28636b83f50da401423a09188b78681e86f8481182319050781ae613cd728198f126410e03896f1f1328fa8ebd8204246a12cceef30a1596411b85e62a2f1d577c1bc08531135f23c0cac9ea1af105af920c72334052bb25cb1013d23321a41102e05d4c8dddbc25382198bd08a6858857fe6a410adcb91fa19a24803076f5b3512627e5162e473080152883cd2e9107ba5fec728993e7291d28bc45ad19fd320a925fe10cc17110964349a87b17c19117ad3fb9da458481ddfbe4dc928445cffca3bd1624829280545940102201340e893f3b638952218b2ecefd0fb98229a0ef9d17b9803881382d9bbfd10fe513f14a3589402ac71aa7b40f539fd4129ce1f4aec1a68c1718c94979d434aa588e0aa14a158ee34ff2edbe965be51b32d750bc53799644c25016a50e70150d5ed013ae07bdb396490e3086f8da398b2104e21f9c082c71a56d289e6dbce21c30c69b2f41db0a4e3eba7dc4c324d17f9188bca080f2b2b77a184868a9e7612426da2eecd9610146800ec7d3b29a5d439d41d6d53e74e4fcbc5804e0922fd0c8862f0ce9de490121d71dd65fe1a697856b237b1fd62365297b261941d16537e4129f9080d0282257be73e7282b88e5ebe2d562c9114e8669508c55540acf932c16b7c906092ea78fe3f93e2919f4ef1c88fa5785200ae57e9adae95fc3a7700714251142563faf39e11d8ef1abdd79d1509a0867bef03a2b8d40e8b28b719010604e5efb42c020b242251378ae19fd2c763fcced51214a0488992726d689e836e16e5600101240b493d6f332d828968d8c6c3dd7926a987f4b97b672fa52ef3bc53342970843d40436ec7b33dc6da28dd89461915ec7521528c8e494d448b249d40cbf00c1f50dde5f631718884da4c44887e313d1a24058586e9eefc17011073ed3adea6ff922312114d909888126ab838aa645008867584f7b6dc400a0d8445086c5a86a7cceea6506fc8ec30e444c277bb1ffaeb082306da66470c2a8be9dc02cfb814c0948711d5bb140beb9ec8481d50862d7fcfe0674843bab75e0001f0baa25bdcaa210cf447ddb9a1984a334c614dcb8f505ca144efec5bc48050a471af6f49541c620c5351eeed1b9d1086904a0df7deb58cc4a0b1300548b4c4ac3513b39f6b0efc490d838884d0d2b7c522dae9c5d8071dff445a8018013a687f97e9c210631ae164b1f0b0c560d81fc6ecc650373444e81530362ebc11ddee9c102500807742fe18520622888bc031668ca630d408c387a040183202a39c01121347a014100fa91d948c872cc0173921a4bb10becf76faca167b716e1712ab97cbee6a70fb9861570efa230a7ec370847ed35c9cdf7aa88f7f1bc1ae2462301820a127da7ca73e0d7e3861fca9d125084bc830417ad242d8d9b65b0c4ffaea9760b8fdb2bbbde75362badb1d8683d8ba384e414e745d7c780ea6dbe12eb21794492ec238683becee6ef559c74d7fb1ca45cf2955552d572e25fe5d94fd074811fa49c79f880b0925d72c14c2d0ef9ffea13557f7a443ce08c080430ab0fce342780521cc01075850c0b9e0e115a62f604ca46052676a004871bb10fe0921444aa25fd6fd0fb73fe1fa02d5af23fd058c30006f17c23f6184332c846ee387e0f6f542bfce31131403cef550833f5e0fff4040a63f45484635de175e91e1050d11018134bd8c893f2e847fa245e208332425c6420bacdba8600a441ffcf7ef9c014a3593ea07cfc097db9ca95f08c77e51ddbfceb5aa3896936b84d5fa477b827467ef9f54dbfef5bd9f4e3fe0a7c3bff7d395e7b9ed5c29f3ca9f4ea590e09de45ded2a9ebf14eaccf0c50394c0936dba9f41d4704ab5dbdafdff385409ebd118e43f46a7a2df7557f47b742afc37e9546191ed994ec5b5cd7ba25369981b456942b54aae588c250969bd43ff87085558e743cf842a5dda8ae1538137d0a9f00f6aeb9bb076fad3583bfb21ac1deb9e205d577a2bd8c17e1d6bc70848101dea236222729892f24d8cd4982c0131108e88ba1b24a2e18c27fc9fca072094104ae1eb0ab231f91e62b7f6e53bf858a7e8cf090c7ca830624e01f8337ffd1ad18424d10919214f3286e9f2800d490c04d5bddc6f43609024208287321a33e287a434a8fb514a8621e4d1f12b2126fc3c12063c0ed2d1e3c0e227a6693af90b76125312e5af4ba2ab2931f54f1dc346384b14bf757a03d6c95304ef20422fe273f9247a32df892910c04304e30eae8d199280531c46d9fe00412079fc6afdca46c6890605c211bde75ac19f87243c60a214cb900af92c5898affd2cd8c1b0ee9a79b313fae13994310aafcb7251ab1ad7da055302e8ba75747294e4f89d0a4f740a1e99a4128695cf3daae2c33a3630913c6ae96588783edb07119d980634a72e2c03bf6db928d6ecc4485310889b7a47a82ef07f8ca5a758433491012f3a247bd22ef6c83c934284a5f467c9748ff40b36925240f4f27c5bad70bee8f3d44ea411b67b974d1143efec32c694d33063bf6bd08b01b6618a8507f78336521018592e1a375211a52478289b108d13c4577cf16b44630892c80007ca3411ed79b942b64194b344899ef6f02cda4b548c2106a3c54c10d33908530444273800c81801af9b58820545e1d483b73aa1bf3187527b49aecff5374b2f63670422f05d8d7f590d8709462345551e96d89e675d8493043f26de629290884651194b53c1a15a47e8b2ba7b87bd4fd5a50827fdfdb5602085d9e3203e3d0df275d49e987de4e4612895d4223c5355900e473fa672c93985ba0de38ea312d38a4a53fc71d0b0d070ab0ef7de66e7b94061567137eb3166fe932e683e94a03914482fcf2b142c6617054238b26432ec637e4e7ec2617b1fe31305a23032a087cb98919d30f538210e6a3316cbb413da43bd40c104b9011077f65427b54fbbf8382e1a00a9c126fc3acfc3a1d461c37f065a643f0d2dfed8104a02240bd5efad0ef5878750c62900e7203aa806c7b4a1303d4821aa004ce8f99a6fec6fd2655b10892465dc0c299292047cd849d618996e59bd633dc7748fe214083184088e11d6bbe38eb2c6155e7094a566ec459281b8616e28c5b45b88b655c0b0d7ef7d8bc66038ddfc8e694c627d7e382f233a3a2dbc4bc3f39a692ff80a15e300691dbecb8463066e413db4f03d3eff592602343a1e994f466312289c0ae9f61f12869070d056a4d35053f5629a8974281769b4e5186b62efbb548b004e42bef71d2815d339aa3deb43e7a8e684118d483eeb16799164b771f4772dc0f143281f985d001008586ce7ceafe08a04312ef437bc8f4aa0e3b6e72f45ec6f510984b6fcffa5127cfa612a01414284b7af7967a8a16f01f1abb93b8180473b5e05894144710a8563bb3f04a5d5b77201fa58dee57c31fe5c8fdb79b8250f9082bd30c18a134d8070f2e9dd72c53069c31b193d441a948650e4bb023302050c0bcd77385a4c550ea63493ef8302333d371646876f8998ea04d254f668a60c118761f7f7b30982af592e04110ea993df00e4d8ec0f87faf4311e1d698428e2d1c3d126cf323d165629918c6817fbb69d4444b768441ca70e219e8b3961201ee9cbd15de87147926b3bf30ad1040c418ebbea7dfc08c1db14cb7bd08383707063bc9f7bc5866afe6b942212376e349cfe1659330e58acf6ff521a1f82a16140f01fe1b3b1eff2d9d8f7f86c248519fa2f9f4dbc9fcf16ce4c88e1b369a2d313a18ddec0d81f63fec11fe4b3fda8b6be0974e23f0b3ae905fb11d0494f510f09beef8c047f784a6c8c47c45882e8bc53147b8f4642a31d26ef0c2034481b99bd4dc33ac573511c87ed1577372f129891b8bb6500ed9f5e103f6089c2596477c4ac983b20e2d4c32cb577860f041011b9e7898c23ffe921800fe57aaafbb3354af5b6b059dff5348268531e3bb089d28772bdae4cc138b0e2554539a2bb1c23cd5e3c9696c8b08e5c2303882110b13359c2c1362f50313dab5df71b7cef9e623752c6878cd32584df0612dc1d48126b24c240f6638c040532ec85dbde959fe3b650df072d5a568514c69755b9ae8fbd40ef2901e12c9f3bf83746349c020f892c055286b7217ccddc79c20515e4ddcee76fcca62454001cb9ed96c431a3f9c33b4c3df4f52281c3fbcabc660f63545e371c6bab743f5325ee7e2c612cf4310009d384e8088c19662c4f6af550e5d5e57bf9badb02c709065158a9babf27525cfdf936be2f32004017d1df581a270c1111b959aa086ffbfc1c4a3cdcc306600838d5cbfb360d638c8687fd3e837d86f2510ad00f638c11c659a8d0df8c2ad3331b9edbb3a9f649f7a68bc390f7f0bc5a2f5a2c891fee188063666fe976564d23fb98f3c8318e0e7d14e19d669f09502143e03ebce17aeae91bef3647386322c2726032d66143f4c025808823184b09b9ddc0f14f5cd0ff02bf1ad3782a9f0000
4	2	6	TRIM	1795899543811300	1795899542376751	1795899545277025	1795899545203010	COMPLETE	61	0	t	76150	\\x1f8b08000000000000ffe5bd5793e2c8b606fa7e7f46bdd25d4a6f26e23ca40cc223e1e1c48e09bc11dec38efddf6fa4a89e46a0eaa6ab8bd973efa987ea16a2209566d96f7debdf2feb7eb73fdef77b7fee362f7f402ea99092128439e3147e79d92e96e3eecb1f2ffb71673dde6cdac67ad1596cbf6eb6ed6ddf1818dd75fb30edafbfc2972f2fcbf669ba68f75efef8f7cb60b19eb5b72f7fc02f2fa3be7ee9c552964dbcfc6431749452ca4ceadfa9c2b25306343fe9927c653a29d8016cd9e97361d2a5ca1f8043ab5d3eb25d531ddcd2340bf25b1f988b4e1b595b61ab4163b21f8ef7e621d53b6d9a2ef30393d254c9cc0729d54ff4d1307b340fa9d110e526960abfb3aa7f75d1749bab04a7c279782cd6f3a058a905f9491e15ce73a07efa93d7bfc20febb8b5594f3f88af9f23b36ca111f876afe726971df54b3f66f4b2a994b2f2e5a0766ab88eab0a666b3537bb4d5fbf6ecffa20ee75336f55e35eb7922a28c57dce26887dbf999dc5be3ff2f33f2f5f5e0ea3f126e8af372f7ffcefcbf8e0aba1d273e19816a2f35e633aed8cc1296fa78fca774db933ad436b911f76aa4dd574e7b6b2c2d78ebb9eedf5c8713801c3a698110cb2703b0c6764bc5811e6db25544087e374d2a6d5651ecdb2b9d4e6723f59212be8a69bfd628b1c1dbb49acf9f81c0e2ebd9b2adea1337f8832fb412617be68d964d83cb5b2fb6cee10bee0accbe0546fd60ac5f0d26eba3d019b3839f24eb5d608e4b390e579df5fd6f6874caebcbeda1dee71dab58f2bdf2899fa910f8ea354de34dd0561de5135e0e4a054a6652b6529efa094be1dfea4026bdf09d6d9bcc590df7377e1382c361f36d13aed2f0b8776db99840fa7486b55f76a7bbf7da6aa9e5d25c2178b6e7b3a811de06e127e72bcdaaf48695375734d659a7b064a7e3220e309a3f98362ed96258a35bf649f911a248fb605974dcf5d4d3213b0aeb2a555c099b3bf956eafea74db16b4e78361bde4f692272767d9e782a5b050862106c6a1b959957da9c687b6b74dd78776a2d9f0fa381c8f971e4cf82a50f35ee65c499c4f56de70ab7ddb4b283c3f07e15b8ea0dedc9b1e9b2fd3c6cc49034f8060e6a4f2a7944bc337e456bed701009d86aedfb7aa16309783a46959fda57d991fb39818670df38060c9a6e5657961d8c7f9d0cf8fd299cee53ba43b3feeddae993d9f9db5db87c70299353629d4ee16accbc4b7771be04dd5981baadb5a213a7065d7c91c4eee6cea84475a4d7372572a7b8b648f5b65d0391d662ab1594bb73a3c5e3ec3aa0756909ecb949f39c8e42a9b2f9cf75b66a0e4b0eb5f966cc7ada395af663b1e49c393d39ce7c5de1af65729ef782027a73537ba7b2bdfdd0ffd74a9310a86bd75b7e4cce8567a86cf2db0491d61cfe9e59d834753cca9c2f2c25cba05b5531e9c798e33ab964b29cbe2d6c183fd259b165d6395ca4c2810be02ab5ab2ededcbe75cae9d3c79b054f0a76e3599b6d3b5133979c6500da749306e19e99399eb795d53029b9cedaea91c618f779749f2db452696273a2da75b5551cda54ddc4b954ead69d939fbc24997138d564a65d87c0c3217f1a0ca4593e5130d3ac97bab1d2eebe3afd466be499ad651ee6773c710a2a07c5fa99593ce18a2cb8191db7abe524b90491fbbf9041bf74aded0d2d7b6b9cd131c54406168ab6590be9236d67019e4b2896328c195aff6aeef770763b484de2137974e5aa9ecc8927cefed5bf9e3bcea28956d5985dad0f6ce2782cf22bc9e378e1b6f8a4fa58950876ccb3a0d52f3bd573b80f3410db32d8b2430f558a6b3044e8591a42a135cdb15647168d7503a57308b59b12b1c252c3ac95906229a4cad50bee9fa581536340fa4dd9503bf8007671bb8ca7745b97b90956021fc9c5aa8dc219c9dfcc13e1ad057d09344e5cfc6ccb73306dbe1722d555a06397ace11d157d6dc9fa76aa333742dd6b3963ba3e67546d525c87aab723751a1d6dc5f8e87a533ab13d6b3f0de34bce139b90c72ab4e3b10e5bc3bf3e78aa727d8daaf5a9657b4b99ef3c77f6cdfaf7bebea99e8ff1b7aca27b6a336643b566dd7c507138fdda60ac861a1722c5dd4d79d8dea2f8e79959b15eb43bb32ee1a46bf29266a67e553077737390bc5176ca30aa7ac3c58fbc9616332e5582ab3c78a25d734a836c77657ae324e3ad8646869b7f76d1b750255c92e7de8560f7ed5eb144ba6a8a5fba0dd4f8c88e44b27b9ab2c8ba5b157dfdae784f0bb9b4906bae91e5c785d7763b6b3f3aed3c9ce6bbe5c10920a16d94a69e594fb36ce0935c8e6da5b375dc864bc66e56c66c7bb96d339355c20a7d4c9f071d1288dcd4c7b826ca632ebb209dda5c82ebd56d7965933d99d1e47e6d03eae48cfb57d2bef0f2d750279b3dc1dd9e360edfa6ced1f40617cca9b7685cca80fd56913e4ab6bb6b567c89af9c0828b6ab1b66a413bbf9f55fdd3098fab855c7261dadb4a72eb1339f6ab5ec12f15ecfabed6f24f74cd9d6c2dd7ec59396394f383756d1ce466c9dcd24a1c57037fdd3382c0eee69bc440635714f9d21f4f766d8e086f8d915b049dc4f4bc4bca82cf33f521281e947af9f25d6dfb8eba55dbc37e6a9d3cdca8eeb65bfda6ba07ded2f54ae7fc6a02e7ce6845b2366c172e2aadcb459d2693c95d8194f1d8ee50491d9426ebc245755b85741ac194b369171bd386756e7388df547731595e77aa99831a2240da3c17bedf6e26d3bb433e61d72eaadb5e15accd95eab6445a0ce1806ff39e6124d7819774b9e01755cd5a76476fe3b79f8251eb9d8f4b742c59d7aa7bec0d99077ab9e3f91dd5ad26f3ec79b9c2b5051f0469e15d5eccfac3264a4b302d804edbb12f7a400076de6dbdd46e7db44c7a7a53dda706e9806579b43336e56af390b36db75a91a96632396f885c3935ce2faac7f5d2dce65753c7f4b283dd1c1c8fd9c522514f29c773b7992238962be596931b8e3ba5dc3133acd636b57441e53a44f8a5fe2a70eaf49c483a66bd3b4cef73a7dc996ddc753a61b69dbc77ecae87760277cfcd8bda2d1c0bf935482513f593972ee5d9042dcca6326069438ba1a8b0d969ba12d4cf0c9aeb829dcdd65b3e64dd0df06a8b4620c2cfc89c8fb9aedb56d5637b14a4f3235ab2a64ebeed1b931ab62f3656b781bb0767e60d6749b3091253bf3bec0641769569762f9f51503d9833a66ae58edd4dbb92581b2e87abc9617c2c2fc04535772b4750aa9036a113bb3ba9ad8ee9d4cc16ca0c10bda8e6fc1c6541110eb253d338f432e56c40e6f9ca882ea7365baccea5d1a1d2167e9339d394632256da37793fef137731ca577313b3b4b453a34dc5ac95b6f9fce2dc2c4deaee3aef27212de5fd4ea7559acdbbeb7cc56b8d5bf9757bd22a0dcb629dafb4b65362d8bb5dba6a1d128b6e0f77e051edd3d4aeb06167d7edb7cc69cb126292aeb4d5ae2f7a36ac94cc4da3bba96d82d438d8c0557e6b76aaa65f05857637580dedd2c8c4add6d4ef8879df4967eb8df4658eecc370924b74a6cd852c03f7e0cd3749e2d8896272c12eeb505e0d3bf8b442db42b3b6481c8fa7fdb6ba1ca45b305d5aaaf1b15a4f8f836eb14d615a96d39363db9e8e835e956568dadc80f5b13ee393ea60795c15d2b5c1d23f36587ee67417c75529ddce274bc756b93eab764db328fcf139313b72cb50e1f2ea8d62d559dab04698587ea6b3299fe99b693041b3fdc1308bbdbcc7eb2473b8360d4441cec7721b740fda345806b975c5af27eae70ad4676e19a48713324e047b710e4d832097dd0496a438bd2c1e6e4d035b9b0660ff666eee6b9dd034c8969dd3bed318987a0f655bd668d46def13834c1b68d3a0674dd23bd7039bbe5111a1ea3f9dc6d97d90cf6d6da0fc6ccbaa962bc37d6e4bd2f626bcde75dda3dbf1cbe70a90e35ec64c1afb9ce71f1cd3a3ea6c637fd0ed994d73b3d981a69203a3a48ad8a81f526723d1358521f76a97331287dcde20becd0c51338b6b6331ac00e3b448722f7136072963db19cecdd469e66f6c7738398df6ab9a558741e0b5b7e36535935c359a72303e4dfd7979a16c5eeeb09a559cc0b637a98c97d55c2bd7000999ebcffcd174bf3a9fbdddaa658d2bfec4eb16c532c8b4eafb83ec0e965def22a67efe5330cd627eabc2f77b429947cbeb0c53d5a09cb60435a7aa582eb495b59b2436ea4c0e4265b379efe00e83a46f426ad555c12a98ca5a8e7d618e1a4657a5127976b01ae39a50b4b970552a6136943755c3b45ad0a6936c054e693b0826f6ce01fe80b79b05b76714325e3f57b47c2bb5a9b6d3d3615e4e8db47bac66d3a5498678135402c3d5f9d0375d4941c5ebcd8a566633d9553bb050c94bb911e9a4f232a5a5da552668ca0fb3c461b074b3e5e3d4eba0a255487660d02e8dd1504e693ed36a73a334a683610517f9613a1cab6d8a15ca8ed7af24d5dae83b416b345e2a393d7860e1bc79cfea849ba0e31b646ba9b49df3cffbeea95a68f5ba239b62c3f569503a3a4554ca51bbd039115f90e2067847b9dadaaa62053e5a4de7d542a1d3aad9ad5239e7630f0c026f99737bb6b5dd18be58ef9da098da766a361c35d23edc4db741a1d3d9b4ec0d732cdfb03a1b2773ca7796d62c7f4cf8a36c9638f6aedf4e0b33b53a1577466a7f5e154ad261dece9e15b779649d37383b69f2374f3e34030ebef990f77e650224bafed8eb27516a82d5b9b04ba44ef5c336541f5666599db12c2d670a278fedce6d681c36980de7b537ef7d60b304dcb68379b1c2ac59ae53af93ecc504482648a3d380669e904436d5d8849f670e3bc51580f58e7f31014cee55aad7de7babba1b4256991e3d8946abc01b1744fe6202581d2d21be6feb5471d7ae9c4b0945232640460cb127ad35a8bc6302644a567dd2f20296c7e7eebafd667a1cac5cf5ec6517b982df2996ec4ba004a58ab97dadb43de4483016276d412b55189dc71c563b5d2b9149eff37b6398db380a757747856b53c71fe4dd1d70456fb35560b56b15d9a9db9990e2a8208cfd48f85ea75c484f78c76b9a0a7566ca7746bb6160670f73a90e5ec1f02de50e1dab975a984a3584529e6d1887acaa15136cd5ca3afb94d9b26d5977f8e1e2bd276966686f9c93b5ab15abb3d23e77e4a56dda488e53998b196777d17aa1e7d0a94e99bbaf81fdec0c3bb5d6d6ecab6c28fc95b2ad594549fdbf74bec8bc7399679c3a48f7ce962b1cdb4feddd8c533be50b678b0f7b5bdf5dd7324ed52f15ce56032d943fd88f334ed5ab6dcf567d5a547e8a97334e5df9bdb3653aaef27869dc71daa75c30b0ab9ba2f212cb71c7e9207d0dd3c8f2586fd2713aab1c18d8ce666a78a464d7c1fcec25338edad70c8fb6ec3a086a5e2de30c555d7914eaeb405ff7463be53169d7c1d4d5d7f0e08a62e094516763b58b79639d6a0cdf225181c5b22c67db8b529eaffbf98c6cad4a4eadb25f94f20ddccf6782ceaae4f4aafb4549894cbf9bf3faed92b3989e17a5d4b0d3efe6c8a85d72c074bd28a5bbad7e377b18654b8eca34c911bc05da546613908548eeb7396f83a6f588ba94d5ca6626f6f3c152cff932c8662add15af64f12af4a4836c0aa2ae8043028aa1bad49e74f1cd93366fd4a5395c06d9c5585d5e9b251a49ad2e7bcda0b5af6c7718684fba65e5b8d5f1cd457313aacb9655cded065e69315dd8174ffaece0a5974d360713105e27b3b0bfcfd733d5c942a5b32d0bb4f9d41d68d5083a605b7b5397c0343da9ce3692bb6dd21cb968980755650c8ca2525d55f71d5f15bba63534376ab8507298cea894b093beca996aa366ca4f2aab9ab495b5354b812a0c9b399547d33a00e36590e64d1288464babc7194f57d0b296ad59c555aded75d569594dab46bf2b3bf3fed4dfefcb459b5528ab59ce3e59f216dbec32c816ad555a78ce6ee66fdc696a823665d6b2b247cc7ed9736e76ec5105bc79cec09f6c1dc54973a41af59cf46d73bc38a869735357836c6170b0db63e2a8759a1355ec67f2072b3da9a6cdf3629e34483193195ac9897b505b425ce595d3fd433251a8e5bdc3306da9825b37db41c1aab6dd52ca17ab22499d1c382a2d602f6523088663a7b3a8b9a96d62ed1566be799c1bbda04d9c9190e304c954e6e57d69d84dda13bc390fa79693ddba9daea9bc4ebf60d91d390f9acbd270218f099276fc192ecd4741d546e9ad9aa42c5e70e7789bf19ae393791c4e1741a7d39a6c2422229d5e186669785ca62678745205434d0aae619555d473b6bcccb8955c59a96e40a646b5aaec70777e9beba259ab33ff22376dda58da89e15fea95ac5a475014cb6ecd76e71ddb1766f750cd076a7db44d56473edd5637556fd6681fedea3c3bf745d95d04456c647ab655679e7f1cd747815759e3a56de9ed4fea6e3a28e67a74699dfd21f177e78100c9325c8f4cc35d2ffc427f461c6b9bdcf7942bd229bfe5c264d54d62ab667ae34cd9efced3c36a7200b225f398a834fd724d6c0367b43a40f35abd2a5f078b739d590ff6ebb55dae923ee427ae49fa9b866aa6ca099b9bb3e1c9dc9686e6b0ddcdab74f89a9a9f805cad68c3eb2eade47a42b3f5f49bf8f6cffbf3da286280dd60e61436b5f9a2d2aa8c73e87499c31d0c78fd5c2efb74721a360ba37ca6dbb978546cbb2d6f6743db9db45bed7e7b1bbee825fa07eeb0c9b6ba0faf73a349f69c698daae0e23e27a544e76a798186c63033dbfb87756371de1addca59ad1af9f2fecaaa0460cabc5c239d09d2a6527618003c38c906aa2c8cc0e814b5f73c0df24aa555185cfab6eaf966f7b4eb74713fb7cc9e66eca2be73726f9ddbf3d309e0467353bda85dd5711992a3c360bc0ff275c82f8e927bdc6df7cd6e8aaca99ddcf60ddb2c2a7fd94f0e03db49d4d3c6a1de9979adbd91b217ab6a425058ca989e8fdadc49053943258e4139eb75e6a77ce0f503eb68d97e3de737d95804e974a6dcb2d3b57ece97296fe738e6c0300ce360186691670ff6b17d403b690e8bca3b2cece9ba7b11b6c9ea6cb7f3ad4e90087c83cc275cd472bc601b53a778b1c2adc5b16fa8e0e006f39ab4cca9b20f8363cd01f9c5667c51ab2ad7b4b35db5dd150ce5e76d6b5c558dcca46401b338d85da223f983e31abe715c2c37f9929cae1d52e9ee0edee93cd4e25c29352ee4077ec2b732fdf5e2586ee546f9f6b6bd6a58a4726af89788cda18e0a4995062646b3ead1568d7cbe5a9f5426e6b6d7b42fef5185f571e41c3660e1ab4cce735a8b8c09ed53c5cb78abd3a63f55e9893f75bb9d7ec9db2613ae939859562dd972cd94b7f12bfbe09ce527e9ee4f2bc3e372ba9da687193395e9b594ef2d0fe75cad931ad06d7639eca7bd539ae46a4dabb83c66dd9495f25a416b382d9154b1935699f6f77cd625dda68ad82e7afd7eb916094027109afbc690e5279700747651768051deae92a1970972936ea62c0cdc407a3f2e83f4c2ae64b9556c6f8b07332600fd76ed1e8d63d5715347d6eed989b9ada8361517fe78de5bdbb276cc1d4da503b863311b55805b3bf8864a5b337fe5a1f5f9e08d82a608ef07e74d7e7d6c0eba55aaf2d6ccdfed3af81838541ca4951fd4fcbad53cdba0a0fc32703640965beb92df5d88fa64692b6f609c7d9b1bb06a4ac3e8a941c3681d728161a42de9254c65ec0ddbaf1c0dda75129e989a7d6cac0f0d6c9c87ae3130e6c1b46a05ed9655f610f29c8ab90c7269b7efcb5cff34f3c7ed8a6bf396d3ee5945a734f64627bc04995d2613249689d3dcdf6e65edcc7233a6bdcbe2cccb58ad659031e79692a5e578e6cf165ee2fc402af5ea0738c9457f1c849132e3a00a4e1a8f0ce1e646be359ed47cc59b22affae382e5a72a633531ba24515545e421df5e8da607d52786ab8ae3c2dab7bdc9a46ac2f462aed2ac983ad8b5712d5093e6d157b9bca986760aa95a459da66e355b045ea6e29bc639d1aeb64f834c551c7b8eebe48f4169b40ed236aa027f5aa866a1bbe994f2de60e7598d215f830eb0fcaedcef44ba5e2ad2d2aa6ed52a28731ece46e342cded4f6a19afe755acbc8f8ed566f1e410396f8a747fc076a5658b1627a82154b757e9d6dcfeb934d666bd05f1c9a8b62a70ba90c362d52ed697d552b05bb72ba8ae8cf2b0d4c88439d89eb3699456d808cf757e6bcf12ebb4cffcf21114fdf1a664077bdbf4e1a0bd0385fa3a57b3b7ebface3fcd374b50187759c6c639b7e733733a75f28d2a99dab3c0243e4ccd5bc09b2f27d04641bee2cbc166161485d9ecd9bd96a8f9703c4b3b45738ab676c9e96d7d784a6f402e31cc26cd61fbe4fa8d437fe8a4aa73d632594d787ea5b71d07b679582e557ab50afc4cdbcd6a974afdcf95a769bde7699e0644de7a9afab5717e03bdfeb43439e353b1d34ed4e582152e9ea1c8b33c5d8d51a1709ae6a795b6752ea5717a3ba36fc1e6203f2fc37aa7098b83ce36cd1bf058b72e9ea6bb76b29d36c2e526f59c74eecd339518b7e169c7a76f79e2e9a174b8f234cd44b3a860e3dc5b7b7237de04057f26c19baa5a678bfc3a4f3c309b9353bde2f7229ee6caac12ef3858efdf0b363bcb5a7dd29ca905c1a23f4ebd7d6f86ae87e7ee5e240b95413d73be789a19546fed7d74821dd2c77276b198acde74d60185cdb69e486d8dd61e1f7db36a4db387a5c223a7ecdb9b84eba8d630efc8e464691767b817d8c81b706258b834f7862336aba09d7930951a75959fcae495a31a6c208c8eb7373c1058ca31b7d6e19ba7a955a156915d0e67ddf18e06076b42ac7c1fa1cbf3ac66d5dc427bcfb2084f41c73ebb72ec1b325de3db8ba7795879451dccb4586a5adaf7b2dd658717b234631e86f9374fd3caf73d15eaf942b298f1a07d2e06fee9d8ee98cbc4b8e41de6b0189413c755c7047b36f030c7c5a0723c653b66eb6cadbd73851683123bad3ae6ecb052de615e2c3bf583374c59a751427987b3be3ee9ebdd6ca6bce3405f337d3dee170cef9c4d3482d9605818d915636978e7a2be1eea6ba4b2ca3b97f5f5485f171453deb9afafc7fa7a59ce6e8ae3d9603c39fa85ae63f48ac0797bee6cadb963e3e33c5b4a154041a450b250b251699e2de5a6a02092e964af64574beb6cc96ac1824825f5f5fcb8ce96dc232c08a791dc966c956919998a7c5389dd592aaf8c7a7771f2e4ae7f49a0fc15785d94eb7d592e65ca6f81d7f26ae7cbc2bc5db9e464d38b733f2d83c9f110aa4490ddac8b80adb3c7ed3b39d9f6a67231292d83879e64e1b834f78dc9cea95e02af8d09cdecc960307ef3244f34d5f76ab994cec1eac06bcf34e4be58eb642720bc5ef5bcb6976fcc779545788d599fb8fdb67bb671da2c144cdaece4c3c06b32d13cdb38c86f46e6ce58a9625055e6c12e2835d49ea4a38a8169fa265543a24c0ddbc928db56aaa56df0f9c1cf29ab9954be7530fda64294ecd6adfacc5f64e8ac725ce4f4b89bad9e57eda06535bd17b42983ce78eaef440954d06994ad59ad547ee06d27a36535eb54539bc43eab03b79be2f27c5aaf58cbda7b87a13718af9641265134367292dc661ef6240ba6c9ab007c0bbc5a47cb1ba89418cba15a2d645b0d4e69b6978949a369a2e6f9a872ed2cf5128d091a9a2c8dda2aef6632072b1778be32d2878aead48b793f551dfb43354c8bae1a74456bb85aebc0ebd668da9bca3e55f24bfee27c32853f4241d3748be733f10aedbd957669bfda2a670b4ac8bdca7841bd530a02277bc642a8a9376a2f5d9c4c6fbd8e75b09aebc9bada5ec8ca508aadca8ee1ba509ab2207346f4ec8fbb9bd5d62db714f25ae86465576a13b4476e332fa709e0b64f56b734f25ad50932d6c33139766bee7a994c7a5d9656bc364a83e61e77d2378157ed3358e7b65bcbe3b3f4fd0bc22bf424f58f6fb2c372128a8c61b298387ae86c0cab6935cc6fed463d97f6cfa7e931f0f2fd4dc9ae573dcb3778635f2db80e9fdac94611f862d4dd38dea8ca8eb6c89de63e760b73c71b3732193b85acac2f73ee2028e66db0b537b543c73f8c970d905d34c5c84cada1e1978ead8ae35ab53134e17938f7cb3e2e021783409a1997cefdda29d576dc649f4d156e256b7e7e15b4abe6312035b51cae9345561abb93a8ea54bef5032f32e08efd9717b968f9da8b0cb8a344af969622dd055ecfaa8c78d76d54b3172f32278caa3d6d6f70131b86e11466abe46cd25c54f2c58b1759a83a2dde680dca3e9dc345a93014c316bf1c7992ca2db7d94adfb15b223df12f28128be0fd39b980bdf4c58bf40e227ded45aa8301cfb553794a8cf1be38f38fd9c6d2decb6cbda4f02a487981b2d66150c954a6a2cccb6c766e35e245b6ac49d7981ecff67b5ea495eda0629567ddca163b89c34535e747253569126855f1b6e5bc7991e6b2a52c119483cdbe7648cd739721b6ebbeda679c652e07bb3a7fdbdee3832f57c953356f3476472b535f4ebc2d854d7b55eb97ab4c266779afdfc4a46ab2b200468e9ce75eab344d825286aca7762e3dd8fa7236de579dfcae98b14ca79ff18dfe6e58cda70607fb641c0d031ed20c1681b113a7b2771a0c869344ae0e669701e52793f61a58e3c571ee792aeff24343e76a2bc30ab9a811d5a9b62d9eecf13e3963a77db412eb73597990e5bcf345fe1f458bed8bbee5fafdad6ff4ac1e28f0032fd923de4f5ec492edf5ba67d50050ec1db7b8c9348d61b79df0972bf7146e41a59abb596a7fc6d381b935674dd63b14dc7ecfc93a8bb27f71bfb32051ea488b7bc3f6e11474b9c86ed3dd9c4a4db7e8029132cfbbb5b4a8caa553fb467291190f8e13b799de14dcfa529b417abf2d86e56a55d593493ecde7c9461876fa2c76874ec758386fde6c50ddf8d03eadabcacc8f97e97aab973ebae76135b0b7f9d332ed9a30734cb7dc71e0fab9194d393d30385a9b55aa6aed8a3d3339b50ce4efe9fe6c1b8d696aeae7f0509dd279af5635537ea556f457d3ec11019cac3a49e01c0b96d5b58ee7ea2c6f93ad5f3956da766256eef48a7b9b141a555a77928be3a99b380615beaa05b46ef49dc5a9eeb04ca01a1d092bbb395e967bebda1c78c9a0deb2d9c9daf989808ddebc24dcb0ce07a79f994e128eeaf68d7129b1f0db4b967d83b7d5955bda4f4aa433b5597d904aa5f6a94ef9a8afada4bbcfa59203bb53464da9aadb6c296b270950d5b26ff55bdb927909b6298766adc01b75f8e9cc96489f197df433dcf4fdcd007473d6de354a447f5db6651571c7dec95aa2a5c7a76153de39b76fc35e57ef836ccbcaa6cbeede729bdd4a105e5f6bae30979ae9d62f6bd968869e32a8e64a6b9c2ba8ad367567fec44d6c3a222b9a3a4066cdfc60383d9f79db9f6f55e8292f0ecbaa9d6834fd83a11c6be6afa7489d77edaddf94cab5667a2f0d6d6330339431c7eb649196fdf3b93f3b1737fbd094e643ff5cb141ad3424eb111816ac642e6bdbcb991836442f57f07c513d80e460963f485b394e3333c97b2db3be0749bfb02973ff604f0c3154702f4baab737b09faa1928b0ce03e3a436036378f0aac6e1e060235135f37bc31d364a06ab26d120b1444161e2b096b5f44b1dcf4a9696d55c6daf367234ee4ffde9b831b2012fb29ac59c4ee075a658e76dbdf330b12ff6a7fe6847aa362b97562dab6dcd02cf39669641ae7634857482ddccdfb16342cbc65ff8018e9bf730082349c641a59d34d9a8ee2e5d1fba8bb1ef9bc3c566a25a2b0f1c52b5f10498d3a6e1aba295cc0f5d34c63a507db0548ba5d307373b0243b3472d5b0d76f669986a4df279b521b4a036a1673d9d1eca4998904950e47d2f63f99623691fb4cbe2d495d32cc9a6fcdda9346f4f33151c0835a8665b2d170392f0fa95a3a51a6a5d6de60f495f0652254ffdedb4b49041ae824bebe1daec15a49bdcb48a5e0fadcc04b566a05513ce50a22e48cbc48a97c664d9996053f88b6a5d95526b7374f2ba86676295df83e6f05cf325ca0fcdcd68772ef55787f124ea59f70bcd56695731466f9e35a3938c7f92c6c929d4b3f99eddc95692fee16c1daa5e65bd8676bd7522be611e3641b1e5afb6f676df0e7c7adccf82627f48a49db1ca299f91730f14bbd9eac8b68664e4d37aad50f502e7b0b441a568fb936c6e514daddc53d26c779a27bfb518579ce429312f98c66cd7f6abe7f61ea4aca35733077b55f4a7a7ecba9a5454064636b148fae9bd4a8716cffffccfcbbffef39fffe7df8f62f9df80dbc61e5e23f88dee623eef77b7e3c53c0ae6ef2c16db3fc71ac4bf19cfbe4ac405945d22690f61c6e5cb97974d7ff5f207faf2b21dcffa9b6d7bb67cf9e30501c4be42f815890a027f50f10716af8cc9967ebbae1d78f9e3a558c8a50bcecb278c7cd0ee6e37a37e7ffb9181c387073e5bf4fad3cba7eda6ed6dbff7f2e56531ff73b35bf6d7fbf166b1fe73bad86c5efe78491573f6cb9797f67add3e6978fcbf2fff7df9e365da1fe8416e4f4b3d0395a6e7fc09a350fa7f7fbb78f9037c7939fe399bbdfc015ec19797d3f7ff7e1bc87cb83bf5e75f1140fa43a6fdf9703b0adfc5c3b72dd7fdcd66b7eeff395bb6f55fc2eb97dac76f2fa32f2ff3fe7838ea2c76e108e0bffef3e56a14f0db2810fd5b8701fef59f7020dfa66e3d1e8efe0fcd1d63bf318c9ba9dbb6c7d3bf61e618fd67cc9cf8cd99fb971638bbeee8cf6d7fb30dcb5bea2a97fb1419dbdf6cc7332dfede13543dc9baa207da62203085b02dfa8210d0698b9ec062407a5fbf7d25a400c26f328c7c79e92f17ddd1f71185b7bfbcecfbeb8d16e8fa1d3f9072f20f805e3183addb5d7123b7ae37c9f58ccb5729f15f2f4d17876f2f7329fe7a79341efe75c2a0905f5eba8b796f1cea9b3f5e528eca5552cd97d8851bb6c7f3706dbebc3f22783f221e37220150fc88f4035c8fa85c2d7b8e5571ecc7c7f44d44bd334d84be5226ee0645c82b85318322ec95a1270cea66a6e8abbc5aa4bf668ac6cf1463af5092df5cbb3779f48369c2346e9af03bd3c429ffed69ba1dd3cd2cf15729e5fd2cf1570170cc2c895728e94766e95f9f2064c2bf5e6e3f59c650f2e5252cfefcf3a776d5bc7fdcbefc8108d1e59fd35ef8603f782c8259b8823fb74fb7dad0fb9075aac7f2d7075c4bb6b8e3b1bd9d77c828615f5ed6eded78a1578c112ebebcf4fa83e9c560be6cc48b0cd96cd7e1628257400827427ff3ed8a0329d997976d7fb6ecafdb5b7da3abc7f80a7eb223ef068619a2f46a601462723730f02a0542919141c6b9decf1f1ad84353462482f27a640cdd4f197de51292c8c804a58413f85943033143a38280eb49639cd3bba1a15720018c2e274204a298598300885f5eceb8917144f441f83e6932669791f03ddfc70511e69cb38fae668c6abf1b972454afde5fe3e2520fe16664f0f5669301ce0040cfdcfe92090caec725b478bc5b490449f460420629c4e293662c6664041082aef798e4e47efba35701a36b09a0de647a1e9fb5c70802a165b8fe3632c1b49ebf5b4bcab5a97235328400c6fa2f3f34b2077619414cb0ebd594584b90bb913144a323031c3309e9af8cec87fa882224b470fc893ed2718cddc7b4915676f75f8af58e79d4fc8e7fd64d7fbb5c8ce7db2bd362dd1fea68c562ad432ed9176d6bec8661fc25fbf2935d1d7f3a7ee33be2c4f3a73f489c7afaf427d9de9fb4a77fc7a73dc7cf76bf04e0c9d6187dc71a7b44b42201b5cdf05d7d2376afbef12bd2b2ea4a4a60a115387f9e36225822726df230a2ed989881851bfc6a640460a0cdb8a7596384528eae853e67f45ee8935700f5bbae870685405a793ecd1a230c4181233a5c4fe2fdac45e78c62c284b6cf9e65f31021b136ddbf6ba3d092bf9b3246b58573ad270120947d74ca1e39001261bd8faf0e008e5b4c22a2e6181542841ef4a79816b10363084615b8f6e3ef6c7e26388b4e191750e8313c6d975108c347bf9a331d1eba7394701835bab62d24c38ce3e7d9631462a62dadf55f23635abadddbd661d8253a6988c479239f26352842506b82ef43a3ec5ea0d1578460d4bca69802f96b43fba14a629487d6f45355127b47253db28684237a2dc36418fdb9936158dc38bb046021307be6c6e710eaf0de77731f694ff14e5808a4fd93aba1712ca0d442f7431bffa1edc509e1913329318ef1916438e2eb9d2f2427facc3c4bc2524e2988ac2711f7d202e978e48d5f0929c67a229f256229a722e25732c6e3b412c0f4d6fa813c5408cfd297545240a27e659c16c737b60f1404c4867b3ee455c6cc18831846632a04c4cd1844323a630c332c197f9ebfcb208ec60888107123a35cabf7eb101924926823e9593a89410ab48ffd7d97096d03de8d4cc2881e87401024b46dff2c139be9715d9bd8428b81fbd885b8d3e20441f64ba6cf0f15126788e9d8c45315127f34621db7820ce348c44e60702ff6d1ab64375e12414232bd0d9f665530a643bcd74393f7d62b7dc5ec66d76328398c93ad9f37322143217065ef68cbef6e7be1dbd018240c481d787fdabe9790e9dcc2550056db2bf7216ba10dee9b7022179fe526c58e8c401daefcbe9a319202be42a2eda368cc4e526d363e4b1f714038894e598ca604af0483a833029044486fc94f59ccd8915d1ca0abd830885b4c0e6ea4181282b20fc7d31f111b1ccad001fabe9a50c755ef043f26fc465952c1197f620a8213149d342a639d5e8ef439bcf6452490f0a9f9244ea490912c04d46a3dc6b78cce19e01ce869fc2427493009f4497caa4e121f779238273c92ac1138265749f4368fce136552729da3789a27c2050e13ba573662acf52a6fa2634c9fc80fdb3b0f48572e09d7eee1778d04405ce28d609daf8898d534fcc36729240138e6114101e283b05c470cae6518048cc2270a0a0104d17ae5bb55cdf5406344988e075d3bbcf2e2f43d6b2d05c458efecef9b0cc59864509b6451b18f09c4ecc3c9ca47249880984574a58cb3c9c8ab90383a340a18417a473ecbdf15180aadb6afcc8b18d94ab4dd7a1352c49c31edf73dcb47120484f9baf5f760a70ed0dd9d0016462a22311f4899061c3ccd8e153aa61e91b480c70688b9885a8b180a2ce296f3e32a89ea8ffb295e69b5eb6f3e1bafa427e0ed83ff78a914ab56eacf8a53aebc5c833bf517e97f2f5fd4e90f4487f5c5d70116e82b05527e154c76be12c0a1ecca0ea464f0f253a425781826d57e5f7804e3b9fec31077fae5a537de6cdbf36e7f132edcff32f84abf842857261ffaf5afebc57ffb10f80abea057f00587b7bf2b75bd71c69bcdaedf7b07264a30d330d1fe71395ef7379115a71aca85c2985ebfbd09516f564a155c0df2ff8c6df214581bfd65589b780cd626380971463f79ac70ff5d6a223e609269c9f4ab1bf85b0186b22cc7bb8024ef44080790c31f3d9d045268b7e5a94f077fe3e94ad542215d70631e4e024e11ffe1c3491ce6d49e6a4bcbdf88ef0801a188f81c40a704ef43159244ad1cc4a90843c6cf8a6a6a8b58446c69a1ade63bbda8537e51bd289088453e7d96017659f6efd2f482d4d5b2f4fb4b9bde9bb316379900dc860a2840447b750f4fe62fefe75fb49724c4a1037cedc0c759bf3af71255fd8033fce16ce203f6928402e9e9bb8a29c7c463f0ab0c31efd7d16e82f51f3fd15e925086908cef8789c4064b29d321e488918910d139aba76d599de1bd5e4e0a62008ef015876e61646412d0b830ee6719e692d030957315c48a495bd3571e8eff7a640450a8e3bf4ff36624158246d3d65aacdc2d27a1b7a1220c19fb70a8e891e5e4484413ea48cfe17d54fe16858019673c0e7bf903c3fccbcb6cbcd96833eed7f05592c689c9b0a62a464c82c8cfafebeb1f3a10184849d093b1687aab3c84458bdb6a5cc8482e83702d43ef83cca1628bc6fe308acbae7f92b8c5005c5ce2ef23a3316072700bab8208f0100dff2c618b01a0301206e134165725a0165fd76740721206ca3f270c1837679084656c57d236d66fd6751d91bc27d598ed0f27647f7e2631801cf16bc1118e20460ddc4641049640bff559a1530c08bd49b3082da7eed43ad199f4eb9131c69006a63cc90ec580ea628d8885ac03a2f7f606d658bdeb7d86c087d17b8f1c4c26a98ea27dd70138662dd12ba52cba960c411916183d29a68b754837521743898e2adf231ee58dedc8a4d0f9bca7e94d0c343c309264c47a22eed69252adbda366902471e9cf1fe4fd3fa837b50916a337e5b3f4e62fce20fd5b07f743a58e0009c19e4f55eaf0c14455dc5c491a62c7af62ceb130000e42ecfd95f2040c9138dffad36487a43c82ea6058e75cef7d6b78e3f50bc95958e5fba4ac0b86009008289fca189b9bbe526d5b5c8b0e4104e1cf54501021a84dc82bb889ded13169479d018c64aa2081ec898e0a86180aedec7e9f341e5356aa334237a80e0a85101a61fabca16908d5b52ee018c56214a84e945e0f0d3109b4a5f934031232118275af801d1ad7180798beb1b9854e097dd4807c40c842cea50e0e5f055f625242f095df656b75dcfcc3c7f301c1a1ffa7631757731633b21081785b5a2720f9b03ff080b08502b3883944e34090e015731c9d3340748cfa9746f661d50effc9aa1dfe83543b8640c867ab76f4617f1d87b5391143529bfa319bed06b5001090219ef259c700214975c2e13a0479af0a42933c6a7b03423024cf5405487f7ea4108ac51437d0571082a5af55019150fbcf4f53ed88021c291d232c76d224d6e8fda86a97fcd33441dc9c314a22683541622b67b42abbcdc06bfdf63c570a7124f59ebf72f2e294271737e520586708e26a143f094f8111c742d7797c3f015c6bacfbc524da138cd4f2a3d0367996ee44828465565751a118e421d638a3281a1e718ac1876b271fd96582d108f090c1d8021a04f5c25def7fca38f83cfb316e9b491e824baee83f40dcd0e05d952ea05268f3ee6ff0d8d13f59ada37f925a670293ff1ab919fd29e486fe8cdc0cff2eb919f9a7919b69bd173322f1ce88b45ff9747233ac53cd31e4665ad2c4b076016dd1ff1f2437833a7c7a3f4d44bbab77d3a41992d8df416e26e2c9cdd03be4661f9aa57f7d829079120a8cfd2a0a8ce2875060583bae3ac8f3549c14fa0d9c945d2c38f720298c99c440fcf8c908d6a181a73a7bf8e3715ced196b97e42a390b638ba6428eaa48a651c7f29f07ebc7da0a8f444b25d390f57b948ed449c5483e0322168785f9b41c28d62426115c475cf01bbf22046e268d734a74d8fd6936252634cc325dc19af527c73057e92c56242e2f31fa30b2ec011701534423f5234cc4a0aef0abb8a96ce1927119c7c8f1841816fe271bbb381436ff0c639708227508f2a962ed6136cad8dd26b93e7c576e9ffebcfb73006ec2ccbac823642c7896438a2505115759e79d627c78ce6f90570073263f2c3c1ed96092ca28fa50eaa0d97d7c4d3bd051842708eb3a9e15f8c392870442578eb2b6e1efa36bb7b51a8ceb92cb2746e60910589f83ab64630c80424349f91dfb8be0da057ad6362340ff8ec4fd702ced6348237c0d31869452f94c1d45a00c2928af01617170180c6fd427431085b8e9a7c57109a62c42af48650cbd227e95324ab7020115143d131243a80c5960d7df437f318793be427a0319171203f26168f0036283301152f65c2bf6585a137193d7d6425afcda4efba152a248409d7f781e25a5fef0bb2fe52137e83f9992f2f3d9229fc1e4f84fa1a484bf3b5bff154a4a4c2584ba52fea926d9a3949471024ca7d72381789dd2be17faf8c6ba08390c756eea69f24b10a83fffc7d4049ac8ea26dd8390ceb33c91980c13c143aef26bb2c038effc069d89a404619cf159660f0d81c611832c96b939f4db2241038a42c8f2d36c0b8a28d306dfd58ce94d7b5fd90e6e90d3084acd1ff33c054e3163119a0222357dd4bdff4bf4bbae4c0b02a0c4dab07d5a8e986aac61347b17834fd660be1b22eeb0f6e0a307e001994129047a1f5f3352c6735945c1e6006a2feed7d8ae7f713519e69a6ee0cabc8ec1f2915706b5fd78b59a92321952fb3eed6c6adead68fd4c5c5291b39b7c27d6f4315a247f9235a6c1f8baaaffa9fae83d3eca47842be53c0a32e72161cffde6c2b7156d1c68ecc2f3307254a0107ff9fd3c521d14bb87b0b21bcc86663e09c3cd4fd3480c12acc11057dc8a249eee341a9585905210f2a83d4b563084c3f2de2bfc7b8c8344349ce4663539ff451ed65f13150c311c4120081c13c8a6af242cfd8c443ea1ae047aa2b664ba30e57a3569187dbdaf0294b708044c50982f7dd6116054a01b40492cdb90b8a5996302e13040f52cf9ca980c45e735e16fac851116bd451add0812bef6ac9171807984982c64d8bedf6737c4d202421442fc9e753239d428ee9f21f2e1abce40dc30c562067e8d65ee872a49407da09eac92de63a47c60d37348437ce095708d41c4c157c16f6518201f87463f222838d6456c918244194fc777cb64456058a7fbb45c1cc7244acb4443abe3be8633a413ba212d074f14fb1cd390b5fa3a4918171ac6b735154450fe7965af718b491023110a7a16e389d057799b81405ce3cef813e78c721e295bb8f4558823c7bf0972224a434af8a7193e9cddb43ae0711d35d02bd3751dd7abc9f5473c53ba8a0b4bc8f70310c346a9a90734cc38dade8987b1e267c555b88432528f2be2c43e7d0da951a3b605a47135cc9f26cd04a06191e895cc882d2fe5f826964ea19eef4fa348c602d2b07aeabfc2fd057f99fbab2ffb047506fc6b5f76d0574a61ef6b5b70f955f6509f830e05b2477ecefd05ff26ee2fa47f61cdee85f5ff88fea5fbe432aaffa73b07337ef9453f91fb0beb2a9c77b9bf34d2898471835fe0fe7a749b7c0b277f3e475c77319bb5e7bdcbc7802ec78276bb5f1102e02b05a8f3b50d11d5bf064850ccc9e0815d807e79173c941fa00c024228e208731962d037d3fe41dffe73d95fffb9b9e8b19faca080f0dd15640050aa6dd2bf56b09c2a962a4ee9cf64b1f467ae58709dd2cb5f70beffd59c125f42dd2f754b1a48b89000e17f7df95ff01adea03aed2e84248c412cf8e5c6e58e2412528824e11a9612de61fa06a34c624888d0ecd0fced46f8271c320901a21201c169788387af730ca4e004228e98bc7c3b0fff4220cd518304a684227af91311dee08003c030a410607a199708ff444288391504030ddabb7c980c6f1046380332acc065e272e3f227bac9210194710c39d577f4e9d237fefad18da7c4bf7e222d59583ef05494a04621feaac0fb39571c1650f7a4f8e9d3fd9ce0efaf9cd1efb0e17de43cff4519e7584ebaf6ee43be177dfacfcf1e5dfc0d8f0e7fefd195e7e59ab17479f8c38fcea1d42887ff0ea097ff32a0573c06e8d5b246bbfc4f3daae4378eeabbc4875870c438ffc9c385853acfc319e8ae19775f8ab94eb91dfeafb7befc5b7006f1b305eead8beb2fad3985ca654ffd9f031f0849840e553d35b2f6715e7ddd538c46da6851105305885f69d800e7ba3e1160a2d7f949148158602a23a40322ccb1c6d021dcc0a2a126b18c233cffacf25ca13bb844a2b6407bc3775306858ea24540ee847d9c1dea81c0c24542ff0e47e94de1bab6a27f2925fbcb8ae757a34d8281b01ef52ada14976503f006562a910e9e3c31a82398aec28fe0aa633a63eb74b88e424526594a2e9e1ad56122cc7d5e654d638e120a69ef6feac935dbde6731d3c5ada666988b1c251243e7876f5b85e9be8790c6f5f0fb34e923288ea0658488e9fba6a5cf6dab30bdd19e582c22048337a92ccdf476b7cd18ba21718242c29050fcb3227492854c0eff9dd0cbadbf4239856d4ad8578a18fa4a31e97dedb041efabecf63a98b4bb3dd8ebfe3cf4827f39f4f2805101899e282474dd3ca061e7a30f045e24793ff082905edaabc0cb25d812c65dde6230b7811718d240418c74b13d12905c8225e10dc204d18166dd4086ff1577d13720649ab717332831b9843198bea101c61233c2754f4efc57dc056ac01d859a4a5142cd0071f9301ede203ace4e04a24ca06f37c23f814248400811547088c85be045dfd01fc310214c335abedd08ff24045be93220c6b804970f93e10d065958f3c2b87ed26f81177d07090a4448414904a36f819790a5fbaf1f4131fe49e0450aa8110c4ff7cfd1c7f6fb23a109c9c57b8d6bfef3b347877fc3a3e3df7bf41f85263ef8e892cb10e2f634375737baba1dace432242efba89bfbdbdee1ff293717c83029f8f7bbb9e0b371fcb13e7cccb3ddaba9eb6f4ca673b9fb47fb916c240040a051ce4ff57cdfeb82f180c11edfd0013dee2cc99b2e8640eabeaee29fe42d499dd788d8d722a61e1b6944e02d5e52fbd54f745525025c17985e217a6200cc3aa773dbf2196884dd13bd258938f8794444a3c5a2f51810804b3bed7859f2095316cbe9a3f3b80f6d58f41a16ad5e4fa54e9eb2bf6bbf3ee00e4a8ec298ff5525400c39277d0deb0923957c12e138d0e5e76d0a214904e645a5b600ee81c7a18ebe46b9e8ac607cc5c903bbe2a1332ea4886036048a21dea6af8cc89b59d39ca64fec3b8ca5845467e7afb071b18132226f2a9b90ee54fb9ee2fa848324898cf0384a1e53d7845f4389747d5e34fbdd2f122efc4843424de1f0640da90b1e3e1a1b9692f29bd6b4310cc3f455505db47c2d093541ec13b50789674bd768968744a1ceafdf14c40322c53f4a186aff98474a7c388de9daad37af0e6b469b6353f6444e430220a7d16eca611babfb9c41d86e3a5aeac0429bed59055bba224cea74cb7543f158a6869ba10180a96e14f54139fd7361480066d1662f9cc4b40761af209cda6b0dc210c2f193f6290a84008a7904852e62a4217dc5e4a6ca930b48c336be4f3be5b1068f86ab3d68f0e814d58d890e6598467a78037eea298f7b46c640441751a211ce77ce060c9b984594914421efd3b300e4040811f2b37f1f1a8eed84c5c14d745e420842eeb7cfd2931287cdbe9faa27df6bf9f080a48600e1481683702d5deeb94e42c3ecda02a3843d95518440401089a60b62e897358bd90da388ee3f0a357fdafdd0b418f8fdc31dcf8aae61a80f1d6eacdd97e8e186045fb86aff3b2a3cee192166915a2d16537887b520bfa9386514c80f77137f4083434c819ebdab64a52eafb9dbb132f4bf22acc482bc0be7fa0c35090908ebd9aeba5ac4301ae984c88d9aa43afca2e7f15e1eea62d84fd8b0b1da88fe4272fd96ad5877bf92bfd4ede2b736ec23fb82511cf58c500cf1b24eafdfb8465432ddcdee79b600e4e0a62b79987abdf745f88d54c092842d649f546542a08048576f5c350588e94c4a75c0e086465e5288e3dabe7d504b22ce4339f2542df95ef784474eb6c0374d87f57eb93b2597386004cfa361d5fc8307fb2125a9bb0e5f2f2191313207be8a507c470a722409f9d7ee9750bffa093618029ab932c2da11d3a9599727dff47b038c914f8c93c60d0d69f87b4456c4d45731edc044c59e66ad8c05687dd691d44d62353bf4f79189986600f415d01ba607287594ef7905860469b05d448ac559fbf415850c75110e0a0cc230f4fd21f8146b0c51188af4eb90581cbddb0593172996e354e8f6c14f3361111332da8b34be1bc685abe03ada2098f66ce38616e6a57edb8a425cf75e8a1418c614b26a761870cb717849313c6fce38a15192cff88a77486f62c294032ee24b0cdf9bb38f72ca92f8060aecd7695b9f61bac73750e0cf1adc8f35bb60a17efaef40ad6ea127030cd8a0c3e057c219fb4ad9407e159882af800c281b00c6606830fc046a453ea3d631a6c80d482e05d58ba0cbc6c807c056e41571fe3ed84ad380d348959b934bfe6915f39e5328ab4aba58882b7283543b3621768903f8bdc88d7042b98000214205a4d7456e04702904850c4821be81ad2e09518c0814ba044dbcc1a02e456e8c13000910407fcb5b99d9a5ca0d337dacb92618fd8eb5d23724a6900a2aa566d6f986b5d20a53bb264820a81baabd81c32e456e5a1813cd4a2f1013f0ad962dac58d36cb4ba7911829091eb1a37a6596aa944820bca601cd40a4a2cd90fa15604e981fc1d502bf2b1fdfe73a81541e2d2d6e617f146247cf4bf036a457fefd1df875a918f3e3a46ba19d093cba5e86f944bc5f73fd0ed9029e23f7db227b380699dff51770deb16f091f45358df7f4f938c75ee200234d6acd49f64aac6585d18c0680f322e621229f415874d12227c9954230cfe0ebefcb7f5bf371fe87fc17c08779a7c265c316e02100a4164ffdf832bc61911bf84f2fb078118e1ff9f418ce26f00316226c208fe7fa77719fba919cd7ed6bb8cbc62867ea77719fe47f52ea3af2185fa7d472ea4d3fc311db9f06dffab4a299dcfc776bfd207e3a3cdcb883e69f75db9b836dbe29a976955fad8a87ea375198f6f5d06df695d861f5dbaf727eaa7ddcb108d9da7b0b1764cf732a1dddedf9aa78ff72ec3bfddbb8ce89cda43edcb1e95334f623b10bfca76a0517d0fb01de82cafd008b4a71ab9ef75c3792082a73b4e4733f7242679835ea58c527141cd131736b97d5a781d231e323c5e15bac6f07c6a2a2e1de58f5071511d21785e2a0e234e23e5a402c5d0b66a7cfc4d0315dd099a3f35568c292591ec310f8d80fb649c90b7202b2843e2c64f8915c78e4cb2482287e258d24381f5f8af51565437468b6b691b3681f9fd283666028496d25f731632c0df3b7a376c748449fe615af847fc3cae83b0d733a6b300f73d80436c5c24290724fb7095fd434753881017f13dba1e76d4baefd870bb941262fe6b19df5f3c9992099d29bd622688416cd1575d5c191d19d3a4c2f879e84702c48dcc00202e8f29d04d7f6edd3e282c117f7cfbff502385250ff2c91ae9bd66208f6c2e4d0f14691a44614cdc85bc72a06dcb2b954409a7e4c37c9a8f4857826194b895d318067d5d69705319a55b3481d8f65442bffafb328c10190681ae88947504ea1e2b4d355423daa944d70d3f4f8ae93c5c84b89585c9c0fba676e128ae37be200c6b3bfb59c282704d6d1701a7c53009a05726742e3d020d2400c669a40f098bb839e31af27c6d95d1f75a14468505a31788ead320b14417cc44f2aa3c76ce80b869a242288128aed6e693983408110269a17e85c68821ac07af486afce7f53e835ae47c1493ff88e817f2669f8118f611f20aa97697ae0d5902008dcbdfc370f77d8240a3f0827bbdc2e4c70c4ddb6adac08d20f7347f41dce114ec235a89511416663e552bbdd712e4015941b59515692111b3edf1abc6a4df006a900cf19bcf421153c2b8b618aeca4863404861d78d1bbca2d04c9d1f1cd803328c52147efef719a331481fa40d9e1bce1dc9c53b98b2cfc12051ddbc3462ef872de5efce23215a065fcb302069ac46d26d123ee73cf20bcdce9567a98dc67b351ea267a21c4a28ece2797f1ec96748572a198b6217c392b7fb6d16f67bbc699acbe5339d11066808d8b98272c7f6a6d539f8a81a0f67fba306c6034780211cc6f5beaf66d84deedef4b9812e42042e5d619f6593318d76e39162de187c20790d59b9ae85069324d4aacf5b4c72d302998770ec984aee682b3440094261ff9e4f0213732ab096e54f5548ef350479408831c2b8d6c957fd7962880da0aef3bb694d0875756a1c9a18ea99fe0421c674bf851b86bab8480fbf65f797ba5125f91c1916372e86a0a64cfb6e21ca9880227dd5a66a74cab04061f3860fa19c1f19998061a7d8eff6be78a71e3b2a5c391492a08f0eec0109a6819b32daf73ba6001abd0a70a32a290f39c09f67ee731d4c8df4b20b8bf0ee21ceec86068e6af89876019e65ee6b646b246c473888eda142a3230b6b06795c7f790d27fb9493c911907a6f5f81e96315126237fdc6004450c4322584d9c84f10fc1cd13040b2bec2f9c7b9bc1ad31c559698231a6bf97c56d487df59b22ca6568cbe8a30be1dc1db84ad847e65d67ea893049321d1f35375d27b54ba0f2da26e61112109217a8fdf87acc3c7880832ce9e1a4be79c9108664a034be37836c316b191fe594c07169f1785e29c0b4d77761551896d172ad80d99aed61aa115743fb24f116392c8c8b834b76e5cb912be2dbc914c4afddabd180b5b34fcbe529237d6eb254f78df9a10df52d108c8487cdcee730c7e4140b40e9a860542f76b49a21dc720d33dbae342d79fd43491e89e1c91d6af1cc6b48b26af28e4cd8810cdeaa1c5eeffcf389782081929cf26dac4b9efcc096e3a260aa86b3c9e997e1614c308c9b5e68389435982e82e830c0b2ce20bc73f277e21181491182c8da954a2af17dff37ace38c421da6d797730df4b42fc581dbd55fffc77201bf297211b8f35a8a09a7f556fc9a76ad9f768fb1eb147745557085afc1eb48d658e2337aa0c6009c27374b731c34ea99f7098250b7117579198186e72dd935b238323541e0c852d799f468ba39f3c42f142452ca71dbe4df23306709816fad0a43d709a25a020523ecd88f6ceef6d2671e36221ddac2e8e23e1fde3fc6bda4c0206b594ff6e9283186b0ebff2d0a788624938d4e6d5d3d250524309e8cfbc3ffc4ac33ee051167c1e36b47f96a29510b0885f4ac2e4fdbda1199627464d604962d5c62329e247464628d5199bab68a4d6ebf7be7ce8ae46ea192088e3c07f68600fad26132159dafa3b474bd8c4e1cef70bbb44de143484e7f859aa564a5d68763d67528bee7b629bb0d16c24b60c34dd7ccc3e43ef9691fe5029090eb4ce7fa652d21d393f8a2394f2b21057d6524ce24223826e38432145e2992da689941c44b9da423e81fb9847a85323ea92b0b0b5c0b3020b1400144667af5cbf987d8f5f39bbddf74c68faab38a5f419a242db59513489c0312626f9565f71b5ed35a37d7c9ce88110d6cf57930278a196bac2b9c4c470896e8f7dd33a596f7b1dec7a96894101a428c26fc742633ba6c98826bc8af44e96303494ee57937e8614a300f1306a762d5fe38d9f9b1003c798c57260c1309dfcfba29f028651144f8263636b6106e11a7e2ca04efc3dcd95a78011a813e1ebefda327e35d96d16036aeae827721b50a0d14111bb2c0e18aa118637185f802909d5cfe31bed874a09e968c793c1ed1a48f7d178240502c848a65fd218f54d5f29d39650041d81e231c79fa49574ac3b4c475f811c637ad3eb0ed837cc195c08c93edc76ec01d90f011611bc9e043166227cbdb5787435008825ce78207bf780108390c0088096859bf63e992e6e59e90523b19928f42940178d0c423a68f57dc242dcc8fdc06e9b4b01a13db5e775e4a29069babaa86b19db663d24c18ee4c828a07a763f94ee7964ce740fa7483832a486bd0fe1ca9b8c67d8e12dd619f91c8b9f424e6e299f63a011f8558a1b2f090b0cc2529c0fedb3074406140247c8c4650ce7f0378ed2eb6d862014fab03e4d21e9b58c360c403105e948bf7c1328d0c463b1abc94367e71d85f4ff02a4aa069676290100
8	2	4	STALE	1795899560429199	1795899560408277	1795899561429199	1795899560429199	PARTIAL	3	0	f	1577	\\x1f8b08000000000000ffe5945d6bdb301486eff733ceb5dc486afc21dd6d5d6065c11e2330b6118c6a9fc462b6e549725a13f2df8b9399855db4658132d8ddd1e19578f45e3c7bb058a0de6199f70e248b4598081146744e131ec704bce9740112ee2bed7ea09dedd86c332bacbaafd1066c5698b6c5c26bd302814e0db55125c83ddc19e3735d8204a79b40f03861a2988bb0e4d7512c8080c39f20e704bc6ed079d5742081531e058c053c59712a432139bde271f86d8c7be5112464e9f2365dc0e1f066ff24b978967ca30aef2a44ff37e0fcc5e08d29b13ebdd6d7ca6309044c9bbbbe43bbd3ced8bc36ce81840fd9f23d1050d6aac181fcbe3f8d20a1c6cd08e9876e6c60f5f5d3226740a67f9db2bf0e20298187bc6940d22b4a60f83d4e20edb61fb00d38e5e32335b65b5f1d53f131d65974aeb798379d1a6fb2f3957a98d69c408b7a5bdd99fe48c0d6077246c1260a1ebe2a065d1f8e205375566fabffa8bb28ba00e38feabcd2f52b341785ff4673c985cdad47e1f445957b747e5cc297b7cb25ac9f3415174c3c6faacb1c1bbe4455d7e78ebdc9d27471b3bacdd2fcdde7ece3221d75fb0833e9b63029060000
7	1	1	STALE	1795899560427879	1795899560408276	1795899561427879	1795899560427879	PARTIAL	3	0	f	1089	\\x1f8b08000000000000ffbd93418bdb301484effd19739637b2d68e63ddb64b0ea1a95d4aa06c4b305afb2536b52d5792b36b42fe7b7152d3f4b25d0adddbd330129f1e334718caa93a5091f516d28fe27011c7e19c077c21a23983d35d9543e2a9acec7732b3833fdbcd72a39e6a329e98e5ba6d2977956ec1d0a9a1d6aa803ce2516b975505246cd578e1ad8a43a5e63957f92e0a023058fa011930b8aa21eb54d341427031f77cdf138b8de0328ca5e037220abe8e76a71c41224dd6ab6489d3e9ddf145f2c55fc9772a77b62472ff022e5e0ddee882eacb6b7dad1c1560d06d66fb8ecca1b2da64b5b6161249fa7195dcadc1a08c518385fc76bc8c90d819dd8ea06ee8c62d6c1e3e2d330136fded62fe7580e40ccf59d340f21bce30fc1e279876df0fd47a820b1f0c35b57b579e5dd1d9d619b2b63794359d1a6ffad7927a9e64c1d052b52f1f757f26f0b7277645e14f14227c530ccec49f20620209df7c1fdbd3760c629f979923eb46155feed66b6c5f4cb0881651fc9fbb17be26c2b7d7ddbb4f936479bf59a549f6fe73fa61998c35fc09fb0291e441040000
11	3	10	TRIM	1795899588874412	1795899587873070	1795899589874412	1795899589638044	COMPLETE	15	0	t	17292	\\x1f8b08000000000000ffcd5ad992e2b8b67dbf9fc12bd9694996642923ce833c60c00c3663c2898e0a06638c011b1b30d0d1ff7e43645527537775f529eeb964049136062faf3dacbdb7f45b21f5277eb8f7a75f7659e10d6a9c30ce09d398a6020dbc14b671124e0a6f857d384ec32c1b29693c8eb7bf64dbd1d65766ca241de54b3ffd452dbc1492d171198fa685b7df0ab3385d8db68537f85298fbf254c110463f9a798b38b08410422fc9f7722319b7e1bc712acd1bfdc169b8eaaa83551d3456bda5f06655cee9fa40770391dbbdb01ad7532fd2d78a1119495415fe7b3fcd17ef86575e835a60efbd4c07455fd19b992d66b6711435ddf0ec3d2bd9efa677be6757be4dd0725beb5b6abd6fc1e1a2b11a76a6e1e0e4a161bfd712df7d597fbc8dedde6a2afe935745be79fe6c0ade6dcbbefecc8c47eea3f357af7f155e0af93ccc223fcd0a6fff2e84b92782dc9308750391f5f47db91c87e058372b07e1d93adfe9463e8cebc1b83b10037b6d0ae37c6e06317347c0764d386bd31d5f06b5daf67c07038bc98e70d1af3400a7c96298808687d85eb3b3407eae1f8f431bcef064d8ecc3a9678eda3b343a9dbfda9ce849ad77586d196e73ad97e6e7c76abbba035789e2d4cec7869f8683637fd06b343f1ebb57990c20cf0f9ecbdeb769e4ee7823d3ce1fb974853570c1deb83930f353333f18c21322b72c21eabadede04aa5b54cce32217a23a348530849b0b213ffeb0a012eed359b4541c3c44da7427e912262f4701ec8e77a211ad8793d3e47ce9bab34af7657bd31a6b7ae650e57cb20ac8463b1c3651bf988f8dddfe541bf63b0ae39dbab2644ae06e6d9f2dd4863faad39956aa35539df80bd8781f654a17c3867b1844f909f6c83b538a1baeb887359c2d78deaa08250b9070c93e9a9d5869aa3245bc2b8aa23057c94bad6335d3bcc9bbd6cc37c4ee30a8fa4d74c653eb943ae34cef4ec27113944bc553e6ec5a91d298aa8bedd94606387491e450b79516d9a727ed38a66b7bd3d2c7deeecc8d1066a564748bf2bf4e0fa52e1a2896d5d7d363d5e8f93dc5553d6459bd3469578d336694cbe3b93cb667bda20b2bf2d892c713ab2ddc4331dc7553cbcf6ba5f333e5c770d7dd2079bc2ab614376fcae35c1eebef53c52d16e7bbee2694c7a24a2d6536fceafad5e94258bca9ea4d374556e7fcc07a63959574e3c0079c393cf570dbf38448226743fb13a51cc70769d28d555dad86a0f86e04d80dcec7a9aac47cc4397585291250b90c37f9fd811634da27968845b42f795e7786337af2dac3686179423873a3662d1c17265b553a9333374e78e5ba27730917ec7cfc4eaab66b7a093d01913b53031e68d98daa2e3181c0ced438fba282ec7ad786548914f5d0863bbfbaed746466d2f59e8dfa8da5c62640d847d3a0f3d640341cbf4c72ed0032c07d2b39799d243f2d405378d594d401df2a70e3796b3fed44332172311262206a9ea08a8285bb575c6119a2227443988e98998ae955daa25431446e8cc57eaca841451746dd343d7d237220f68356fd3decafbdfd245d76f25c758646a7860fae67cc93c83965038b4f4aed95b7894e8705322c6768c480b9ee563925dd6a2f2b89a211b6d7de623cdc7472b5e24c8d6489437708a609708654c9b8d8c5991b69c7f9822c481c15d7588fdc731c3e783574bd581db6a50d85cb84de325a6650636179a2537cb045cda81a41a9b8104c5f551015ceca1b8bf23a541425c46b5d5177ae9d97bb0b10095c29da62b66b8c725b09154d892a9929863c8a834651041511d706d6b0cdcaad28ab7716c77d942fe9a69ad88d412d712b4a6e58e3e9b23bc2e50073d0b0aac314c156dc1c754f6a0f78413674a01d1bcba53bb09b7ab1132ea271dcecd6f9ae829dc164d66f054bab7542c6522c59653bb49bd565e84ecb1d63586f62300ec3b6c70f5b618f96c5596bad6cdf4f68c3c4d41335626b6362bbb34559800434ba83913e007ce9b9d59d7221137563289229626bd2f26452940ef7ed55dff5931393be1e2cabceda656525041511d413d33c29650fccc5a15befed275533b1cbc2cb4f9b1d6814736d6a2ee0e8e49dfaed34aa73e22c4da3b88abc034b5751f3b4aa7093ec0cc3c34a3201eea81f2dcdf9d49a7907d27cef3609d6b646e2b9ccebe7d58965fb87c5509fabadba374cc510d8ce68d0d341341a7923a86cbbf676eaf50ca5a537bcf9a8b4ee566bcda4a19bca61e3d69c53dd94c9ea5f52f6ce52271fd1b3c4add4057e392de5377237b2bbdfe4ae556c39eefb6a3c3fa1c0c836b8d88b45e3438e8cf604d3a1aad3c6610637a7710c8615940c3bee87dc19c591d3868d2e3b3667c23717e3a0592e7ec89d7e5c0cc683220b023489677aedccbe5e1a1bec502aae871f72672666a77b2177fa0aed31045663eb628526a0ee405ad72c28b067edb2d629bf90bb74149c8ef553ab752577605627aeb64b8f9d3f91bb0aa9db8b68d951193d55b9d2fc78ce26092234ef79db0619574aa7f3c38949bdb872cb601098c0293bf6590e44d97493c581db15c18df971be4fc7650a6ad5b25d3242bd81bcceb15beeea7de48b2253d3896bc515b280763d9a8aac536eb98958e20e2a6fba4bb36575a817babedaade4bb6e622865b5e41dea35cb6ad4eb65dd3055a6d7f78aa2e4a41427191fe2e6723fa877039307f538fb90bbfadcad9bb9321f8ff6eedc5eb653d5ee63a1cc9c7ab7f9c139985b5d6ef05d7bb44036088fbc7530847bacd8d957593742b0758513a8d4d2ca354fdd7bb11e986c5fd403fc718fa0122d160bb14adcd46af6f6e6d2e02c3c7ae01086e6470972d8944cafdb1ecd22a86769d1c9ed090cadca4ad7a28f72c5164a7ee22541a71dafb7501675a1377062cc85cd3e6c20aaad7aa41c841d0de6efa5715f0c0f3d8e37ac54a1a7a5f951f2b47bf56e672142b552ccdeb79b77d32e0e4227df55f1ba5b3f5f421b4269797ad40cb2c9a1ea6b3af3489b8e85b9ab99de875947ac35349bb360eab9edb2632d3ac053adc46d21cf3a6caad66c53a67bb378046daf7e80229a4cabc37773e7a181abd1b11bf526ab6861d853cf76830a1ef704a14aafec976686ab1efa8b48ad79a46c377ba3939b37a2a5051bf5e1bb9de97add4da33e5e7af629481d6f5d9cbbd041a234a8b9c39a834eadb21bd81b511a6ec261d9690f36c05dd36254aab3c9d4acb4edd3c2dd4ce34c2335cbd6f53e2f163fec2be24ecde28660a937ec9a41dd14fdf2c1c85dc7ffe0555f3787b9b2d00dc38d795fa45a6c74747d9f18ebafdf1fb510e0c53eadedbcc02d6b7920842e5c34197f8d4977700c694d23a3ceacd69a6663d41b959c52d3abb7b77ae3c83ad55545af94dd44698f0273c2bcf5e690549a6d16b78c465e9ed8516a4c2d51a55edb6d7c4dcdbd5a7aea2a8d432c5cdecf6bc1651953ccc3c0e1bdf2692fe12591e377148b57e6c79694c40454e3ae1bf1758074577e0ece650c95654c233044125d9631bafc7e1eb43f82df41e57319333758beef0d1c217dc6191a8d00466e5e1c4f2359c64c8dd59e75dc1d0358ca8333352cab31d827f34ebcc0c27386c6f13d98b9a54a7db7c844e00c3fca1860d879545ec151a27beea0d484fbf6bbd995558cbe98a49b6655e8c47293e3a2c2978b66bdb173e3a2675beb0cf0c6b816badab67a3281293ccb242ce79bc53176d5d37458cbdae710f4cc77457295ce6912394a50cfd870bd5b7973bfd43f41d3db0c8d43cbc8dd4ed548a2da5ce459d1b19a2b2fb1a7ca09acd9a867a499777277a528891c7d4b05cb56f6cacb02a3bc40f93b1d1a78a2127760ce368b58fcbd97e979337d723ce700531122f2c25ea6cf2b8bb252b43dee997cb18c0d38881205d366ec95fb218d458cd76531082b835cd74202f46c809b624a9b61604e655ec862da128da3e37876cb0f811e079621aac781209bf1badbab738cd9726a553cd0d8b602353d9aa7300d662e80d076b5eede1d2cf6c67a5b8fad613a3e7a5cf3b1bd331b692b796f344d558f3cbf3b78efd92e494aeef0e819b8393b75472dbd14f0bc26aac1dc3fb6f67d305aa85ccba787c6706e6759db717db5a51fe65e640d79195abcc87079ac1bedd67c5e0a17aa137a9d612d6ad8d38e5372875df338deabd3d261ae07065df9d3129e156b5e608863d4a803d6333b9385e9a90d9177eb87e2989822b1a947b2d1366af68db46406e128f50ed576d26d567723ddacb961df3bb07061350ee5b864264929f58edb7e13d4a3b835370ff16aee6d9ba9032ad0f7b9dec54de0f56727b55b6e522f31c091216f110e66a08276e3a1f16e2a732ff1cba6654df6a82ad2a5a37bd5182d237d5f6d1c84eb8bb16c250abffefefbfffcf677e7225f1b70650f2fa721ca245eaffdc9368cd7d78391711c6fbf8472209285ab5f461a1c91993af3b5f10453df2fbc14327f537893bf1faefc6c3b5a2585b7020288fe02e12f8875107823fc0d8157a291a1bc5cce610a6f8566a3566958859f807c369a6cb3b9ef6f9f0b7c154ffde5c7afed96a3ad3f2dbc14e2f5976c97f8e93ecce2f4cb32ceb2c25ba1dcac998597c2284d474739e6f8ede3dfc25b61e9cf24c8ed31910c7406aef5055e8f447efb76704676f8b25a15dec02b78291c3ffffd06641dec8efefa170490fc91a5bf0eb6f3f355daf9b224f5b36c97fa5f56c9487e135e9e1a1dbe9d462f85b51f06f371bc3b2380bffefe7281027e4381c8ff290cf0ebeff2ef3ff70ee96fbbec9fb806d25e0adbbb9b2202d98dc96ecc7b69c1bba70780c99fdf2671b8de5e7092fa81f4aa3895a1e1145e0ac168179ce3c4294883fcd93de0cfbac75f72cd016414fe9d1cb295c1f84fd866f0a5f0c7f7bfc3eaad5528c018e197423ada86b17c58ccc94b61eacf961f19edec8eea2b62489509281d85ebb3135315010cf09f51b8f557899f8eb6f28349e10de157f01d53dc03a380f24b6094aa77c8f02bd5d8153046193943b8050638a73f05984609a017c0a826ed7b030cbd6228ed72810ca9106a84ff24648f6cc955a8924bca18e60f901120afba404610865445cf33a68628e797c6e44cbb372679a5aa8aaf39431803c67e12b2079c69aa86f19535f1bdffe357caa5e12e29a30432489f084c4300b10b600c33fc803202e0b53155463021f489c6e44805daa531a164f08e33c0c07500400621e64f743346808aaedc8c5076870cbe3284af91018d0195c0e785260700834b6414b37b3f23afaa86e8759e25105295ff08677f25470c62c621feae1c9dbf9dfc795938f6c7238a47d3f16482089da9e39106089d303c8553e273f4cbb73b52a062f44da888141ab9a4f8e5bbc2b6f60fdbc21b43724d71392dbcfdfb2f9f0a61022178aec8a27f2eb21c1028bdeb4264b5fb58565f319685d3a5f5b186a0bcf45911c32921f452fe0980da835826005f2363540344d59e18310c42992b3ef31fc2f7b14c5e1167d7c854863442c9d3386300a998ab979ca9f75aa6be022cf15e00c3147ec8c8932a13063026daa59b312033f0bd9ba9005dab2cc490c3e7a53f06347c4e621794c93c7d830cbc527a830c42a2695c7b9acc3208296797c8b447f24fb00c924b27e358e54f2c7f19242a90f5eea7943d0a4cf4aa4272edfe10328235f43c5b2200b024e99331287ff8de96985f7306286244b611cfe20c210a08b86a19c8a32a53d3d0153208315401fda164f69772443065407dae1ca97f538e1ef1a4a92abee48953e9de775e2f2bd0eb3c01a04ae59d9fe55b2a40e7aee9428ee8bd6fa157c8d87599848186d527a65615524d4e4c2eaaf1874eaf2272e3f49049317b226584007845d9b93bbd737acc652f78a9e09c53244bc16785a3ca0192cef29928a8ec3befe44863523f2fdd4ca31a976dfdb338c3eaad1c019911eeacc918b991234a217814003f8b338c1194f7fc8a0cca31e05dfba2c11bef07943c332a31030c5d96629c3da48b6ab22dbcc4a562282b906789378100ab973d323d37c377894ca57284705957438d1259d13fcb8e44052abf49b1f7a5187c45f0262a01d63892ad61f273a4881246a555fe3bfd1ef9d17e0fffbd7e8f691843f45c81c5ff5c600983404e603e331f9273adfb398486ae673790408c1e95bb3f2b9429624cce3e2e8a3739c4ba8b18acc9fafcaa79211a91befaac88a172b27459567255b69cf7f32e2ce5ed522d30e2fc89bd0b65fc5ce95f88c50360ea2b2172a4799964344a3459c33f8b3239bb9465e667514264e1ff60de8b6e06712ad2d447c87e16671ac6e727ffe48c4ba077c8a87a834cd5286012c3d338d32897a17dd1ef3d18f8c2574d93c272c519d0d08f0de27e8c338654554ad2a7989de7a7772a8bd9cdf41e10552532bf3c0d19d6f875f14b6576bb1f5e0289ffd29af4bcb6f42c5b3242afc76a1a7cb078855e09be199123b924270bf59f24b28cabe71ef879eba9ecc1d373a4c9359bffcfeba91f7cfeccf5540e3106e0fb5cfbd9365cc9ed123fb7a2515f0a7e124fe69f88ce1fbf14f67e9ac90d20f28abfdc1581f92b54a9dc15f1770d77b12f80e2572847c45f4f2de3fce3b4fa4ab4cfd3f330f8e3f2f3f2e8245e4fc3f3fe94b742a755a9d72db9cbe2c1f682e01c21fffef53b66be44c45fb91c86de22e2afe7b1dd2d220dbc42396ebb4454b644ad531e7c07d1cf708a2755b9f447ab5cf2b7aa5c8e20d0645ff7cc2a97fcf32a57ee559395d0a7603d9850c257a4de8c44a0aa012a87f6cfd22b4e299755ed2730e98a77720598c47bb9a6ab52aec9eefb69c034a46a378df47dc1a6ca3aee66a8cb103d4f969e25a5f2edca96e41cbe77528a90ece92e251e000d3f711d9c0382d0d5760bcce5c4fb8e330ed835324d230480e7ad03c91b929b22f78135e5a6067ad3185082ce03cc672183189f45e9c29ab24ebae38caa37bd14262a62f489d68484137035a2670f77f51028c7f117c838841a93cff434ce34a45ded37225c36caf711a0de4c6c90a6b1b3043e8b330490769dcea0ec47ef3863b78bc78863fa6825e89f6d1de084ca46e3b97244ffb11c71448026579c2e5cebc1223b7ac5e0765d16a980f0e775c31c117c9eff7cf64f50e6a5bbce8eb39b3125d080f6ccb4cf550cd1952069e7b8bb9f6d50d9815c3a3d4700ffd88ad98f71a65255956be59f5289c9c311fd99d9ab012a61587d62725539c2d24e978b078f3626107253f770483179e2a48a6324f7575d5a5395cbadf79cc15bce348dfcbc4efd11320aa09cd75e4caa1e4e5d10970dfc2532b945e58901802960321d7c5226b729deaf37aaf0b68665e0bcc4fb2c600469581681177b391ecc5cf02b25371b1325855c2ea83dcb9684aa502eab7f52a63dd898835fb5db2dc32ad7b4f38260f273f488aa72c7cb7fabe993b6f9a1a64fbb6afafe17d3d2bf888c430000
\.


--
-- Data for Name: boots; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.boots (boot, robot_id, boot_id, first_seen_us) FROM stdin;
1	1	sim-53a95aa6c0acf744	1795899515215253
2	2	sim-927819c495d23679	1795899515215256
3	3	sim-a71a5f3fe7bc46ee	1795899560576470
4	4	sim-ba60d84d60738174	1795899560576476
\.


--
-- Data for Name: calibrations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.calibrations (calibration_id, model, version, measurements, fit, calibration, uploaded_us, uploaded_by) FROM stdin;
1	measured	1	{"model":"measured","youngs_modulus_mpa":0.12,"geometry":null,"rows":[{"pressure_mpa":0.01,"strain":0.0072,"elongation_mm":null},{"pressure_mpa":0.02,"strain":0.0152,"elongation_mm":null},{"pressure_mpa":0.03,"strain":0.023999999999999997,"elongation_mm":null},{"pressure_mpa":0.04,"strain":0.0336,"elongation_mm":null},{"pressure_mpa":0.05,"strain":0.044,"elongation_mm":null},{"pressure_mpa":0.06,"strain":0.0552,"elongation_mm":null},{"pressure_mpa":0.07,"strain":0.0672,"elongation_mm":null},{"pressure_mpa":0.08,"strain":0.08,"elongation_mm":null},{"pressure_mpa":0.09,"strain":0.0936,"elongation_mm":null},{"pressure_mpa":0.1,"strain":0.10799999999999998,"elongation_mm":null},{"pressure_mpa":0.11,"strain":0.1232,"elongation_mm":null},{"pressure_mpa":0.12,"strain":0.1392,"elongation_mm":null},{"pressure_mpa":0.13,"strain":0.156,"elongation_mm":null},{"pressure_mpa":0.14,"strain":0.17359999999999998,"elongation_mm":null},{"pressure_mpa":0.15,"strain":0.192,"elongation_mm":null}],"reason":null}	{"c":{"value":2.778369447015907,"standard_error":0.040642416863462885,"low":2.6912135227830696,"high":2.8683479474080023},"a":{"value":5.255876425856451,"standard_error":0.03316621079173411,"low":5.184107962587237,"high":5.328638447199148},"b_per_mpa":{"value":8.233259570471512,"standard_error":0.12290426312915212,"low":7.9697821904631825,"high":8.505447393013533},"elongation_gain_mm":null,"strain_scatter":0.00156834107416034,"elongation_scatter":null,"residuals":[{"k2":7.639261133628423,"k2_residual":0.0026753402253185676,"elongation_residual":null},{"k2":7.237194758174294,"k2_residual":0.00012553734517317672,"elongation_residual":null},{"k2":6.87533502026558,"k2_residual":-0.001253330353990556,"elongation_residual":null},{"k2":6.547938114538647,"k2_residual":-0.0017603296186459172,"elongation_residual":null},{"k2":6.250304563877801,"k2_residual":-0.0016518077757081695,"elongation_residual":null},{"k2":5.978552191535287,"k2_residual":-0.0011478201412518096,"elongation_residual":null},{"k2":5.729445850221318,"k2_residual":-0.0004371869676056406,"elongation_residual":null},{"k2":5.5002680162124635,"k2_residual":0.0003184621346994376,"elongation_residual":null},{"k2":5.288719246358138,"k2_residual":0.0009813967494343157,"elongation_residual":null},{"k2":5.092840755752282,"k2_residual":0.0014350570542527308,"elongation_residual":null},{"k2":4.910953585903986,"k2_residual":0.001581747871024053,"elongation_residual":null},{"k2":4.7416103588038485,"k2_residual":0.001340651708597873,"elongation_residual":null},{"k2":4.583556680177054,"k2_residual":0.0006460842761328855,"elongation_residual":null},{"k2":4.435700013074568,"k2_residual":-0.0005540636680232414,"elongation_residual":null},{"k2":4.297084387665987,"k2_residual":-0.0022997388394083718,"elongation_residual":null}]}	{"name":"measured","c":2.778369447015907,"a":5.255876425856451,"b_per_mpa":8.233259570471512,"youngs_modulus_mpa":0.12,"elongation_gain_mm":8.676619894902702}	1795899515182645	local
\.


--
-- Data for Name: changes; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.changes (change_id, tx, recorded_us, fleet, kind, robot_id, whisker_id, number, command_id) FROM stdin;
1	808	1795899515195385	f	POLICY	\N	\N	\N	\N
2	808	1795899515195404	f	ACTION	\N	\N	4	\N
3	817	1795899515459579	f	ACTION	2	\N	\N	\N
4	818	1795899515471172	f	ACTION	1	\N	\N	\N
5	819	1795899515485302	f	ACTION	2	\N	\N	\N
6	820	1795899515501812	f	ACTION	1	\N	\N	\N
7	879	1795899525226468	f	HEALTH	\N	8	\N	\N
8	879	1795899525226468	f	HEALTH	\N	9	\N	\N
9	879	1795899525226468	f	HEALTH	\N	5	\N	\N
10	879	1795899525226468	f	HEALTH	\N	6	\N	\N
11	879	1795899525226468	f	HEALTH	\N	4	\N	\N
12	879	1795899525226468	f	HEALTH	\N	7	\N	\N
13	879	1795899525189545	f	HEALTH	\N	1	\N	\N
14	879	1795899525189545	f	HEALTH	\N	3	\N	\N
15	879	1795899525189545	f	HEALTH	\N	2	\N	\N
16	946	1795899535222999	f	HEALTH	\N	2	\N	\N
17	946	1795899535222999	f	ALARM	\N	2	\N	\N
18	989	1795899542122235	f	HEALTH	\N	6	\N	\N
19	989	1795899542122235	f	HEALTH	\N	5	\N	\N
20	989	1795899542122235	f	HEALTH	\N	8	\N	\N
21	989	1795899542100450	f	HEALTH	\N	3	\N	\N
22	989	1795899542100450	f	HEALTH	\N	1	\N	\N
23	992	1795899542436757	f	TOUCH_TEST	\N	5	\N	\N
24	996	1795899542874405	f	TOUCH_TEST	2	5	\N	\N
25	996	1795899542909806	f	TOUCH_TEST	2	5	\N	\N
26	996	1795899542993232	f	TOUCH_TEST	2	5	\N	\N
27	996	1795899543099420	f	TOUCH_TEST	2	5	\N	\N
28	996	1795899543174917	f	TRIM	\N	1	4294967296	\N
29	996	1795899543174917	f	HEALTH	\N	1	\N	\N
30	996	1795899543174917	f	COMPENSATION	\N	1	4294967296	\N
31	996	1795899543174917	f	SETPOINT	\N	1	\N	ea9dcf50-31f2-5629-b2c3-f1a948ddd282
32	998	1795899543204808	f	TOUCH_TEST	2	5	\N	\N
33	998	1795899543310898	f	TOUCH_TEST	2	5	\N	\N
34	998	1795899543215584	f	SETPOINT	\N	\N	\N	ea9dcf50-31f2-5629-b2c3-f1a948ddd282
35	998	1795899543215585	f	SETPOINT	\N	\N	\N	ea9dcf50-31f2-5629-b2c3-f1a948ddd282
36	1003	1795899543373923	f	TOUCH_TEST	2	5	\N	\N
37	1003	1795899543373923	f	TOUCH_TEST	\N	5	\N	\N
38	1003	1795899543811300	f	TRIM	\N	6	8589934592	\N
39	1003	1795899543811300	f	HEALTH	\N	6	\N	\N
40	1003	1795899543811300	f	COMPENSATION	\N	6	8589934592	\N
41	1003	1795899543811300	f	SETPOINT	\N	7	\N	0c7385cc-2200-502b-a125-a12f285374f4
42	1004	1795899543816776	f	TOUCH_TEST	2	5	\N	\N
43	1004	1795899543816777	f	SETPOINT	\N	\N	\N	0c7385cc-2200-502b-a125-a12f285374f4
44	1004	1795899543816778	f	SETPOINT	\N	\N	\N	0c7385cc-2200-502b-a125-a12f285374f4
45	1004	1795899543852206	f	TRIM	\N	3	4294967297	\N
46	1004	1795899543852206	f	HEALTH	\N	3	\N	\N
47	1004	1795899543852206	f	COMPENSATION	\N	3	4294967297	\N
48	1004	1795899543852206	f	ALARM	\N	3	\N	\N
49	1006	1795899543874131	f	TOUCH_TEST	2	5	\N	\N
50	1006	1795899543894861	f	TRIM	\N	8	8589934593	\N
51	1006	1795899543894861	f	HEALTH	\N	8	\N	\N
52	1006	1795899543894861	f	COMPENSATION	\N	8	8589934593	\N
53	1006	1795899543894861	f	SETPOINT	\N	9	\N	5751a546-5262-534d-b6fd-9cdb34acd1dc
54	1006	1795899543894861	f	TOUCH_TEST	2	5	\N	\N
55	1010	1795899543898190	f	SETPOINT	\N	\N	\N	5751a546-5262-534d-b6fd-9cdb34acd1dc
56	1010	1795899543898191	f	SETPOINT	\N	\N	\N	5751a546-5262-534d-b6fd-9cdb34acd1dc
57	1010	1795899544001012	f	TOUCH_TEST	2	5	\N	\N
58	1010	1795899544107962	f	TOUCH_TEST	2	5	\N	\N
59	1010	1795899544193334	f	TOUCH_TEST	2	5	\N	\N
60	1010	1795899544277025	f	TRIM	\N	5	8589934594	\N
61	1010	1795899544277025	f	HEALTH	\N	5	\N	\N
62	1010	1795899544277025	f	COMPENSATION	\N	5	8589934594	\N
63	1010	1795899544277025	f	SETPOINT	\N	5	\N	f306fb61-4766-56f9-8350-04f56f066179
64	1010	1795899544277025	f	TOUCH_TEST	2	5	\N	\N
65	1011	1795899544288440	f	SETPOINT	\N	\N	\N	f306fb61-4766-56f9-8350-04f56f066179
66	1011	1795899544288441	f	SETPOINT	\N	\N	\N	f306fb61-4766-56f9-8350-04f56f066179
67	1011	1795899544323297	f	TOUCH_TEST	2	5	\N	\N
68	1027	1795899546461764	f	SETPOINT	\N	\N	\N	0c7385cc-2200-502b-a125-a12f285374f4
69	1027	1795899546529331	f	TOUCH_TEST	\N	7	\N	\N
70	1027	1795899546690517	f	SETPOINT	\N	\N	\N	5751a546-5262-534d-b6fd-9cdb34acd1dc
71	1027	1795899546760690	f	TOUCH_TEST	\N	9	\N	\N
72	1030	1795899546872587	f	TOUCH_TEST	2	7	\N	\N
73	1030	1795899546873012	f	TOUCH_TEST	2	9	\N	\N
74	1030	1795899546909438	f	SETPOINT	\N	\N	\N	f306fb61-4766-56f9-8350-04f56f066179
75	1030	1795899546909439	f	TOUCH_TEST	2	7	\N	\N
76	1030	1795899546909440	f	TOUCH_TEST	2	9	\N	\N
77	1030	1795899546977769	f	TOUCH_TEST	2	7	\N	\N
78	1030	1795899546977769	f	TOUCH_TEST	2	9	\N	\N
79	1030	1795899547045572	f	TOUCH_TEST	2	7	\N	\N
80	1030	1795899547045572	f	TOUCH_TEST	2	9	\N	\N
81	1030	1795899547142841	f	TOUCH_TEST	2	7	\N	\N
82	1030	1795899547142841	f	TOUCH_TEST	2	9	\N	\N
83	1030	1795899547218593	f	TOUCH_TEST	2	7	\N	\N
84	1030	1795899547218593	f	TOUCH_TEST	2	9	\N	\N
85	1030	1795899547302793	f	TOUCH_TEST	2	7	\N	\N
86	1030	1795899547302793	f	TOUCH_TEST	2	9	\N	\N
87	1033	1795899547385931	f	TOUCH_TEST	2	7	\N	\N
88	1033	1795899547385931	f	TOUCH_TEST	2	9	\N	\N
89	1033	1795899547478661	f	TOUCH_TEST	2	7	\N	\N
90	1033	1795899547478661	f	TOUCH_TEST	2	9	\N	\N
91	1033	1795899547558790	f	TOUCH_TEST	2	7	\N	\N
92	1033	1795899547558790	f	TOUCH_TEST	2	9	\N	\N
93	1033	1795899547619145	f	TOUCH_TEST	2	7	\N	\N
94	1033	1795899547619145	f	TOUCH_TEST	2	9	\N	\N
95	1033	1795899547705744	f	TOUCH_TEST	2	7	\N	\N
96	1033	1795899547705744	f	TOUCH_TEST	2	9	\N	\N
97	1033	1795899547812016	f	TOUCH_TEST	2	7	\N	\N
98	1033	1795899547812016	f	TOUCH_TEST	2	9	\N	\N
99	1033	1795899547570958	f	SETPOINT	\N	\N	\N	ea9dcf50-31f2-5629-b2c3-f1a948ddd282
100	1033	1795899547614460	f	TOUCH_TEST	\N	1	\N	\N
101	1036	1795899547872196	f	TOUCH_TEST	2	7	\N	\N
102	1036	1795899547872196	f	TOUCH_TEST	2	9	\N	\N
103	1036	1795899547961890	f	TOUCH_TEST	2	7	\N	\N
104	1036	1795899547961890	f	TOUCH_TEST	2	9	\N	\N
105	1036	1795899548033229	f	TOUCH_TEST	2	7	\N	\N
106	1036	1795899548033229	f	TOUCH_TEST	2	9	\N	\N
107	1036	1795899548125803	f	TOUCH_TEST	2	7	\N	\N
108	1036	1795899548125803	f	TOUCH_TEST	2	9	\N	\N
109	1036	1795899548197309	f	TOUCH_TEST	2	7	\N	\N
110	1036	1795899548197309	f	TOUCH_TEST	2	9	\N	\N
111	1036	1795899548291008	f	TOUCH_TEST	2	7	\N	\N
112	1036	1795899548291008	f	TOUCH_TEST	2	9	\N	\N
113	1036	1795899548357210	f	TOUCH_TEST	2	7	\N	\N
114	1036	1795899548357210	f	TOUCH_TEST	2	9	\N	\N
115	1036	1795899547888724	f	TOUCH_TEST	1	1	\N	\N
116	1036	1795899547919084	f	TOUCH_TEST	1	1	\N	\N
117	1036	1795899548038694	f	TOUCH_TEST	1	1	\N	\N
118	1036	1795899548174676	f	TOUCH_TEST	1	1	\N	\N
119	1036	1795899548342926	f	TOUCH_TEST	1	1	\N	\N
120	1039	1795899548457141	f	TOUCH_TEST	2	7	\N	\N
121	1039	1795899548457141	f	TOUCH_TEST	2	9	\N	\N
122	1039	1795899548527186	f	TOUCH_TEST	2	7	\N	\N
123	1039	1795899548527186	f	TOUCH_TEST	2	9	\N	\N
124	1039	1795899548631848	f	TOUCH_TEST	2	7	\N	\N
125	1039	1795899548631848	f	TOUCH_TEST	2	9	\N	\N
126	1039	1795899548674340	f	TOUCH_TEST	2	7	\N	\N
127	1039	1795899548675253	f	TOUCH_TEST	2	7	\N	\N
128	1039	1795899548675254	f	TOUCH_TEST	2	9	\N	\N
129	1039	1795899548549584	f	TOUCH_TEST	1	1	\N	\N
130	1039	1795899548730556	f	TOUCH_TEST	1	1	\N	\N
131	1042	1795899548874654	f	TOUCH_TEST	1	1	\N	\N
132	1042	1795899549009106	f	TOUCH_TEST	1	1	\N	\N
133	1042	1795899549209423	f	TOUCH_TEST	1	1	\N	\N
134	1045	1795899549364867	f	TOUCH_TEST	1	1	\N	\N
135	1045	1795899549546787	f	TOUCH_TEST	1	1	\N	\N
136	1045	1795899549661187	f	TOUCH_TEST	1	1	\N	\N
137	1056	1795899550988213	f	ERROR	\N	\N	8589934592	\N
138	1056	1795899551116624	f	ERROR	\N	\N	8589934593	\N
139	1062	1795899552130630	f	ERROR	\N	\N	4294967296	\N
140	1071	1795899553531107	f	ERROR	\N	\N	8589934594	\N
141	1095	1795899557677780	f	ERROR	\N	\N	8589934592	\N
142	1095	1795899557677780	f	ERROR	\N	\N	8589934592	\N
143	1095	1795899557862116	f	SETPOINT	\N	7	\N	480b2f79-29c9-5215-8d3e-6706c0383dbc
144	1096	1795899557874392	f	SETPOINT	\N	\N	\N	480b2f79-29c9-5215-8d3e-6706c0383dbc
145	1096	1795899557874393	f	SETPOINT	\N	\N	\N	480b2f79-29c9-5215-8d3e-6706c0383dbc
146	1096	1795899557880037	f	ERROR	\N	\N	8589934593	\N
147	1096	1795899557880037	f	ERROR	\N	\N	8589934593	\N
148	1099	1795899558111380	f	SETPOINT	\N	9	\N	81cc1ce2-1806-5930-a0df-5935770f2ab6
149	1101	1795899558116306	f	SETPOINT	\N	\N	\N	81cc1ce2-1806-5930-a0df-5935770f2ab6
150	1101	1795899558116307	f	SETPOINT	\N	\N	\N	81cc1ce2-1806-5930-a0df-5935770f2ab6
151	1101	1795899558192917	f	ACTION	\N	\N	10	\N
152	1105	1795899558350623	f	SETPOINT	\N	4	\N	0c37bd95-658a-59da-a81d-1650dc8ec40f
153	1105	1795899558351208	f	ACTION	\N	\N	11	\N
154	1106	1795899558354719	f	SETPOINT	\N	\N	\N	0c37bd95-658a-59da-a81d-1650dc8ec40f
155	1106	1795899558355003	f	SETPOINT	\N	\N	\N	0c37bd95-658a-59da-a81d-1650dc8ec40f
156	1110	1795899558369150	f	SETPOINT	\N	\N	\N	480b2f79-29c9-5215-8d3e-6706c0383dbc
157	1110	1795899558435043	f	TOUCH_TEST	\N	7	\N	\N
158	1110	1795899558748626	f	ERROR	\N	\N	4294967296	\N
159	1110	1795899558748626	f	ERROR	\N	\N	4294967296	\N
160	1110	1795899558862830	f	SETPOINT	\N	1	\N	51b43e4d-65ce-50c4-ac50-da011232dd60
161	1111	1795899558868108	f	TOUCH_TEST	2	7	\N	\N
162	1111	1795899558868511	f	SETPOINT	\N	\N	\N	51b43e4d-65ce-50c4-ac50-da011232dd60
163	1111	1795899558868512	f	SETPOINT	\N	\N	\N	51b43e4d-65ce-50c4-ac50-da011232dd60
164	1114	1795899558909194	f	TOUCH_TEST	2	7	\N	\N
165	1114	1795899558966904	f	SETPOINT	\N	\N	\N	81cc1ce2-1806-5930-a0df-5935770f2ab6
166	1114	1795899558998426	f	TOUCH_TEST	\N	9	\N	\N
167	1114	1795899558998426	f	TOUCH_TEST	2	7	\N	\N
168	1114	1795899559084151	f	TOUCH_TEST	2	7	\N	\N
169	1114	1795899559180543	f	TOUCH_TEST	2	7	\N	\N
170	1114	1795899559248476	f	TOUCH_TEST	2	7	\N	\N
171	1117	1795899559366436	f	TOUCH_TEST	2	9	\N	\N
172	1117	1795899559377211	f	TOUCH_TEST	2	9	\N	\N
173	1117	1795899559377519	f	TOUCH_TEST	2	7	\N	\N
174	1117	1795899559377519	f	TOUCH_TEST	2	9	\N	\N
175	1117	1795899559453934	f	TOUCH_TEST	2	7	\N	\N
176	1117	1795899559453934	f	TOUCH_TEST	2	9	\N	\N
177	1117	1795899559542847	f	TOUCH_TEST	2	7	\N	\N
178	1117	1795899559542847	f	TOUCH_TEST	2	9	\N	\N
179	1117	1795899559607018	f	TOUCH_TEST	2	7	\N	\N
180	1117	1795899559607018	f	TOUCH_TEST	2	9	\N	\N
181	1117	1795899559670632	f	TOUCH_TEST	2	7	\N	\N
182	1117	1795899559670632	f	TOUCH_TEST	2	9	\N	\N
183	1117	1795899559759826	f	TOUCH_TEST	2	7	\N	\N
184	1117	1795899559759826	f	TOUCH_TEST	2	9	\N	\N
185	1117	1795899559760720	f	SETPOINT	\N	\N	\N	0c37bd95-658a-59da-a81d-1650dc8ec40f
186	1117	1795899559825315	f	TOUCH_TEST	2	7	\N	\N
187	1117	1795899559825315	f	TOUCH_TEST	2	9	\N	\N
188	1117	1795899559825316	f	TOUCH_TEST	2	9	\N	\N
189	1117	1795899559374953	f	SETPOINT	\N	\N	\N	51b43e4d-65ce-50c4-ac50-da011232dd60
190	1118	1795899559930237	f	TOUCH_TEST	2	7	\N	\N
191	1124	1795899560440078	f	ALARM	\N	3	\N	\N
192	1125	1795899560427879	f	HEALTH	\N	1	\N	\N
193	1125	1795899560427879	f	HEALTH	\N	2	\N	\N
194	1125	1795899560427879	f	HEALTH	\N	3	\N	\N
195	1125	1795899560427879	f	ALARM	1	\N	\N	\N
196	1125	1795899560427879	f	ALARM	\N	2	\N	\N
197	1129	1795899560497072	f	ALARM	\N	2	\N	\N
198	1131	1795899560429199	f	HEALTH	\N	4	\N	\N
199	1131	1795899560429199	f	HEALTH	\N	5	\N	\N
200	1131	1795899560429199	f	HEALTH	\N	6	\N	\N
201	1131	1795899560429199	f	HEALTH	\N	7	\N	\N
202	1131	1795899560429199	f	HEALTH	\N	8	\N	\N
203	1131	1795899560429199	f	HEALTH	\N	9	\N	\N
204	1131	1795899560429199	f	ALARM	2	\N	\N	\N
205	1131	1795899560539362	f	POLICY	\N	\N	\N	\N
206	1131	1795899560539434	f	ACTION	\N	\N	14	\N
207	1200	1795899570555196	f	HEALTH	\N	11	\N	\N
208	1200	1795899570555196	f	HEALTH	\N	10	\N	\N
209	1273	1795899582136454	f	TOUCH_TEST	\N	12	\N	\N
210	1306	1795899587541961	f	HEALTH	\N	10	\N	\N
211	1316	1795899588874412	f	TRIM	\N	10	12884901888	\N
212	1316	1795899588874412	f	HEALTH	\N	10	\N	\N
213	1316	1795899588874412	f	COMPENSATION	\N	10	12884901888	\N
214	1316	1795899588874412	f	ALARM	\N	10	\N	\N
215	1320	1795899589307474	f	POLICY	\N	\N	\N	\N
216	1320	1795899589307522	f	ACTION	\N	\N	15	\N
217	1341	1795899591298424	f	HEALTH	\N	12	\N	\N
218	1341	1795899591385471	f	TOUCH_TEST	4	12	\N	\N
219	1431	1795899602218598	f	TOUCH_TEST	\N	12	\N	\N
220	1431	1795899602220745	f	ACTION	\N	\N	17	\N
221	1431	1795899602219548	f	ACTION	\N	\N	17	\N
\.


--
-- Data for Name: compensation_candidates; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_candidates (compensation_id, ordinal, whisker_id, compensation_case, length_mm, length_sd_mm, pressure_before_mpa, pressure_mpa, predicted_error, predicted_error_by_ratio, gives_up_own_role, chosen, refused, predicted_error_low, predicted_error_high) FROM stdin;
4294967296	0	1	SELF_COMPENSATION	62.352987260817315	0.290533663343571	0.1	0.0239163422454471	0.184925703165943	[0.4602207158335452,0.39988443619553604,0.33744664482258124,0.27777636599417743,0.22314768761968,0.17445289020617513,0.1318642696429799,0.09519381961024265,0.06408786224650434,0.03813132755429636,0.016902418265595825,1.7897434773341983e-15]	f	t	\N	0.13341909734883597	0.2739056076242349
8589934592	0	6	SELF_COMPENSATION	45.35864093451495	0.3517681490881638	0.1	0	0.6889433331621059	[0.764197627703869,0.766392934502087,0.7571051957537972,0.7411917061975003,0.7219159425841857,0.7013675526252656,0.6808341622083224,0.6610772322233833,0.6425215923053905,0.6253807136051933,0.6097377862728834,0.5955975519633928]	f	f	NEEDS_BELOW_RANGE	0.6033398019746002	0.7262903781333586
8589934592	1	7	SHORTER_FOR_LONGER	65.99742566828668	0.09998510543085688	0.1	0.05610445272379032	0.1911272055555676	[0.49313446695279556,0.42193100623096585,0.35154012450333366,0.2860463294588606,0.22720615756569823,0.17556654246785014,0.13105971088379625,0.09332172827146692,0.061863130431519586,0.03615942958586934,0.015697840302251184,1.2403537368201953e-11]	t	t	\N	0.12510741372838216	0.3289316991097235
4294967297	0	3	SELF_COMPENSATION	45.10639341098966	0.35496266486060873	0.1	0	0.6931213463916085	[0.766402603042119,0.7692278549339158,0.7605107792914053,0.7450670916220784,0.7261556013500942,0.7058760203075874,0.6855304334836131,0.6658947224929641,0.6474064551129731,0.630289755589891,0.614636485894521,0.6004583535781398]	f	f	NEEDS_BELOW_RANGE	0.6083526052476528	0.7301706265449139
8589934593	0	8	SELF_COMPENSATION	45.19655668779852	0.3112731580288288	0.1	0	0.6489289818890435	[0.7314155218566161,0.7349696796960773,0.7251803124869551,0.7076817722651795,0.6862418835684935,0.6632707564630995,0.6402549077553046,0.6180757812600882,0.5972277051204515,0.5779617415017242,0.5603787602682653,0.544488960426268]	f	f	NEEDS_BELOW_RANGE	0.5513661746859375	0.6915155199076667
8589934593	1	9	LONGER_FOR_SHORTER	67.99836258874367	0.09991102480825781	0.1	0.1466952802560571	0.3013531449730227	[0.7531297312513126,0.6477776142858799,0.5450291141047972,0.44920336434719016,0.3622134559138374,0.2846932812463157,0.21660009275427444,0.15754414712786083,0.10697166252792671,0.0642668551191467,0.028808420989370306,8.36033425764502e-12]	t	t	\N	0.19401245347417592	0.4923980289681928
8589934594	0	5	SELF_COMPENSATION	65.81550793964036	0.2963732229420894	0.1	0.056097985000166134	0.21038613857336852	[0.5234915986914741,0.4526434088621999,0.3817347436369917,0.3148004722686083,0.25369847510090154,0.19912899860788907,0.1511855540717306,0.10965493363455067,0.07418113839570814,0.0443545707448441,0.019759768853201316,1.2323272557074672e-11]	f	t	\N	0.1537039353466472	0.3359292292556803
8589934594	1	4	SHORTER_FOR_LONGER	69.99346985689263	0.09986530629742435	0.1	0.10080511614961361	1.1385457471480676	[1.1135670759273655,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696,1.1635244183687696]	t	f	ERROR_ABOVE_LIMIT	0	1.4298842223070487
12884901888	0	10	SELF_COMPENSATION	64.12743189133924	0.2810746597909039	0.1	0.039713971776186754	0.19177804042870117	[0.48244903734559963,0.41679005400067914,0.3503270333612,0.28751096020662625,0.23036975921294392,0.17965147865527506,0.13544129720595885,0.09749530720856375,0.06542090976814621,0.03877349725775819,0.017107150913987356,7.676071880040384e-12]	f	t	\N	0.13845347271123884	0.2869920670100256
12884901888	1	11	SHORTER_FOR_LONGER	69.99317857366702	0.09999021206705701	0.1	0.09777147956003494	0.05509249424319959	[0.11331511224429529,0.11331511224429529,0.11331511224429529,0.11331511224429529,0.11331511224429529,0.11331511224429529,0.11331511224429529,0.11331511224429529,0.11331511224429529,0.07230736217221251,0.03474750233032079,2.2596977642304787e-10]	t	f	COSTS_MORE	0	1.4303124090534334
\.


--
-- Data for Name: compensation_error_bins; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_error_bins (compensation_error_id, ratio, contacts, after_per_mm, before_per_mm, before_origin, target_per_mm, target_origin, error, error_low, error_high) FROM stdin;
1	0.7	10	0.008688025080602171	0.009718753917093292	MEASURED	0.008578410761729001	MEASURED	0.09612397667976795	0	0.299339186803659
1	0.8	16	0.006237209104613963	0.007304990834516944	MEASURED	0.006440410100085988	MEASURED	0.2350283638991404	0.05836987293100818	0.41168685486727263
1	0.9	14	0.004772186369560524	0.0056465009034488796	MEASURED	0.004898390795696431	MEASURED	0.16869766205280143	0.012240594011458605	0.32515473009414425
2	0.5	14	0.018496506738595687	0.017797795325059474	MEASURED	0.019118547359813724	MEASURED	0.47097456967672086	0.13148692760223518	0.8104622117512066
2	0.6	15	0.013383774015247301	0.012538015640335234	MEASURED	0.013605017947010979	MEASURED	0.2073509404613803	0	0.48670977375534497
2	0.7	12	0.010117229817983272	0.009090262050466735	MEASURED	0.009987896993299586	MEASURED	0.14408176254315933	0	0.4249076216258606
2	0.8	14	0.007685239515865297	0.006851909015417212	MEASURED	0.00751959929596223	MEASURED	0.24807942354329232	0	0.5263040853625744
2	0.9	12	0.005978388556351866	0.00530955646098725	MEASURED	0.005831825751333314	MEASURED	0.2806268867951958	0	0.5673294558443138
3	0.5	11	0.01766252901897748	0.020711674448480537	MODEL	0.01668797473459542	MEASURED	0.24220353249002016	0.1022052297851268	0.3822018351949135
3	0.6	13	0.01195784473541042	0.014712144895554133	MODEL	0.011715192175617629	MEASURED	0.0809664290592921	0	0.18317628952533768
3	0.7	15	0.008571189056115137	0.010760518348309777	MODEL	0.00847449141887449	MEASURED	0.04229943050781741	0	0.1297844476453149
3	0.8	13	0.006297682021809584	0.008274705755321804	MODEL	0.006445581481121939	MEASURED	0.08085807038838407	0	0.16870638963783133
3	0.9	13	0.0046922406280085005	0.006396821765643925	MODEL	0.004926602292315285	MEASURED	0.1594059040560658	0.08420194910557861	0.234609859006553
4	0.5	11	0.017834747225522363	0.01900166141947582	MODEL	0.016920143228116084	MEASURED	0.43939274766021624	0.18306120771903195	0.6957242876014005
4	0.55	11	0.014230821206443787	0.015567402135659188	MODEL	0.013817143600832138	MEASURED	0.23635228589388135	0.010993250188295722	0.461711321599467
4	0.8	11	0.006183897852948883	0.0073901500320986665	MODEL	0.00646072729158646	MEASURED	0.297850941849148	0.11634687065237972	0.4793550130459163
4	0.9	16	0.004852871915204019	0.005726338734211016	MODEL	0.004974876771433106	MEASURED	0.16235666244246727	0.02337972444010708	0.3013336004448275
5	0.45	11	0.020754521363649928	0.022292172726256124	MEASURED	0.019987997449178015	MEASURED	0.3326673635019341	0.0488864179133488	0.6164483090905194
5	0.5	16	0.017171472521172522	0.018330179477238216	MEASURED	0.016765095861270198	MEASURED	0.25965172451886936	0	0.5382397343521789
5	0.55	14	0.014475418927395234	0.015562659515328052	MEASURED	0.013690307758087621	MEASURED	0.41931820037104045	0.22409046426188184	0.6145459364801991
5	0.6	22	0.011730289378560558	0.013289022630053314	MEASURED	0.011712804563660074	MEASURED	0.011092890808245326	0	0.18302931399191377
5	0.65	12	0.010090440912121102	0.011080993627205356	MEASURED	0.009899499915815707	MEASURED	0.161609828697957	0	0.37404033335782993
5	0.7	19	0.00864515487928431	0.009718753917093292	MEASURED	0.008578410761729001	MEASURED	0.05852985326507954	0	0.22209430126978608
5	0.75	17	0.007303621089819451	0.008369740543566801	MEASURED	0.007297811316766285	MEASURED	0.005419922237317307	0	0.15848538138616777
5	0.8	24	0.006263229222953543	0.007304990834516944	MEASURED	0.006440410100085988	MEASURED	0.20493271487139988	0.04597912497093873	0.363886304771861
5	0.85	11	0.005434400195421828	0.0063631199731252934	MEASURED	0.0056083313740101825	MEASURED	0.23043694458589561	0.03344159209245523	0.427432297079336
5	0.9	23	0.004765482033789213	0.0056465009034488796	MEASURED	0.004898390795696431	MEASURED	0.17765935860232746	0.03705835954006356	0.3182603576645914
5	0.95	19	0.004136688944880531	0.0049692859307794626	MEASURED	0.004280422510568555	MEASURED	0.20865321262670292	0.07668410898925596	0.34062231626414985
5	1	12	0.0037322276390154402	0.004424956743294398	MEASURED	0.003871978727819715	MEASURED	0.2527244933676263	0.043771550680877264	0.4616774360543754
6	0.5	19	0.018458096318761656	0.017797795325059474	MEASURED	0.019118547359813724	MEASURED	0.5000568037549581	0.19987493269282403	0.8002386748170922
6	0.55	16	0.015472766493976534	0.014791665074141461	MEASURED	0.01586708197890218	MEASURED	0.36666290364236126	0.048129863865125244	0.6851959434195973
6	0.6	28	0.013374559758383503	0.012538015640335234	MEASURED	0.013605017947010979	MEASURED	0.21598658895637293	0	0.4427443926176098
6	0.7	17	0.010045074309284892	0.009090262050466735	MEASURED	0.009987896993299586	MEASURED	0.06369773864290496	0	0.3082345619440391
6	0.75	13	0.008608282843529338	0.007926367785695224	MEASURED	0.008605070905543149	MEASURED	0.004732463859764841	0	0.28264811532166473
6	0.8	24	0.007701628371946038	0.006851909015417212	MEASURED	0.00751959929596223	MEASURED	0.2726250198448638	0.023102430141484	0.5221476095482436
6	0.85	20	0.006808145712736355	0.006055266935779889	MEASURED	0.006712636280967207	MEASURED	0.1452903644935441	0	0.3596306023710827
6	0.9	20	0.005923046522659449	0.00530955646098725	MEASURED	0.005831825751333314	MEASURED	0.17466233035775658	0	0.41902406581022833
6	0.95	18	0.005406604058109337	0.004649582949887297	MEASURED	0.0051357012754148276	MEASURED	0.557277453797959	0.2842424220736317	0.8303124855222863
7	0.5	20	0.01787437483844769	0.020711674448480537	MODEL	0.01668797473459542	MEASURED	0.2948530427750864	0.18242073127982283	0.40728535427034995
7	0.55	16	0.015025907651341491	0.017488567136375466	MODEL	0.0140060775225935	MEASURED	0.2928451314576816	0.18439560494332635	0.40129465797203684
7	0.6	24	0.012184574708028056	0.014712144895554133	MODEL	0.011715192175617629	MEASURED	0.1566199324026614	0.07210488155266118	0.2411349832526616
7	0.65	16	0.01031563194989937	0.012632283625287977	MODEL	0.010003265993831357	MEASURED	0.11881470566439116	0.02345727945184156	0.21417213187694076
7	0.7	20	0.00863196842620608	0.010760518348309777	MODEL	0.00847449141887449	MEASURED	0.06888676826326409	0	0.14988818275544302
7	0.75	16	0.0073984148231703035	0.009431521900751498	MODEL	0.0073873149257337335	MEASURED	0.00542992836450603	0	0.08727309490587001
7	0.8	22	0.006374936643544355	0.008274705755321804	MODEL	0.006445581481121939	MEASURED	0.0386222186070362	0	0.11310955916260264
7	0.85	21	0.00554746480683523	0.007330776489917083	MODEL	0.005678384962576274	MEASURED	0.07923071110860354	0.01073761647618117	0.1477238057410259
7	0.9	18	0.004670536420342874	0.006396821765643925	MODEL	0.004926602292315285	MEASURED	0.1741684671014917	0.10481221359350018	0.24352472060948321
7	0.95	10	0.004185184939370439	0.005670682639313028	MODEL	0.004341639204505662	MEASURED	0.11771945222986631	0.03880766565089705	0.19663123880883557
7	1	11	0.0036997012543486486	0.005121182414291644	MODEL	0.00389703723831357	MEASURED	0.16120308917384174	0.07020663164180622	0.25219954670587724
\.


--
-- Data for Name: compensation_errors; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_errors (compensation_error_id, compensation_id, recorded_us, contacts, bins, error, error_low, error_high, pressure_mpa, error_with_gain, error_with_gain_low, error_with_gain_high) FROM stdin;
1	8589934592	1795899550988213	100	3	0.16767052477450542	0.12491352157638255	0.2104275279726283	0.05610445272379032	\N	\N	\N
2	8589934593	1795899551116624	100	5	0.26445599765636024	0.19146394887105472	0.33744804644166576	0.1466952802560571	\N	\N	\N
3	4294967296	1795899552130630	100	5	0.13189899226748503	0.10639210609500746	0.1574058784399626	0.0239163422454471	\N	\N	\N
4	8589934594	1795899553531107	100	4	0.17835699773765168	0.125517731233255	0.23119626424204837	0.056097985000166134	\N	\N	\N
5	8589934592	1795899557677780	200	12	0.16848973353578833	0.12675361290364012	0.21022585416793654	0.05610445272379032	0.17274739911821171	0.11389665032771407	0.23159814790870936
6	8589934593	1795899557880037	200	9	0.2694167598479231	0.20330589555432876	0.3355276241415175	0.1466952802560571	0.24919557028409847	0.15290942059721213	0.3454817199709848
7	4294967296	1795899558748626	200	11	0.14657674605103266	0.12094716502302538	0.17220632707903993	0.0239163422454471	0.11980347470013109	0.08099418485483977	0.1586127645454224
\.


--
-- Data for Name: compensation_refinements; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_refinements (compensation_refinement_id, compensation_id, recorded_us, contacts, outcome, pressure_from_mpa, pressure_best_mpa, error, error_low, error_high, error_best, error_best_low, error_best_high, error_with_gain, error_with_own_gain, gain_published) FROM stdin;
1	8589934592	1795899557677780	200	HELD_MARGIN	0.05610445272379032	0.05797279095184448	0.16703460288325456	0.12660505127298444	0.20746415449352468	0.16435917988839718	0.12349741737898302	0.20522094239781136	0.1947328065780797	0.03374998685548463	t
2	8589934593	1795899557880037	200	REFINED	0.1466952802560571	0.13965569095643893	0.266459322667258	0.20034845837366366	0.3325701869608524	0.23679714531682655	0.17090903064101032	0.3026852599926428	0.24056763870548672	0.05494658524193016	t
3	4294967296	1795899558748626	200	HELD_DITHER	0.0239163422454471	0.02392245256482987	0.1445591506786508	0.11892956965064352	0.17018873170665808	0.14603049743569338	0.11925129664280787	0.1728096982285789	0.12185774319379217	0.019118119312765837	t
\.


--
-- Data for Name: compensation_responses; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensation_responses (compensation_id, t_us, ratio, deflection_mm, after_strain, before_strain, before_origin, target_strain, target_origin) FROM stdin;
8589934592	1795899546422495	0.5275	3.5124	0.05443041	0.059245603451548834	MEASURED	0.05218932850593121	MEASURED
8589934592	1795899546514254	0.6741	5.4564	0.05272947	0.05611574481725122	MEASURED	0.0500634222193681	MEASURED
8589934592	1795899546558583	0.9553	3.2574	0.01314983	0.015978115038909224	MEASURED	0.013758491434410497	MEASURED
8589934592	1795899546646398	0.7589	3.0686	0.02130983	0.025043888046628188	MEASURED	0.021825269513302416	MEASURED
8589934592	1795899546678246	0.8359	4.3397	0.02425473	0.02866020738627318	MEASURED	0.025281819507688395	MEASURED
8589934593	1795899546687004	0.5977	1.188	0.01599123	0.015010348123180054	MEASURED	0.016286099859021953	MEASURED
8589934592	1795899546748985	0.7535	1.4054	0.0102468	0.011646497575532811	MEASURED	0.010152860739711958	MEASURED
8589934593	1795899546800836	0.8823	5.7231	0.03437089	0.03180631904650012	MEASURED	0.03490681257044145	MEASURED
8589934592	1795899546870721	0.4544	0.4744	0.00958609	0.010388585282023431	MEASURED	0.0093119140127465	MEASURED
8589934593	1795899546873150	0.7929	1.918	0.01524808	0.013402357387252244	MEASURED	0.014703815604037317	MEASURED
8589934593	1795899546896643	0.653	4.2018	0.04388357	0.04442287004774971	MEASURED	0.04826691324238957	MEASURED
8589934594	1795899546899156	0.466	5.3456	0.10740786	0.11338218801508451	MODEL	0.09884214433783425	MEASURED
8589934592	1795899546907527	0.5000181613474053	1.0134	0.01652119	0.018574531000730053	MEASURED	0.01698856417528567	MEASURED
8589934593	1795899546907527	0.5000111140059843	1.0119	0.01822133	0.018008827382928035	MEASURED	0.019345250355951072	MEASURED
8589934592	1795899546932413	0.8999	1.9795	0.00969012	0.011180080475554499	MEASURED	0.009698881149187955	MEASURED
8589934592	1795899546957527	0.6000655890127631	1.9886	0.02533943	0.02642080449455161	MEASURED	0.023286929784470226	MEASURED
8589934593	1795899546957527	0.6000422051264029	2.0095	0.02514828	0.025191586056475455	MEASURED	0.027335475304762272	MEASURED
8589934593	1795899546970857	0.7165	1.1179	0.01097382	0.009673733874451898	MEASURED	0.010636499726335263	MEASURED
8589934594	1795899546988808	0.831	5.6422	0.03192863	0.038343676847417775	MODEL	0.03349916002932448	MEASURED
8589934592	1795899546989947	0.7691	5.4899	0.03737162	0.043539127403359044	MEASURED	0.03792115852679228	MEASURED
8589934592	1795899547007527	0.6999148210840214	3.0027	0.0250563	0.029189909340440225	MEASURED	0.025765057243829548	MEASURED
8589934593	1795899547007527	0.700155385779762	3.0178	0.03056594	0.027419775469133628	MEASURED	0.03012759303214417	MEASURED
8589934594	1795899547022117	0.4644	0.6816	0.01352299	0.014547296921866048	MODEL	0.012684751861583356	MEASURED
8589934592	1795899547027567	0.9753	2.848	0.01155653	0.013372219301680408	MEASURED	0.011720161458482243	MEASURED
8589934593	1795899547049206	0.9176	2.7824	0.0158513	0.014125100434266846	MEASURED	0.015527052661395346	MEASURED
8589934592	1795899547057527	0.7999422545315501	0.9965	0.00620393	0.007280569572989265	MEASURED	0.006418900899911137	MEASURED
8589934593	1795899547057527	0.8001152900807754	0.9868	0.00772678	0.006759316177635824	MEASURED	0.007418020950020632	MEASURED
8589934593	1795899547077047	0.9941	3.4754	0.01683528	0.014635492428766621	MODEL	0.016691376413981905	MEASURED
8589934592	1795899547089461	0.7605	2.5678	0.01904583	0.020862341962407237	MEASURED	0.018179453199320104	MEASURED
8589934592	1795899547107527	0.8999959501227466	2.0365	0.00969984	0.011499217064251816	MEASURED	0.009975677691886514	MEASURED
8589934593	1795899547107527	0.9000494460478828	1.9697	0.0124505	0.010456907656092997	MEASURED	0.011485517030297291	MEASURED
8589934594	1795899547132599	0.9921	1.8951	0.00745426	0.008692795553754372	MODEL	0.00752718678914182	MEASURED
8589934592	1795899547157527	1	2.9526	0.01067009	0.013065127280251039	MEASURED	0.01143240439176049	MEASURED
8589934593	1795899547157527	0.9998323632999011	3.0369	0.01507725	0.012615709022876058	MODEL	0.014388379001080198	MEASURED
8589934593	1795899547159411	0.6806	5.0093	0.05384563	0.04829881897551208	MEASURED	0.053024082397130974	MEASURED
8589934594	1795899547199856	0.9389	1.7227	0.00793285	0.008955846742923993	MODEL	0.007769796602524729	MEASURED
8589934592	1795899547201622	0.7166	2.3539	0.0198867	0.021781644381028357	MEASURED	0.019207673415090783	MEASURED
8589934592	1795899547207527	0.5000996945587751	1.0019	0.0171339	0.01835810024051881	MEASURED	0.016790525408512034	MEASURED
8589934593	1795899547207527	0.49983845369967167	0.9891	0.01875227	0.0176146264692611	MEASURED	0.01892163626792516	MEASURED
8589934592	1795899547208722	0.7773	1.759	0.01211638	0.013677782552090977	MEASURED	0.012074910215435107	MEASURED
8589934594	1795899547211790	0.5009	3.8802	0.07041801	0.0721127302719667	MODEL	0.06542733573456092	MEASURED
8589934593	1795899547257380	0.6694	4.0803	0.04333009	0.040981928829745266	MEASURED	0.04455963068777727	MEASURED
8589934592	1795899547257527	0.6001261765629267	2.0631	0.02316777	0.02740511637448639	MEASURED	0.024154403329586877	MEASURED
8589934593	1795899547257527	0.5997757902993209	2.0296	0.02558104	0.02546624980133227	MEASURED	0.027633189901336404	MEASURED
8589934592	1795899547299054	0.9268	4.2188	0.01987221	0.02220166932687515	MEASURED	0.019152110851517464	MEASURED
8589934592	1795899547307527	0.7002536866554622	2.9881	0.02704703	0.029018670550460052	MEASURED	0.02561341400831394	MEASURED
8589934593	1795899547307527	0.6998093567981029	2.9779	0.03002792	0.027085419741359217	MEASURED	0.02975977721710858	MEASURED
8589934594	1795899547311813	0.7355	5.8893	0.04690856	0.05173655652251625	MODEL	0.04549988480632909	MEASURED
8589934593	1795899547337004	0.7525	1.8256	0.01564735	0.014366931491264591	MEASURED	0.015598792256416067	MEASURED
8589934592	1795899547352881	0.8853	4.1212	0.02144378	0.02415772670973083	MEASURED	0.020975974081304274	MEASURED
8589934594	1795899547354483	0.8405	3.8803	0.02285479	0.025733258622880784	MODEL	0.02245255648847858	MEASURED
8589934592	1795899547357527	0.8001911925873464	1.0137	0.00630717	0.007401210365635741	MEASURED	0.00652516858745772	MEASURED
8589934593	1795899547357527	0.7997466668049107	0.9891	0.00778247	0.006781956426469732	MEASURED	0.00744274792512665	MEASURED
8589934593	1795899547391383	0.4977	4.7088	0.09153883	0.0845442422481268	MEASURED	0.09080793007408593	MEASURED
8589934592	1795899547407527	0.9002497962263303	2.0181	0.00974424	0.01138799549303303	MEASURED	0.00987903720834007	MEASURED
8589934593	1795899547407527	0.899691014325379	1.9999	0.01171189	0.010626998092145045	MEASURED	0.01167214748107264	MEASURED
8589934594	1795899547421203	0.6272	5.4377	0.05777604	0.0658263989065953	MODEL	0.057914117718662034	MEASURED
8589934593	1795899547425575	0.5296	1.7897	0.02827522	0.028492445121207428	MEASURED	0.030535118012059926	MEASURED
8589934592	1795899547450665	0.9858	3.4506	0.01307872	0.015796695540810427	MEASURED	0.01383559725094488	MEASURED
8589934592	1795899547483853	0.9267	3.6148	0.01527316	0.019027822318295074	MEASURED	0.01641431761176451	MEASURED
8589934592	1795899547507527	0.5000803295972377	1.0079	0.01650911	0.018469389262863792	MEASURED	0.016892332562364883	MEASURED
8589934593	1795899547507527	0.499844425832048	1.0043	0.01717093	0.017884912764908414	MEASURED	0.019211983488495062	MEASURED
8589934593	1795899547511467	0.4405	0.2794	0.00590331	0.006226051381015092	MEASURED	0.0066777645645869094	MEASURED
8589934594	1795899547517649	0.8103	0.733	0.00439302	0.005257246406210487	MODEL	0.004602322790056314	MEASURED
8589934592	1795899547543025	0.8133	4.835	0.02947558	0.03406835128119832	MEASURED	0.03001276886397642	MEASURED
8589934592	1795899547557527	0.6001240401117525	2.0018	0.02342387	0.026591028305447524	MEASURED	0.023436882872779376	MEASURED
8589934593	1795899547557527	0.5998467139287393	1.9987	0.02809378	0.02507258460742745	MEASURED	0.027206112389785566	MEASURED
8589934594	1795899547569182	0.4962	4.3968	0.08561407	0.08314793003291607	MODEL	0.0754902239732499	MEASURED
8589934593	1795899547584793	0.6285	5.8504	0.07074669	0.06688931171171929	MEASURED	0.07260051212249123	MEASURED
8589934592	1795899547607527	0.7001535857414151	2.993	0.02573541	0.029074924448822075	MEASURED	0.025663213446154198	MEASURED
8589934593	1795899547607527	0.6997463319346076	3.0116	0.03097211	0.027397131550592493	MEASURED	0.030102185538305536	MEASURED
8589934594	1795899547614322	0.8537	2.4225	0.0133909	0.015533562332411632	MODEL	0.013528485977997644	MEASURED
8589934593	1795899547616704	0.8289	3.2877	0.02470097	0.021063350539608675	MEASURED	0.023328214592866978	MEASURED
8589934592	1795899547651907	0.5446	3.5369	0.05040129	0.056105432934924045	MEASURED	0.04937148083044133	MEASURED
8589934592	1795899547657527	0.8001489680289265	1.0088	0.00607476	0.007366282439753837	MEASURED	0.006494390940108968	MEASURED
8589934593	1795899547657527	0.7996974981157619	0.9936	0.00781321	0.0068137348829565075	MEASURED	0.007477606650106629	MEASURED
8589934592	1795899547679354	0.9071	2.147	0.01001979	0.01190744436570677	MEASURED	0.01032528153657676	MEASURED
8589934592	1795899547707527	0.9002508667096791	1.974	0.00926182	0.011139112111541383	MEASURED	0.009663131304883806	MEASURED
8589934593	1795899547707527	0.89960768751873	2.0414	0.01173047	0.01084983753683272	MEASURED	0.011916857480591458	MEASURED
8589934594	1795899547729023	0.9107	4.4926	0.02248932	0.02500123626545853	MODEL	0.02174012706378563	MEASURED
8589934593	1795899547729346	0.4873	2.8698	0.0550709	0.053629058453966746	MEASURED	0.05757263957433394	MEASURED
8589934593	1795899547745100	0.4549	1.1342	0.02421062	0.023819785115899213	MEASURED	0.025568087571352767	MEASURED
8589934594	1795899547750199	0.7222	1.933	0.01554392	0.017630245182057396	MODEL	0.015431048373650709	MEASURED
8589934592	1795899547772483	0.807	3.2616	0.02002859	0.023376793226292995	MEASURED	0.020601585720975996	MEASURED
4294967296	1795899547420913	0.6009	4.9417	0.06086773	0.07255485757986051	MODEL	0.057717537093425815	MEASURED
4294967296	1795899547492233	0.5486	0.5289	0.00809581	0.009235095012300694	MODEL	0.007445136014063573	MEASURED
4294967296	1795899547558013	0.8907	1.1731	0.00570332	0.007701220054462089	MODEL	0.00592099455237027	MEASURED
8589934592	1795899547807527	0.5001696128821835	0.9956	0.0173918	0.01823785235758102	MEASURED	0.016680470617555773	MEASURED
8589934593	1795899547807527	0.49984206933540865	1.0079	0.0187438	0.017949183780165995	MEASURED	0.01928102122717831	MEASURED
8589934594	1795899547813415	0.4907	3.2312	0.05689033	0.06237173941511108	MODEL	0.05667220609198945	MEASURED
8589934592	1795899547837556	0.4684	1.7782	0.03507302	0.036822051033425424	MEASURED	0.03297402496721943	MEASURED
8589934592	1795899547857527	0.6001943127799385	2.0001	0.02401059	0.026562257947576412	MEASURED	0.0234114293189069	MEASURED
8589934593	1795899547857527	0.5998040119557155	2.022	0.0273353	0.025368494025559213	MEASURED	0.027527150209942623	MEASURED
8589934593	1795899547861628	0.5856	0.6622	0.00925966	0.008715940791107034	MEASURED	0.009451661748517014	MEASURED
8589934594	1795899547882738	0.8371	2.428	0.01329182	0.016243084393314094	MODEL	0.01417892638091071	MEASURED
8589934592	1795899547893142	0.52	2.6188	0.04205812	0.044560558385213576	MEASURED	0.040704391400861524	MEASURED
8589934593	1795899547900287	0.762	2.4788	0.02094755	0.01898545918630512	MEASURED	0.02062176373491171	MEASURED
8589934592	1795899547907527	0.7002161134683501	2.982	0.02483081	0.028962672131284544	MEASURED	0.02556404171882352	MEASURED
8589934593	1795899547907527	0.6997589814857694	3.0278	0.03027817	0.027543457975886258	MEASURED	0.030262975889696127	MEASURED
8589934592	1795899547950791	0.4501	3.55	0.07268749	0.07910505566864978	MEASURED	0.07092805608658613	MEASURED
8589934592	1795899547957527	0.8002652434663861	1.0218	0.00629572	0.007458844150243083	MEASURED	0.006575952073268931	MEASURED
8589934593	1795899547957527	0.7997152618569964	0.9812	0.00761386	0.006728370911365363	MEASURED	0.007383931264077488	MEASURED
8589934593	1795899547977538	0.8479	5.948	0.03860535	0.036218122020826894	MEASURED	0.040146268976053015	MEASURED
8589934594	1795899547986360	0.6928	1.049	0.00869568	0.010412868253196053	MODEL	0.009150369395754369	MEASURED
8589934592	1795899548007527	0.9003420536269644	1.9681	0.00898789	0.011103254279989292	MEASURED	0.009631970591570439	MEASURED
8589934593	1795899548007527	0.8996049779445658	2.0069	0.01209249	0.010666547593867547	MEASURED	0.01171554056158553	MEASURED
8589934592	1795899548023528	0.734	2.9093	0.02241118	0.025492131114526966	MEASURED	0.022247750081386703	MEASURED
8589934592	1795899548057527	1	2.9652	0.01103156	0.013120881735216548	MEASURED	0.011481191323731018	MEASURED
8589934593	1795899548057527	0.9995538691691294	3.0698	0.01438978	0.012760817783186463	MODEL	0.014553851929341464	MEASURED
8589934594	1795899548064063	0.5804	1.1256	0.01430527	0.015844719325545018	MODEL	0.014177204351630572	MEASURED
8589934593	1795899548070444	0.5381	3.4952	0.05795103	0.053952559363334325	MEASURED	0.057843422110541165	MEASURED
8589934592	1795899548102627	0.4973	3.7701	0.06320442	0.06981561390793108	MEASURED	0.06386562760452945	MEASURED
8589934594	1795899548105946	0.737	2.6568	0.0214031	0.023241703844999552	MODEL	0.020435829305018725	MEASURED
8589934592	1795899548107527	0.5002508779251262	1.0067	0.01766703	0.018435535100249888	MEASURED	0.016861184893465917	MEASURED
8589934593	1795899548107527	0.4998240545222514	1.0009	0.01953015	0.017825746642242173	MEASURED	0.019148408124288214	MEASURED
8589934593	1795899548112272	0.8748	5.0788	0.03252408	0.028811571054658442	MEASURED	0.03197488257363777	MEASURED
8589934593	1795899548154321	0.9672	0.2074	0.00112955	0.0009241615326196582	MEASURED	0.0010216175625800388	MEASURED
8589934592	1795899548157527	0.6002786613399675	1.9988	0.02323454	0.026537572896046444	MEASURED	0.023389557487399917	MEASURED
8589934593	1795899548157527	0.5997716215435772	2.0104	0.02642361	0.02522569110497778	MEASURED	0.027372156884104357	MEASURED
8589934594	1795899548175073	0.6142	1.8245	0.0215866	0.023012528833698167	MODEL	0.02049563453150232	MEASURED
8589934592	1795899548177980	0.4531	5.4667	0.10774367	0.1203423525623275	MEASURED	0.10787991324244824	MEASURED
8589934592	1795899548207527	0.7003134769193687	3.0457	0.02767761	0.02957278100712541	MEASURED	0.026102412048136302	MEASURED
8589934593	1795899548207527	0.6997467320517438	2.9876	0.03040846	0.027178766001198985	MEASURED	0.029862260192463554	MEASURED
8589934594	1795899548209124	0.5184	1.1677	0.01902586	0.020360844303771775	MODEL	0.018427405130813486	MEASURED
8589934593	1795899548242135	0.6077	4.07	0.05042824	0.0497379608204247	MEASURED	0.05398897949962975	MEASURED
8589934592	1795899548252997	0.7087	3.8729	0.03315838	0.036680670031787564	MEASURED	0.032360675661893705	MEASURED
8589934592	1795899548257527	0.8002830518445311	1.0074	0.00658481	0.007353371351790502	MEASURED	0.006482957174128067	MEASURED
8589934593	1795899548257527	0.7996314852395412	1.008	0.00779932	0.00691374253323292	MEASURED	0.007587336354914326	MEASURED
8589934593	1795899548282630	0.5444	2.4871	0.03710129	0.037531092692781445	MEASURED	0.04024941370515454	MEASURED
8589934592	1795899548307527	0.9002558237477558	1.993	0.0097673	0.011246186275898391	MEASURED	0.009756014692464699	MEASURED
8589934593	1795899548307527	0.8995055205682647	2.0131	0.01216319	0.010702229644017108	MEASURED	0.011754678319112801	MEASURED
8589934594	1795899548317663	0.6996	0.2125	0.00176082	0.002068017651992923	MODEL	0.0018156085846725055	MEASURED
8589934592	1795899548323037	0.5428	3.7977	0.05765552	0.060629206740116376	MEASURED	0.05335812573572537	MEASURED
8589934593	1795899548345601	0.6468	1.6521	0.01827458	0.01781259460732605	MEASURED	0.01934879918882366	MEASURED
4294967296	1795899547653219	0.6076	0.4576	0.00483186	0.00657624595789466	MODEL	0.005225749491559726	MEASURED
4294967296	1795899547690907	0.977	2.1247	0.00814439	0.011363860550367793	MODEL	0.00876315657492543	MEASURED
4294967296	1795899547781862	0.5176	0.9128	0.01484	0.017763898978639458	MODEL	0.014249783181132814	MEASURED
4294967296	1795899547814241	0.6791	4.052	0.03819249	0.04679862117853483	MODEL	0.036612042966762064	MEASURED
4294967296	1795899547874546	0.6097	5.2403	0.05949266	0.07480817130615271	MODEL	0.05942542250669922	MEASURED
4294967296	1795899547907527	0.4999172398440693	1.0262	0.01723257	0.021289882702270575	MODEL	0.017130639412034618	MEASURED
4294967296	1795899547957527	0.6003563985304003	1.9926	0.02470602	0.029306766488388	MODEL	0.023315645918471146	MEASURED
4294967296	1795899547982773	0.8577	1.2409	0.00649186	0.00883961269184456	MODEL	0.006902593078729647	MEASURED
4294967296	1795899548007527	0.7000840561010648	3.0018	0.02345249	0.03261684268477705	MODEL	0.025432236718988723	MEASURED
4294967296	1795899548019682	0.5053	0.3588	0.00615819	0.007299012035369167	MODEL	0.005867547147569696	MEASURED
4294967296	1795899548057527	0.801556681531701	0.993	0.00634794	0.008167949010408602	MODEL	0.006372790951869425	MEASURED
4294967296	1795899548079477	0.572	5.087	0.06913811	0.08207980917129139	MODEL	0.06591509858080659	MEASURED
4294967296	1795899548107527	0.9016259692360561	2.022	0.00928077	0.012925516049087605	MODEL	0.009919668889178893	MEASURED
4294967296	1795899548157527	1	2.9566	0.01135289	0.015001009228401696	MODEL	0.0115219802987979	MEASURED
4294967296	1795899548181526	0.963	3.5464	0.01418374	0.019593589124978602	MODEL	0.014903141162760938	MEASURED
4294967296	1795899548207527	0.5007764065582853	0.9924	0.01716122	0.020524007582719467	MODEL	0.01651190588572183	MEASURED
4294967296	1795899548214749	0.7939	4.8985	0.03127372	0.04111216721414671	MODEL	0.0321159598707919	MEASURED
4294967296	1795899548257527	0.6009964057986016	2.0075	0.02173041	0.029465333037732286	MODEL	0.023439366417517035	MEASURED
4294967296	1795899548281521	0.638	3.6342	0.03800991	0.04749127087386748	MODEL	0.037782763507080215	MEASURED
4294967296	1795899548307527	0.7019814456240935	3.025	0.0254448	0.03269014226225114	MODEL	0.025481709129039035	MEASURED
8589934592	1795899548347125	0.463	4.5325	0.08919545	0.09588941979344037	MEASURED	0.0859002841700937	MEASURED
8589934594	1795899548362565	0.9872	3.929	0.01489467	0.018228254419351036	MODEL	0.015795238904086673	MEASURED
8589934592	1795899548407527	0.5001311976469774	0.9962	0.01663801	0.018251488214441024	MEASURED	0.0166929831541538	MEASURED
8589934593	1795899548407527	0.49969118377051086	1.027	0.01686798	0.018299834551727498	MEASURED	0.01965754533549445	MEASURED
8589934592	1795899548420454	0.914	4.51	0.01945922	0.024582412620833292	MEASURED	0.021306968612692226	MEASURED
8589934593	1795899548439311	0.6853	5.659	0.06109475	0.05378439750477126	MEASURED	0.05905823418686071	MEASURED
8589934594	1795899548450931	0.9233	2.4072	0.01047416	0.012992640796223294	MODEL	0.011277852785592003	MEASURED
8589934592	1795899548457527	0.6000954638676465	1.9716	0.02164396	0.02619234598098447	MEASURED	0.023085529445198053	MEASURED
8589934593	1795899548457527	0.5997258380945074	1.9801	0.02783901	0.02484930501425446	MEASURED	0.026963689596994585	MEASURED
8589934593	1795899548476056	0.809	3.3283	0.02560775	0.02224854047071595	MEASURED	0.02442616541540614	MEASURED
8589934592	1795899548489279	0.8982	1.5593	0.00761638	0.008844852499903124	MEASURED	0.0076738415254720355	MEASURED
8589934592	1795899548507527	0.700201831847674	3.013	0.02568915	0.029265004518918013	MEASURED	0.02583091793044639	MEASURED
8589934593	1795899548507527	0.6996514622238112	3.0062	0.03124594	0.027355813859892046	MEASURED	0.030056666217893834	MEASURED
8589934594	1795899548525151	0.894	4.6442	0.02377882	0.026924607043560193	MODEL	0.02346756666471174	MEASURED
8589934593	1795899548542699	0.5155	1.4301	0.02440256	0.024010005455430423	MEASURED	0.02581107712980422	MEASURED
8589934592	1795899548557471	0.9528	3.1524	0.01308547	0.015557997181829653	MEASURED	0.013398881757568261	MEASURED
8589934592	1795899548557527	0.800212493978221	1.0156	0.00623459	0.007414652044985923	MEASURED	0.006537011098676839	MEASURED
8589934593	1795899548557527	0.7995169115048363	1.002	0.0078752	0.006874760196798621	MEASURED	0.007544518361508984	MEASURED
8589934594	1795899548585464	0.5502	4.6876	0.06139469	0.07307732588018764	MODEL	0.06472280720559714	MEASURED
8589934592	1795899548607527	0.9002743908089319	2.0195	0.0099822	0.011395185725849877	MEASURED	0.00988525970166096	MEASURED
8589934593	1795899548607527	0.8994161676676031	2.005	0.01179391	0.010661610684160518	MEASURED	0.011710017120195005	MEASURED
8589934592	1795899548626458	0.783	0.9404	0.00602261	0.007197838557717146	MEASURED	0.006352234684100144	MEASURED
8589934594	1795899548642822	0.9004	2.7087	0.01258223	0.015458358810771127	MODEL	0.013461470473006361	MEASURED
8589934593	1795899548657527	0.9994057732026069	3.0317	0.0140703	0.01260687424491665	MODEL	0.014378264272270878	MEASURED
8589934593	1795899548659065	0.484	5.9326	0.11818377	0.11229534879511281	MEASURED	0.12053296464293467	MEASURED
8589934593	1795899548683501	0.4968	4.594	0.08629175	0.08276717097807261	MEASURED	0.08889526887566909	MEASURED
8589934594	1795899548701658	0.8193	4.7902	0.02777317	0.03355694914744474	MODEL	0.029340288530497485	MEASURED
8589934592	1795899548711142	0.9901	2.5504	0.00950676	0.011555726985810274	MEASURED	0.010118263307078325	MEASURED
8589934594	1795899548775826	0.8348	0.3018	0.00171377	0.002030994634841305	MODEL	0.0017734601017000645	MEASURED
8589934593	1795899548777695	0.9475	2.3903	0.01259666	0.011183226905567657	MEASURED	0.01235098776814567	MEASURED
4294967296	1795899548357527	0.8022675226964516	0.9934	0.00649902	0.008156034388452891	MODEL	0.006362768038331132	MEASURED
4294967296	1795899548379992	0.715	4.1505	0.03405817	0.04321745701314716	MODEL	0.033618076492787106	MEASURED
4294967296	1795899548407527	0.9020969985816348	2.0439	0.00953745	0.013050589487183902	MODEL	0.010014873248974028	MEASURED
4294967296	1795899548417525	0.8698	2.1774	0.01163682	0.015049681465320925	MODEL	0.01172860989247657	MEASURED
4294967296	1795899548503361	0.8823	4.0675	0.01913595	0.027258354023107372	MODEL	0.0209863363577086	MEASURED
4294967296	1795899548507527	0.5011202610324413	0.9863	0.01841248	0.020372216201366884	MODEL	0.01638880216464702	MEASURED
4294967296	1795899548557527	0.6011025831545243	1.9982	0.02420296	0.029318843928137144	MODEL	0.02332243470215013	MEASURED
4294967296	1795899548586974	0.8692	1.0485	0.00598778	0.007257794567191649	MODEL	0.005656745307506079	MEASURED
4294967296	1795899548607527	0.701674585455757	3.0091	0.02686155	0.032546990462457036	MODEL	0.025371360084913756	MEASURED
4294967296	1795899548657527	0.8014118362685553	0.9931	0.00642822	0.00817187344442162	MODEL	0.006376001270746183	MEASURED
4294967296	1795899548667516	0.9585	4.8576	0.02090985	0.027121012789528415	MODEL	0.020644432717881196	MEASURED
4294967296	1795899548707527	0.9017080423419437	1.976	0.00904563	0.012628948724941315	MODEL	0.009691936688940235	MEASURED
8589934592	1795899548780615	0.5764	1.4839	0.01913211	0.02134822751627404	MEASURED	0.01884216330580476	MEASURED
8589934592	1795899548818005	0.4859	4.4397	0.08355002	0.08587383728686104	MEASURED	0.07861348956317105	MEASURED
8589934594	1795899548851128	0.5238	2.3867	0.03869471	0.040818225032739214	MODEL	0.03691407313845465	MEASURED
8589934593	1795899548868224	0.7202	4.0484	0.0371779	0.03465169592339315	MEASURED	0.03810640246109434	MEASURED
8589934594	1795899548889960	0.7941	2.3112	0.01491975	0.017301701873173224	MODEL	0.015179993463149107	MEASURED
8589934592	1795899548894924	0.8117	2.1212	0.01354002	0.015011083117304178	MEASURED	0.013225370511996742	MEASURED
8589934593	1795899548896987	0.8034	4.2935	0.03192978	0.029144700546502905	MEASURED	0.03198947518040188	MEASURED
8589934593	1795899548964700	0.7777	1.3005	0.01030155	0.009480922093105193	MEASURED	0.010394724985625192	MEASURED
8589934592	1795899548984210	0.9211	1.1393	0.00519356	0.00610048226760614	MEASURED	0.005285290252903104	MEASURED
8589934594	1795899548997459	0.5827	1.1339	0.01526152	0.015840470131692593	MODEL	0.014168923946948013	MEASURED
8589934593	1795899549026627	0.5136	2.3369	0.04223741	0.03951325699111003	MEASURED	0.042473421534670784	MEASURED
8589934594	1795899549045079	0.4631	1.8665	0.03538711	0.04003897268644867	MODEL	0.034919328402294045	MEASURED
8589934592	1795899549065849	0.9797	0.4237	0.00170567	0.001968375080814786	MEASURED	0.001724698600050256	MEASURED
8589934594	1795899549076490	0.5531	3.6369	0.05605199	0.056134641673287994	MODEL	0.04969707072482479	MEASURED
8589934593	1795899549090433	0.5487	2.7446	0.04326967	0.040785493966872186	MEASURED	0.043748167566531763	MEASURED
8589934592	1795899549108709	0.5491	3.196	0.05229827	0.049896445511589824	MEASURED	0.043895762148583616	MEASURED
8589934592	1795899549145083	0.9316	1.1443	0.0047028	0.005950518314085313	MEASURED	0.005131621508994712	MEASURED
8589934593	1795899549158738	0.8596	5.5361	0.03702469	0.03268233033740217	MEASURED	0.03624589104658063	MEASURED
8589934594	1795899549170334	0.7285	5.1474	0.03828955	0.046118084687420555	MODEL	0.040597265059606306	MEASURED
8589934594	1795899549220218	0.4643	3.7223	0.07461513	0.07947551253986558	MODEL	0.06930098581486305	MEASURED
8589934593	1795899549223249	0.4445	4.3401	0.09048712	0.0951213319910283	MEASURED	0.10204522001515312	MEASURED
8589934592	1795899549228204	0.9365	1.5436	0.00660198	0.00793005111772596	MEASURED	0.006836619546880842	MEASURED
8589934592	1795899549286610	0.5373	2.6575	0.03956776	0.04326801485264095	MEASURED	0.03809177009522322	MEASURED
8589934594	1795899549297071	0.6827	3.0797	0.03035989	0.03149097437554806	MODEL	0.027710785316268555	MEASURED
4294967296	1795899548736095	0.7379	3.7146	0.02945267	0.036273044929259216	MODEL	0.028426797562966517	MEASURED
4294967296	1795899548753499	0.7276	1.8826	0.01430068	0.018918963059357953	MODEL	0.014850889851686503	MEASURED
4294967296	1795899548807527	0.5012232154433377	1.0158	0.01688851	0.0209736479807939	MODEL	0.01687233142395874	MEASURED
4294967296	1795899548852680	0.6411	5.6966	0.06099627	0.07373781735067463	MODEL	0.058634709813582736	MEASURED
4294967296	1795899548869158	0.6017748731932424	1.9878	0.02242512	0.029103448877598925	MODEL	0.02314857235984746	MEASURED
4294967296	1795899548878218	0.6191	5.1302	0.05899964	0.0710947093214223	MODEL	0.05639005714107091	MEASURED
4294967296	1795899548907527	0.7025143510053167	3.0446	0.02491564	0.032851650622581545	MODEL	0.025605436049688197	MEASURED
4294967296	1795899548957527	0.8030871381095027	1.0097	0.00658612	0.008272088937066232	MODEL	0.006452455587208362	MEASURED
4294967296	1795899548975434	0.5723	2.4938	0.03265377	0.040197883952908034	MODEL	0.03227976389173099	MEASURED
4294967296	1795899549007527	0.9031136134083142	1.9962	0.00956533	0.012714639150202593	MODEL	0.009755421914311797	MEASURED
4294967296	1795899549008747	0.9807	4.8512	0.01943454	0.025725980225727075	MODEL	0.01982576976400887	MEASURED
4294967296	1795899549105156	0.8125	3.9779	0.02425976	0.031799339727907	MODEL	0.024766809114522323	MEASURED
4294967296	1795899549107527	0.5017104968529853	1.0026	0.01689568	0.0206642695052167	MODEL	0.01662203583064903	MEASURED
4294967296	1795899549157527	0.602196095227659	2.0051	0.02476999	0.029317144687164235	MODEL	0.02331695324543341	MEASURED
4294967296	1795899549203396	0.534	2.1776	0.03366651	0.03999267775727924	MODEL	0.03232037034935268	MEASURED
8589934593	1795899549317567	0.6148	5.7059	0.07696186	0.06811413838775936	MEASURED	0.07395870088889614	MEASURED
8589934594	1795899549343892	0.6806	2.539	0.02232302	0.02612376598781788	MODEL	0.022994402533671656	MEASURED
8589934593	1795899549347954	0.8119	5.5929	0.04068789	0.03709146178334913	MEASURED	0.040727037899349165	MEASURED
8589934592	1795899549377751	0.6877	0.3428	0.00297729	0.003456706086922382	MEASURED	0.003053260304149767	MEASURED
8589934592	1795899549414480	0.9253	2.8048	0.01298694	0.014815664257237258	MEASURED	0.012781830439255648	MEASURED
8589934594	1795899549427312	0.9304	3.6549	0.01708244	0.019392198360983808	MODEL	0.016844322987720296	MEASURED
8589934593	1795899549450651	0.9922	3.9508	0.01964828	0.01671299571379272	MODEL	0.019060493081741396	MEASURED
8589934594	1795899549487832	0.5303	3.79	0.05953558	0.06333701074840054	MODEL	0.0562520486298679	MEASURED
8589934593	1795899549505477	0.9387	5.9227	0.03340437	0.02832519871987452	MEASURED	0.031270008164433725	MEASURED
8589934592	1795899549516558	0.711	2.373	0.01977911	0.02232291320182581	MEASURED	0.019691286007847867	MEASURED
8589934593	1795899549541506	0.5909	0.6889	0.00967797	0.008905836820471925	MEASURED	0.009659856270325572	MEASURED
8589934592	1795899549574620	0.7979	4.1155	0.02677018	0.03023646382312986	MEASURED	0.026661107576057202	MEASURED
8589934594	1795899549597401	0.9484	3.7275	0.01569992	0.018944150613800687	MODEL	0.016413123441491942	MEASURED
8589934592	1795899549621772	0.8037	1.3249	0.00792503	0.009581381343153877	MEASURED	0.008445548893598094	MEASURED
8589934594	1795899549641877	0.7946	5.0133	0.03212752	0.037479799277175964	MODEL	0.03288140028836983	MEASURED
8589934593	1795899549651903	0.8122	1.4666	0.01095912	0.009718358870929597	MEASURED	0.010671058773304407	MEASURED
8589934594	1795899549715039	0.9164	5.882	0.02734229	0.032282561712289784	MODEL	0.028049162864764658	MEASURED
8589934593	1795899549732527	0.9225	4.7505	0.02584513	0.023819067894764897	MEASURED	0.026189107686825596	MEASURED
8589934592	1795899549739808	0.9831	2.293	0.00950351	0.010565642571374026	MEASURED	0.009255599705013674	MEASURED
8589934592	1795899549761290	0.8728	4.3407	0.0216513	0.02602945536706359	MEASURED	0.022910353347838797	MEASURED
8589934594	1795899549782128	0.5586	0.8618	0.01231488	0.013053721286071135	MODEL	0.011547902202205999	MEASURED
4294967296	1795899549207527	0.7024792203374481	2.9926	0.0272536	0.032293819794665946	MODEL	0.025170788567567937	MEASURED
4294967296	1795899549235515	0.89	1.9589	0.0102202	0.012881911822842424	MODEL	0.009905255476051564	MEASURED
4294967296	1795899549257527	0.8025613756408612	0.9965	0.00661223	0.008175191920937644	MODEL	0.006377412199917864	MEASURED
4294967296	1795899549296330	0.8112	3.3017	0.01927325	0.0264831077440903	MODEL	0.02063059960529676	MEASURED
4294967296	1795899549307527	0.9022198090062776	2.0022	0.00954595	0.012780521698517506	MODEL	0.009807426355792969	MEASURED
4294967296	1795899549357429	0.5374	5.3316	0.08077893	0.09676395853979482	MODEL	0.078155656176475	MEASURED
4294967296	1795899549407527	0.5011939945841296	0.9925	0.01683994	0.020494752486453837	MODEL	0.016487166290967085	MEASURED
4294967296	1795899549457527	0.6015581494468699	1.987	0.02419214	0.029111952137848052	MODEL	0.02315614850308812	MEASURED
4294967296	1795899549457629	0.7193	2.4092	0.01959984	0.02478267991904124	MODEL	0.019264832700341954	MEASURED
4294967296	1795899549507527	0.701811302687228	2.9518	0.02587705	0.03191468671825087	MODEL	0.024877919977521267	MEASURED
4294967296	1795899549539547	0.4703	1.3061	0.02522024	0.03027337617151921	MODEL	0.024172119976989034	MEASURED
4294967296	1795899549555932	0.5798	5.218	0.07180151	0.08204889542426051	MODEL	0.06549463044548769	MEASURED
4294967296	1795899549557527	0.8019771652731985	0.9978	0.0061697	0.00819839305652361	MODEL	0.006396111772788969	MEASURED
4294967296	1795899549607527	0.9024535855294399	1.9997	0.00916464	0.012757329063450716	MODEL	0.009789248998211883	MEASURED
4294967296	1795899549631764	0.7994	4.0988	0.025509	0.033906079798992766	MODEL	0.026463343047747234	MEASURED
8589934593	1795899549801859	0.6986	0.4056	0.00410514	0.003702579427527303	MEASURED	0.004067953629528717	MEASURED
8589934593	1795899549808433	0.9109	2.8481	0.01783017	0.014706842345192553	MEASURED	0.016161541514554987	MEASURED
8589934592	1795899549817495	0.8126	5.2643	0.03140901	0.03716341616310572	MEASURED	0.03274073768248646	MEASURED
8589934594	1795899549835993	0.4859	0.2202	0.00424091	0.004327887159404715	MODEL	0.003935127046724099	MEASURED
8589934592	1795899549903104	0.6551	1.6855	0.01721372	0.018381567758166073	MEASURED	0.01641686527825889	MEASURED
8589934594	1795899549916895	0.5856	2.2148	0.02794384	0.03064582838052759	MODEL	0.027401052482206464	MEASURED
8589934593	1795899549920741	0.707	2.0874	0.0200196	0.01858098282235968	MEASURED	0.020421918551679245	MEASURED
8589934592	1795899549975135	0.5322	5.9807	0.09103907	0.0991775315487386	MEASURED	0.08733999388293574	MEASURED
8589934593	1795899549991853	0.4736	2.5211	0.05009442	0.049120038721374014	MEASURED	0.05277708213310406	MEASURED
8589934594	1795899550004124	0.5115	0.4568	0.00697283	0.008166340242178332	MODEL	0.007398093219146452	MEASURED
8589934593	1795899550024856	0.5186	2.5788	0.04706311	0.0427996933483008	MEASURED	0.04601703842382733	MEASURED
8589934592	1795899550028893	0.6165	4.0516	0.04422761	0.051002010893892884	MEASURED	0.044909603106927314	MEASURED
8589934594	1795899550062066	0.9189	4.2186	0.01892739	0.023013245506738948	MODEL	0.01998833679172227	MEASURED
8589934593	1795899550084694	0.4997	0.8741	0.01575283	0.015574828117115856	MEASURED	0.016730371031882157	MEASURED
8589934592	1795899550111263	0.5319	3.1658	0.04652973	0.05255513066271223	MEASURED	0.0462831583222614	MEASURED
8589934594	1795899550140792	0.8849	0.5145	0.00269233	0.0030506789825716376	MODEL	0.0026623667035525975	MEASURED
8589934593	1795899550151994	0.7913	2.9273	0.02288199	0.020545975326867152	MEASURED	0.022539558391348486	MEASURED
8589934592	1795899550165445	0.7862	4.9688	0.03294307	0.03769674283092601	MEASURED	0.033261927722137145	MEASURED
8589934594	1795899550170244	0.8039	4.3819	0.02791304	0.03196200506089367	MODEL	0.028004894589442015	MEASURED
8589934593	1795899550210415	0.9205	1.2075	0.00727254	0.00608512036042009	MEASURED	0.006689981057423518	MEASURED
8589934592	1795899550241212	0.8888	0.6943	0.00314249	0.004033620799722266	MEASURED	0.0035016128428823055	MEASURED
8589934594	1795899550250958	0.564	5.0056	0.06782719	0.07444189273164935	MODEL	0.06580543878793649	MEASURED
8589934592	1795899550293798	0.4656	3.7938	0.07550739	0.07943600362884305	MEASURED	0.07114822475536885	MEASURED
8589934593	1795899550317922	0.5886	0.8498	0.01175039	0.011071767308168072	MEASURED	0.012007943826901511	MEASURED
4294967296	1795899549739530	0.9397	5.0612	0.02191	0.029534018005388376	MODEL	0.022552974791298464	MEASURED
4294967296	1795899549793654	0.5346	0.5997	0.00897746	0.010990730031504282	MODEL	0.008881337635587445	MEASURED
4294967296	1795899549808181	0.7228	2.0215	0.0168255	0.020590409928625132	MODEL	0.01599707022872342	MEASURED
4294967296	1795899549901089	0.5232	3.6284	0.0628299	0.06921860137206204	MODEL	0.055472367137322884	MEASURED
4294967296	1795899550006332	0.5857	4.017	0.04713452	0.06195355112765781	MODEL	0.04940609548515625	MEASURED
4294967296	1795899550016286	0.6408	5.1173	0.05017432	0.06630015194886772	MODEL	0.05272296994495902	MEASURED
4294967296	1795899550098147	0.7227	0.6996	0.00575272	0.0071279271395895336	MODEL	0.005537906400144437	MEASURED
4294967296	1795899550159415	0.8365	0.3345	0.00200692	0.0025139262172585984	MODEL	0.0019698344317028355	MEASURED
4294967296	1795899550233556	0.7999	2.2309	0.01430122	0.018430236738852194	MODEL	0.014383453116624012	MEASURED
8589934594	1795899550334786	0.7416	2.5363	0.01910516	0.021904316662532407	MODEL	0.019247867485462294	MEASURED
8589934593	1795899550344887	0.8617	5.442	0.03730337	0.03194964871338085	MEASURED	0.03543664884971043	MEASURED
8589934592	1795899550349997	0.5816	2.0597	0.025376	0.02911272924648425	MEASURED	0.025687313497286958	MEASURED
8589934594	1795899550378475	0.9147	2.4487	0.01154993	0.013494966391584243	MODEL	0.011728103193794859	MEASURED
8589934593	1795899550435334	0.8071	5.5923	0.0409255	0.037577593132043965	MEASURED	0.04125215629054546	MEASURED
8589934594	1795899550444690	0.538	0.2433	0.00386949	0.003957166684832969	MODEL	0.003510727310791049	MEASURED
8589934592	1795899550446066	0.8263	5.6856	0.03262075	0.038520304762486635	MEASURED	0.033998992734665584	MEASURED
8589934594	1795899550507407	0.4693	5.8222	0.11844058	0.12192107355899111	MODEL	0.10623449057657532	MEASURED
8589934592	1795899550515590	0.8453	5.1887	0.02913088	0.03342666556473944	MEASURED	0.02946990404070406	MEASURED
8589934593	1795899550529928	0.4695	0.7562	0.01643995	0.014975089983216058	MEASURED	0.016086597632095676	MEASURED
8589934594	1795899550547777	0.7972	6.0204	0.03847599	0.0446990812127953	MODEL	0.03920099575657906	MEASURED
8589934593	1795899550576041	0.5988	4.0813	0.05459487	0.05137734874582685	MEASURED	0.055746686786394564	MEASURED
8589934592	1795899550590140	0.6409	3.5025	0.03640435	0.03993993470564452	MEASURED	0.035700029800135896	MEASURED
8589934592	1795899550615217	0.7443	3.1476	0.0237048	0.026776275280111336	MEASURED	0.023354642139990726	MEASURED
8589934593	1795899550637046	0.8855	5.1798	0.03190596	0.028549188218511344	MEASURED	0.03133671557326823	MEASURED
8589934594	1795899550669844	0.8464	5.5389	0.03028943	0.036182548155330826	MODEL	0.03154394978942867	MEASURED
8589934593	1795899550681110	0.6008	4.7939	0.06311075	0.05994545034655609	MEASURED	0.06504917959581838	MEASURED
8589934594	1795899550683711	0.5529	1.0634	0.01399285	0.016424589133542424	MODEL	0.014541406106745963	MEASURED
8589934592	1795899550696770	0.8573	1.6877	0.00911783	0.01053586033668985	MEASURED	0.009282036853174228	MEASURED
8589934592	1795899550748171	0.6312	2.3416	0.0261317	0.027539089269926733	MEASURED	0.024629350545916962	MEASURED
4294967296	1795899550337516	0.6306	3.1314	0.03736262	0.04186600967383955	MODEL	0.03334697202060965	MEASURED
4294967296	1795899550350410	0.7907	1.3448	0.00835482	0.011382458198552924	MODEL	0.008896300913448278	MEASURED
4294967296	1795899550413321	0.7405	3.689	0.0267752	0.03576453935202638	MODEL	0.02801669710169885	MEASURED
4294967296	1795899550530481	0.5379	5.6822	0.07803646	0.10294796209029755	MODEL	0.08314343740197132	MEASURED
4294967296	1795899550570937	0.9466	3.7305	0.01601311	0.021417443769520057	MODEL	0.016335872735622037	MEASURED
4294967296	1795899550638228	0.7108	1.936	0.01526027	0.020400750501406283	MODEL	0.015879965177624328	MEASURED
4294967296	1795899550688597	0.8196	4.8167	0.02861152	0.0378032238298645	MODEL	0.029409222202260926	MEASURED
8589934594	1795899550776247	0.495	5.7865	0.10648237	0.10991789759224006	MODEL	0.09981191669918643	MEASURED
8589934593	1795899550801364	0.445	2.4358	0.05217829	0.053274821890042665	MEASURED	0.05715427459014888	MEASURED
8589934593	1795899550813722	0.9798	5.3538	0.02693659	0.02333014583020684	MODEL	0.026605180111203035	MEASURED
8589934594	1795899550824634	0.4637	3.6393	0.07341205	0.07788536040341283	MODEL	0.06792041605327963	MEASURED
8589934592	1795899550824991	0.8114	4.1841	0.0235859	0.029633601597548628	MEASURED	0.02610886039366755	MEASURED
8589934593	1795899550881396	0.8394	1.7924	0.0128407	0.01116425496878973	MEASURED	0.012370442622995815	MEASURED
8589934592	1795899550883393	0.5519	2.6655	0.03865324	0.04120562330617075	MEASURED	0.03624400204332983	MEASURED
8589934594	1795899550931161	0.797	5.0941	0.03269016	0.0378417556535974	MODEL	0.033188044990755235	MEASURED
8589934592	1795899550941890	0.6024	1.7988	0.01987094	0.023715101688807635	MEASURED	0.020899319932395626	MEASURED
8589934594	1795899550987024	0.8778	2.8988	0.01465157	0.017494361136445886	MODEL	0.01528268566555979	MEASURED
8589934593	1795899551003354	0.5958	5.1076	0.07101489	0.06494739055321058	MEASURED	0.07046146298759912	MEASURED
8589934593	1795899551018891	0.8623	0.2174	0.00145638	0.0012743290637557381	MEASURED	0.0014134479122658527	MEASURED
8589934592	1795899551033969	0.6215	3.65	0.03738247	0.04520744785895322	MEASURED	0.03979572464508654	MEASURED
8589934594	1795899551066346	0.7825	5.2104	0.03388578	0.04023412572223101	MODEL	0.035356231671285814	MEASURED
8589934593	1795899551092973	0.6286	0.8247	0.00969998	0.009425980485277975	MEASURED	0.01023084201799932	MEASURED
8589934594	1795899551106826	0.67	1.5924	0.01536856	0.01690911214548338	MODEL	0.014790447740382365	MEASURED
8589934592	1795899551122896	0.7569	4.4545	0.03307426	0.03656064000889775	MEASURED	0.03186557488762167	MEASURED
8589934594	1795899551149968	0.8757	1.062	0.00545367	0.00644288006112417	MODEL	0.005630004356131902	MEASURED
8589934593	1795899551158367	0.4967	3.2857	0.05683748	0.05921900036259006	MEASURED	0.06360327424221211	MEASURED
8589934592	1795899551167104	0.6142	1.0193	0.01208966	0.012927551464151763	MEASURED	0.011384815514374407	MEASURED
8589934592	1795899551212030	1	2.6412	0.00944012	0.011687195750389165	MEASURED	0.010226670215917432	MEASURED
8589934594	1795899551243193	0.6327	1.9705	0.01966462	0.023447426129038246	MODEL	0.02061363553146414	MEASURED
8589934593	1795899551248543	0.5964	3.1445	0.04438184	0.03990440711017618	MEASURED	0.04329346088043092	MEASURED
8589934594	1795899551327741	0.7436	5.7573	0.04666457	0.04944578329748526	MODEL	0.04343743172353358	MEASURED
4294967296	1795899550759335	0.6234	0.9651	0.0113177	0.013195494051504822	MODEL	0.010459010419462353	MEASURED
4294967296	1795899550874132	0.7056	2.3013	0.01798236	0.024612721547470323	MODEL	0.01917439886782639	MEASURED
4294967296	1795899550883860	0.7629	0.3856	0.00284083	0.0035159399657377372	MODEL	0.0027444550640634176	MEASURED
4294967296	1795899550953259	0.6976	3.2397	0.02905763	0.03545462788603772	MODEL	0.027655845763440566	MEASURED
4294967296	1795899551050655	0.4554	4.5636	0.09186959	0.11205431688771297	MODEL	0.0897177905691665	MEASURED
4294967296	1795899551097283	0.9155	1.1349	0.00511536	0.0070157736304204835	MODEL	0.005371825170030781	MEASURED
4294967296	1795899551162608	0.73	1.2643	0.00920568	0.012620411098377353	MODEL	0.009902913213144657	MEASURED
8589934592	1795899551335921	0.6664	1.3263	0.0127107	0.013966384864673076	MEASURED	0.012465535232914689	MEASURED
8589934593	1795899551339633	0.7984	2.2294	0.01734301	0.01534318760006849	MEASURED	0.016837143884228106	MEASURED
8589934593	1795899551351869	0.8702	1.689	0.01034636	0.009697342128841154	MEASURED	0.010759815725712838	MEASURED
8589934594	1795899551354726	0.9213	4.7848	0.02205776	0.025950714276290577	MODEL	0.022532064626228837	MEASURED
8589934592	1795899551365649	0.848	5.0114	0.0278379	0.03205602179231798	MEASURED	0.028256943186869277	MEASURED
8589934592	1795899551410383	0.8968	1.5077	0.0077047	0.00858259619550064	MEASURED	0.007446948726757984	MEASURED
8589934594	1795899551420532	0.8977	0.804	0.00412993	0.004618902128801256	MODEL	0.004023762300267783	MEASURED
8589934593	1795899551458973	0.9225	0.2527	0.0014307	0.0012670410392605176	MEASURED	0.0013931138853722404	MEASURED
8589934593	1795899551479811	0.7723	1.9836	0.01701044	0.014756065660347893	MEASURED	0.016034980054951752	MEASURED
8589934594	1795899551485518	1	2.8189	0.01087957	0.012696340941547299	MODEL	0.010981309949569631	MEASURED
8589934592	1795899551493904	0.762	3.2578	0.02363565	0.02635673578199147	MEASURED	0.022965281051540585	MEASURED
8589934594	1795899551568476	0.5148	3.8086	0.06331491	0.06727763790780215	MODEL	0.06092002741567908	MEASURED
8589934593	1795899551595797	0.9352	3.7189	0.02112668	0.01794219087466421	MEASURED	0.019804295412248926	MEASURED
8589934592	1795899551596568	0.6627	5.6964	0.05115249	0.060674153450028113	MEASURED	0.05416547268288383	MEASURED
8589934594	1795899551630400	0.6051	1.7203	0.01990847	0.02233940642252705	MODEL	0.019920858345172494	MEASURED
8589934593	1795899551652481	0.952	1.2475	0.00663518	0.0057716080657432625	MEASURED	0.006375637404068178	MEASURED
8589934592	1795899551654631	0.7843	4.3775	0.02841538	0.033385320949478374	MEASURED	0.029460977804069737	MEASURED
8589934592	1795899551677518	0.4632	2.616	0.05187488	0.05529993354990272	MEASURED	0.04953846702596359	MEASURED
8589934594	1795899551704361	0.6257	1.2064	0.0133574	0.01467305440761259	MODEL	0.012912000536777693	MEASURED
8589934593	1795899551711485	0.7813	0.7576	0.005886	0.005467637931861072	MEASURED	0.005995561970648698	MEASURED
8589934594	1795899551761036	0.7261	2.8676	0.02292126	0.025867008883987536	MODEL	0.02277787404865435	MEASURED
8589934592	1795899551783540	0.9362	1.7532	0.00781058	0.009013533862397127	MEASURED	0.007770854227330007	MEASURED
8589934593	1795899551802101	0.5789	2.1636	0.0321133	0.029136823449350112	MEASURED	0.031586868915634336	MEASURED
8589934592	1795899551830485	0.9398	1.5082	0.0064045	0.00768524178345553	MEASURED	0.006624180847905125	MEASURED
8589934593	1795899551836693	0.8052	4.3037	0.03442518	0.029069883539103707	MEASURED	0.031909862892562826	MEASURED
8589934594	1795899551837335	0.6248	4.8172	0.04737333	0.05875599304512159	MODEL	0.05225429398535007	MEASURED
4294967296	1795899551267641	0.4966	3.9513	0.07159679	0.08297946189043327	MODEL	0.0668072450908249	MEASURED
4294967296	1795899551302331	0.7528	4.473	0.03441544	0.04192250503489777	MODEL	0.03277639100979498	MEASURED
4294967296	1795899551378188	0.8949	2.6184	0.01232952	0.017014021547830792	MODEL	0.01307195159154169	MEASURED
4294967296	1795899551452233	0.5466	2.0503	0.03070898	0.03604664684963544	MODEL	0.02906974628858468	MEASURED
4294967296	1795899551476445	0.9007	4.2019	0.01901975	0.026920832853112562	MODEL	0.020663529780178304	MEASURED
4294967296	1795899551573043	0.6527	1.7457	0.01823951	0.021812918892291634	MODEL	0.01731304457994682	MEASURED
4294967296	1795899551632775	0.941	2.1999	0.00989595	0.012797872956067616	MODEL	0.009770657168468191	MEASURED
4294967296	1795899551726956	0.7385	3.2671	0.02563765	0.03185017836023102	MODEL	0.02495826224360936	MEASURED
4294967296	1795899551772945	0.4945	2.7434	0.04980781	0.05806056754522398	MODEL	0.04676217571307305	MEASURED
4294967296	1795899551842487	0.6995	1.8711	0.0163532	0.020365131481730945	MODEL	0.01588071857836788	MEASURED
8589934593	1795899551896898	0.9112	3.4807	0.02004706	0.017959702097212954	MEASURED	0.019736424067424888	MEASURED
8589934594	1795899551898189	0.5437	5.6653	0.07998875	0.09032882649003207	MODEL	0.08007441724327764	MEASURED
8589934592	1795899551919243	0.7588	0.699	0.00476511	0.005706386910526429	MEASURED	0.0049730357636351705	MEASURED
8589934594	1795899551943192	0.9236	1.8723	0.00861059	0.010098244761079896	MODEL	0.008765091884365615	MEASURED
8589934593	1795899551959976	0.5936	1.8708	0.02672094	0.02396557752029269	MEASURED	0.025997744549050093	MEASURED
8589934592	1795899552007209	0.6597	0.9046	0.00887011	0.009725150626316854	MEASURED	0.008683397461224493	MEASURED
8589934592	1795899552031135	0.6983	4.5397	0.03841989	0.04434443921280618	MEASURED	0.0391451172846329	MEASURED
8589934594	1795899552053356	0.9086	2.5434	0.01181031	0.014226642178948347	MODEL	0.012374603945031957	MEASURED
8589934593	1795899552057320	0.5671	0.7971	0.01196745	0.011102063788631336	MEASURED	0.01191847986816062	MEASURED
8589934594	1795899552092358	0.4919	3.4763	0.06175764	0.06680227914520874	MODEL	0.06068740720438533	MEASURED
8589934593	1795899552095731	0.5448	4.6313	0.07418115	0.06978767288615124	MEASURED	0.07484366800896386	MEASURED
8589934592	1795899552097182	0.5369	3.6975	0.05736811	0.06028716198317006	MEASURED	0.05307617762319067	MEASURED
8589934592	1795899552149284	0.7678	3.0227	0.02005676	0.024059718596217115	MEASURED	0.020956805757638326	MEASURED
8589934593	1795899552168325	0.9364	3.4057	0.01824757	0.0163817744549939	MEASURED	0.018082947691811832	MEASURED
8589934594	1795899552168960	0.8205	5.2276	0.02888689	0.03650676590881597	MODEL	0.031914174946975064	MEASURED
8589934592	1795899552215449	0.7859	5.7677	0.0386236	0.043793965894537865	MEASURED	0.03864252064286521	MEASURED
8589934593	1795899552267620	0.8047	2.7113	0.01968937	0.018338968808513566	MEASURED	0.020130153000109566	MEASURED
8589934594	1795899552271934	0.918	5.308	0.02352248	0.029019369500471966	MODEL	0.02520820370432661	MEASURED
8589934594	1795899552312393	0.772	5.5041	0.03851493	0.043724068594178093	MODEL	0.03826278511472877	MEASURED
4294967296	1795899551940744	0.916	4.2199	0.02056532	0.02605544069232517	MODEL	0.019948418404208735	MEASURED
4294967296	1795899552004783	0.5327	2.0402	0.03598916	0.03763995239899359	MODEL	0.030425682750387477	MEASURED
4294967296	1795899552040931	0.8325	3.9903	0.02349374	0.03029661341195438	MODEL	0.023754880955960192	MEASURED
4294967296	1795899552115952	0.728	5.5237	0.04155633	0.055447619917704014	MODEL	0.04352216043066514	MEASURED
4294967296	1795899552150727	0.7513	0.7478	0.0055507	0.007037477573555807	MODEL	0.005503445866293913	MEASURED
4294967296	1795899552251908	0.5059	1.7489	0.03040742	0.035500125857880226	MODEL	0.028534949291662063	MEASURED
4294967296	1795899552288557	0.7912	3.1414	0.02152597	0.026553839792271383	MODEL	0.020752284764418833	MEASURED
8589934592	1795899552324871	0.6169	4.1622	0.04894233	0.05232614290443818	MEASURED	0.046074495914957665	MEASURED
8589934593	1795899552327786	0.8743	5.4271	0.03481144	0.030827616307557697	MEASURED	0.03421150503729597	MEASURED
8589934593	1795899552364998	0.8054	5.3769	0.04125671	0.03629902103001489	MEASURED	0.03984559828067579	MEASURED
8589934594	1795899552381804	0.5451	3.6152	0.0545559	0.05736196848346742	MODEL	0.05084014545874249	MEASURED
8589934592	1795899552384372	0.5952	2.0831	0.02582011	0.02812770454589737	MEASURED	0.024798405208537332	MEASURED
8589934592	1795899552437181	0.9693	3.5278	0.01403016	0.01672425414920368	MEASURED	0.014387980202122782	MEASURED
8589934594	1795899552438619	0.9263	5.1643	0.02326819	0.027672697688621396	MODEL	0.024050826646512154	MEASURED
8589934593	1795899552445814	0.8251	0.975	0.00691916	0.0063109320413530625	MEASURED	0.006988353537549395	MEASURED
8589934592	1795899552478143	0.7799	5.2266	0.03658542	0.04034927774906894	MEASURED	0.035615449536148	MEASURED
8589934593	1795899552483437	0.8065	0.9827	0.00748273	0.0066141442095351485	MEASURED	0.007260724662685395	MEASURED
8589934594	1795899552538487	0.5923	1.7549	0.02186024	0.02375433854775775	MODEL	0.021219728548728126	MEASURED
8589934594	1795899552568208	0.8212	4.5934	0.02570403	0.03201944669421004	MODEL	0.02798867113974945	MEASURED
8589934593	1795899552595578	0.8404	2.0504	0.01445814	0.012737159863862724	MEASURED	0.01411390944361041	MEASURED
8589934592	1795899552598231	0.4801	4.6128	0.08241338	0.09124569744727686	MEASURED	0.08356312108668602	MEASURED
8589934594	1795899552627182	0.7756	0.4767	0.00310215	0.0037501267115799685	MODEL	0.0032985751151480883	MEASURED
8589934593	1795899552655301	0.6342	4.4669	0.05607814	0.05014024281242954	MEASURED	0.05443481175717235	MEASURED
8589934592	1795899552655557	0.4811	4.2909	0.08437283	0.08454946053660901	MEASURED	0.07742555798600523	MEASURED
8589934594	1795899552688540	0.6003	4.5414	0.05701121	0.0598940054744877	MODEL	0.05344470600694177	MEASURED
8589934593	1795899552710227	0.6641	2.3669	0.02475325	0.024167749315616462	MEASURED	0.026271599893331245	MEASURED
8589934592	1795899552731697	0.7745	2.1861	0.01342994	0.017078120327823774	MEASURED	0.014869833449059667	MEASURED
8589934593	1795899552749186	0.5903	3.9651	0.05382744	0.05136342506842738	MEASURED	0.05571066911330924	MEASURED
8589934592	1795899552783280	0.7399	1.7835	0.01301271	0.015364455246722898	MEASURED	0.013404481839544118	MEASURED
4294967296	1795899552403355	0.7869	4.9812	0.0323393	0.042587767714590226	MODEL	0.033306019878606284	MEASURED
4294967296	1795899552419153	0.8635	4.2307	0.02186272	0.029703723293311137	MODEL	0.02317278535441693	MEASURED
4294967296	1795899552519861	0.5191	4.3667	0.07483193	0.08452615979000117	MODEL	0.06778746913496271	MEASURED
4294967296	1795899552564694	0.7141	5.222	0.04685667	0.05451352808291912	MODEL	0.04241114852014428	MEASURED
4294967296	1795899552666438	0.7922	1.038	0.00712147	0.00875091845636267	MODEL	0.006837897526225429	MEASURED
4294967296	1795899552684991	0.9264	5.5683	0.02475652	0.033535722632323774	MODEL	0.02566615804143668	MEASURED
8589934594	1795899552787961	0.8548	3.2842	0.0181171	0.02100027336814261	MODEL	0.01828676538251811	MEASURED
8589934593	1795899552810631	0.596	4.3841	0.05897368	0.05571002539856529	MEASURED	0.06044037319467854	MEASURED
8589934592	1795899552832432	0.6756	2.4668	0.02171758	0.025804684834024164	MEASURED	0.022808677037639568	MEASURED
8589934594	1795899552847281	0.5481	3.1909	0.04268958	0.050106375241739255	MODEL	0.04439095033043325	MEASURED
8589934592	1795899552882005	0.9456	4.2073	0.01787625	0.021134554044478684	MEASURED	0.01820990361244985	MEASURED
8589934593	1795899552899096	0.7376	2.8994	0.02505155	0.023819826356134437	MEASURED	0.025845645768903004	MEASURED
8589934594	1795899552899322	0.9777	5.7078	0.02217274	0.027073305007750476	MODEL	0.02349187360093137	MEASURED
8589934593	1795899552952425	0.7337	1.6886	0.0149652	0.014030900834550573	MEASURED	0.015221647098041764	MEASURED
8589934592	1795899552984560	0.919	3.5251	0.01589655	0.018974824838917263	MEASURED	0.016441425921324374	MEASURED
8589934594	1795899552996105	0.7567	1.497	0.01055749	0.012399346676976649	MODEL	0.010873264940487558	MEASURED
8589934593	1795899553024509	0.9546	3.889	0.02054223	0.017876930597050325	MEASURED	0.019750275088122226	MEASURED
8589934592	1795899553029987	0.6774	3.9547	0.0370684	0.04114282835043941	MEASURED	0.036362272828689965	MEASURED
8589934594	1795899553038175	0.5013	2.7996	0.05139513	0.05195328908407174	MODEL	0.04713413500600532	MEASURED
8589934592	1795899553074438	0.9895	2.4125	0.00957684	0.010946647544337103	MEASURED	0.009585328970880791	MEASURED
8589934593	1795899553103244	0.8275	5.7189	0.04043412	0.03677791445745021	MEASURED	0.04072999469823818	MEASURED
8589934594	1795899553136249	0.4636	2.4051	0.04924712	0.051492092611807865	MODEL	0.04490466414028325	MEASURED
8589934592	1795899553144479	0.7877	0.6174	0.00406481	0.004664700459446563	MEASURED	0.004115564590091047	MEASURED
8589934594	1795899553175313	0.5859	3.9854	0.04988332	0.0550908709150996	MODEL	0.049255829439765954	MEASURED
8589934593	1795899553203628	0.6767	1.0977	0.01208432	0.01071138595052405	MEASURED	0.011757356361006594	MEASURED
8589934594	1795899553225869	0.5473	1.2367	0.01799488	0.01947357003343349	MODEL	0.017254220804387124	MEASURED
8589934592	1795899553252553	0.5606	0.4129	0.00555307	0.006191646712922619	MEASURED	0.005443260796132206	MEASURED
8589934593	1795899553262986	0.9395	0.9	0.00524913	0.004295626639551684	MEASURED	0.00474239618354648	MEASURED
8589934594	1795899553292412	0.8894	2.0421	0.01061065	0.011974232324687362	MODEL	0.01044349638709112	MEASURED
8589934592	1795899553294863	0.6115	1.9325	0.02357987	0.024726578328141163	MEASURED	0.02177918732221398	MEASURED
8589934593	1795899553313061	0.5601	3.363	0.05340575	0.048000345970777625	MEASURED	0.051513866968938116	MEASURED
4294967296	1795899552769487	0.9315	4.1423	0.01799825	0.024646353771283994	MODEL	0.018846638088663225	MEASURED
4294967296	1795899552808962	0.9942	0.2154	0.00092452	0.001107436167580435	MODEL	0.0008514578500132487	MEASURED
4294967296	1795899552922371	0.8913	5.7754	0.02700485	0.037859034097951584	MODEL	0.029104597124151393	MEASURED
4294967296	1795899552998099	0.6102	5.0759	0.06102727	0.07234636768749553	MODEL	0.05746519921536775	MEASURED
4294967296	1795899553060667	0.5102	5.5674	0.09771357	0.11126431464323001	MODEL	0.0893674557622948	MEASURED
4294967296	1795899553075334	0.6141	2.2338	0.02644344	0.03144748849628682	MODEL	0.024963239617725	MEASURED
4294967296	1795899553150685	0.8734	5.54	0.02862668	0.037950896297424826	MODEL	0.02955866082315215	MEASURED
8589934592	1795899553368718	0.7613	4.071	0.03006204	0.033000778465630945	MEASURED	0.028755563467436705	MEASURED
8589934594	1795899553376432	0.9621	3.0012	0.01241377	0.014766087220632893	MODEL	0.012768259691361248	MEASURED
8589934593	1795899553398301	0.5355	1.769	0.02948304	0.027564714728796028	MEASURED	0.029549013733921464	MEASURED
8589934593	1795899553431362	0.5763	2.4589	0.03456238	0.03341067840572217	MEASURED	0.03621589598207696	MEASURED
8589934594	1795899553435562	0.6733	5.9098	0.05357882	0.06213859378770585	MODEL	0.054328491617698024	MEASURED
8589934592	1795899553461053	0.5384	2.6481	0.04251624	0.0429453983413415	MEASURED	0.037805209826861474	MEASURED
8589934594	1795899553495993	0.6536	1.1781	0.011892	0.013144538459889814	MODEL	0.011523167447458413	MEASURED
8589934593	1795899553497650	0.8687	5.3058	0.03593379	0.030582909873476942	MEASURED	0.03393139004553666	MEASURED
8589934592	1795899553510878	0.661	4.5316	0.0406554	0.04852221463382565	MEASURED	0.04332131766320304	MEASURED
8589934592	1795899553548719	0.8912	5.9357	0.02879371	0.034273745288364466	MEASURED	0.029748887155684942	MEASURED
8589934593	1795899553561858	0.5972	3.5481	0.04648401	0.044905408958698406	MEASURED	0.048720912673694994	MEASURED
8589934594	1795899553593638	0.4603	4.5754	0.0918161	0.09922984776507776	MODEL	0.08657750272190437	MEASURED
8589934592	1795899553626184	0.9684	2.4268	0.0095039	0.011529893781410852	MEASURED	0.009919818391069923	MEASURED
8589934594	1795899553630738	0.5297	3.1088	0.04689866	0.05206357167391169	MODEL	0.046243562784688524	MEASURED
8589934593	1795899553640534	0.9115	3.0152	0.01693037	0.015545942445319849	MEASURED	0.017084111226692403	MEASURED
8589934594	1795899553711158	0.595	0.2844	0.00349743	0.0038158842526974574	MODEL	0.003407465573752796	MEASURED
8589934593	1795899553712776	0.8259	2.0818	0.01474256	0.013445879910558702	MEASURED	0.014889697825254108	MEASURED
8589934592	1795899553714555	0.6244	3.7615	0.03890687	0.04615418272352532	MEASURED	0.040622328131753795	MEASURED
8589934592	1795899553749024	0.4568	2.858	0.05739526	0.06198318799763949	MEASURED	0.05554996243799753	MEASURED
8589934594	1795899553754022	0.6116	2.0351	0.02303972	0.025882475931350526	MODEL	0.02305987022967402	MEASURED
4294967296	1795899553240629	0.8418	5.6135	0.03392021	0.04162354781876326	MODEL	0.03258687283241805	MEASURED
4294967296	1795899553334522	0.6156	5.2327	0.06096695	0.07331818821053596	MODEL	0.05818643147131308	MEASURED
4294967296	1795899553361282	0.9875	1.9613	0.00726949	0.01023949162255939	MODEL	0.00788182615328819	MEASURED
4294967296	1795899553458475	0.8207	1.8644	0.01200446	0.014591010231259992	MODEL	0.011349139673981871	MEASURED
4294967296	1795899553510792	0.8114	2.2808	0.01378576	0.018284906011654188	MODEL	0.014243661533821544	MEASURED
4294967296	1795899553548552	0.5444	1.9703	0.03051527	0.034903303901533074	MODEL	0.028158063083446584	MEASURED
8589934593	1795899553804172	0.8744	4.7789	0.03109165	0.027138559385596454	MEASURED	0.03011764303018979	MEASURED
8589934594	1795899553821987	0.6052	2.2001	0.02563583	0.028560785138064773	MODEL	0.02546833931201129	MEASURED
8589934592	1795899553837537	0.8805	3.7009	0.01897422	0.021962521882280855	MEASURED	0.019075481949606184	MEASURED
8589934593	1795899553849299	0.8521	2.337	0.01583183	0.014072588598841996	MEASURED	0.015601789549317787	MEASURED
8589934593	1795899553875469	0.9273	0.4985	0.00287735	0.0024532997433988476	MEASURED	0.0027069151676617173	MEASURED
8589934592	1795899553927580	0.5017	3.345	0.05163198	0.0609228794060726	MEASURED	0.05571504612157141	MEASURED
8589934594	1795899553928600	0.9444	3.6486	0.01542522	0.018720587778104047	MODEL	0.016228669941372946	MEASURED
8589934594	1795899553956081	0.8631	0.7274	0.00389347	0.004554661953537679	MODEL	0.003961577020307451	MEASURED
8589934593	1795899553960493	0.6333	2.1621	0.02591114	0.024339653387015218	MEASURED	0.026423342185637237	MEASURED
8589934592	1795899553973344	0.8393	4.7631	0.02659818	0.031174504604366618	MEASURED	0.027494174139245833	MEASURED
8589934592	1795899554030530	0.9977	5.5801	0.0221912	0.024827574078904038	MEASURED	0.021728242001511525	MEASURED
8589934594	1795899554048271	0.506	2.2959	0.04046345	0.0418763342760344	MODEL	0.03796647181432734	MEASURED
8589934593	1795899554073993	0.9291	4.0133	0.02288075	0.01966157628450848	MEASURED	0.02169595257342688	MEASURED
8589934593	1795899554075745	0.4982	2.5591	0.05307238	0.04585980990319065	MEASURED	0.04925866599947585	MEASURED
8589934594	1795899554099087	0.7198	4.1319	0.03214806	0.03794358502445147	MODEL	0.03322131697924556	MEASURED
8589934592	1795899554119377	0.9498	2.4156	0.0097497	0.012009700391216504	MEASURED	0.010344997158861061	MEASURED
8589934592	1795899554177620	0.5383	3.5801	0.05260972	0.058080840787500636	MEASURED	0.05112938421076204	MEASURED
8589934594	1795899554183308	0.5318	4.8482	0.0780608	0.08059259441610628	MODEL	0.07156235103328802	MEASURED
8589934593	1795899554207138	0.9954	3.7178	0.01867457	0.015607886230302376	MODEL	0.017800505914348654	MEASURED
8589934592	1795899554247029	0.6172	4.2385	0.04809919	0.05323342566841887	MEASURED	0.04687256817268032	MEASURED
8589934593	1795899554251120	0.8519	3.2881	0.02226186	0.019810271436824706	MEASURED	0.021962763324899902	MEASURED
8589934594	1795899554273008	0.5016	2.6698	0.04610631	0.04948977285782902	MODEL	0.04489721033572728	MEASURED
8589934593	1795899554335827	0.7431	3.5889	0.03087766	0.02901822134121253	MEASURED	0.03149359096030095	MEASURED
4294967296	1795899553662018	0.8712	2.8011	0.01454612	0.019293402217914042	MODEL	0.015032400392479835	MEASURED
4294967296	1795899553674303	0.8929	2.8632	0.01358709	0.018695699586266677	MODEL	0.014368746772747533	MEASURED
4294967296	1795899553772593	0.7804	1.7682	0.01177414	0.015381368222105623	MODEL	0.01204161493016564	MEASURED
4294967296	1795899553865240	0.7659	5.0618	0.03547388	0.04578072304600316	MODEL	0.03571818945265639	MEASURED
4294967296	1795899553922859	0.5889	5.6418	0.08037199	0.08610914906223478	MODEL	0.06863364982882322	MEASURED
4294967296	1795899553993461	0.5818	5.694	0.07223067	0.08894680157999263	MODEL	0.0709775887535893	MEASURED
4294967296	1795899554071434	0.6522	4.7293	0.05286683	0.05918311284634405	MODEL	0.04697774004179379	MEASURED
4294967296	1795899554092406	0.6495	5.4591	0.05910064	0.06887708337169098	MODEL	0.054696085989136126	MEASURED
4294967296	1795899554174562	0.4756	5.6046	0.11026672	0.12730882837623278	MODEL	0.10288146514033757	MEASURED
4294967296	1795899554230085	0.5854	0.6891	0.00907323	0.010638306133613724	MODEL	0.008484144718500859	MEASURED
8589934594	1795899554337357	0.8629	0.8621	0.00464618	0.005400816425964777	MODEL	0.004697680008917678	MEASURED
8589934592	1795899554338309	0.9665	1.5546	0.00632919	0.007420173231998632	MEASURED	0.006384779453488191	MEASURED
8589934594	1795899554353304	0.733	5.4114	0.04192345	0.0478729745113787	MODEL	0.042116339919774634	MEASURED
8589934593	1795899554385406	0.5762	1.4492	0.02065847	0.019698002971627795	MEASURED	0.021351785447789023	MEASURED
8589934592	1795899554385616	0.6503	3.6826	0.03620898	0.040768512434571524	MEASURED	0.03642100709301089	MEASURED
8589934594	1795899554414501	0.8718	4.2189	0.02094871	0.025845814576652585	MODEL	0.02245313331594674	MEASURED
8589934593	1795899554441656	0.7623	3.0829	0.02516306	0.023592211831174676	MEASURED	0.025625891277517934	MEASURED
8589934592	1795899554463191	0.9659	2.6233	0.01014392	0.01253939733933493	MEASURED	0.010790097759402229	MEASURED
8589934594	1795899554481977	0.9574	2.3819	0.00949602	0.011849863314553502	MODEL	0.010253488095174323	MEASURED
8589934592	1795899554485536	0.7604	0.4897	0.00344826	0.003979736928444683	MEASURED	0.003467964384140547	MEASURED
8589934593	1795899554534886	0.6142	2.511	0.03219276	0.030034261554506517	MEASURED	0.03261050966750696	MEASURED
8589934592	1795899554572666	0.6991	0.2659	0.00232768	0.0025911582097944215	MEASURED	0.002287244087201512	MEASURED
8589934594	1795899554592191	1	0.5828	0.0021775	0.0026249343718236775	MODEL	0.002270356322895165	MEASURED
8589934593	1795899554600152	0.8289	5.0134	0.03644973	0.0321194152736789	MEASURED	0.03557309701003111	MEASURED
8589934592	1795899554611307	0.4513	2.0989	0.04244855	0.046542706075742526	MEASURED	0.041728106405814286	MEASURED
8589934594	1795899554633815	0.8437	3.3506	0.01892797	0.022039094802039156	MODEL	0.019220858337368453	MEASURED
8589934593	1795899554656303	0.5359	3.5103	0.05663197	0.054618582711285786	MEASURED	0.05855149550871259	MEASURED
8589934594	1795899554695927	0.6986	2.3434	0.01947205	0.022871923954969862	MODEL	0.020083044478403703	MEASURED
8589934593	1795899554703210	0.7742	5.399	0.0435782	0.039948995849494	MEASURED	0.043414958955878796	MEASURED
8589934592	1795899554737990	0.5481	2.2312	0.03084668	0.034957105916218416	MEASURED	0.030754926242134415	MEASURED
8589934594	1795899554745672	0.5374	4.3761	0.0671904	0.07132514751178287	MODEL	0.06328369626863695	MEASURED
4294967296	1795899554335252	0.7687	0.6018	0.00458696	0.005401902445804406	MODEL	0.0042126891518311105	MEASURED
4294967296	1795899554354716	0.977	4.2217	0.0167202	0.02257956892054771	MODEL	0.017412066697586808	MEASURED
4294967296	1795899554445023	0.6583	1.9385	0.01860242	0.02381653364464512	MODEL	0.018886448601190892	MEASURED
4294967296	1795899554540463	0.6772	3.1425	0.02957117	0.03649783229778092	MODEL	0.028562039003943093	MEASURED
4294967296	1795899554593531	0.6195	0.3297	0.00375016	0.004563274069030303	MODEL	0.003619210571318069	MEASURED
4294967296	1795899554661916	0.6091	5.6683	0.0705307	0.08107245217229421	MODEL	0.06440782336768909	MEASURED
4294967296	1795899554738782	0.9936	2.1261	0.00822439	0.010945916797841519	MODEL	0.00841669914187781	MEASURED
8589934592	1795899554761569	0.8129	1.193	0.00703926	0.008415187626609352	MEASURED	0.007413596943557738	MEASURED
8589934593	1795899554768311	0.5154	5.6005	0.0970703	0.09406203965927533	MEASURED	0.10111746841125009	MEASURED
8589934594	1795899554816828	0.7209	5.4996	0.04223478	0.050345563232286054	MODEL	0.04407323000937794	MEASURED
8589934593	1795899554825617	0.698	1.6253	0.01642953	0.014863634937511923	MEASURED	0.016329973474069368	MEASURED
8589934592	1795899554854680	0.6802	4.1045	0.03866113	0.04233904106389971	MEASURED	0.03741350806579276	MEASURED
8589934592	1795899554878104	0.5875	0.4527	0.00532673	0.006272434695875046	MEASURED	0.005532498948910725	MEASURED
8589934594	1795899554923325	0.5976	5.139	0.06211585	0.06837112678039226	MODEL	0.06103155980921187	MEASURED
8589934593	1795899554934633	0.4503	1.4236	0.03034586	0.030464562344745923	MEASURED	0.03269245371081271	MEASURED
8589934592	1795899554974541	0.967	1.7047	0.00646046	0.008126728335375609	MEASURED	0.006992517183298059	MEASURED
8589934594	1795899554991345	0.7156	3.7832	0.03047989	0.035159928277638024	MODEL	0.030801642197641085	MEASURED
8589934593	1795899554992188	0.9461	0.2648	0.00145982	0.0012432167560458528	MEASURED	0.0013729438518381588	MEASURED
8589934592	1795899555036256	0.6984	1.9746	0.01693409	0.019282420483534415	MEASURED	0.017021487083037492	MEASURED
8589934594	1795899555041068	0.7665	2.0514	0.01440465	0.01654162665972097	MODEL	0.014486378046542096	MEASURED
8589934593	1795899555046689	0.7616	5.2415	0.04274007	0.04019103759382368	MEASURED	0.043654239646682094	MEASURED
8589934593	1795899555090900	0.9318	2.9327	0.01621915	0.014270372434343447	MEASURED	0.0157489032575229	MEASURED
8589934592	1795899555104561	0.728	4.6108	0.03534961	0.041108657451283274	MEASURED	0.03588910793152483	MEASURED
8589934594	1795899555110971	0.6464	4.7949	0.05182061	0.05468905900283672	MODEL	0.04799007459063241	MEASURED
8589934594	1795899555169663	0.8614	0.5017	0.00255686	0.0031549231990689024	MODEL	0.002744752812093866	MEASURED
8589934592	1795899555197906	0.5428	0.854	0.01261111	0.013633868540448004	MEASURED	0.011998799109542477	MEASURED
8589934593	1795899555199944	0.572	4.7849	0.06449468	0.06552095130939481	MEASURED	0.0703546823885623	MEASURED
8589934592	1795899555220701	0.9124	4.768	0.02132597	0.02609331494733787	MEASURED	0.022618805561324763	MEASURED
8589934594	1795899555241559	0.7695	0.441	0.00318371	0.003527122890920648	MODEL	0.0030876255630703803	MEASURED
8589934593	1795899555257578	0.7349	3.2144	0.0300673	0.026615856348668053	MEASURED	0.028876124379920723	MEASURED
8589934593	1795899555280961	0.5517	2.6442	0.04352638	0.03887661972616763	MEASURED	0.04170635767751028	MEASURED
8589934594	1795899555298045	0.8568	2.4556	0.01446446	0.015622553917526349	MODEL	0.013600146671208633	MEASURED
4294967296	1795899554777657	0.4407	2.6703	0.06186041	0.06949454637758759	MODEL	0.05579740956637944	MEASURED
4294967296	1795899554813598	0.569	1.488	0.01933772	0.024250285599051936	MODEL	0.01948407261984199	MEASURED
4294967296	1795899554915257	0.506	2.7597	0.05077363	0.055997556737167414	MODEL	0.045009972186041046	MEASURED
4294967296	1795899554975977	0.6103	0.2347	0.00267725	0.003344097792965197	MODEL	0.0026561961597572643	MEASURED
4294967296	1795899555024034	0.5549	2.4276	0.03809498	0.04148679881282237	MODEL	0.03341069638082434	MEASURED
4294967296	1795899555107061	0.6294	5.1306	0.05505687	0.06885054007385065	MODEL	0.054851155337158106	MEASURED
4294967296	1795899555152977	0.6743	0.9008	0.00795478	0.01055202043907737	MODEL	0.008346430803150607	MEASURED
8589934592	1795899555323812	0.7942	5.0439	0.03301633	0.03743432992013597	MEASURED	0.033014986781855236	MEASURED
8589934594	1795899555348113	0.5047	3.0605	0.05440173	0.05608901978275402	MODEL	0.05086157480016679	MEASURED
8589934592	1795899555372561	0.5918	4.5466	0.05550063	0.06209324356883688	MEASURED	0.05475453943368841	MEASURED
8589934593	1795899555377190	0.883	1.9529	0.01269367	0.010833620867922207	MEASURED	0.01189006345101738	MEASURED
8589934592	1795899555409096	0.9529	2.2338	0.00978418	0.011021742563500686	MEASURED	0.009492100939385028	MEASURED
8589934593	1795899555433936	0.5135	5.7154	0.10361426	0.0966744020232892	MEASURED	0.10391633799803127	MEASURED
8589934594	1795899555461094	0.9582	4.6382	0.01950134	0.023031275720148812	MODEL	0.019926297763326384	MEASURED
8589934593	1795899555512113	0.5483	0.3708	0.00587801	0.0055180472045241475	MEASURED	0.005918771686080621	MEASURED
8589934594	1795899555516777	0.9129	3.0058	0.01354971	0.016637852745658106	MODEL	0.014463165815673168	MEASURED
8589934592	1795899555516807	0.8855	1.403	0.00700438	0.008219924397638986	MEASURED	0.0071372118397360915	MEASURED
8589934594	1795899555562007	0.5467	3.3876	0.05102095	0.05345338895872469	MODEL	0.047365406561766125	MEASURED
8589934592	1795899555568346	0.8949	3.3504	0.01601543	0.019164459085241576	MEASURED	0.01663056577986234	MEASURED
8589934593	1795899555569720	0.5733	4.3694	0.06698241	0.059563159131432585	MEASURED	0.06396108937085657	MEASURED
8589934594	1795899555626837	0.4976	5.8676	0.10236406	0.1103872301289025	MODEL	0.10020076354306984	MEASURED
8589934593	1795899555658034	0.5872	5.4753	0.0753438	0.07167556154848315	MEASURED	0.07773128444902383	MEASURED
8589934592	1795899555673846	0.9866	2.3575	0.00902345	0.010771806182773609	MEASURED	0.009434032127855551	MEASURED
8589934594	1795899555690804	0.8981	5.0385	0.02381654	0.028917246261051563	MODEL	0.025189882279161274	MEASURED
8589934592	1795899555698429	0.5024	5.1406	0.08728336	0.09338010449569364	MEASURED	0.0853939313203084	MEASURED
8589934593	1795899555735145	0.9554	5.38	0.03060573	0.024681764967593507	MEASURED	0.027269229241087215	MEASURED
8589934594	1795899555752846	0.6574	1.4104	0.01390021	0.015555761974025811	MODEL	0.013629938755669303	MEASURED
4294967296	1795899555249765	0.4654	5.3623	0.11397357	0.1266503980014879	MODEL	0.10121628278701128	MEASURED
4294967296	1795899555282361	0.8631	1.4851	0.00774866	0.010437291224939306	MODEL	0.00814298375189867	MEASURED
4294967296	1795899555381203	0.483	5.7448	0.11082757	0.12689906441614332	MODEL	0.10241384572518362	MEASURED
4294967296	1795899555436368	0.6167	1.7521	0.02022891	0.024464676713257878	MODEL	0.019412100391875606	MEASURED
4294967296	1795899555516154	0.9915	5.226	0.02050395	0.027034828621206045	MODEL	0.020795597331882573	MEASURED
4294967296	1795899555562449	0.7568	4.0658	0.03028107	0.03769215591233602	MODEL	0.029450188175500006	MEASURED
4294967296	1795899555659340	0.7182	0.2431	0.00206789	0.0025084752984832286	MODEL	0.0019503057496329074	MEASURED
8589934592	1795899555766238	0.9553	4.5327	0.01780855	0.022233683931007504	MEASURED	0.019145058674019912	MEASURED
8589934593	1795899555783200	0.8866	5.9939	0.0341205	0.03294231423148662	MEASURED	0.036160587283796404	MEASURED
8589934592	1795899555815086	0.505	2.0316	0.03447377	0.036546046114463694	MEASURED	0.033414971296246126	MEASURED
8589934594	1795899555819060	0.8589	0.8473	0.00425319	0.005361967316410789	MODEL	0.004666478334922081	MEASURED
8589934593	1795899555824137	0.5494	3.4201	0.04869508	0.0506970815576469	MEASURED	0.05438148076922973	MEASURED
8589934594	1795899555902670	0.6714	1.8311	0.01676611	0.019362575610735042	MODEL	0.016933284870346847	MEASURED
8589934593	1795899555931066	0.8378	5.819	0.04033431	0.03640007121073069	MEASURED	0.040329883705948213	MEASURED
8589934592	1795899555937921	0.8129	3.3988	0.02220109	0.0239744674814081	MEASURED	0.021120983480103973	MEASURED
8589934594	1795899555948977	0.4757	1.9526	0.03813177	0.03989402843168265	MODEL	0.03632733434870244	MEASURED
8589934593	1795899555949396	0.7095	3.312	0.03286423	0.029262622381701856	MEASURED	0.03216529995573176	MEASURED
8589934592	1795899556006692	0.7488	3.7916	0.02859162	0.03184326317162889	MEASURED	0.027766951386697884	MEASURED
8589934594	1795899556016727	0.6836	3.3976	0.03032631	0.034649466205779474	MODEL	0.030486411616851995	MEASURED
8589934593	1795899556022075	0.5155	5.5584	0.08815843	0.09332019741519088	MEASURED	0.1003204608896607	MEASURED
8589934592	1795899556059490	0.8468	0.344	0.00195735	0.0022073890234914745	MEASURED	0.0019459227945363901	MEASURED
8589934592	1795899556101647	0.898	2.8091	0.01314623	0.01594220653526968	MEASURED	0.013831714465863782	MEASURED
8589934593	1795899556121331	0.8429	3.74	0.02475077	0.023078486233251514	MEASURED	0.025575855480197723	MEASURED
8589934594	1795899556122694	0.4939	2.6622	0.04650755	0.05077762360727523	MODEL	0.04611634708587617	MEASURED
8589934593	1795899556143754	0.7527	2.2714	0.01964249	0.01786500089538221	MEASURED	0.019396962859486264	MEASURED
8589934594	1795899556157458	0.8554	2.3893	0.01329762	0.015254760897902155	MODEL	0.01328254330439913	MEASURED
8589934592	1795899556187063	0.6755	3.8192	0.03614645	0.03996405928232201	MEASURED	0.0353243038958727	MEASURED
8589934593	1795899556246532	0.5431	5.3467	0.07759614	0.08106026807990296	MEASURED	0.08692613515564562	MEASURED
8589934594	1795899556252135	0.9324	2.2506	0.00991191	0.011883984149892378	MODEL	0.010319663402606566	MEASURED
8589934592	1795899556269003	0.8668	0.4812	0.00247732	0.002930693560275137	MEASURED	0.0025804469070588843	MEASURED
8589934594	1795899556276912	0.5255	1.3949	0.02228823	0.023711845439371295	MODEL	0.021073605334685434	MEASURED
8589934593	1795899556277456	0.6849	4.9764	0.04795091	0.047354588628498	MEASURED	0.05199705806904223	MEASURED
4294967296	1795899555677274	0.8181	3.1979	0.0204477	0.02519574627448324	MODEL	0.019605912378563576	MEASURED
4294967296	1795899555772441	0.4807	5.7418	0.11254163	0.12793447596438648	MODEL	0.10329205805503339	MEASURED
4294967296	1795899555864216	0.8753	0.7098	0.00346111	0.004839565150140639	MODEL	0.003730297268237903	MEASURED
4294967296	1795899555911094	0.9135	4.7532	0.02161503	0.029525189225401312	MODEL	0.02261434115416579	MEASURED
4294967296	1795899555979591	0.6315	0.5141	0.00572527	0.006854250014257479	MODEL	0.005458736120456715	MEASURED
4294967296	1795899556047332	0.998	5.9844	0.02162793	0.030501932708257688	MODEL	0.02343608870716807	MEASURED
4294967296	1795899556076902	0.8327	4.8828	0.0273242	0.03705403707939401	MODEL	0.029052280850426295	MEASURED
4294967296	1795899556141228	0.8593	3.4256	0.01778511	0.024304853705545356	MODEL	0.018973985250143172	MEASURED
4294967296	1795899556214919	0.9351	5.5732	0.02503917	0.032877880622157275	MODEL	0.025125917558492965	MEASURED
4294967296	1795899556307665	0.791	3.2115	0.02172302	0.027160746182566673	MODEL	0.02122727323396032	MEASURED
8589934592	1795899556305619	0.6283	1.0887	0.01301665	0.012923538961724665	MEASURED	0.011559987566576977	MEASURED
8589934593	1795899556346819	0.5857	1.4713	0.01989383	0.019358806441543124	MEASURED	0.020992995160733142	MEASURED
8589934592	1795899556366484	0.9687	2.5838	0.01022853	0.01226687631411782	MEASURED	0.010553680830777427	MEASURED
8589934594	1795899556379226	0.7624	3.5598	0.02552443	0.029027839142918233	MODEL	0.025435417213372256	MEASURED
8589934594	1795899556427616	0.9828	3.9633	0.01522673	0.018576506882439597	MODEL	0.016107240429526687	MEASURED
8589934593	1795899556431605	0.8334	0.5494	0.0040743	0.003477493383438845	MEASURED	0.003852180073561772	MEASURED
8589934592	1795899556445544	0.615	1.8708	0.01905128	0.023665135069600024	MEASURED	0.02084004237752257	MEASURED
8589934594	1795899556483300	0.4523	1.9737	0.04113731	0.04417787421803946	MODEL	0.038590844153065636	MEASURED
8589934592	1795899556524940	0.5805	3.5053	0.04444743	0.049730671809577645	MEASURED	0.04388218307830711	MEASURED
8589934593	1795899556539366	0.5629	4.9834	0.07334094	0.07043384609116841	MEASURED	0.07559903240086939	MEASURED
8589934592	1795899556552406	0.4998	4.9152	0.08537727	0.09016452437585876	MEASURED	0.08246707420042644	MEASURED
8589934594	1795899556579106	0.8427	4.9625	0.02555036	0.03272523106013881	MODEL	0.028544455165121826	MEASURED
8589934593	1795899556585081	0.9902	5.0672	0.0241872	0.02153821635587445	MODEL	0.024563168313039768	MEASURED
8589934593	1795899556634987	0.7161	4.2832	0.03975309	0.03710855456458756	MEASURED	0.040801036188404395	MEASURED
8589934592	1795899556637377	0.7935	3.2906	0.01886506	0.02446874550864714	MEASURED	0.02158094775244117	MEASURED
8589934594	1795899556660998	0.6364	2.047	0.0222971	0.02407908631371008	MODEL	0.021158309211951852	MEASURED
8589934593	1795899556678224	0.9116	3.018	0.01664984	0.01555641949464243	MEASURED	0.017095703587559522	MEASURED
8589934592	1795899556690206	0.6604	3.968	0.03896497	0.042566548049371745	MEASURED	0.0380053190494412	MEASURED
8589934594	1795899556713271	0.9115	1.2355	0.00553231	0.006862147821566237	MODEL	0.005966391712819526	MEASURED
8589934593	1795899556765828	0.9227	3.3711	0.01866769	0.016894197492664	MEASURED	0.018575372475802154	MEASURED
4294967296	1795899556366253	0.453	3.7534	0.07696385	0.09303197415254506	MODEL	0.07452086711995444	MEASURED
4294967296	1795899556471717	0.9468	4.4374	0.01815634	0.02546389074580733	MODEL	0.019421589012104595	MEASURED
4294967296	1795899556536808	0.6294	0.3892	0.00390079	0.00522290379229382	MODEL	0.004160930428648098	MEASURED
4294967296	1795899556603635	0.5094	1.1728	0.01951673	0.023506191406047244	MODEL	0.01888277736833602	MEASURED
4294967296	1795899556613294	0.6417	3.2604	0.03501974	0.042125750533995594	MODEL	0.03349426682410698	MEASURED
4294967296	1795899556734474	0.667	1.0739	0.0107072	0.0128550629107623	MODEL	0.010179910759804418	MEASURED
4294967296	1795899556744951	0.9201	0.7459	0.00328883	0.00456042801700102	MODEL	0.0034891372267969838	MEASURED
8589934592	1795899556772918	0.5154	4.0593	0.07106173	0.07025114069690881	MEASURED	0.06419022433156926	MEASURED
8589934594	1795899556805792	0.8577	1.9112	0.01046541	0.01213140756862408	MODEL	0.010559626586611864	MEASURED
8589934593	1795899556807697	0.886	2.5493	0.01577558	0.014032650687546255	MEASURED	0.015403140229810205	MEASURED
8589934592	1795899556810005	0.7295	3.5774	0.02911917	0.03175672973320187	MEASURED	0.027722207095799794	MEASURED
8589934594	1795899556872962	0.5265	1.722	0.02751745	0.029168151371818427	MODEL	0.025919185441559498	MEASURED
8589934592	1795899556911482	0.7243	2.7004	0.02315001	0.024432064884932173	MEASURED	0.021535394809010667	MEASURED
8589934593	1795899556923124	0.9666	3.9521	0.02027291	0.017636340143887735	MEASURED	0.019495594438844327	MEASURED
8589934594	1795899556926118	0.5429	1.1993	0.01877061	0.019175194146312875	MODEL	0.01700026148424048	MEASURED
8589934593	1795899556967032	0.6646	5.2774	0.05676898	0.05380213998620754	MEASURED	0.058486979811980755	MEASURED
8589934594	1795899556992845	0.6967	5.4501	0.04905536	0.0534884557829326	MODEL	0.04697845753017928	MEASURED
8589934592	1795899557001401	0.9248	0.3655	0.00161526	0.0019391137843123621	MEASURED	0.0016796054718871969	MEASURED
8589934594	1795899557011557	0.61	1.1525	0.0131641	0.014732674750217488	MODEL	0.013128873330458328	MEASURED
8589934592	1795899557041938	0.4367	2.2561	0.04584964	0.05311720265130069	MEASURED	0.04767243395485564	MEASURED
8589934593	1795899557073527	0.624	5.0941	0.06074691	0.0590079154047415	MEASURED	0.06409680244880014	MEASURED
8589934592	1795899557100312	0.6553	3.5291	0.03422745	0.03846333651621756	MEASURED	0.03435181327164401	MEASURED
8589934593	1795899557114728	0.963	3.5336	0.01922182	0.015909296022206025	MEASURED	0.017583462843561395	MEASURED
8589934594	1795899557116365	0.6907	1.3771	0.01268139	0.013753969517976434	MODEL	0.012089822260423789	MEASURED
8589934593	1795899557151796	0.794	2.0287	0.01626882	0.014132763489643298	MEASURED	0.01550589091209618	MEASURED
8589934594	1795899557167341	0.8735	4.9281	0.02521447	0.030062341632557714	MODEL	0.02610999367187963	MEASURED
8589934592	1795899557176429	0.4671	3.4433	0.06915741	0.07166968708105552	MEASURED	0.06418563302726572	MEASURED
8589934594	1795899557232323	0.7316	3.5576	0.02885573	0.031597105538079526	MODEL	0.0278028975613003	MEASURED
8589934592	1795899557233050	0.8423	5.7963	0.03198723	0.03763736336557247	MEASURED	0.033188119383250864	MEASURED
8589934593	1795899557240989	0.4693	2.2595	0.04392609	0.04478069417069809	MEASURED	0.048103987195177306	MEASURED
8589934594	1795899557284478	0.6246	1.7703	0.02001935	0.02160615507106622	MODEL	0.019215829061223575	MEASURED
8589934593	1795899557313534	0.9412	5.9317	0.03235147	0.028191455906668703	MEASURED	0.03112600813102355	MEASURED
8589934592	1795899557330274	0.7184	5.1296	0.03953681	0.04721671922275587	MEASURED	0.04163275721996831	MEASURED
4294967296	1795899556828547	1	5.6509	0.02140192	0.028671177382390296	MODEL	0.022021767729986153	MEASURED
4294967296	1795899556910018	0.8319	1.276	0.00763033	0.009702982486397092	MODEL	0.007608625851181958	MEASURED
4294967296	1795899556987367	0.5961	2.4618	0.03164663	0.03670710743078166	MODEL	0.02922331755678651	MEASURED
4294967296	1795899557024572	0.7458	3.0705	0.02388606	0.029335958821902663	MODEL	0.022961396277218837	MEASURED
4294967296	1795899557102322	0.9529	5.8264	0.02394121	0.03295905484779378	MODEL	0.025112239757394107	MEASURED
4294967296	1795899557180434	0.6863	5.7311	0.05351046	0.06481022143305322	MODEL	0.05064508398257612	MEASURED
8589934594	1795899557345402	0.854	5.7107	0.03056307	0.03659030248579217	MODEL	0.03186589215442422	MEASURED
8589934593	1795899557346271	0.7762	3.9211	0.03215041	0.0287062974234838	MEASURED	0.03147106268690056	MEASURED
8589934592	1795899557402061	1	2.6833	0.00997482	0.011873486429281859	MEASURED	0.010389680520358642	MEASURED
8589934593	1795899557445984	0.9523	2.0931	0.01080417	0.009676600573253171	MEASURED	0.010689459630571609	MEASURED
8589934592	1795899557460027	0.9809	3.5824	0.01420062	0.016594611371040725	MEASURED	0.014539127277493211	MEASURED
8589934594	1795899557472765	0.9662	0.8889	0.00361558	0.004331422952268464	MODEL	0.0037431887671252407	MEASURED
8589934594	1795899557495765	0.9606	3.5554	0.01387963	0.017554785737750538	MODEL	0.015182911493179975	MEASURED
8589934593	1795899557534423	0.5851	5.0551	0.07253659	0.0666490363106403	MEASURED	0.07227334063074779	MEASURED
8589934592	1795899557539953	0.619	2.489	0.02651265	0.031078413780983274	MEASURED	0.02736200942315485	MEASURED
8589934594	1795899557568409	0.8628	2.4541	0.01205276	0.01537812892105584	MODEL	0.013376224285700004	MEASURED
8589934593	1795899557580133	0.9442	5.9309	0.0329769	0.027977338906896417	MEASURED	0.03089395504087744	MEASURED
8589934592	1795899557582697	0.8305	3.3735	0.01959182	0.02260115411684314	MEASURED	0.019943385493355826	MEASURED
8589934593	1795899557635574	0.7682	1.016	0.00837219	0.007646058993390954	MEASURED	0.008307274276928293	MEASURED
8589934594	1795899557667919	0.7125	5.3284	0.04295157	0.0499617089681888	MODEL	0.04378705666389523	MEASURED
8589934594	1795899557688529	0.7219	3.6555	0.02903207	0.03336899838290694	MODEL	0.029207738251572173	MEASURED
8589934593	1795899557738948	0.8248	5.9848	0.04433667	0.03832372953607898	MEASURED	0.0421039189900431	MEASURED
4294967296	1795899557254024	0.9969	4.1614	0.0153713	0.021263539911878303	MODEL	0.016340915653006778	MEASURED
4294967296	1795899557339189	0.832	2.9386	0.01742377	0.022340043748324122	MODEL	0.01751773555898636	MEASURED
4294967296	1795899557354309	0.8635	5.0741	0.02816703	0.03562523042583734	MODEL	0.027792334641276135	MEASURED
4294967296	1795899557464778	0.5713	5.1812	0.07717111	0.08379459294964131	MODEL	0.06729991814305823	MEASURED
4294967296	1795899557510746	0.5459	4.399	0.07470077	0.07752578285762116	MODEL	0.06252783159021916	MEASURED
4294967296	1795899557606766	0.4709	1.0038	0.02027514	0.023213211442110374	MODEL	0.01853282305992982	MEASURED
4294967296	1795899557645715	0.5385	0.4531	0.0072012	0.008192004317404848	MODEL	0.006615406505943584	MEASURED
4294967296	1795899557689218	0.6343	0.6782	0.00743888	0.008964197798338108	MODEL	0.007135898948303807	MEASURED
4294967296	1795899557792212	0.8569	4.7686	0.02630704	0.034037541792332884	MODEL	0.026582384974553286	MEASURED
4294967296	1795899557848289	0.5253	2.4399	0.04435965	0.046200985962929986	MODEL	0.0373927859435328	MEASURED
8589934593	1795899557759499	0.7551	4.0611	0.03409502	0.031722601931866316	MEASURED	0.03444644179530328	MEASURED
8589934594	1795899557775251	0.8798	2.2087	0.01142776	0.013263325532310057	MODEL	0.011583316303482182	MEASURED
8589934594	1795899557825467	0.8254	4.2798	0.02859082	0.0295096165013069	MODEL	0.02580112679571306	MEASURED
8589934594	1795899557926553	0.799	2.3759	0.01437029	0.017556101437903454	MODEL	0.015392868183967307	MEASURED
4294967296	1795899557884812	0.7596	3.265	0.02316306	0.030038487037878873	MODEL	0.023459637424240294	MEASURED
4294967296	1795899557952135	0.6549	3.5801	0.03812903	0.04443792844095605	MODEL	0.03525827241660774	MEASURED
4294967296	1795899558057417	0.8422	1.7507	0.00975861	0.012968104457946762	MODEL	0.0101520060944933	MEASURED
4294967296	1795899558077224	0.753	2.7756	0.0215461	0.02599965747494635	MODEL	0.02032673829275353	MEASURED
8589934594	1795899557988806	0.5372	0.4708	0.00656561	0.007678854904142182	MODEL	0.006813303856825529	MEASURED
8589934594	1795899558032737	0.9549	5.9421	0.02435999	0.029737121696476333	MODEL	0.025740225418756327	MEASURED
8589934594	1795899558106931	0.5757	3.0449	0.04110406	0.04353727068213498	MODEL	0.03898055330954553	MEASURED
8589934594	1795899558170457	0.5269	0.8146	0.01153018	0.013778506701280313	MODEL	0.012243065914277762	MEASURED
8589934594	1795899558211073	0.6702	4.1037	0.03940498	0.04354962528641941	MODEL	0.03809194631053054	MEASURED
4294967296	1795899558156206	0.9063	3.5399	0.01634355	0.022373846705039852	MODEL	0.01715744831532821	MEASURED
4294967296	1795899558226267	0.8385	3.1355	0.01980306	0.0234451168892097	MODEL	0.018364905010505746	MEASURED
4294967296	1795899558299599	0.5158	0.5805	0.01002158	0.01137001784172278	MODEL	0.00912358142045142	MEASURED
8589934594	1795899558323283	0.9417	4.8924	0.02105132	0.025264617364261166	MODEL	0.02191002838936103	MEASURED
8589934594	1795899558376961	0.454	0.4569	0.01001166	0.010158204332338832	MODEL	0.008871278327566751	MEASURED
8589934592	1795899558389604	0.9075	2.9041	0.014538	0.016090151558910932	MEASURED	0.01395187917543703	MEASURED
8589934594	1795899558408512	0.6944	1.7146	0.01446335	0.01694060738369482	MODEL	0.014883430826894204	MEASURED
8589934592	1795899558443569	0.5551	1.743	0.02289685	0.026643842823241642	MEASURED	0.02343111444350798	MEASURED
8589934594	1795899558506877	0.8019	3.8634	0.02385903	0.028329294831119484	MODEL	0.024828742161208048	MEASURED
8589934592	1795899558518243	0.8858	3.5689	0.01715263	0.020893502896131892	MEASURED	0.01814111832130884	MEASURED
8589934594	1795899558559998	0.683	0.5199	0.00488649	0.005311447858986602	MODEL	0.004673669516765263	MEASURED
8589934592	1795899558565046	0.7643	5.9143	0.04097798	0.04754031206533632	MEASURED	0.041417555488840234	MEASURED
8589934592	1795899558650528	0.5273	2.6974	0.03979788	0.04553161496423908	MEASURED	0.04010920011856386	MEASURED
8589934594	1795899558656886	0.6468	1.4282	0.01449933	0.016269603119277536	MODEL	0.014275927902447711	MEASURED
8589934594	1795899558713458	0.6349	4.8327	0.05031391	0.05711302020196402	MODEL	0.05019548284682462	MEASURED
8589934592	1795899558736267	0.8136	3.8194	0.02383372	0.02689046656457276	MEASURED	0.023688939459046095	MEASURED
8589934594	1795899558746379	0.6529	1.0589	0.00997101	0.011839791626480677	MODEL	0.010380346362093156	MEASURED
8589934592	1795899558750792	0.4426	5.8351	0.11678725	0.13407241445068507	MEASURED	0.12027782688444351	MEASURED
4294967296	1795899558349490	0.7084	2.3706	0.01954253	0.025151844929654957	MODEL	0.019585687065626557	MEASURED
4294967296	1795899558441718	0.8235	4.3466	0.02610811	0.03377243970150263	MODEL	0.026256909068663747	MEASURED
4294967296	1795899558519181	0.7519	0.2163	0.00167056	0.0020322376546805495	MODEL	0.0015890979370458784	MEASURED
4294967296	1795899558593840	0.858	4.3956	0.02470618	0.031288748216533595	MODEL	0.02443126469898323	MEASURED
4294967296	1795899558622619	0.8605	5.4795	0.02913828	0.03876087857428049	MODEL	0.03025338705770098	MEASURED
8589934592	1795899558830869	0.879	0.2541	0.00130351	0.0015137448789422484	MEASURED	0.001314878684254427	MEASURED
8589934594	1795899558859608	0.4839	4.7753	0.08072184	0.09456712899313448	MODEL	0.08600993575960486	MEASURED
8589934593	1795899558875914	0.8057	5.9149	0.04530653	0.03989816358352095	MEASURED	0.04379696708752734	MEASURED
8589934592	1795899558901672	0.8381	3.3303	0.01895697	0.021866133402373294	MEASURED	0.01928608804348024	MEASURED
8589934592	1795899558907527	0.49990741968569125	0.9958	0.01699869	0.018259570578987975	MEASURED	0.01670061484164096	MEASURED
8589934594	1795899558936684	0.8142	4.5832	0.02627553	0.03253740873497553	MODEL	0.028468802173936377	MEASURED
8589934592	1795899558957527	0.5999168336744124	1.9909	0.02378295	0.026464411780017516	MEASURED	0.023325566802414096	MEASURED
8589934594	1795899558978715	0.7313	5.9357	0.04724661	0.052762907862991364	MODEL	0.04642898281113552	MEASURED
8589934592	1795899558997939	0.6547	1.4284	0.01407343	0.015597155835601171	MEASURED	0.013930382535213427	MEASURED
8589934593	1795899558998319	0.5393	2.6253	0.04139669	0.04034948531515761	MEASURED	0.043261749312244996	MEASURED
8589934592	1795899559007527	0.69991362902463	3.0143	0.02602562	0.02930277957717373	MEASURED	0.02586468617708627	MEASURED
8589934592	1795899559013119	0.7258	3.2084	0.02659395	0.02878859040255417	MEASURED	0.02513648332526603	MEASURED
8589934593	1795899559040440	0.9407	1.0459	0.00551097	0.004977040154878063	MEASURED	0.005494989677329312	MEASURED
8589934594	1795899559049586	0.5783	2.9512	0.03709833	0.04183376718434598	MODEL	0.037441946353653915	MEASURED
8589934592	1795899559057527	0.799911465283925	0.998	0.00641214	0.007292140944885448	MEASURED	0.006429114360767927	MEASURED
8589934594	1795899559081852	0.5463	5.124	0.07743342	0.08096436438139903	MODEL	0.0717470596275085	MEASURED
8589934592	1795899559105738	0.843	3.3645	0.01854774	0.021806549650506674	MEASURED	0.019227918250200163	MEASURED
8589934592	1795899559107527	0.8998705060328238	2.0269	0.00950632	0.011448647858681524	MEASURED	0.00993188530150767	MEASURED
8589934593	1795899559118573	0.8868	5.8627	0.03854608	0.03220457895220504	MEASURED	0.03535110019217394	MEASURED
8589934593	1795899559160797	0.626	5.4625	0.06910046	0.06296269423377525	MEASURED	0.0683312099278666	MEASURED
8589934592	1795899559200926	0.9503	3.8246	0.01576534	0.018991545454908443	MEASURED	0.01635854351536323	MEASURED
8589934594	1795899559205026	0.6026	2.6458	0.03080396	0.03463561031737036	MODEL	0.030896381578277708	MEASURED
8589934592	1795899559207527	0.4998872559417115	0.9881	0.01765802	0.018119757622809044	MEASURED	0.01657276017798567	MEASURED
8589934594	1795899559212187	0.6331	2.9032	0.03140259	0.034502813951661195	MODEL	0.03033125015909125	MEASURED
8589934593	1795899559213504	0.6421	5.7939	0.06637493	0.06341001790989718	MEASURED	0.06886468785127785	MEASURED
8589934592	1795899559234807	0.803	3.4304	0.02211079	0.02485515231182244	MEASURED	0.02190957714743207	MEASURED
8589934592	1795899559257527	0.5998688557592955	2.0069	0.02419653	0.026681339218724162	MEASURED	0.02351683102973177	MEASURED
8589934593	1795899559299906	0.9134	1.1059	0.00634216	0.005674375838763631	MEASURED	0.006236363605326966	MEASURED
8589934592	1795899559307527	0.6998427504556117	2.9792	0.02600261	0.028967680627013454	MEASURED	0.025569007907880706	MEASURED
8589934592	1795899559310437	0.7706	3.7464	0.02517751	0.029587501410797783	MEASURED	0.02576751023868233	MEASURED
8589934594	1795899559333467	0.9527	5.6175	0.02405903	0.02825961278846055	MODEL	0.024468988592945055	MEASURED
8589934592	1795899559366227	0.7997807033800572	0.9985	0.0059571	0.0072983962113532365	MEASURED	0.006434678544167327	MEASURED
8589934593	1795899559366227	0.3571029195480879	1.0196	0.03105593	0.033107023574995995	MODEL	0.03512478076449244	MODEL
8589934592	1795899559358581	0.6983	5.9939	0.05211143	0.05854927290297574	MEASURED	0.05168445458782764	MEASURED
8589934594	1795899559364024	0.615	2.969	0.03489291	0.03735298507036347	MODEL	0.03326403749250301	MEASURED
8589934593	1795899559364228	0.8726	1.7979	0.01091516	0.010258042647429444	MEASURED	0.011383177135665676	MEASURED
8589934592	1795899559407527	0.899885878071596	2.0177	0.00971205	0.011396239176482727	MEASURED	0.009886410554925487	MEASURED
8589934593	1795899559407527	0.5000233426542909	2.0204	0.04073936	0.035955471540568135	MEASURED	0.038623726008565645	MEASURED
8589934593	1795899559437416	0.8919	0.3007	0.00179401	0.001630176811143235	MEASURED	0.0017898664219289213	MEASURED
8589934592	1795899559457527	0.9998717650780762	2.9793	0.01114044	0.01318730543505659	MEASURED	0.011539412598174655	MEASURED
8589934593	1795899559457527	0.6428275184218117	2.9941	0.03639667	0.03269230266073738	MEASURED	0.0355056826747322	MEASURED
8589934594	1795899559460584	0.8183	1.8746	0.01082354	0.013166487886736074	MODEL	0.011513610932216208	MEASURED
8589934592	1795899559470231	0.4417	3.2108	0.06495148	0.07404790450822017	MEASURED	0.06643349436009865	MEASURED
8589934592	1795899559490909	0.4456	3.0963	0.06027559	0.07027312760438682	MEASURED	0.06302922447613796	MEASURED
8589934592	1795899559507527	0.49981532297120446	0.9935	0.01711388	0.018223729358324746	MEASURED	0.01666793204391501	MEASURED
8589934593	1795899559507527	0.7854817177329012	1.0136	0.00780932	0.007230267842061744	MEASURED	0.00792981924008746	MEASURED
8589934594	1795899559514313	0.8542	4.8602	0.02606159	0.031125075931932093	MODEL	0.027105565252890047	MEASURED
8589934593	1795899559539257	0.7781	5.3309	0.0451736	0.03881980928249972	MEASURED	0.04256212908748759	MEASURED
8589934592	1795899559546635	0.958	5.1145	0.02204294	0.024922496559405486	MEASURED	0.02145662990308576	MEASURED
8589934592	1795899559557527	0.5998118289022337	1.9852	0.02426221	0.02639783359523868	MEASURED	0.023267027562795764	MEASURED
8589934593	1795899559557527	0.9284133453154463	1.9951	0.01167467	0.009791114850734821	MEASURED	0.010803852850174787	MEASURED
8589934594	1795899559589723	0.4756	5.147	0.09515795	0.10519984940774796	MODEL	0.09579593654737495	MEASURED
8589934593	1795899559596475	0.7952	2.2695	0.01675977	0.015757856805970156	MEASURED	0.017289779727334642	MEASURED
8589934592	1795899559607527	0.6997636548402131	3.0055	0.02615812	0.029230292214727196	MEASURED	0.02580092482420112	MEASURED
8589934593	1795899559607527	0.9849890996521736	2.9659	0.01471389	0.012764638922285949	MODEL	0.014556936584765442	MEASURED
8589934592	1795899559616513	0.5208	4.0207	0.06009699	0.06821434958520103	MEASURED	0.06230813351104791	MEASURED
8589934594	1795899559636275	0.9895	5.2704	0.020782	0.024321374998594852	MODEL	0.021068072078137504	MEASURED
8589934593	1795899559642431	0.4604	4.0828	0.08668331	0.08385467796057101	MEASURED	0.09003575520886269	MEASURED
8589934592	1795899559657527	0.799690789454086	1.0133	0.00651993	0.007408391069245829	MEASURED	0.006531690586500343	MEASURED
8589934593	1795899559657527	0.9849643772931185	0.9987	0.0048303	0.004298458972584836	MODEL	0.00490200985620765	MEASURED
8589934592	1795899559675246	0.4835	1.6781	0.02916936	0.0327601290938722	MEASURED	0.029995099749754475	MEASURED
8589934594	1795899559689204	0.6093	0.3924	0.00476923	0.005027389074696465	MODEL	0.004480534704766821	MEASURED
8589934592	1795899559707527	0.899613134269203	1.9933	0.00993243	0.011266207490099392	MEASURED	0.00977377053432189	MEASURED
8589934593	1795899559707527	0.9850100436087109	2.0044	0.01017048	0.008626103159248754	MODEL	0.009837305426825003	MEASURED
8589934593	1795899559708406	0.4605	5.8457	0.11219106	0.12001360703183413	MEASURED	0.128860705319098	MEASURED
8589934592	1795899559751107	0.4894	4.6658	0.08380118	0.08904207044656243	MEASURED	0.08149520755390749	MEASURED
8589934593	1795899559752839	0.6601	1.8242	0.01998262	0.018860597408839046	MEASURED	0.020498924435311212	MEASURED
8589934593	1795899559757527	0.9849004181168654	2.9334	0.01481503	0.012627446251335031	MODEL	0.014400473213269784	MEASURED
8589934594	1795899559786006	0.9031	0.3626	0.0018151	0.00205567943499052	MODEL	0.001789451534261658	MEASURED
8589934592	1795899559807527	0.4996640545618683	1.0085	0.01872688	0.018509439257571245	MEASURED	0.01692941447219503	MEASURED
8589934593	1795899559807527	0.9848267080849956	1.0101	0.00506282	0.004348958454983519	MODEL	0.004959596108803967	MEASURED
4294967296	1795899559228502	0.788	1.3015	0.00817395	0.011095014304173617	MODEL	0.00867539371588139	MEASURED
4294967296	1795899559324288	0.8118	1.0045	0.00640745	0.00804459086856249	MODEL	0.006266209231712319	MEASURED
4294967296	1795899559365411	0.8464	4.0877	0.02247965	0.029958895007589068	MODEL	0.023437140656511042	MEASURED
4294967296	1795899559431578	0.5672	2.1905	0.02827826	0.03591440759831102	MODEL	0.028864255715844576	MEASURED
4294967296	1795899559480369	0.49	0.665	0.01230859	0.014310393084935213	MODEL	0.011534807905249718	MEASURED
4294967296	1795899559587811	0.9324	4.6012	0.02128838	0.02731828421995497	MODEL	0.020886655256361405	MEASURED
4294967296	1795899559631217	0.5146	0.6721	0.01161417	0.01322089597373425	MODEL	0.01061096130013844	MEASURED
8589934592	1795899559844038	0.5912	1.2725	0.01561762	0.01741358013060017	MEASURED	0.015356035323654996	MEASURED
8589934593	1795899559846649	0.5485	1.3643	0.02068631	0.020288316712781307	MEASURED	0.021761868143099536	MEASURED
8589934592	1795899559857527	0.5995710293778906	1.9629	0.02197722	0.026122157918071327	MEASURED	0.023024370335717633	MEASURED
8589934594	1795899559870289	0.8599	5.9443	0.03252415	0.03752236103733814	MODEL	0.03265088843276433	MEASURED
8589934592	1795899559895130	0.9627	5.2995	0.0218788	0.025529663856609954	MEASURED	0.021972708577105395	MEASURED
8589934592	1795899559907527	0.6995897637309175	2.9872	0.02529104	0.029067373520586935	MEASURED	0.025657375036840725	MEASURED
4294967296	1795899559693220	0.615	5.1238	0.06325755	0.0719283241882899	MODEL	0.05708893301543021	MEASURED
4294967296	1795899559794533	0.9084	2.9296	0.01333925	0.018422731755498613	MODEL	0.014122589500444985	MEASURED
4294967296	1795899559852488	0.8624	5.2175	0.02836005	0.03673274652519164	MODEL	0.028661498421548786	MEASURED
\.


--
-- Data for Name: compensations; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, target_pressure_mpa, compensator_whisker_id, compensation_case, pressure_before_mpa, pressure_mpa, predicted_error, decided_us, ended_us, end_reason, predicted_error_low, predicted_error_high, approval) FROM stdin;
4294967296	1	1	70	0.1	1	SELF_COMPENSATION	0.1	0.0239163422454471	0.184925703165943	1795899543174917	\N	\N	0.13341909734883597	0.2739056076242349	AUTOMATIC
8589934592	2	6	70	0.1	7	SHORTER_FOR_LONGER	0.1	0.05610445272379032	0.1911272055555676	1795899543811300	\N	\N	0.12510741372838216	0.3289316991097235	AUTOMATIC
4294967297	1	3	70	0.1	\N	\N	\N	\N	\N	1795899543852206	\N	\N	\N	\N	AUTOMATIC
8589934593	2	8	65	0.1	9	LONGER_FOR_SHORTER	0.1	0.1466952802560571	0.3013531449730227	1795899543894861	\N	\N	0.19401245347417592	0.4923980289681928	AUTOMATIC
8589934594	2	5	70	0.1	5	SELF_COMPENSATION	0.1	0.056097985000166134	0.21038613857336852	1795899544277025	\N	\N	0.1537039353466472	0.3359292292556803	AUTOMATIC
12884901888	3	10	70	0.1	10	SELF_COMPENSATION	0.1	0.039713971776186754	0.19177804042870117	1795899588874412	\N	\N	0.13845347271123884	0.2869920670100256	PROPOSED
\.


--
-- Data for Name: console_sessions; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.console_sessions (session_id, actor, sealed, created_us, expires_us) FROM stdin;
\.


--
-- Data for Name: contact_hours; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contact_hours (whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, temperature_c, compensation_error) FROM stdin;
10	1795896000000000	440	150	0	0.0036760776	0.040565174	-0.1384603	0.23664396	0.009994492	0.7195707	64.08162	0.16470471	68.15122	0.10038712	24	\N
11	1795896000000000	440	150	0	-0.0020059654	0.03909916	-0.12429344	0.14912774	0.00922609	0.7248673	69.99259	0.10002119	69.99381	0.099917285	24	\N
12	1795896000000000	46	150	0	0.003491671	0.037811562	-0.09368931	0.09630834	0.009076049	0.7299878	70	0.100039296	70	0.09987551	24	\N
4	1795896000000000	507	150	13	-0.0016246645	0.03659115	-0.12680139	0.1141201	0.009314768	0.72384125	69.99373	0.09990262	69.99519	0.09944418	24	\N
5	1795896000000000	498	150	30	0.0031951095	0.04538823	-0.113534205	0.21395189	0.009293066	0.7271252	65.89465	0.290342	68.47089	0.0858177	24	0.178357
6	1795896000000000	521	150	0	0.0052106883	0.07154803	-0.13447148	0.965731	0.013836236	0.72354513	45.39461	0.31385285	60.17561	0.09988972	24	0.16848974
7	1795896000000000	542	150	30	-0.0011210119	0.039341692	-0.13056163	0.14367555	0.009891418	0.72747743	66.02376	0.08744393	65.9945	0.083117455	24	\N
8	1795896000000000	521	150	0	0.0043045604	0.07111831	-0.11344243	0.80015427	0.014912012	0.72240746	45.19686	0.26978904	57.136948	0.099929065	24	0.26941675
9	1795896000000000	532	150	31	0.0011202506	0.03744713	-0.114685796	0.11016217	0.010134538	0.72310823	68.05616	0.08961738	68.00537	0.11711697	24	\N
1	1795896000000000	494	150	57	0.004584943	0.04443778	-0.122894146	0.27376696	0.0091686435	0.7318734	62.03972	0.20139275	66.69793	0.072991155	24	0.14657675
2	1795896000000000	150	150	370	0.0021281336	0.03934243	-0.10702925	0.118521444	0.008534067	0.75304866	69.99071	0.09987991	69.99096	0.099911645	24	\N
3	1795896000000000	520	150	0	0.0044793547	0.07444905	-0.12865806	0.8952636	0.013752678	0.7312585	45.344345	0.31642914	60.195786	0.09990448	24	\N
\.


--
-- Data for Name: contact_minutes_20261103; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contact_minutes_20261103 (whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, temperature_c, compensation_error) FROM stdin;
8	1795899480000000	221	150	0	-0.0012075156	0.038475137	-0.10383844	0.1262506	0.010934781	0.71263826	64.99804	0.099971935	64.99751	0.09993962	24	\N
9	1795899480000000	221	150	0	0.0009686853	0.0366612	-0.11357805	0.10061845	0.009991725	0.7169849	67.99777	0.099901445	67.99729	0.09995903	24	\N
6	1795899480000000	222	150	0	0.0009971345	0.0398374	-0.13447148	0.14046137	0.009407843	0.7169164	69.99287	0.09984981	69.99512	0.09988064	24	\N
5	1795899480000000	222	150	0	-0.0016487471	0.035526663	-0.105951846	0.098914176	0.009141392	0.7265465	69.99698	0.0999133	69.99787	0.09991613	24	\N
7	1795899480000000	222	150	0	0.00017767122	0.038540356	-0.13056163	0.108908765	0.010290759	0.7289398	65.99804	0.09997527	65.998276	0.09991613	24	\N
4	1795899480000000	222	150	0	-0.0048471363	0.03726704	-0.11583293	0.09785694	0.009163767	0.7298957	69.99347	0.099856146	69.99667	0.099903226	24	\N
1	1795899480000000	220	150	0	0.00074134336	0.03712648	-0.122894146	0.10121048	0.008952833	0.734476	69.998604	0.09945605	69.99709	0.099895135	24	\N
3	1795899480000000	220	150	0	0.0010929955	0.039603136	-0.10268716	0.12789139	0.008955198	0.73378134	69.99109	0.09992627	69.99358	0.09993081	24	\N
2	1795899480000000	150	150	70	0.0021281336	0.03934243	-0.10702925	0.118521444	0.008534067	0.75304866	69.99071	0.09987991	69.99116	0.099885404	24	\N
10	1795899540000000	440	150	0	0.0036760776	0.040565174	-0.1384603	0.23664396	0.009994492	0.7195707	64.08162	0.16470471	68.15122	0.10038712	24	\N
11	1795899540000000	440	150	0	-0.0020059654	0.03909916	-0.12429344	0.14912774	0.00922609	0.7248673	69.99259	0.10002119	69.99381	0.099917285	24	\N
12	1795899540000000	46	150	0	0.003491671	0.037811562	-0.09368931	0.09630834	0.009076049	0.7299878	70	0.100039296	70	0.09987551	24	\N
4	1795899540000000	285	0	13	0.0025815093	0.035313707	-0.12680139	0.1141201	0.009511865	0.71593857	69.99373	0.09990262	69.99335	0.09887114	24	\N
5	1795899540000000	276	0	30	0.009723785	0.055403687	-0.113534205	0.21395189	0.009497498	0.7279053	65.89465	0.290342	66.61455	0.06867843	24	0.178357
6	1795899540000000	299	0	0	0.010452969	0.09738538	-0.094915465	0.965731	0.019345807	0.73179233	45.39461	0.31385285	47.9587	0.099901006	24	0.16848974
7	1795899540000000	320	0	30	-0.002630731	0.040261026	-0.11409387	0.14367555	0.009427185	0.72577745	66.02376	0.08744393	65.990486	0.065262854	24	\N
8	1795899540000000	300	0	0	0.011121161	0.09704323	-0.11344243	0.80015427	0.01983052	0.73448867	45.19686	0.26978904	47.41605	0.099916	24	0.26941675
9	1795899540000000	311	0	31	0.0013010568	0.038422223	-0.114685796	0.11016217	0.010304902	0.7304129	68.05616	0.08961738	68.01413	0.13572982	24	\N
1	1795899540000000	274	0	57	0.0097752055	0.052353922	-0.120357275	0.27376696	0.009460067	0.7283589	62.03972	0.20139275	63.010033	0.04291722	24	0.14657675
2	1795899540000000	0	0	300	\N	\N	\N	\N	\N	\N	69.99071	0.09987991	69.99071	0.099944	24	\N
3	1795899540000000	300	0	0	0.008655865	0.102147855	-0.12865806	0.8952636	0.01966957	0.728147	45.344345	0.31642914	48.11183	0.099872	24	\N
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
-- Data for Name: contacts_20261128; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contacts_20261128 (whisker_id, boot, seq, "position", t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm, place, distance_mm) FROM stdin;
11	3	23	6	1795899568455290	1795899568570536	0.8066	4.8946	0.03024026	0.1008	24	LEARNING	-0.03561853952703292	69.99514713985636	0.099945116059535	RATIO	\N
11	3	23	8	1795899568505050	1795899568570536	0.7141	2.4331	0.01942267	0.0996	24	LEARNING	-0.03618242535250734	69.99506311758942	0.09994516419903558	RATIO	\N
11	3	24	0	1795899568581310	1795899568860938	0.7725	4.166	0.02981398	0.0996	24	LEARNING	0.021590547280822093	69.99513326549572	0.0999454252032448	RATIO	\N
11	3	24	3	1795899568700756	1795899568860938	0.9028	4.865	0.02368663	0.0996	24	LEARNING	-0.019579529377126377	69.99508136564334	0.09994553557365878	RATIO	\N
11	3	24	5	1795899568761234	1795899568860938	0.4618	3.596	0.06412995	0.1008	24	LEARNING	-0.08647308525773259	69.99496657017984	0.0999455122662122	RATIO	\N
11	3	24	7	1795899568821153	1795899568860938	0.8546	3.432	0.01928043	0.0996	24	LEARNING	0.00020669163218385057	69.99496744919783	0.09994566397933084	RATIO	\N
11	3	24	9	1795899568852997	1795899568860938	0.7243	4.0375	0.03210589	0.0996	24	LEARNING	-0.009002863884041822	69.99494105981948	0.09994580492974543	RATIO	\N
11	3	25	0	1795899568920394	1795899569216761	0.5322	2.8391	0.04333049	0.0996	24	LEARNING	0.026775910755323467	69.99496565245654	0.09994604038938609	RATIO	\N
11	3	25	2	1795899568978152	1795899569216761	0.8399	4.0084	0.02476019	0.1008	24	LEARNING	0.053895011516274204	69.99507168930036	0.09994632993232094	RATIO	\N
11	3	25	4	1795899569042162	1795899569216761	0.6391	1.289	0.01398798	0.1008	24	LEARNING	0.04179121642672113	69.99513259120685	0.09994660012741154	RATIO	\N
11	3	25	7	1795899569122355	1795899569216761	0.8611	3.4904	0.01891272	0.0996	24	LEARNING	-0.019838982819607543	69.99507792239292	0.09994670099886115	RATIO	\N
11	3	25	9	1795899569210016	1795899569216761	0.8382	4.27	0.02640271	0.0996	24	LEARNING	0.052963135663510616	69.99520212498854	0.09994699959288222	RATIO	\N
11	3	26	1	1795899569276967	1795899569570906	0.5919	3.9622	0.04589744	0.0996	24	LEARNING	-0.04390179416131612	69.99510283592538	0.09994700936678554	RATIO	\N
11	3	26	2	1795899569311181	1795899569570906	0.6452	3.8326	0.0389534	0.0996	24	LEARNING	-0.002178553534200113	69.99509712331613	0.09994717960302701	RATIO	\N
11	3	26	5	1795899569417032	1795899569570906	0.4918	1.165	0.01980144	0.1008	24	LEARNING	-0.016843449049945457	69.99508154694747	0.09994735815466853	RATIO	\N
11	3	26	7	1795899569489085	1795899569570906	0.9349	3.6814	0.01764611	0.0996	24	LEARNING	0.04342716884949307	69.99512735018993	0.09994760695579785	RATIO	\N
11	3	26	8	1795899569548219	1795899569570906	0.9494	3.1001	0.01365897	0.1008	24	LEARNING	-0.009767446319355394	69.99510993123423	0.0999477884675982	RATIO	\N
11	3	27	0	1795899569615082	1795899569900378	0.7308	2.1911	0.01766716	0.0996	24	LEARNING	0.022306141187697553	69.99512531357291	0.09994801088351961	RATIO	\N
11	3	27	3	1795899569645769	1795899569900378	0.7881	4.5777	0.03148545	0.1008	24	LEARNING	0.021251343113474572	69.99515707441564	0.09994825650817604	RATIO	\N
11	3	27	5	1795899569712128	1795899569900378	0.7109	1.3432	0.01014606	0.0996	24	LEARNING	-0.1010742172039968	69.99521983527664	0.09994857950276623	RATIO	\N
11	3	27	6	1795899569801447	1795899569900378	0.5152	4.6365	0.07149003	0.1008	24	LEARNING	-0.025883401498651367	69.99513739475124	0.09994858527835579	RATIO	\N
11	3	27	8	1795899569876653	1795899569900378	0.5942	3.2034	0.03912339	0.1008	24	LEARNING	0.01664075245341245	69.99518349290452	0.09994881221099113	RATIO	\N
11	3	28	0	1795899569921659	1795899570209491	0.5643	4.3002	0.05704512	0.0996	24	LEARNING	-0.0003414051066393301	69.99518278041901	0.09994899510161434	RATIO	\N
11	3	28	2	1795899569983703	1795899570209491	0.6973	0.5928	0.00521181	0.0996	24	LEARNING	0.01262919878179461	69.9951911876465	0.09994920763368102	RATIO	\N
11	3	28	4	1795899570068209	1795899570209491	0.7941	4.5999	0.0302687	0.0996	24	LEARNING	-0.004238623636723488	69.9951821000183	0.09994938980051535	RATIO	\N
11	3	28	7	1795899570124141	1795899570209491	0.5534	5.1207	0.0703172	0.0996	24	LEARNING	-0.0036905986478938373	69.99517954851562	0.09994959237478314	RATIO	\N
11	3	28	9	1795899570202393	1795899570209491	0.4913	1.2872	0.01960957	0.0996	24	LEARNING	-0.1242934416555343	69.99525046555515	0.09994992135742209	RATIO	\N
11	3	29	0	1795899570283986	1795899570555196	0.9417	5.5854	0.02726833	0.1008	24	LEARNING	0.07183408883054136	69.99568024628148	0.09995026318584792	RATIO	\N
11	3	29	3	1795899570361670	1795899570555196	0.6219	2.9882	0.03168647	0.0996	24	LEARNING	-0.0310692723431294	69.99552029666287	0.09995003637008805	RATIO	\N
11	3	29	5	1795899570427705	1795899570555196	0.9338	3.1696	0.01450475	0.0996	24	LEARNING	-0.008410371173677102	69.99545939696544	0.09994991101765463	RATIO	\N
11	3	29	6	1795899570436628	1795899570555196	0.9947	0.4939	0.00200144	0.0996	24	LEARNING	0.019580208091673122	69.99550912652816	0.09995010969605395	RATIO	\N
11	3	29	8	1795899570507115	1795899570555196	0.7844	2.6129	0.0176647	0.0996	24	LEARNING	-0.0024719263769257213	69.99549591060033	0.09995015783077582	RATIO	\N
10	3	23	7	1795899568467031	1795899568570536	0.8741	5.3472	0.02766545	0.0996	24	LEARNING	-0.015831809640826436	69.99227061434665	0.09991956991319773	RATIO	\N
10	3	23	9	1795899568566954	1795899568570536	0.9691	4.3175	0.01822958	0.0996	24	LEARNING	0.01914430440804898	69.9917789497304	0.09991539312329381	RATIO	\N
10	3	24	1	1795899568608443	1795899568860938	0.5858	0.8135	0.01029763	0.0996	24	LEARNING	0.031178165407807067	69.99146399572987	0.09991412449804278	RATIO	\N
10	3	24	2	1795899568671670	1795899568860938	0.6427	4.4599	0.04635137	0.0996	24	LEARNING	0.022717167550938066	69.99115151505892	0.09991247496434388	RATIO	\N
10	3	24	4	1795899568743783	1795899568860938	0.8996	1.4914	0.00716484	0.0996	24	LEARNING	-0.02821331111294727	69.99179836058117	0.09991042041321872	RATIO	\N
10	3	24	6	1795899568816977	1795899568860938	0.8635	5.8821	0.03113896	0.0996	24	LEARNING	-0.019767677490594864	69.99223214479683	0.09990839510693753	RATIO	\N
10	3	24	8	1795899568848324	1795899568860938	0.8203	0.3679	0.0021331	0.0996	24	LEARNING	-0.0466464942772934	69.99260952466096	0.09990812460664455	RATIO	\N
10	3	25	1	1795899568953921	1795899569216761	0.9157	1.5463	0.00725905	0.0996	24	LEARNING	-0.009041652219809978	69.99282899455335	0.0999050002578537	RATIO	\N
10	3	25	3	1795899569033257	1795899569216761	0.9292	1.5908	0.00748338	0.0996	24	LEARNING	0.027275813531259352	69.99213586305167	0.09990051048710927	RATIO	\N
10	3	25	5	1795899569075612	1795899569216761	0.5173	1.847	0.02863594	0.0996	24	LEARNING	-0.007625267976275064	69.99222374963774	0.09989955840819945	RATIO	\N
10	3	25	6	1795899569118559	1795899569216761	0.4467	1.7788	0.03469455	0.0996	24	LEARNING	-0.052131417249686306	69.99268706971128	0.0998996431730095	RATIO	\N
10	3	25	8	1795899569201628	1795899569216761	0.794	3.8333	0.02615726	0.1008	24	LEARNING	0.043690302104581864	69.99172234479511	0.09989595278988939	RATIO	\N
10	3	26	0	1795899569254437	1795899569570906	0.5005	3.2086	0.04988837	0.0996	24	LEARNING	-0.06491572223514967	69.99240073212833	0.09989631234437692	RATIO	\N
10	3	26	3	1795899569330694	1795899569570906	0.9418	0.9543	0.00420382	0.1008	24	LEARNING	-0.01172330751325019	69.99262794165993	0.09989420196119271	RATIO	\N
10	3	26	4	1795899569410567	1795899569570906	0.8225	4.9433	0.03064036	0.1008	24	LEARNING	0.025205637599565067	69.99209938172515	0.09989111501638452	RATIO	\N
10	3	26	6	1795899569475132	1795899569570906	0.9156	0.2422	0.00109544	0.0996	24	LEARNING	-0.04288124981306819	69.9922748631096	0.09989110032338082	RATIO	\N
10	3	26	9	1795899569555046	1795899569570906	0.6602	2.7026	0.02586559	0.0996	24	LEARNING	-0.005278455923569233	69.99235821998963	0.09988958420951281	RATIO	\N
10	3	27	1	1795899569627219	1795899569900378	0.5627	4.3805	0.05577027	0.0996	24	LEARNING	-0.03819911653235984	69.99286368568401	0.09988915973621305	RATIO	\N
10	3	27	2	1795899569643413	1795899569900378	0.9975	0.9315	0.0035649	0.0996	24	LEARNING	-0.012577528873410225	69.99315796972957	0.09988610692614551	RATIO	\N
10	3	27	4	1795899569711053	1795899569900378	0.8722	4.872	0.02543647	0.0996	24	LEARNING	-0.013023537055341494	69.99349281985904	0.09988305569258397	RATIO	\N
10	3	27	7	1795899569817611	1795899569900378	0.8957	5.2763	0.02624822	0.0996	24	LEARNING	-0.0005291098357710976	69.99350717973789	0.09987916144629512	RATIO	\N
10	3	27	9	1795899569877913	1795899569900378	0.4979	1.4439	0.02290101	0.0996	24	LEARNING	-0.053610738232716615	69.99414416455983	0.09987904663783918	RATIO	\N
10	3	28	1	1795899569961271	1795899570209491	0.7468	4.0899	0.03087229	0.1008	24	LEARNING	0.01328802134446801	69.99386512092609	0.09987612048313296	RATIO	\N
10	3	28	3	1795899570028730	1795899570209491	0.4481	0.736	0.01500783	0.0996	24	LEARNING	0.003937305777616481	69.9938329308439	0.09987542811040119	RATIO	\N
10	3	28	5	1795899570101131	1795899570209491	0.895	5.5568	0.02695917	0.0996	24	LEARNING	-0.02801800772066922	69.99465147859013	0.09987238058348746	RATIO	\N
10	3	28	6	1795899570118831	1795899570209491	0.8447	2.0367	0.0122614	0.0996	24	LEARNING	0.057141796271196116	69.99315362568005	0.09986731376484585	RATIO	\N
10	3	28	8	1795899570191248	1795899570209491	0.8741	0.6739	0.00349975	0.0996	24	LEARNING	-0.014082970902151845	69.99338447689114	0.0998656374890075	RATIO	\N
10	3	29	1	1795899570301042	1795899570555196	0.514	3.4335	0.05265728	0.0996	24	LEARNING	-0.025475543651706435	69.993705768247	0.0998649088741778	RATIO	\N
10	3	29	2	1795899570331833	1795899570555196	0.6884	3.5601	0.03110087	0.0996	24	LEARNING	-0.009046413234202948	69.99388330042517	0.0998628116601482	RATIO	\N
10	3	29	4	1795899570425991	1795899570555196	0.6779	1.7468	0.01669025	0.1008	24	LEARNING	0.04569889216501566	69.9930345835503	0.09985968909762045	RATIO	\N
10	3	29	7	1795899570452916	1795899570555196	0.7276	1.843	0.0150866	0.1008	24	LEARNING	0.03764584427216384	69.99229669054122	0.09985654028603384	RATIO	\N
10	3	29	9	1795899570541602	1795899570555196	0.59	2.583	0.03381753	0.1008	24	LEARNING	0.08038793599936273	69.9911024638607	0.09985397761928133	RATIO	\N
10	3	74	2	1795899585309449	1795899585555761	0.574	5.4194	0.07096707	0.1008	24	USED	0.02348985437423213	69.98535654127497	0.09973700607599928	RATIO	\N
10	3	74	5	1795899585426284	1795899585555761	0.5027	2.2559	0.0370733	0.1008	24	USED	-0.006424959136604649	69.98537799635295	0.09973714202085203	RATIO	\N
10	3	74	6	1795899585471353	1795899585555761	0.5893	5.7081	0.0710637	0.1008	24	USED	0.024680882912296233	69.98526792852198	0.09973705021856896	RATIO	\N
10	3	74	8	1795899585504047	1795899585555761	0.8357	0.274	0.00166588	0.1008	24	USED	0.03976267026497787	69.98522212001949	0.099737165116251	RATIO	\N
10	3	75	0	1795899585574553	1795899585856870	0.7964	2.0746	0.01357232	0.0996	24	USED	0.0070909373128664865	69.98516411089618	0.0997369168946086	RATIO	\N
10	3	75	3	1795899585701498	1795899585856870	0.6319	3.8038	0.04231567	0.1008	24	USED	0.050623538531939724	69.98489479480156	0.09973655893156978	RATIO	\N
10	3	75	5	1795899585735706	1795899585856870	0.5031	4.0019	0.06587021	0.0996	24	USED	-0.0017091002002637956	69.98490066086792	0.09973667316773006	RATIO	\N
10	3	75	7	1795899585819538	1795899585856870	0.7363	0.3719	0.00279387	0.1008	24	USED	-0.025758948739471973	69.98495557379077	0.09973689471496464	RATIO	\N
10	3	75	8	1795899585843342	1795899585856870	0.8113	0.2871	0.00186812	0.1008	24	USED	0.04125820657960627	69.98490411940311	0.09973699620662205	RATIO	\N
10	3	76	0	1795899585917409	1795899586200126	0.83	4.903	0.02867087	0.0996	24	USED	-0.013328341355157421	69.98502335240646	0.09973694993193913	RATIO	\N
10	3	76	2	1795899586008829	1795899586200126	0.6874	3.6142	0.03116289	0.1008	24	USED	-0.032101013384682846	69.98521892829436	0.09973719975490433	RATIO	\N
10	3	76	4	1795899586082334	1795899586200126	0.8759	5.3992	0.02773806	0.1008	24	USED	-0.024831274417093752	69.9854520743198	0.0997372898173572	RATIO	\N
10	3	76	6	1795899586131234	1795899586200126	0.7155	0.7872	0.00652374	0.1008	24	USED	0.011124380361892538	69.98539861429495	0.09973724888625293	RATIO	\N
10	3	76	9	1795899586196009	1795899586200126	0.8767	4.4523	0.02348355	0.1008	24	USED	0.0034148317726941696	69.98536608286174	0.09973695794565543	RATIO	\N
10	3	77	1	1795899586265864	1795899586569010	0.99	5.7086	0.02428156	0.1008	24	USED	0.07134400184806905	69.98444059879331	0.09973509549934706	RATIO	\N
10	3	77	2	1795899586333006	1795899586569010	0.9217	0.4557	0.00221759	0.1008	24	USED	0.036555714614979785	69.98430539003267	0.09973497457442589	RATIO	\N
10	3	77	5	1795899586409759	1795899586569010	0.6911	1.0801	0.00925542	0.1008	24	USED	-0.027809823367817833	69.98445319547862	0.09973519117053693	RATIO	\N
10	3	77	7	1795899586452499	1795899586569010	0.4921	2.0294	0.03593818	0.1008	24	USED	0.028721151295061587	69.98436387098484	0.09973518425734668	RATIO	\N
10	3	77	9	1795899586550641	1795899586569010	0.594	5.2555	0.06449163	0.1008	24	USED	0.02534661714781	69.98425220177947	0.09973509606481958	RATIO	\N
10	3	78	0	1795899586574751	1795899586906986	0.6606	5.3298	0.05158088	0.1008	24	USED	0.0017132448084606318	69.98424317362057	0.099735111434201	RATIO	\N
10	3	78	2	1795899586666367	1795899586906986	0.9075	3.8531	0.0194043	0.1008	24	USED	0.03474541289632816	69.98388920858682	0.09973431824060942	RATIO	\N
10	3	78	4	1795899586704008	1795899586906986	0.5447	4.0308	0.05497394	0.1008	24	USED	-0.03898425322049336	69.98403847456036	0.09973462047056264	RATIO	\N
10	3	78	6	1795899586772402	1795899586906986	0.4799	4.4864	0.07674429	0.0996	24	USED	-0.05118936794061558	69.98418024336266	0.09973495141485078	RATIO	\N
10	3	78	9	1795899586902172	1795899586906986	0.8332	4.0592	0.02437317	0.1008	24	USED	0.017883578834490516	69.98403326645378	0.09973460207014906	RATIO	\N
10	3	79	0	1795899586935190	1795899587190748	0.8785	2.0696	0.01046971	0.1008	24	USED	-0.03552151271007753	69.98435644272801	0.09973482778981407	RATIO	\N
10	3	79	3	1795899587031813	1795899587190748	0.9857	1.1865	0.00494211	0.1008	24	USED	0.03734434463957483	69.98396506717906	0.09973390438279792	RATIO	\N
10	3	79	5	1795899587092842	1795899587190748	0.7491	1.1641	0.0090194	0.1008	24	USED	0.04097791900612679	69.9837243930227	0.09973355900369732	RATIO	\N
10	3	79	7	1795899587158147	1795899587190748	0.5654	4.5673	0.05785409	0.1008	24	USED	-0.039673526888092045	69.98388508305007	0.09973386587635082	RATIO	\N
10	3	79	8	1795899587171105	1795899587190748	0.6225	1.1176	0.01245323	0.1008	24	USED	0.021420358832944308	69.98378815184678	0.09973378152053489	RATIO	\N
10	3	80	1	1795899587288576	1795899587541961	0.4949	4.7042	0.09683337	0.1008	24	USED	0.19119330911405047	69.9837663622033	0.09973395225102401	RATIO	\N
10	3	80	2	1795899587310131	1795899587541961	0.7553	4.6476	0.03922084	0.1008	24	USED	0.1449650828866259	69.98364905814694	0.09973396246214976	RATIO	\N
10	3	80	4	1795899587409196	1795899587541961	0.6727	0.5184	0.00582413	0.1008	24	USED	0.1868004035800588	69.98354955276876	0.09973400857337066	RATIO	\N
10	3	80	7	1795899587493252	1795899587541961	0.507	3.073	0.0633088	0.1008	24	USED	0.2366439517747015	69.983548781844	0.09973420848705886	RATIO	\N
10	3	80	9	1795899587524880	1795899587541961	0.7858	1.1273	0.00885866	0.1008	24	USED	-0.0373243169100639	64.38337124885436	0.6696996339951273	RATIO	\N
10	3	81	0	1795899587604424	1795899587901861	0.495	3.2823	0.06320404	0.1008	24	USED	-0.0316702892047858	64.58513738138646	0.6098906006941698	RATIO	\N
10	3	81	3	1795899587693135	1795899587901861	0.4849	2.5035	0.05241632	0.1008	24	USED	0.019943316331211804	64.48147896265124	0.5651380547613521	RATIO	\N
10	3	81	5	1795899587737446	1795899587901861	0.645	4.6959	0.05651816	0.1008	24	USED	0.006062380765228483	64.44392839495046	0.5115005316112574	RATIO	\N
10	3	81	6	1795899587772028	1795899587901861	0.8484	5.5015	0.03854556	0.1008	24	USED	0.030045550608192164	64.24572424323068	0.45410527130300643	RATIO	\N
10	3	81	9	1795899587900409	1795899587901861	0.6485	5.3726	0.06511639	0.1008	24	USED	0.016600353356258656	64.17670392004645	0.4267095492163131	RATIO	\N
10	3	82	0	1795899587905151	1795899588245110	0.4974	3.4427	0.06472174	0.1008	24	USED	-0.05250463726926315	64.31837826381567	0.41244898590867635	RATIO	\N
10	3	82	2	1795899587981192	1795899588245110	0.8248	5.2987	0.03827565	0.1008	24	USED	-0.004666574731034178	64.3387052191423	0.385022552171702	RATIO	\N
10	3	82	5	1795899588074639	1795899588245110	0.5329	0.6602	0.01157797	0.1008	24	USED	0.009823943033774294	64.32024481097122	0.37568973609862577	RATIO	\N
10	3	82	6	1795899588116989	1795899588245110	0.75	4.5464	0.03943904	0.1008	24	USED	-0.02153415676535745	64.39121759375935	0.35828542063386903	RATIO	\N
10	3	82	8	1795899588200475	1795899588245110	0.7196	0.6494	0.00628523	0.1008	24	USED	0.003967707776630539	64.38283015686395	0.34777650064009924	RATIO	\N
10	3	83	1	1795899588302181	1795899588546803	0.5066	2.1886	0.0407439	0.0996	24	USED	-0.02180537178581469	64.4206110268436	0.34064003425203615	RATIO	\N
10	3	83	3	1795899588355011	1795899588546803	0.5506	5.4949	0.08996214	0.1008	24	USED	0.006329694492077643	64.40891039768493	0.33305265607756784	RATIO	\N
10	3	83	5	1795899588434639	1795899588546803	0.5024	0.8852	0.01661083	0.1008	24	USED	-0.029819489797275563	64.44985749422354	0.32780422840933904	RATIO	\N
10	3	83	7	1795899588480822	1795899588546803	0.9824	0.6707	0.0034101	0.1008	24	USED	0.03333214235788258	64.37461599881165	0.31640017275406146	RATIO	\N
10	3	83	8	1795899588510438	1795899588546803	0.6015	4.3688	0.06176582	0.1008	24	USED	0.027237042076100712	64.32709375388319	0.3097216006957609	RATIO	\N
10	3	84	1	1795899588628841	1795899588874412	0.7116	4.4729	0.04657549	0.1008	24	USED	0.05346661342910398	64.21899141508636	0.30171319410025504	RATIO	\N
10	3	84	3	1795899588689904	1795899588874412	0.5047	3.5573	0.06765763	0.1008	24	USED	-0.01236770373238511	64.234148701888	0.2977105765682474	RATIO	\N
10	3	84	5	1795899588744763	1795899588874412	0.5903	2.6321	0.03760896	0.1008	24	USED	-0.00315461248959365	64.23870352542865	0.29279748514565807	RATIO	\N
10	3	84	7	1795899588823382	1795899588874412	0.6801	0.4835	0.00533534	0.1008	24	USED	0.01612438460708125	64.22254701495402	0.28931062888180914	RATIO	\N
10	3	84	8	1795899588847970	1795899588874412	0.8656	5.3082	0.036424	0.1008	24	USED	0.044470625212536766	64.12743189133924	0.2810746597909039	RATIO	\N
11	3	78	7	1795899586832208	1795899586906986	0.5545	1.9898	0.0248065	0.0996	24	USED	-0.09036803547709459	69.9929751914056	0.09998412604894107	RATIO	\N
11	3	78	8	1795899586863311	1795899586906986	0.8407	4.6638	0.02835406	0.0996	24	USED	0.04472144907228444	69.99307460680441	0.09998443918541185	RATIO	\N
11	3	79	1	1795899586965219	1795899587190748	0.6405	2.1592	0.02212606	0.0996	24	USED	-0.0018801936899563731	69.99307272048078	0.09998463148470893	RATIO	\N
11	3	79	2	1795899587015430	1795899587190748	0.5326	4.8542	0.07743587	0.0996	24	USED	0.07528054845321086	69.99314727257178	0.09998492621992021	RATIO	\N
11	3	79	4	1795899587074272	1795899587190748	0.4808	3.256	0.05785018	0.1008	24	USED	-0.008762922347066325	69.99313733065874	0.09998510156488763	RATIO	\N
11	3	79	6	1795899587120638	1795899587190748	0.6939	1.5564	0.01430892	0.0996	24	USED	0.05352087283135487	69.99319977192579	0.0999853791956311	RATIO	\N
11	3	79	9	1795899587184539	1795899587190748	0.8694	4.8416	0.02631807	0.0996	24	USED	0.0065900013531042315	69.99321408081772	0.09998557209906768	RATIO	\N
11	3	80	0	1795899587250320	1795899587541961	0.8659	3.2243	0.0170881	0.0996	24	USED	-0.025382373232606545	69.99316564489672	0.0999856819022518	RATIO	\N
11	3	80	3	1795899587326336	1795899587541961	0.6976	3.8169	0.03519716	0.1008	24	USED	0.06165529487093471	69.99328409497049	0.09998602755492865	RATIO	\N
11	3	80	5	1795899587414379	1795899587541961	0.8647	5.3083	0.02844437	0.1008	24	USED	-0.02374418809523838	69.99322010952854	0.0999860986630129	RATIO	\N
11	3	80	6	1795899587449527	1795899587541961	0.5671	3.5591	0.04819568	0.0996	24	USED	0.03340930938994646	69.9932486300535	0.09998633393285696	RATIO	\N
11	3	80	8	1795899587520744	1795899587541961	0.6342	0.238	0.00256837	0.0996	24	USED	0.02975283878308972	69.99325646208513	0.09998654553423494	RATIO	\N
11	3	81	1	1795899587606069	1795899587901861	0.4663	4.678	0.08685008	0.0996	24	USED	-0.023100312490992238	69.99323095947778	0.09998669888205933	RATIO	\N
11	3	81	2	1795899587676506	1795899587901861	0.6761	2.4181	0.02311759	0.0996	24	USED	0.037480421449596416	69.99327536305903	0.0999869510300985	RATIO	\N
11	3	81	4	1795899587726999	1795899587901861	0.9873	5.6334	0.02244088	0.1008	24	USED	-0.016706127291744227	69.99324919686869	0.09998710343816784	RATIO	\N
11	3	81	7	1795899587792307	1795899587901861	0.9146	4.0801	0.01811492	0.1008	24	USED	-0.0831614735276674	69.99306515125126	0.0999870160369302	RATIO	\N
11	3	81	8	1795899587850329	1795899587901861	0.9568	1.8241	0.00780351	0.0996	24	USED	-0.00971917706394341	69.99305608885315	0.09998719819194851	RATIO	\N
11	3	82	1	1795899587965564	1795899588245110	0.5017	4.5047	0.08670537	0.0996	24	USED	0.1491277340285568	69.9931733623339	0.09998755886308018	RATIO	\N
11	3	82	3	1795899588023493	1795899588245110	0.533	3.0448	0.04616959	0.0996	24	USED	0.02651598582616334	69.99319229944335	0.09998778058389296	RATIO	\N
11	3	82	4	1795899588044571	1795899588245110	0.8001	3.4302	0.02141911	0.0996	24	USED	-0.035082193388121706	69.99312900261434	0.09998786938397347	RATIO	\N
11	3	82	7	1795899588153063	1795899588245110	0.9017	2.3157	0.01185472	0.0996	24	USED	0.03352423170499843	69.99317825639343	0.09998812837412986	RATIO	\N
11	3	82	9	1795899588226050	1795899588245110	0.4653	5.7724	0.11413067	0.0996	24	USED	0.03280162857873206	69.99321567584406	0.09998837064430197	RATIO	\N
11	3	83	0	1795899588273340	1795899588546803	0.9664	4.7202	0.02013683	0.0996	24	USED	0.007630036206532986	69.99322442506319	0.09998857796710915	RATIO	\N
11	3	83	2	1795899588316770	1795899588546803	0.8496	0.3254	0.00185879	0.0996	24	USED	0.008504655358786242	69.99322991089544	0.09998878067754999	RATIO	\N
11	3	83	4	1795899588390283	1795899588546803	0.7635	3.7833	0.02767978	0.0996	24	USED	0.02191002058597957	69.99326765885156	0.09998901784554368	RATIO	\N
11	3	83	6	1795899588442152	1795899588546803	1	1.7186	0.006583	0.0996	24	USED	-0.015454201775104376	69.99326467708721	0.0999892141579393	RATIO	\N
11	3	83	9	1795899588530390	1795899588546803	0.9661	1.2149	0.00479285	0.0996	24	USED	-0.06680603758205021	69.99321952845409	0.09998934530329967	RATIO	\N
11	3	84	0	1795899588581056	1795899588874412	0.7234	1.8725	0.01514297	0.0996	24	USED	0.011132187372378527	69.99323359239227	0.09998955456571365	RATIO	\N
11	3	84	2	1795899588658775	1795899588874412	0.9347	5.5406	0.0242991	0.0996	24	USED	-0.04353874931107858	69.99316264734942	0.09998963811718403	RATIO	\N
11	3	84	4	1795899588737403	1795899588874412	0.8572	2.5021	0.01327363	0.0996	24	USED	-0.044450643777115	69.99308998156609	0.09998971924782536	RATIO	\N
11	3	84	6	1795899588776984	1795899588874412	0.7545	1.7738	0.01307239	0.1008	24	USED	0.004911273656491848	69.99309862586054	0.09998990970640385	RATIO	\N
11	3	84	9	1795899588856151	1795899588874412	0.7195	2.5415	0.02186154	0.0996	24	USED	0.06053911827808729	69.99317857366702	0.09999021206705701	RATIO	\N
12	4	21	4	1795899584200479	1795899584565547	0.5068042857142857	1.2672	0.02121754	0.0996	24	LEARNING	0.038998681906434275	70	0.10002386114478397	DISTANCE	35.4763
12	4	21	5	1795899584537950	1795899584565547	0.6579071428571428	3.153	0.03215729	0.0996	24	LEARNING	0.048857956854128456	70	0.10002406164032418	DISTANCE	46.0535
12	4	22	0	1795899584587342	1795899585598944	0.71135	0.6299	0.00510842	0.0996	24	LEARNING	-0.018953832727831528	70	0.10002426213546252	DISTANCE	49.7945
12	4	22	1	1795899584843205	1795899585598944	0.7440085714285714	0.2939	0.00228631	0.0996	24	LEARNING	0.03572502304021543	70	0.10002446263019896	DISTANCE	52.0806
12	4	22	2	1795899585017439	1795899585598944	0.6049157142857142	3.7958	0.04368624	0.1008	24	LEARNING	-0.000700479288264864	70	0.10002466312453352	DISTANCE	42.3441
12	4	22	3	1795899585352186	1795899585598944	0.5897600000000001	0.4796	0.00587908	0.1008	24	LEARNING	0.015017784829437792	70	0.1000248636184662	DISTANCE	41.2832
12	4	22	4	1795899585394035	1795899585598944	0.8396371428571429	2.8221	0.01602128	0.1008	24	LEARNING	-0.027122886621060292	70	0.100025064111997	DISTANCE	58.7746
12	4	23	0	1795899585761722	1795899586770621	0.5479414285714286	3.2753	0.04469292	0.1008	24	LEARNING	-0.022333842459192413	70	0.10002526460512594	DISTANCE	38.3559
12	4	23	1	1795899585838772	1795899586770621	0.82464	4.3982	0.02531524	0.0996	24	LEARNING	-0.050153380868352644	70	0.100025465097853	DISTANCE	57.7248
12	4	23	2	1795899586127975	1795899586770621	0.5864214285714286	3.8393	0.04451582	0.0996	24	LEARNING	-0.05167149468491518	70	0.10002566559017818	DISTANCE	41.0495
12	4	23	3	1795899586261120	1795899586770621	0.8283671428571429	2.33	0.01468997	0.0996	24	LEARNING	0.05242868545504706	70	0.10002586608210151	DISTANCE	57.9857
12	4	23	4	1795899586501843	1795899586770621	0.8640257142857143	4.812	0.02757906	0.0996	24	LEARNING	0.0486903286918982	70	0.10002606657362298	DISTANCE	60.4818
12	4	23	5	1795899586666995	1795899586770621	0.6498128571428571	2.9835	0.03092324	0.1008	24	LEARNING	0.03822201575396599	70	0.10002626706474256	DISTANCE	45.4869
12	4	24	0	1795899586859649	1795899587861490	0.85844	2.5049	0.01430633	0.1008	24	LEARNING	0.02708658133382919	70	0.1000264675554603	DISTANCE	60.0908
12	4	24	1	1795899587046114	1795899587861490	0.5177128571428571	2.3379	0.03613165	0.0996	24	LEARNING	-0.0029242756580948673	70	0.10002666804577616	DISTANCE	36.2399
12	4	24	2	1795899587250038	1795899587861490	0.8244357142857144	2.6544	0.01599584	0.0996	24	LEARNING	-0.00539049055823672	70	0.10002686853569018	DISTANCE	57.7105
12	4	24	3	1795899587524104	1795899587861490	0.6826785714285715	0.8902	0.00778517	0.0996	24	LEARNING	-0.029396923243646796	70	0.10002706902520234	DISTANCE	47.7875
12	4	24	4	1795899587669340	1795899587861490	0.7346942857142857	4.9894	0.04003123	0.0996	24	LEARNING	0.034922243524948667	70	0.10002726951431266	DISTANCE	51.4286
12	4	24	5	1795899587770438	1795899587861490	0.5865714285714286	3.1085	0.04024638	0.0996	24	LEARNING	0.05939893879553707	70	0.10002747000302112	DISTANCE	41.06
12	4	25	0	1795899588064452	1795899589070115	0.4980085714285714	0.6972	0.01155979	0.0996	24	LEARNING	-0.00510809733908438	70	0.10002767049132774	DISTANCE	34.8606
12	4	25	1	1795899588368579	1795899589070115	0.6465971428571429	5.1586	0.05199913	0.0996	24	LEARNING	0.0001680300465368812	70	0.10002787097923252	DISTANCE	45.2618
12	4	25	2	1795899588488888	1795899589070115	0.8862985714285715	2.9368	0.01534607	0.1008	24	LEARNING	0.00844227192422851	70	0.10002807146673545	DISTANCE	62.0409
12	4	25	3	1795899588628694	1795899589070115	0.6814199999999999	2.161	0.01914255	0.1008	24	LEARNING	-0.02364677388232015	70	0.10002827195383655	DISTANCE	47.6994
12	4	25	4	1795899588882818	1795899589070115	0.7400471428571429	1.8256	0.01465495	0.0996	24	LEARNING	0.05138487280095946	70	0.10002847244053581	DISTANCE	51.8033
12	4	25	5	1795899589032841	1795899589070115	0.7366728571428572	5.5109	0.04048062	0.0996	24	LEARNING	-0.049004711564258355	70	0.10002867292683323	DISTANCE	51.5671
12	4	26	0	1795899589242353	1795899590244663	0.5406357142857142	3.4706	0.04816746	0.0996	24	LEARNING	-0.029038596239240867	70	0.10002887341272883	DISTANCE	37.8445
12	4	26	1	1795899589511068	1795899590244663	0.44715857142857146	4.8163	0.09645161	0.0996	24	LEARNING	-0.014132460167251169	70	0.1000290738982226	DISTANCE	31.3011
12	4	26	2	1795899589614360	1795899590244663	0.7997257142857143	3.3013	0.02151063	0.0996	24	LEARNING	0.006485795723667749	70	0.10002927438331453	DISTANCE	55.9808
12	4	26	3	1795899589849083	1795899590244663	0.58909	1.7585	0.0234292	0.0996	24	LEARNING	0.09630834140398013	70	0.10002947486800465	DISTANCE	41.2363
12	4	26	4	1795899590115075	1795899590244663	0.47432714285714284	2.459	0.0488603	0.1008	24	LEARNING	0.08240488479598206	70	0.10002967535229294	DISTANCE	33.2029
12	4	27	0	1795899590296143	1795899591298424	0.8003428571428571	3.5002	0.0233533	0.1008	24	LEARNING	0.028513068340755048	70	0.10002987583617941	DISTANCE	56.024
12	4	27	1	1795899590451276	1795899591298424	0.9860457142857143	3.5903	0.0149595	0.0996	24	LEARNING	0.029147922315652237	70	0.10003007631966407	DISTANCE	69.0232
\.


--
-- Data for Name: contacts_20261129; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contacts_20261129 (whisker_id, boot, seq, "position", t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm, place, distance_mm) FROM stdin;
\.


--
-- Data for Name: contacts_default; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.contacts_default (whisker_id, boot, seq, "position", t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm, place, distance_mm) FROM stdin;
\.


--
-- Data for Name: epochs; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.epochs (fleet, epoch, owner, holder, began_us, shard) FROM stdin;
f	1795899515011	sd96c8d0a8f83511a8e8440ba8d838f4d	vm	1795899515010706	0
f	1795899560342	sbeba64adbcc256f3ba7056c84d1d5e92	vm	1795899560342371	0
\.


--
-- Data for Name: event_outbox; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.event_outbox (fleet, shard, epoch, number, events) FROM stdin;
\.


--
-- Data for Name: health_changes; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.health_changes (health_change_id, whisker_id, recorded_us, kind, was, becomes) FROM stdin;
1	8	1795899525226468	CONDITION	LEARNING	HEALTHY
2	9	1795899525226468	CONDITION	LEARNING	HEALTHY
3	5	1795899525226468	CONDITION	LEARNING	HEALTHY
4	6	1795899525226468	CONDITION	LEARNING	HEALTHY
5	4	1795899525226468	CONDITION	LEARNING	HEALTHY
6	7	1795899525226468	CONDITION	LEARNING	HEALTHY
7	1	1795899525189545	CONDITION	LEARNING	HEALTHY
8	3	1795899525189545	CONDITION	LEARNING	HEALTHY
9	2	1795899525189545	CONDITION	LEARNING	HEALTHY
10	2	1795899535222999	FAULT	\N	GAUGE_OPEN
11	6	1795899542122235	CONDITION	HEALTHY	SUSPECTED
12	5	1795899542122235	CONDITION	HEALTHY	SUSPECTED
13	8	1795899542122235	CONDITION	HEALTHY	SUSPECTED
14	3	1795899542100450	CONDITION	HEALTHY	SUSPECTED
15	1	1795899542100450	CONDITION	HEALTHY	SUSPECTED
16	1	1795899543174917	CONDITION	SUSPECTED	TRIMMED
17	6	1795899543811300	CONDITION	SUSPECTED	TRIMMED
18	3	1795899543852206	CONDITION	SUSPECTED	TRIMMED
19	8	1795899543894861	CONDITION	SUSPECTED	TRIMMED
20	5	1795899544277025	CONDITION	SUSPECTED	TRIMMED
21	1	1795899560427879	FAULT	\N	STALE
22	2	1795899560427879	FAULT	GAUGE_OPEN	STALE
23	3	1795899560427879	FAULT	\N	STALE
24	4	1795899560429199	FAULT	\N	STALE
25	5	1795899560429199	FAULT	\N	STALE
26	6	1795899560429199	FAULT	\N	STALE
27	7	1795899560429199	FAULT	\N	STALE
28	8	1795899560429199	FAULT	\N	STALE
29	9	1795899560429199	FAULT	\N	STALE
30	11	1795899570555196	CONDITION	LEARNING	HEALTHY
31	10	1795899570555196	CONDITION	LEARNING	HEALTHY
32	10	1795899587541961	CONDITION	HEALTHY	SUSPECTED
33	10	1795899588874412	CONDITION	SUSPECTED	TRIMMED
34	12	1795899591298424	CONDITION	LEARNING	HEALTHY
\.


--
-- Data for Name: journal; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.journal (fleet, number, entries, shard) FROM stdin;
f	193	\\xfdffffffffffffff03000000000000005ab5d2755c6106000103000000000000007b000000000000000a0000000000010083d0cd755c61060000bc7493180456ea3f003d0ad7a3703dff3f1244c46a7fa9873f567daeb6627fb93f0000000000003840000000000bb0ce755c6106000029ed0dbe3099e83f008638d6c56d340c40b0d789059d949e3f20d26f5f07ceb93f0000000000003840000000007b19cf755c61060000b4c876be9f1ae33f00dbf97e6abc74ff3fe920b778dbf99c3f20d26f5f07ceb93f000000000000384000000100dd40cf755c61060000a54e401361c3e33f00e6ae25e4831e0c40021abee89f9ea43f567daeb6627fb93f0000000000003840000001005076d0755c61060000f1f44a598638ee3f001b0de02d90201740223406c68f6b9a3f567daeb6627fb93f000000000000384000000000ee7fd0755c61060000273108ac1c5ae23f005f29cb10c73a0b40f592942edc3da93f567daeb6627fb93f000000000000384000000100a7e4d0755c6106000044faedebc039e13f005396218e753112408e409ba0768db13f567daeb6627fb93f000000000000384000000000bd6fd1755c610600005af5b9da8afdef3f00b6f3fdd478e910402433ee380b9c943f20d26f5f07ceb93f00000000000038400000000097f6d1755c610600005f07ce1951daef3f006f8104c58fb10b40ca42096d1889913f567daeb6627fb93f000000000000384000000100c76fd2755c61060000ecc039234a7bdb3f00499d8026c286e33fae83de76fc72893f567daeb6627fb93f00000000000038400300000000000000b80fd5755c610600020300000000000000490dd5755c6106000200000000000000567daeb6627fb93f9a9999999999b93f000000000100567daeb6627fb93f9a9999999999b93f00000300000000000000d56cd6755c61060000fdffffffffffffff0400000000000000a10dd2755c610600020400000000000000df0bd2755c6106000100000000000000567daeb6627fb93f9a9999999999b93f00000400000000000000ca9ad2755c610600000400000000000000d56cd6755c61060000	0
f	194	\\xfdffffffffffffff040000000000000009b3d6755c61060001040000000000000025000000000000000600000000000000046ac7755c610600015305a3923a314540666666666666e63f545227a08970114039ab919f85ebaa3f20d26f5f07ceb93f0000000000003840000000008de1c8755c61060001f5dbd781731e5040666666666666e63f8e06f01648d01740159dd96cb4359d3f567daeb6627fb93f0000000000003840000000009c36cb755c610600018a1f63ee5a1a4e40666666666666e63ff54a598638d600405065831287e8873f567daeb6627fb93f000000000000384000000000b4c0ce755c610600019ca223b9fc374940666666666666e63f1d386744696ffb3f207a73341ed78c3f567daeb6627fb93f000000000000384000000000e583d2755c610600011b9e5e29cbe04640666666666666e63f4182e2c798bb0d40bfc130c3f310a33f567daeb6627fb93f00000000000038400000000091f2d5755c610600018bfd65f7e4714140666666666666e63fd734ef384547f03f91aa9adecd6c923f567daeb6627fb93f0000000000003840	0
\.


--
-- Data for Name: leases; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.leases (fleet, epoch, owner, holder, commits, expires_us, shard, shards, shards_wanted, log_next, log_topic) FROM stdin;
f	1795899560342	sbeba64adbcc256f3ba7056c84d1d5e92	vm	90	1795899604377704	0	1	1	\N	\N
\.


--
-- Data for Name: log_archives; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.log_archives (fleet, shard, topic, next_offset, planned_to, seen, archived_to_us, files, contacts, bytes) FROM stdin;
\.


--
-- Data for Name: notes; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.notes (note_id, robot_id, written_us, author, text, action_id) FROM stdin;
1	2	1795899515485302	local	The right array was cut at the gate.\nIt awaits new whiskers.	7
2	1	1795899515501812	local	The gauge of whisker 1 is open.	8
\.


--
-- Data for Name: policies; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.policies (fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, change_margin, changed_us, changed_by, reason, action_id) FROM stdin;
f	1	ADVISE	TIP	LAST_RESORT	0.5	0.25	0.1	1795899560539362	local	a shift without automatic changes	14
\.


--
-- Data for Name: quarantine; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.quarantine (quarantine_id, fleet, robot, topic, boot_id, seq, received_us, quarantined_us, cause, code, payload) FROM stdin;
\.


--
-- Data for Name: redo; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.redo (fleet, number, rows, shard) FROM stdin;
\.


--
-- Data for Name: robots; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.robots (robot_id, fleet, robot, boot_id, connection, model, updated_us, state, held, journal_number, labels, shard_hash) FROM stdin;
1	f	crawler-2	sim-53a95aa6c0acf744	CONNECTION_BROKEN	simulated	1795899602136618	\\x08009691f423a201000002011400000073696d2d353361393561613663306163663734340107dbc7c59ac7ab98030181d1f50df5070199c3dc0bcd0701afafdd09ab0901d5fdac07930a01f5c4b505b51b018dc2bd03cb090189fdc301cf06010000001400000073696d2d35336139356161366330616366373434cc00000000000000000000000000000000000000000000000000010000000500000066726f6e7401000100000000000000000000000000000000bfcda43ba5abc73fb88ec2af2e2d4f409a9999999999b93f34f5228f867d983f00d7d60156fc294574f326bca2d2051c5e1546a9b83d3cbab004b94906469190e83cceb2067a1b4a4647d3523cd38d0443310e4630ef9c3cc59205818b4246faf6f63bff8d047d391c4661f9403cbb91069b7b82460d0c583cbbf205612486469728993cbef0041c0768466f2764bc9beb02bfc0184686836f3cffe8020b840d465a1e893c014ea79c811a98d23f009001000001966023968aa73f01b31f5b0c97ac3ff03bc1f4813487bf858e3053cd3f443fd80e3e9ebefb463ffa22d867590635bfd80e3e9ebefb463f5aaa1a2377f3533f8483de4024f132bffa22d867590635bf8483de4024f132bf5259fc4b8b2b733f94049fb48474ed3f4bd1e6617ad4ed3fb67daa649a42ee3fa83018dca7b5ee3f22f7c8753228ef3f564d320e0397ef3f7afbb0861a00f03ffcbfa9a55731f03fa3f05989e95ef03f2d0e2446a588f03fc51f4fe674aef03fe9e5a4924dd0f03f009c52db763d44952abd3cb83b867f07449c895abdf2399a6a1644340a923d000000c74f937ba444687f263bc5523fbaca44aaa2043cf4341782514461a6c7bc9a246c5459444b615c3d0000030000000000000002000000020000000000e86f59735c610600010001fc7c96725c610600010003000000c83951735c610600fc7c96725c610600000025ec50735c6106002c2cae705c6106000000495051735c6106002c2cae705c6106000000010000000000000000	f	193	hall=south	90216735
2	f	crawler-1	sim-927819c495d23679	CONNECTION_BROKEN	simulated	1795899602136495	\\x08009691f423a201000002011400000073696d2d393237383139633439356432333637390107fdd2c99ac7ab980301f1bbaf0d8b0601e9a6800bcf0401d1eb9e08b90801c5c7a506a70a01fd93af04cd0801bb8bb802d1030183c143f131010000001400000073696d2d393237383139633439356432333637399e0100000000000000000000000000000000000000000000000003000000040000006c65667400000500000072696768740000040000007461696c0000030000000000000002000000030000000113579e34db76c83fdd5e78d2d57f50409a9999999999b93ff6a1370bb9b9ac3f0199f805e3e42f4670b8873ce9ef07dbec6e46f233883cfdb10764b67f46d473103d94d109b421ab46968f453ddfef090fd2bd4630b7e23cb8af098489c2469ac9493dcb8e0ac101df460fb5393de3f3080bcbc846348d463d87ee08f2f6c046c2c0343dfdd0080384d84685345b3dedcc0bb3700347c46b4e3d80e503a2c452463086623dccd3034165c5451aa98abc97f005ec442e4622ed693ce08a04e79d0246717bd53c8ff206962775463357013ce8b203c04901469fd6cf3cc18f06625574466e15073d9392055af45c4697c8a13cb0af070b66a14606827b3cb9ac0336841846e686523c88b007f883ae46f69ba13cb5d10569cc93469af42f3cb8aa035d903046a87e013d01eda2e9b59f98b93f00900100007557a31c6a1fa73f58e25736939aae3f10461aa7c2d8b4bf7d3844a471912a3f5545a66687ba303f9161e675850526bf5545a66687ba303f2b2f997e04c9433fb835f56ce1c622bf9161e675850526bfb835f56ce1c622bf3bcab660713b723fadcfb751d2d2ee3fb470a88e0c0cef3f657765f20e4cef3fe3775a1f5d8eef3fa10a7b7c67d0ef3f65e45d345d08f03f3680270b4427f03f3ff0db03b244f03f54c02d358d60f03f387bf8bbcb7af03fcac102216c93f03f6c6f868e70aaf03fb86c77a7a744a5d18dbd8af001a63f4f45f5ec8a3cfa4af43a844432d70ebd91af01c0533545fdf6953c9833b1921944b84d9b3cdeaf016f3d58457074013dc672ca8b0a456779c03c86b201943e604536bddf3cd749d1a3c844ff747a3c84ce01f1d28845d7c9f83cf7737d072845f076063d9d2fefaf6444ec09083d0001000000040000000500000002202d8db35e49d33f0e0d332ce5ff50409a9999999999b93f1cd9add83ce0c13f01fbb70497f3fc4563acff3ccbd0080022844678a3303d8ace0a2811b24696012c3dcaf00827dda846bd0d493dfcd1098f4eb946c9654f3db7900671ed74461982353dfcce0ae33de046a52e5e3d95ab08ef72b346c09c493deccd096302d0463dfc783d8a910bceaf03479fb7743d99ef076782c24656f0593da3e801d0f4d1454acf943dae57f5088a44ec1732b9cc30abac14449912163ebe4c2a8fa044911a113d00c68b010dbe41450324a43d0000af8a01370e5e450ac0ae3d8a3eed036d4429b9253db16e98920945ce09ec3dae45c63ae94498f5d53ddaa501bcce97456c19e83d0124b20fd8c493b93f0100000000a02a66700924b23fb67134c120c3b53f5a00cb2b3528a5bfacac187cb331ea3ea0f3dc7c8409913e48a3a97e0a7f17bfa0f3dc7c8409913e2b7fd02899a9253f12f739ca85acfbbe48a3a97e0a7f17bf12f739ca85acfbbea99d3ea88ace6d3fc031b7a614bff03f1479ad34a1a1f03f9dbdf930f282f03fafd0dddecb64f03f72339e1b2f48f03fe99b81a2ab2df03fc9ccf6028f15f03f58bb7a010000f03f560929c31ddaef3fccb3c18a7eb9ef3fbdc4c6881c9eef3fb598337cec87ef3fae57f5088a44ec1732b9cc30abac14449912163ebe4c2a8fa044911a113d00c68b010dbe41450324a43d0000af8a01370e5e450ac0ae3d8a3eed036d4429b9253db16e98920945ce09ec3dae45c63ae94498f5d53ddaa501bcce97456c19e83d0002000000010000000100000000e0275ad8eeedca3f8e983648317450409a9999999999b93ffcf8e405e0b8ac3f00d1d802c4c9984571b4b63cf1ef04a5f019468057073dd1ab05deb9334603b4ae3cbdef047df131461736033dd08e0442e92a46cca7303cad910404b82d464d38563cc3cc032cac29462ce4153dbaf20347833e4647c43abcb0f105181b93466d316b3ccbb205e7f78c46c530c53c9bce031e694f4644dca63cc2e8013e3ad045ae04e83c01ab91fc64c7f7d23f00000000002177e064b3a6a73f4ba245e6f4bdb33f1324dcfff1807c3f5ce8f4b3a1d8323f7215900d695e333f88b7121a2c9027bf7215900d695e333fba2ff02f573a443f1e17dd8a159a23bf88b7121a2c9027bf1e17dd8a159a23bf625bcc12b463723f917627f9e120ee3fa723a80a9351ee3f5636118ad287ee3f5f9390a023bfee3fb73b35ccf3f4ee3ffb3f758fcb27ef3f03692423d956ef3fe21f2669ac81ef3f41c3c9860ea8ef3f7339a169e9c9ef3fb1ffb1a838e7ef3f1f2200000000f03fd1d802c4c9984571b4b63cf1ef04a5f019468057073dd1ab05deb9334603b4ae3cbdef047df131461736033dd08e0442e92a46cca7303cad910404b82d464d38563cc3cc032cac29462ce4153dbaf20347833e4647c43abcb0f105181b93466d316b3ccbb205e7f78c46c530c53c9bce031e694f4644dca63cc2e8013e3ad045ae04e83c000c0000000000000003000000030000000000d26e59735c610600010001957b47725c610600060006000000f9ff50735c610600d059aa705c6106000000517f51735c61060063c855725c610600000057f651735c610600d059aa705c6106000000c71052735c610600e3983b735c61060000005e2452735c610600d059aa705c6106000000f92251735c6106009a3144735c6106000000010000000000000000	f	193	hall=north	263116395
3	f	crawler-3	sim-a71a5f3fe7bc46ee	ONLINE	simulated	1795899601636026	\\x08009691f423a201000000011400000073696d2d613731613566336665376263343665650107b2cab6aec7ab980301cbac8a0cdf0501b9ce930a990a01e5829b088b0901d3a7a30695090189f4ab04ab0901b5eab502c50901c7a23fd50a010000001400000073696d2d613731613566336665376263343665657b0000000000000000000000000000000000000000000000000001000000040000006c65667400000100000000000000000000000000000000f4b9ddcd2e8cc83f3f7117d8270850409a9999999999b93fa22bf2c36355a43f00000000000000000000000000000f52e29120fdd13f0000000000d3bf9a0cb8d6a83f6b3261f3e3d5a73f87a80dd10d5dbabffaa2eea8824b3c3fa7bee0577bc83f3fc7c2eaa8aa3830bfa7bee0577bc83f3f29a379672b374e3f9f4348efbd5a26bfc7c2eaa8aa3830bf9f4348efbd5a26bf8300caab4239733f6b8ac473aa8fed3fa3923376eccced3f22cdb5f31f13ee3f7a70074b9c5bee3f9104579088a2ee3feadb5a56ade5ee3f2f4dea0ac923ef3f1f6ed0112c5cef3f8a8d9e4a7d8eef3f11810fec95baef3f657261246be0ef3f44c1ffffffffef3f0000000000000000000000000100000000000000000100000001000000000000000000000000000000000000000000000000000002000000b09ecd755c610600000000000000000000003ceecc755c61060000000000000000000000000000000000000000	f	192		1371191216
4	f	crawler-4	sim-ba60d84d60738174	ONLINE	simulated	1795899602220595	\\x08009691f423a201000000011400000073696d2d62613630643834643630373338313734010789e6daaec7ab980301efdee90bcb090197abf309fd0901b7b6fc07d50901fb818706cf07019ba58e0497050183ee9902e30401cf95258307010000001400000073696d2d62613630643834643630373338313734260000000000000000000000000000000000000000000000000001000000040000006c656674010000000000020000000000000000000000000000000000000000000000000000000166aed7755c61060001000100000091f2d5755c61060066aed7755c6106000100000000000000000000	f	194		1915221346
\.


--
-- Data for Name: rollout_events; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.rollout_events (rollout_event_id, rollout_id, recorded_us, event, stage, actor, detail) FROM stdin;
1	15	1795899589307474	STARTED	FEW	local	fewer changes
\.


--
-- Data for Name: rollouts; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.rollouts (rollout_id, fleet, kind, change, state, stage, place_max, level, robots, looks, probability, changed_robots, unchanged_robots, changed_error, unchanged_error, started_us, stage_us, updated_us, started_by, reason) FROM stdin;
15	f	POLICY	{"change_margin":0.2,"expected_version":1,"longer_for_shorter":"LAST_RESORT","mode":"ADVISE","objective":"TIP","own_role_cost":0.25,"predicted_error_max":0.5}	RUNNING	FEW	1381892864	0.05	4	0	\N	0	0	\N	\N	1795899589307437	1795899589307459	1795899589307474	local	fewer changes
\.


--
-- Data for Name: setpoint_states; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.setpoint_states (setpoint_state_id, command_id, recorded_us, state, error, pressure_mpa) FROM stdin;
1	ea9dcf50-31f2-5629-b2c3-f1a948ddd282	1795899543174917	PENDING	\N	\N
2	ea9dcf50-31f2-5629-b2c3-f1a948ddd282	1795899543215584	RECEIVED	\N	\N
3	ea9dcf50-31f2-5629-b2c3-f1a948ddd282	1795899543215585	APPLYING	\N	\N
4	0c7385cc-2200-502b-a125-a12f285374f4	1795899543811300	PENDING	\N	\N
5	0c7385cc-2200-502b-a125-a12f285374f4	1795899543816777	RECEIVED	\N	\N
6	0c7385cc-2200-502b-a125-a12f285374f4	1795899543816778	APPLYING	\N	\N
7	5751a546-5262-534d-b6fd-9cdb34acd1dc	1795899543894861	PENDING	\N	\N
8	5751a546-5262-534d-b6fd-9cdb34acd1dc	1795899543898190	RECEIVED	\N	\N
9	5751a546-5262-534d-b6fd-9cdb34acd1dc	1795899543898191	APPLYING	\N	\N
10	f306fb61-4766-56f9-8350-04f56f066179	1795899544277025	PENDING	\N	\N
11	f306fb61-4766-56f9-8350-04f56f066179	1795899544288440	RECEIVED	\N	\N
12	f306fb61-4766-56f9-8350-04f56f066179	1795899544288441	APPLYING	\N	\N
13	0c7385cc-2200-502b-a125-a12f285374f4	1795899546461764	APPLIED	\N	0.0552
14	5751a546-5262-534d-b6fd-9cdb34acd1dc	1795899546690517	APPLIED	\N	0.1476
15	f306fb61-4766-56f9-8350-04f56f066179	1795899546909438	APPLIED	\N	0.0552
16	ea9dcf50-31f2-5629-b2c3-f1a948ddd282	1795899547570958	APPLIED	\N	0.024
17	480b2f79-29c9-5215-8d3e-6706c0383dbc	1795899557862116	PENDING	\N	\N
18	480b2f79-29c9-5215-8d3e-6706c0383dbc	1795899557874392	RECEIVED	\N	\N
19	480b2f79-29c9-5215-8d3e-6706c0383dbc	1795899557874393	APPLYING	\N	\N
20	81cc1ce2-1806-5930-a0df-5935770f2ab6	1795899558111380	PENDING	\N	\N
21	81cc1ce2-1806-5930-a0df-5935770f2ab6	1795899558116306	RECEIVED	\N	\N
22	81cc1ce2-1806-5930-a0df-5935770f2ab6	1795899558116307	APPLYING	\N	\N
23	0c37bd95-658a-59da-a81d-1650dc8ec40f	1795899558350623	PENDING	\N	\N
24	0c37bd95-658a-59da-a81d-1650dc8ec40f	1795899558354719	RECEIVED	\N	\N
25	0c37bd95-658a-59da-a81d-1650dc8ec40f	1795899558355003	APPLYING	\N	\N
26	480b2f79-29c9-5215-8d3e-6706c0383dbc	1795899558369150	APPLIED	\N	0.0564
27	51b43e4d-65ce-50c4-ac50-da011232dd60	1795899558862830	PENDING	\N	\N
28	51b43e4d-65ce-50c4-ac50-da011232dd60	1795899558868511	RECEIVED	\N	\N
29	51b43e4d-65ce-50c4-ac50-da011232dd60	1795899558868512	APPLYING	\N	\N
30	81cc1ce2-1806-5930-a0df-5935770f2ab6	1795899558966904	APPLIED	\N	0.1392
31	0c37bd95-658a-59da-a81d-1650dc8ec40f	1795899559760720	APPLIED	\N	0.0792
32	51b43e4d-65ce-50c4-ac50-da011232dd60	1795899559374953	APPLIED	\N	0.0252
\.


--
-- Data for Name: setpoints; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.setpoints (command_id, robot_id, whisker_id, compensation_id, epoch, version, robot_boot_id, pressure_mpa, slew_mpa_per_s, issued_us, expires_us, reason, gain, state, error, reached_mpa) FROM stdin;
0c7385cc-2200-502b-a125-a12f285374f4	2	7	8589934592	1795899515011	2	sim-927819c495d23679	0.05610445272379032	0.02	1795899543811300	1795899556005592	SHORTER_FOR_LONGER	[[0.45,0.9479492314789023],[0.5,0.9533958894661387],[0.55,0.9594915129470752],[0.6,0.9656931448395172],[0.65,0.971691025920875],[0.7,0.9773098741272693],[0.75,0.9824530283545255],[0.8,0.9870700631510357],[0.85,0.9911375843039233],[0.9,0.9946476090957268],[0.95,0.9976004056731758],[1.0,0.9999999999980428]]	APPLIED	\N	0.0552
5751a546-5262-534d-b6fd-9cdb34acd1dc	2	9	8589934593	1795899515011	3	sim-927819c495d23679	0.1466952802560571	0.02	1795899543894861	1795899556229140	LONGER_FOR_SHORTER	[[0.45,1.0518132432928142],[0.5,1.046844150427977],[0.55,1.0411653083619348],[0.6,1.0352893647744732],[0.65,1.0295152419103077],[0.7,1.0240161482568277],[0.75,1.0188904448587124],[0.8,1.0141916244630174],[0.85,1.0099463369667907],[0.9,1.0061654335672432],[0.95,1.0028508543044865],[1.0,1.0000000000008533]]	APPLIED	\N	0.1476
f306fb61-4766-56f9-8350-04f56f066179	2	5	8589934594	1795899515011	4	sim-927819c495d23679	0.056097985000166134	0.02	1795899544277025	1795899556471652	SELF_COMPENSATION	[[0.45,0.9415140024463701],[0.5,0.9474578102245815],[0.55,0.9540798851609888],[0.6,0.9608324180631874],[0.65,0.9674014080463768],[0.7,0.973607807341977],[0.75,0.9793515859958294],[0.8,0.9845792821588442],[0.85,0.9892647392826818],[0.9,0.993397432621164],[0.95,0.9969752592878561],[1.0,1.0000000000019396]]	APPLIED	\N	0.0552
ea9dcf50-31f2-5629-b2c3-f1a948ddd282	1	1	4294967296	1795899515011	0	sim-53a95aa6c0acf744	0.0239163422454471	0.02	1795899543174917	1795899556978616	SELF_COMPENSATION	[[0.45,0.9027891972357462],[0.5,0.9117640307150392],[0.55,0.9223707038507787],[0.6,0.9334986960850098],[0.65,0.9444994850081937],[0.7,0.9549942039264601],[0.75,0.964763884877102],[0.8,0.973685307727822],[0.85,0.9816926489652636],[0.9,0.9887540822118686],[0.95,0.9948572362993388],[1.0,1.0000000000000007]]	APPLIED	\N	0.024
480b2f79-29c9-5215-8d3e-6706c0383dbc	2	7	8589934592	1795899515011	7	sim-927819c495d23679	0.05610445272379032	0.02	1795899557862116	1795899567861575	REFINEMENT	[[0.45,0.9632350536398825],[0.5,0.9702208315170737],[0.55,0.9780344709686061],[0.6,0.9861283886309561],[0.65,0.9941899710905383],[0.7,1.0020420117928321],[0.75,1.0095863757815216],[0.8,1.016771330904717],[0.85,1.0235721661847679],[0.9,1.0299794523813954],[0.95,1.0359917916758712],[1.0,1.0416112487209501]]	APPLIED	\N	0.0564
81cc1ce2-1806-5930-a0df-5935770f2ab6	2	9	8589934593	1795899515011	8	sim-927819c495d23679	0.13965569095643893	0.02	1795899558111380	1795899568462846	REFINEMENT	[[0.45,1.0466505539253461],[0.5,1.0394603784294008],[0.55,1.0319692528827098],[0.6,1.0246084886285123],[0.65,1.017623050577836],[0.7,1.0111500118161934],[0.75,1.0052633395942385],[0.8,1.0000000055112732],[0.85,0.9953755199169716],[0.9,0.9913933477488341],[0.95,0.9880507155814012],[1.0,0.9853422571002485]]	APPLIED	\N	0.1392
0c37bd95-658a-59da-a81d-1650dc8ec40f	2	4	\N	1795899515011	9	sim-927819c495d23679	0.08	0.02	1795899558350623	1795899569350213	OPERATOR	[]	APPLIED	\N	0.0792
51b43e4d-65ce-50c4-ac50-da011232dd60	1	1	4294967296	1795899515011	2	sim-53a95aa6c0acf744	0.0239163422454471	0.02	1795899558862830	1795899568862216	REFINEMENT	[[0.45,0.920473435188017],[0.5,0.932187262739299],[0.55,0.9456302610523639],[0.6,0.9596747683258586],[0.65,0.9736568737496081],[0.7,0.9871840741420026],[0.75,1.0000252972965584],[0.8,1.0120464774336133],[0.85,1.0231719365392926],[0.9,1.0333607425572027],[0.95,1.042591952938879],[1.0,1.0508552292143298]]	APPLIED	\N	0.0252
\.


--
-- Data for Name: supervisors; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.supervisors (supervisor, holder, fleets, alive_us, deaf, heard) FROM stdin;
sbeba64adbcc256f3ba7056c84d1d5e92	vm	f	1795899604377728		
\.


--
-- Data for Name: touch_tests; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.touch_tests (touch_test_id, test_id, robot_id, whisker_id, kind, reason, contacts, state, error, requested_us, updated_us, ended_us, touches, missed, length_mm, length_sd_mm) FROM stdin;
1	bef8b6e8-f382-5099-869b-40719c9b154f	2	5	WALL	CHANGE	10	DONE	\N	1795899542436757	1795899543373923	1795899543373923	1	7	69.98270210280323	0.09945790236963252
2	e9e42bf7-e9b2-551d-a879-9d2e70b509d4	2	5	WALL	CHANGE	10	DONE	\N	1795899543373923	1795899544323297	1795899544323297	7	2	65.81550793964036	0.2963732229420894
3	7b1f82f1-11df-5b13-a1ae-0ea639b128a2	2	7	WALL	SETPOINT	36	DONE	\N	1795899546529331	1795899548675253	1795899548675253	32	4	65.98779161542959	0.09341112925207218
4	3bd8e05d-4dcf-5fc5-902b-a6e837e55c92	2	9	WALL	SETPOINT	36	DONE	\N	1795899546760690	1795899548675254	1795899548675254	32	3	68.04043144767239	0.09435409694382695
5	c3d411c6-1fd0-5d9f-a19f-8e2aac0d7b26	1	1	WALL	SETPOINT	36	DONE	\N	1795899547614460	1795899549661187	1795899549661187	29	4	62.22166333841608	0.2186945540630811
7	798273b9-62fe-5bba-9b58-b1e0d7869b3b	2	9	WALL	OPERATOR	10	DONE	\N	1795899558998426	1795899559825316	1795899559825316	10	0	68.05517565730291	0.08962888478777074
6	efb740e1-a037-5ed9-b7c7-fc13fd73ac47	2	7	WALL	SETPOINT	36	RUNNING	\N	1795899558435043	1795899559930237	\N	19	2	\N	\N
8	2b2d2512-466c-58d2-b28b-9aa76dde9a0c	4	12	WALL	SCHEDULE	10	WITHDRAWN	\N	1795899582136454	1795899591385471	1795899591385471	0	0	\N	\N
9	989aca66-e8c1-5a6e-ab68-10161aaf11f0	4	12	WALL	OPERATOR	10	PENDING	\N	1795899602218598	1795899602218598	\N	0	0	\N	\N
\.


--
-- Data for Name: trims; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.trims (trim_id, robot_id, whisker_id, detected_us, length_before_mm, length_after_mm, length_after_sd_mm, contacts_to_detect) FROM stdin;
4294967296	1	1	1795899543174917	69.99738505348813	62.30500352658983	0.2967231360146912	19
8589934592	2	6	1795899543811300	69.99277206895079	45.32179251931638	0.3535808279266446	28
4294967297	1	3	1795899543852206	69.99135458188542	45.091631651642665	0.35582230621138966	29
8589934593	2	8	1795899543894861	64.99800405410024	45.21647995701467	0.31212154321667446	30
8589934594	2	5	1795899544277025	69.98268068826249	65.81550793964036	0.2963732229420894	44
12884901888	3	10	1795899588874412	69.983548781844	64.234148701888	0.2977105765682474	22
\.


--
-- Data for Name: turned_away; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.turned_away (fleet, robot, tries, first_us, last_us) FROM stdin;
f	stranger	195	1795899560576472	1795899601866385
\.


--
-- Data for Name: webhook_dead_letters; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.webhook_dead_letters (webhook_id, event_id, attempts, dead_us, status, problem, again) FROM stdin;
1	7	1	1795899589536798	\N	io: Connection refused (os error 111)	f
\.


--
-- Data for Name: webhook_events; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.webhook_events (event_id, tx, place, occurred_us, kind, word, fleet, robot_id, whisker_id, number, command_id) FROM stdin;
1	879	28734392403623488	1795899525226468	CONDITION_CHANGED	HEALTHY	f	2	8	1	\N
2	879	28734392403623488	1795899525226468	CONDITION_CHANGED	HEALTHY	f	2	9	2	\N
3	879	28734392403623488	1795899525226468	CONDITION_CHANGED	HEALTHY	f	2	5	3	\N
4	879	28734392403623488	1795899525226468	CONDITION_CHANGED	HEALTHY	f	2	6	4	\N
5	879	28734392403623488	1795899525226468	CONDITION_CHANGED	HEALTHY	f	2	4	5	\N
6	879	28734392403623488	1795899525226468	CONDITION_CHANGED	HEALTHY	f	2	7	6	\N
8	879	28734392403032720	1795899525189545	CONDITION_CHANGED	HEALTHY	f	1	3	8	\N
9	879	28734392403032720	1795899525189545	CONDITION_CHANGED	HEALTHY	f	1	2	9	\N
10	946	28734392563567989	1795899535222999	ALARM_RAISED	GAUGE_OPEN	f	1	2	1	\N
11	989	28734392673955760	1795899542122235	CONDITION_CHANGED	SUSPECTED	f	2	6	11	\N
12	989	28734392673955760	1795899542122235	CONDITION_CHANGED	SUSPECTED	f	2	5	12	\N
13	989	28734392673955760	1795899542122235	CONDITION_CHANGED	SUSPECTED	f	2	8	13	\N
14	989	28734392673607200	1795899542100450	CONDITION_CHANGED	SUSPECTED	f	1	3	14	\N
15	989	28734392673607200	1795899542100450	CONDITION_CHANGED	SUSPECTED	f	1	1	15	\N
16	996	28734392690798675	1795899543174917	COMPENSATION_BEGUN	\N	f	1	1	4294967296	\N
17	996	28734392690798673	1795899543174917	TRIM	\N	f	1	1	4294967296	\N
18	996	28734392690798672	1795899543174917	CONDITION_CHANGED	TRIMMED	f	1	1	16	\N
19	1003	28734392700980803	1795899543811300	COMPENSATION_BEGUN	\N	f	2	6	8589934592	\N
20	1003	28734392700980801	1795899543811300	TRIM	\N	f	2	6	8589934592	\N
21	1003	28734392700980800	1795899543811300	CONDITION_CHANGED	TRIMMED	f	2	6	17	\N
22	1004	28734392701635301	1795899543852206	ALARM_RAISED	UNCOMPENSATED	f	1	3	2	\N
23	1004	28734392701635297	1795899543852206	TRIM	\N	f	1	3	4294967297	\N
24	1004	28734392701635296	1795899543852206	CONDITION_CHANGED	TRIMMED	f	1	3	18	\N
25	1006	28734392702317779	1795899543894861	COMPENSATION_BEGUN	\N	f	2	8	8589934593	\N
26	1006	28734392702317777	1795899543894861	TRIM	\N	f	2	8	8589934593	\N
27	1006	28734392702317776	1795899543894861	CONDITION_CHANGED	TRIMMED	f	2	8	19	\N
28	1010	28734392708432403	1795899544277025	COMPENSATION_BEGUN	\N	f	2	5	8589934594	\N
29	1010	28734392708432401	1795899544277025	TRIM	\N	f	2	5	8589934594	\N
30	1010	28734392708432400	1795899544277025	CONDITION_CHANGED	TRIMMED	f	2	5	20	\N
31	1125	28734392966846069	1795899560427879	ALARM_RAISED	ROBOT_SILENT	f	1	\N	3	\N
32	1125	28734392966846070	1795899560427879	ALARM_CLEARED	GAUGE_OPEN	f	1	2	1	\N
33	1131	28734392966867189	1795899560429199	ALARM_RAISED	ROBOT_SILENT	f	2	\N	4	\N
34	1200	28734393128883136	1795899570555196	CONDITION_CHANGED	HEALTHY	f	3	11	30	\N
35	1200	28734393128883136	1795899570555196	CONDITION_CHANGED	HEALTHY	f	3	10	31	\N
36	1306	28734393400671376	1795899587541961	CONDITION_CHANGED	SUSPECTED	f	3	10	32	\N
37	1316	28734393421990597	1795899588874412	ALARM_RAISED	PROPOSED	f	3	10	5	\N
38	1316	28734393421990593	1795899588874412	TRIM	\N	f	3	10	12884901888	\N
39	1316	28734393421990592	1795899588874412	CONDITION_CHANGED	TRIMMED	f	3	10	33	\N
7	879	28734392403032720	1795726725189545	CONDITION_CHANGED	HEALTHY	f	1	1	7	\N
40	1341	28734393460774784	1795899591298424	CONDITION_CHANGED	HEALTHY	f	4	12	34	\N
\.


--
-- Data for Name: webhooks; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.webhooks (webhook_id, name, url, fleets, kinds, level, enabled, secret, previous_secret, previous_until_us, created_us, changed_us, changed_by, done_tx, done_place, done_event, attempts, streak, next_us, holder, held_until_us, last_us, last_status, last_problem, last_success_us, delivered, failed, lost) FROM stdin;
1	tickets	http://127.0.0.1:1/vibrissa	f	\N	WARNING	t	\\x1567ca48d6491e02b4a4b7b25943c38943e32e35717128c4517cfdc140b349af	\N	\N	1795899515169048	1795899589445532	local	879	28734392403032720	7	3	4	1795899603175013	\N	0	1795899596571092	\N	io: Connection refused (os error 111)	\N	0	11	0
\.


--
-- Data for Name: whiskers; Type: TABLE DATA; Schema: public; Owner: -
--

COPY public.whiskers (whisker_id, array_id, robot_id, whisker, "position", x_mm, y_mm, model, whole_length_mm, nominal_pressure_mpa, pressure_max_mpa, length_mm, length_sd_mm, condition, fault, pressure_mpa, setpoint_mpa, contacts, heard_us, state, leak_per_s, leak_low_per_s, leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact, erosion_high_mm_per_contact, contacts_left, contacts_left_low, contacts_left_high, held, rollup) FROM stdin;
4	2	2	0	0	0	0	nguyen-2021	70	0.1	0.2	69.99372700435151	0.09990262240794123	HEALTHY	STALE	0.0792	0.08	657	1795899559930237	\\x8b04c0018216000001010b6e677579656e2d32303231010181f6e042c19a0c81b51803c1d50981e2090081f6e04238ab4b3df54c6f3d6df1bbb874772537000000005c93d43a25e7eb38c8c7623735069536c9e6d3b2000000008da77bb52297f33906bc0f36d3265cb3000000004e1ab2b5f3b608364d6db2ad00000000abb18e310699bf2f00000000922f1a3259854d38000000007ac08e35a18a583f9597f4430ad7a33bbc98f23fffbb53bd000000000000000013c4643c9bfe3f42010000c0410000c041b24c393f883fd33c000096430000803f000010400000000000bcda2c39411b143a6fc6743a00000000ddeaad34aa26ed3504590e37000000000406683ddceccabb34f5eabf000000000406683ddceccabb34f5eabfc5e05141e2d474412f17ad41a829454180f35a3fc46a183b94a28b3e5d0bf13f55a0a23b852f4b3eab5f2141e62324418c042e4137c81d412c8e1f41f3712041093b2241067f1122ffffff069ca37f3f5c8622bc51ee7f3fbaaad4b7000000003e9d3739028bd8943e2cb909be3bf97f3f86e7c4b7000000003760cbba0aa60a0c4112937dbfe0f61f413db7acb800000000b485903c00000af2ec35c3ef681cc2120d4f3d8f05204100000000f7b8753f000000624bc83fe4763646e7ba11c3d3c606404d7936461ec711c396d66c40ee459f45de82ffc2c5249840f6499f454690ffc2d526813f1a49f3481d6561c48577833f9a49f348d46661c42aaf8b3f4b4bf348ac6c61c498f07a3f5a7f8c4de1ee9a465dfc7e3f7a7f8c4d2def9a46ef81803f8a7f8c4d53ef9a46e88a823faa7f8c4d9eef9a46d21c0c4059f973bf7efabf40c63294b80000000055b1883b43a41c3e99dc5fbd38feff3f62c34fb7000000002cc241bab659df47f38509c4a95cb8467662df475a9409c4e961b846f8eb3745e674c2c292312a45a6fc37458986c2c202412a45008f0000000000000000000000000000000000f0cbabb78ed7b0060000000000a74216420000619188bd1a7058414d6e4bbf586f873fddd6983e6ab63b3edab0d7bdefdd743c05279ebd17ade53b000000000041c6154200008b6d8abd1e0a4443ec2a11c088e0d841b33715be7b811840d9555a3ef375353f754430bd9efcc93c58293540a6d31b423968674114c695ba6af2b1350ff1df4162515e386fbdf84241143abccbdb933500bd38a642ac46503c0a3ea542e215193d6132a542820b8a3d1d3ea5428005dd3d7f65a5422d2d2a3ed5b7a542948c6c3e717fa642f40e813c7685a642b70ce23cb289a64293a2a13d000000000000000000000000000000000000000000000000000000000000000000002c42230a0d3e000000ff01edda843d492ead401fe5113f00000005108fd801ce8ff800ce8c6900f18a9c01878c81009d89b200cd8e5b01c38e5201c28be7009689cd0177887efe7390ba00f88f0c01dd8d3b00ac8ba400d381b600a8010000a599074f805346c5de223dbf8f0e2a1bce4673fe0c3d94f007055887462fdc2c3d80d00da680ea4692cf2b3dfccd0ad1e2cd46e04c053dca900c756ee446325a5e3dfecd0a9c71e946279d4c3dfcce0ca92e0347322e633d9bf00c6146074732e8573df9b0098905de468b1c7f3df1ef0ea63c1b470196683dd1e804763680466d61a83d91057d6952735c610600000000c00000000000e58ea83f00000000fedfad3f009fd358735c6106000d008c4200802744a0022544157323444d892144f7441f445c001a44ba7b144443460f4434eb0a449d33074404e703449868f84357e8e543c400d4435682c243bcb6a0437f8d7e43b629c3436c0b9943fd5eac4315549e4300887d42786e2a42350b1942a330de41c0eb2041e59a2f41c0da5941b3818f4110ac93410b82954187900a426b8f99420000d7c64f735c61060050d34f735c610600	\N	\N	\N	\N	\N	\N	\N	\N	\N	t	\\x018cb8c80100ad9c070000
8	4	2	0	4	0	0	nguyen-2021	65	0.1	0.2	45.19686110231551	0.26978902591359377	TRIMMED	STALE	0.1008	0.1	671	1795899559930237	\\x8b0480018204020001010b6e677579656e2d32303231010181c9fe3dc19a0c81b5180181a70c0081c9fe3d2641393deca5473d460ababe3473f1b5000000006e9095b9286f8b37f337cb361c4010370a49afb200000000e76826b5b008cd385cbc943686a836b300000000c51ddbb550cbc6363cfc90b1000000009a2106b4f9d1fd2f000000004460003259854d380000000056d981355066793ffc6feb43e702d13b1783fbbf3543763d000000000000000005d8613cefb63042010000c0410000c04132493a3fc479c63c000096430000803f000010400000000000b96fe7b809f9f0b9bc9ad4ba000000004bd00e36fbc62c376bd50f380000000096e6b2bda7d7f4be4fa2fbbf0000000096e6b2bda7d7f4be4fa2fbbf16c78443838c8443f110844353f382439a3b893a4de3453afe59833d00af014397ee6e3fc300cf3dec113d431bc44c42363cb4415863f54189937a43d9de654366a59842037d0000ff1fff8a021ab71e3bac2aec3a35951d3bad0378b6000000009944e3b8b3015691983938fb953eea43a83e9296adb60000000092af54bc8a02a7f880bf0bdc38429c1305430af5ba3c0000000034e087bf3be59a12be1823f340d15f514261e6a93b00000000d8be01bf8a022eb6a84232146ec5db06044580d5814300000000266c41440000201c1b2441819615c3a15d3242764cfd410000000021609741b26d8c3fb09c5744cc17dac1445a983f729e57445e1adac1a868ad3ff8a05744a31edac13182c43fc7a257443b24dac1e56c134120232048b392834475a10c3f0a0f844f5c8710475c86653e7917214d722cc945e3dcc53dd41ec654f15882c91a078a3fea2cc65437f280c92cf1343f912bc654d44980c9bf15743f7ac717513d17cfc6074881bf2fda3842fc120643ccfcba3c00000000a5dc87bf711e844ff23a16472db4de475e1e844f1e3316471fb4de47371e844f7223164701b4de47e81d844fa4031647c6b3de470096b4ce4a735c61060008ff08f73fa8354d3ff78919000000009b0f1942041f3461b7bd665cc7410000a642e058fbbcddff7d400000a642a6d8c53b8665f43c0000a7422707683b2707e8360000a7425152f2395152f23300e0a642d4d63a00000000cc7b1a420f1f767e6d3f4c9055430000a842ece2febf1887c1410000a742faaf4dbf16a0af3f0000a742c4de033d8da64a3d0000a6427d26113d7b5fcc3a00e0a642c9cc952ae686cc3d63b92f42ff40cc3d0a0808fe40cc3dc91d2642c17d033b89000800a1010500bf020700d5030800e3040600f905070014070200320804004e09fdfff78919efbfa642febd923c5b45a6420c7a753dfd1ca642d91deb3dac26a642ada8213ef527a642d762233eeef4a542b8ea573eaed4a6426802803ce6d0a642f2acde3c1ecea642086e9e3d22e5e93d00000000000000000000000000000000000000000000000000000000000030421a1f413e000000ff000b108f7c01fc8bd800aa8f5a01fc88eaff7e8d7601d98cf100b68ae4ff978f6801e88d9a00c18927008b90f400fc8c1301b58e3101d4890800808f1c01f73c660aab030000b7f603b13bc7450450a33c81f108769180463b3cf83cd6af0881b979465228d03cf6f0093e459b4649042b3dfcf0094f85aa46dc522d3db0b0098ae3ad46a8f5383df2d00a8b5acd465ea4273db9cd089cb2ab464990363d9db208aa80b246a119833d97ed066b209c4613d9523dbfae08b8c5c546ae91453dce8803b56123462fddb23d9f057d6952735c610600000000c000000000401eb0a63f0000002014efb13faddd34420000724384ced042c568cc425811c842dbf8c34264b1bb4232d6b442a4e9ad42d9eda642b5ba9e4279899642e82484422e7658425a512642e4edf94176c27741f6a26140e3b01440b5e5174093331b40fa731e400231134030b8db3f80ac8b3f3a20d63e63f1453b909b503b62506d3b0683903b1f4dbb3b85d0f73be119743c3667673d0000	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
10	5	3	0	0	0	0	nguyen-2021	70	0.1	0.2	64.06128112284564	0.16237991428121423	TRIMMED	\N	0.1008	0.1	615	1795899601560882	\\x8b04008204000001010b6e677579656e2d32303231010181f6e042c19a0c81b5180181a70c0081f6e042ba2e393d0fb6513dce90b5bd9f7fe236000000002201923957a28537601ed836c7c0e936d7d2afb20000000000746cb5f987c138d4df81364af44db300000000d26687b5973f9c36ae002d3000000000d22488b367a3cb2f00000000b0d61b3259854d38000000004b238b35e8905a3f80d0f9435b4bd13bb6695e404f280fbe0000000000000000237f523c5b3a3d42010000c0410000c041e0ba3a3f12afdf3c000096430000803f0000104000000000003848b1395bafca3ab70a833b00000000a454e735361515373f94043800000000d78c1ebdad19b2be36bb15c000000000c9cf58bd656cd2bea6441fc047085e43b2ec8e43421f6442095d1543242a974080a24f3b69e200411c58653fbdb3a63b3a63aa3e0b079d431a5cb9438deeea424bcd20427354bc426b9aa64336d33a430f7f2103f0f0ff029bcd97badfac9ebc1a947d3f76a6ef36000000009fd8803bd1014a05b23b12e9173d228c9c3cfa428237000000005160443bc501756f9c3b358e5d3ecbf3893dbb0387b6000000003a2fcfbb03b6d6403a64d454bb1d257c3f5c7481b7000000008cded03ad301b8458f3f230661420ea5d042a4abaab90000000070cb08c0003fc06b30bd265527415d275542b7a17a3b0000000012cbb7be299fbfd6415a149bc3b4210443cb2c214200000000ed1eed41d30168623844116c91c5fff14645bd66404300000000daed3144004c83cdf942efc155c4745fde43ccbd91420000000044dcc34260f9a53f192c3546f736b9c26fdf224039722d47784c91c368a4b741fc6e36460caf97c3b20ebf425ba5dd45288982c348097340aa04dd45c72a82c34c4a7f40b29add45808282c33ab2d33f5e1b2b4f962e7dc7974ffb3f831a2b4f7f7d81c780a9ca3f824e784d1a1d8bc6a107143fb1310752ae22e948b326c33e44d74e55d2c74f4a5de1be3f4de74e5553cc504a44bb3f40376c76534a13c74928a7da3a88188cbc1180ff3f23a24eb700000000cf8a57ba9ea68c3ffcc960422c8dd24260dab8b900000000552509c07023823fdac85a42636dd142e494c2b900000000582005c01cb3053ab46215bd0f253f40d09dadb6000000008ace4b3b91c12a4f17587ac795e994497e52264f4d9b77c778f1834ad7f87946f039b4c326511c46aa4a3a453369c7c27c813945afbd39454ad2c6c219f53845654a3a45e968c7c237813945009ef4d4c5755c61060008eb00004095214e3fa16c0000000017590e42091f277b1abef3c041410000a64275da29beb4de64400000a64260d27f3e8c82283e0000a7428d78c43dba3a683c0040a7423ce9f03d3ce9703c00c0a742f8a63e00b2b8401c710f42071f88e4a341c80687440000a84249c4b83f737305420000a842f0b1833fd61ecc3f0000a842ff6c66bd9794033e0040a7423a567a3e0462d43d0080a7420000803ffd863141b5ebf93fdf14b5b9e26d4d3500000041546d96365efc734006c830ba8516003487e5dd1bf1d2cd3d698ee641849ecd3d0d04047bb3cd3d9639db4173f1e7ba44001200d600f3ff5e010500ec0101007702fcff0103070094030e0027041500b10407004005faffc9050a0051060d00a16c1714a74203237d3c4453a642d708143d2aeda54279dd513da36ba542a72fb53d8c5fa542e8a45a3e51e1a5424bde7c3e4c3da7420e57863cfc3aa7421ecfed3c1c39a7421927ac3d1638a73fa2cbb33f220d6a3f00000000000000000000000000000000000000000000204248e6383e000000ff000510910e02fc887701eb8c4600b0890a017e8c0f01988dba00a9906c01e78bffff8b89c1ff7b8f1b01d48f4900e08f8601fb8d6b01bf8bfeff908b03019f64a2037e030240a0b604652f07464b0c4e3caf93097aa89a463582e93c8ff00846dd9546b81e0e3dd0d10966bdb546839a533dd5d1082c64ad46a029653d818e07e4e28e46e839433db88e0a61c7d6460944473d8294097c22d6463899623dd1d309930ee346e289243dc6d0066a5f9f467fed5f3daaf0075000be46edbe463df8c7034a7435461a058d3de70432a5cd755c610600000000c000000000cb96a73f000000e09492a73fe277804200004243e91f1543a5c412436e611043de1d0e43fd9609434bed0343c631fd4256bff3426516eb42d6e2e2428d61d94291b7cf426512c04268b0a9428ce68642a34b4b42a0dea64017ceac405b2bb340308eb9408575c74024b6c240fed3ae402d279240dc6b8c403bd09440ebe88c40abe51b40988b014000ac1240c39a3840a840763b0000	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80101190000000000000000000000d6499e0bbaa1763fa9d10f16303e9e3fd77f32bd05dea83d8b72c9b7337bca3fd1b359f5b9aa34406868ef35b3079940e9263108ac1c04400000000000c08240601f8042ec46263e00ad9c070001190000000000000000000000d6499e0bbaa1763fa9d10f16303e9e3fd77f32bd05dea83d8b72c9b7337bca3fd1b359f5b9aa34406868ef35b3079940e9263108ac1c04400000000000c08240601f8042ec46263e00
6	3	2	0	2	0	0	nguyen-2021	70	0.1	0.2	45.39461288041251	0.3138528361227074	TRIMMED	STALE	0.0996	0.1	671	1795899559930237	\\x8b0480018204010001010b6e677579656e2d32303231010181f6e042c19a0c81b51801a1940c0081f6e0421390233d8310213d85bfddbe0ebac8b500000000b988a7babc8586373884d83653020a371475c2b200000000b3ce54b5db52c43832409936d74547b300000000be1c20b597ccbb36f3b0ccb100000000a68d6bb4ecafe72f000000007c3c023259854d380000000021df75353ef26a3f1b1c0c440ad7a33b5a8058beae3003bd0000000000000000029d5d3cb4615042010000c0410000c041c95d3a3f2857c43c000096430000803f000010400000000000d6f76939748f4a3a91091d3a00000000a3210c36235f293798af0e3800000000d10907becb1b3dbffb3543c000000000d10907becb1b3dbffb3543c0eaf487437ee18943c5188d4355f78c43c014e43c2110f239ee0d733d50b0444111bb3e3e974d893dbd4c9e4322cf2443dc44e341f9e6a042646333436056b2437bf05e43037f0000ff1fff8a029102e5b9a1d3c03cc325033cfeaf8437000000009bad163b0724813f3bda04a6bc08fd793f70198c3600000000d0f68abb8c02958f32408e06d041610605430a9e863b00000000edd7a7c00051dfa3f33e360ef740c3d98842261250b900000000532361bf3ba32e3ac11d7a49c3f77be44264486b420000000066883d428c029f659ac3d35c64c5e5ea0845cf81854300000000f03869440000592fc73f3338b5453cc805c329e20f40e03db5452cd405c3c42f7040a544b5450ee705c3c1aa87400446b5455a0406c37a43d53f7aad9346f1b31143820a8f3f8d3e8e4f790209c7b1dbac3e743b8e4f04d10ac7f235ac3e3098ca4da6e622c621f4753fbd2cfb51fd7dd2c653970e3fff009f54ad85114ae3d5b83f38049f54acca114a0600363f44029f54f73a124aa47932408daecf41db0206431af9853b0000000093f8a7c0b82b8e4fd78207c724ec3f49b82b8e4f008b07c733ec3f49be2b8e4f4b9b07c73bec3f49c22b8e4f38bc07c71cec3f490096f63b4c735c61060007923da03fa267333ffbbe24000000009b0f1942041f4d66753f5f9d71410000a8424251e93d38ca523e0000a742c8e70a3ed4d03d3d0080a742d72548b91da267370040a6422d8ea8375152f2330060a642c2e92d000000009d821a420f1f30f17fbd00dc47430000a64217668a4034d1f2410000a642b54895bd5422cd3f0080a742b48e9c3db118bc3d0000a7420129163d5c728b3b0000a742cd81a12afe40cc3de0fe2f429c58cd3d0b0108a835cd3d3cdc2d4260f7983b8a000200a0010d00b1020a00c5031000df040900f20512000507060016080e002f091300480a0c00fbbe249aaaa64277b1cd3c3b1ca7420dae963d762ba742ed58b83d183fa74282f10d3e8191a742ee0d393ee8eba7424e1e593ec17ea6429974743c3478a642a19ed93cc773a642e9469d3d9e4ea23e60eeb23e0000000000000000000000000000000000000000000000000000304272eee93d000000ff000d108ed100ef862101758bf500c18a8c00958b1601f28d7f00da8b8100ac8ef800e7893300888d4201ce89c5ff83892600858c6c00b78e0600f4887b017e35530fc2030000d19605a90d09468644743ca8ee07c84d61468d5d1c3db5d208846e85461edfab3cd9900719ff7646b8121f3d8bee094e74af4607050e3decce094210ab466dc0403db78d0836fd9e4629460a3dc7ee081109b7467864503d88b408c70bb3469f7b493d88b2071825a246db663b3ddb8f08228fc1460c691e3de1c8037f023346fc24803d9f057d6952735c610600000080bf00000000e0555ba43f000000003e57a43f8449354200007443186a97420e709342d9f98f42bfe28c425f928542e3497c4287f46d42e6b95c4256514b422dff3c42f0b31e426d69f94195efb94156348c41cbf7a74038db793ebcee4e404d885440eca859405c735e4000ad6a400e8c78403cca83405c1f8e408a599a401b1ba6402902c64002ebaa4063871140c3ad5a3c9a6e263d1fdb793e0000	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
3	1	1	2	2	50	0	nguyen-2021	70	0.1	0.2	45.34434392352871	0.3164291278206218	TRIMMED	STALE	0.0996	0.1	670	1795899559863259	\\x8b0490018204000201010b6e677579656e2d3230323181c2d72f0181f6e042c19a0c81b51801a1940c0081f6e0420fba213da56f683dbf50debe16a867b600000000c74181ba154d9937298cb336e5b71c3730a6c4b2000000005e4348b52b0fbd38e4018936060635b300000000fae272b5039ad2362153bfb10000000076d39eb3b660f32f00000000ff96003259854d3800000000d9b57e35a2cd6f3f1efbf34368a2b93b449f4dc0aa07a03c969e893e0000803f96f3843ceac35742010000c0410000c04158073b3f0558d13c000096430000803f00001040000000000048a27db9c51193bac2a86cbb0000000061fd093697cc2537bc98093800000000f5b0d63ca9d81f3d0a7664bf00000000f5b0d63ca9d81f3d0a7664bfa7d98443afb284434e628443a2b083434dcd8e3a65e6ef39e40ca83df2eb6242e1ef90403dd5ff3ee09f2643d895fd41f57736417fcf2043a5d98b43a4836a431e02ad42077f0000ff1ff28a02722ede3ac5a5823a9ca8d63a7a635db600000000bb463fb804d5bbb43a9254723d17297b3f1f9f2bb800000000b09d96bb02c0d3d93a339fd03c56a77d3f1cbeccb700000000edf277bb8a026eaf04c013f4a5c0a7d00343b73cf83c0000000030a18840011306cf3a5a1dd53b97ef7e3f7b384ab700000000032c48bb3fd6bde9bec0dd9440996d5b42a8019d3a00000000d404443f8a022c09dcc2ac1317c5a76de44444b3844300000000aaf213440000009da5883ff419134466959ac137c5903f951a1344aa999ac103d29e3f641b1344baa19ac1e17fae3f461b13445cb09ac1ea940541b0b0604624ba8f435504574082a2dc453e6d2c4329a1003f7cfc894f99be34474bf77f3f32c94545dae18b40ae1dd33dc0684f4d73b33946aef11a3fa2092c54c7cd70c9129c923fe0092c541d1870c9aa9d463f85082c54f7af6fc9b0f7b03d29022c5469ba6ec939cb04c04ffca5c03dd00443a443f83c0000000091a1884041ff894f5e023647856099473eff894f84ff35479b6099473bff894fd6f93547c760994730ff894f5aee354717619947009ed8434b735c610600077ae0a13ffd18333ff1c317000000008c3519420d1f01ad0ebd71a609410000a6423c8391bc62d4ed3f0000a64271f585bc6a2ded3c0000a642e85dbd3aa2eede390080a64200000000000000000040a642e2b130000000006d741a420e1ff89083bd0d853c430000a642461508c06b97c6410000a642026242bf7e2581400080a642eb421dbd2d12853e0080a642a2689f3d998edf3c00a0a6420000803f40c6bf412394a341c98337ba39182d35000010414f28dc38f50bd14335866abcad8d033597838713f1d2cd3d16619d41fe40cc3d09040405e7cc3df7ab9241f64ad3bb4400d1ffcd00d0ff5701cfffe201caff6b02c1fff502d5ff7f03d6ff0904c4fff1c317a720a64250528a3c649ca542d0d9173dfc52a542fb1b4e3d4235a54262a7db3ddf7aa54274cc2e3e15eaa54249ec433ec043a642b398723c0544a6427707d93c3144a6424b2f9d3d000000000000000000000000000000000000000000000000000000000000000000003042e373663d000000ff01949e1e3dd3de4c409f995f3f0000000110878d00bb8b8401a4893b00818936008f885aff7a8d8400f18d5300c98d3a00e57f7301c18cb7ffb0897401848d6400f18d7d01c88775ff958cad00d039040d7f030020d5b903a459b6454eece2ba9cd107c8dc54469dea1e3dc1ad084a74834612fb193db28f081f7688463a70ea3caccf06f62f6b466a89423db9f0075f219646f275033db1f007f86b9246943b353df28d08e240a14606b9473defce09dff8be464428343dfccd09a8abc5467f543e3de38d06892e934690ed473d8fa60639ba9b46af09593d9e05db6351735c610600000000c00000000020009ea43f00000060c196a83fd55d3442000072430f499a42810f984252e195425abe934218d78d421e0d8742bc0680424b2e724238f36342a58055428dbd3442d2a018426904f74136dda5416865b940b1de8a3ec0964b3bc8894e3b4383513b0883543b55435d3b2a43683b8fdb743bcc5a813bfe52893b987c923b059aac3b04c6cb3b7caafa3b0e7e383ca74b173d2dc5703e0000	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
2	1	1	1	1	25	0	nguyen-2021	70	0.1	0.2	69.99071077355408	0.09987991573942093	HEALTHY	STALE	0.0996	0.1	300	1795899559863259	\\x8b048001800400010200020b6e677579656e2d3230323181e1eb170181f6e042c19a0c81b51801a1940c0081f6e042390c653d7dfa9d3d9e280bb9def1903600000000710761baa165823782b579b64ead8e36ae60c7b200000000eb7b8eb5567e6a3958b50936f59f57b3000000007e401fb605aa083612581a2f0000000007241f326d55d32f00000000ebba2a3259854d3800000000888a0b36923f6e3fdafc80430ad7a33b850117bff76648bc000000000000000030637f3c10b8ff41010000c0410000c041cbc7403f18fec33c000096430000803f000010400000000000abe80fb91fa627bac962b3ba000000000ee1d3356fca0e370eea0738000000006ee7e0bbcd844ebdccebdebe000000006ee7e0bbcd844ebdccebdebeb485824320c800437ff1f53f04e19a3ec780543a5654cc39a888243db3b8f84039d6863dc084473d221215434bdf09422ccbd84168c32c4327cac0432279b742a0460342037f01fffffffff001b8a9d23f4885513f30897c3fa1c4b73900000000d90f1a3df40106e1d53fc595713f8c8e7c3f006cbc3900000000f485293dfa01e0114e4363870d4353bf7643c4fac53d00000000967b2cbe07023d4f3e2962883ec5dfdf40e4f1a8b70000000060f5babc35a71d0941f6411841b34953427abe0a3c000000005cc4833f9701094ad6c42d3187c53f4f3f4296af074300000000a1b76444fa01f2f79fc51c4d39c6f1a7d8421a975943000000004c9c1c45004111d87ec37ceb28c4cbe6fd40aefa764200000000f902e9425552864002b3174826362fc460c1fd3f248c21482f5d31c4107e2c3f389ece4fcb01534537f97e3f3e3bf74826dafc42e652b03e484d194d03232145face6c3f2bd7cf54d7ba54cafa808b3fa753a55513b823ca617dbe3e364da5557f0223ca54bfa33e3eff1253742449c9239f3b43a5a90243d5e56c432094bd3d000000003a7406bf1f3c4243cc150643ead7704327a0c03d00000000eebabdbe8ff0c64fedd5dc45a63c924b7b30c24f120414465eef994b0096326349735c61060009fab905407a7a653fa5c108000000008c3519420d1f41a231bd689322410000a6422bd4d6bd3b0bf23d0000a642fbdfe4bd3fce593c0000a642322bf7bc6efa253b0080a64281c46abc81c46a390020a642e6a33c000000007e571a420e1f2d2f8dbd7c1d4a430000a642c0561940bd5be1410000a6421642563fbda2a2400000a642fc1c14beffb28e3e0080a642655ecebb9dec273c00c0a642d39f8a2acccccc3dac4f2f42b512cd3d0a08087a6dcc3defe12442b1aab1ba890005009c01f0ffb402f7ffc903f9ffe304f1fffa05f3ff0c07feff1f08f7ff35090000a5c1083a16a6427f61893cb983a542a30b003d132aa54265af713dcd3ba542c2a3e53d3b78a5421c54383e84e8a542aec64f3e2251a6428c04793ce355a642fc39dc3c5f59a642cafd9d3d000000000000000000000000000000000000000000000000000000000000000000003042d555a33d02020000010000003f7fd99d3fa182263fffff0005108e1501f582fd00af8e1d02e48e2801e68a6100ca8e9700e78cda00bd8a9c00b38ecd00f28c6401c08f5901f48c1501d88eb200f18aa0009a8c1e01cf8ce600bb0100009afc0184852b45b6d8103ce9b207693b5546b17bc93cbeef0406a00f469bfb3a3db4aa039302f245e169003dc5f20459153d467f25953d80d0071f979146e37e573dccef037e8c1f46bff3b03dda8f0bf859d946bee07d3db3d207a036a0462267783dfdcf0745adb246913b823de5ad0830ecbc4687d6a63dcb89029967d645659c963dac02db6351735c61060000000000008fff8b4200802744fc762544e20d2444932a224401c81f44881f1a44064914442ae10e44fdfd0944638b0444696dfe430f63eb439f8ada43ed3fc843bc39b543a730994312e56443f75f1544f07e5f43843caa42c6640c42c2e43e4152c26841dc348e413240ad4127d6c0417ecdaa41872e284128cb524147ae8c417b058041da87063d71e93c3c0000	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
7	3	2	1	3	25	0	nguyen-2021	66	0.1	0.2	66.02375847076655	0.08744393483471993	HEALTHY	STALE	0.0564	0.05610445272379032	692	1795899559930237	\\x8b048001961e0101000b6e677579656e2d3230323181e1eb170181d2f83ec19a0c81b51803a1f10600f6a1370bb9b9ac3f0081d2f83e909d863cf21ebf3c94b2bc391d6c0437000000001b3c923aaeec5437288d173500c450369c70bbb2000000006451a1b4ef8b5e399100ef35c78585b300000000a59bf6b50c6eeb35baac1330000000009c170c34aac3d32f0000000050e81c3259854d380000000068bc9b356ce3723f897216440ad7a33b1e04503f0c3112be00000000000000002411703c025c6342010000c0410000c04184e4393f5765d53c000096430000803f000010400000000000888a61b7e2700f3849ba6c3a00000000ed70d935c2f9113727690b38000000007d7f7abd1df2d0be4b800fc0000000007d7f7abd1df2d0be4b800fc0bea86542a59b9641690ce740cd8be03fee20803f3318803f861d893fab1fa74172e4813fae518a3fe316e6420cf58142a6acd34109f02d42c79f15432b45804323fd1443057f20ffffffff06310f9e3c7c0cabbb5f527f3f4e9be3360000000085a58e3b04c288613cefdc4b3d10747f3fc5f994b600000000e41d233b87023f223343f868a94213d16743fabb933d000000006fb224412b37f7394031b52cc0bc5c2a423d6b203a00000000c69c033f0e35929a3ec2a955be53565f41e0a31038000000000bc46f3d4a548836c4a88928c4e19200c335f78f4200000000fdc6c04187025e91cac5f0c46cc67fb1f6414609674300000000af540244007e4e75c9c45d8d1ec57fd606c38adfea4200000000ee668142b95d8b3faf9616462ec323c24f1a863f48cdf245edb809c24068aa3e83b49e4fe030a34747ab6e3fc5190c4c4c6ce044068a803ffb21b749dbfbe8c26d14ca3e1ef801535ed61e494bba173f2e9da0552511c048aaec323fd39ca055959ac548e5e81d3f93a23a549af088496bff2f3d33348c3ea8ccbf4069d7a1b6000000002930653c27ec7c3ced79323e48df7f40211c88360000000036a1133cde39ba47c02ce6c2bc08cd46ff22a7468ee638c2a57a2746008f0000000000000000000000000000000000b0cbb9b68ed7b00600000000007536fd410000de79703f12b858416adfce3f213efe3f79f3053f1366623ed18c27bb64a4a33b000000000000000000000000009af702420000b3286c3fb4e6404311febb40dcf408424e88753e357e7b3fda5c3e3ece7f923d7a9e06bcd244583ae1b0fc3fe4aa0d42809606421fa0323a293ec0359ab9b5419da5583937768f4430bf8d3c6c889c3400fd9539425906053dddad39422f8e6d3d7dd73942b8a79e3db7e63942c141df3def0f3a4210c37f3ef5a93b42b7cf8f3e7882394232fa6f3d2d813942f156fa3d5b803942e995ce3e000000000000000000000000000000000000000000000000000000000000000000000c4280992d3e000000ff0002108f5601e38b2900a88afe008c8e9d00ce8d9201bd8d9f00c08db700c78e3fffe3864301768af6ff8f8d6e00ce88fcfe798f9c00ee884600808a4e00968d4300c201000099f805e3e42f46a702963ce9ef07dbec6e46297e963cfdb10764b67f46ef98173d94d109b421ab46b1b44c3ddfef090fd2bd466701f13cb8af098489c246b5ee503dcb8e0ac101df462ada403de3f3080bcbc8464fb24d3d87ee08f2f6c046dde53b3dfdd0080384d846a059623dedcc0bb3700347df90553d80e503a2c452464bab693db4057d6952735c610600000000c00000000080344fa53f000000a0496cab3f0100000000000000f6a1370bb9b9ac3fdd5e78d2d57f5040eda2e9b59f98b93fc3f50243489c45e1353bbb9b9004afe1f645bb6d573cdcca037eeae5455eac0e3de5d205343c4a46ffdeb53be592033e0ff1452908d43cb8ef048190404638b1083d89b2048d9b3c46fb1e9c3ce98e06a4ac8746a3c5523cfeec02e68500466fbb4a3cc6f00579078f46ab908c3c80f104b4a88046ed48e83b838a03b6bf23468eeb003df6a1370bb9b9ac3f02010000000001adcfb751d2d2ee3fb470a88e0c0cef3f657765f20e4cef3fe3775a1f5d8eef3fa10a7b7c67d0ef3f65e45d345d08f03f3680270b4427f03f3ff0db03b244f03f54c02d358d60f03f387bf8bbcb7af03fcac102216c93f03f6c6f868e70aaf03f00645f51735c610600adff834200c027442d9b25448a132444e4ff21444fdd1f44e4fe1a44cf031644b2c9104431df0b4443750744263d0344a013f743c5e8e643e64bd24313a2c043273e9c430e137643ad6ac442d51996426cd98e420dab8242ae5ae741aae3ca3db1f4013ca2dd113c36b8223c0c9f353c305b613c13b9903c36e6ce3c1aeb113d3868ae3d6aa5773e0000da3cbd98757f504064000000000000002a8c90c0b941a4c01cb6bfc0384fcec0551fd1c0af60d1c02564d1c07564d1c07768d1c03f97d1c0e2e6d2c035d4d8c0f7b1eac004e208c17d7e2ac1e06459c10a3384c133d18fc17c0692c1bc3992c1723c92c1953c92c1953d92c13b4992c1e19c92c1541794c1e08c98c1784ea2c14f19b3c13f8acac1d00de2c14db2edc1b1e9efc1311df0c1e91ff0c11320f0c16521f0c1de30f0c10da0f0c17d97f2c10287f8c1a0c202c241f20dc260911dc260402dc2970735c2438336c2c3a536c297a736c2aea736c256a836c20ab036c276e736c299e237c218d93ac2445641c2a1834cc23f215cc234d26bc2a19d73c2bb1a75c2643d75c2393f75c2513f75c2f93f75c2a54775c2e57e75c2727976c2ae6e79c2e9e97fc2828a85c28f588dc2043295c2d81999c219d999c284ea99c270eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c278eb99c21f85eb51b81ee53f130015000001010183e0f323a20100000a000000000000000101026380f9755c6106000000000000000000176a3a735c6106007e973a735c610600	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
5	2	2	1	1	25	0	nguyen-2021	70	0.1	0.2	65.89465066777655	0.2903419990119249	TRIMMED	STALE	0.0564	0.056097985000166134	648	1795899559930237	\\x8b048001921e000101000b6e677579656e2d3230323181e1eb170181f6e042c19a0c81b51803a1f10600fcf8e405e0b8ac3f0081f6e042ff35b33cc96d71bad08d77bd073f3f36000000002d780e3a70a9d13863fd1738c9c12c386b82ddb200000000111a7fb5f0008c39c8b18f37e4a483b30000000031341eb6b8f69b37905e3eaf00000000de8016b3a8bbd22f0000000026bd1e3259854d3800000000cef48b35f289613fdcc300440deeaa3b00ea883f66c007be0000000000000000e462723cb9db4f42010000c0410000c041bbd6393f620ed23c000096430000803f000010400000000000e6af56b976d47bba0bd801bb000000005b68c3356bf305378d800238000000001b73e0bdc83323bfb17836c0000000001b73e0bdc83323bfb17836c037a65243d469a541dc4a3e4163141440b65d5d3a5bc6e539ba152f3de959a2432758bb3b50303a3d1a45ec425c113c423344154268195e40a9f9254307f434434c2cb442037f11f1ff0fffca018ed0044081253b3f6197733febe1563800000000ffb2993b04d072983ca0bc2d3e74667f3f78263b39000000003ae5043ccc01e0995443f0c89b4271b646439db6ca3c0000000034dd753f104b8a8a3fa49fe33f1e377f41d10c233b0000000036de403e2fc6c52841a42e4640faab3a420c5bde3b0000000071552f3f01f55cf7bd350525bf52502d3cbef57f3f000000002e397abdcc01944a9bc54f3b2ac6ee7553434c7b384300000000bcbcf2430046880d08c40eaf3cc420f3b141785d864200000000c5c30a42ea89e43f3a2d5d4654643ac3abd72940b3305d469d673ac33b46584087315d466f693ac3b5870441a6e14a466cfe8a43a5d5d03e824a1d4fb370954777f0863f10bc994a71fbe4c43647ae3e984dc54cdf86ac45b9e07f3f86af5349741fee43d6a5583fffa92f55d6bcbcc894043b3fc3ae2f55f276b9c847c0463f8c074b536d822f48aae0bd3cfac9103efecf7f40c46eb53900000000e41e783c014f514768f661c3fa619b46785051470ef961c346639b46774e5147def961c35e629b46009f517f51735c6106000100000000b003673d8ff7800ab1cc4e0000000064d805420c0fcaa16a3f34b0874100003c4236253fbf6714364000003a4270cb86befdd5463e00003942649132bdf2051d3b00003a4200000000000000000000000000f3e10a420d1f9acf86bce4df4d4300003c42ca1e35bc92afc44100003a424a31483f24f1134000003a42ffaf13bf0e3a653e00803a4209826cbc4df18e3b008039420000803fbbc0e34121a10942007de238f7528d3400003041dbf75b39b4fb9344e586733bf2604832c1e3fa098b8e643d03e921418b8e643d0902025e0c653dcc4c144193b30dbb2200fbff6500fcffaa001900ee001c003401200080010a00c80124000c021d00b1cc4ebafa39423414e53c58c2394283ec4a3d86c739422127923d34cd39426a73de3db0f939422a998c3e13933b426a8aa13e23023a4270274b3d0b013a426adbcd3d51003a422baaa63e000000000000000000000000000000000000000000000000000000000000000000001442ac585e3e000000ff0007108f6e01d4912202f3906500e48d6800ae8feb00cf8c3c00a28c3f01a0905401d7909600d08d0400a9890f01857fdc007f8ceb0097895f00e58a06007f815c03e5030000a396041599044672b91b3b84d107fb6983467312423de2ce090087b146096bf73c97f206c54288462e97363d91d20ab3c1e046f3bc0b3dd98e089b23b946f1542b3df6cf081403c9468c4d463da5ef09bec1fa46254b5d3dbd8e08d15bd6468daa603d97930965aeff4658dd7a3dceef0960880b4766e4803de4c502bfde1246df998c3d88057d6952735c610600000000c000000000402255a73f000000803d66b33ffcf8e405e0b8ac3f0000010200000001917627f9e120ee3fa723a80a9351ee3f5636118ad287ee3f5f9390a023bfee3fb73b35ccf3f4ee3ffb3f758fcb27ef3f03692423d956ef3fe21f2669ac81ef3f41c3c9860ea8ef3f7339a169e9c9ef3fb1ffb1a838e7ef3f1f2200000000f03f00a11482725c6106008aa1834200006b4382c7534394de5043aadf4d437e944a432ea74343a6d03d43468e3743affd2f43c008284361f92043fb9a144302ce0a439ad203439d7ef342ee7cc442a5e89a4290276e401f067540b3e76e405a825740958a224066bdc33fdb21883f60a8283fc726613e35d7be3adab7ce3a2f50dd3ae309e93ab956fc3acd6c1c3b2729463b00008e98364831745040640000000000000068d492c0fccc92c056cc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c04ccc92c0676666666666e63f00000100000000000000000000000087b38b725c610600feba8b725c610600	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
9	4	2	1	5	25	0	nguyen-2021	68	0.1	0.2	68.05616263443537	0.08961737665635709	HEALTHY	STALE	0.1404	0.13965569095643893	682	1795899559930237	\\x8b04800196160201000b6e677579656e2d3230323181e1eb170181e4ec40c19a0c81b51803e19111001cd9add83ce0c13f0081e4ec4022409c3d527bd43dc06b583ad9fa6bb600000000a3a867b96806e33783d1efb6fbc82d360cbab0b200000000af4d9db4cb096a39b74c383564e059b300000000f128d1b594b6e835c979093000000000e5aa06344e5fcf2f0000000020be073259854d38000000008a2c81353f4e663f859908440ad7a33b2f96f4bdafb8363d000000000000000042e4693c6e605e42010000c0410000c04107893a3fc142d33c000096430000803f00001040000000000046b697b616cead37b1d9053a00000000dcd03335eb5884367fd29e37000000005b8fb8bd6ee9efbe53c9e0bf000000005b8fb8bd6ee9efbe53c9e0bf19d99e4102032141c35e24402ec7163ffeadb43bd2bfc93a91e8353e5d916642354313416284a13ec0e70542d56ef441fb8fad41979d03422f330b427d590c4244620942057fffffff0ff20a3c8d113e7a1c5ebec7ba7e3fac3c97b700000000106dbfba0543c9a63d920b23beeb517f3fd2c0aab60000000030514bba23800737413ce295c0ab270a42a7e1163b000000009500ea3d000023990858c4e62b7ac416f635c224ce084200000000dfead94100000043fd99403bc12c46b61b554396add23feec3c3457a1d0a432d4e753f539a644bb5628345273d603ffc98644bd2568345134c1c3f1a93644b602a834570957a3fa2a5d6511eee0bc74ca2803fb8a5d65130d30bc72d917d3f8ea5d651a5c50bc72b13693fd1a4d65118aa0bc7008f0000000000000000000000000000000000baa5c7b68ed7b0060000000000ba75f241000060d0763f15491b41bd78783e24b9ad3d1620c2bd2da6663c640380bc2cea6539000000000000000000000000000e4af641000078816f3f747e3043fb30c63e5a6eb9416571f43d7d987f409619673f54de0b3f0449853b4137003d1fb33840e6d3fe41ce1bd6418046c5ba306e5a3576eb854177cd1d399a253244007e34bd6d04383600fcfff442dae1113d8a23f54296b2aa3d074ef5422539ed3d0185f5427f97193e5dabf5421c4a4f3e09eff542fdf6473e0700f5420ff7933d0200f542f8e1203e0100f5429538083f0000000000000000000000000000000000000000000000000000000000000000000004420cf7bd3d000000ff016dc4e53df90fbb40f850ec3e00000001108e0101cf900b00f78ace008c8e4801d882d7009688c300bd887100798b1700918c7e01a28a2d00908b1e019f8c7300a78a7d0190905d01f68e3300cd8e5301e0010000fbb70497f3fc454c87f83ccbd00800228446ed102d3d8ace0a2811b2460b6f283dcaf00827dda846327b453dfcd1098f4eb9463ed34b3db7900671ed74468eef313dfcce0ae33de0461a9c5a3d95ab08ef72b346350a463deccd096302d046b269753d8a910bceaf03471425713d99ef076782c246cb5d563da3e801d0f4d1450406933daa057d6952735c610600000000c000000000c00d14aa3f000000c088daa53f01000000010000006ab29633e9c6c23f0e0d332ce5ff504024b20fd8c493b93fab9502546d7745bbd28d3cc3f204287f2d46a4fb5b3deb900409152346e2fa543df08d07dd4f9846691d8e3dd9ae022ec0da454650353df2af04be9e5346b4bca73df6b2035d6934467912873dd39006eb6b9f46347cb23de68f05fce18d46b3dbba3dad9105b9de9246dc8c993dc4cc04df3a7f462cd7d23da58b02f30f0646f48ec53d1cd9add83ce0c13f02010100000001c031b7a614bff03f1479ad34a1a1f03f9dbdf930f282f03fafd0dddecb64f03f72339e1b2f48f03fe99b81a2ab2df03fc9ccf6028f15f03f58bb7a010000f03f560929c31ddaef3fccb3c18a7eb9ef3fbdc4c6881c9eef3fb598337cec87ef3f00142d55735c610600e4ff87420080274436c62544de902444a4102344cb772144a0b91d4433ba194482171544762a10449c0c0b44fc470644d1b2fa4349cbe84390a9d643edb0c143a0ee9e432f09824357f0df42045b854260f51442cf17f1418001fd4119a9ff41c949f2417790d8416c7da84156978a4150e7954115f8cf4118f3e44105939741e8cb0f42994ffd410000d79143735c61060078b643735c610600	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
1	1	1	0	0	0	0	nguyen-2021	70	0.1	0.2	62.03972004101045	0.20139275943528973	TRIMMED	STALE	0.0252	0.0239163422454471	644	1795899559863259	\\x8b048001961e000001010b6e677579656e2d32303231010181f6e042c19a0c81b51803e189030034f5228f867d983f0081f6e0427252643a37b485bc443cf7bdfd817237000000002241c83ab0a0193843471237bcd56e37fbd6aeb200000000625c3bb48e349c39673ae736bdb86fb300000000c57c21b60e90f3369c02e03000000000957d8e34f1eccd2f0000000088d4123259854d38000000000ed88b3532b8713f3489d1431e6aba3b00f8a63fa363d4bbed4cb0420000b2422cbb8a3c2be93e42010000c0410000c0411d163b3f9a25c93c000096430000803f0000104000000000000a59dc3988a0073b17e2a73b000000002f8ec135ce28073703f507380000000011d9f93cc11ded3da7e2e4be00000000a41a02bebdc629bf3f791cc0c4700f446fbbf74534d8114454a7b63efe50343ae212ec39f155203d454c7f40aa9c4b3c03a0353ddbb91644b3451c45228e01442be05f42c3213043451644431cd64e41057f20f2ffffffbc015b482d3f5a7a033e63e3f23e363d25390000000029b70c3d7d7ac2f63ee77cd53e9735203ff3108339000000004664193de001b6e6b942d9db7142894f1743adb4163d00000000aa65a740007d3822ed41e9f121428f44cb4271b79f3c000000008d4e004069050303c3de67c7c4545b0044a0c5c4420000000037cd6442e001b6b234c567360ec638249d4458334543000000006c8b9c43000bf375c9c0fa5b80c153edab40d9083041000000009d5e9d3f5f50e84078c2c347c36338c4d553f043658625481133b9c4224a1d42498a2548faf9b9c41d476240621b3c4ffb2d0cc892138b41d3253c4f9fae0cc8685a18410f53934edd6ea6c7d447c23ea66a0a54bf9f51c874d7f03e55dc6455603a074a287f913f3be36455d9cc074a141d803fe8c8874e64e8b34411eb84421e004e42edfd07430904063d00000000c8d67e402e47e941ee4620422204cc422eab9d3c00000000f7d1fb3f6c72184fbed7f9c7397b184b8ecb904e1010a3c7d9e91e4bd3d2904e00d1a3c779ef1e4b008f0000000000000000000000000000000000bee6b0b78ed7b006000000000068ebfb41000078ff88bd1c0f134131aee2bce0a0d83f3a980bbe097b843c064e44bd74a31f3b000000000000000000000000003f9801420000409fdbbc369a094307e62cbff81ed941a8e817bf9b572640674808bedb70653df50297bdf7ca483cb0b3fc3f0249094213d4e8419b46c8bab638993589bbb54161993139c9bc5844223e36bd4151193600d001a5418d2dcd3cf967a4411477db3c81c1a3416047f13c6f8ba2415706213d4e06a1410b93a93d92cda041108f013eb84ea541a1a94e3d3f52a541f732db3d6a54a541e7ccb63eeac0db3e0906473fe4c48b3f62a5343f8f50e63e00000000000000000000000000000c424c05033e000000ff000d10892a00c98bde009590caffeb8d3501b1895e00948e0102bc8d4101d48edb00cc90feffe48bf201a18d0801b98c9e00a98a3901888dc201be892201bf3bf004e303000092d804d41815464884a83c80f005a1dc4b46de7a093db4b308ad18aa467956333d8eb10ae976ca4672e81f3d87d206ab258d46f2ba383def8e079d25a9465ad40e3de0d108421de54624343c3defad06dc7c9f4618ae533d92ef08860ce1463e547c3dfdd00acbe71047a3ec523de190081cb0e2461793583da28703ade24a461e5b8d3d8405db6351735c610600000000c000000000e05d98a73f000000600f60a93f010000000000000034f5228f867d983fb88ec2af2e2d4f404ea79c811a98d23fd7d601b43b2a4574f326bca29205ff380a466b812d3cdc8f0491d0fc45a3c10a3da19206b8024246f92d243cd38d043de30e4630ef9c3cc5920543d94346faf6f63bff8d046d101d4661f9403cd0d10558b072467dd3663cbab205f51f75466d26a23c9cd004329b5c461aed59bcf2cb02d1e30b4642fd303cffe80253340e465a1e893c34f5228f867d983f0201000000000194049fb48474ed3f4bd1e6617ad4ed3fb67daa649a42ee3fa83018dca7b5ee3f22f7c8753228ef3f564d320e0397ef3f7afbb0861a00f03ffcbfa9a55731f03fa3f05989e95ef03f2d0e2446a588f03fc51f4fe674aef03fe9e5a4924dd0f03f006ea460735c6106005338794200007c43c9df4643d9af4343120a4043c9eb3c43431536431a672f43d6b2294374582443bfc91e4346961943c63c0f43b8a50143429fe742a6d2d3429258ab42a46771426dfda23f6bb0903f8017713ffe753e3f2c09a93ee170bc3ae2d3c23a133dc93adb5cd03a7482d73afc52e73a380a003b54ca0f3b24c51d3b1e9f453be328873b000055f55042c7164f40640000000000000094348ac0481086c0679784c0443784c04e2684c0462484c01b2484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0192484c0676666666666e63f0000010000000000000000000000000ecd49735c61060069f049735c610600	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80100ad9c070000
12	6	4	0	0	0	0	nguyen-2021	70	0.1	0.2	70	0.1000417036743478	HEALTHY	\N	0.0996	0.1	208	1795899602154249	\\x8b0400800c0000000b6e677579656e2d32303231010181f6e042c19a0c81b51801a1940c0081f6e042a0125a3d73cb7f3d000000007faa2ab700000000a811d8b874be1437960819b500000000c2fae0b2000000007e92c4b5219bad3900000000b0a0a4b300000000f7309fb635120936000000000000000000000000d325d02f0000000075913b3259854d38000000002b223b36b7985a3f58a133430ad7a33b849b1b403c63003e00000000000000002c7f843c719ad241010000c0410000c041fb2b3a3f0963c33c000050430000803f00001040000000000085416a398436993a27ce663b000000003e4b9435ef4cd5364a52e63700000000ca532f3dcc555a3e75a3fc3e00000000ca532f3dcc555a3e75a3fc3ef5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43f5ff1d43afc8cb41871aff4258e12343a8f61c42007fffffffffff9e01000000000000000000001e4300000000000000000000000000000e7dc605c22117974100000000df7a604100000000111328419e0105a25bc52e4b22c6000000001f7a134300000000ddfbaf440000ebff7f3f0000000000000000ebff7f3f0000000000000000ebff7f3f000000000000000016b67b3f835b174f45fd7246638d413f3efeb154e4ad42493ab7843fd5fdb1543d2743498c83d83dfce8b1541f724449009edf0bd2755c61060007525dd6bf59ca323f00000000003ad010420a1f086faabd8d9e5f410000a64230d5a9bf82e2f53f0000a742988cb83e573e4d3e0000a7426883223d11685e3b0040a7429e5d6fbc9e5d6f390040a642e49a1f0000000023f51042001f53e350bfbfb370420000a6426dd58abe15ea11410000a6422436ae3d2a99813e0000a642f2108fbcf701693b0080a6421eab8d3c400f2d3b0080a6420000803f12a4bd41cdf2f440b20497ba4f7785350000e040dea87b37be5f6a42b57f10bc152db235ffd586104d84cd3dfd817541a835cd3d0b010117fbcb3d310b6041c6d1f5bb2f0000007e00e7ffd400dbff2e01cfff7e01dbffd301cfff2a02dbff8202e7ffd402f4ff2f03e7ff0075bca6427283a73cd781a6428594413d9c31a6428b9dbf3d143ca642daee1f3ea93ea6425153143ed2f2a542942f4a3eadb2a642e594833cb3aea6423befe83ceeaba642e250a83d5767503f9da5543f00000000000000000000000000000000000000000000000000002442d1e8313e000000d00000108f7500d57e6d01e68ed601ca8b6101978dec00bf895f017c8cdf00c08d3000bb8b1100b4860e00808b65019b8f3d01eb8e0d01db8c1201b88cf700a78872017f010200ee9303088dc7455445043d84b00247449b4524f61e3db7ef03b5c51446b513ff3caaf004a0864d46535f3f3dfbcf04f8994746e31a593dd9ae05659f72460c23073d86ce05c0197146be6b903dcab20406724e46fd195e3d88b0045601714611da793d94d1042a476f4615a26f3dbaf1035f3b4b46bbf4833dc6a9025bc1034604e2a23dd00109b3d6755c6106000000000000008c420000504331834b43f88d4943aa4f474366fc4443d89d40435f063c436ffe36436f8d31435f342c43fc802743ad841d43e2a31143ee0b0743d422fb427feec2422e2790425c0a6a425f6c2642ca350c42df38004220752642b8296042e0ae5742327d05423d5ad540d46ee6400188d840980ecd404475f340631e10418a84214132c7f9400000000000000080514064000000187231bf7c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c07c39a9c0000000000000e03f00000000000102019691f423a2010000010000000000000001020066db08775c6106000000000000000000	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c801010c0000000000000000000000d8b0a7cef0d2753f841a6c1f842b893f3ce742bd18c2543d88ce467b8692bf3ffd997ecab35f20400000000000408a40323333333333f33f000000000000724000008c42aae2cc3d00ad9c0700010c0000000000000000000000d8b0a7cef0d2753f841a6c1f842b893f3ce742bd18c2543d88ce467b8692bf3ffd997ecab35f20400000000000408a40323333333333f33f000000000000724000008c42aae2cc3d00
11	5	3	1	1	25	0	nguyen-2021	70	0.1	0.2	69.9925212001339	0.1000260336220851	HEALTHY	\N	0.0996	0.1	615	1795899601560882	\\x8b04008004000101000b6e677579656e2d3230323181e1eb170181f6e042c19a0c81b51801a1940c0081f6e0424c274b3dbb7e743d5a12e0b84bc3fd3500000000b5ce273a58755f37b65aca36ef879236c8b0c0b20000000037d66bb5e183f138fe3a0e36d65e6eb3000000006e5436b6ab0e0936fe49692d00000000f4bf2731e116d82f00000000886d293259854d3800000000af9dae35144d703fba7f02440ad7a33b4bd06ebf4270d2bd00000000000000002057763cb40c5342010000c0410000c0414250383fd9acc53c000096430000803f0000104000000000008f439ab9d89c88ba1c560ebb00000000c2123d3614165437b182263800000000d6d6e3bde5ab17bf915f1fc000000000d6d6e3bde5ab17bf915f1fc029d0fd41af69fe408062d13f42808c3e0a327d3a3691f839230e583de19e4c41176cde3ec3b6993d31513d4391bd604287c8df41b7b3ee421b8f9a437fdb1f43e2bd2142027fffffff1fff04b206403ce1bd913c1002803f8f79b53800000000e859cfba9001237112425097ddc08839104346e4793d00000000e7c69dc06e09adac41c8fdcdc08f40dc42b1bc173d000000000fa352c02a8acf5d4048e938c04611284221dd663b000000006dfd4fbf44dfde54c3d33a90c3aad4bbbfb2098442000000007ba5fa42b504c76e3fc6c41cc3c681c0dec2c1f3e44300000000213da84544dfde54c3d33a90c3aad4bbbfb2098442000000007ba5fa42294926a8c2813305c3ec5f06bfd93e21420000000016b54c42fae8dc3f155f53464254f4427389373f392a134f8817a5467127be3e693e8a4ea37675468e6be23e30ff8a4c98648d45948fef3f9d3417538a8f68c9359ce73ebb670c57024731cb81f0503f54301753266f68c9c0481d3fdae20e528aa6c8c8009ead13cb755c61060003a7e8583e50fc983e93e72a0000000017590e42091f34e644bddbff46410000a64265d345bc9acade3d0000a6425ef0a43d3f93723c0000a642ffa243bc83ce82390040a642cc44cb3b0b822b3800a0a6429eea0e00000000ce5a0f42071fda257cbd614f3c430000a6423246373f7edeb3410000a642a3964f3eabe3e43f0080a6428d341dbed1ac9e3e0000a64220c9eabce0f4033c0040a6420000803f4086c241e6d5aa4140f6053b5bd25c35000010418dcaea389001e443e9ca323d96338c369d95b80f849ecd3de6af7d41013acc3d0f0102e686cc3d3b2874414887aebb2200ebff6300d7ffa600daffe700e0ff2b01edff7201cfffb601cafffb01dfff4002e7ff8702eaffd302ceff1803d6ff5c03d0ff9f03d1ff93e72a4248a64209426f3c9c85a5423fa10d3d8b37a5424ea06d3d3737a542dc91ee3dd174a54221a83d3ec6e5a542a611593e0065a642363e803c8a64a6425bfde73c1f64a64220bcaa3d00000000000000000000000000000000000000000000000000000000000000000000204257ddc33d000000ff00041087f400c68ba400a88b7d01ac8c2600c589bb00958dcf00e1893c019b8b6300aa8d6e01d08c7801c38a5c009b89ef00828b9000f08e5400e48a1201988a5100990102008996063ca61a46dbbf273cc5d00c9750a646932c163da2ef0ab9b79b46ceea363db59011168cf84607c4233dfcad0ce121cc46e4ee413dd1900d591ae3462190483de1b00e08b7f24631c5643d8d900d63b2f346f2fe633dd7cf0c5766f146205d7a3dadf20b7a42e5465503443d9cee0b7de3e946f714853d94aa060fb4954656398b3de70432a5cd755c610600000080bfe1ff8b4200c01944606d1644b2ff14444e2e1344cd86114490480e44edc10a4481cc06445a360244fc75fb438f90f443fa65e7434733d843155dc8439f5ab74351b5954356dd6e43f603b643560779436e5a04431f66c54218320e43a42012438e209542aaa2a3408f5c9e4042af7a403f484640f2c65c403e5579403fec8f401e3fc94003d013410000	\N	\N	\N	\N	\N	\N	\N	\N	\N	f	\\x018cb8c80101190000000000000000000000b666ced0cc0b78bf4b3c72a35aea953f07aa82bd8cf03d3db549c892ecfdce3fa2d634ef38253140ad5f9eb140579b40de718a8ee4f203400000000000c082402cfc8b4273dacc3d00ad9c070001190000000000000000000000b666ced0cc0b78bf4b3c72a35aea953f07aa82bd8cf03d3db549c892ecfdce3fa2d634ef38253140ad5f9eb140579b40de718a8ee4f203400000000000c082402cfc8b4273dacc3d00
\.


--
-- Name: actions_action_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.actions_action_id_seq', 17, true);


--
-- Name: alarm_shelves_alarm_shelf_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.alarm_shelves_alarm_shelf_id_seq', 1, true);


--
-- Name: alarms_alarm_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.alarms_alarm_id_seq', 5, true);


--
-- Name: arrays_array_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.arrays_array_id_seq', 6, true);


--
-- Name: black_boxes_black_box_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.black_boxes_black_box_id_seq', 12, true);


--
-- Name: boots_boot_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.boots_boot_seq', 4, true);


--
-- Name: calibrations_calibration_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.calibrations_calibration_id_seq', 1, true);


--
-- Name: changes_change_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.changes_change_id_seq', 221, true);


--
-- Name: compensation_errors_compensation_error_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.compensation_errors_compensation_error_id_seq', 7, true);


--
-- Name: compensation_refinements_compensation_refinement_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.compensation_refinements_compensation_refinement_id_seq', 3, true);


--
-- Name: health_changes_health_change_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.health_changes_health_change_id_seq', 34, true);


--
-- Name: notes_note_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.notes_note_id_seq', 2, true);


--
-- Name: quarantine_quarantine_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.quarantine_quarantine_id_seq', 1, false);


--
-- Name: robots_robot_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.robots_robot_id_seq', 4, true);


--
-- Name: rollout_events_rollout_event_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.rollout_events_rollout_event_id_seq', 1, true);


--
-- Name: setpoint_states_setpoint_state_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.setpoint_states_setpoint_state_id_seq', 32, true);


--
-- Name: touch_tests_touch_test_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.touch_tests_touch_test_id_seq', 9, true);


--
-- Name: webhook_events_event_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.webhook_events_event_id_seq', 40, true);


--
-- Name: webhooks_webhook_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.webhooks_webhook_id_seq', 1, true);


--
-- Name: whiskers_whisker_id_seq; Type: SEQUENCE SET; Schema: public; Owner: -
--

SELECT pg_catalog.setval('public.whiskers_whisker_id_seq', 12, true);


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
-- Name: archive_horizons archive_horizons_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.archive_horizons
    ADD CONSTRAINT archive_horizons_pkey PRIMARY KEY (fleet, shard);


--
-- Name: archives archives_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.archives
    ADD CONSTRAINT archives_pkey PRIMARY KEY (fleet);


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
-- Name: black_boxes black_boxes_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.black_boxes
    ADD CONSTRAINT black_boxes_pkey PRIMARY KEY (black_box_id);


--
-- Name: black_boxes black_boxes_robot_id_event_us_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.black_boxes
    ADD CONSTRAINT black_boxes_robot_id_event_us_key UNIQUE (robot_id, event_us);


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
-- Name: console_sessions console_sessions_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.console_sessions
    ADD CONSTRAINT console_sessions_pkey PRIMARY KEY (session_id);


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
    ADD CONSTRAINT epochs_pkey PRIMARY KEY (fleet, shard, epoch);


--
-- Name: event_outbox event_outbox_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.event_outbox
    ADD CONSTRAINT event_outbox_pkey PRIMARY KEY (fleet, shard, epoch, number);


--
-- Name: health_changes health_changes_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.health_changes
    ADD CONSTRAINT health_changes_pkey PRIMARY KEY (health_change_id);


--
-- Name: journal journal_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.journal
    ADD CONSTRAINT journal_pkey PRIMARY KEY (fleet, shard, number);


--
-- Name: leases leases_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.leases
    ADD CONSTRAINT leases_pkey PRIMARY KEY (fleet, shard);


--
-- Name: log_archives log_archives_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.log_archives
    ADD CONSTRAINT log_archives_pkey PRIMARY KEY (fleet, shard);


--
-- Name: notes notes_action_id_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.notes
    ADD CONSTRAINT notes_action_id_key UNIQUE (action_id);


--
-- Name: notes notes_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.notes
    ADD CONSTRAINT notes_pkey PRIMARY KEY (note_id);


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
    ADD CONSTRAINT redo_pkey PRIMARY KEY (fleet, shard, number);


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
-- Name: rollout_events rollout_events_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.rollout_events
    ADD CONSTRAINT rollout_events_pkey PRIMARY KEY (rollout_event_id);


--
-- Name: rollouts rollouts_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.rollouts
    ADD CONSTRAINT rollouts_pkey PRIMARY KEY (rollout_id);


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
-- Name: touch_tests touch_tests_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.touch_tests
    ADD CONSTRAINT touch_tests_pkey PRIMARY KEY (touch_test_id);


--
-- Name: touch_tests touch_tests_test_id_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.touch_tests
    ADD CONSTRAINT touch_tests_test_id_key UNIQUE (test_id);


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
-- Name: webhook_dead_letters webhook_dead_letters_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.webhook_dead_letters
    ADD CONSTRAINT webhook_dead_letters_pkey PRIMARY KEY (webhook_id, event_id);


--
-- Name: webhook_events webhook_events_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.webhook_events
    ADD CONSTRAINT webhook_events_pkey PRIMARY KEY (event_id);


--
-- Name: webhooks webhooks_name_key; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.webhooks
    ADD CONSTRAINT webhooks_name_key UNIQUE (name);


--
-- Name: webhooks webhooks_pkey; Type: CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.webhooks
    ADD CONSTRAINT webhooks_pkey PRIMARY KEY (webhook_id);


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
-- Name: actions_for_many; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX actions_for_many ON public.actions USING btree (action_id) WHERE (subjects IS NOT NULL);


--
-- Name: actions_in_order; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX actions_in_order ON public.actions USING btree (asked_us);


--
-- Name: actions_of_parent; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX actions_of_parent ON public.actions USING btree (parent_id, state) WHERE (parent_id IS NOT NULL);


--
-- Name: actions_pending; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX actions_pending ON public.actions USING btree (fleet, action_id) WHERE (state = 'PENDING'::text);


--
-- Name: alarm_shelves_of_robot; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarm_shelves_of_robot ON public.alarm_shelves USING btree (robot_id, kind) WHERE (robot_id IS NOT NULL);


--
-- Name: alarm_shelves_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarm_shelves_of_whisker ON public.alarm_shelves USING btree (whisker_id, kind);


--
-- Name: alarms_in_order; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarms_in_order ON public.alarms USING btree (raised_us, alarm_id);


--
-- Name: alarms_of_robot; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarms_of_robot ON public.alarms USING btree (robot_id, raised_us) WHERE (robot_id IS NOT NULL);


--
-- Name: alarms_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarms_of_whisker ON public.alarms USING btree (whisker_id, raised_us);


--
-- Name: alarms_standing; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarms_standing ON public.alarms USING btree (whisker_id, kind) WHERE (cleared_us IS NULL);


--
-- Name: alarms_standing_of_robot; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX alarms_standing_of_robot ON public.alarms USING btree (robot_id, kind) WHERE ((cleared_us IS NULL) AND (robot_id IS NOT NULL));


--
-- Name: black_boxes_by_time; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX black_boxes_by_time ON public.black_boxes USING btree (event_us);


--
-- Name: black_boxes_recording; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX black_boxes_recording ON public.black_boxes USING btree (robot_id) WHERE (state = 'RECORDING'::text);


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
-- Name: compensations_decided; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensations_decided ON public.compensations USING btree (decided_us);


--
-- Name: compensations_not_ended; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensations_not_ended ON public.compensations USING btree (target_whisker_id) WHERE (ended_us IS NULL);


--
-- Name: compensations_of_compensator; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensations_of_compensator ON public.compensations USING btree (compensator_whisker_id) WHERE (ended_us IS NULL);


--
-- Name: compensations_of_target; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX compensations_of_target ON public.compensations USING btree (target_whisker_id, decided_us);


--
-- Name: console_sessions_by_expiry; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX console_sessions_by_expiry ON public.console_sessions USING btree (expires_us);


--
-- Name: contacts_20261128_pages; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX contacts_20261128_pages ON public.contacts_20261128 USING brin (t_us) WITH (autosummarize='on');


--
-- Name: contacts_20261129_pages; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX contacts_20261129_pages ON public.contacts_20261129 USING brin (t_us) WITH (autosummarize='on');


--
-- Name: contacts_default_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX contacts_default_of_whisker ON public.contacts_default USING btree (whisker_id, t_us);


--
-- Name: health_changes_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX health_changes_of_whisker ON public.health_changes USING btree (whisker_id, recorded_us);


--
-- Name: notes_of_robot; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX notes_of_robot ON public.notes USING btree (robot_id, note_id);


--
-- Name: quarantine_of_fleet; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX quarantine_of_fleet ON public.quarantine USING btree (fleet, quarantine_id);


--
-- Name: rollout_events_of; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX rollout_events_of ON public.rollout_events USING btree (rollout_id);


--
-- Name: rollouts_open; Type: INDEX; Schema: public; Owner: -
--

CREATE UNIQUE INDEX rollouts_open ON public.rollouts USING btree (fleet) WHERE (state = ANY (ARRAY['RUNNING'::text, 'PAUSED'::text]));


--
-- Name: setpoint_states_of_setpoint; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX setpoint_states_of_setpoint ON public.setpoint_states USING btree (command_id);


--
-- Name: setpoints_by_state; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX setpoints_by_state ON public.setpoints USING btree (state, issued_us, robot_id);


--
-- Name: setpoints_in_order; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX setpoints_in_order ON public.setpoints USING btree (issued_us, state, robot_id);


--
-- Name: setpoints_of_compensation; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX setpoints_of_compensation ON public.setpoints USING btree (compensation_id, epoch, version);


--
-- Name: setpoints_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX setpoints_of_whisker ON public.setpoints USING btree (whisker_id, issued_us);


--
-- Name: touch_tests_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX touch_tests_of_whisker ON public.touch_tests USING btree (whisker_id, requested_us);


--
-- Name: trims_in_order; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX trims_in_order ON public.trims USING btree (detected_us, robot_id);


--
-- Name: trims_of_whisker; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX trims_of_whisker ON public.trims USING btree (whisker_id, detected_us);


--
-- Name: webhook_events_in_order; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX webhook_events_in_order ON public.webhook_events USING btree (tx, place, event_id);


--
-- Name: whiskers_in_need; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX whiskers_in_need ON public.whiskers USING btree (robot_id, array_id, condition, fault, whisker_id) WHERE (("position" IS NOT NULL) AND ((condition <> 'HEALTHY'::text) OR (fault IS NOT NULL)));


--
-- Name: whiskers_of_model; Type: INDEX; Schema: public; Owner: -
--

CREATE INDEX whiskers_of_model ON public.whiskers USING btree (model, robot_id) WHERE ("position" IS NOT NULL);


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
-- Name: alarms webhook_alarm_cleared; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_alarm_cleared AFTER UPDATE OF cleared_us ON public.alarms FOR EACH ROW WHEN (((old.cleared_us IS NULL) AND (new.cleared_us IS NOT NULL))) EXECUTE FUNCTION public.webhook_alarm_cleared();


--
-- Name: alarms webhook_alarm_raised; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_alarm_raised AFTER INSERT ON public.alarms FOR EACH ROW EXECUTE FUNCTION public.webhook_alarm_raised();


--
-- Name: compensations webhook_approved; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_approved AFTER UPDATE OF approval ON public.compensations FOR EACH ROW WHEN (((old.approval = 'PROPOSED'::text) AND (new.approval = 'APPROVED'::text))) EXECUTE FUNCTION public.webhook_approved();


--
-- Name: compensations webhook_begun; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_begun AFTER INSERT ON public.compensations FOR EACH ROW WHEN (((new.compensator_whisker_id IS NOT NULL) AND (new.approval = 'AUTOMATIC'::text))) EXECUTE FUNCTION public.webhook_begun();


--
-- Name: health_changes webhook_condition; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_condition AFTER INSERT ON public.health_changes FOR EACH ROW WHEN ((new.kind = 'CONDITION'::text)) EXECUTE FUNCTION public.webhook_condition();


--
-- Name: compensations webhook_ended; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_ended AFTER UPDATE OF ended_us ON public.compensations FOR EACH ROW WHEN (((old.ended_us IS NULL) AND (new.ended_us IS NOT NULL) AND (new.compensator_whisker_id IS NOT NULL) AND (new.approval = ANY (ARRAY['AUTOMATIC'::text, 'APPROVED'::text])))) EXECUTE FUNCTION public.webhook_ended();


--
-- Name: setpoint_states webhook_setpoint_failed; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_setpoint_failed AFTER INSERT ON public.setpoint_states FOR EACH ROW WHEN ((new.state = ANY (ARRAY['REJECTED'::text, 'FAILED'::text, 'EXPIRED'::text]))) EXECUTE FUNCTION public.webhook_setpoint_failed();


--
-- Name: trims webhook_trim; Type: TRIGGER; Schema: public; Owner: -
--

CREATE TRIGGER webhook_trim AFTER INSERT ON public.trims FOR EACH ROW EXECUTE FUNCTION public.webhook_trim();


--
-- Name: actions actions_parent_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.actions
    ADD CONSTRAINT actions_parent_id_fkey FOREIGN KEY (parent_id) REFERENCES public.actions(action_id);


--
-- Name: active_calibrations active_calibrations_calibration_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.active_calibrations
    ADD CONSTRAINT active_calibrations_calibration_id_fkey FOREIGN KEY (calibration_id) REFERENCES public.calibrations(calibration_id);


--
-- Name: alarm_shelves alarm_shelves_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.alarm_shelves
    ADD CONSTRAINT alarm_shelves_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: alarm_shelves alarm_shelves_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.alarm_shelves
    ADD CONSTRAINT alarm_shelves_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


--
-- Name: alarms alarms_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.alarms
    ADD CONSTRAINT alarms_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


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
-- Name: black_boxes black_boxes_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.black_boxes
    ADD CONSTRAINT black_boxes_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: black_boxes black_boxes_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.black_boxes
    ADD CONSTRAINT black_boxes_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


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
-- Name: notes notes_action_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.notes
    ADD CONSTRAINT notes_action_id_fkey FOREIGN KEY (action_id) REFERENCES public.actions(action_id);


--
-- Name: notes notes_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.notes
    ADD CONSTRAINT notes_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: policies policies_action_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.policies
    ADD CONSTRAINT policies_action_id_fkey FOREIGN KEY (action_id) REFERENCES public.actions(action_id);


--
-- Name: rollout_events rollout_events_rollout_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.rollout_events
    ADD CONSTRAINT rollout_events_rollout_id_fkey FOREIGN KEY (rollout_id) REFERENCES public.rollouts(rollout_id);


--
-- Name: rollouts rollouts_rollout_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.rollouts
    ADD CONSTRAINT rollouts_rollout_id_fkey FOREIGN KEY (rollout_id) REFERENCES public.actions(action_id);


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
-- Name: touch_tests touch_tests_robot_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.touch_tests
    ADD CONSTRAINT touch_tests_robot_id_fkey FOREIGN KEY (robot_id) REFERENCES public.robots(robot_id);


--
-- Name: touch_tests touch_tests_whisker_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.touch_tests
    ADD CONSTRAINT touch_tests_whisker_id_fkey FOREIGN KEY (whisker_id) REFERENCES public.whiskers(whisker_id);


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
-- Name: webhook_dead_letters webhook_dead_letters_webhook_id_fkey; Type: FK CONSTRAINT; Schema: public; Owner: -
--

ALTER TABLE ONLY public.webhook_dead_letters
    ADD CONSTRAINT webhook_dead_letters_webhook_id_fkey FOREIGN KEY (webhook_id) REFERENCES public.webhooks(webhook_id) ON DELETE CASCADE;


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


