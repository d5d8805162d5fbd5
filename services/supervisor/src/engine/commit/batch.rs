//! The open batch of a worker: rows, journal entries and checkpoints of the next transaction, and the publications after
//! it.

use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::{Event, Outcome};
use vibrissa_core::units::Micros;
use vibrissa_protocol as protocol;

use crate::engine::commit::checkpoint::{CheckpointQueue, CheckpointRate};
use crate::engine::commit::journal::Journal;
use crate::engine::commit::transaction::{RobotShare, SealedTransaction};
use crate::engine::message::{MessageTimes, RawMessage};
use crate::engine::part::Part;
use crate::engine::robot::{Durable, KnownRobot, Robots};
use crate::log_inbox::LogRange;
use crate::outbox::Publication;
use vibrissa_store::Batch;

/// A contacts message with the number of its boot in the database.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) message: &'a protocol::Contacts,
    pub(crate) boot: i64,
}

/// Open batch of a worker: the effects of its steps since the last transaction was sealed.
#[derive(Debug, Default)]
pub(crate) struct OpenBatch {
    /// Number of the transaction that the batch becomes part of.
    number: i64,
    rows: Batch,
    journal: Journal,
    checkpoints: CheckpointQueue,
    publications: Vec<Publication>,
    /// A setpoint is among the publications, so the transaction must not wait.
    is_urgent: bool,
    /// The messages behind the rows, in case the database rejects the rows.
    messages: Vec<RawMessage>,
    /// The current messages are in a partitioned log, to which the journal refers.
    is_in_log: bool,
    /// Times of the `contacts` messages in the batch.
    times: Vec<MessageTimes>,
}

impl OpenBatch {
    /// Sets the number of the transaction that the batch becomes part of.
    pub(crate) fn set_number(&mut self, number: i64) {
        self.number = number;
    }

    /// Number of the transaction that the batch becomes part of.
    #[cfg(test)]
    pub(crate) fn number(&self) -> i64 {
        self.number
    }

    /// Sets whether the next messages are in a partitioned log. [`Self::refer`] must follow.
    pub(crate) fn set_in_log(&mut self, is_in_log: bool) {
        self.is_in_log = is_in_log;
    }

    /// Makes the messages of these records durable by a reference to the log.
    pub(crate) fn refer(&mut self, now: Micros, range: LogRange, part: Part, except: Vec<i64>) {
        self.journal.log(now, range, part, except);
    }

    /// Replaces the journalled ticks of single robots after `before` bytes of the journal by one of all.
    pub(crate) fn tick_all(&mut self, before: usize, now: Micros, part: Part) {
        self.journal.tick_all(before, now, part);
    }

    /// Rows of the transaction.
    pub(crate) fn rows(&self) -> &Batch {
        &self.rows
    }

    pub(crate) fn rows_mut(&mut self) -> &mut Batch {
        &mut self.rows
    }

    /// Adds a publication, which goes out after the commit.
    pub(crate) fn publish(&mut self, publication: Publication) {
        self.publications.push(Publication { transaction: self.number, ..publication });
    }

    /// Adds a setpoint, for which the commit must not wait.
    pub(crate) fn publish_setpoint(&mut self, publication: Publication) {
        self.publish(publication);
        self.is_urgent = true;
    }

    /// Takes the publications without a commit, for a fault planted by a test.
    pub(crate) fn take_publications(&mut self) -> Vec<Publication> {
        std::mem::take(&mut self.publications)
    }

    /// Adds a message that has changed a robot.
    pub(crate) fn push_message(&mut self, message: RawMessage) {
        self.messages.push(message);
    }

    /// Removes the messages that do not fit a condition.
    pub(crate) fn retain_messages(&mut self, fits: impl FnMut(&RawMessage) -> bool) {
        self.messages.retain(fits);
    }

    pub(crate) fn push_times(&mut self, times: MessageTimes) {
        self.times.push(times);
    }

    /// Makes a step durable: by a journal entry, if a replay of the event leads to the same state without any decision,
    /// or else by a checkpoint. `is_ordinary` is true if all effects are.
    pub(crate) fn make_durable(
        &mut self,
        known: &mut KnownRobot,
        now: Micros,
        event: &Event<'_>,
        source: Option<Source<'_>>,
        outcome: Outcome,
        is_ordinary: bool,
    ) {
        if known.durable == Durable::NextCheckpoint {
            return;
        }
        // A message with an implausible time has changed the estimate of the robot's clock, too.
        let is_taken = matches!(outcome, Outcome::Taken | Outcome::BadTime);
        // The journal has neither missed touches nor contacts of tests or beyond the gauge's range.
        let is_special = matches!(event, Event::Contacts { contacts, missed, .. }
            if !missed.is_empty() || contacts.iter().any(|contact| contact.is_test || contact.saturated));
        let is_journalled = is_ordinary
            && !is_special
            && known.durable != Durable::BeforeTakeover
            && match event {
                // A contacts message that is not accepted can also give up a gap.
                Event::Contacts { boot_id, .. } if is_taken || known.robot.has_gap(boot_id) => {
                    let source = source.filter(|_| is_taken);
                    if self.is_in_log {
                        self.journal.count(source.map_or(0, |source| source.message.contacts.len()));
                    } else {
                        self.journal.contacts(known, now, event, source.map(|source| source.message));
                    }
                    true
                }
                Event::Status { .. } if is_taken && known.robot.is_settled() => {
                    if !self.is_in_log {
                        self.journal.status(known, now, event);
                    }
                    true
                }
                Event::Tick if matches!(known.durable, Durable::Journal(_)) => {
                    self.journal.tick(known, now);
                    true
                }
                // The state has not changed.
                _ if !is_taken => return,
                Event::Contacts { .. }
                | Event::Status { .. }
                | Event::Tick
                | Event::Connection { .. }
                | Event::Factsheet { .. }
                | Event::Setpoint { .. }
                | Event::TouchTest { .. }
                | Event::Operator(_)
                | Event::PolicyChanged => false,
            };
        if !is_journalled {
            if known.robot.has_changed() {
                self.checkpoint(known);
            }
        } else if known.durable == Durable::Checkpoint {
            known.durable = Durable::Journal(self.number);
            self.checkpoints.push(self.number, now, &known.name);
        }
    }

    /// Makes the batch write a checkpoint of the robot.
    pub(crate) fn checkpoint(&mut self, known: &mut KnownRobot) {
        if known.durable != Durable::NextCheckpoint {
            known.durable = Durable::NextCheckpoint;
            self.checkpoints.push_next(&known.name, known.whisker_ids.len());
        }
    }

    /// Counts the whiskers of a robot that has a new layout, and whose checkpoint the batch must write.
    pub(crate) fn count_layout(&mut self, whiskers: usize) {
        self.checkpoints.count_layout(whiskers);
    }

    /// Checkpoints that the batch must write, and those that may wait.
    pub(crate) fn checkpoints(&mut self) -> &mut CheckpointQueue {
        &mut self.checkpoints
    }

    /// Adds the checkpoints that the transaction must contain because of decisions.
    pub(crate) fn write_decided_checkpoints(&mut self, robots: &mut Robots, rate: &mut CheckpointRate) {
        self.checkpoints.write_decided(robots, self.number, &mut self.rows, rate);
    }

    /// Adds waiting checkpoints that are due, as far as the rate allows.
    pub(crate) fn write_due_checkpoints(&mut self, robots: &mut Robots, now: Micros, rate: &mut CheckpointRate) {
        self.checkpoints.write_due(robots, (self.number, now), &mut self.rows, rate);
    }

    /// Seals the open batch by appending it to those of other workers.
    pub(crate) fn seal_into(&mut self, transaction: &mut SealedTransaction) {
        transaction.rows.append(&mut self.rows);
        transaction.publications.append(&mut self.publications);
        transaction.messages.append(&mut self.messages);
        transaction.times.append(&mut self.times);
        self.is_urgent = false;
        let (entries, contacts) = self.journal.take();
        transaction.append_entries(entries, contacts);
    }

    /// Removes a robot's rows and publications. Its journal entries and messages are only in the batch of its own worker.
    pub(crate) fn remove_rows(&mut self, share: &RobotShare) {
        share.remove_rows(&mut self.rows);
        share.remove_publications(&mut self.publications);
    }

    /// Removes a robot's journal entries and messages, and returns the messages.
    pub(crate) fn remove_messages(&mut self, share: &RobotShare) -> Vec<RawMessage> {
        self.journal.remove(share.robot_id());
        share.take_messages(&mut self.messages)
    }

    /// Whether there is nothing to commit or to publish.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty() && self.journal.is_empty() && self.publications.is_empty() && self.checkpoints.is_empty()
    }

    /// Whether a setpoint waits for the commit.
    pub(crate) fn is_urgent(&self) -> bool {
        self.is_urgent
    }

    /// Size of the journal entries in bytes.
    pub(crate) fn journal_bytes(&self) -> usize {
        self.journal.bytes()
    }

    pub(crate) fn message_count(&self) -> usize {
        self.messages.len()
    }

    /// Largest number of whiskers in the checkpoints that the transaction must write.
    pub(crate) fn decided_whiskers(&self) -> usize {
        self.checkpoints.next_whiskers()
    }
}

/// Whether an effect can be skipped when the event is replayed: its row or request is done, and it changes no state of
/// other parts.
pub(crate) fn is_ordinary(effect: &Effect) -> bool {
    matches!(effect, Effect::Contact(_) | Effect::Response(_) | Effect::AskForFactsheet | Effect::BadTime { .. })
}
