//! SQLite's part of the store: the file and its connections.

use std::fs::OpenOptions;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{ConnectOptions as _, Connection as _};
use tokio::time::Instant;
use tracing::info;

use super::connect::Options;
use super::database::{ACQUIRE_PATIENCE, Either, Pool};
use super::lock::FileLock;
use super::{StoreError, database, failed};

/// Mode of a new database: readable by its owner only, because it contains hashes of tokens and the audit log.
const MODE: u32 = 0o600;

/// Opens or creates the file, and locks it for the supervisor.
pub(super) async fn open(path: &Path, name: &str, supervisor: &str) -> Result<(Pool, Options), StoreError> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists()) {
        return Err(StoreError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    let lock = FileLock::take(path, supervisor)?;
    if std::fs::metadata(path).map_or(0, |file| file.len()) == 0 {
        refuse_new(path, &lock)?;
    }
    // SQLite gives its other files the mode of this one. A failure is ignored here, because SQLite reports it.
    let _ = OpenOptions::new().write(true).create_new(true).mode(MODE).open(path);
    connect(path, name, Some(lock)).await
}

/// Refuses a database without tables in the place of one that had tables.
fn refuse_new(path: &Path, lock: &FileLock) -> Result<(), StoreError> {
    match lock.installed() {
        Some(mark) => Err(StoreError::Vanished { path: path.to_owned(), mark: mark.to_owned() }),
        None => Ok(()),
    }
}

/// Time limit for the check of a file: a large database must not delay the start for long.
const CHECK_PATIENCE: Duration = Duration::from_secs(10);
/// Steps of SQLite's program between two looks at the time.
const CHECK_STEPS: i32 = 1000;

/// Looks for damage of the file as far as the time allows: first its structure, then its indexes, too.
pub(super) async fn check(options: &SqliteConnectOptions) -> Result<(), StoreError> {
    let database = options.get_filename().display().to_string();
    let deadline = Instant::now() + CHECK_PATIENCE;
    let damaged = |findings: String| StoreError::Damaged { database: database.clone(), findings };
    let failed = |source: sqlx::Error| match damage(&source) {
        Some(findings) => damaged(findings),
        None => StoreError::Open { database: database.clone(), source },
    };
    let mut link = options.clone().read_only(true).create_if_missing(false).connect().await.map_err(failed)?;
    link.lock_handle().await.map_err(failed)?.set_progress_handler(CHECK_STEPS, move || Instant::now() < deadline);
    for pragma in ["PRAGMA quick_check(3)", "PRAGMA integrity_check(3)"] {
        let findings: Vec<String> = match sqlx::query_scalar(pragma).fetch_all(&mut link).await {
            Ok(findings) => findings,
            Err(sqlx::Error::Database(error)) if error.code().as_deref() == Some(INTERRUPTED) => {
                info!(database, seconds = CHECK_PATIENCE.as_secs(), "the check of the database's file took too long");
                break;
            }
            Err(problem) => return Err(failed(problem)),
        };
        if findings != ["ok"] {
            return Err(damaged(findings.join("; ")));
        }
    }
    // An error here concerns only this connection.
    let _ = link.close().await;
    Ok(())
}

/// SQLite's code of an interrupted statement.
const INTERRUPTED: &str = "9";

/// SQLite's words about a file that it cannot read, if the error is of that kind: CORRUPT or NOTADB.
pub(super) fn damage(problem: &sqlx::Error) -> Option<String> {
    let sqlx::Error::Database(error) = problem else { return None };
    let code: i32 = error.code()?.parse().ok()?;
    // The lower 8 bits are the kind of an extended code.
    matches!(code & 0xff, 11 | 26).then(|| error.message().to_owned())
}

/// Checks that the tables of the program exist if they have existed; afterwards they must.
pub(super) async fn check_tables(pool: &SqlitePool, options: &Options) -> Result<(), StoreError> {
    const SQL: &str = "SELECT count(*) FROM sqlite_master WHERE name = '_sqlx_migrations'";
    let Either::Sqlite((options, Some(lock))) = options else { return Ok(()) };
    let count: i64 = sqlx::query_scalar(SQL).fetch_one(pool).await.map_err(failed("look for the tables"))?;
    if count == 0 { refuse_new(options.get_filename(), lock) } else { Ok(()) }
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
        .map_err(|source| match damage(&source) {
            Some(findings) => StoreError::Damaged { database: path.display().to_string(), findings },
            None => StoreError::Open { database: name.to_owned(), source },
        })?;
    Ok((database::Pool::Sqlite(pool), Either::Sqlite((options, lock))))
}

#[cfg(test)]
pub(crate) mod tests;
