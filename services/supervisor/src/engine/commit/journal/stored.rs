//! Rows of the journal as the database has them: entries of all versions that this program reads.

use borsh::{BorshDeserialize, BorshSerialize};

use vibrissa_store::JournalReading;

use super::{Entry, NO_ROBOT, VERSION, VERSION_OF_LOG, version_2, version_4};

/// A row of the journal, as the database has it.
#[derive(Debug)]
pub(crate) struct StoredEntries {
    /// Number of its transaction.
    pub(crate) number: i64,
    bytes: Vec<u8>,
    /// The partition of references that do not name one.
    partition: u32,
}

impl StoredEntries {
    /// The row of the database. References without a partition are to the one that the row names.
    pub(crate) fn new(row: JournalReading) -> Self {
        Self { number: row.number, bytes: row.entries, partition: u32::try_from(row.log_partition).unwrap_or_default() }
    }

    /// The entries.
    pub(crate) fn entries(&self) -> impl Iterator<Item = std::io::Result<Entry>> {
        read_of(&self.bytes, self.partition)
    }

    /// The row with the entries of one robot, and those about all robots, in order.
    pub(crate) fn of_robot(&self, robot_id: i64) -> Self {
        let mut bytes = Vec::new();
        for entry in self.entries().map_while(Result::ok) {
            if entry.robot_id == robot_id || entry.robot_id == NO_ROBOT {
                bytes.extend((-VERSION_OF_LOG).to_le_bytes());
                // Writing to memory cannot fail.
                let _ = entry.serialize(&mut bytes);
            }
        }
        Self { number: self.number, bytes, partition: self.partition }
    }
}

/// The bytes of entries that are not read yet.
struct Reader<'b> {
    bytes: &'b [u8],
    /// The partition of references that do not name one.
    partition: u32,
    /// Version of the next entry.
    version: i64,
}

impl<'b> Reader<'b> {
    fn new(bytes: &'b [u8], partition: u32) -> Self {
        Self { bytes, partition, version: 1 }
    }

    /// The next entry, or `None` at the end.
    ///
    /// # Errors
    /// The entry is damaged, or of a version that this program cannot read.
    fn next(&mut self) -> std::io::Result<Option<Entry>> {
        while let Some((first, rest)) = self.bytes.split_first_chunk() {
            let version = i64::from_le_bytes(*first).saturating_neg();
            if version <= 0 {
                break;
            }
            (self.version, self.bytes) = (version, rest);
        }
        if self.bytes.is_empty() {
            return Ok(None);
        }
        match self.version {
            VERSION | VERSION_OF_LOG => Entry::deserialize(&mut self.bytes).map(Some),
            4 => version_4::Entry::deserialize(&mut self.bytes).map(|entry| Some(entry.of_partition(self.partition))),
            1 | 2 => version_2::Entry::deserialize(&mut self.bytes).map(|entry| Some(entry.into())),
            version => {
                let problem =
                    format!("entries of version {version}, and this program reads versions 1 to {VERSION_OF_LOG}");
                Err(std::io::Error::new(std::io::ErrorKind::InvalidData, problem))
            }
        }
    }
}

/// Reads entries that this program has written.
pub(super) fn read(bytes: &[u8]) -> impl Iterator<Item = std::io::Result<Entry>> {
    read_of(bytes, 0)
}

/// Reads entries. Records of references that do not name a partition are in this one.
pub(super) fn read_of(bytes: &[u8], partition: u32) -> impl Iterator<Item = std::io::Result<Entry>> {
    let mut reader = Reader::new(bytes, partition);
    std::iter::from_fn(move || {
        let entry = reader.next();
        if entry.is_err() {
            reader.bytes = &[];
        }
        entry.transpose()
    })
}
