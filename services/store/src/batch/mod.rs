//! The rows of one transaction, in the order in which they must be written.

mod compensation;
mod event;
mod parts;
mod policy;
mod record;
mod rows;
mod touch_test;

pub use compensation::*;
pub use event::*;
pub(crate) use parts::Parts;
pub use parts::{Owner, Owners, Rows};
pub use policy::{PolicyChanged, PolicyRow};
pub use record::*;
pub use rows::*;
pub use touch_test::*;

pub use crate::row::Interval;

use crate::LogPositions;

/// All rows that follow from a batch of messages, and the journal.
#[derive(Debug, Default)]
pub struct Batch {
    /// New layouts. Their whiskers that are on the robot now are among `whiskers`.
    pub layouts: Vec<LayoutRow>,
    /// Checkpoints of robots.
    pub robots: Vec<RobotRow>,
    /// Checkpoints of whiskers.
    pub whiskers: Vec<WhiskerRow>,
    /// Contacts that are stored as single rows.
    pub contacts: Vec<ContactRow>,
    /// Aggregates of minutes and hours that have ended.
    pub rollups: Vec<RollupRow>,
    /// Responses of compensators at single contacts; written after the compensations that they refer to.
    pub responses: Vec<ResponseRow>,
    /// All other rows, in their order.
    pub records: Vec<Record>,
    /// Events for the log, in their order.
    pub events: Vec<EventRow>,
    /// Journal entries of robots whose checkpoints are not among `robots`.
    pub journal: Option<JournalRow>,
    /// Journal rows up to this number are contained in the checkpoints and can be deleted.
    pub journal_done: Option<i64>,
    /// Positions in the partitioned log that change; none without a log.
    pub log: LogPositions,
}

impl Batch {
    /// Whether there is nothing to write.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.layouts.is_empty()
            && self.robots.is_empty()
            && self.whiskers.is_empty()
            && self.contacts.is_empty()
            && self.rollups.is_empty()
            && self.responses.is_empty()
            && self.records.is_empty()
            && self.events.is_empty()
            && self.journal.is_none()
            && self.journal_done.is_none()
    }

    /// All rows except the journal.
    pub(crate) fn rows(&self) -> Rows<'_> {
        Rows {
            layouts: &self.layouts,
            robots: &self.robots,
            whiskers: &self.whiskers,
            contacts: &self.contacts,
            rollups: &self.rollups,
            responses: &self.responses,
            records: &self.records,
            events: &self.events,
        }
    }

    /// The whiskers that rows refer to, possibly several times.
    pub(crate) fn whisker_ids(&self) -> impl Iterator<Item = i64> {
        let records = self.records.iter().filter_map(|record| match record {
            Record::Health(row) => Some(row.whisker_id),
            Record::Alarm(row) => Some(row.whisker_id),
            Record::AlarmCleared(row) => Some(row.whisker_id),
            Record::Trim(_)
            | Record::Decision(_)
            | Record::Ended(_)
            | Record::Setpoint(_)
            | Record::SetpointState(_)
            | Record::Error(_)
            | Record::Refinement(_)
            | Record::Activation(_)
            | Record::Approved { .. }
            | Record::Gone { .. }
            | Record::Answer { .. }
            | Record::Policy(_)
            | Record::AlarmsForgotten { .. }
            | Record::Decommissioned { .. }
            | Record::Quarantined(_)
            | Record::TouchTest(_)
            | Record::TouchTestProgress(_)
            | Record::TestOfAction { .. }
            | Record::RobotAlarm(_)
            | Record::RobotAlarmCleared(_)
            | Record::Rollout(_) => None,
        });
        let whiskers = self.whiskers.iter().map(|row| row.whisker_id);
        let contacts = self.contacts.iter().map(|row| row.whisker_id);
        let rollups = self.rollups.iter().map(|row| row.whisker_id);
        whiskers.chain(contacts).chain(rollups).chain(records)
    }

    /// As [`Self::append`], for a batch that is not used any more.
    pub fn append_all(&mut self, mut other: Self) {
        self.append(&mut other);
    }

    /// Appends the rows of another batch. The journal is not touched: there is one for the whole transaction.
    pub fn append(&mut self, other: &mut Self) {
        self.layouts.append(&mut other.layouts);
        self.robots.append(&mut other.robots);
        self.whiskers.append(&mut other.whiskers);
        self.contacts.append(&mut other.contacts);
        self.rollups.append(&mut other.rollups);
        self.responses.append(&mut other.responses);
        self.records.append(&mut other.records);
        self.events.append(&mut other.events);
    }
}
