//! Contacts that have no room in the outbox: they wait on disk, and come back in order when receipts have made room.

use vibrissa_protocol::{Contacts, RobotTopic, decode_contacts, encode};

use super::{Agent, Output};
use crate::contract::Now;
use crate::store::spool::Position;
use crate::store::{Payload, Record};

/// State of the disk, as the agent knows it.
#[derive(Debug)]
pub(super) struct Spooling {
    /// Whether something waits there.
    pub(super) is_waiting: bool,
    /// A message was asked back and has not come yet.
    is_asked: bool,
    /// Position after the last one that has come back.
    pub(super) position: Option<Position>,
}

impl Spooling {
    pub(super) fn new(is_waiting: bool, position: Option<Position>) -> Self {
        Self { is_waiting, is_asked: false, position }
    }
}

impl Agent {
    /// Whether a message of so many bytes must go to the disk: later ones never overtake earlier ones.
    pub(super) fn must_spool(&self, bytes: usize) -> bool {
        let Some(spooling) = &self.spooling else { return false };
        let has_room =
            self.bytes_kept() + bytes <= self.limits.outbox_bytes && self.outbox.len() < self.limits.outbox_messages;
        spooling.is_waiting || !has_room
    }

    /// Sends contacts to the disk.
    pub(super) fn spool(&mut self, message: &Contacts, out: &mut Vec<Output>) {
        if let Some(spooling) = &mut self.spooling {
            spooling.is_waiting = true;
            out.push(Output::Spool(encode(message)));
        }
    }

    /// Asks for the next message back while the outbox is half empty. The other half is its room.
    pub(super) fn ask_back(&mut self, out: &mut Vec<Output>) {
        let is_free = 2 * self.bytes_kept() < self.limits.outbox_bytes
            && (2 * self.outbox.len() < self.limits.outbox_messages || self.outbox.is_empty());
        let Some(spooling) = &mut self.spooling else { return };
        if spooling.is_waiting && !spooling.is_asked && is_free {
            spooling.is_asked = true;
            out.push(Output::TakeBack);
        }
    }

    /// A message has come back, or nothing waits any more.
    pub(super) fn came_back(&mut self, back: Option<(&[u8], Position)>, now: Now, out: &mut Vec<Output>) {
        let Some(spooling) = &mut self.spooling else { return };
        spooling.is_asked = false;
        let Some((message, position)) = back else {
            spooling.is_waiting = false;
            return;
        };
        spooling.position = Some(position);
        // What another version has written may keep other rules.
        let Ok(message) = decode_contacts(message, Vec::new()) else {
            self.dropped_earlier += 1;
            return;
        };
        let message = self.voice.contacts(message.contacts, message.missed);
        let payload = encode(&message);
        if let Some(stored) = Payload::new(&payload) {
            let (boot_id, seq) = (message.boot_id, message.seq);
            // One record, so that no restart finds one without the other.
            out.push(Output::Store(Record::Contacts { boot_id, seq, payload: stored, spooled: Some(position) }));
        }
        self.outbox.keep(message.seq, payload.clone(), self.connected.then_some(now.at));
        self.publish(RobotTopic::Contacts, payload, out);
    }

    /// Messages were lost on the disk: there was no room, or it cannot be written.
    pub(super) fn lost_on_disk(&mut self, messages: u64) {
        self.dropped_earlier += messages;
    }

    /// Bytes of all messages in memory.
    pub(super) fn bytes_kept(&self) -> usize {
        self.outbox.bytes() + self.earlier.iter().map(|boot| boot.outbox.bytes()).sum::<usize>()
    }
}
