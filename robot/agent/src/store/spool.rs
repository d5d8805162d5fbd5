//! Contacts that have no room in memory: on disk, in order, for hours without a supervisor.
//!
//! A folder has segments of about 1 MiB, numbered in the order of writing. A line is a CRC-32 in hexadecimal, a space,
//! and the contacts as JSON. They have no number yet: each gets one of the boot that takes it back, and the record of
//! that in the file of the outbox has the position after it. So a restart takes none back twice. A segment is removed
//! after that file was synchronised. Beyond the bound the oldest segment goes.

use std::collections::VecDeque;
use std::fs::{DirBuilder, File};
use std::io::{BufRead, BufReader, ErrorKind, Read, Result, Seek, SeekFrom, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use super::private;

/// Size of a segment after which the next one begins, bytes.
const SEGMENT_BYTES: u64 = 1 << 20;
/// Longest line that is read: a message of the contract is shorter.
const LINE_MAX_BYTES: u64 = 512 * 1024;
/// Attempts to read a segment before it is left out: the process may have too many open files for a while.
pub const READ_ATTEMPTS: u32 = 6;

/// Number of a segment, and the bytes of it that are done with.
pub type Position = (u64, u64);

#[derive(Debug)]
struct Segment {
    id: u64,
    bytes: u64,
}

/// An open folder.
#[derive(Debug)]
pub struct Spool {
    folder: PathBuf,
    bytes_max: u64,
    /// The oldest first; the last one is written if there is a writer.
    segments: VecDeque<Segment>,
    next_id: u64,
    writer: Option<File>,
    is_dirty: bool,
    /// Bytes of the first segment that were taken back.
    offset: u64,
    reader: Option<BufReader<File>>,
    /// Failed attempts to read the first segment.
    failures: u32,
    /// Messages that cannot be read, since the last call of [`Spool::lost`].
    lost: u64,
    /// Segments that were taken back.
    done: Vec<u64>,
}

/// Makes a folder that is missing. A link of somebody else does not lead to another one.
fn make(folder: &Path) -> Result<()> {
    if std::fs::symlink_metadata(folder).is_ok_and(|found| found.is_dir()) {
        return Ok(());
    }
    DirBuilder::new().mode(0o700).create(folder)
}

fn is_full(problem: &std::io::Error) -> bool {
    matches!(problem.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
}

impl Spool {
    /// Opens a folder, which is created if it is missing, at the position up to which it was taken back.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn open(folder: &Path, from: Option<Position>, bytes_max: u64) -> Result<Self> {
        let found = match make(folder).and_then(|()| std::fs::read_dir(folder)) {
            // It is made with the first segment.
            Err(problem) if is_full(&problem) => None,
            found => Some(found?),
        };
        let from = from.unwrap_or_default();
        let mut segments = Vec::new();
        for entry in found.into_iter().flatten() {
            let entry = entry?;
            let name = entry.file_name();
            // Other files are not the agent's.
            let Some(id) =
                name.to_str().filter(|name| name.len() == 16).and_then(|name| u64::from_str_radix(name, 16).ok())
            else {
                continue;
            };
            segments.push(Segment { id, bytes: entry.metadata()?.len() });
        }
        segments.sort_unstable_by_key(|segment| segment.id);
        let next_id = segments.last().map_or(0, |last| last.id).max(from.0) + 1;
        let (done, rest): (Vec<Segment>, Vec<Segment>) = segments.into_iter().partition(|segment| segment.id < from.0);
        let offset = rest.first().filter(|first| first.id == from.0).map_or(0, |_| from.1);
        Ok(Self {
            folder: folder.to_owned(),
            bytes_max,
            segments: rest.into(),
            next_id,
            writer: None,
            is_dirty: false,
            offset,
            reader: None,
            failures: 0,
            lost: 0,
            done: done.into_iter().map(|segment| segment.id).collect(),
        })
    }

    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bytes() == 0
    }

    /// Bytes that wait.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.segments.iter().map(|segment| segment.bytes).sum::<u64>().saturating_sub(self.offset)
    }

    /// Appends contacts. They survive the end of the process at once, and a power cut after [`Spool::unsynced`].
    /// Returns how many messages were dropped for them.
    ///
    /// # Errors
    /// The operating system refuses, for instance because the disk is full.
    pub fn append(&mut self, contacts: &[u8]) -> Result<u64> {
        let mut line = format!("{:08x} ", crc32fast::hash(contacts)).into_bytes();
        line.extend_from_slice(contacts);
        line.push(b'\n');
        let dropped = self.make_room(line.len() as u64);
        let is_full = self.segments.back().is_none_or(|last| last.bytes >= SEGMENT_BYTES);
        if self.writer.is_none() || is_full {
            make(&self.folder)?;
            let file = private::create(&self.path(self.next_id))?;
            self.segments.push_back(Segment { id: self.next_id, bytes: 0 });
            (self.writer, self.next_id) = (Some(file), self.next_id + 1);
        }
        let (Some(file), Some(last)) = (&mut self.writer, self.segments.back_mut()) else { return Ok(dropped) };
        if let Err(problem) = file.write_all(&line) {
            // A part of a line would damage the next one.
            let _ = file.set_len(last.bytes);
            let _ = file.seek(SeekFrom::Start(last.bytes));
            return Err(problem);
        }
        last.bytes += line.len() as u64;
        self.is_dirty = true;
        Ok(dropped)
    }

    /// Removes the oldest segments until there is room; the number of their messages.
    fn make_room(&mut self, bytes: u64) -> u64 {
        let mut dropped = 0;
        while self.bytes() + bytes > self.bytes_max && self.segments.len() > 1 {
            let unread = self.segments.front().filter(|_| self.offset == 0).map(|first| first.id);
            while self.offset < self.segments.front().map_or(0, |first| first.bytes) {
                match self.line() {
                    // A damaged line was a message, too.
                    Ok(_) => dropped += 1,
                    Err(_) => {
                        dropped += 1;
                        break;
                    }
                }
            }
            self.leave();
            // A full disk needs the room at once. What cannot be removed now is removed later.
            let _ = self.remove(unread.as_slice());
        }
        dropped
    }

    /// The next contacts, and the position after them; `None` if nothing waits.
    ///
    /// # Errors
    /// The operating system refuses. The next call tries again. At the last of [`READ_ATTEMPTS`] the segment is left out,
    /// and counts as one lost message: how many it has is not known.
    pub fn take(&mut self) -> Result<Option<(Vec<u8>, Position)>> {
        while let Some(Segment { id, bytes }) = self.segments.front() {
            let id = *id;
            if self.offset >= *bytes {
                self.leave();
                continue;
            }
            match self.line() {
                Ok(Some(contacts)) => return Ok(Some((contacts, (id, self.offset)))),
                Ok(None) => self.lost += 1,
                Err(problem) => {
                    (self.reader, self.failures) = (None, self.failures + 1);
                    if self.failures >= READ_ATTEMPTS {
                        self.lost += 1;
                        self.leave();
                    }
                    return Err(problem);
                }
            }
        }
        Ok(None)
    }

    /// Messages that could not be read since the last call.
    pub fn lost(&mut self) -> u64 {
        std::mem::take(&mut self.lost)
    }

    /// The next line of the first segment; `None` if it is damaged, as after a power cut.
    fn line(&mut self) -> Result<Option<Vec<u8>>> {
        let Some(first) = self.segments.front() else { return Ok(None) };
        if self.reader.is_none() {
            let mut file = private::read_linked(&self.path(first.id))?;
            file.seek(SeekFrom::Start(self.offset))?;
            self.reader = Some(BufReader::new(file));
        }
        let Some(reader) = &mut self.reader else { return Ok(None) };
        let mut line = Vec::new();
        let read = reader.by_ref().take(LINE_MAX_BYTES).read_until(b'\n', &mut line)?;
        // Less than was written: the rest is lost.
        self.offset = if read == 0 { first.bytes } else { self.offset + read as u64 };
        Ok(checked(&line).map(<[u8]>::to_vec))
    }

    /// Leaves the first segment, which is removed later.
    fn leave(&mut self) {
        if let Some(first) = self.segments.pop_front() {
            self.done.push(first.id);
        }
        (self.offset, self.reader, self.failures) = (0, None, 0);
        if self.segments.is_empty() {
            self.writer = None;
        }
    }

    /// The file to synchronise with the disk, if something was written since the last call.
    pub fn unsynced(&mut self) -> Option<Result<File>> {
        let is_dirty = std::mem::take(&mut self.is_dirty);
        self.writer.as_ref().filter(|_| is_dirty).map(File::try_clone)
    }

    /// The segments that were taken back. [`Spool::remove`] them once the file of the outbox is on the disk.
    #[must_use]
    pub fn done(&self) -> Vec<u64> {
        self.done.clone()
    }

    /// Removes segments that were taken back. Those that remain are still among [`Spool::done`].
    ///
    /// # Errors
    /// The operating system refuses for one of them.
    pub fn remove(&mut self, done: &[u64]) -> Result<()> {
        let mut removed = Ok(());
        for &id in done {
            match std::fs::remove_file(self.path(id)) {
                Err(problem) if problem.kind() != ErrorKind::NotFound => removed = Err(problem),
                Ok(()) | Err(_) => self.done.retain(|&other| other != id),
            }
        }
        removed
    }

    fn path(&self, id: u64) -> PathBuf {
        self.folder.join(format!("{id:016x}"))
    }
}

fn checked(line: &[u8]) -> Option<&[u8]> {
    let (sum, rest) = line.split_at_checked(9)?;
    let contacts = rest.strip_suffix(b"\n")?;
    let sum = u32::from_str_radix(std::str::from_utf8(sum).ok()?.strip_suffix(' ')?, 16).ok()?;
    (crc32fast::hash(contacts) == sum).then_some(contacts)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("vibrissa-spool-{name}-{}", std::process::id()));
            let _ = std::fs::remove_dir_all(&path);
            Self(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    fn message(number: u64) -> Vec<u8> {
        format!("{{\"number\":{number},\"rest\":\"{}\"}}", "x".repeat(10_000)).into_bytes()
    }

    fn all(spool: &mut Spool) -> Vec<Vec<u8>> {
        std::iter::from_fn(|| spool.take().unwrap()).map(|(contacts, _)| contacts).collect()
    }

    fn expected(numbers: std::ops::Range<u64>) -> Vec<Vec<u8>> {
        numbers.map(message).collect()
    }

    #[test]
    fn contacts_come_back_in_order_over_restarts_and_none_twice() {
        let folder = Folder::new("order");
        let mut spool = Spool::open(&folder.0, None, 1 << 30).unwrap();
        (0..500).for_each(|number| assert_eq!(spool.append(&message(number)).unwrap(), 0));
        let mut position = None;
        for number in 0..250 {
            let (contacts, at) = spool.take().unwrap().unwrap();
            assert_eq!(contacts, message(number));
            position = Some(at);
        }
        // Some were taken back after the position that the outbox knows of.
        let mut again = Spool::open(&folder.0, position, 1 << 30).unwrap();
        again.remove(&again.done()).unwrap();
        again.append(&message(500)).unwrap();
        assert!(all(&mut again) == expected(250..501) && again.is_empty());
        again.append(&message(501)).unwrap();
        assert!(all(&mut again) == expected(501..502), "it goes on after it was empty");
        again.remove(&again.done()).unwrap();
        assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 0, "nothing is left on the disk");
    }

    #[test]
    fn beyond_its_bound_the_oldest_go_and_are_counted() {
        let folder = Folder::new("bound");
        let mut spool = Spool::open(&folder.0, None, 3 << 20).unwrap();
        let dropped: u64 = (0..1000).map(|number| spool.append(&message(number)).unwrap()).sum();
        assert!(spool.done().is_empty(), "their files are gone, too");
        assert!(spool.bytes() <= 3 << 20 && spool.bytes() > 2 << 20, "{}", spool.bytes());
        assert!(all(&mut spool) == expected(dropped..1000));
    }

    #[test]
    fn regress_a_damaged_message_without_room_is_counted() {
        let folder = Folder::new("damaged");
        let mut spool = Spool::open(&folder.0, None, 2 << 20).unwrap();
        (0..110).for_each(|number| assert_eq!(spool.append(&message(number)).unwrap(), 0));
        let path = folder.0.join(format!("{:016x}", 1));
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[15_000] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let dropped: u64 = (110..220).map(|number| spool.append(&message(number)).unwrap()).sum();
        assert!(dropped > 100 && all(&mut spool) == expected(dropped..220), "{dropped}");
    }

    #[test]
    fn a_power_cut_costs_only_the_lines_that_it_tore_and_they_are_counted() {
        let folder = Folder::new("torn");
        let mut spool = Spool::open(&folder.0, None, 1 << 30).unwrap();
        (0..3).for_each(|number| assert_eq!(spool.append(&message(number)).unwrap(), 0));
        drop(spool);
        let path = folder.0.join(format!("{:016x}", 1));
        let whole = std::fs::read(&path).unwrap();
        for (cut, damaged) in [(whole.len() - 1, None), (whole.len() - 5_000, None), (whole.len(), Some(15_000))] {
            let mut bytes = whole[..cut].to_vec();
            damaged.into_iter().for_each(|at: usize| bytes[at] ^= 1);
            std::fs::write(&path, bytes).unwrap();
            let mut spool = Spool::open(&folder.0, None, 1 << 30).unwrap();
            spool.append(&message(9)).unwrap();
            let lost = if damaged.is_some() { 1 } else { 2 };
            let left: Vec<Vec<u8>> = [0, 1, 2, 9].into_iter().filter(|&number| number != lost).map(message).collect();
            assert!(all(&mut spool) == left, "{cut} {damaged:?}");
            assert_eq!(spool.lost(), 1, "{cut} {damaged:?}");
            std::fs::remove_file(folder.0.join(format!("{:016x}", 2))).unwrap();
        }
    }
}
