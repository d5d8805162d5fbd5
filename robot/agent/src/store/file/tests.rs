//! Files that are whole, torn, damaged, full, or of others.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

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
    Record::Contacts { boot_id: boot(), seq, payload: Payload::new(text.as_bytes()).unwrap(), spooled: None }
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
    let (_file, stored, damage) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
    assert_eq!((numbers(&stored), damage), (vec![1, 3], Damage::default()));
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
        let (mut file, stored, damage) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
        assert_eq!((damage.lines, damage.aside), (0, None), "at {length}");
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
    let (mut file, stored, damage) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
    assert_eq!((numbers(&stored), damage.lines), (vec![1], 1));
    // The file goes on without the line; the damaged one is kept.
    file.replace([]).unwrap();
    assert_eq!(fs::read(damage.aside.unwrap()).unwrap(), broken);
}

/// The state after these records.
fn state(records: impl IntoIterator<Item = Record>) -> Stored {
    let mut stored = Stored::default();
    records.into_iter().for_each(|record| stored.take(record));
    stored
}

#[test]
fn a_changed_byte_costs_no_more_than_its_line() {
    let folder = Folder::new("flipped");
    let records = some_records();
    written(&folder, &records);
    let whole = fs::read(folder.file()).unwrap();
    for at in 0..whole.len() {
        // The head is line 0, and record `line` - 1 is on the line.
        let line = whole[..at].iter().filter(|&&byte| byte == b'\n').count();
        for to in [whole[at] ^ 1, whole[at] ^ 0x80, 0, b'\n'] {
            let mut broken = whole.clone();
            broken[at] = to;
            fs::write(folder.file(), &broken).unwrap();
            let opened = StoreFile::open(&folder.file(), 1 << 20);
            if broken.starts_with(b"vibrissa-robot outbox 0\n") {
                let refused = opened.unwrap_err().to_string();
                assert!(refused.contains("no outbox of this version"), "{refused}");
                continue;
            }
            let (_file, stored, damage) = opened.unwrap();
            // Without its line feed, a line takes the next one with it.
            let is_joined = whole[at] == b'\n' && to != b'\n';
            let kept = records.iter().enumerate().filter(|(number, _)| {
                let its_line = number + 1;
                to == whole[at] || its_line != line && !(is_joined && its_line == line + 1)
            });
            assert_eq!(stored, state(kept.map(|(_, record)| record.clone())), "byte {at} is {to}");
            // Only the last line may be taken for a torn one.
            let is_torn = is_joined && at + 1 == whole.len();
            assert_eq!(damage.lines > 0, to != whole[at] && !is_torn, "byte {at} is {to}: {damage:?}");
        }
    }
}

#[test]
fn an_end_that_a_power_cut_left_as_zeros_costs_only_itself() {
    let folder = Folder::new("zeros");
    let records = some_records();
    written(&folder, &records);
    let whole = fs::read(folder.file()).unwrap();
    for length in 0..whole.len() {
        for fill in [0, 0xff, b'\n'] {
            let mut cut = whole[..length].to_vec();
            cut.resize(whole.len() + 100, fill);
            fs::write(folder.file(), &cut).unwrap();
            let opened = StoreFile::open(&folder.file(), 1 << 20);
            // Line feeds alone, or 0xff alone, are no sign of an outbox.
            if length < 12 && fill != 0 {
                continue;
            }
            let lines = whole[..length].iter().filter(|&&byte| byte == b'\n').count();
            let is_complete = fill == b'\n' && whole[length] == b'\n';
            let before = (lines + usize::from(is_complete)).saturating_sub(1);
            let expected = state(records[..before].iter().cloned());
            assert_eq!(opened.unwrap().1, expected, "{length} bytes and {fill}");
        }
    }
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
    // Nor is the file of somebody else touched.
    fs::write(folder.file(), "root:x:0:0\n").unwrap();
    assert!(StoreFile::open(&folder.file(), 1).unwrap_err().to_string().contains("no outbox of this version"));
    assert_eq!(fs::read(folder.file()).unwrap(), b"root:x:0:0\n");
    fs::remove_file(folder.file()).unwrap();
    let _first = StoreFile::open(&folder.file(), 1).unwrap();
    let refused = StoreFile::open(&folder.file(), 1).unwrap_err().to_string();
    assert!(refused.contains("in use by another agent"), "{refused}");
}

#[test]
fn regress_no_link_is_followed_and_nobody_else_can_read_the_files() {
    let folder = Folder::new("links");
    let victim = folder.0.join("victim");
    for kind in ["symbolic", "hard"] {
        for name in ["outbox", "outbox.lock", "outbox.new", "outbox.damaged"] {
            for old in ["outbox", "outbox.lock", "outbox.new", "outbox.damaged"] {
                let _ = fs::remove_file(folder.0.join(old));
            }
            fs::write(&victim, "keep me").unwrap();
            let path = folder.0.join(name);
            if kind == "hard" {
                fs::hard_link(&victim, &path).unwrap()
            } else {
                symlink(&victim, &path).unwrap()
            }
            let opened = StoreFile::open(&folder.file(), 1 << 20);
            match name {
                "outbox" | "outbox.lock" => {
                    let refused = opened.unwrap_err().to_string();
                    assert!(refused.contains("link"), "{name}: {refused}");
                }
                "outbox.new" => assert!(opened.unwrap().0.replace(some_records()).is_err()),
                _ => {
                    // A damaged line wants to be copied there.
                    drop(opened.unwrap().0.replace(some_records()));
                    let whole = fs::read_to_string(folder.file()).unwrap();
                    fs::write(folder.file(), whole.replacen("\"seq\":3", "\"seq\":4", 1)).unwrap();
                    let (_file, _, damage) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
                    let aside = damage.aside.unwrap();
                    assert_eq!((damage.lines, &aside), (1, &folder.0.join("outbox.damaged-2")));
                    fs::remove_file(aside).unwrap();
                }
            }
            assert_eq!(fs::read(&victim).unwrap(), b"keep me", "{kind} {name}");
        }
    }
    fs::remove_file(folder.0.join("outbox.damaged")).unwrap();
    // Files of an earlier version are closed to others.
    written(&folder, &some_records());
    for name in ["outbox", "outbox.lock"] {
        fs::set_permissions(folder.0.join(name), fs::Permissions::from_mode(0o644)).unwrap();
    }
    let (mut file, ..) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
    for name in ["outbox", "outbox.lock"] {
        assert_eq!(fs::metadata(folder.0.join(name)).unwrap().permissions().mode() & 0o777, 0o600, "{name}");
    }
    file.replace(some_records()).unwrap();
    assert_eq!(fs::metadata(folder.file()).unwrap().permissions().mode() & 0o777, 0o600);
}

#[test]
fn regress_files_of_somebody_else_keep_content_and_mode() {
    let folder = Folder::new("foreign");
    let mode = |path: &std::path::Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    for name in ["outbox", "outbox.lock", "outbox.new", "outbox.damaged"] {
        let path = folder.0.join(name);
        fs::write(&path, "root:x:0:0\n").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
        let opened = StoreFile::open(&folder.file(), 1 << 20);
        match name {
            "outbox" => assert!(opened.unwrap_err().to_string().contains("no outbox of this version")),
            "outbox.new" => {
                let refused = opened.unwrap().0.replace(some_records()).unwrap_err().to_string();
                assert!(refused.contains("move it away"), "{refused}");
            }
            _ => opened.unwrap().0.replace(some_records()).unwrap(),
        }
        assert_eq!((fs::read(&path).unwrap(), mode(&path)), (b"root:x:0:0\n".to_vec(), 0o644), "{name}");
        for name in ["outbox", "outbox.lock", "outbox.new", "outbox.damaged"] {
            let _ = fs::remove_file(folder.0.join(name));
        }
    }
    // A torn file of an earlier agent is replaced.
    for torn in ["", "vibrissa-rob", "vibrissa-robot outbox 1\nx", "\0\0\0\0", "vibrissa-rob\0\0"] {
        fs::write(folder.0.join("outbox.new"), torn).unwrap();
        StoreFile::open(&folder.file(), 1 << 20).unwrap().0.replace(some_records()).unwrap();
    }
}

#[test]
fn regress_no_earlier_copy_of_a_damaged_file_is_replaced() {
    let folder = Folder::new("copies");
    let mut copies = Vec::new();
    for at in 0..12 {
        let _ = fs::remove_file(folder.file());
        written(&folder, &some_records());
        let whole = fs::read_to_string(folder.file()).unwrap();
        let broken = whole.replacen("\"seq\":3", &format!("\"seq\":{}", 30 + at), 1);
        fs::write(folder.file(), &broken).unwrap();
        let (_file, _, damage) = StoreFile::open(&folder.file(), 1 << 20).unwrap();
        copies.extend(damage.aside.map(|aside| (aside, broken)));
        assert_eq!(copies.len(), usize::min(at + 1, 10));
        assert!(copies.iter().all(|(aside, broken)| fs::read_to_string(aside).unwrap() == *broken));
    }
}

/// Only root can give files away, so others see only that their own file stays theirs.
#[test]
fn regress_a_lock_that_root_makes_belongs_to_the_owner_of_the_folder() {
    let folder = Folder::new("owner");
    let me = fs::metadata(&folder.0).unwrap().uid();
    let owner = if me == 0 { 65_534 } else { me };
    std::os::unix::fs::chown(&folder.0, Some(owner), None).unwrap();
    let _lock = StoreFile::lock(&folder.file()).unwrap();
    assert_eq!(fs::metadata(folder.0.join("outbox.lock")).unwrap().uid(), owner);
}
