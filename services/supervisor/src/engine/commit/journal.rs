//! The journal: an input log of ordinary events in compact form, written with the rows of their effects. With it, not
//! every contact needs a checkpoint: after a crash, a robot's last checkpoint is loaded, and the later events are
//! replayed.
//!
//! The same events lead to the same state, because the core has no clock and no randomness; so only events are stored.
//! Only events that lead to contact rows and nothing else are journalled; a decision needs a checkpoint.

use std::collections::BTreeMap;

use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_core::robot::effect::ContactRecord;
use vibrissa_core::robot::event::{Contact, GaugeState, RegulatorState, WhiskerStatus};
use vibrissa_core::robot::{Event, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};
use vibrissa_edge::words::Word;

use crate::engine::commit::batch::Source;
use crate::engine::shard::Known;
use vibrissa_store::batch::ContactRow;

/// Version of the entries' layout. A negative number -v before entries gives their version v; entries begin with a robot's
/// id, which is positive. Version 1 had the same layout and no version number.
const VERSION: i64 = 2;
/// Index of an array that the robot does not have.
const NO_ARRAY: u16 = u16::MAX;

/// Borsh tag of [`Told::Contacts`].
const CONTACTS: u8 = 1;

/// Journal entries of the open transaction.
#[derive(Debug, Default)]
pub(in crate::engine) struct Journal {
    bytes: Vec<u8>,
    contacts: usize,
}

/// An event of one robot.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::engine) struct Entry {
    pub(in crate::engine) robot_id: i64,
    pub(in crate::engine) now: Micros,
    pub(in crate::engine) told: Told,
}

/// Kind and content of a journalled event.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::engine) enum Told {
    Tick,
    Contacts { boot: i64, seq: u64, contacts: Vec<KeptContact> },
    Status { boot: i64, robot_time: Micros, whiskers: Vec<KeptStatus> },
}

/// A journalled contact.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::engine) struct KeptContact {
    array: u16,
    whisker: u16,
    robot_time: Micros,
    ratio: f64,
    deflection_mm: f64,
    strain: f64,
    pressure_mpa: f64,
    /// Not used by the core; only the aggregates contain its mean.
    temperature_c: f64,
}

/// A journalled line of a status.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::engine) struct KeptStatus {
    array: u16,
    whisker: u16,
    pressure_mpa: f64,
    setpoint_mpa: f64,
    regulator: RegulatorState,
    gauge: GaugeState,
}

impl Journal {
    pub(in crate::engine) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Size of the entries in bytes.
    pub(in crate::engine) fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Takes the entries, and the number of contacts in them.
    pub(in crate::engine) fn take(&mut self) -> (Vec<u8>, usize) {
        let contacts = std::mem::take(&mut self.contacts);
        let kept = Vec::with_capacity(self.bytes.len());
        (std::mem::replace(&mut self.bytes, kept), contacts)
    }

    /// Removes one robot's entries.
    pub(in crate::engine) fn remove(&mut self, robot_id: i64) {
        let kept = by_robot(&self.bytes).into_iter().filter(|(other, _)| *other != robot_id);
        let bytes: Vec<u8> = kept.flat_map(|(_, entries)| entries).collect();
        let contacts = read(&bytes).filter_map(Result::ok).map(|entry| match entry.told {
            Told::Contacts { contacts, .. } => contacts.len(),
            Told::Tick | Told::Status { .. } => 0,
        });
        self.contacts = contacts.sum();
        self.bytes = bytes;
    }

    pub(in crate::engine) fn tick(&mut self, known: &Known, now: Micros) {
        self.write(&Entry { robot_id: known.robot_id, now, told: Told::Tick });
    }

    /// Adds a `contacts` message, with its source if it was accepted; otherwise its contacts are omitted.
    pub(in crate::engine) fn contacts(
        &mut self,
        known: &Known,
        now: Micros,
        event: &Event<'_>,
        taken: Option<Source<'_>>,
    ) {
        let Event::Contacts { boot_id, seq, contacts } = event else { return };
        let temperatures = taken.map_or(&[][..], |source| &source.told.contacts);
        let contacts = if taken.is_some() { contacts } else { &[][..] };
        self.contacts += contacts.len();
        // Encoded like an `Entry`, without allocating one.
        let head = (known.robot_id, now, CONTACTS, known.boot(boot_id), *seq, contacts.len() as u32);
        self.write(&head);
        for (position, one) in contacts.iter().enumerate() {
            let temperature_c = temperatures.get(position).map_or(0.0, |told| told.temperature_c);
            self.write(&KeptContact::of(&known.robot, one, temperature_c));
        }
    }

    pub(in crate::engine) fn status(&mut self, known: &Known, now: Micros, event: &Event<'_>) {
        let Event::Status { boot_id, robot_time, whiskers } = event else { return };
        let kept = whiskers.iter().map(|one| KeptStatus::of(&known.robot, one)).collect();
        let told = Told::Status { boot: known.boot(boot_id), robot_time: *robot_time, whiskers: kept };
        self.write(&Entry { robot_id: known.robot_id, now, told });
    }

    fn write(&mut self, entry: &impl BorshSerialize) {
        if self.bytes.is_empty() {
            self.bytes.extend(version_mark());
        }
        // Writing to memory cannot fail.
        let _ = entry.serialize(&mut self.bytes);
    }
}

fn version_mark() -> [u8; 8] {
    (-VERSION).to_le_bytes()
}

/// Skips the version numbers before an entry.
///
/// # Errors
/// The entries are of a version that this program cannot read.
fn skip_versions(bytes: &mut &[u8]) -> std::io::Result<()> {
    while let Some((first, rest)) = bytes.split_first_chunk() {
        match i64::from_le_bytes(*first) {
            0.. => break,
            version if version == -VERSION => *bytes = rest,
            version => {
                let problem = format!(
                    "entries of version {}, and this program reads versions 1 to {VERSION}",
                    version.unsigned_abs()
                );
                return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, problem));
            }
        }
    }
    Ok(())
}

/// Reads the entries of one row.
pub(in crate::engine) fn read(mut bytes: &[u8]) -> impl Iterator<Item = std::io::Result<Entry>> {
    std::iter::from_fn(move || {
        let skipped = skip_versions(&mut bytes);
        if skipped.is_ok() && bytes.is_empty() {
            return None;
        }
        let entry = skipped.and_then(|()| Entry::deserialize(&mut bytes));
        if entry.is_err() {
            bytes = &[];
        }
        Some(entry)
    })
}

/// Entries of one row by robot, as bytes with their version number, in order. Entries that cannot be read are left out.
pub(in crate::engine) fn by_robot(mut bytes: &[u8]) -> Vec<(i64, Vec<u8>)> {
    let mut robots: BTreeMap<i64, Vec<u8>> = BTreeMap::new();
    while skip_versions(&mut bytes).is_ok() && !bytes.is_empty() {
        let before = bytes;
        let Ok(entry) = Entry::deserialize(&mut bytes) else { break };
        let own = robots.entry(entry.robot_id).or_insert_with(|| version_mark().to_vec());
        own.extend_from_slice(&before[..before.len() - bytes.len()]);
    }
    robots.into_iter().collect()
}

fn array_index(robot: &Robot, name: &str) -> u16 {
    robot.arrays().position(|array| array == name).map_or(NO_ARRAY, |index| index as u16)
}

fn array_name(arrays: &[String], index: u16) -> &str {
    arrays.get(usize::from(index)).map_or("", String::as_str)
}

impl KeptContact {
    fn of(robot: &Robot, contact: &Contact<'_>, temperature_c: f64) -> Self {
        Self {
            array: array_index(robot, contact.array),
            whisker: contact.whisker,
            robot_time: contact.robot_time,
            ratio: contact.ratio.a(),
            deflection_mm: contact.deflection.mm(),
            strain: contact.strain.ratio(),
            pressure_mpa: contact.pressure.mpa(),
            temperature_c,
        }
    }

    /// The contact's row as it was written; `boot` and `seq` are those of the message.
    pub(in crate::engine) fn row(
        &self,
        record: &ContactRecord,
        whisker_id: i64,
        (boot, seq): (i64, u64),
        now: Micros,
    ) -> ContactRow {
        ContactRow {
            whisker_id,
            boot,
            seq: seq as i64,
            position: record.position as i64,
            t_us: self.robot_time.0 as i64,
            received_us: now.0 as i64,
            ratio: self.ratio,
            deflection_mm: self.deflection_mm,
            strain: self.strain,
            pressure_mpa: self.pressure_mpa,
            temperature_c: self.temperature_c,
            used: record.used.word(),
            residual: record.residual,
            length_mm: record.length.length.mm(),
            length_sd_mm: record.length.sd_mm,
        }
    }

    /// The contact, on a robot with these arrays; `None` if a value is outside the core's ranges, which cannot be the
    /// case for written entries.
    pub(in crate::engine) fn contact<'a>(&self, arrays: &'a [String]) -> Option<Contact<'a>> {
        Some(Contact {
            array: array_name(arrays, self.array),
            whisker: self.whisker,
            robot_time: self.robot_time,
            ratio: ContactRatio::new(self.ratio).ok()?,
            deflection: Millimetre::new(self.deflection_mm).ok()?,
            strain: Strain::new(self.strain).ok()?,
            pressure: Megapascal::new(self.pressure_mpa).ok()?,
        })
    }
}

impl KeptStatus {
    fn of(robot: &Robot, status: &WhiskerStatus<'_>) -> Self {
        Self {
            array: array_index(robot, status.array),
            whisker: status.whisker,
            pressure_mpa: status.pressure.mpa(),
            setpoint_mpa: status.setpoint.mpa(),
            regulator: status.regulator,
            gauge: status.gauge,
        }
    }

    /// The line of a status, on a robot with these arrays; `None` if a value is outside the core's ranges.
    pub(in crate::engine) fn status<'a>(&self, arrays: &'a [String]) -> Option<WhiskerStatus<'a>> {
        Some(WhiskerStatus {
            array: array_name(arrays, self.array),
            whisker: self.whisker,
            pressure: Megapascal::new(self.pressure_mpa).ok()?,
            setpoint: Megapascal::new(self.setpoint_mpa).ok()?,
            regulator: self.regulator,
            gauge: self.gauge,
        })
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_core::robot::Numbers;
    use vibrissa_protocol::{self as protocol, BootId, Name};

    use crate::engine::retention::Keep;

    use super::*;

    /// Bytes of each version, as written by the program of that version. If this fails because the bytes have changed:
    /// raise the version, keep a reader for the old one, and add a file for the new one.
    #[test]
    fn golden_entries_of_version_1_are_read_and_become_version_2() {
        let of_version_1 = include_bytes!("../../../../../tests/data/formats/journal-1.bin");
        let of_version_2 = include_bytes!("../../../../../tests/data/formats/journal-2.bin");
        let entries: Vec<Entry> = read(of_version_1).map(Result::unwrap).collect();
        let contacts = entries.iter().filter(|entry| matches!(entry.told, Told::Contacts { .. })).count();
        let statuses = entries.iter().filter(|entry| matches!(entry.told, Told::Status { .. })).count();
        assert!(contacts > 0 && statuses > 0, "{contacts} and {statuses}");
        assert!(read(of_version_2).map(Result::unwrap).eq(entries.iter().cloned()));
        let mut journal = Journal::default();
        entries.iter().for_each(|entry| journal.write(entry));
        assert_eq!(journal.take().0, of_version_2);
    }

    #[test]
    fn what_was_written_is_read_and_a_row_that_is_cut_off_says_so() {
        let mut known = Known::new(Name::robot("r").unwrap(), 7, Robot::new(1, Numbers::default()), Keep::All);
        known.boots.insert("b", 3);
        let contact = Contact {
            array: "nowhere",
            whisker: 5,
            robot_time: Micros(11),
            ratio: ContactRatio::known(0.7),
            deflection: Millimetre::known(3.0),
            strain: Strain::known(0.001),
            pressure: Megapascal::known(0.1),
        };
        let mut journal = Journal::default();
        let contacts = [contact; 2];
        let event = Event::Contacts { boot_id: "b", seq: 9, contacts: &contacts };
        let felt = |temperature_c| protocol::Contact {
            array: Name::new("nowhere").unwrap(),
            whisker: 5,
            t_us: 11,
            ratio: 0.7,
            deflection_mm: 3.0,
            strain: 0.001,
            pressure_mpa: 0.1,
            temperature_c,
        };
        let boot_id = BootId::new("b").unwrap();
        let told = protocol::Contacts { boot_id, seq: 9, contacts: vec![felt(21.0), felt(22.0)] };
        journal.contacts(&known, Micros(100), &event, Some(Source { told: &told, boot: 3 }));
        journal.tick(&known, Micros(200));
        journal.contacts(&known, Micros(300), &event, None);
        let (bytes, count) = journal.take();
        assert_eq!((count, journal.is_empty()), (2, true));
        let entries: Vec<Entry> = read(&bytes).map(Result::unwrap).collect();
        let kept = |temperatures: &[f64]| {
            temperatures.iter().map(|&one| KeptContact::of(&known.robot, &contact, one)).collect()
        };
        let told = |temperatures| Told::Contacts { boot: 3, seq: 9, contacts: kept(temperatures) };
        let entry = |now, told| Entry { robot_id: 7, now: Micros(now), told };
        assert_eq!(entries, [entry(100, told(&[21.0, 22.0])), entry(200, Told::Tick), entry(300, told(&[]))]);
        let Told::Contacts { contacts, .. } = &entries[0].told else { panic!("contacts") };
        let arrays = ["a".to_owned()];
        assert_eq!(contacts[0].contact(&arrays), Some(Contact { array: "", ..contact }), "an unknown array");
        // Concatenated rows, and rows of version 1, have the same entries.
        let parts: Vec<u8> = by_robot(&bytes).into_iter().flat_map(|(_, entries)| entries).collect();
        for row in [[&parts[..], &bytes].concat(), [&bytes[8..], &bytes[8..]].concat()] {
            assert!(read(&row).map(Result::unwrap).eq(entries.iter().chain(&entries).cloned()));
        }
        let newer = [&(-VERSION - 1).to_le_bytes()[..], &bytes[8..]].concat();
        let refused: Vec<_> = read(&newer).collect();
        assert!(matches!(&refused[..], [Err(problem)] if problem.to_string().contains("version 3")), "{refused:?}");
        let cut: Vec<_> = read(&bytes[..bytes.len() - 1]).collect();
        assert_eq!(cut.iter().filter(|entry| entry.is_ok()).count(), 2);
        assert_eq!(cut.iter().filter(|entry| entry.is_err()).count(), 1);
    }
}
