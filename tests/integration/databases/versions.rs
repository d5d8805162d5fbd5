//! Newer versions of PostgreSQL, which `tests/postgres-versions` fetches.

use std::path::Path;
use std::process::Command;

use vibrissa_tests::postgres::Postgres;

use crate::Fresh;
use crate::contract::written_and_read;

const VERSIONS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/postgres-versions");

/// Every table, list and total is as with SQLite, of which another test compares them with the system's PostgreSQL.
#[tokio::test(flavor = "multi_thread")]
async fn newer_servers_give_back_the_same() {
    let fetched = Command::new(VERSIONS).output().unwrap();
    if !fetched.status.success() {
        println!("skipped: {}", String::from_utf8_lossy(&fetched.stderr));
        return;
    }
    let expected = written_and_read(&Fresh::sqlite().await, 1).await;
    let mut versions = Vec::new();
    for programs in String::from_utf8(fetched.stdout).unwrap().lines() {
        let server = Postgres::start_of(Path::new(programs)).await;
        server.make_supervisor();
        let database = Fresh::of(server).await;
        let version: String = sqlx::query_scalar("SHOW server_version_num")
            .fetch_one(&mut sqlx::ConnectOptions::connect(&database.server.as_ref().unwrap().connect()).await.unwrap())
            .await
            .unwrap();
        assert_eq!(written_and_read(&database, 1).await, expected, "PostgreSQL {version}");
        versions.push(version.parse::<u32>().unwrap() / 10_000);
    }
    assert_eq!(versions, [16, 17, 18]);
}
