//! Checkpoints, which are rows with a robot's state: written at once after a decision, and otherwise from time to time,
//! so that the journal stays short.

use std::collections::VecDeque;

use tracing::error;
use vibrissa_core::robot::event::Link;
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_edge::words::Word;
use vibrissa_protocol::{Name, Segmenter};

use crate::engine::robot::{Durable, KnownRobot, Robots};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::Batch;
use vibrissa_store::batch::{Interval, RobotRow, WhiskerRow};

/// Age of a robot's first journal entry at which its checkpoint is due; it may be later if many are due.
const AFTER: Micros = Micros(2_000_000);
/// The same if a partitioned log has the messages: a checkpoint costs far more than a reference to the log,
const AFTER_WITH_LOG: Micros = Micros(60_000_000);
/// as long as the journal refers to at most this many contacts, so that a replay takes only some seconds.
const CONTACTS_WITH_LOG: usize = 1_000_000;

/// Age of a robot's first journal entry at which its checkpoint is due.
pub(crate) fn due_after(has_log: bool, contacts_in_journal: usize) -> Micros {
    if has_log && contacts_in_journal < CONTACTS_WITH_LOG { AFTER_WITH_LOG } else { AFTER }
}
/// Rate of whiskers' checkpoints without a decision, per second,
const WHISKERS_PER_S: f64 = 2_000.0;
/// and increase of the rate per contact in the journal, so that a replay of the journal never takes more than some
/// seconds.
const WHISKERS_PER_S_A_CONTACT: f64 = 2e-3;
/// Largest number of whiskers at once.
const BURST: f64 = 1024.0;
/// Limit of whiskers in the checkpoints at the end of supervision: less than a second of work.
const WHISKERS_AT_THE_END: f64 = 10_000.0;

/// Robots that need a checkpoint.
#[derive(Debug, Default)]
pub(crate) struct CheckpointQueue {
    /// Robots whose checkpoint the next transaction must write.
    next: Vec<Name>,
    /// Number of their whiskers; only changed ones are written.
    next_whiskers: usize,
    /// The other robots, by the number and time of the first journal entry that their checkpoint does not contain.
    queue: VecDeque<(i64, Micros, Name)>,
    /// Age at which they are due.
    after: Option<Micros>,
}

impl CheckpointQueue {
    pub(crate) fn push_next(&mut self, name: &Name, whiskers: usize) {
        self.next.push(name.clone());
        self.next_whiskers += whiskers;
    }

    /// Counts the whiskers of a robot of the next transaction that has a new layout.
    pub(crate) fn count_layout(&mut self, whiskers: usize) {
        self.next_whiskers += whiskers;
    }

    pub(crate) fn push(&mut self, number: i64, now: Micros, name: &Name) {
        self.queue.push_back((number, now, name.clone()));
    }

    /// Whether the next transaction must write no checkpoint.
    pub(crate) fn is_empty(&self) -> bool {
        self.next.is_empty()
    }

    /// Largest number of whiskers in the checkpoints that the next transaction must write.
    pub(crate) fn next_whiskers(&self) -> usize {
        self.next_whiskers
    }

    /// Whether a checkpoint without a decision is due.
    pub(crate) fn is_due(&mut self, robots: &Robots, now: Micros) -> bool {
        self.oldest(robots).is_some_and(|(_, since)| now.since(since) >= self.after.unwrap_or(AFTER))
    }

    /// Sets the age at which checkpoints are due.
    pub(crate) fn set_after(&mut self, after: Micros) {
        self.after = Some(after);
    }

    /// Makes all waiting checkpoints due.
    pub(crate) fn make_due(&mut self) {
        for (_, since, _) in &mut self.queue {
            *since = Micros::default();
        }
    }

    /// Number and time of the first journal entry that a recovery of these robots needs; `None` if it needs none.
    pub(crate) fn oldest(&mut self, robots: &Robots) -> Option<(i64, Micros)> {
        while let Some((number, since, name)) = self.queue.front() {
            if robots.get(name).is_some_and(|known| known.durable == Durable::Journal(*number)) {
                return Some((*number, *since));
            }
            self.queue.pop_front();
        }
        None
    }

    /// Writes the checkpoints that the transaction of this number must contain because of decisions.
    pub(super) fn write_decided(
        &mut self,
        robots: &mut Robots,
        number: i64,
        rows: &mut Batch,
        rate: &mut CheckpointRate,
    ) {
        self.next_whiskers = 0;
        for name in std::mem::take(&mut self.next) {
            if let Some(known) = robots.get_mut(&name) {
                rate.take(write(known, number, rows));
            }
        }
    }

    /// Writes waiting checkpoints that are due, as far as the rate allows.
    pub(super) fn write_due(
        &mut self,
        robots: &mut Robots,
        (number, now): (i64, Micros),
        rows: &mut Batch,
        rate: &mut CheckpointRate,
    ) {
        while rate.has_any() && self.is_due(robots, now) {
            let Some((_, _, name)) = self.queue.pop_front() else { break };
            if let Some(known) = robots.get_mut(&name) {
                rate.take(write(known, number, rows));
            }
        }
    }
}

/// Limits the rate of whiskers' checkpoints.
#[derive(Debug)]
pub(crate) struct CheckpointRate {
    tokens: f64,
    at: Micros,
}

impl CheckpointRate {
    pub(crate) fn new(now: Micros) -> Self {
        Self { tokens: BURST, at: now }
    }

    /// The limit for the last transaction.
    pub(crate) fn at_the_end(now: Micros) -> Self {
        Self { tokens: WHISKERS_AT_THE_END, at: now }
    }

    /// Adds the tokens of the time that has passed.
    pub(crate) fn refill(&mut self, now: Micros, contacts_in_journal: usize) {
        let rate = WHISKERS_PER_S + WHISKERS_PER_S_A_CONTACT * contacts_in_journal as f64;
        self.tokens = (self.tokens + rate * now.since(self.at).as_s()).min(self.tokens.max(BURST));
        self.at = now;
    }

    fn has_any(&self) -> bool {
        self.tokens >= 1.0
    }

    fn take(&mut self, whiskers: usize) {
        self.tokens -= whiskers as f64;
    }
}

/// Adds the changed parts of a robot's checkpoint, and returns the number of whiskers.
fn write(known: &mut KnownRobot, number: i64, batch: &mut Batch) -> usize {
    known.durable = Durable::Checkpoint;
    let mut changed = Vec::new();
    known.robot.take_changed_whiskers(|index| changed.push(index));
    known.history.take_changed(&mut changed);
    let is_row_due = std::mem::take(&mut known.is_row_due);
    if !known.robot.take_changed() && changed.is_empty() && !is_row_due {
        return 0;
    }
    let Some(state) = known.robot.to_bytes() else {
        error!(robot = %known.full_name(), "cannot encode the state, keeping the last checkpoint");
        return 0;
    };
    let (boot_id, link) = known.robot.connection_state();
    batch.robots.push(RobotRow {
        robot_id: known.robot_id,
        boot_id: boot_id.map(str::to_owned),
        // Nothing is taken of an excluded robot: for people it is not there.
        connection: if known.is_excluded { Link::Offline } else { link }.word(),
        held: known.robot.is_held(),
        updated_us: wall_clock().0 as i64,
        journal_number: number,
        software: known.told.software().to_owned(),
        state,
    });
    for &index in &changed {
        batch.whiskers.extend(whisker_row(known, index));
    }
    changed.len()
}

fn whisker_row(known: &KnownRobot, index: usize) -> Option<WhiskerRow> {
    let view = known.robot.whisker(index)?;
    let whisker_id = *known.whisker_ids.get(index)?;
    let Some(state) = known.robot.whisker_to_bytes(index) else {
        error!(whisker = %known.full_name_of(index), "cannot encode the state, keeping the last checkpoint");
        return None;
    };
    Some(WhiskerRow {
        whisker_id,
        position: index as i64,
        length_mm: view.length.length.mm(),
        length_sd_mm: view.length.sd_mm,
        condition: view.condition.word(),
        fault: view.fault.map(Word::word),
        segmenter: known.told.segmenter(whisker_id).map(Segmenter::as_str),
        pressure_mpa: view.pressure.map(Megapascal::mpa),
        setpoint_mpa: view.setpoint.mpa(),
        contacts: view.contacts as i64,
        heard_us: view.heard.map(|heard| heard.0 as i64),
        held: view.held,
        leak_per_s: view.leak_per_s.map(known_interval),
        erosion_mm_per_contact: view.erosion.map(|erosion| known_interval(erosion.mm_per_contact)),
        contacts_left: view.erosion.map_or([None; 3], |erosion| {
            let left = erosion.contacts_left;
            [left.mean, left.low, left.high]
        }),
        state,
        rollup: known.history.stored(index, known.full_name_of(index), wall_clock()),
    })
}

fn known_interval(known: vibrissa_core::estimation::Interval) -> Interval {
    Interval { mean: known.mean, low: known.low, high: known.high }
}
