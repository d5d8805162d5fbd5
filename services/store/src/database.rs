//! The two databases, behind one face: SQLite, a file, and PostgreSQL, a server that supervisors share.
//!
//! Most statements are the same for both (`$1` is a parameter in either) and stand in [`on!`]; what differs is in
//! the modules `sqlite` and `postgres`.

use std::time::Duration;

use sqlx::migrate::{MigrateError, Migration, MigrationType, Migrator};
use sqlx::postgres::{PgConnection, PgPool};
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection, SqlitePool};
use sqlx::{ConnectOptions, SqlSafeStr};
use tokio::time::{Instant, interval_at};
use tracing::info;

use super::StoreError;
use super::address::PostgresAddress;
use super::lock::FileLock;

/// The same expression on whichever database it is.
macro_rules! on {
    ($database:expr, |$name:ident| $body:expr) => {
        match $database {
            $crate::database::Either::Sqlite($name) => $body,
            $crate::database::Either::Postgres($name) => $body,
        }
    };
}
pub(super) use on;

/// One thing of SQLite's, or its like of PostgreSQL's.
#[derive(Debug, Clone)]
pub(super) enum Either<S, P> {
    Sqlite(S),
    Postgres(P),
}

/// Connections for reading.
pub(super) type Pool = Either<SqlitePool, PgPool>;
/// A connection of its own, for writing.
pub(super) type Link = Either<SqliteConnection, PgConnection>;
/// An open transaction.
pub(super) type Tx<'c> = Either<sqlx::Transaction<'c, sqlx::Sqlite>, sqlx::Transaction<'c, sqlx::Postgres>>;
/// How to connect; to a server, with the connections for reading, which must know of a new password.
pub(super) type Options = Either<(SqliteConnectOptions, Option<FileLock>), (PostgresAddress, PgPool)>;

impl Options {
    /// A connection of its own.
    pub(super) async fn connect(&self) -> sqlx::Result<Link> {
        match self {
            Either::Sqlite((options, _)) => options.connect().await.map(Either::Sqlite),
            Either::Postgres((address, pool)) => {
                let address = address.with_password_read_again();
                pool.set_connect_options((*address).clone());
                let mut link = address.connect().await?;
                super::postgres::prepare_writer(&mut link).await?;
                Ok(Either::Postgres(link))
            }
        }
    }
}

impl Pool {
    /// Begins a transaction that writes, on one of the connections for reading: for what is rare and small.
    pub(super) async fn begin(&self) -> sqlx::Result<Tx<'static>> {
        match self {
            Either::Sqlite(pool) => pool.begin_with("BEGIN IMMEDIATE").await.map(Either::Sqlite),
            Either::Postgres(pool) => pool.begin().await.map(Either::Postgres),
        }
    }
}

impl Link {
    /// Begins a transaction.
    pub(super) async fn begin(&mut self) -> sqlx::Result<Tx<'_>> {
        match self {
            // At once for writing: a transaction that begins by reading can fail when it comes to write.
            Either::Sqlite(link) => sqlx::Connection::begin_with(link, "BEGIN IMMEDIATE").await.map(Either::Sqlite),
            Either::Postgres(link) => sqlx::Connection::begin(link).await.map(Either::Postgres),
        }
    }
}

impl Tx<'_> {
    /// Leaves everything as it was.
    pub(super) async fn rollback(self) -> sqlx::Result<()> {
        on!(self, |tx| tx.rollback().await)
    }

    /// Makes it last.
    pub(super) async fn commit(self) -> sqlx::Result<()> {
        on!(self, |tx| tx.commit().await)
    }
}

/// The migrations, part of the program. (The macro that would read them at build time costs a second build of
/// the whole database library.)
macro_rules! migrations {
    ($folder:literal: $($version:literal $name:literal),+) => {
        Migrator::with_migrations(vec![$(Migration::new(
            $version,
            $name.into(),
            MigrationType::Simple,
            include_str!(concat!("../../../migrations/", $folder, "/", $name, ".sql")).into_sql_str(),
            false,
        )),+])
    };
}

impl Pool {
    /// Brings the tables up to date: a transaction for each change, so that whoever stops it loses that one's work only.
    pub(super) async fn migrate(&self, database: &str) -> Result<(), StoreError> {
        match self {
            Either::Sqlite(pool) => {
                let migrator = migrations!("sqlite": 1 "0001_supervision", 2 "0002_leases", 3 "0003_closed_loop",
                    4 "0004_rates", 5 "0005_actions", 6 "0006_access", 7 "0007_alarms", 8 "0008_changes",
                    9 "0009_calibrations", 10 "0010_inline_states", 11 "0011_journal", 12 "0012_history", 13 "0013_redo",
                    14 "0014_quarantine", 15 "0015_allowed_robots", 16 "0016_supervisor_hearing");
                self.change(&migrator, |version| migrator.run_to(version, pool)).await
            }
            Either::Postgres(pool) => {
                let migrator = migrations!("postgres": 1 "0001_supervision", 2 "0002_leases", 3 "0003_closed_loop",
                    4 "0004_rates", 5 "0005_actions", 6 "0006_access", 7 "0007_alarms", 8 "0008_changes",
                    9 "0009_calibrations", 10 "0010_inline_states", 11 "0011_journal", 12 "0012_history", 13 "0013_redo",
                    14 "0014_quarantine", 15 "0015_allowed_robots", 16 "0016_supervisor_hearing");
                self.change(&migrator, |version| migrator.run_to(version, pool)).await
            }
        }
        .map_err(|source| {
            let database = database.to_owned();
            if let MigrateError::VersionMissing(version) = source {
                return StoreError::TooNew { database, version };
            }
            StoreError::Migrate { database, source }
        })
    }

    /// One change after the other. Those of a database with something in it may take their time, and are told of.
    async fn change<W>(&self, migrator: &Migrator, run_to: impl Fn(i64) -> W) -> Result<(), MigrateError>
    where
        W: Future<Output = Result<(), MigrateError>>,
    {
        const APPLIED: &str = "SELECT max(version) FROM _sqlx_migrations";
        // A new database has no such table; one that is away says so again at once.
        let applied: Option<i64> =
            on!(self, |pool| sqlx::query_scalar(APPLIED).fetch_one(pool).await).unwrap_or_default();
        let newest = migrator.iter().map(|migration| migration.version).max().unwrap_or_default();
        if let Some(applied) = applied.filter(|&applied| applied < newest) {
            let rows = self.contacts_about().await.unwrap_or_default();
            for migration in migrator.iter().filter(|migration| migration.version > applied) {
                watched(&migration.description, rows, run_to(migration.version)).await?;
            }
        }
        run_to(newest).await
    }

    /// How many contacts there are, about: most of what a change may have to go through.
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

/// How often it is told that a change of the tables is still under way.
const PROGRESS: Duration = Duration::from_secs(5);

/// Tells of a change of the tables while it goes on.
async fn watched<T>(
    migration: &str,
    contacts: i64,
    work: impl Future<Output = Result<T, MigrateError>>,
) -> Result<T, MigrateError> {
    let begun = Instant::now();
    info!(migration, contacts, "changing the tables; stopped now, they stay as they were");
    tokio::pin!(work);
    let mut ticks = interval_at(begun + PROGRESS, PROGRESS);
    loop {
        let seconds = begun.elapsed().as_secs_f32();
        tokio::select! {
            done = &mut work => {
                info!(migration, seconds = begun.elapsed().as_secs_f32(), ok = done.is_ok(), "the tables are changed");
                return done;
            }
            _ = ticks.tick() => info!(migration, seconds, "still changing the tables"),
        }
    }
}

/// How long a connection for reading is waited for.
pub(super) const ACQUIRE_PATIENCE: Duration = Duration::from_secs(3);
