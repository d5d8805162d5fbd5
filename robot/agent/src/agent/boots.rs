//! Messages of earlier boots, which the store has kept over a restart.
//!
//! They are sent again with their own boot and number, so that a supervisor that has them already does not record them
//! twice. A supervisor takes contacts only of boots whose factsheet it knows, and a boot that another one has followed never
//! comes back. So the births and factsheets of earlier boots come before the first ones of the present boot, unless a receipt
//! has shown that a supervisor knows them. If none heard that, and one misses a factsheet later, the agent begins another boot
//! ([`Agent::reboot`]), before which it introduces them again. Messages of a boot that was never connected were never sent:
//! they get numbers of this boot.

use vibrissa_protocol::{BootId, Receipt, RobotTopic, TouchTestOutcome, decode_contacts, encode};

use super::{Agent, Output};
use crate::contract::{Commands, EstimateOrder, Now, Outbox, TouchTests, Voice};
use crate::store::{Payload, Record, StoredBoot};

/// Earlier boots whose messages are kept over a restart. A supervisor remembers the numbers of four boots: those, the present
/// one, and another one after [`Agent::reboot`].
const EARLIER_MAX: usize = 2;
/// Time since the first connection of a boot before which the agent does not begin another one: receipts may be on their way.
const REBOOT_AFTER_US: u64 = 5_000_000;

/// An earlier boot with messages.
#[derive(Debug)]
pub(super) struct Earlier {
    voice: Voice,
    is_known: bool,
    pub(super) outbox: Outbox,
}

impl Agent {
    /// Takes the messages of earlier boots up.
    pub(super) fn take_up(&mut self, boots: Vec<StoredBoot>) {
        let mut earlier = Vec::new();
        for boot in boots {
            if boot.births > 0 {
                let mut outbox = Outbox::new(self.limits.outbox_messages);
                for (seq, payload) in boot.messages {
                    outbox.keep(seq, payload.bytes().to_vec(), None);
                }
                let voice = Voice::earlier(boot.boot_id, boot.births, boot.factsheets);
                earlier.push(Earlier { voice, is_known: boot.is_known, outbox });
                continue;
            }
            for message in boot.messages.values() {
                // What another version has written may keep other rules.
                let Ok(message) = decode_contacts(message.bytes(), Vec::new()) else {
                    self.dropped_earlier += 1;
                    continue;
                };
                let message = self.voice.contacts(message.contacts, message.missed);
                self.outbox.keep(message.seq, encode(&message), None);
            }
        }
        let beyond = earlier.len().saturating_sub(EARLIER_MAX);
        self.dropped_earlier += earlier.drain(..beyond).map(|boot| boot.outbox.len() as u64).sum::<u64>();
        earlier.retain(|boot| !boot.outbox.is_empty());
        self.earlier = earlier;
        self.make_room();
    }

    /// Drops the oldest messages until the outbox keeps its bound in bytes.
    pub(super) fn make_room(&mut self) {
        let mut bytes = self.bytes_kept();
        while bytes > self.limits.outbox_bytes {
            let Some(oldest) = self.earlier.first_mut() else {
                let before = self.outbox.bytes();
                if !self.outbox.drop_oldest() {
                    return;
                }
                bytes -= before - self.outbox.bytes();
                continue;
            };
            let before = oldest.outbox.bytes();
            if oldest.outbox.drop_oldest() {
                self.dropped_earlier += 1;
                bytes -= before - oldest.outbox.bytes();
            } else {
                self.earlier.remove(0);
            }
        }
    }

    /// Takes a receipt for this boot or an earlier one.
    pub(super) fn receipt(&mut self, receipt: &Receipt, now: Now, out: &mut Vec<Output>) {
        if receipt.robot_boot_id == *self.voice.boot_id() {
            self.outbox.receipt(receipt, now.at);
        } else if let Some(boot) = self.earlier.iter_mut().find(|boot| *boot.voice.boot_id() == receipt.robot_boot_id) {
            boot.is_known = true;
            boot.outbox.receipt(receipt, now.at);
            self.earlier.retain(|boot| !boot.outbox.is_empty());
        } else {
            return;
        }
        let (boot_id, next, held) = (receipt.robot_boot_id.clone(), receipt.next, receipt.held.clone());
        out.push(Output::Store(Record::Receipt { boot_id, next, held }));
    }

    /// Publishes birth and factsheet of each earlier boot that the supervisor may not know.
    pub(super) fn announce_earlier(&mut self, now: Now, out: &mut Vec<Output>) {
        for boot in self.earlier.iter_mut().filter(|boot| !boot.is_known && !boot.outbox.is_empty()) {
            let birth = boot.voice.birth(now.stamp_us);
            let factsheet = boot.voice.factsheet(now.stamp_us, &self.facts);
            out.push(Output::Store(record_of(&boot.voice)));
            out.push(Output::Publish(RobotTopic::Connection, encode(&birth)));
            out.push(Output::Publish(RobotTopic::Factsheet, encode(&factsheet)));
        }
    }

    /// Whether the supervisor, which misses a factsheet, may miss that of an earlier boot.
    pub(super) fn may_miss_a_boot(&self, now: Now) -> bool {
        let is_over = self.introduced.is_some_and(|at| now.at >= at + REBOOT_AFTER_US);
        is_over && self.earlier.len() <= EARLIER_MAX && self.earlier.iter().any(|boot| !boot.is_known)
    }

    /// Begins another boot, as after a restart of the robot.
    pub(super) fn reboot(&mut self, now: Now, out: &mut Vec<Output>) {
        while !self.under_way.is_empty() {
            self.end_test(0, TouchTestOutcome::Failed, now, out);
        }
        self.flush(now, out);
        self.reboots += 1;
        let text = format!("{}-{}", self.first_boot_id, self.reboots);
        // A text that is too long could only come from a boot id that is no random one.
        let Ok(boot_id) = BootId::new(&text) else { return };
        let voice = std::mem::replace(&mut self.voice, Voice::new(boot_id));
        let outbox = std::mem::replace(&mut self.outbox, Outbox::new(self.limits.outbox_messages));
        self.dropped_earlier += outbox.dropped();
        if !outbox.is_empty() {
            self.earlier.push(Earlier { voice, is_known: outbox.newest_covered().is_some(), outbox });
        }
        self.commands = Commands::default();
        self.estimates = EstimateOrder::default();
        self.touch_tests = TouchTests::default();
        self.supervision.restart();
        self.births.sent();
        self.connected = false;
        self.introduced = None;
        for chamber in &mut self.chambers {
            chamber.restart();
        }
        out.push(Output::Store(self.boot_record()));
        out.push(Output::Reconnect);
    }

    /// The record of this boot.
    pub(super) fn boot_record(&self) -> Record {
        record_of(&self.voice)
    }

    /// Records of the whole state, with which the store begins anew.
    #[must_use]
    pub fn records(&self) -> Vec<Record> {
        let mut records = Vec::new();
        if let Some((segment, bytes)) = self.spooling.as_ref().and_then(|spooling| spooling.position) {
            records.push(Record::Spooled { segment, bytes });
        }
        for chamber in &self.chambers {
            if let Some((epoch, version)) = chamber.seen {
                records.push(Record::Seen { array: chamber.array.clone(), whisker: chamber.number, epoch, version });
            }
        }
        for boot in &self.earlier {
            add(&mut records, &boot.voice, &boot.outbox, boot.is_known);
        }
        add(&mut records, &self.voice, &self.outbox, self.outbox.newest_covered().is_some());
        records
    }
}

fn add(records: &mut Vec<Record>, voice: &Voice, outbox: &Outbox, is_known: bool) {
    records.push(record_of(voice));
    if is_known {
        // Nothing below the first stored message is needed again.
        let next = outbox.messages().next().map_or(0, |(seq, _)| seq);
        records.push(Record::Receipt { boot_id: voice.boot_id().clone(), next, held: Vec::new() });
    }
    for (seq, payload) in outbox.messages() {
        if let Some(payload) = Payload::new(payload) {
            records.push(Record::Contacts { boot_id: voice.boot_id().clone(), seq, payload, spooled: None });
        }
    }
}

fn record_of(voice: &Voice) -> Record {
    Record::Boot { boot_id: voice.boot_id().clone(), births: voice.births(), factsheets: voice.factsheets() }
}
