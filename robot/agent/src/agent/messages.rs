//! Messages that answer nothing: births, factsheets, statuses, contacts.

use vibrissa_protocol::{Contacts, RobotTopic, encode};

use super::{Agent, Output};
use crate::contract::Now;
use crate::store::{Payload, Record};

/// Shortest time between status messages that report a change, in microseconds.
const STATUS_PAUSE_US: u64 = 100_000;

impl Agent {
    pub(super) fn publish(&self, topic: RobotTopic, payload: Vec<u8>, out: &mut Vec<Output>) {
        if self.connected {
            out.push(Output::Publish(topic, payload));
        }
    }

    /// Sends birth and factsheet.
    pub(super) fn announce(&mut self, now: Now, out: &mut Vec<Output>) {
        self.births.sent();
        let birth = self.voice.birth(now.stamp_us);
        let factsheet = self.voice.factsheet(now.stamp_us, &self.facts);
        out.push(Output::Store(self.boot_record()));
        self.publish(RobotTopic::Connection, encode(&birth), out);
        self.publish(RobotTopic::Factsheet, encode(&factsheet), out);
    }

    /// Answers a request for the factsheet. It may be one of an earlier boot that the supervisor misses.
    pub(super) fn factsheet_asked(&mut self, now: Now, out: &mut Vec<Output>) {
        if self.may_miss_a_boot(now) {
            return self.reboot(now, out);
        }
        self.tell_facts(now, out);
    }

    /// Sends the factsheet, if a broker is connected: each number is sent.
    pub(super) fn tell_facts(&mut self, now: Now, out: &mut Vec<Output>) {
        if self.connected {
            let factsheet = self.voice.factsheet(now.stamp_us, &self.facts);
            self.publish(RobotTopic::Factsheet, encode(&factsheet), out);
        }
    }

    pub(super) fn status(&mut self, now: Now, out: &mut Vec<Output>) {
        if !self.connected || self.unknown_until.is_some() {
            return;
        }
        for chamber in &mut self.chambers {
            chamber.reported = chamber.condition(now);
        }
        let whiskers = self.chambers.iter().map(|chamber| chamber.status(now)).collect();
        let status = self.voice.status(now.stamp_us, whiskers, self.messages_dropped());
        self.status_sent = now.at;
        self.status_at = now.at + self.limits.status_every_us;
        self.publish(RobotTopic::Status, encode(&status), out);
    }

    /// Ends the time in which nothing is known of the chambers: a status that comes before would report a fault of each.
    pub(super) fn know_chambers(&mut self, now: Now) {
        let Some(until) = self.unknown_until else { return };
        if now.at >= until || self.chambers.iter().all(|chamber| chamber.present_reading().is_some()) {
            self.unknown_until = None;
            self.status_at = now.at;
        }
    }

    /// Brings the next status forward if a condition differs from the last report.
    pub(super) fn report_change(&mut self, now: Now) {
        if self.chambers.iter().any(|chamber| chamber.condition(now) != chamber.reported) {
            self.status_at = self.status_at.min(now.at.max(self.status_sent + STATUS_PAUSE_US));
        }
    }

    /// Sends the waiting contacts as one message, which is stored until it is receipted.
    pub(super) fn flush(&mut self, now: Now, out: &mut Vec<Output>) {
        self.batch_until = None;
        if self.batch.is_empty() && self.missed.is_empty() {
            return;
        }
        let (contacts, missed) = (std::mem::take(&mut self.batch), std::mem::take(&mut self.missed));
        let message = self.alone(contacts, missed);
        if self.must_spool(encode(&message).len()) {
            return self.spool(&message, out);
        }
        let message: Contacts = self.voice.contacts(message.contacts, message.missed);
        let payload = encode(&message);
        if let Some(stored) = Payload::new(&payload) {
            let (boot_id, seq) = (message.boot_id, message.seq);
            out.push(Output::Store(Record::Contacts { boot_id, seq, payload: stored, spooled: None }));
        }
        self.outbox.keep(message.seq, payload.clone(), self.connected.then_some(now.at));
        self.make_room();
        self.publish(RobotTopic::Contacts, payload, out);
    }

    /// Sends unreceipted messages again, those of earlier boots first.
    pub(super) fn resend(&mut self, now: Now, out: &mut Vec<Output>) {
        let boots = self.earlier.iter_mut().map(|boot| &mut boot.outbox);
        for outbox in boots.chain([&mut self.outbox]) {
            if outbox.resend_at().is_some_and(|due| due <= now.at) {
                let payloads = outbox.resend(now.at);
                out.extend(payloads.into_iter().map(|payload| Output::Publish(RobotTopic::Contacts, payload)));
            }
        }
    }
}
