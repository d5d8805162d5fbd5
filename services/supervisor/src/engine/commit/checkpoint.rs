//! Robots' states as rows: at once where something is decided, and otherwise now and then, so that the journal stays short.

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

/// A state is written this long after the first entry of the journal that it does not contain, or later if there are many.
const AFTER: Micros = Micros(2_000_000);
/// Whiskers whose states are written in a second, beside those where something was decided ...
const WHISKERS_PER_S: f64 = 2_000.0;
/// ... and as many more for each contact that waits in the journal, so that it cannot outgrow what is gone through again in
/// some seconds.
const WHISKERS_PER_S_A_CONTACT: f64 = 2e-3;
/// The most at once.
const BURST: f64 = 1024.0;
/// Whiskers whose states are written when a fleet is given up: in less than a second.
const WHISKERS_AT_THE_END: f64 = 10_000.0;

/// Robots whose states are to be written.
#[derive(Debug, Default)]
pub(in crate::engine) struct Waiting {
    /// By the next transaction.
    next: Vec<Name>,
    /// Their whiskers, of which those are written that have changed.
    next_whiskers: usize,
    /// The others, by the number of the first entry of the journal that their states do not contain, and since when.
    queue: VecDeque<(i64, Micros, Name)>,
}

impl Waiting {
    pub(in crate::engine) fn push_next(&mut self, name: &Name, whiskers: usize) {
        self.next.push(name.clone());
        self.next_whiskers += whiskers;
    }

    /// A robot of the next transaction has got its whiskers.
    pub(in crate::engine) fn laid_out(&mut self, whiskers: usize) {
        self.next_whiskers += whiskers;
    }

    pub(in crate::engine) fn push(&mut self, number: i64, now: Micros, name: &Name) {
        self.queue.push_back((number, now, name.clone()));
    }

    pub(in crate::engine) fn is_next_empty(&self) -> bool {
        self.next.is_empty()
    }

    /// Whiskers whose states the next transaction writes, at the most.
    pub(in crate::engine) fn next_whiskers(&self) -> usize {
        self.next_whiskers
    }
}

/// How many whiskers' states may be written now.
#[derive(Debug)]
pub(in crate::engine) struct Pace {
    tokens: f64,
    at: Micros,
}

impl Pace {
    pub(in crate::engine) fn new(now: Micros) -> Self {
        Self { tokens: BURST, at: now }
    }

    /// For the last transaction.
    pub(in crate::engine) fn at_the_end(now: Micros) -> Self {
        Self { tokens: WHISKERS_AT_THE_END, at: now }
    }

    /// Time has passed, and so many contacts wait in the journal.
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
    /// Whether a state waits to be written that may be.
    pub(in crate::engine) fn is_state_due(&mut self, now: Micros) -> bool {
        self.oldest_waiting().is_some_and(|(_, since)| now.since(since) >= AFTER)
    }

    /// States that wait are due.
    pub(in crate::engine) fn no_longer_wait(&mut self) {
        for (_, since, _) in &mut self.gathering.waiting.queue {
            *since = Micros::default();
        }
    }

    /// The first entry of the journal that is needed to take this shard's robots up, and since when; none if none is.
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

    /// The states that the transaction must write, because something was decided.
    pub(in crate::engine) fn snapshot_decided(&mut self, pace: &mut Pace) {
        self.gathering.waiting.next_whiskers = 0;
        for name in std::mem::take(&mut self.gathering.waiting.next) {
            if let Some(known) = self.robots.get_mut(&name) {
                pace.take(write(known, self.gathering.number, &mut self.gathering.batch));
            }
        }
    }

    /// Those that it may write, because they have waited.
    pub(in crate::engine) fn snapshot_waiting(&mut self, now: Micros, pace: &mut Pace) {
        while pace.has_any() && self.is_state_due(now) {
            let Some((_, _, name)) = self.gathering.waiting.queue.pop_front() else { break };
            if let Some(known) = self.robots.get_mut(&name) {
                pace.take(write(known, self.gathering.number, &mut self.gathering.batch));
            }
        }
    }
}

/// Writes what has changed of a robot; says how many whiskers.
fn write(known: &mut Known, number: i64, batch: &mut Batch) -> usize {
    known.stored = Stored::State;
    let mut changed = Vec::new();
    known.robot.take_changed_whiskers(|index| changed.push(index));
    known.history.take_changed(&mut changed);
    if !known.robot.take_changed() && changed.is_empty() {
        return 0;
    }
    let Some(state) = known.robot.to_bytes() else {
        error!(robot = %known.name, "its state cannot be stored; the one stored before stays");
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
        error!(robot = %known.name, whisker = index, "its state cannot be stored; the one stored before stays");
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
