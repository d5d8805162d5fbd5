//! The database: named queries, one transaction for each batch.
//!
//! [`batch`] is what is written, [`commit`] writes it, [`load`] reads back what a restart needs, [`read`] what people ask for, as [`readings`]. Nothing outside this module knows SQL.

pub mod address;
pub mod batch;
mod commit;
mod load;
pub mod read;
pub mod readings;

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{SqlSafeStr, SqlitePool};

pub use address::DatabaseAddress;
pub use batch::Batch;
pub use load::StoredRobot;

/// Why the database cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// There is no place for it.
    #[error("cannot make the database {path}: the folder {folder} does not exist")]
    NoFolder {
        /// Which database.
        path: PathBuf,
        /// Where it would be.
        folder: PathBuf,
    },
    /// It cannot be opened.
    #[error("cannot open the database {path}: {source}")]
    Open {
        /// Which.
        path: PathBuf,
        /// Why.
        source: sqlx::Error,
    },
    /// Its tables cannot be brought up to date.
    #[error("cannot bring the tables of {path} up to date: {source}")]
    Migrate {
        /// Which.
        path: PathBuf,
        /// Why.
        source: sqlx::migrate::MigrateError,
    },
    /// A query failed.
    #[error("database, while trying to {what}: {source}")]
    Query {
        /// What it was for.
        what: &'static str,
        /// Why.
        source: sqlx::Error,
    },
}

/// The migrations, part of the program. (The macro that would read them at build time costs a second build of
/// the whole database library.)
fn migrations() -> Migrator {
    let first = Migration::new(
        1,
        "supervision".into(),
        MigrationType::Simple,
        include_str!("../../../../migrations/sqlite/0001_supervision.sql").into_sql_str(),
        false,
    );
    Migrator::with_migrations(vec![first])
}

/// Names what a query is for, if it fails.
fn failed(what: &'static str) -> impl FnOnce(sqlx::Error) -> StoreError {
    move |source| StoreError::Query { what, source }
}

/// An open database.
#[derive(Debug, Clone)]
pub struct Store {
    pool: SqlitePool,
}

impl Store {
    /// Opens or makes the file, and brings its tables up to date.
    ///
    /// # Errors
    /// The file or its folder cannot be used, or it is not ours.
    pub async fn open(path: &Path) -> Result<Self, StoreError> {
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists()) {
            return Err(StoreError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
        }
        let open_error = |source| StoreError::Open { path: path.to_owned(), source };
        let options = SqliteConnectOptions::from_str("sqlite:")
            .map_err(open_error)?
            .filename(path)
            .create_if_missing(true)
            .foreign_keys(true)
            .journal_mode(SqliteJournalMode::Wal)
            // A commit that was receipted must survive a loss of power.
            .synchronous(SqliteSynchronous::Full)
            .busy_timeout(Duration::from_secs(10));
        let pool = SqlitePoolOptions::new().max_connections(4).connect_with(options).await.map_err(open_error)?;
        migrations().run(&pool).await.map_err(|source| StoreError::Migrate { path: path.to_owned(), source })?;
        Ok(Self { pool })
    }

    /// Whether it answers.
    ///
    /// # Errors
    /// It does not.
    pub async fn ping(&self) -> Result<(), StoreError> {
        sqlx::query("SELECT 1").execute(&self.pool).await.map(drop).map_err(failed("ask whether it is there"))
    }

    /// Closes all connections, so that the file is complete by itself.
    pub async fn close(&self) {
        self.pool.close().await;
    }
}
