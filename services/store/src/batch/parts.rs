//! A batch grouped by the owners of its rows: each owner's rows are adjacent, so that any range of owners can be written alone.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::ops::Range;

use super::{Batch, ContactRow, EventRow, JournalRow, LayoutRow, Record, ResponseRow, RobotRow, RollupRow, WhiskerRow};

/// The owner of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Owner {
    /// The fleet: a policy or a calibration belongs to no robot.
    Fleet,
    /// The robot with this number in the database.
    Robot(i64),
    /// A message in quarantine. It has its own owner, so that only this row is lost if the database refuses it, too.
    Quarantine,
}

/// Robots of the rows that do not name their robot.
#[derive(Debug, Default)]
pub struct Owners {
    /// Numbers of robots by `whisker_id`.
    pub whiskers: HashMap<i64, i64>,
    /// Numbers of robots by `action_id`.
    pub actions: HashMap<i64, i64>,
    /// Numbers of robots by `command_id`.
    pub commands: HashMap<String, i64>,
}

impl Owners {
    fn robot(robot_id: i64) -> Owner {
        if robot_id == 0 { Owner::Fleet } else { Owner::Robot(robot_id) }
    }

    fn event(event: &EventRow) -> Owner {
        Self::robot(event.robot_id.unwrap_or_default())
    }

    /// The upper 32 bits of the number of a trim or compensation are its robot's number.
    fn compensation(compensation_id: i64) -> Owner {
        Self::robot(compensation_id >> 32)
    }

    fn whisker(&self, whisker_id: i64) -> Owner {
        Self::robot(self.whiskers.get(&whisker_id).copied().unwrap_or_default())
    }

    fn record(&self, record: &Record) -> Owner {
        match record {
            Record::Health(row) => self.whisker(row.whisker_id),
            Record::Alarm(row) => self.whisker(row.whisker_id),
            Record::AlarmCleared(row) => self.whisker(row.whisker_id),
            Record::Trim(row) => Self::robot(row.robot_id),
            Record::Decision(row) => Self::robot(row.robot_id),
            Record::Setpoint(row) => Self::robot(row.robot_id),
            Record::Ended(row) => Self::compensation(row.compensation_id),
            Record::Error(row) => Self::compensation(row.compensation_id),
            Record::Refinement(row) => Self::compensation(row.compensation_id),
            Record::Approved { compensation_id } => Self::compensation(*compensation_id),
            Record::Gone { robot_id, .. }
            | Record::AlarmsForgotten { robot_id, .. }
            | Record::Decommissioned { robot_id, .. } => Self::robot(*robot_id),
            Record::SetpointState(row) if row.robot_id != 0 => Self::robot(row.robot_id),
            Record::SetpointState(row) => Self::robot(self.commands.get(&row.command_id).copied().unwrap_or_default()),
            Record::Answer { robot_id, .. } if *robot_id != 0 => Self::robot(*robot_id),
            Record::Answer { action_id, .. } => Self::robot(self.actions.get(action_id).copied().unwrap_or_default()),
            Record::TouchTest(row) => Self::robot(row.robot_id),
            Record::TouchTestProgress(row) => Self::robot(row.robot_id),
            Record::TestOfAction { robot_id, .. } => Self::robot(*robot_id),
            Record::RobotAlarm(row) => Self::robot(row.robot_id),
            Record::RobotAlarmCleared(row) => Self::robot(row.robot_id),
            Record::Activation(_) | Record::Policy(_) | Record::Rollout(_) => Owner::Fleet,
            Record::Quarantined(_) => Owner::Quarantine,
        }
    }
}

/// The rows of a range of owners; the fields are those of [`Batch`].
#[derive(Debug, Clone, Copy)]
pub struct Rows<'b> {
    /// New layouts.
    pub layouts: &'b [LayoutRow],
    /// Checkpoints of robots.
    pub robots: &'b [RobotRow],
    /// Checkpoints of whiskers.
    pub whiskers: &'b [WhiskerRow],
    /// Contacts that are stored as single rows.
    pub contacts: &'b [ContactRow],
    /// Aggregates of minutes and hours that have ended.
    pub rollups: &'b [RollupRow],
    /// Responses of compensators.
    pub responses: &'b [ResponseRow],
    /// All other rows, in their order.
    pub records: &'b [Record],
    /// Events for the log.
    pub events: &'b [EventRow],
}

/// Number of kinds of rows; a kind is an index into `ends`.
const KINDS: usize = 8;

impl Batch {
    /// Removes the rows of some owners. The journal is not touched.
    pub fn retain(&mut self, owners: &Owners, stays: impl Fn(Owner) -> bool) {
        self.layouts.retain(|row| stays(Owners::robot(row.robot_id)));
        self.robots.retain(|row| stays(Owners::robot(row.robot_id)));
        self.whiskers.retain(|row| stays(owners.whisker(row.whisker_id)));
        self.contacts.retain(|row| stays(owners.whisker(row.whisker_id)));
        self.rollups.retain(|row| stays(owners.whisker(row.whisker_id)));
        self.responses.retain(|row| stays(Owners::compensation(row.compensation_id)));
        self.records.retain(|row| stays(owners.record(row)));
        self.events.retain(|row| stays(Owners::event(row)));
    }
}

/// A batch whose rows of each kind are sorted by owner.
pub(crate) struct Parts<'o> {
    batch: Batch,
    of: &'o Owners,
    owners: Vec<Owner>,
    /// For each owner and kind, the end of the owner's rows among those of the kind.
    ends: Vec<[usize; KINDS]>,
    journal_number: Option<i64>,
    /// Serialized journal entries, by owner.
    journal: BTreeMap<Owner, Vec<u8>>,
}

impl<'o> Parts<'o> {
    /// Sorts a batch by owner; the rows of one owner keep their order.
    pub(crate) fn of(mut batch: Batch, of: &'o Owners, split_journal: impl Fn(&[u8]) -> Vec<(i64, Vec<u8>)>) -> Self {
        // A setpoint in this batch is not in the database yet: its states get their robot from it.
        let mut own: HashMap<String, i64> = HashMap::new();
        for record in &batch.records {
            if let Record::Setpoint(row) = record {
                own.insert(row.command_id.clone(), row.robot_id);
            }
        }
        for record in &mut batch.records {
            if let Record::SetpointState(row) = record
                && row.robot_id == 0
            {
                row.robot_id = own.get(&row.command_id).copied().unwrap_or_default();
            }
        }
        let journal_row = batch.journal.take();
        let journal_number = journal_row.as_ref().map(|row| row.number);
        let mut journal: BTreeMap<Owner, Vec<u8>> = BTreeMap::new();
        for (robot_id, entries) in journal_row.map(|row| split_journal(&row.entries)).unwrap_or_default() {
            journal.entry(Owners::robot(robot_id)).or_default().extend(entries);
        }
        let mut all: BTreeSet<Owner> = journal.keys().copied().collect();
        let mut sort = Sort { all: &mut all };
        let kinds: [Vec<Owner>; KINDS] = [
            sort.by(&mut batch.layouts, |row| Owners::robot(row.robot_id)),
            sort.by(&mut batch.robots, |row| Owners::robot(row.robot_id)),
            sort.by(&mut batch.whiskers, |row| of.whisker(row.whisker_id)),
            sort.by(&mut batch.contacts, |row| of.whisker(row.whisker_id)),
            sort.by(&mut batch.rollups, |row| of.whisker(row.whisker_id)),
            sort.by(&mut batch.responses, |row| Owners::compensation(row.compensation_id)),
            sort.by(&mut batch.records, |row| of.record(row)),
            sort.by(&mut batch.events, Owners::event),
        ];
        let owners: Vec<Owner> = all.into_iter().collect();
        let end_of = |owner: Owner| std::array::from_fn(|kind| kinds[kind].partition_point(|other| *other <= owner));
        let ends = owners.iter().map(|&owner| end_of(owner)).collect();
        Self { batch, of, owners, ends, journal_number, journal }
    }

    /// Number of owners.
    pub(crate) fn len(&self) -> usize {
        self.owners.len()
    }

    /// The owner at an index.
    pub(crate) fn owner(&self, index: usize) -> Owner {
        self.owners[index]
    }

    /// The rows of a range of owners.
    pub(crate) fn rows(&self, range: Range<usize>) -> Rows<'_> {
        let at = |kind: usize| {
            let end = |index: usize| index.checked_sub(1).map_or(0, |last| self.ends[last][kind]);
            end(range.start)..end(range.end)
        };
        Rows {
            layouts: &self.batch.layouts[at(0)],
            robots: &self.batch.robots[at(1)],
            whiskers: &self.batch.whiskers[at(2)],
            contacts: &self.batch.contacts[at(3)],
            rollups: &self.batch.rollups[at(4)],
            responses: &self.batch.responses[at(5)],
            records: &self.batch.records[at(6)],
            events: &self.batch.events[at(7)],
        }
    }

    /// Number of the batch's journal row, if it has one.
    pub(crate) fn journal_number(&self) -> Option<i64> {
        self.journal_number
    }

    /// The journal entries of a range of owners.
    pub(crate) fn journal(&self, range: Range<usize>) -> Vec<u8> {
        let entries = self.owners[range].iter().filter_map(|owner| self.journal.get(owner));
        entries.flat_map(|entries| entries.iter().copied()).collect()
    }

    /// The batch; only its fields other than rows may be used.
    pub(crate) fn rest(&self) -> &Batch {
        &self.batch
    }

    /// Turns this back into a batch, without the rows and journal entries of the owners in `left_out`.
    pub(crate) fn without(mut self, left_out: &HashSet<Owner>) -> Batch {
        self.batch.retain(self.of, |owner| !left_out.contains(&owner));
        if let Some(number) = self.journal_number {
            let stays = self.journal.iter().filter(|(owner, _)| !left_out.contains(owner));
            let entries: Vec<u8> = stays.flat_map(|(_, entries)| entries.iter().copied()).collect();
            self.batch.journal = (!entries.is_empty()).then_some(JournalRow { number, entries });
        }
        self.batch
    }
}

/// Sorts rows by owner, and collects all owners.
struct Sort<'a> {
    all: &'a mut BTreeSet<Owner>,
}

impl Sort<'_> {
    /// Sorts rows by owner; returns their owners in the new order.
    fn by<T>(&mut self, rows: &mut [T], owner_of: impl Fn(&T) -> Owner) -> Vec<Owner> {
        rows.sort_by_cached_key(|row| owner_of(row));
        let owners: Vec<Owner> = rows.iter().map(owner_of).collect();
        self.all.extend(owners.iter().copied());
        owners
    }
}
