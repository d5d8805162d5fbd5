//! Entries of versions 1 and 2, whose contacts have a contact ratio and no other place.

use borsh::BorshDeserialize;
use vibrissa_core::units::Micros;

use super::{JournalContact, JournalEvent, JournalPlace, JournalStatus, PlaceAndAngle};

#[derive(BorshDeserialize)]
pub(super) struct Entry {
    robot_id: i64,
    now: Micros,
    event: Event,
}

#[derive(BorshDeserialize)]
enum Event {
    Tick,
    Contacts { boot: i64, seq: u64, contacts: Vec<Contact> },
    Status { boot: i64, robot_time: Micros, whiskers: Vec<JournalStatus> },
}

#[derive(BorshDeserialize)]
struct Contact {
    array: u16,
    whisker: u16,
    robot_time: Micros,
    ratio: f64,
    deflection_mm: f64,
    strain: f64,
    pressure_mpa: f64,
    temperature_c: f64,
}

impl From<Entry> for super::Entry {
    fn from(Entry { robot_id, now, event }: Entry) -> Self {
        let event = match event {
            Event::Tick => JournalEvent::Tick,
            Event::Contacts { boot, seq, contacts } => {
                JournalEvent::Contacts { boot, seq, contacts: contacts.into_iter().map(Into::into).collect() }
            }
            Event::Status { boot, robot_time, whiskers } => JournalEvent::Status { boot, robot_time, whiskers },
        };
        Self { robot_id, now, event }
    }
}

impl From<Contact> for JournalContact {
    fn from(one: Contact) -> Self {
        Self {
            array: one.array,
            whisker: one.whisker,
            robot_time: one.robot_time,
            place: PlaceAndAngle { place: JournalPlace::Ratio { ratio: one.ratio, sd: None }, angle_is_stated: false },
            deflection_mm: one.deflection_mm,
            strain: one.strain,
            pressure_mpa: one.pressure_mpa,
            temperature_c: one.temperature_c,
        }
    }
}
