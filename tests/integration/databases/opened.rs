//! Databases of earlier versions of the program, left in the middle of their work. This version opens them without
//! losing anything that was learned.
//!
//! `tests/data/make-database` has made each folder `tests/data/database-N`: a database whose last migration is N, and
//! the answers of the REST API that its own version has given from it, by path. Those of `database-16` are as of the
//! transaction before the one in `redo`.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::{Map, Value};
use sqlx::postgres::PgConnection;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AssertSqlSafe, ConnectOptions as _, Connection as _};
use tempfile::TempDir;
use vibrissa_store::{DatabaseAddress, Store, StoreError};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::postgres::{DATABASE, Postgres};
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::{PATIENCE, found_within, until_true};
use vibrissa_tests::web::try_get;

use crate::history::{count, rows};

/// A database that an earlier version has left.
pub(crate) struct Left {
    folder: &'static str,
    newest_migration: i64,
    /// Tables that have rows, some with the condition of these rows.
    filled: &'static [&'static str],
    /// Whether a transaction waits in `redo`, so that this version refuses the database.
    is_in_redo: bool,
    /// Number of trimmed whiskers, and of compensations.
    trimmed: usize,
    compensations: usize,
}

const LEFT_16: Left = Left {
    folder: "database-16",
    newest_migration: 16,
    filled: &["robots", "whiskers", "contacts", "trims", "compensations", "setpoints", "journal"],
    is_in_redo: true,
    trimmed: 2,
    compensations: 2,
};

pub(crate) const LEFT_37: Left = Left {
    folder: "database-37",
    newest_migration: 37,
    filled: &[
        "actions",
        "active_calibrations",
        "alarm_shelves",
        "alarms",
        "allowed_robots",
        "api_tokens",
        "arrays",
        "black_boxes",
        "boots",
        "calibrations",
        "compensation_candidates",
        "compensation_error_bins",
        "compensation_errors",
        "compensation_refinements",
        "compensation_responses",
        "compensations",
        "contact_hours",
        "contact_minutes",
        "contacts",
        "epochs",
        "health_changes",
        "journal",
        "leases",
        "notes",
        "policies",
        "robots",
        "rollout_events",
        "rollouts",
        "setpoint_states",
        "setpoints",
        "touch_tests WHERE ended_us IS NOT NULL",
        "touch_tests WHERE ended_us IS NULL",
        "trims",
        "turned_away",
        "webhook_dead_letters",
        "webhook_events",
        "webhooks",
        "whiskers",
    ],
    is_in_redo: false,
    trimmed: 6,
    compensations: 6,
};

/// Tables whose rows are in another table now.
const RENAMED: [(&str, &str); 1] = [("webhook_events", "events")];

/// Fields that change while time goes on, by path of the list.
const CHANGING: &[(&str, &[&str])] = &[
    // The supervisor writes a robot's row soon after its start.
    ("/v1/robots", &["updated_at"]),
    // A test that was under way expires then.
    ("/v1/touch-tests", &["updated_at", "ended_at"]),
    // The supervisor tries to deliver, and gives up events of the fixture, which are older than a day, and drops those
    // older than a week.
    (
        "/v1/webhooks",
        &[
            "last_at",
            "last_status",
            "last_problem",
            "failures",
            "failed",
            "next_at",
            "waiting",
            "oldest_at",
            "dead_letters",
            "lost",
        ],
    ),
];

impl Left {
    fn file(&self, name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(self.folder).join(name)
    }

    /// The answers of its own version, by path.
    pub(crate) fn recorded(&self, name: &str) -> Map<String, Value> {
        let text = std::fs::read_to_string(self.file(name)).unwrap();
        let views = text.parse::<Value>().unwrap().as_object().unwrap().clone();
        let whiskers = views.iter().find(|(path, _)| is_list(path, "/v1/whiskers")).unwrap().1.as_array().unwrap();
        let trimmed = whiskers.iter().filter(|one| one["condition"] == "TRIMMED").count();
        let compensations = views.iter().find(|(path, _)| is_list(path, "/v1/compensations")).unwrap().1;
        assert_eq!((trimmed, compensations.as_array().unwrap().len()), (self.trimmed, self.compensations));
        views
    }

    /// Numbers of rows of the tables that have some.
    async fn counts(&self, address: &DatabaseAddress, is_migrated: bool) -> BTreeMap<String, i64> {
        let counting = |table: &&str| {
            let now = RENAMED.iter().find(|(before, _)| is_migrated && before == table).map_or(*table, |(_, now)| now);
            format!("SELECT '{table}' AS name, count(*) FROM {now}")
        };
        let sql = self.filled.iter().map(counting).collect::<Vec<_>>().join(" UNION ALL ");
        let counts: BTreeMap<String, i64> =
            rows!(address, (String, i64), AssertSqlSafe(sql.clone())).into_iter().collect();
        let empty: Vec<_> = counts.iter().filter(|&(_, &rows)| rows == 0).collect();
        assert!(empty.is_empty(), "no rows in the fixture: {empty:?}");
        counts
    }

    async fn goes_on(&self, address: &DatabaseAddress, (folder, url): (TempDir, &str), views: &str) {
        let recorded = self.recorded(views);
        assert_eq!(newest_migration(address).await, self.newest_migration);
        let counts = self.counts(address, false).await;
        if self.is_in_redo {
            is_refused(address).await;
            finish(address).await;
        }
        let store = Store::open(address, "test").await.unwrap();
        store.prepare().await.unwrap();
        store.close().await;
        assert!(newest_migration(address).await > self.newest_migration);
        assert_eq!(self.counts(address, true).await, counts);
        self.shows((folder, url), &recorded).await;
    }

    /// Starts the program, and compares its answers with recorded ones.
    pub(crate) async fn shows(&self, (folder, url): (TempDir, &str), recorded: &Map<String, Value>) {
        let opened = Opened::start(folder, url).await;
        let (mut differences, mut same) = (Vec::new(), 0);
        // Open tests and setpoints expire after the start. Once the views are the same, they stay so.
        found_within(PATIENCE, async || {
            tokio::time::sleep(Duration::from_millis(1500)).await;
            differences = opened.differences(recorded).await;
            same = if differences.is_empty() { same + 1 } else { 0 };
            (same == 2).then_some(())
        })
        .await;
        assert!(same == 2, "{differences:#?}");
        let log = std::fs::read_to_string(opened.folder.path().join("log")).unwrap();
        assert!(!log.contains("ERROR"), "{log}");
        assert!(opened.process.is_running());
    }
}

fn is_list(path: &str, list: &str) -> bool {
    path.split('?').next() == Some(list)
}

/// A running program that owns fleet `f` of a database. It removes no rows because of their age.
struct Opened {
    process: Process,
    http: SocketAddr,
    folder: TempDir,
}

impl Opened {
    async fn start(folder: TempDir, database: &str) -> Self {
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        // Nobody listens there: a supervisor with a broker would call the robots of the fixture silent.
        let mqtt = free_port().to_string();
        let arguments =
            ["run", "--fleet", "f", "--http", &http.to_string(), "--mqtt-port", &mqtt, "--database-url", database];
        let all_ages = ["--records-days", "--contacts-days", "--rollups-minutes-days", "--black-box-days"];
        let all_ages = all_ages.into_iter().flat_map(|key| [key, "0"]);
        let launch = Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.into_iter().chain(all_ages).map(str::to_owned).collect(),
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

    /// Differences from recorded answers.
    async fn differences(&self, recorded: &Map<String, Value>) -> Vec<String> {
        let mut found = Vec::new();
        for (path, then) in recorded {
            let (status, body) = try_get(self.http, path).await.unwrap();
            assert_eq!(status, 200, "{path}: {body}");
            let now: Value = body.parse().unwrap();
            let changing = CHANGING.iter().find(|(list, _)| is_list(path, list)).map_or(&[][..], |&(_, fields)| fields);
            compare(path, changing, then, now.get("items").unwrap_or(&now), &mut found);
        }
        found
    }
}

/// Adds the differences of an answer. It may have fields that the recorded one lacks: later versions have added some.
fn compare(place: &str, changing: &[&str], then: &Value, now: &Value, found: &mut Vec<String>) {
    match (then, now) {
        (Value::Object(then), Value::Object(now)) => {
            for (field, then) in then.iter().filter(|(field, _)| !changing.contains(&field.as_str())) {
                let now = now.get(field).unwrap_or(&Value::Null);
                compare(&format!("{place} {field}"), changing, then, now, found);
            }
        }
        (Value::Array(then), Value::Array(now)) if then.len() == now.len() => {
            for (at, (then, now)) in then.iter().zip(now).enumerate() {
                compare(&format!("{place} [{at}]"), changing, then, now, found);
            }
        }
        (then, now) if then == now || is_near(place, then, now) => {}
        (then, now) => found.push(format!("{place}: {then} then, {now} now")),
    }
}

/// Whether a value is a length as near to that of a former program as later ones tell it.
fn is_near(place: &str, then: &Value, now: &Value) -> bool {
    // Later programs correct lengths for the slope of a whisker's offset.
    const BY_SLOPE_MM: f64 = 0.3;
    // Their intervals contain a factory error of 0.5 mm, where those of former programs began with 0.196 mm.
    const BY_TOLERANCE_MM: f64 = 0.304;
    // They are wider while the detector follows a change: one whisker of migration 16 stands 2 mm before a verdict.
    const BY_CHANGE_MM: f64 = 2.0;
    let Some((then, now)) = then.as_f64().zip(now.as_f64()) else { return false };
    let near_mm = BY_SLOPE_MM + BY_TOLERANCE_MM;
    match place.rsplit(' ').next() {
        Some("length_mm") => (then - now).abs() < BY_SLOPE_MM,
        Some("length_low_mm") => (-near_mm..near_mm + BY_CHANGE_MM).contains(&(then - now)),
        Some("length_high_mm") => (-near_mm..near_mm + BY_CHANGE_MM).contains(&(now - then)),
        _ => false,
    }
}

async fn newest_migration(address: &DatabaseAddress) -> i64 {
    count(address, "SELECT max(version) FROM _sqlx_migrations").await
}

/// Removes the transaction that waits in `redo`: the database is then as of the transaction before it.
async fn finish(address: &DatabaseAddress) {
    count(address, "DELETE FROM redo RETURNING number").await;
}

/// Opens a database in which a transaction waits for its version: nothing may be changed.
async fn is_refused(address: &DatabaseAddress) {
    let store = Store::open(address, "test").await.unwrap();
    for _ in 0..2 {
        let problem = store.prepare().await.unwrap_err();
        assert!(matches!(problem, StoreError::Unfinished { .. }) && !problem.is_passing(), "{problem}");
    }
    store.close().await;
}

/// A copy of a database in SQLite, in its folder.
pub(crate) fn sqlite_of(left: &Left) -> (TempDir, DatabaseAddress, String) {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("fleet.sqlite3");
    std::fs::copy(left.file("fleet.sqlite3"), &copy).unwrap();
    let url = format!("sqlite:{}", copy.display());
    (folder, DatabaseAddress::Sqlite(copy), url)
}

/// A copy of a database in PostgreSQL.
pub(crate) async fn postgres_of(left: &Left) -> (Postgres, DatabaseAddress, String) {
    let server = Postgres::start().await;
    let restored = server
        .client("psql")
        .args(["-X", "-q", "-d", DATABASE, "-v", "ON_ERROR_STOP=1", "-f"])
        .arg(left.file("fleet.sql"))
        .output();
    let restored = restored.unwrap();
    assert!(restored.status.success(), "psql: {}", String::from_utf8_lossy(&restored.stderr));
    let url = Postgres::url(server.port());
    (server, url.parse().unwrap(), url)
}

async fn sqlite_goes_on(left: &Left) {
    let (folder, address, url) = sqlite_of(left);
    left.goes_on(&address, (folder, &url), "views-sqlite.json").await;
}

async fn postgres_goes_on(left: &Left) {
    let (_server, address, url) = postgres_of(left).await;
    left.goes_on(&address, (tempfile::tempdir().unwrap(), &url), "views-postgres.json").await;
}

#[tokio::test]
async fn golden_a_sqlite_database_of_migration_16_goes_on_with_nothing_lost() {
    sqlite_goes_on(&LEFT_16).await;
}

#[tokio::test]
async fn golden_a_postgresql_database_of_migration_16_goes_on_with_nothing_lost() {
    postgres_goes_on(&LEFT_16).await;
}

#[tokio::test]
async fn golden_a_sqlite_database_of_migration_37_goes_on_with_nothing_lost() {
    sqlite_goes_on(&LEFT_37).await;
}

#[tokio::test]
async fn golden_a_postgresql_database_of_migration_37_goes_on_with_nothing_lost() {
    postgres_goes_on(&LEFT_37).await;
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
