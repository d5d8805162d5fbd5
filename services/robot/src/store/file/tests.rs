//! Files that are whole, torn, damaged, full, or of others.

use std::fs;

use vibrissa_protocol::{BootId, Name};

use super::*;
use crate::store::Payload;

/// A folder that is removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("vibrissa-robot-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir(&path).unwrap();
        Self(path)
    }

    fn file(&self) -> PathBuf {
        self.0.join("outbox")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn boot() -> BootId {
    BootId::new("b1").unwrap()
}

fn contacts(seq: u64) -> Record {
    let text = format!("{{\"boot_id\":\"b1\",\"seq\":{seq},\"contacts\":[]}}");
    Record::Contacts { boot_id: boot(), seq, payload: Payload::new(text.as_bytes()).unwrap() }
}

fn some_records() -> Vec<Record> {
    vec![
        Record::Boot { boot_id: boot(), births: 1, factsheets: 1 },
        Record::Seen { array: Name::new("left").unwrap(), whisker: 3, epoch: 7, version: 9 },
        contacts(0),
        contacts(1),
        contacts(2),
        contacts(3),
        Record::Receipt { boot_id: boot(), next: 1, held: vec![(2, 2)] },
    ]
}

/// A file with these records, closed as by a kill.
fn written(folder: &Folder, records: &[Record]) {
    let (mut file, _, _) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
    file.replace([]).unwrap();
    file.append(records).unwrap();
}

fn numbers(stored: &Stored) -> Vec<u64> {
    stored.boots.iter().flat_map(|boot| boot.messages.keys().copied()).collect()
}

#[test]
fn what_is_appended_is_read_after_a_kill() {
    let folder = Folder::new("kill");
    written(&folder, &some_records());
    let (_file, stored, damaged) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
    assert_eq!((numbers(&stored), damaged), (vec![1, 3], 0));
    assert_eq!((stored.boots[0].births, stored.boots[0].is_known), (1, true));
    assert_eq!(stored.seen[&(Name::new("left").unwrap(), 3)], (7, 9));
    assert!(stored.boots[0].messages[&3].bytes().starts_with(b"{\"boot_id\":\"b1\",\"seq\":3"));
}

#[test]
fn a_file_that_was_torn_anywhere_gives_the_records_before() {
    let folder = Folder::new("torn");
    written(&folder, &some_records());
    let whole = fs::read(folder.file()).unwrap();
    let mut before = 0;
    // Without the last line feed the receipt is whole.
    for length in 0..whole.len() - 1 {
        fs::write(folder.file(), &whole[..length]).unwrap();
        let (mut file, stored, damaged) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
        assert_eq!(damaged, 0, "at {length}");
        let messages = numbers(&stored).len();
        assert!(messages >= before, "at {length}");
        before = messages;
        // It goes on with a new file.
        file.replace([contacts(8)]).unwrap();
        file.append(&[contacts(9)]).unwrap();
        drop(file);
        assert_eq!(numbers(&StoreFile::open(&folder.file(), 1 << 20).unwrap().1), [8, 9], "at {length}");
    }
    assert_eq!(before, 4, "the receipt is torn");
}

#[test]
fn a_damaged_record_is_left_out_and_counted() {
    let folder = Folder::new("damaged");
    written(&folder, &some_records());
    let whole = fs::read(folder.file()).unwrap();
    let line = whole.windows(7).position(|part| part == b"\"seq\":3").unwrap();
    let mut broken = whole.clone();
    broken[line + 6] = b'4';
    fs::write(folder.file(), &broken).unwrap();
    let (_file, stored, damaged) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
    assert_eq!((numbers(&stored), damaged), (vec![1], 1));
}

#[test]
fn a_full_file_is_replaced_by_the_present_state() {
    let folder = Folder::new("full");
    let (mut file, _, _) = StoreFile::open(&folder.file(), 10_000).unwrap();
    file.replace([]).unwrap();
    let mut largest = 0;
    for seq in 0..2000 {
        file.append(&[contacts(seq)]).unwrap();
        if file.is_full() {
            file.replace([contacts(seq)]).unwrap();
        }
        largest = largest.max(fs::metadata(folder.file()).unwrap().len());
    }
    assert!((9_000..10_200).contains(&largest), "{largest}");
    drop(file);
    assert_eq!(numbers(&StoreFile::open(&folder.file(), 10_000).unwrap().1).last(), Some(&1999));
}

#[test]
fn a_file_of_another_version_or_in_use_is_refused_and_stays() {
    let folder = Folder::new("other");
    fs::write(folder.file(), "vibrissa-robot outbox 2\nx\n").unwrap();
    let refused = StoreFile::open(&folder.file(), 1).unwrap_err().to_string();
    assert!(refused.contains("no outbox of this version"), "{refused}");
    assert_eq!(fs::read(folder.file()).unwrap(), b"vibrissa-robot outbox 2\nx\n");
    fs::remove_file(folder.file()).unwrap();
    let _first = StoreFile::open(&folder.file(), 1).unwrap();
    let refused = StoreFile::open(&folder.file(), 1).unwrap_err().to_string();
    assert!(refused.contains("in use by another agent"), "{refused}");
}
