//! Measures pages of tables in a database with ten thousand robots of 24 whiskers. No robot is connected.

use std::time::Instant;

use serde_json::json;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, Executor};
use vibrissa_tests::web;

use crate::Bench;
use crate::report::{Figure, Target, median};
use crate::stage::{self, Store, Supervisor};

const PART: &str = "pages";
/// The fleet that the supervisor under test owns, which has no robots.
const OWN: &str = "own";
const ROBOTS: usize = 10_000;
const REQUESTS: usize = 7;

/// Requests: the name in the table, the path, and whether it is a page of a table.
const PAGES: [(&str, &str, bool); 14] = [
    ("robots of a fleet", "/v1/robots?fleet=big&limit=50", true),
    ("robots by attention", "/v1/robots?sort=attention&limit=50", true),
    ("whiskers of a robot", "/v1/whiskers?fleet=big&robot=robot-5000&limit=50", true),
    ("whiskers by length", "/v1/whiskers?sort=length_mm&limit=50", true),
    ("whiskers of a fleet by length", "/v1/whiskers?fleet=big&sort=length_mm&limit=50", true),
    ("compensations, the newest", "/v1/compensations?limit=50", true),
    ("compensations by robot", "/v1/compensations?sort=robot&limit=50", true),
    ("setpoints in a state", "/v1/setpoints?state=REJECTED&limit=50", true),
    ("alarms by urgency", "/v1/alarms?sort=urgency&limit=50", true),
    ("fleets", "/v1/fleets", true),
    ("board of all robots", "/v1/board", true),
    ("board of the faulty robots", "/v1/board?state=FAULTY", true),
    ("overview of all fleets", "/v1/overview", false),
    ("overview of a fleet", "/v1/overview?fleet=big", false),
];

/// Rows of a table: its columns, their values for the number `i`, and how many numbers there are. `NOW` is the present time.
const ROWS: [(&str, &str, usize); 8] = [
    (
        "robots(robot_id, fleet, robot, connection, model, updated_us)",
        "1000000 + i, 'big', 'robot-' || i, 'ONLINE', 'm', NOW",
        ROBOTS,
    ),
    (
        "arrays(array_id, robot_id, \"array\", array_type, whiskers)",
        "1000000 + i, 1000000 + i, 'left', 'TYPE_1', 24",
        ROBOTS,
    ),
    (
        "whiskers(whisker_id, array_id, robot_id, whisker, position, x_mm, y_mm, model, whole_length_mm, \
         nominal_pressure_mpa, pressure_max_mpa, length_mm, length_sd_mm, condition, pressure_mpa, setpoint_mpa, \
         contacts, heard_us, state)",
        "1000000 + i, 1000000 + (i + 23) / 24, 1000000 + (i + 23) / 24, i % 24, i % 24, 1.0, 2.0, 'nguyen-2021', 70.0, \
         0.1, 0.2, 70.0 - 0.0001 * (i * 7919 % 100003), 0.1, CASE WHEN i % 10 = 0 THEN 'TRIMMED' ELSE 'HEALTHY' END, 0.1, \
         0.1, i % 1009, NOW, STATE",
        24 * ROBOTS,
    ),
    (
        "compensations(compensation_id, robot_id, target_whisker_id, target_length_mm, target_pressure_mpa, \
         compensator_whisker_id, compensation_case, pressure_before_mpa, pressure_mpa, predicted_error, decided_us, \
         ended_us)",
        "1000000 + i, 1000000 + (10 * i + 23) / 24, 1000000 + 10 * i, 65.0, 0.1, 1000000 + 10 * i, 'SELF_COMPENSATION', 0.1, \
         0.12, 0.02, NOW - 5000000 * i, CASE WHEN i % 2 = 0 THEN NOW END",
        2 * ROBOTS,
    ),
    (
        "compensation_errors(compensation_id, recorded_us, contacts, bins, error, error_low, error_high)",
        "1000000 + i, NOW, 500, 20, 0.02, 0.01, 0.03",
        2 * ROBOTS,
    ),
    (
        "setpoints(command_id, robot_id, whisker_id, epoch, version, robot_boot_id, pressure_mpa, slew_mpa_per_s, \
         issued_us, expires_us, reason, state)",
        "'c' || i, 1000000 + (i + 23) / 24, 1000000 + i, 1, i, 'b', 0.1, 0.02, NOW - 1000000 * i, NOW, 'SELF_COMPENSATION', \
         CASE WHEN i % 100 = 0 THEN 'REJECTED' ELSE 'APPLIED' END",
        10 * ROBOTS,
    ),
    ("setpoint_states(command_id, recorded_us, state)", "'c' || i, NOW, 'PENDING'", 10 * ROBOTS),
    (
        "alarms(whisker_id, raised_us, kind, cleared_us)",
        "1000000 + i, NOW - 5000000 * i, CASE WHEN i % 2 = 0 THEN 'LEAK' ELSE 'ERODING' END, \
         CASE WHEN i % 4 = 0 THEN NULL ELSE NOW END",
        2 * ROBOTS,
    ),
];

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    bench.say(&format!("{PART}: {ROBOTS} robots with 24 whiskers each"));
    let broker = stage::broker();
    let stores = [Store::postgres().await, Store::Sqlite(bench.stage.folder.path().join("pages.sqlite3"))];
    for store in &stores {
        let supervisor = Supervisor::start(&bench.stage, &broker, store, OWN).await?;
        fill(store).await?;
        for (what, path, is_table) in PAGES {
            let mut times = Vec::new();
            for _ in 0..REQUESTS {
                let begun = Instant::now();
                let (status, body) = web::try_get(supervisor.http, path).await?;
                times.push(1e3 * begun.elapsed().as_secs_f64());
                anyhow::ensure!(status == 200, "{path}: {status} {body}");
            }
            let slowest = times.iter().copied().fold(0.0, f64::max);
            bench.line(PART, 0, json!({ "subject": store.name(), "page": what, "ms": times }))?;
            let target = if is_table { Target::AtMost(100.0) } else { Target::None };
            let beside = format!("slowest of {REQUESTS}: {slowest:.0} ms");
            bench.row(PART, &format!("{}: {what}", store.name()), target, Figure(median(times), "ms"), beside)?;
        }
        supervisor.stop().await?;
    }
    Ok(())
}

/// Writes the rows.
async fn fill(store: &Store) -> anyhow::Result<()> {
    // PostgreSQL accepts numbers for its identity columns only with this clause, which SQLite does not know.
    let (now, state, overriding) = match store {
        Store::Postgres(_) => (
            "(extract(epoch FROM now()) * 1000000)::bigint",
            "decode(repeat('5a', 900), 'hex')",
            "OVERRIDING SYSTEM VALUE",
        ),
        Store::Sqlite(_) => ("unixepoch() * 1000000", "randomblob(900)", ""),
    };
    for (table, values, rows) in ROWS {
        let values = values.replace("NOW", now).replace("STATE", state);
        let sql = AssertSqlSafe(format!(
            "INSERT INTO {table} {overriding} WITH RECURSIVE n(i) AS (SELECT CAST(1 AS bigint) UNION ALL SELECT i + 1 FROM n WHERE i < {rows}) \
             SELECT {values} FROM n"
        ));
        match store {
            Store::Postgres(server) => {
                let mut connection = server.connect().connect().await?;
                connection.execute(sql).await?;
                // As autovacuum does in time.
                connection.execute("ANALYZE").await?;
                connection.close().await?;
            }
            Store::Sqlite(path) => {
                let mut connection = SqliteConnectOptions::new().filename(path).connect().await?;
                connection.execute(sql).await?;
                connection.close().await?;
            }
        }
    }
    Ok(())
}
