//! Checkpoints, which are rows with a robot's state: written at once after a decision, and otherwise from time to time,
//! so that the journal stays short.

use std::collections::VecDeque;

use tracing::error;
use vibrissa_core::units::Micros;
use vibrissa_edge::words::Word;
use vibrissa_protocol::Name;

use crate::engine::mpa;
use crate::engine::shard::{Known, Shard, Stored};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::Batch;
use vibrissa_store::batch::{Interval, RobotRow, WhiskerRow};

/// Age of a robot's first journal entry at which its checkpoint is due; it may be later if many are due.
const AFTER: Micros = Micros(2_000_000);
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
pub(in crate::engine) struct Waiting {
    /// Robots whose checkpoint the next transaction must write.
    next: Vec<Name>,
    /// Number of their whiskers; only changed ones are written.
    next_whiskers: usize,
    /// The other robots, by the number and time of the first journal entry that their checkpoint does not contain.
    queue: VecDeque<(i64, Micros, Name)>,
}

impl Waiting {
    pub(in crate::engine) fn push_next(&mut self, name: &Name, whiskers: usize) {
        self.next.push(name.clone());
        self.next_whiskers += whiskers;
    }

    /// Counts the whiskers of a robot of the next transaction that has a new layout.
    pub(in crate::engine) fn laid_out(&mut self, whiskers: usize) {
        self.next_whiskers += whiskers;
    }

    pub(in crate::engine) fn push(&mut self, number: i64, now: Micros, name: &Name) {
        self.queue.push_back((number, now, name.clone()));
    }

    pub(in crate::engine) fn is_next_empty(&self) -> bool {
        self.next.is_empty()
    }

    /// Largest number of whiskers in the checkpoints that the next transaction must write.
    pub(in crate::engine) fn next_whiskers(&self) -> usize {
        self.next_whiskers
    }
}

/// Limits the rate of whiskers' checkpoints.
#[derive(Debug)]
pub(in crate::engine) struct Pace {
    tokens: f64,
    at: Micros,
}

impl Pace {
    pub(in crate::engine) fn new(now: Micros) -> Self {
        Self { tokens: BURST, at: now }
    }

    /// The limit for the last transaction.
    pub(in crate::engine) fn at_the_end(now: Micros) -> Self {
        Self { tokens: WHISKERS_AT_THE_END, at: now }
    }

    /// Adds the tokens of the time that has passed.
    pub(in crate::engine) fn go_on(&mut self, now: Micros, contacts_in_journal: usize) {
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

impl Shard {
    /// Whether a checkpoint without a decision is due.
    pub(in crate::engine) fn is_state_due(&mut self, now: Micros) -> bool {
        self.oldest_waiting().is_some_and(|(_, since)| now.since(since) >= AFTER)
    }

    /// Makes all waiting checkpoints due.
    pub(in crate::engine) fn no_longer_wait(&mut self) {
        for (_, since, _) in &mut self.gathering.waiting.queue {
            *since = Micros::default();
        }
    }

    /// Number and time of the first journal entry that a recovery of this shard's robots needs; `None` if it needs
    /// none.
    pub(in crate::engine) fn oldest_waiting(&mut self) -> Option<(i64, Micros)> {
        let queue = &mut self.gathering.waiting.queue;
        while let Some((number, since, name)) = queue.front() {
            if self.robots.get(name).is_some_and(|known| known.stored == Stored::Journal(*number)) {
                return Some((*number, *since));
            }
            queue.pop_front();
        }
        None
    }

    /// Adds the checkpoints that the transaction must contain because of decisions.
    pub(in crate::engine) fn snapshot_decided(&mut self, pace: &mut Pace) {
        self.gathering.waiting.next_whiskers = 0;
        for name in std::mem::take(&mut self.gathering.waiting.next) {
            if let Some(known) = self.robots.get_mut(&name) {
                pace.take(write(known, self.gathering.number, &mut self.gathering.batch));
            }
        }
    }

    /// Adds checkpoints that are due, as far as the rate allows.
    pub(in crate::engine) fn snapshot_waiting(&mut self, now: Micros, pace: &mut Pace) {
        while pace.has_any() && self.is_state_due(now) {
            let Some((_, _, name)) = self.gathering.waiting.queue.pop_front() else { break };
            if let Some(known) = self.robots.get_mut(&name) {
                pace.take(write(known, self.gathering.number, &mut self.gathering.batch));
            }
        }
    }
}

/// Adds the changed parts of a robot's checkpoint, and returns the number of whiskers.
fn write(known: &mut Known, number: i64, batch: &mut Batch) -> usize {
    known.stored = Stored::State;
    let mut changed = Vec::new();
    known.robot.take_changed_whiskers(|index| changed.push(index));
    known.history.take_changed(&mut changed);
    if !known.robot.take_changed() && changed.is_empty() {
        return 0;
    }
    let Some(state) = known.robot.to_bytes() else {
        error!(robot = %known.name, "cannot encode the state, keeping the last checkpoint");
        return 0;
    };
    let (boot_id, link) = known.robot.connection_state();
    batch.robots.push(RobotRow {
        robot_id: known.robot_id,
        boot_id: boot_id.map(str::to_owned),
        connection: link.word(),
        held: known.robot.is_held(),
        updated_us: wall_clock().0 as i64,
        journal_number: number,
        state,
    });
    for &index in &changed {
        batch.whiskers.extend(whisker_row(known, index));
    }
    changed.len()
}

fn whisker_row(known: &Known, index: usize) -> Option<WhiskerRow> {
    let view = known.robot.whisker(index)?;
    let whisker_id = *known.whisker_ids.get(index)?;
    let Some(state) = known.robot.whisker_to_bytes(index) else {
        error!(robot = %known.name, whisker = index, "cannot encode the state, keeping the last checkpoint");
        return None;
    };
    Some(WhiskerRow {
        whisker_id,
        position: index as i64,
        length_mm: view.length.length.mm(),
        length_sd_mm: view.length.sd_mm,
        condition: view.condition.word(),
        fault: view.fault.map(Word::word),
        pressure_mpa: mpa(view.pressure),
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
        rollup: known.history.stored(index, wall_clock()),
    })
}

fn known_interval(known: vibrissa_core::estimation::Interval) -> Interval {
    Interval { mean: known.mean, low: known.low, high: known.high }
}
