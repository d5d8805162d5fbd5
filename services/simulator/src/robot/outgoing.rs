//! Messages that a robot sends.

use vibrissa_protocol::{
    ArrayFacts, Connection, ConnectionState, Contacts, Factsheet, PlaceKind, RobotTopic, Status, Timestamp,
    WhiskerFacts, encode,
};

use super::Robot;
use crate::journal::JournalEntry;
use crate::scenario::{ArrayScenario, Misbehaviour, WhiskerScenario};

/// Calibration in the factsheet: the built-in one, from which each whisker deviates slightly.
const WHISKER_MODEL: &str = "nguyen-2021";

/// Action for the network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// Publish on one of the robot's topics, with that topic's quality of service and retain flag.
    Publish {
        /// Topic of the message.
        topic: RobotTopic,
        /// Encoded message.
        payload: Vec<u8>,
    },
    /// The robot has restarted: cut the connection without a farewell, then connect again.
    Restart,
}

/// Next `seq` of each topic in the present boot.
#[derive(Debug, Default)]
pub(super) struct Sequences {
    /// That of the next birth; the will or farewell of the connection has the number after it.
    connection: u64,
    factsheet: u64,
    contacts: u64,
    status: u64,
    setpoint_state: u64,
    test_state: u64,
}

impl Sequences {
    fn take(counter: &mut u64) -> u64 {
        let seq = *counter;
        *counter += 1;
        seq
    }

    pub(super) fn setpoint_state(&mut self) -> u64 {
        Self::take(&mut self.setpoint_state)
    }

    pub(super) fn test_state(&mut self) -> u64 {
        Self::take(&mut self.test_state)
    }
}

impl Robot {
    /// Last will for the next connection, with the same boot id as its birth.
    #[must_use]
    pub fn will(&self, now_us: u64) -> Vec<u8> {
        let mut will = self.connection(self.sequences.connection + 1, now_us, ConnectionState::ConnectionBroken);
        if self.breaks(Misbehaviour::WillOfAnotherBoot) {
            will.boot_id = super::boot_id(self.seed, self.name(), self.start_us, u64::MAX);
        }
        encode(&will)
    }

    pub(super) fn birth(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        let birth = self.connection(self.sequences.connection, now_us, ConnectionState::Online);
        self.sequences.connection += 2;
        self.publish(RobotTopic::Connection, encode(&birth), out);
    }

    /// Number of contacts messages made in this boot; the sequence number of the next one.
    #[must_use]
    pub fn messages_made(&self) -> u64 {
        self.sequences.contacts
    }

    /// Last message before a clean disconnect.
    #[must_use]
    pub fn farewell(&mut self, now_us: u64) -> Vec<Outgoing> {
        let mut out = Vec::new();
        let seq = self.sequences.connection.saturating_sub(1);
        let farewell = self.connection(seq, now_us, ConnectionState::Offline);
        self.publish(RobotTopic::Connection, encode(&farewell), &mut out);
        out
    }

    fn connection(&self, seq: u64, now_us: u64, state: ConnectionState) -> Connection {
        Connection { boot_id: self.boot_id.clone(), seq, timestamp: Timestamp(now_us), state }
    }

    pub(super) fn factsheet(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        if !self.connected {
            return;
        }
        let factsheet = Factsheet {
            boot_id: self.boot_id.clone(),
            seq: Sequences::take(&mut self.sequences.factsheet),
            timestamp: Timestamp(now_us),
            model: self.config.robot.model.clone(),
            on_supervisor_loss: self.config.robot.on_supervisor_loss,
            arrays: self.config.robot.arrays.iter().map(|array| self.array_facts(array)).collect(),
            touch_tests: self.config.behaviour.touch_tests.clone(),
        };
        self.publish(RobotTopic::Factsheet, encode(&factsheet), out);
    }

    pub(super) fn status(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        if !self.connected {
            return;
        }
        for whisker in &mut self.whiskers {
            whisker.reported = whisker.condition();
        }
        if self.breaks(Misbehaviour::SkipsNumbers) && self.sequences.status % 3 == 2 {
            self.sequences.status += 1;
        }
        let dropped = self.outbox.dropped();
        let status = Status {
            boot_id: self.boot_id.clone(),
            seq: Sequences::take(&mut self.sequences.status),
            t_us: now_us,
            whiskers: self.whiskers.iter().filter(|one| !one.is_silent(now_us)).map(super::Whisker::status).collect(),
            contacts_dropped: (dropped > 0).then_some(dropped),
        };
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
        let seq = Sequences::take(&mut self.sequences.contacts);
        let (contacts, missed) = (std::mem::take(&mut self.batch), std::mem::take(&mut self.missed));
        let message = Contacts { boot_id: self.boot_id.clone(), seq, contacts, missed };
        let payload = encode(&message);
        self.journal.write(|| JournalEntry::Felt(message));
        if !self.breaks(Misbehaviour::SendsOnce) {
            self.outbox.keep(seq, payload.clone(), self.connected.then_some(now_us));
        }
        if self.connected {
            for payload in self.link.pass(payload, now_us) {
                self.publish(RobotTopic::Contacts, payload, out);
            }
        }
    }

    pub(super) fn resend(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        let payloads = self.outbox.resend(now_us);
        for payload in self.resent_as_sent(payloads) {
            self.publish(RobotTopic::Contacts, payload, out);
        }
    }

    pub(super) fn publish(&self, topic: RobotTopic, payload: Vec<u8>, out: &mut Vec<Outgoing>) {
        if self.connected {
            out.push(Outgoing::Publish { topic, payload });
        }
    }

    fn array_facts(&self, array: &ArrayScenario) -> ArrayFacts {
        let behaviour = &self.config.behaviour;
        let place = Some(behaviour.places.kind()).filter(|kind| *kind != PlaceKind::Ratio);
        let whiskers = array.whiskers.iter().map(|whisker| WhiskerFacts { place, ..whisker_facts(whisker) });
        ArrayFacts {
            array: array.array.clone(),
            array_type: array.array_type,
            task: behaviour.task,
            whiskers: whiskers.collect(),
        }
    }
}

fn whisker_facts(whisker: &WhiskerScenario) -> WhiskerFacts {
    WhiskerFacts {
        whisker: whisker.whisker,
        x_mm: whisker.x_mm,
        y_mm: whisker.y_mm,
        model: WHISKER_MODEL.to_owned(),
        length_mm: whisker.length_mm,
        pressure_mpa: whisker.pressure_mpa,
        pressure_max_mpa: whisker.pressure_max_mpa,
        neighbours: whisker.neighbours.clone(),
        place: None,
    }
}
