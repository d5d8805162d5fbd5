//! A copy of a SQLite database, complete by itself, while a supervisor works with it.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Connection};
use tokio::time::{Instant, interval_at};

/// How often progress is told.
const PROGRESS: Duration = Duration::from_secs(2);

/// For its owner only: it holds the hashes of tokens.
const MODE: u32 = 0o600;

/// Why there is no back-up.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    /// There is nothing to copy.
    #[error("there is no database {0}: name the one to copy with --database-url sqlite:FILE")]
    NoDatabase(PathBuf),
    /// Something is there already.
    #[error("{0} is there already, and a back-up overwrites nothing: choose another name, or move it away")]
    Exists(PathBuf),
    /// A file cannot be made or kept.
    #[error("cannot write the back-up {path}: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The database cannot be read, or its copy not be written.
    #[error("cannot copy {from} into {to}: {source}")]
    Copy {
        /// The database.
        from: PathBuf,
        /// Its copy.
        to: PathBuf,
        /// Why.
        source: sqlx::Error,
    },
    /// The copy is no good.
    #[error("the copy of {from} is damaged, and was removed: {findings}. The database itself may be damaged, too")]
    Damaged {
        /// The database.
        from: PathBuf,
        /// What SQLite's check says.
        findings: String,
    },
}

/// Copies a database as it is at this moment, checks the copy, and makes it last: when this returns, it is on the disk.
/// `progress` is told bytes written, and how many it can be at the most. Gives the bytes of the copy.
///
/// # Errors
/// There is no such database, the copy's name is taken, or it cannot be written; then nothing is left behind. Nor is it if
/// the copy is not waited for to the end.
pub async fn copy(from: &Path, to: &Path, progress: impl FnMut(u64, u64)) -> Result<u64, BackupError> {
    if !from.exists() {
        return Err(BackupError::NoDatabase(from.to_owned()));
    }
    // Under another name until it is whole, so that what has the name is a back-up.
    let part = beside(to, ".part");
    for taken in [to, &part] {
        if taken.exists() {
            return Err(BackupError::Exists(taken.to_owned()));
        }
    }
    let in_file = |source| BackupError::File { path: to.to_owned(), source };
    OpenOptions::new().write(true).create_new(true).mode(MODE).open(&part).map_err(in_file)?;
    // Also if it is not waited for to the end.
    let part = Part(part);
    write(from, &part.0, progress).await?;
    keep(&part.0, to).map_err(in_file)
}

/// A copy that is not whole yet: of no use to anybody.
struct Part(PathBuf);

impl Drop for Part {
    fn drop(&mut self) {
        // There is none if all went well; otherwise what went wrong is told.
        let _ = std::fs::remove_file(&self.0);
    }
}

async fn write(from: &Path, part: &Path, mut progress: impl FnMut(u64, u64)) -> Result<(), BackupError> {
    let failed = |source| BackupError::Copy { from: from.to_owned(), to: part.to_owned(), source };
    let mut link = open(from).await.map_err(failed)?;
    let size: i64 = sqlx::query_scalar("SELECT page_count * page_size FROM pragma_page_count(), pragma_page_size()")
        .fetch_one(&mut link)
        .await
        .map_err(failed)?;
    {
        // One read transaction: writers go on beside it.
        let copying = sqlx::query("VACUUM INTO $1").bind(part.to_string_lossy().into_owned()).execute(&mut link);
        tokio::pin!(copying);
        let mut ticks = interval_at(Instant::now() + PROGRESS, PROGRESS);
        loop {
            tokio::select! {
                copied = &mut copying => break copied.map(drop),
                _ = ticks.tick() => progress(std::fs::metadata(part).map_or(0, |file| file.len()), size.unsigned_abs()),
            }
        }
    }
    .map_err(failed)?;
    link.close().await.map_err(failed)?;
    let findings = check(part).await.map_err(failed)?;
    if findings == ["ok"] {
        return Ok(());
    }
    Err(BackupError::Damaged { from: from.to_owned(), findings: findings.join("; ") })
}

async fn open(path: &Path) -> sqlx::Result<SqliteConnection> {
    SqliteConnectOptions::new().filename(path).create_if_missing(false).connect().await
}

/// What SQLite finds wrong with a file; `ok` if it is nothing.
async fn check(path: &Path) -> sqlx::Result<Vec<String>> {
    let mut link = SqliteConnectOptions::new().filename(path).read_only(true).connect().await?;
    let findings = sqlx::query_scalar("PRAGMA integrity_check(10)").fetch_all(&mut link).await?;
    link.close().await?;
    Ok(findings)
}

/// Makes the file last under its name.
fn keep(part: &Path, to: &Path) -> std::io::Result<u64> {
    let file = File::open(part)?;
    file.sync_all()?;
    let bytes = file.metadata()?.len();
    // Fails if somebody has taken the name meanwhile.
    std::fs::hard_link(part, to)?;
    std::fs::remove_file(part)?;
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()?;
    Ok(bytes)
}

fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(ending);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_copy_that_is_not_waited_for_leaves_nothing() {
        let folder = std::env::temp_dir().join(format!("vibrissa-backup-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (from, to) = (folder.join("from"), folder.join("to"));
        std::fs::write(&from, b"").unwrap();
        let mut copying = Box::pin(copy(&from, &to, |_, _| {}));
        assert!(futures_util::poll!(&mut copying).is_pending());
        assert!(beside(&to, ".part").exists(), "it has begun");
        drop(copying);
        let left: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|one| one.unwrap().file_name()).collect();
        assert_eq!(left, ["from"]);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
