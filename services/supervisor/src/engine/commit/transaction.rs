//! A sealed transaction on its way to the database.

use std::collections::{BTreeSet, HashMap};

use vibrissa_protocol::Name;

use crate::engine::message::{MessageTimes, RawMessage};
use crate::outbox::Publication;
use crate::trace::PendingSpans;
use vibrissa_store::Batch;
use vibrissa_store::batch::{JournalRow, Owner, Owners, Record};

/// A sealed transaction.
#[derive(Default)]
pub(crate) struct SealedTransaction {
    /// Number of the transaction in the fleet's journal.
    pub(in crate::engine) number: i64,
    pub(in crate::engine) rows: Batch,
    pub(in crate::engine) publications: Vec<Publication>,
    /// The messages behind the rows.
    pub(in crate::engine) messages: Vec<RawMessage>,
    pub(in crate::engine) times: Vec<MessageTimes>,
    /// Spans of the transaction, by worker.
    pub(in crate::engine) spans: Vec<PendingSpans>,
    /// Actions whose answers are in the rows.
    pub(in crate::engine) answered: Vec<i64>,
    /// Number of contacts in the journal entries.
    pub(in crate::engine) journal_contacts: usize,
    /// Number of received messages that wait for its commit.
    pub(in crate::engine) received: u64,
}

impl SealedTransaction {
    /// A transaction without any content.
    pub(crate) fn new(number: i64, answered: Vec<i64>) -> Self {
        Self { number, answered, ..Self::default() }
    }

    /// Number of the transaction in the fleet's journal.
    pub(crate) fn number(&self) -> i64 {
        self.number
    }

    /// Adds the spans of a worker's steps.
    pub(crate) fn push_spans(&mut self, spans: PendingSpans) {
        self.spans.push(spans);
    }

    /// Adds a worker's journal entries, which contain `contacts` contacts.
    pub(in crate::engine) fn append_entries(&mut self, entries: Vec<u8>, contacts: usize) {
        self.journal_contacts += contacts;
        if entries.is_empty() {
            return;
        }
        match &mut self.rows.journal {
            Some(row) => row.entries.extend_from_slice(&entries),
            None => self.rows.journal = Some(JournalRow { number: self.number, entries }),
        }
    }

    /// Whether there is nothing to write or to publish.
    pub(in crate::engine) fn is_empty(&self) -> bool {
        self.rows.is_empty() && self.publications.is_empty()
    }

    /// Whether a robot would move by one of the publications.
    pub(in crate::engine) fn has_moves(&self) -> bool {
        self.publications.iter().any(Publication::moves)
    }

    /// Removes the publications by which robots would move.
    pub(in crate::engine) fn withhold_moves(&mut self) {
        self.publications.retain(|publication| !publication.moves());
    }

    /// Takes the actions whose answers are committed with the rows.
    pub(crate) fn take_answered(&mut self) -> Vec<i64> {
        std::mem::take(&mut self.answered)
    }

    /// Whether there are rows that live pages show.
    pub(crate) fn has_records(&self) -> bool {
        !self.rows.records.is_empty()
    }

    /// Whether there are events for other programs.
    pub(crate) fn has_events(&self) -> bool {
        !self.rows.events.is_empty()
    }

    /// Removes a robot whose rows the database has left out, and returns its messages. Actions whose answers were left
    /// out are pending again.
    pub(crate) fn remove_rejected(&mut self, share: &RobotShare) -> Vec<RawMessage> {
        share.remove_publications(&mut self.publications);
        let committed = answers(&self.rows.records);
        self.answered.retain(|action_id| committed.contains(action_id));
        share.take_messages(&mut self.messages)
    }

    #[cfg(test)]
    pub(crate) fn into_rows(self) -> Batch {
        self.rows
    }
}

/// Ids of the actions that are answered in these rows.
pub(crate) fn answers(records: &[Record]) -> BTreeSet<i64> {
    let mut ids = BTreeSet::new();
    for record in records {
        if let Record::Answer { action_id, .. } = record {
            ids.insert(*action_id);
        }
    }
    ids
}

/// Selects a robot's share of a transaction.
pub(crate) struct RobotShare {
    robot: Name,
    robot_id: i64,
    owners: Owners,
}

impl RobotShare {
    /// The share of a robot with these whiskers.
    pub(crate) fn of(robot: &Name, robot_id: i64, whisker_ids: &[i64]) -> Self {
        let whiskers: HashMap<i64, i64> = whisker_ids.iter().map(|&whisker_id| (whisker_id, robot_id)).collect();
        Self { robot: robot.clone(), robot_id, owners: Owners { whiskers, ..Owners::default() } }
    }

    pub(super) fn robot_id(&self) -> i64 {
        self.robot_id
    }

    pub(super) fn remove_rows(&self, rows: &mut Batch) {
        rows.retain(&self.owners, |owner| owner != Owner::Robot(self.robot_id));
    }

    pub(super) fn remove_publications(&self, publications: &mut Vec<Publication>) {
        publications.retain(|publication| publication.robot != self.robot);
    }

    pub(super) fn take_messages(&self, messages: &mut Vec<RawMessage>) -> Vec<RawMessage> {
        messages.extract_if(.., |message| message.robot == self.robot).collect()
    }
}
