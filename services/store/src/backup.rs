//! Back-up of a SQLite database into a single file, while a supervisor uses the database.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::ErrorKind;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Connection};
use tokio::time::{Instant, interval_at};
use vibrissa_protocol::plain;

use super::cause::for_log;

/// Interval between reports of progress.
const PROGRESS: Duration = Duration::from_secs(2);

/// Mode of the copy: readable by its owner only, because it contains the hashes of tokens.
const MODE: u32 = 0o600;

/// Reason why no back-up was made.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    /// The database does not exist.
    #[error("there is no database {0}: name the file to copy with --database-url sqlite:FILE")]
    NoDatabase(PathBuf),
    /// The file of the back-up exists already.
    #[error("{0} exists already, and a back-up overwrites nothing: choose another name, or move that file away")]
    Exists(PathBuf),
    /// The file of the back-up cannot be created, synchronised or renamed.
    #[error("cannot write the back-up {path}: {}", plain::io(source))]
    File {
        /// File of the back-up.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The database cannot be read, or its copy cannot be written.
    #[error("cannot copy {from} into {to}: {}", for_log(source))]
    Copy {
        /// File of the database.
        from: PathBuf,
        /// File of the copy.
        to: PathBuf,
        /// Error of SQLite.
        source: sqlx::Error,
    },
    /// SQLite's integrity check has found errors in the copy.
    #[error("the copy of {from} is damaged and was removed: {findings}. The database itself may be damaged, too")]
    Damaged {
        /// File of the database.
        from: PathBuf,
        /// Errors that the integrity check has found.
        findings: String,
    },
}

/// Copies the present state of a database, checks the copy, and synchronises it to the disk. `progress` gets the
/// bytes written so far and the most that the copy can have. Returns the size of the copy in bytes.
///
/// # Errors
/// The database does not exist, a file with the copy's name exists, or the copy cannot be written. Then, or if the
/// future is dropped before its end, no file is left behind.
pub async fn copy(from: &Path, to: &Path, progress: impl FnMut(u64, u64)) -> Result<u64, BackupError> {
    if !from.exists() {
        return Err(BackupError::NoDatabase(from.to_owned()));
    }
    // The copy has another name until it is complete, so a file with the final name is always a back-up.
    let part = beside(to, ".part");
    for taken in [to, &part] {
        if taken.exists() {
            return Err(BackupError::Exists(taken.to_owned()));
        }
    }
    let in_file = |source| BackupError::File { path: to.to_owned(), source };
    OpenOptions::new().write(true).create_new(true).mode(MODE).open(&part).map_err(in_file)?;
    // Removes the incomplete copy even if this future is dropped.
    let part = Part(part);
    write(from, &part.0, progress).await?;
    keep(&part.0, to).map_err(in_file)
}

/// An incomplete copy, which is removed when this is dropped.
struct Part(PathBuf);

impl Drop for Part {
    fn drop(&mut self) {
        // After success the file was renamed and does not exist; after a failure the caller gets the original error.
        let _ = std::fs::remove_file(&self.0);
        let _ = std::fs::remove_file(beside(&self.0, "-journal"));
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
        // A single read transaction: writers are not blocked.
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

/// Findings of SQLite's integrity check; `ok` alone if there are no errors.
async fn check(path: &Path) -> sqlx::Result<Vec<String>> {
    let mut link = SqliteConnectOptions::new().filename(path).read_only(true).connect().await?;
    let findings = sqlx::query_scalar("PRAGMA integrity_check(10)").fetch_all(&mut link).await?;
    link.close().await?;
    Ok(findings)
}

/// Gives the file its final name, and synchronises it and its folder to the disk. Returns its size in bytes.
fn keep(part: &Path, to: &Path) -> std::io::Result<u64> {
    let file = File::open(part)?;
    file.sync_all()?;
    let bytes = file.metadata()?.len();
    name(part, to, std::fs::hard_link(part, to))?;
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match File::open(folder)?.sync_all() {
        // Some network shares synchronise no folders.
        Err(problem) if !matches!(problem.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Err(problem),
        _ => Ok(bytes),
    }
}

/// Gives the copy its name, also if the attempt to `link` it failed for want of hard links, as on FAT and many network shares.
/// Unlike a renaming alone, neither a link nor a new file ever replaces another file.
fn name(part: &Path, to: &Path, link: std::io::Result<()>) -> std::io::Result<()> {
    match link {
        Err(problem) if problem.kind() != ErrorKind::AlreadyExists => {
            File::create_new(to)?;
            // Otherwise an empty file would count as a back-up.
            std::fs::rename(part, to).inspect_err(|_| drop(std::fs::remove_file(to)))
        }
        linked => linked.and_then(|()| std::fs::remove_file(part)),
    }
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
        // Another program locks the database, so that the copy waits, and SQLite writes nothing more once it is dropped.
        let options = SqliteConnectOptions::new().filename(&from).create_if_missing(true);
        let mut locking = options.connect().await.unwrap();
        sqlx::raw_sql("CREATE TABLE one (value INTEGER); BEGIN EXCLUSIVE").execute(&mut locking).await.unwrap();
        let mut copying = Box::pin(copy(&from, &to, |_, _| {}));
        assert!(futures_util::poll!(&mut copying).is_pending());
        assert!(beside(&to, ".part").exists(), "it has begun");
        drop(copying);
        let names = std::fs::read_dir(&folder).unwrap().map(|one| one.unwrap().file_name().into_string().unwrap());
        let left: Vec<String> = names.filter(|name| name.starts_with("to")).collect();
        assert!(left.is_empty(), "{left:?}");
        locking.close().await.unwrap();
        let _ = std::fs::remove_dir_all(&folder);
    }

    /// The whole copy was made and then removed.
    #[test]
    fn regress_a_disk_without_hard_links_gets_the_copy() {
        let folder = std::env::temp_dir().join(format!("vibrissa-backup-name-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let [part, to, other] = ["part", "to", "other"].map(|name| folder.join(name));
        let no_links = || Err(ErrorKind::PermissionDenied.into());
        assert_eq!(name(&part, &to, no_links()).unwrap_err().kind(), ErrorKind::NotFound);
        assert!(!to.exists(), "an empty file is no back-up");
        std::fs::write(&part, b"rows").unwrap();
        std::fs::write(&other, b"other").unwrap();
        assert_eq!(name(&part, &other, no_links()).unwrap_err().kind(), ErrorKind::AlreadyExists);
        name(&part, &to, no_links()).unwrap();
        let read = |path| std::fs::read(path).unwrap();
        assert_eq!((read(&to), read(&other), part.exists()), (b"rows".to_vec(), b"other".to_vec(), false));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
