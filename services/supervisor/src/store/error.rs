//! Why the database cannot be used.

use std::path::PathBuf;
use std::time::Duration;

/// Why the database cannot be used. No variant shows a password.
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
    /// Another supervisor works with the file.
    #[error(
        "the database {path} belongs to {holder} now: stop that supervisor, give this one a file of its own, or let \
         them share a PostgreSQL with --database-url postgres://..."
    )]
    InUse {
        /// Which database.
        path: PathBuf,
        /// Who, as it says of itself.
        holder: String,
    },
    /// It cannot be opened.
    #[error("cannot open the database {database}: {source}")]
    Open {
        /// Which.
        database: String,
        /// Why.
        source: sqlx::Error,
    },
    /// Its lock cannot be taken.
    #[error("cannot lock the database with the file {path}: {source}")]
    Lock {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Its tables cannot be brought up to date.
    #[error("cannot bring the tables of {database} up to date: {source}")]
    Migrate {
        /// Which.
        database: String,
        /// Why.
        source: sqlx::migrate::MigrateError,
    },
    /// A newer version of the program has changed its tables.
    #[error(
        "a newer vibrissa has worked with {database}: this one, {}, does not know the change {version} of its tables. \
         Start the newer one, or restore the back-up of before the upgrade",
        env!("CARGO_PKG_VERSION")
    )]
    TooNew {
        /// Which.
        database: String,
        /// The first migration that is not known here.
        version: i64,
    },
    /// The server is too old.
    #[error("{database} is PostgreSQL {version}: version 15 or newer is needed")]
    TooOld {
        /// Which.
        database: String,
        /// Its version.
        version: String,
    },
    /// A query failed.
    #[error("database, while trying to {what}: {source}")]
    Query {
        /// What it was for.
        what: &'static str,
        /// Why.
        source: sqlx::Error,
    },
    /// No answer came.
    #[error("database, while trying to {what}: no answer in {} s", patience.as_secs())]
    NoAnswer {
        /// What it was for.
        what: &'static str,
        /// How long it was waited for.
        patience: Duration,
    },
    /// The fleet is not this supervisor's any more: nothing was written.
    #[error("fleet {fleet} is not ours any more: its lease of epoch {epoch} was taken over")]
    LeaseLost {
        /// Which fleet.
        fleet: String,
        /// The epoch that it was ours in.
        epoch: u64,
    },
}

impl StoreError {
    /// Whether waiting can help: the server is away, starting, or too busy. The opposite is a person's affair, such
    /// as a wrong password.
    #[must_use]
    pub fn is_passing(&self) -> bool {
        match self {
            Self::NoFolder { .. }
            | Self::InUse { .. }
            | Self::Lock { .. }
            | Self::TooNew { .. }
            | Self::TooOld { .. } => false,
            Self::Open { source, .. } | Self::Query { source, .. } => passes(source),
            Self::Migrate { source, .. } => {
                matches!(source, sqlx::migrate::MigrateError::Execute(source) if passes(source))
            }
            Self::NoAnswer { .. } => true,
            Self::LeaseLost { .. } => false,
        }
    }
}

/// Whether a server that gives this answer may give another one soon.
fn passes(problem: &sqlx::Error) -> bool {
    if let sqlx::Error::Database(told) = problem {
        // Connection trouble, lack of resources, shutting down or starting up, and conflicts.
        let code = told.code().unwrap_or_default();
        return ["08", "53", "57", "40", "55"].iter().any(|class| code.starts_with(class));
    }
    matches!(problem, sqlx::Error::Io(_) | sqlx::Error::PoolTimedOut | sqlx::Error::Protocol(_))
}

/// Names what a query is for, if it fails.
pub(super) fn failed(what: &'static str) -> impl FnOnce(sqlx::Error) -> StoreError {
    move |source| StoreError::Query { what, source }
}
