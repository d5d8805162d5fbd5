//! Reads the service's database as an external reader.

use std::path::Path;

use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};
use sqlx::{Row, SqlitePool};

/// A connection that reads.
pub(crate) struct Database {
    pool: SqlitePool,
}

/// A contact with its name (the robot's boot, the message's number, the position in it) and its measured values.
#[derive(Debug)]
pub(crate) struct Recorded {
    pub(crate) robot: String,
    pub(crate) boot_id: String,
    pub(crate) seq: i64,
    pub(crate) position: i64,
    pub(crate) whisker: i64,
    pub(crate) t_us: i64,
    pub(crate) strain: f64,
    pub(crate) length_mm: f64,
}

impl Database {
    pub(crate) async fn open(path: &Path) -> Self {
        let options = SqliteConnectOptions::new().filename(path).read_only(true);
        Self { pool: SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap() }
    }

    /// Runs a query for one number; 0 while the database or its table does not exist yet.
    pub(crate) async fn early_number(path: &Path, sql: &'static str) -> i64 {
        let options = SqliteConnectOptions::new().filename(path).read_only(true);
        let Ok(pool) = SqlitePoolOptions::new().max_connections(1).connect_with(options).await else { return 0 };
        sqlx::query_scalar(sql).fetch_one(&pool).await.unwrap_or(0)
    }

    /// Runs a query for one number.
    pub(crate) async fn number(&self, sql: &'static str) -> i64 {
        sqlx::query_scalar(sql).fetch_one(&self.pool).await.unwrap_or_else(|error| panic!("{sql}: {error}"))
    }

    /// Runs a query for one column of texts.
    pub(crate) async fn texts(&self, sql: &'static str) -> Vec<String> {
        sqlx::query_scalar(sql).fetch_all(&self.pool).await.unwrap_or_else(|error| panic!("{sql}: {error}"))
    }

    /// Every contact in the order of recording.
    pub(crate) async fn contacts(&self) -> Vec<Recorded> {
        let rows = sqlx::query(
            "SELECT robot, b.boot_id, seq, c.position, whisker, t_us, strain, c.length_mm FROM contacts c \
             JOIN boots b USING (boot) JOIN robots r ON r.robot_id = b.robot_id \
             JOIN whiskers w ON w.whisker_id = c.whisker_id ORDER BY contact_id",
        )
        .fetch_all(&self.pool)
        .await
        .unwrap();
        let recorded = |row: &sqlx::sqlite::SqliteRow| Recorded {
            robot: row.get("robot"),
            boot_id: row.get("boot_id"),
            seq: row.get("seq"),
            position: row.get("position"),
            whisker: row.get("whisker"),
            t_us: row.get("t_us"),
            strain: row.get("strain"),
            length_mm: row.get("length_mm"),
        };
        rows.iter().map(recorded).collect()
    }

    /// Number of contacts, and of their different names; equal if no contact is recorded twice.
    pub(crate) async fn counted(&self) -> (i64, i64) {
        let sql = "SELECT count(*), count(DISTINCT boot || ' ' || seq || ' ' || position) FROM contacts";
        sqlx::query_as(sql).fetch_one(&self.pool).await.unwrap()
    }
}
