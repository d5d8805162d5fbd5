//! Allows one supervisor for an SQLite file: an operating system lock on a file beside it, which ends with the
//! process.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Error, Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::StoreError;

/// Line of the lock file that says that the database has had tables. It stays when the supervisor ends.
const INSTALLED: &str =
    "The database has tables. If it is lost, restore its back-up, or remove this file to begin a new one.";
/// Most bytes of the lock file that are read.
const FILE_BYTES_MAX: u64 = 1000;

/// The lock, held as long as a clone of this lives, unless it is released.
#[derive(Debug, Clone)]
pub(super) struct FileLock {
    file: Arc<File>,
    path: PathBuf,
    /// The file says that the database has had tables.
    is_installed: bool,
}

impl FileLock {
    /// Locks a database for the supervisor `name`.
    ///
    /// # Errors
    /// Another supervisor holds the lock, or the lock file cannot be written.
    pub(super) fn take(database: &Path, name: &str) -> Result<Self, StoreError> {
        let path = beside(database);
        let failed = |source| StoreError::Lock { path: path.clone(), source };
        let mut file = open(&path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                // The holder may not have written its name yet, or the file may be unreadable.
                let _ = file.take(FILE_BYTES_MAX).read_to_string(&mut holder);
                let holder = holder.lines().next().unwrap_or_default();
                let holder = if holder.is_empty() { "another supervisor".to_owned() } else { holder.to_owned() };
                return Err(StoreError::InUse { path: database.to_owned(), holder });
            }
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        let mut before = String::new();
        let is_text = (&file).take(FILE_BYTES_MAX).read_to_string(&mut before).is_ok();
        if !is_text || !is_ours(&before) {
            return Err(failed(Error::other("no supervisor has written it: move it away")));
        }
        let is_installed = before.lines().any(|line| line == INSTALLED);
        file.set_len(0).and_then(|()| file.rewind()).map_err(failed)?;
        writeln!(file, "supervisor {name:?} (process {})", std::process::id()).map_err(failed)?;
        let lock = Self { file: Arc::new(file), path, is_installed };
        if is_installed {
            lock.write_installed()?;
        }
        Ok(lock)
    }

    /// The lock file, if it says that the database has had tables.
    pub(super) fn installed(&self) -> Option<&Path> {
        self.is_installed.then_some(&self.path)
    }

    /// Notes that the database has tables.
    pub(super) fn set_installed(&self) -> Result<(), StoreError> {
        if self.is_installed { Ok(()) } else { self.write_installed() }
    }

    fn write_installed(&self) -> Result<(), StoreError> {
        let mut file = &*self.file;
        writeln!(file, "{INSTALLED}")
            .and_then(|()| file.sync_all())
            .map_err(|source| StoreError::Lock { path: self.path.clone(), source })
    }

    /// Ends the lock for all clones, and for processes that have just been forked and still share the open file.
    pub(super) fn release(&self) {
        // A lock that cannot be released ends with the process.
        let _ = self.file.unlock();
    }
}

/// Opens the lock file, which is created if it is missing. A link of somebody else leads to no other file.
fn open(path: &Path) -> std::io::Result<File> {
    let is_link = || Err(Error::other("it is a symbolic link"));
    if path.is_symlink() {
        return is_link();
    }
    let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).mode(0o600).open(path)?;
    let (found, named) = (file.metadata()?, std::fs::symlink_metadata(path)?);
    if (found.dev(), found.ino()) != (named.dev(), named.ino()) {
        // It was made meanwhile. Nothing is written yet.
        return is_link();
    }
    if !found.is_file() || found.nlink() > 1 {
        return Err(Error::other("it is no regular file, or has another name, too (a hard link)"));
    }
    Ok(file)
}

/// Whether the content of a lock file is that of a supervisor; it is empty after a crash at its first start.
fn is_ours(text: &str) -> bool {
    text.is_empty() || text.starts_with("supervisor \"") || text.lines().any(|line| line == INSTALLED)
}

fn beside(database: &Path) -> PathBuf {
    let mut path = database.as_os_str().to_owned();
    path.push(".lock");
    PathBuf::from(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_lock_file_that_no_supervisor_has_written_stays_as_it_is() {
        let folder = std::env::temp_dir().join(format!("vibrissa-lock-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (database, victim) = (folder.join("v.sqlite3"), folder.join("victim"));
        let lock = beside(&database);
        std::fs::write(&victim, "keep me").unwrap();
        for plant in [
            (|victim, lock| std::os::unix::fs::symlink(victim, lock)) as fn(&Path, &Path) -> std::io::Result<()>,
            |victim, lock| std::fs::hard_link(victim, lock),
            |_, lock| std::fs::write(lock, "keep me"),
        ] {
            plant(&victim, &lock).unwrap();
            assert!(matches!(FileLock::take(&database, "s"), Err(StoreError::Lock { .. })));
            assert_eq!(std::fs::read(&lock).unwrap(), b"keep me");
            std::fs::remove_file(&lock).unwrap();
        }
        for _ in 0..2 {
            FileLock::take(&database, "s").unwrap().set_installed().unwrap();
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
