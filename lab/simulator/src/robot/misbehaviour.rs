//! Violations of the contract that a scenario can request. They change messages before the rules see them, or on their
//! way out; the rules themselves know nothing of them.

use vibrissa_protocol::{
    Contact, Contacts, Estimate, Message, OnSupervisorLoss, QualityOfService, Receipt, RobotTopic, Setpoint, Status,
    TouchTest, WhiskerStatus, decode, encode,
};

use vibrissa_robot::contract::outbox::{BACKOFF_MAX_US, BACKOFF_START_US};
use vibrissa_robot::contract::{Addressee, Outbox, TestVerdict, Tested, Verdict};
use vibrissa_robot::mqtt::Delivery;

use super::{Outgoing, Robot};
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
    Outbox::with_longest_pause(behaviour.kept_messages, if is_steady { BACKOFF_START_US } else { BACKOFF_MAX_US })
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
        if self.breaks(Misbehaviour::DropsUncounted) {
            status.contacts_dropped = None;
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
        let at = self.places.get(&(contact.array.clone(), contact.whisker));
        contact.strain *= at.map_or(1.0, |&at| self.strain_factor(at));
        if self.breaks(Misbehaviour::ContactsAhead) {
            contact.t_us += HOUR_US;
        }
        if self.breaks(Misbehaviour::RatioAboveOne) && is_fifth {
            contact.ratio = Some(1.2);
        }
        let strain_max = at.and_then(|&at| self.whiskers[at].facts().strain_max);
        if let Some(strain_max) = strain_max.filter(|_| self.breaks(Misbehaviour::StrainBeyondGauge) && is_fifth) {
            contact.strain = 1.5 * strain_max;
        }
        if self.breaks(Misbehaviour::AnotherPlace) && is_fifth {
            (contact.distance_mm, contact.ratio) = (contact.ratio.map(|ratio| 70.0 * ratio), None);
        }
        if self.breaks(Misbehaviour::UnknownWhiskerTouched) && is_fifth {
            contact.whisker = NO_WHISKER;
        }
        contact
    }

    /// Factor on the strain of a whisker's contacts.
    pub(super) fn strain_factor(&self, at: usize) -> f64 {
        if self.breaks(Misbehaviour::MultipliesStrain) { self.whiskers[at].reading_gain() } else { 1.0 }
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

    /// Decides about a setpoint by the contract's rules, which the fault evades.
    pub(super) fn decide_setpoint(&mut self, setpoint: &Setpoint, at: Option<usize>, now_us: u64) -> Verdict {
        let fault = self.misbehaviour();
        let mut read = setpoint.clone();
        match fault {
            Some(Misbehaviour::TakesOtherBoots) => read.robot_boot_id = self.boot_id().clone(),
            Some(Misbehaviour::TakesExpired) => read.expires_us = u64::MAX,
            Some(Misbehaviour::TakesAnyPressure) => read.pressure_mpa = 0.0,
            Some(_) | None => {}
        }
        let Some(whisker) = at.and_then(|at| self.whiskers.get_mut(at)) else {
            return self.commands.judge(&read, self.voice.boot_id(), now_us, None);
        };
        if fault == Some(Misbehaviour::TakesAnySetpoint) {
            return Verdict::Take;
        }
        let order = (read.epoch, read.version);
        let is_stale = |seen: (u64, u64)| match fault {
            Some(Misbehaviour::TakesOldVersions) => order.0 < seen.0,
            Some(Misbehaviour::TakesOldEpochs) => order.1 <= seen.1,
            Some(_) | None => order <= seen,
        };
        let before = whisker.seen;
        // The rules are told of an order that gives the answer of the fault.
        let stale = before.filter(|&seen| is_stale(seen)).map(|seen| seen.max(order));
        let mut seen = stale;
        let addressee = Addressee { pressure_max_mpa: whisker.facts().pressure_max_mpa, seen: &mut seen };
        let verdict = self.commands.judge(&read, self.voice.boot_id(), now_us, Some(addressee));
        whisker.seen = if stale.is_none() { before.max(seen) } else { before };
        verdict
    }

    /// Decides about a touch test by the contract's rules, which the fault evades.
    pub(super) fn decide_test(&mut self, test: &TouchTest, at: Option<usize>, now_us: u64) -> TestVerdict {
        let mut read = test.clone();
        if self.breaks(Misbehaviour::TestsForOtherBoots) {
            read.robot_boot_id = self.boot_id().clone();
        }
        let kinds = &self.config.behaviour.touch_tests;
        let tested = at.and_then(|at| self.whiskers.get_mut(at)).map(|whisker| Tested {
            is_ready: whisker.applying.is_none(),
            seen: &mut whisker.seen,
            kinds,
        });
        self.touch_tests.judge(&read, self.voice.boot_id(), now_us, tested)
    }

    /// Delivery of the messages on a topic, changed by the fault.
    pub(crate) fn delivery(&self, topic: RobotTopic) -> Delivery {
        let right = Delivery::of(topic);
        match (self.misbehaviour(), topic) {
            // The farewell is retained as it must be.
            (Some(Misbehaviour::BirthNotRetained), RobotTopic::Connection) => {
                Delivery { is_retained: self.is_leaving, ..right }
            }
            (Some(Misbehaviour::FactsheetNotRetained), RobotTopic::Factsheet) => {
                Delivery { is_retained: false, ..right }
            }
            (Some(Misbehaviour::StatusRetained), RobotTopic::Status) => Delivery { is_retained: true, ..right },
            (Some(Misbehaviour::AnswersAtMostOnce), RobotTopic::SetpointState) => {
                Delivery { quality: QualityOfService::AtMostOnce, ..right }
            }
            (Some(_) | None, _) => right,
        }
    }

    /// Whether a contacts message finds room in the outbox: always, except with the fault that drops the newest.
    pub(super) fn has_room(&mut self) -> bool {
        let is_full = self.outbox.len() >= self.config.behaviour.kept_messages;
        let drops_it = is_full && self.breaks(Misbehaviour::DropsNewest);
        self.dropped_newest += u64::from(drops_it);
        !drops_it
    }

    /// Behaviour without a supervisor.
    pub(super) fn without_supervisor(&self) -> OnSupervisorLoss {
        if self.breaks(Misbehaviour::ReturnsWithoutSupervisor) {
            OnSupervisorLoss::Nominal
        } else {
            self.config.robot.on_supervisor_loss
        }
    }

    /// Whether to use an estimate.
    pub(super) fn accepts_estimate(&mut self, estimate: &Estimate) -> bool {
        match self.misbehaviour() {
            Some(Misbehaviour::TakesOldEstimates) => true,
            Some(Misbehaviour::KeepsFirstEstimate) => {
                let is_first = self.whiskers.iter().all(|whisker| whisker.estimated_mm.is_none());
                self.estimates.takes(estimate) && is_first
            }
            Some(_) | None => self.estimates.takes(estimate),
        }
    }

    /// Whether the fault ignores a valid message.
    pub(super) fn ignores(&self, message: &Message, payload: &[u8]) -> bool {
        // The re-encoded message has only the known fields.
        self.breaks(Misbehaviour::RefusesUnknownFields) && encode(message).len() < payload.len()
    }

    /// Handles an invalid message.
    pub(super) fn on_invalid(&mut self, out: &mut Vec<Outgoing>) {
        self.refused += 1;
        if self.breaks(Misbehaviour::RestartsOnMalformed) {
            self.restart(out);
        }
    }
}
