//! Databases of earlier versions of the program, left in the middle of their work. This version opens them without
//! losing anything that was learned.
//!
//! Each folder `tests/data/database-N` contains a database whose last migration is N, and the lists that its own
//! version has served from it. Those of `database-16` are as of the transaction before the one in `redo`.
//! `VIEWS=write` replaces these lists; use it for a new folder only.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::{Map, Value};
use sqlx::postgres::PgConnection;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions as _, Connection as _};
use tempfile::TempDir;
use vibrissa_store::{DatabaseAddress, Store, StoreError};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::postgres::{DATABASE, Postgres};
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::try_get;

/// Lists of everything that was learned, decided and measured.
const VIEWS: [&str; 7] =
    ["/v1/arrays", "/v1/whiskers", "/v1/trims", "/v1/compensations", "/v1/setpoints", "/v1/errors", "/v1/calibrations"];

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/database-16").join(name)
}

/// A running program that owns fleet `f` of a database.
struct Opened {
    process: Process,
    http: SocketAddr,
    folder: TempDir,
}

impl Opened {
    async fn start(folder: TempDir, database: &str) -> Self {
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let mqtt = free_port().to_string();
        let arguments =
            ["run", "--fleet", "f", "--http", &http.to_string(), "--mqtt-port", &mqtt, "--database-url", database];
        let launch = Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.iter().map(|&argument| argument.to_owned()).collect(),
            environment: vec![("RUST_LOG".to_owned(), "warn".to_owned())],
            log: folder.path().join("log"),
        };
        let opened = Self { process: Process::start(launch), http, folder };
        until_true("the supervisor owns the fleet", async || {
            try_get(http, "/readyz").await.is_ok_and(|(status, _)| status == 200)
        })
        .await;
        opened
    }

    async fn views(&self) -> Map<String, Value> {
        let mut views = Map::new();
        for path in VIEWS {
            let (status, body) = try_get(self.http, &format!("{path}?limit=500")).await.unwrap();
            assert_eq!(status, 200, "{path}: {body}");
            let mut view: Value = body.parse().unwrap();
            views.insert(path.to_owned(), view["items"].take());
        }
        views
    }

    /// The lists, once they no longer change because of the time since the database was left.
    async fn settled(&self) -> Map<String, Value> {
        let mut before = self.views().await;
        until("the same views twice", async || {
            tokio::time::sleep(Duration::from_millis(1500)).await;
            let now = self.views().await;
            let is_same = now == before;
            before = now.clone();
            is_same.then_some(now)
        })
        .await
    }
}

/// The fields of a list's rows that rows of then had: later versions have added others.
fn of_then(view: &Value, recorded: &Value) -> Value {
    let known = |field: &String| recorded[0].get(field).is_some();
    let rows = view.as_array().unwrap().iter().map(|row| {
        let fields = row.as_object().unwrap().iter().filter(|(field, _)| known(field));
        fields.map(|(field, value)| (field.clone(), value.clone())).collect()
    });
    Value::Array(rows.collect())
}

async fn nothing_is_lost(opened: Opened, expected: &str) {
    let views = opened.settled().await;
    let log = std::fs::read_to_string(opened.folder.path().join("log")).unwrap();
    assert!(!log.contains("ERROR"), "{log}");
    let path = fixture(expected);
    if std::env::var("VIEWS").is_ok_and(|what| what == "write") {
        std::fs::write(&path, serde_json::to_string_pretty(&views).unwrap() + "\n").unwrap();
    }
    let recorded: Map<String, Value> =
        std::fs::read_to_string(&path).unwrap().parse::<Value>().unwrap().as_object().unwrap().clone();
    let trimmed = |views: &Map<String, Value>| {
        let whiskers = views["/v1/whiskers"].as_array().unwrap();
        whiskers.iter().filter(|one| one["condition"] == "TRIMMED").count()
    };
    assert_eq!((trimmed(&recorded), recorded["/v1/compensations"].as_array().unwrap().len()), (2, 2));
    for path in VIEWS {
        assert_eq!(of_then(&views[path], &recorded[path]), recorded[path], "{path}");
    }
    assert!(opened.process.is_running());
}

/// Removes the transaction that waits in `redo`: the database is then as of the transaction before it.
const FINISH: &str = "DELETE FROM redo";

/// Opens a database in which a transaction waits for its version: nothing may be changed.
async fn is_refused(address: &DatabaseAddress) {
    let store = Store::open(address, "test").await.unwrap();
    for _ in 0..2 {
        let problem = store.prepare().await.unwrap_err();
        assert!(matches!(problem, StoreError::Unfinished { .. }) && !problem.is_passing(), "{problem}");
    }
    store.close().await;
}

#[tokio::test]
async fn golden_a_sqlite_database_of_migration_16_goes_on_with_nothing_lost() {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("fleet.sqlite3");
    std::fs::copy(fixture("fleet.sqlite3"), &copy).unwrap();
    is_refused(&DatabaseAddress::Sqlite(copy.clone())).await;
    let mut link = SqliteConnectOptions::new().filename(&copy).connect().await.unwrap();
    let newest: i64 =
        sqlx::query_scalar("SELECT max(version) FROM _sqlx_migrations").fetch_one(&mut link).await.unwrap();
    assert_eq!(newest, 16);
    sqlx::raw_sql(FINISH).execute(&mut link).await.unwrap();
    link.close().await.unwrap();
    let url = format!("sqlite:{}", copy.display());
    nothing_is_lost(Opened::start(folder, &url).await, "views-sqlite.json").await;
}

#[tokio::test]
async fn golden_a_postgresql_database_of_migration_16_goes_on_with_nothing_lost() {
    let server = Postgres::start().await;
    let restored = server
        .client("psql")
        .args(["-X", "-q", "-d", DATABASE, "-v", "ON_ERROR_STOP=1", "-f"])
        .arg(fixture("fleet.sql"))
        .output();
    let restored = restored.unwrap();
    assert!(restored.status.success(), "psql: {}", String::from_utf8_lossy(&restored.stderr));
    let url = Postgres::url(server.port());
    is_refused(&url.parse().unwrap()).await;
    let mut link = PgConnection::connect(&url).await.unwrap();
    let newest: i64 =
        sqlx::query_scalar("SELECT max(version) FROM _sqlx_migrations").fetch_one(&mut link).await.unwrap();
    assert_eq!(newest, 16);
    sqlx::raw_sql(FINISH).execute(&mut link).await.unwrap();
    let opened = Opened::start(tempfile::tempdir().unwrap(), &url).await;
    nothing_is_lost(opened, "views-postgres.json").await;
}

/// An earlier version that is still running may begin a transaction after the look at `redo`.
#[tokio::test]
async fn the_migration_itself_refuses_unfinished_transactions() {
    const BEFORE: &str = "CREATE TABLE redo (number BIGINT); INSERT INTO redo VALUES (7)";
    let mut link = SqliteConnectOptions::new().in_memory(true).connect().await.unwrap();
    sqlx::raw_sql(BEFORE).execute(&mut link).await.unwrap();
    let migration = include_str!("../../../migrations/sqlite/0060_no_intent_log.sql");
    let refused = sqlx::raw_sql(migration).execute(&mut link).await.unwrap_err();
    assert!(refused.to_string().contains("redo_is_empty"), "{refused}");

    let server = Postgres::start().await;
    let mut link = PgConnection::connect(&Postgres::url(server.port())).await.unwrap();
    sqlx::raw_sql(BEFORE).execute(&mut link).await.unwrap();
    let migration = include_str!("../../../migrations/postgres/0060_no_intent_log.sql");
    let refused = sqlx::raw_sql(migration).execute(&mut link).await.unwrap_err();
    assert!(refused.to_string().contains("redo_is_empty"), "{refused}");
}
