//! The two databases, behind one face: SQLite, a file, and PostgreSQL, a server that supervisors share.
//!
//! Most statements are the same for both (`$1` is a parameter in either) and stand in [`on!`]; what differs is in
//! the modules `sqlite` and `postgres`.

use std::time::Duration;

use sqlx::migrate::{MigrateError, Migration, MigrationType, Migrator};
use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool};
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection, SqlitePool};
use sqlx::{ConnectOptions, SqlSafeStr};

use super::StoreError;
use super::lock::FileLock;

/// The same expression on whichever database it is.
macro_rules! on {
    ($database:expr, |$name:ident| $body:expr) => {
        match $database {
            $crate::store::database::Either::Sqlite($name) => $body,
            $crate::store::database::Either::Postgres($name) => $body,
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
/// How to connect.
pub(super) type Options = Either<(SqliteConnectOptions, Option<FileLock>), PgConnectOptions>;

impl Options {
    /// A connection of its own.
    pub(super) async fn connect(&self) -> sqlx::Result<Link> {
        match self {
            Either::Sqlite((options, _)) => options.connect().await.map(Either::Sqlite),
            Either::Postgres(options) => {
                let mut link = options.connect().await?;
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
            include_str!(concat!("../../../../migrations/", $folder, "/", $name, ".sql")).into_sql_str(),
            false,
        )),+])
    };
}

impl Pool {
    /// Brings the tables up to date.
    pub(super) async fn migrate(&self, database: &str) -> Result<(), StoreError> {
        match self {
            Either::Sqlite(pool) => {
                migrations!("sqlite": 1 "0001_supervision", 2 "0002_leases", 3 "0003_closed_loop", 4 "0004_rates",
                    5 "0005_actions", 6 "0006_access", 7 "0007_alarms", 8 "0008_changes", 9 "0009_calibrations",
                    10 "0010_inline_states", 11 "0011_journal")
                .run(pool)
                .await
            }
            Either::Postgres(pool) => {
                migrations!("postgres": 1 "0001_supervision", 2 "0002_leases", 3 "0003_closed_loop", 4 "0004_rates",
                    5 "0005_actions", 6 "0006_access", 7 "0007_alarms", 8 "0008_changes", 9 "0009_calibrations",
                    10 "0010_inline_states", 11 "0011_journal")
                .run(pool)
                .await
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
}

/// How long a connection for reading is waited for.
pub(super) const ACQUIRE_PATIENCE: Duration = Duration::from_secs(3);
