//! A local folder, PostgreSQL, and supervisors that are killed.

use serde_json::json;
use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Row};
use vibrissa_tests::oracle::ledger::Verdict;
use vibrissa_tests::oracle::recorded;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::wait::until_within;

use crate::reading::Archive;
use crate::stage::{LONG, Stage};

/// Position of the archive, and time of receipt of the newest contact, µs since 1970 UTC.
struct Position {
    archived_to_us: i64,
    is_planned: bool,
    files: i64,
    newest_us: i64,
}

async fn position(database: &PgConnectOptions) -> Option<Position> {
    const SQL: &str = "SELECT archived_to_us, planned_to_us IS NOT NULL, files, \
         (SELECT coalesce(max(received_us), 0) FROM contacts) FROM archives";
    let mut connection: PgConnection = database.connect().await.ok()?;
    let row = sqlx::query(SQL).fetch_optional(&mut connection).await.ok()??;
    Some(Position { archived_to_us: row.get(0), is_planned: row.get(1), files: row.get(2), newest_us: row.get(3) })
}

async fn until_position(database: &PgConnectOptions, what: &str, holds: impl Fn(&Position) -> bool) -> Position {
    until_within(LONG, what, async || position(database).await.filter(|position| holds(position))).await
}

/// Stops the contacts, waits until all are archived, and compares the files with what robots made.
async fn end(mut stage: Stage, server: &Postgres, folder: &std::path::Path) -> (Verdict, Archive) {
    stage.robots.rest();
    until_within(LONG, "receipts of all messages", async || (stage.robots.undelivered() == 0).then_some(())).await;
    let database = server.connect();
    until_position(&database, "the last contact in a file", |at| at.archived_to_us > at.newest_us && !at.is_planned)
        .await;
    let robots = std::mem::replace(&mut stage.robots, no_robots());
    let mut truth = robots.stop().await;
    let archive = Archive::read(folder);
    archive.compare(&mut truth.ledger);
    (truth.ledger.verdict(), archive)
}

fn no_robots() -> vibrissa_tests::oracle::robots::Robots {
    vibrissa_tests::oracle::robots::Robots::start(&[], &[]).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn supervisors_are_killed_while_they_archive_and_each_contact_is_in_one_file() {
    let server = Postgres::start_with_supervisor().await;
    let folder = tempfile::tempdir().unwrap();
    let url = format!("file://{}", folder.path().display());
    let stage = Stage::start(Some(Postgres::supervisor_url(server.port())), &["--archive-url", &url]);
    let database = server.connect();

    // The first one dies when its first file is uploaded, and the position not yet advanced.
    let mut first = stage.supervisor("first", Some("death_after_upload"));
    until_position(&database, "the first plan", |at| at.is_planned).await;
    let mut second = stage.supervisor("second", None);
    until_within(LONG, "the death of the first supervisor", async || first.process.ended_already()).await;
    assert!(position(&database).await.unwrap().files == 0 || second.log().contains("contacts archived"));
    let before = until_position(&database, "a file of the second one", |at| at.files > 0).await.files;

    // The others are killed with kill -9 whenever a file is planned.
    for turn in 0..3 {
        until_position(&database, "a plan", |at| at.is_planned).await;
        second.process.kill();
        second.process.restart();
        until_position(&database, "a file after a kill", |at| at.files > before + turn).await;
    }
    let (verdict, archive) = end(stage, &server, folder.path()).await;
    println!("{verdict:?} in {} files", archive.files);
    assert_eq!((verdict.missing, verdict.duplicate, verdict.wrong), (0, 0, 0), "{verdict:?}\n{}", second.log());
    assert!(verdict.felt > 500, "{verdict:?}");
    let at = position(&database).await.unwrap();
    assert_eq!(archive.files as i64, at.files);

    for (column, kind) in [
        ("fleet", "VARCHAR"),
        ("robot", "VARCHAR"),
        ("whisker", "BIGINT"),
        ("at", "TIMESTAMP WITH TIME ZONE"),
        ("received_at", "TIMESTAMP WITH TIME ZONE"),
        ("seq", "BIGINT"),
        ("ratio", "DOUBLE"),
        ("deflection_mm", "DOUBLE"),
        ("strain", "DOUBLE"),
        ("pressure_mpa", "DOUBLE"),
        ("temperature_c", "DOUBLE"),
        ("length_mm", "DOUBLE"),
        ("day", "DATE"),
    ] {
        assert_eq!(archive.types[column], json!(kind), "{column}");
    }

    // The database has the same contacts: nothing was deleted, and nothing written twice.
    let mut connection = database.connect().await.unwrap();
    assert_eq!(recorded::count(&mut connection, &[]).await.unwrap(), archive.contacts() as i64);
    let bytes: i64 =
        sqlx::query_scalar("SELECT (bytes / contacts)::bigint FROM archives").fetch_one(&mut connection).await.unwrap();
    println!("{bytes} bytes per contact");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_horizon_that_is_not_kept_loses_contacts() {
    let server = Postgres::start_with_supervisor().await;
    let folder = tempfile::tempdir().unwrap();
    let url = format!("file://{}", folder.path().display());
    let stage = Stage::start(Some(Postgres::supervisor_url(server.port())), &["--archive-url", &url]);
    let _supervisor = stage.supervisor("early", Some("early_horizon"));
    let database = server.connect();
    until_position(&database, "three files", |at| at.files >= 3).await;
    let (verdict, _) = end(stage, &server, folder.path()).await;
    assert!(verdict.missing > 0, "the comparison must notice lost contacts: {verdict:?}");
}
