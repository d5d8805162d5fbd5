//! Events of contacts for the log, which only subscribers of contacts get.

use std::collections::BTreeMap;

use vibrissa_core::robot::effect::ContactRecord;
use vibrissa_core::units::ContactRatio;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::words::Word;
use vibrissa_store::events::write::EventRow;

use crate::engine::commit::batch::Source;
use crate::engine::robot::KnownRobot;
use crate::events::{ContactPart, ContactsPart, EventSink, Parts};

/// Makes the events of contacts.
#[derive(Debug)]
pub(crate) struct ContactEvents {
    sink: EventSink,
    /// Contacts of the current message.
    contacts: Vec<ContactPart>,
    /// Number of contacts that are left out since the last event of contacts, by the robot's number in the database.
    left_out: BTreeMap<i64, u64>,
}

impl ContactEvents {
    pub(crate) fn new(sink: EventSink) -> Self {
        Self { sink, contacts: Vec::new(), left_out: BTreeMap::new() }
    }

    /// Takes a contact of the current message.
    pub(super) fn take(&mut self, known: &KnownRobot, contact: &ContactRecord, source: Source<'_>) {
        if self.sink.has_contacts {
            self.contacts.extend(contact_part(known, contact, source));
        }
    }

    /// The event of the current message's contacts; `None` without contacts, or without room for them.
    pub(super) fn make(&mut self, known: &KnownRobot, source: Option<Source<'_>>) -> Option<(EventKind, Parts)> {
        let contacts = std::mem::take(&mut self.contacts);
        let source = source.filter(|_| !contacts.is_empty())?;
        if self.sink.room.is_full() {
            let more = contacts.len() as u64;
            self.sink.room.leave_out(more);
            let left_out = self.left_out.entry(known.robot_id).or_default();
            *left_out += more;
            // The first event is written now, because a restart forgets the number.
            return (*left_out == more).then(|| (EventKind::ContactsLeftOut, Parts::default()));
        }
        let left_out = self.left_out.remove(&known.robot_id);
        let (boot_id, seq) = (source.message.boot_id.as_str().to_owned(), source.message.seq);
        let contacts = Some(ContactsPart { boot_id, seq, left_out, contacts });
        Some((EventKind::Contacts, Parts { contacts, ..Parts::default() }))
    }

    /// Notes the room that an event of any kind takes in the log.
    pub(super) fn added(&self, row: &EventRow) {
        self.sink.room.add(row);
    }
}

fn contact_part(known: &KnownRobot, contact: &ContactRecord, source: Source<'_>) -> Option<ContactPart> {
    let sent = source.message.contacts.get(contact.position)?;
    Some(ContactPart {
        position: contact.position as i64,
        array: sent.array.as_str().to_owned(),
        whisker: sent.whisker,
        t_us: sent.t_us as i64,
        place: sent.place().word(),
        ratio: contact.ratio.map(ContactRatio::a),
        distance_mm: sent.distance_mm,
        deflection_mm: sent.deflection_mm,
        strain: sent.strain,
        pressure_mpa: sent.pressure_mpa,
        temperature_c: sent.temperature_c,
        used: contact.used.word(),
        residual: contact.residual,
        length_mm: contact.length.length.mm(),
        length_sd_mm: contact.length.sd_mm,
    })
    .filter(|_| known.robot.whisker(contact.whisker).is_some())
}
