//! `vibrissa backup`: refusals and the completeness of copies.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Output;

use sqlx::ConnectOptions;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};

use crate::{Fresh, fleet, rows, supervisor};

/// Runs `vibrissa backup`.
pub(crate) fn backup(database_url: &str, to: &Path) -> Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_vibrissa-under-test"))
        .args(["backup", "--database-url", database_url])
        .arg(to)
        .output()
        .unwrap()
}

/// Error message of a backup that must fail.
fn refusal(database_url: &str, to: &Path) -> String {
    let ended = backup(database_url, to);
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    String::from_utf8(ended.stderr).unwrap()
}

/// Copies made while contacts are committed continuously: each one is a complete database with the contacts up to some
/// commit.
#[tokio::test]
async fn copies_that_are_taken_while_contacts_are_committed_are_whole() {
    let database = Fresh::sqlite().await;
    let url = database.address.to_string();
    let mut writer = database.store.writer();
    let lease = writer.acquire(&supervisor("a"), &fleet()).await.unwrap().unwrap();
    let robot = rows::robot(&mut writer, &lease).await;
    let folder = tempfile::tempdir().unwrap();
    let mut before = 0;
    let mut next = 0;
    for round in 0..3 {
        let to = folder.path().join(format!("{round}.sqlite3"));
        let (url, file) = (url.clone(), to.clone());
        let copying = tokio::task::spawn_blocking(move || backup(&url, &file));
        while !copying.is_finished() {
            writer.commit(&lease, &rows::contacts(&robot, next..next + 10)).await.unwrap();
            next += 10;
        }
        let ended = copying.await.unwrap();
        let said = String::from_utf8(ended.stdout).unwrap();
        assert!(ended.status.success() && said.contains("checked") && said.contains("MiB"), "{said}");
        assert_eq!(std::fs::metadata(&to).unwrap().permissions().mode() & 0o777, 0o600);
        let mut copy: SqliteConnection =
            SqliteConnectOptions::new().filename(&to).read_only(true).connect().await.unwrap();
        // Commits are atomic, and the copy is a snapshot.
        let (count, last): (i64, i64) =
            sqlx::query_as("SELECT count(*), coalesce(max(seq), -1) FROM contacts").fetch_one(&mut copy).await.unwrap();
        assert!(count >= before && count == last + 1 && count <= next, "{count} up to {last}");
        // The first commit has registered the robot and its whiskers.
        let commits: i64 = sqlx::query_scalar("SELECT commits FROM leases").fetch_one(&mut copy).await.unwrap();
        assert_eq!(count, 10 * (commits - 1));
        before = count;
    }
    assert!(before > 0, "no contact was committed during the copies");
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 3, "no temporary file may be left");
}

#[tokio::test]
async fn what_cannot_be_backed_up_is_said_and_nothing_is_left_behind() {
    let database = Fresh::sqlite().await;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);

    std::fs::write(path("taken"), "precious").unwrap();
    let said = refusal(&database.address.to_string(), &path("taken"));
    assert!(said.contains("taken") && said.contains("overwrites nothing"), "{said}");
    assert_eq!(std::fs::read_to_string(path("taken")).unwrap(), "precious");

    let nowhere = path("nowhere.sqlite3");
    let said = refusal(&format!("sqlite:{}", nowhere.display()), &path("copy"));
    assert!(said.contains("no database") && said.contains("--database-url"), "{said}");
    assert!(!nowhere.exists(), "the missing database must not be created");

    let said = refusal(&database.address.to_string(), &path("no-such-folder/copy"));
    assert!(said.contains("no-such-folder") && said.contains("cannot write"), "{said}");

    let said = refusal("postgres://vibrissa@127.0.0.1:1/vibrissa", &path("copy"));
    assert!(said.contains("pg_dump"), "{said}");
    let said = refusal("postgres://vibrissa:S3cret@127.0.0.1:1/vibrissa", &path("copy"));
    assert!(said.contains("database.password_file") && !said.contains("S3cret"), "{said}");

    std::fs::write(path("junk.sqlite3"), vec![7; 8192]).unwrap();
    let said = refusal(&format!("sqlite:{}", path("junk.sqlite3").display()), &path("copy"));
    assert!(said.contains("not a database"), "{said}");
    let mut left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["junk.sqlite3", "taken"]);
}
