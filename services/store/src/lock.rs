//! Allows one supervisor for an SQLite file: an operating system lock on a file beside it, which ends with the
//! process.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::os::unix::fs::OpenOptionsExt;
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
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(&path)
            .map_err(failed)?;
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
        // A file that is not text was not written by a supervisor.
        let _ = (&file).take(FILE_BYTES_MAX).read_to_string(&mut before);
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

fn beside(database: &Path) -> PathBuf {
    let mut path = database.as_os_str().to_owned();
    path.push(".lock");
    PathBuf::from(path)
}
