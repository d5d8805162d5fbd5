//! Messages that a robot sends.

use vibrissa_protocol::{ArrayFacts, PlaceKind, RobotTopic, WhiskerFacts, encode};
use vibrissa_robot::contract::{Facts, Moment};

use super::{Outgoing, Robot, RobotConfig};
use crate::journal::JournalEntry;
use crate::scenario::{ArrayScenario, Misbehaviour, WhiskerScenario};

impl Robot {
    /// Last will for the next connection, with the same boot id as its birth.
    #[must_use]
    pub fn will(&self, now_us: u64) -> Vec<u8> {
        let mut will = self.voice.will(now_us);
        if self.breaks(Misbehaviour::WillOfAnotherBoot) {
            will.boot_id = super::boot_id(self.seed, self.name(), self.start_us, u64::MAX);
        }
        encode(&will)
    }

    pub(super) fn birth(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        let birth = self.voice.birth(now_us);
        self.publish(RobotTopic::Connection, encode(&birth), out);
    }

    /// Number of contacts messages made in this boot; the sequence number of the next one.
    #[must_use]
    pub fn messages_made(&self) -> u64 {
        self.voice.contacts_made()
    }

    /// Last message before a clean disconnect.
    #[must_use]
    pub fn farewell(&mut self, now_us: u64) -> Vec<Outgoing> {
        let mut out = Vec::new();
        self.is_leaving = true;
        if !self.breaks(Misbehaviour::LeavesSilently) {
            self.publish(RobotTopic::Connection, encode(&self.voice.farewell(now_us)), &mut out);
        }
        out
    }

    pub(super) fn factsheet(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        if !self.connected {
            return;
        }
        let factsheet = self.voice.factsheet(now_us, &self.facts);
        self.publish(RobotTopic::Factsheet, encode(&factsheet), out);
    }

    pub(super) fn status(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        if !self.connected {
            return;
        }
        for whisker in &mut self.whiskers {
            whisker.reported = whisker.condition();
        }
        let whiskers: Vec<_> =
            self.whiskers.iter().filter(|one| !one.is_silent(now_us)).map(super::Whisker::status).collect();
        let dropped = self.messages_dropped();
        let mut status = self.voice.status(now_us, whiskers, dropped);
        if self.breaks(Misbehaviour::SkipsNumbers) && status.seq % 3 == 2 {
            status = self.voice.status(now_us, status.whiskers, dropped);
        }
        self.status_sent_us = now_us;
        self.status_at_us = now_us + (self.status_every_s() * 1e6) as u64;
        self.publish(RobotTopic::Status, self.status_as_sent(status), out);
    }

    /// Sends the waiting contacts as one message, which is stored until it is receipted.
    pub(super) fn flush(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        self.batch_until_us = None;
        if self.batch.is_empty() && self.missed.is_empty() {
            return;
        }
        let message = self.voice.contacts(std::mem::take(&mut self.batch), std::mem::take(&mut self.missed));
        let (seq, payload) = (message.seq, encode(&message));
        self.journal.write(|| JournalEntry::Felt(message));
        if !self.breaks(Misbehaviour::SendsOnce) && self.has_room() {
            self.outbox.keep(seq, payload.clone(), self.connected.then_some(Moment::of_us(now_us)));
        }
        if self.connected {
            for payload in self.link.pass(payload, now_us) {
                self.publish(RobotTopic::Contacts, payload, out);
            }
        }
    }

    pub(super) fn resend(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        let payloads = self.outbox.resend(Moment::of_us(now_us));
        for payload in self.resent_as_sent(payloads) {
            self.publish(RobotTopic::Contacts, payload, out);
        }
    }

    pub(super) fn publish(&self, topic: RobotTopic, payload: Vec<u8>, out: &mut Vec<Outgoing>) {
        if self.connected {
            out.push(Outgoing::Publish { topic, payload });
        }
    }
}

/// The facts of a robot's factsheet.
pub(super) fn facts(config: &RobotConfig) -> Facts {
    Facts {
        model: config.robot.model.clone(),
        on_supervisor_loss: config.robot.on_supervisor_loss,
        arrays: config.robot.arrays.iter().map(|array| array_facts(config, array)).collect(),
        touch_tests: config.behaviour.touch_tests.clone(),
        applies_gain: config.robot.applies_gain,
        air_control: config.behaviour.air_control,
        software: Vec::new(),
    }
}

fn array_facts(config: &RobotConfig, array: &ArrayScenario) -> ArrayFacts {
    ArrayFacts {
        array: array.array.clone(),
        array_type: array.array_type,
        task: config.behaviour.task,
        whiskers: array.whiskers.iter().map(|whisker| whisker_facts(config, whisker)).collect(),
    }
}

fn whisker_facts(config: &RobotConfig, whisker: &WhiskerScenario) -> WhiskerFacts {
    WhiskerFacts {
        whisker: whisker.whisker,
        x_mm: whisker.x_mm,
        y_mm: whisker.y_mm,
        model: config.model_name.clone(),
        length_mm: whisker.length_mm,
        length_tolerance_mm: whisker.length_tolerance_mm,
        pressure_mpa: whisker.pressure_mpa,
        pressure_max_mpa: whisker.pressure_max_mpa,
        neighbours: whisker.neighbours.clone(),
        place: Some(config.behaviour.places.kind()).filter(|kind| *kind != PlaceKind::Ratio),
        strain_max: whisker.strain_max,
    }
}
