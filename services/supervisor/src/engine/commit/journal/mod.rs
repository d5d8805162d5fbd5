//! The journal: an input log of ordinary events in compact form, written with the rows of their effects. With it, not
//! every contact needs a checkpoint: after a crash, a robot's last checkpoint is loaded, and the later events are
//! replayed.
//!
//! The same events lead to the same state, because the core has no clock and no randomness; so only events are stored.
//! Only events that lead to contact rows and nothing else are journalled; a decision needs a checkpoint.

pub(in crate::engine) mod index;
mod place;
pub(crate) mod records;
mod stored;
mod version_2;
mod version_4;

use std::collections::BTreeMap;

use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_core::robot::effect::ContactRecord;
use vibrissa_core::robot::event::{Contact, GaugeState, RegulatorState, WhiskerStatus};
use vibrissa_core::robot::{Event, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};
use vibrissa_edge::words::Word;
use vibrissa_protocol as protocol;

use crate::engine::part::Part;
use crate::engine::robot::KnownRobot;
use crate::log_inbox::LogRange;
use vibrissa_store::batch::ContactRow;

use place::{JournalPlace, PlaceAndAngle};
pub(crate) use stored::StoredEntries;
use stored::read;

/// Version of the entries' layout. A negative number -v before entries gives their version v; entries begin with a robot's
/// id, which is positive. Entries of version 1 have the layout of version 2 and no version number; [`version_2`] reads both.
const VERSION: i64 = 3;
/// Version of rows with references to a partitioned log. Its other entries are those of version 3. References of
/// version 4 ([`version_4`]) do not name their partition.
const VERSION_OF_LOG: i64 = 5;
/// Robot of entries about all robots of a part.
const NO_ROBOT: i64 = 0;
/// Number of journal rows read at a time.
pub(crate) const ROWS_AT_A_TIME: i64 = 256;
/// Index of an array that the robot does not have.
const NO_ARRAY: u16 = u16::MAX;

/// Borsh tag of [`JournalEvent::Contacts`].
const CONTACTS: u8 = 1;

/// Journal entries of the open transaction.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    bytes: Vec<u8>,
    contacts: usize,
}

/// An event of one robot.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(crate) struct Entry {
    pub(crate) robot_id: i64,
    pub(crate) now: Micros,
    pub(crate) event: JournalEvent,
}

/// Kind and content of a journalled event.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(crate) enum JournalEvent {
    Tick,
    Contacts {
        boot: i64,
        seq: u64,
        contacts: Vec<JournalContact>,
    },
    Status {
        boot: i64,
        robot_time: Micros,
        whiskers: Vec<JournalStatus>,
    },
    /// Records of a partitioned log, for the robots of a part but those in `except`. The entry's time is that of the
    /// first record; each further one is a microsecond later.
    Log {
        range: LogRange,
        part: Part,
        except: Vec<i64>,
    },
    /// A tick of all robots of a part.
    TickAll {
        part: Part,
    },
}

/// A journalled contact.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(crate) struct JournalContact {
    array: u16,
    whisker: u16,
    robot_time: Micros,
    place: PlaceAndAngle,
    deflection_mm: f64,
    strain: f64,
    pressure_mpa: f64,
    temperature_c: f64,
}

/// A journalled line of a status.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(crate) struct JournalStatus {
    array: u16,
    whisker: u16,
    pressure_mpa: f64,
    setpoint_mpa: f64,
    regulator: RegulatorState,
    gauge: GaugeState,
}

impl Journal {
    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Size of the entries in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Takes the entries, and the number of contacts in them.
    pub(crate) fn take(&mut self) -> (Vec<u8>, usize) {
        let contacts = std::mem::take(&mut self.contacts);
        let empty = Vec::with_capacity(self.bytes.len());
        (std::mem::replace(&mut self.bytes, empty), contacts)
    }

    /// Removes one robot's entries.
    pub(crate) fn remove(&mut self, robot_id: i64) {
        let others = by_robot(&self.bytes).into_iter().filter(|(other, _)| *other != robot_id);
        let bytes: Vec<u8> = others.flat_map(|(_, entries)| entries).collect();
        let contacts = read(&bytes).filter_map(Result::ok).map(|entry| match entry.event {
            JournalEvent::Contacts { contacts, .. } => contacts.len(),
            JournalEvent::Tick
            | JournalEvent::Status { .. }
            | JournalEvent::Log { .. }
            | JournalEvent::TickAll { .. } => 0,
        });
        self.contacts = contacts.sum();
        self.bytes = bytes;
    }

    pub(crate) fn tick(&mut self, known: &KnownRobot, now: Micros) {
        self.write(&Entry { robot_id: known.robot_id, now, event: JournalEvent::Tick });
    }

    /// Refers to records of the log.
    pub(crate) fn log(&mut self, now: Micros, range: LogRange, part: Part, except: Vec<i64>) {
        self.write_of_log(&Entry { robot_id: NO_ROBOT, now, event: JournalEvent::Log { range, part, except } });
    }

    /// Replaces the ticks of single robots that were added after `before` bytes by one of all.
    pub(crate) fn tick_all(&mut self, before: usize, now: Micros, part: Part) {
        if self.bytes.len() > before {
            self.bytes.truncate(before);
            self.write_of_log(&Entry { robot_id: NO_ROBOT, now, event: JournalEvent::TickAll { part } });
        }
    }

    /// Counts contacts that the log has.
    pub(crate) fn count(&mut self, contacts: usize) {
        self.contacts += contacts;
    }

    fn write_of_log(&mut self, entry: &Entry) {
        self.bytes.extend((-VERSION_OF_LOG).to_le_bytes());
        // Writing to memory cannot fail.
        let _ = entry.serialize(&mut self.bytes);
    }

    /// Adds a `contacts` message, as it was `accepted`; if it was not, its contacts are omitted.
    pub(crate) fn contacts(
        &mut self,
        known: &KnownRobot,
        now: Micros,
        event: &Event<'_>,
        accepted: Option<&protocol::Contacts>,
    ) {
        let Event::Contacts { boot_id, seq, contacts, .. } = event else { return };
        let temperatures = accepted.map_or(&[][..], |message| &message.contacts);
        let contacts = if accepted.is_some() { contacts } else { &[][..] };
        self.contacts += contacts.len();
        // Encoded like an `Entry`, without allocating one.
        let head = (known.robot_id, now, CONTACTS, known.boot(boot_id), *seq, contacts.len() as u32);
        self.write(&head);
        for (position, one) in contacts.iter().enumerate() {
            let temperature_c = temperatures.get(position).map_or(0.0, |one| one.temperature_c);
            self.write(&JournalContact::of(&known.robot, one, temperature_c));
        }
    }

    pub(crate) fn status(&mut self, known: &KnownRobot, now: Micros, event: &Event<'_>) {
        let Event::Status { boot_id, robot_time, whiskers } = event else { return };
        let whiskers = whiskers.iter().map(|one| JournalStatus::of(&known.robot, one)).collect();
        let event = JournalEvent::Status { boot: known.boot(boot_id), robot_time: *robot_time, whiskers };
        self.write(&Entry { robot_id: known.robot_id, now, event });
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

/// Entries by robot, as bytes of the present version, in order. Entries that cannot be read are left out.
pub(crate) fn by_robot(bytes: &[u8]) -> Vec<(i64, Vec<u8>)> {
    let mut robots: BTreeMap<i64, Vec<u8>> = BTreeMap::new();
    for entry in read(bytes).map_while(Result::ok) {
        let version = if entry.robot_id == NO_ROBOT { VERSION_OF_LOG } else { VERSION };
        let own = robots.entry(entry.robot_id).or_insert_with(|| (-version).to_le_bytes().to_vec());
        // Writing to memory cannot fail.
        let _ = entry.serialize(own);
    }
    robots.into_iter().collect()
}

fn array_index(robot: &Robot, name: &str) -> u16 {
    robot.arrays().position(|array| array == name).map_or(NO_ARRAY, |index| index as u16)
}

fn array_name(arrays: &[String], index: u16) -> &str {
    arrays.get(usize::from(index)).map_or("", String::as_str)
}

impl Entry {
    /// The entry of a contacts message that the log has.
    pub(crate) fn of_contacts(known: &KnownRobot, now: Micros, message: &protocol::Contacts) -> Self {
        let mut contacts = Vec::with_capacity(message.contacts.len());
        for one in message.contacts.iter().filter_map(|one| vibrissa_edge::contact(one).ok()) {
            let temperature_c = message.contacts.get(contacts.len()).map_or(0.0, |one| one.temperature_c);
            contacts.push(JournalContact::of(&known.robot, &one, temperature_c));
        }
        let boot = known.boot(message.boot_id.as_str());
        Self { robot_id: known.robot_id, now, event: JournalEvent::Contacts { boot, seq: message.seq, contacts } }
    }

    /// The entry of a status that the log has; `None` if it is not accepted.
    pub(crate) fn of_status(known: &KnownRobot, now: Micros, message: &protocol::Status) -> Option<Self> {
        let status = |one| Some(JournalStatus::of(&known.robot, &vibrissa_edge::status(one).ok()?));
        let whiskers: Option<Vec<JournalStatus>> = message.whiskers.iter().map(status).collect();
        let (boot, robot_time) = (known.boot(message.boot_id.as_str()), Micros(message.t_us));
        let event = JournalEvent::Status { boot, robot_time, whiskers: whiskers? };
        Some(Self { robot_id: known.robot_id, now, event })
    }
}

impl JournalContact {
    fn of(robot: &Robot, contact: &Contact<'_>, temperature_c: f64) -> Self {
        Self {
            array: array_index(robot, contact.array),
            whisker: contact.whisker,
            robot_time: contact.robot_time,
            place: PlaceAndAngle { place: JournalPlace::of(&contact.place), angle_is_stated: contact.angle_is_stated },
            deflection_mm: contact.deflection.mm(),
            strain: contact.strain.ratio(),
            pressure_mpa: contact.pressure.mpa(),
            temperature_c,
        }
    }

    /// The contact's row as it was written; `boot` and `seq` are those of the message.
    pub(crate) fn row(
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
            place: self.place.place.sent().word(),
            ratio: record.ratio.map(ContactRatio::a),
            distance_mm: self.place.place.distance_mm(),
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
    pub(crate) fn contact<'a>(&self, arrays: &'a [String]) -> Option<Contact<'a>> {
        Some(Contact {
            array: array_name(arrays, self.array),
            whisker: self.whisker,
            robot_time: self.robot_time,
            place: vibrissa_edge::place(self.place.place.sent()).ok()?,
            deflection: Millimetre::new(self.deflection_mm).ok()?,
            strain: Strain::new(self.strain).ok()?,
            pressure: Megapascal::new(self.pressure_mpa).ok()?,
            is_test: false,
            angle_is_stated: self.place.angle_is_stated,
            saturated: false,
            temperature_c: Some(self.temperature_c),
        })
    }
}

impl JournalStatus {
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
    pub(crate) fn status<'a>(&self, arrays: &'a [String]) -> Option<WhiskerStatus<'a>> {
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
mod tests;
