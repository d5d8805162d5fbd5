//! The common interface of the two databases: SQLite, a file, and PostgreSQL, a server that supervisors share.
//!
//! Most statements are the same for both (`$1` is a parameter in either) and are used within [`on!`]. Statements that
//! differ are in the modules `sqlite` and `postgres`.

use std::time::Duration;

use sqlx::SqlSafeStr;
use sqlx::migrate::{MigrateError, Migration, MigrationType, Migrator};
use sqlx::postgres::{PgConnection, PgPool};
use sqlx::sqlite::{SqliteConnection, SqlitePool};
use tokio::time::{Instant, interval_at};
use tracing::info;

use super::StoreError;

/// Evaluates the same expression for whichever database is in use.
macro_rules! on {
    ($database:expr, |$name:ident| $body:expr) => {
        match $database {
            $crate::database::Either::Sqlite($name) => $body,
            $crate::database::Either::Postgres($name) => $body,
        }
    };
}
pub(super) use on;

/// A value for SQLite, or its counterpart for PostgreSQL.
#[derive(Debug, Clone)]
pub(super) enum Either<S, P> {
    Sqlite(S),
    Postgres(P),
}

/// Pool of connections for queries and for small, rare transactions.
pub(super) type Pool = Either<SqlitePool, PgPool>;
/// A single connection for writing.
pub(super) type Link = Either<SqliteConnection, PgConnection>;
/// An open transaction.
pub(super) type Tx<'c> = Either<sqlx::Transaction<'c, sqlx::Sqlite>, sqlx::Transaction<'c, sqlx::Postgres>>;

impl Pool {
    /// Begins a transaction that writes, on a connection of the pool. For rare and small transactions only.
    pub(super) async fn begin(&self) -> sqlx::Result<Tx<'static>> {
        match self {
            Either::Sqlite(pool) => pool.begin_with("BEGIN IMMEDIATE").await.map(Either::Sqlite),
            Either::Postgres(pool) => pool.begin().await.map(Either::Postgres),
        }
    }
}

impl Link {
    /// Begins a transaction that writes.
    pub(super) async fn begin(&mut self) -> sqlx::Result<Tx<'_>> {
        match self {
            // IMMEDIATE: a transaction that begins with a read can fail at its first write.
            Either::Sqlite(link) => sqlx::Connection::begin_with(link, "BEGIN IMMEDIATE").await.map(Either::Sqlite),
            Either::Postgres(link) => sqlx::Connection::begin(link).await.map(Either::Postgres),
        }
    }
}

impl Tx<'_> {
    /// Undoes the transaction.
    pub(super) async fn rollback(self) -> sqlx::Result<()> {
        on!(self, |tx| tx.rollback().await)
    }

    /// Commits the transaction.
    pub(super) async fn commit(self) -> sqlx::Result<()> {
        on!(self, |tx| tx.commit().await)
    }
}

/// The migrations by database, which the build script lists.
mod migrations {
    include!(concat!(env!("OUT_DIR"), "/migrations.rs"));
}

fn migrator(files: &[(&'static str, &'static str)]) -> Migrator {
    let migrations = files.iter().map(|&(name, sql)| {
        // A name begins with the migration's number.
        let version = name.split('_').next().and_then(|number| number.parse().ok()).unwrap_or_default();
        Migration::new(version, name.into(), MigrationType::Simple, sql.into_sql_str(), false)
    });
    Migrator::with_migrations(migrations.collect())
}

impl Pool {
    /// Migrates the tables to the newest version, one transaction for each migration: an interruption undoes only the
    /// current one.
    pub(super) async fn migrate(&self, database: &str) -> Result<(), StoreError> {
        let applied = self.applied().await;
        if applied.is_some_and(|applied| WITH_REDO.contains(&applied)) && self.has_unfinished().await {
            return Err(StoreError::Unfinished { database: database.to_owned() });
        }
        match self {
            Either::Sqlite(pool) => {
                let migrator = migrator(migrations::SQLITE);
                self.change(&migrator, applied, |version| migrator.run_to(version, pool)).await
            }
            Either::Postgres(pool) => {
                let migrator = migrator(migrations::POSTGRES);
                self.change(&migrator, applied, |version| migrator.run_to(version, pool)).await
            }
        }
        .map_err(|source| {
            let database = database.to_owned();
            if let MigrateError::VersionMissing(version) = source {
                return StoreError::TooNew { database, version };
            }
            // The constraint of migration 60: an earlier version is still running.
            if source.to_string().contains("redo_is_empty") {
                return StoreError::Unfinished { database };
            }
            StoreError::Migrate { database, source }
        })
    }

    /// Whether an earlier version has left transactions without their rows, which this version cannot read. Asked before the
    /// first migration, because the earlier version does not start after one.
    async fn has_unfinished(&self) -> bool {
        const SQL: &str = "SELECT count(*) FROM redo";
        on!(self, |pool| sqlx::query_scalar::<_, i64>(SQL).fetch_one(pool).await).is_ok_and(|count| count > 0)
    }

    /// Number of the newest migration that was applied; `None` for a new database, which has no such table. If the database is
    /// unreachable, the next statement fails, too.
    async fn applied(&self) -> Option<i64> {
        const SQL: &str = "SELECT max(version) FROM _sqlx_migrations";
        on!(self, |pool| sqlx::query_scalar(SQL).fetch_one(pool).await).unwrap_or_default()
    }

    /// Runs the missing migrations one after the other. Migrations of a database with data may take long, so their
    /// progress is logged.
    async fn change<W>(
        &self,
        migrator: &Migrator,
        applied: Option<i64>,
        run_to: impl Fn(i64) -> W,
    ) -> Result<(), MigrateError>
    where
        W: Future<Output = Result<(), MigrateError>>,
    {
        let newest = migrator.iter().map(|migration| migration.version).max().unwrap_or_default();
        if let Some(applied) = applied.filter(|&applied| applied < newest) {
            let rows = self.contacts_about().await.unwrap_or_default();
            for migration in migrator.iter().filter(|migration| migration.version > applied) {
                watched(&migration.description, rows, run_to(migration.version)).await?;
            }
        }
        run_to(newest).await
    }

    /// Approximate number of contacts, which make up most of the rows that a migration may rewrite.
    async fn contacts_about(&self) -> sqlx::Result<i64> {
        match self {
            Either::Sqlite(pool) => {
                sqlx::query_scalar("SELECT coalesce(max(contact_id), 0) FROM contacts").fetch_one(pool).await
            }
            Either::Postgres(pool) => {
                sqlx::query_scalar(
                    "SELECT coalesce(sum(greatest(reltuples, 0)), 0)::bigint FROM pg_class \
                     WHERE relkind = 'r' AND relname ~ '^contacts(_|$)'",
                )
                .fetch_one(pool)
                .await
            }
        }
    }
}

/// Newest migrations of databases with the table `redo`.
const WITH_REDO: std::ops::Range<i64> = 13..60;
/// Interval between log messages about a running migration.
const PROGRESS: Duration = Duration::from_secs(5);

/// Logs the begin, progress and end of a migration.
async fn watched<T>(
    migration: &str,
    contacts: i64,
    work: impl Future<Output = Result<T, MigrateError>>,
) -> Result<T, MigrateError> {
    let begun = Instant::now();
    info!(migration, contacts, "migrating the tables; an interruption undoes this migration");
    tokio::pin!(work);
    let mut ticks = interval_at(begun + PROGRESS, PROGRESS);
    loop {
        let seconds = begun.elapsed().as_secs_f32();
        tokio::select! {
            done = &mut work => {
                info!(migration, seconds = begun.elapsed().as_secs_f32(), ok = done.is_ok(), "migration ended");
                return done;
            }
            _ = ticks.tick() => info!(migration, seconds, "still migrating the tables"),
        }
    }
}

/// Time limit for getting a connection from the pool.
pub(super) const ACQUIRE_PATIENCE: Duration = Duration::from_secs(3);
