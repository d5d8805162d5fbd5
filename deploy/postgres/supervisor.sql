-- Creates the role of the supervisors, which owns the schema of their database and nothing else on the server. With
-- docker-compose.yml the server runs this when it initialises the database. It can be run again, also if another role
-- owns the tables: they become this role's. Run it with psql as a superuser in the supervisors' database.
-- SUPERVISOR_PASSWORD_FILE names a file with the role's password:
--
--   SUPERVISOR_PASSWORD_FILE=supervisor.password psql -X -f supervisor.sql 'postgres://postgres@db/vibrissa'

\set ON_ERROR_STOP on
\set password `cat "$SUPERVISOR_PASSWORD_FILE"`

BEGIN;
SELECT 'CREATE ROLE supervisor' WHERE NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'supervisor') \gexec
ALTER ROLE supervisor LOGIN NOSUPERUSER NOCREATEDB NOCREATEROLE NOREPLICATION NOBYPASSRLS PASSWORD :'password';
SELECT format('REVOKE ALL ON DATABASE %I FROM PUBLIC', current_database()) \gexec
SELECT format('REVOKE ALL ON DATABASE %I FROM supervisor', current_database()) \gexec
SELECT format('GRANT CONNECT ON DATABASE %I TO supervisor', current_database()) \gexec
REVOKE ALL ON SCHEMA public FROM PUBLIC;
ALTER SCHEMA public OWNER TO supervisor;
-- This includes a table's indexes, its row type and the sequences of its columns. Partitions are tables of their own.
SELECT format('ALTER TABLE public.%I OWNER TO supervisor', relname)
    FROM pg_class WHERE relnamespace = 'public'::regnamespace AND relkind IN ('r', 'p')
    AND pg_get_userbyid(relowner) <> 'supervisor' \gexec
SELECT format('ALTER VIEW public.%I OWNER TO supervisor', relname)
    FROM pg_class WHERE relnamespace = 'public'::regnamespace AND relkind = 'v'
    AND pg_get_userbyid(relowner) <> 'supervisor' \gexec
SELECT format('ALTER ROUTINE public.%I(%s) OWNER TO supervisor', proname, pg_get_function_identity_arguments(oid))
    FROM pg_proc WHERE pronamespace = 'public'::regnamespace AND pg_get_userbyid(proowner) <> 'supervisor' \gexec
COMMIT;
