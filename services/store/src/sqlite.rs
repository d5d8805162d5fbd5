//! SQLite's part of the store: the file and its connections.

use std::fs::OpenOptions;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};

use super::database::{ACQUIRE_PATIENCE, Either, Options, Pool};
use super::lock::FileLock;
use super::{StoreError, database};

/// Mode of a new database: readable by its owner only, because it contains hashes of tokens and the audit log.
const MODE: u32 = 0o600;

/// Opens or creates the file, and locks it for the supervisor.
pub(super) async fn open(path: &Path, name: &str, supervisor: &str) -> Result<(Pool, Options), StoreError> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists()) {
        return Err(StoreError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    let lock = FileLock::take(path, supervisor)?;
    // SQLite gives its other files the mode of this one. A failure is ignored here, because SQLite reports it.
    let _ = OpenOptions::new().write(true).create_new(true).mode(MODE).open(path);
    connect(path, name, Some(lock)).await
}

/// Opens the file without locking it, beside the supervisor that has locked it.
pub(super) async fn open_beside(path: &Path, name: &str) -> Result<(Pool, Options), StoreError> {
    connect(path, name, None).await
}

async fn connect(path: &Path, name: &str, lock: Option<FileLock>) -> Result<(Pool, Options), StoreError> {
    let options = SqliteConnectOptions::new()
        .filename(path)
        .create_if_missing(true)
        .foreign_keys(true)
        .journal_mode(SqliteJournalMode::Wal)
        // A receipted commit must survive a loss of power.
        .synchronous(SqliteSynchronous::Full)
        // A checkpoint of the write-ahead log every 4,000 pages (16 MB): the same pages are written again and again.
        .pragma("wal_autocheckpoint", "4000")
        .busy_timeout(Duration::from_secs(10));
    let pool = SqlitePoolOptions::new()
        .max_connections(4)
        .acquire_timeout(ACQUIRE_PATIENCE)
        .connect_with(options.clone())
        .await
        .map_err(|source| StoreError::Open { database: name.to_owned(), source })?;
    Ok((database::Pool::Sqlite(pool), Either::Sqlite((options, lock))))
}
