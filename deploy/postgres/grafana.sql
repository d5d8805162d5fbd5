-- Creates the role with which Grafana reads the tables of its dashboards and alerts, and nothing else. Run it again
-- after an update that adds a table to the list below. Run it with psql as a superuser in the supervisors' database,
-- after the supervisors have created the tables. GRAFANA_PASSWORD_FILE names a file with the role's password:
--
--   GRAFANA_PASSWORD_FILE=grafana.password psql -X -f grafana.sql 'postgres://postgres@db/vibrissa'

\set ON_ERROR_STOP on
\set password `cat "$GRAFANA_PASSWORD_FILE"`

BEGIN;
SELECT 'CREATE ROLE grafana' WHERE NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'grafana') \gexec
-- More connections than Grafana opens; queries end after 15 s, when nobody waits for them any more.
ALTER ROLE grafana LOGIN NOSUPERUSER NOCREATEDB NOCREATEROLE NOINHERIT CONNECTION LIMIT 20 PASSWORD :'password';
ALTER ROLE grafana SET default_transaction_read_only = on;
ALTER ROLE grafana SET statement_timeout = '15s';
SELECT format('GRANT CONNECT ON DATABASE %I TO grafana', current_database()) \gexec
GRANT USAGE ON SCHEMA public TO grafana;
-- Revokes rights of earlier versions. Grafana has no access to tokens, actions and calibrations.
REVOKE ALL ON ALL TABLES IN SCHEMA public FROM grafana;
GRANT SELECT ON
    alarm_shelves, alarms, arrays, compensation_candidates, compensation_error_bins, compensation_errors,
    compensation_refinements, compensations, contact_hours, contact_minutes, contacts, epochs, health_changes, leases,
    setpoint_states, setpoints, trims
    TO grafana;
-- The content of policies, without who set them and why.
GRANT SELECT (
    fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, change_margin, changed_us
) ON policies TO grafana;
-- Without the bytes of stored states.
GRANT SELECT (robot_id, fleet, robot, boot_id, connection, model, updated_us, held) ON robots TO grafana;
GRANT SELECT (
    whisker_id, array_id, robot_id, whisker, position, x_mm, y_mm, model, whole_length_mm, nominal_pressure_mpa,
    pressure_max_mpa, length_mm, length_sd_mm, condition, fault, pressure_mpa, setpoint_mpa, contacts, heard_us, held,
    leak_per_s, leak_low_per_s, leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact,
    erosion_high_mm_per_contact, contacts_left, contacts_left_low, contacts_left_high
) ON whiskers TO grafana;
COMMIT;
