//! A file of records: one a line, each with a checksum.
//!
//! The first line states the version. A line is a CRC-32 in hexadecimal, a space, and the record as JSON. A torn last line,
//! as after a power cut, is cut off; a damaged line elsewhere is left out and counted, and the damaged file is kept beside. The file grows by each record, and is
//! replaced by one with only the present state when it exceeds its bound.
//!
//! Only the agent's user can read its files ([`private`]), and no link of somebody else leads the agent to another file.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use vibrissa_protocol::plain;

use super::{Record, Stored, private};

/// First line of a file.
const HEAD: &str = "vibrissa-robot outbox 1";
const VERSION: u64 = 1;
/// Longest line that is read: a message of the contract is shorter.
const LINE_MAX_BYTES: u64 = 512 * 1024;
/// Most copies of damaged files. The agent makes no further ones.
const COPIES_MAX: u32 = 10;

/// Why a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The operating system refuses.
    #[error("outbox.file: cannot {what} {path}: {}", plain::io(problem))]
    Refused {
        /// The attempt.
        what: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// The error of the operating system.
        problem: std::io::Error,
    },
    /// The file has another format.
    #[error("outbox.file: {0} is no outbox of this version: use the program that wrote it, or move the file away")]
    OtherVersion(PathBuf),
    /// Another agent has the file.
    #[error("outbox.file: {0} is in use by another agent")]
    InUse(PathBuf),
}

impl StoreError {
    /// Explains an error of the operating system at an attempt.
    pub(crate) fn refused(what: &'static str, path: &Path) -> impl Fn(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |problem| Self::Refused { what, path: path.clone(), problem }
    }
}

/// Unreadable parts of a file.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Damage {
    /// Damaged lines, which are left out.
    pub lines: u64,
    /// Bytes of a torn line at the end.
    pub torn_bytes: u64,
    /// Copy of the damaged file; none if only its end was torn, or if the copy could not be written.
    pub aside: Option<PathBuf>,
}

/// An open file.
#[derive(Debug)]
pub struct StoreFile {
    path: PathBuf,
    file: File,
    /// Held until the end: two agents would tear each other's lines.
    _lock: File,
    bytes: u64,
    bytes_max: u64,
}

fn line_of(record: &Record) -> Vec<u8> {
    let json = vibrissa_protocol::encode(record);
    let mut line = format!("{:08x} ", crc32fast::hash(&json)).into_bytes();
    line.extend_from_slice(&json);
    line.push(b'\n');
    line
}

fn record_of(line: &[u8]) -> Option<Record> {
    let (sum, json) = line.split_at_checked(9)?;
    let sum = u32::from_str_radix(std::str::from_utf8(sum).ok()?.strip_suffix(' ')?, 16).ok()?;
    if crc32fast::hash(json) == sum { serde_json::from_slice(json).ok() } else { None }
}

impl StoreFile {
    /// Opens a file, which is created if it is missing, and reads its state. `bytes_max` is the size beyond which
    /// [`StoreFile::is_full`] asks for a replacement. A file with damaged lines is copied to `PATH.damaged`, or to
    /// `PATH.damaged-2` and so on beside earlier copies.
    ///
    /// # Errors
    /// The file cannot be read or written, has another format, or is in use.
    pub fn open(path: &Path, bytes_max: u64) -> Result<(Self, Stored, Damage), StoreError> {
        let refused = |what| move |problem| StoreError::Refused { what, path: path.to_owned(), problem };
        let lock = Self::lock(path)?;
        let (stored, mut damage) = match private::read(path) {
            Ok(file) => {
                let found = read(path, &file)?;
                private::close_to_others(&file).map_err(refused("close"))?;
                found
            }
            Err(problem) if problem.kind() == std::io::ErrorKind::NotFound => Default::default(),
            Err(problem) => return Err(refused("read")(problem)),
        };
        if damage.lines > 0 {
            // The agent starts with the other lines, even if the disk is full.
            damage.aside = set_aside(path).ok();
        }
        let file = private::append(path).map_err(refused("open"))?;
        let bytes = file.metadata().map_err(refused("open"))?.len();
        Ok((Self { path: path.to_owned(), file, _lock: lock, bytes, bytes_max }, stored, damage))
    }

    /// Keeps agents from a file until the lock is dropped.
    ///
    /// # Errors
    /// The file is in use, or its lock cannot be written.
    pub fn lock(path: &Path) -> Result<File, StoreError> {
        let refused = StoreError::refused("lock", path);
        let lock = private::append(&beside(path, "lock")).map_err(&refused)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => return Err(StoreError::InUse(path.to_owned())),
            Err(std::fs::TryLockError::Error(problem)) => return Err(refused(problem)),
        }
        // A lock file is empty. Nothing is written to another one, and its mode stays.
        if lock.metadata().map_err(&refused)?.len() == 0 {
            private::close_to_others(&lock).map_err(&refused)?;
            private::give_to_owner(&lock, path).map_err(&refused)?;
        }
        Ok(lock)
    }

    /// Checks that a file, if it is there, is an outbox of this version, and changes nothing.
    ///
    /// # Errors
    /// Those of [`StoreFile::open`].
    pub fn check(path: &Path) -> Result<(), StoreError> {
        match private::read(path) {
            Ok(file) => read(path, &file).map(drop),
            Err(problem) if problem.kind() == std::io::ErrorKind::NotFound => Ok(()),
            Err(problem) => Err(StoreError::refused("read", path)(problem)),
        }
    }

    /// Appends records. They survive the end of the process at once, and a power cut after [`StoreFile::synced`].
    ///
    /// # Errors
    /// The file cannot be written, for instance because the disk is full.
    pub fn append(&mut self, records: &[Record]) -> Result<(), StoreError> {
        let bytes: Vec<u8> = records.iter().flat_map(line_of).collect();
        let refused = |problem| StoreError::Refused { what: "write", path: self.path.clone(), problem };
        if let Err(problem) = self.file.write_all(&bytes) {
            // A part of a line would damage the next one.
            let _ = self.file.set_len(self.bytes);
            return Err(refused(problem));
        }
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// Whether the file exceeds its bound.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.bytes > self.bytes_max
    }

    /// Replaces the content, atomically and durably.
    ///
    /// # Errors
    /// The new file cannot be written; the old one stays in use.
    pub fn replace(&mut self, records: impl IntoIterator<Item = Record>) -> Result<(), StoreError> {
        let path = self.path.clone();
        let refused = |problem| StoreError::Refused { what: "replace", path: path.clone(), problem };
        let new = beside(&self.path, "new");
        let mut file = private::anew(&new, is_head_of_ours).map_err(refused)?;
        let mut bytes = format!("{HEAD}\n").into_bytes();
        let mut written = 0;
        for record in records {
            bytes.extend(line_of(&record));
            if bytes.len() > 65_536 {
                file.write_all(&bytes).map_err(refused)?;
                written += bytes.len() as u64;
                bytes.clear();
            }
        }
        file.write_all(&bytes).map_err(refused)?;
        written += bytes.len() as u64;
        file.sync_all().map_err(refused)?;
        std::fs::rename(&new, &self.path).map_err(refused)?;
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        File::open(folder).and_then(|folder| folder.sync_all()).map_err(refused)?;
        self.file = private::append(&self.path).map_err(refused)?;
        self.bytes = written;
        // If the state itself is large, the next replacement waits until as much again was written.
        self.bytes_max = self.bytes_max.max(2 * written);
        Ok(())
    }

    /// A handle with which another thread can wait until all appended records are on the disk: `sync_data`.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn synced(&self) -> std::io::Result<File> {
        self.file.try_clone()
    }
}

/// Copies a damaged file of ours to a name that is free. No earlier copy is replaced.
fn set_aside(path: &Path) -> std::io::Result<PathBuf> {
    let name = |number| if number == 1 { "damaged".to_owned() } else { format!("damaged-{number}") };
    for number in 1..=COPIES_MAX {
        let aside = beside(path, &name(number));
        match private::create(&aside) {
            Ok(mut to) => {
                std::io::copy(&mut private::read(path)?, &mut to)?;
                return Ok(aside);
            }
            Err(problem) if problem.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(problem) => return Err(problem),
        }
    }
    Err(std::io::Error::from(std::io::ErrorKind::AlreadyExists))
}

/// Whether a file begins as ours, whole or torn: what a power cut did not write is missing, or is read as zeros.
fn is_head_of_ours(bytes: &[u8]) -> bool {
    let head = bytes.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let written = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    version_of(head).is_some() || HEAD.as_bytes().starts_with(&bytes[..written])
}

fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}

/// The number of a whole first line, if it has one.
fn version_of(head: &[u8]) -> Option<u64> {
    let prefix = HEAD.trim_end_matches(|last: char| last.is_ascii_digit());
    std::str::from_utf8(head).ok()?.strip_prefix(prefix)?.parse().ok()
}

/// Whether a first line is ours, torn or damaged: what a power cut did not write is often read as zeros.
fn was_ours(head: &[u8]) -> bool {
    let same = head.iter().zip(HEAD.as_bytes()).filter(|(one, other)| one == other).count();
    head.contains(&0) || 2 * same >= HEAD.len() || (!head.is_empty() && HEAD.as_bytes().starts_with(head))
}

fn read(path: &Path, file: &File) -> Result<(Stored, Damage), StoreError> {
    let other_version = || StoreError::OtherVersion(path.to_owned());
    let (mut stored, mut damage) = (Stored::default(), Damage::default());
    let mut reader = BufReader::new(file);
    let (mut line, mut is_first) = (Vec::new(), true);
    // A file of somebody else has no record. It must not be replaced.
    let mut is_foreign = false;
    loop {
        line.clear();
        let read = reader.by_ref().take(LINE_MAX_BYTES).read_until(b'\n', &mut line);
        read.map_err(|problem| StoreError::Refused { what: "read", path: path.to_owned(), problem })?;
        if line.is_empty() {
            return if is_foreign { Err(other_version()) } else { Ok((stored, damage)) };
        }
        let is_whole = line.pop_if(|last| *last == b'\n').is_some();
        let is_head = std::mem::take(&mut is_first);
        if is_head && is_whole && line == HEAD.as_bytes() {
            continue;
        }
        if is_head && is_whole && version_of(&line).is_some_and(|version| version != VERSION) {
            return Err(other_version());
        }
        if let Some(record) = record_of(&line) {
            is_foreign = false;
            stored.take(record);
        } else if is_whole {
            damage.lines += 1;
            is_foreign |= is_head && !was_ours(&line);
        } else {
            damage.torn_bytes += line.len() as u64;
            is_foreign |= is_head && !was_ours(&line);
        }
    }
}

#[cfg(test)]
mod tests;
