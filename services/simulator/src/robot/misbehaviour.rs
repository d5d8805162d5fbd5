//! Violations of the contract that a scenario can request. They change messages on their way in and out; other
//! violations are in the code that implements the rule.

use vibrissa_protocol::{Contact, Contacts, Message, Receipt, RobotTopic, Status, WhiskerStatus, decode, encode};

use super::{Outgoing, Robot};
use crate::outbox::Outbox;
use crate::scenario::{Behaviour, Misbehaviour};

/// Pressure deficit of [`Misbehaviour::HoldsLess`], in MPa.
pub(super) const HELD_LESS_MPA: f64 = 0.008;
/// A slew faster than any valve.
pub(super) const AT_ONCE_MPA_PER_S: f64 = 10.0;
/// A whisker number that no scenario has.
const NO_WHISKER: u16 = 60_000;
const HOUR_US: u64 = 3_600_000_000;

/// The outbox for this behaviour.
pub(super) fn outbox(behaviour: &Behaviour) -> Outbox {
    let is_steady = behaviour.misbehaviour == Some(Misbehaviour::NoBackoff);
    Outbox::new(behaviour.kept_messages, is_steady)
}

impl Robot {
    /// Whether the robot has this fault.
    pub(super) fn breaks(&self, fault: Misbehaviour) -> bool {
        self.config.behaviour.misbehaviour == Some(fault)
    }

    /// The robot's fault, if it has one.
    #[must_use]
    pub fn misbehaviour(&self) -> Option<Misbehaviour> {
        self.config.behaviour.misbehaviour
    }

    /// Seconds between two `status` messages.
    pub(super) fn status_every_s(&self) -> f64 {
        match self.misbehaviour() {
            Some(Misbehaviour::StatusSeldom) => 25.0,
            Some(Misbehaviour::StatusOften) => 0.1,
            Some(_) | None => self.config.behaviour.status_every_s,
        }
    }

    /// Encodes a status, changed by the fault.
    pub(super) fn status_as_sent(&self, mut status: Status) -> Vec<u8> {
        let is_third = status.seq % 3 == 2;
        if self.breaks(Misbehaviour::StatusLeavesOut) {
            status.whiskers.pop();
        }
        if self.breaks(Misbehaviour::TimeBack) && is_third {
            status.t_us -= 1_500_000;
        }
        for (entry, whisker) in status.whiskers.iter_mut().zip(&self.whiskers) {
            self.falsify(entry, whisker.facts().pressure_mpa);
        }
        let payload = encode(&status);
        if self.breaks(Misbehaviour::MalformedStatus) && is_third {
            let text = String::from_utf8_lossy(&payload).replacen("\"t_us\"", "\"time\"", 1);
            return text.into_bytes();
        }
        payload
    }

    fn falsify(&self, entry: &mut WhiskerStatus, nominal_mpa: f64) {
        if self.breaks(Misbehaviour::HoldsLess) {
            entry.setpoint_mpa += HELD_LESS_MPA;
        }
        if self.breaks(Misbehaviour::StatusStaysNominal) {
            entry.setpoint_mpa = nominal_mpa;
        }
    }

    /// A contact changed by the fault, before it is put into a message; `number` counts the whisker's contacts.
    pub(super) fn contact_as_sent(&self, mut contact: Contact, number: u64) -> Contact {
        let is_fifth = number % 5 == 4;
        if self.breaks(Misbehaviour::ContactsAhead) {
            contact.t_us += HOUR_US;
        }
        if self.breaks(Misbehaviour::RatioAboveOne) && is_fifth {
            contact.ratio = Some(1.2);
        }
        if self.breaks(Misbehaviour::AnotherPlace) && is_fifth {
            (contact.distance_mm, contact.ratio) = (contact.ratio.map(|ratio| 70.0 * ratio), None);
        }
        if self.breaks(Misbehaviour::UnknownWhiskerTouched) && is_fifth {
            contact.whisker = NO_WHISKER;
        }
        contact
    }

    /// A receipt changed by the fault.
    pub(super) fn receipt_as_read(&self, receipt: &Receipt) -> Receipt {
        let mut read = receipt.clone();
        match self.misbehaviour() {
            Some(Misbehaviour::IgnoresNext) => read.next = 0,
            Some(Misbehaviour::IgnoresHeld) => read.held.clear(),
            Some(Misbehaviour::ForgetsGap) => {
                let end = read.held.iter().map(|&(_, last)| last + 1).max();
                read.next = read.next.max(end.unwrap_or(0));
            }
            Some(_) | None => {}
        }
        read
    }

    /// Messages to send again, changed by the fault.
    pub(super) fn resent_as_sent(&self, mut payloads: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        if self.breaks(Misbehaviour::ResendsNewestFirst) {
            payloads.reverse();
        }
        if self.breaks(Misbehaviour::ResendsAltered) {
            return payloads.into_iter().map(|payload| self.altered(payload)).collect();
        }
        payloads
    }

    fn altered(&self, payload: Vec<u8>) -> Vec<u8> {
        match decode(&RobotTopic::Contacts.of(self.fleet(), self.name()), &payload) {
            Ok(Message::Contacts(Contacts { boot_id, seq, mut contacts, missed })) => {
                contacts.iter_mut().for_each(|contact| contact.strain *= 0.9);
                encode(&Contacts { boot_id, seq, contacts, missed })
            }
            Ok(_) | Err(_) => payload,
        }
    }

    /// Whether the fault ignores a valid message.
    pub(super) fn overlooks(&self, message: &Message, payload: &[u8]) -> bool {
        // The re-encoded message has only the known fields.
        self.breaks(Misbehaviour::RefusesUnknownFields) && encode(message).len() < payload.len()
    }

    /// Handles an invalid message.
    pub(super) fn stumble(&mut self, out: &mut Vec<Outgoing>) {
        self.refused += 1;
        if self.breaks(Misbehaviour::RestartsOnMalformed) {
            self.restart(out);
        }
    }
}
