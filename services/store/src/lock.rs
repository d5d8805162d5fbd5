//! Allows one supervisor for an SQLite file: an operating system lock on a file beside it, which ends with the
//! process.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::StoreError;

/// The lock, held as long as a clone of this lives, unless it is released.
#[derive(Debug, Clone)]
pub(super) struct FileLock {
    file: Arc<File>,
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
                let _ = file.take(1000).read_to_string(&mut holder);
                let holder = if holder.is_empty() { "another supervisor".to_owned() } else { holder };
                return Err(StoreError::InUse { path: database.to_owned(), holder });
            }
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        file.set_len(0).and_then(|()| file.rewind()).map_err(failed)?;
        write!(file, "supervisor {name:?} (process {})", std::process::id()).map_err(failed)?;
        Ok(Self { file: Arc::new(file) })
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
