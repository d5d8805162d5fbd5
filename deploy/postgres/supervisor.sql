-- Creates the two roles of the supervisors' database. Supervisors connect as `supervisor`, which owns the tables but the audit
-- log. `supervisor_owner`, as which nobody can connect, owns the schema and the audit log: a supervisor, and a
-- person with its password, can add to the log and answer pending actions, but can delete and change no answered one.
--
-- With docker-compose.yml the server runs this when it initialises the database. It can be run again, also if another role
-- owns the tables. Run it with psql as a superuser in the supervisors' database. SUPERVISOR_PASSWORD_FILE names a file with
-- the password of `supervisor`:
--
--   SUPERVISOR_PASSWORD_FILE=supervisor.password psql -X -f supervisor.sql 'postgres://postgres@db/vibrissa'

\set ON_ERROR_STOP on
\set password `cat "$SUPERVISOR_PASSWORD_FILE"`

BEGIN;
SELECT 'CREATE ROLE supervisor' WHERE NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'supervisor') \gexec
ALTER ROLE supervisor LOGIN NOSUPERUSER NOCREATEDB NOCREATEROLE NOREPLICATION NOBYPASSRLS PASSWORD :'password';
SELECT 'CREATE ROLE supervisor_owner' WHERE NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'supervisor_owner') \gexec
ALTER ROLE supervisor_owner NOLOGIN NOSUPERUSER NOCREATEDB NOCREATEROLE NOREPLICATION NOBYPASSRLS INHERIT;
-- The owner may take tables over from the writer, and not the reverse.
SELECT 'GRANT supervisor TO supervisor_owner' WHERE NOT pg_has_role('supervisor_owner', 'supervisor', 'MEMBER') \gexec
SELECT 'REVOKE supervisor_owner FROM supervisor' WHERE pg_has_role('supervisor', 'supervisor_owner', 'MEMBER') \gexec
SELECT format('REVOKE ALL ON DATABASE %I FROM PUBLIC', current_database()) \gexec
SELECT format('REVOKE ALL ON DATABASE %I FROM supervisor', current_database()) \gexec
SELECT format('GRANT CONNECT ON DATABASE %I TO supervisor', current_database()) \gexec
REVOKE ALL ON SCHEMA public FROM PUBLIC;
-- The owner of a schema can drop all tables in it.
ALTER SCHEMA public OWNER TO supervisor_owner;
GRANT USAGE, CREATE ON SCHEMA public TO supervisor;

-- A supervisor calls this after it has created or migrated the tables.
CREATE OR REPLACE FUNCTION public.protect_audit_log() RETURNS void
    LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
BEGIN
    IF to_regclass('public.actions') IS NULL THEN
        RETURN;
    END IF;
    ALTER TABLE public.actions OWNER TO supervisor_owner;
    IF to_regprocedure('public.keep_answered_action()') IS NOT NULL THEN
        ALTER FUNCTION public.keep_answered_action() OWNER TO supervisor_owner;
    END IF;
    REVOKE ALL ON public.actions FROM PUBLIC, supervisor;
    GRANT SELECT, INSERT, REFERENCES, UPDATE (state, problem, done_us, subjects, test_id) ON public.actions TO supervisor;
    -- For pg_dump.
    GRANT SELECT ON SEQUENCE public.actions_action_id_seq TO supervisor;
END
$$;
ALTER FUNCTION public.protect_audit_log() OWNER TO supervisor_owner;
REVOKE ALL ON FUNCTION public.protect_audit_log() FROM PUBLIC;
GRANT EXECUTE ON FUNCTION public.protect_audit_log() TO supervisor;

-- This includes a table's indexes, its row type and the sequences of its columns. Partitions are tables of their own.
SELECT format('ALTER TABLE public.%I OWNER TO supervisor', relname)
    FROM pg_class WHERE relnamespace = 'public'::regnamespace AND relkind IN ('r', 'p')
    AND pg_get_userbyid(relowner) NOT IN ('supervisor', 'supervisor_owner') \gexec
SELECT format('ALTER VIEW public.%I OWNER TO supervisor', relname)
    FROM pg_class WHERE relnamespace = 'public'::regnamespace AND relkind = 'v'
    AND pg_get_userbyid(relowner) <> 'supervisor' \gexec
SELECT format('ALTER ROUTINE public.%I(%s) OWNER TO supervisor', proname, pg_get_function_identity_arguments(oid))
    FROM pg_proc WHERE pronamespace = 'public'::regnamespace
    AND pg_get_userbyid(proowner) NOT IN ('supervisor', 'supervisor_owner') \gexec
DO $$ BEGIN PERFORM public.protect_audit_log(); END $$;
COMMIT;
