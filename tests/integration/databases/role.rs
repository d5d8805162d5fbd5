//! The database role of a deployed supervisor has all the rights that it needs, and no others.

use std::path::Path;

use sqlx::{ConnectOptions, Connection, Executor};
use vibrissa_store::DatabaseAddress;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::wait::until_true;

use crate::Fresh;
use crate::supervisors::{Replica, start_fleet};

const GRAFANA_SQL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../deploy/postgres/grafana.sql");

/// Runs a supervisor until it has recorded contacts of robots. Returns its log.
async fn works(database: &str, server: &Postgres, broker: &Mosquitto, folder: &Path, name: &str) -> String {
    let mut replica = Replica::start(folder, name, "f", database, broker.port(), 2.0);
    replica.says(200, "true").await;
    let fleet = start_fleet("f", broker.port());
    let mut link = server.connect().connect().await.unwrap();
    let goal: i64 = sqlx::query_scalar("SELECT count(*) + 100 FROM contacts").fetch_one(&mut link).await.unwrap();
    until_true("contacts recorded", async || {
        sqlx::query_scalar::<_, i64>("SELECT count(*) FROM contacts").fetch_one(&mut link).await.unwrap() >= goal
    })
    .await;
    until_true("the tables in order", async || {
        let metrics = replica.get("/metrics").await;
        assert!(metrics.contains("vibrissa_upkeep_errors_total 0\n"), "{metrics}");
        metrics.lines().any(|line| {
            line.strip_prefix("vibrissa_upkeep_timestamp_seconds ")
                .is_some_and(|value| value.parse::<f64>().unwrap() > 0.0)
        })
    })
    .await;
    fleet.stop().await;
    replica.terminate().await;
    std::fs::read_to_string(folder.join(name)).unwrap()
}

async fn of_superuser(server: &Postgres, sql: &'static str) -> i64 {
    sqlx::query_scalar(sql).fetch_one(&mut server.connect().connect().await.unwrap()).await.unwrap()
}

/// Number of our tables, indexes and sequences that do not belong to the role, but those of the audit log.
const OTHERS_TABLES: &str = "SELECT count(*) FROM pg_class WHERE relnamespace = 'public'::regnamespace \
                             AND relkind IN ('r', 'p', 'i', 'I', 'S') AND relname NOT LIKE 'actions%' \
                             AND pg_get_userbyid(relowner) <> 'supervisor'";
/// Number of tables, indexes, sequences and functions of the audit log that its owner does not have.
const UNPROTECTED: &str = "SELECT (SELECT count(*) FROM pg_class WHERE relnamespace = 'public'::regnamespace \
                           AND relname LIKE 'actions%' AND pg_get_userbyid(relowner) <> 'supervisor_owner') \
                           + (SELECT count(*) FROM pg_proc WHERE proname IN ('keep_answered_action', 'protect_audit_log') \
                           AND pg_get_userbyid(proowner) <> 'supervisor_owner')";
const PARTITIONS: &str = "SELECT count(*) FROM pg_inherits JOIN pg_class ON pg_class.oid = inhrelid \
                          WHERE inhparent = 'contacts'::regclass AND relname LIKE 'contacts_2%'";
const ROLE_IS_MORE: &str = "SELECT count(*) FROM pg_roles WHERE rolname = 'supervisor' \
                            AND (rolsuper OR rolcreatedb OR rolcreaterole OR rolreplication OR rolbypassrls)";

#[tokio::test]
async fn regress_a_supervisor_needs_no_superuser() {
    let (broker, server) = (Mosquitto::start(), Postgres::start_with_supervisor().await);
    let folder = tempfile::tempdir().unwrap();
    let url = Postgres::supervisor_url(server.port());
    let log = works(&url, &server, &broker, folder.path(), "s").await;
    assert!(!log.contains("permission denied"), "{log}");
    assert!(of_superuser(&server, PARTITIONS).await >= 2, "expected partitions of today and tomorrow");
    assert_eq!(of_superuser(&server, OTHERS_TABLES).await, 0);
    assert_eq!(of_superuser(&server, UNPROTECTED).await, 0);
    assert_eq!(of_superuser(&server, ROLE_IS_MORE).await, 0);

    // The role suffices for a backup and for creating Grafana's role.
    let dump = folder.path().join("vibrissa.dump");
    let mut dumping = server.client("pg_dump");
    dumping.env("PGUSER", "supervisor").args(["--format=custom", "--dbname=vibrissa", "--file"]).arg(dump);
    let ended = dumping.output().unwrap();
    assert!(ended.status.success(), "{ended:?}");
    let password = folder.path().join("grafana");
    std::fs::write(&password, "none").unwrap();
    let mut psql = server.client("psql");
    psql.args(["-X", "-q", "-d", "vibrissa", "-f", GRAFANA_SQL]).env("GRAFANA_PASSWORD_FILE", password);
    let ended = psql.output().unwrap();
    assert!(ended.status.success(), "{ended:?}");
    let DatabaseAddress::Postgres(supervisor) = url.parse().unwrap() else { panic!("no PostgreSQL: {url}") };
    let mut grafana = (*supervisor).clone().username("grafana").connect().await.unwrap();
    let seen: i64 = sqlx::query_scalar("SELECT count(*) FROM contacts").fetch_one(&mut grafana).await.unwrap();
    assert!(seen >= 100, "{seen}");
}

#[tokio::test]
async fn the_role_can_do_nothing_else_on_the_server() {
    let server = Postgres::start_with_supervisor().await;
    let DatabaseAddress::Postgres(supervisor) = Postgres::supervisor_url(server.port()).parse().unwrap() else {
        panic!("no PostgreSQL")
    };
    let mut link = supervisor.connect().await.unwrap();
    for forbidden in [
        "CREATE ROLE other",
        "CREATE DATABASE other",
        "CREATE SCHEMA other",
        "CREATE EXTENSION dblink",
        "ALTER ROLE supervisor SUPERUSER",
        "SELECT rolpassword FROM pg_authid",
        "COPY (SELECT 1) TO PROGRAM 'true'",
        "SELECT pg_read_file('postgresql.conf')",
        "ALTER SYSTEM SET fsync = off",
    ] {
        let problem = link.execute(forbidden).await.expect_err(forbidden).to_string();
        assert!(problem.contains("permission denied") || problem.contains("must be"), "{forbidden}: {problem}");
    }
    link.close().await.unwrap();
    let mut administrator = server.connect().connect().await.unwrap();
    administrator.execute("CREATE ROLE stranger LOGIN").await.unwrap();
    let refused = (*supervisor).clone().username("stranger").connect().await.expect_err("other roles must not connect");
    assert!(refused.to_string().contains("permission denied"), "{refused}");
}

/// An action of each kind of state, as a supervisor writes them.
const ACTIONS: &str = "INSERT INTO actions (kind, parameters, actor, role, request_id, asked_us, expires_us, state, done_us) \
                       VALUES ('NOTE', '{}', 'ann', 'ADMIN', 'r', 1, 2, 'DONE', 1), \
                       ('HOLD', '{}', 'ann', 'ADMIN', 'r', 1, 2, 'PENDING', NULL)";

#[tokio::test]
async fn regress_the_supervisors_role_cannot_delete_or_change_the_audit_log() {
    let database = Fresh::postgres().await;
    let DatabaseAddress::Postgres(supervisor) = &database.address else { panic!("no PostgreSQL") };
    let mut link = supervisor.connect().await.unwrap();
    link.execute(ACTIONS).await.unwrap();
    for forbidden in [
        "DELETE FROM actions",
        "TRUNCATE actions CASCADE",
        "DROP TABLE actions CASCADE",
        "DROP SCHEMA public CASCADE",
        "ALTER TABLE actions RENAME TO others",
        "ALTER TABLE actions DISABLE TRIGGER ALL",
        "ALTER TABLE actions OWNER TO supervisor",
        "UPDATE actions SET actor = 'eve'",
        "UPDATE actions SET asked_us = 5",
        "CREATE RULE none AS ON INSERT TO actions DO INSTEAD NOTHING",
        "CREATE TRIGGER none BEFORE INSERT ON actions FOR EACH ROW EXECUTE FUNCTION keep_answered_action()",
        "DROP TRIGGER answered_action_is_kept ON actions",
        "CREATE OR REPLACE FUNCTION keep_answered_action() RETURNS trigger LANGUAGE plpgsql AS 'BEGIN RETURN NULL; END'",
        "CREATE OR REPLACE FUNCTION protect_audit_log() RETURNS void LANGUAGE sql AS 'DELETE FROM public.actions'",
        "ALTER FUNCTION keep_answered_action() OWNER TO supervisor",
        "SET ROLE supervisor_owner",
        "GRANT supervisor_owner TO supervisor",
        "SET session_replication_role = replica",
    ] {
        let problem = link.execute(forbidden).await.expect_err(forbidden).to_string();
        assert!(problem.contains("permission denied") || problem.contains("must "), "{forbidden}: {problem}");
    }
    let changed = "UPDATE actions SET state = 'REFUSED', problem = 'x', done_us = 3";
    assert_eq!(link.execute(changed).await.unwrap().rows_affected(), 1, "the pending one only");
    assert_eq!(link.execute(changed).await.unwrap().rows_affected(), 1, "answered rows stay as they are");
    let states: Vec<String> =
        sqlx::query_scalar("SELECT state FROM actions ORDER BY action_id").fetch_all(&mut link).await.unwrap();
    assert_eq!(states, ["DONE", "REFUSED"]);
}

/// A database from before the role was introduced, which the superuser created and owns.
#[tokio::test]
async fn a_database_of_the_superuser_becomes_the_roles_and_goes_on() {
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    let folder = tempfile::tempdir().unwrap();
    let log = works(&Postgres::url(server.port()), &server, &broker, folder.path(), "before").await;
    assert!(log.contains("is a superuser and can delete the audit log"), "{log}");
    assert_ne!(of_superuser(&server, "SELECT count(*) FROM pg_class WHERE relname = 'leases'").await, 0);
    // Running the script twice must not hurt.
    server.make_supervisor();
    server.make_supervisor();
    assert_eq!(of_superuser(&server, OTHERS_TABLES).await, 0);
    assert_eq!(of_superuser(&server, UNPROTECTED).await, 0);
    let url = Postgres::supervisor_url(server.port());
    let log = works(&url, &server, &broker, folder.path(), "after").await;
    assert!(!log.contains("permission denied"), "{log}");
}
