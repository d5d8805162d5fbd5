//! A part of a fleet's robots. Each robot has one owner, its worker. Workers share nothing, so they work in parallel.
//!
//! - [`messages`]: a message is decoded, and checked against the allow list and the limits.
//! - [`reports`]: contacts, status and setpoint states of a known robot become events.
//! - [`stepper`]: an event is stepped through the core.
//! - [`record`], [`rows`]: its effects become rows; [`events`], [`contact_events`]: and events for other programs.
//! - [`log`]: lines of the log, which name their subject in full.
//! - [`publication`]: setpoints, receipts and requests, and the seal of the batch that publishes them; [`estimate`]:
//!   estimates; [`maintenance`]: facts for other tools.

mod announced;
pub(crate) mod contact_events;
mod estimate;
mod events;
mod hearing;
mod log;
mod maintenance;
mod messages;
pub(crate) mod publication;
mod record;
mod refusals;
mod reports;
mod rows;
pub(crate) mod stepper;
mod touch_tests;
pub(crate) mod workers;

use std::collections::BTreeMap;
use std::hash::RandomState;

use vibrissa_core::robot::{Event, Outcome};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Name};

use crate::black_box::recorder::Whose;
use crate::engine::allow_list::{AllowList, RefusedRobots};
use crate::engine::commit::batch::OpenBatch;
use crate::engine::part::Part;
use crate::engine::robot::seqs::Seqs;
use crate::engine::robot::{KnownRobot, Robots};
use crate::inbox::Delayed;
use crate::log_inbox::LogRange;
use crate::outbox::Publication;

pub(crate) use hearing::Found;

use announced::Announced;
use stepper::Stepper;

/// A decommissioned robot: numbers that must not be used twice.
#[derive(Debug, Default)]
struct Former {
    seqs: Seqs,
    next_version: u64,
    /// Its retained messages are cleared, as far as this engine knows.
    is_cleared: bool,
}

/// Decommissioned robots whose retained messages are cleared again at a time.
const CLEARED_AT_ONCE: usize = 10;

/// A part of a fleet's robots, and their open batch.
pub(crate) struct Worker {
    robots: Robots,
    /// Robots whose factsheets are missing.
    announced: Announced,
    stepper: Stepper,
    /// The epoch of the fleet's lease.
    epoch: u64,
    /// Number of robots that have got the current tick, if it was interrupted.
    tick_resumes_at: Option<usize>,
    /// The first robot whose estimate may be published next: each gets its turn.
    estimates_resume_at: usize,
    /// The same for facts for the maintenance.
    maintenance_resumes_at: usize,
    allow_list: AllowList,
    /// Robots whose state a newer version of the program has written, with their numbers. That version
    /// needs it, so none of their messages is taken.
    of_newer_program: BTreeMap<Name, i64>,
    /// Numbers of robots that were decommissioned in this epoch, should they come back.
    former: BTreeMap<Name, Former>,
    /// Robots that are not on the allow list.
    refused_robots: RefusedRobots,
    /// Keys of the hashes of messages.
    hashers: RandomState,
    /// The robots of this worker, if their messages come from a partitioned log.
    part: Option<Part>,
    /// Contacts of a handled message; the allocation is reused.
    contacts: Vec<protocol::Contact>,
}

impl Worker {
    /// One of `workers` workers, without robots.
    pub(crate) fn new(stepper: Stepper, epoch: u64, workers: usize) -> Self {
        Self {
            robots: Robots::new(),
            announced: Announced::of_workers(workers),
            stepper,
            epoch,
            tick_resumes_at: None,
            estimates_resume_at: 0,
            maintenance_resumes_at: 0,
            allow_list: AllowList::default(),
            of_newer_program: BTreeMap::new(),
            former: BTreeMap::new(),
            refused_robots: RefusedRobots::default(),
            hashers: RandomState::new(),
            part: None,
            contacts: Vec::new(),
        }
    }

    /// Makes the journal refer to a partitioned log, as the worker of these robots.
    pub(crate) fn set_part(&mut self, part: Part) {
        self.part = Some(part);
    }

    /// Whether messages of a robot are taken: the allow list permits it, and its state is not one of a newer program.
    pub(crate) fn takes(&self, robot: &Name) -> bool {
        self.allow_list.permits(robot) && !self.of_newer_program.contains_key(robot)
    }

    /// Number of a robot that is known, or that waits for a newer program.
    pub(crate) fn robot_id(&self, robot: &Name) -> Option<i64> {
        let known = self.robots.get(robot).map(|known| known.robot_id);
        known.or_else(|| self.of_newer_program.get(robot).copied())
    }

    /// Makes the messages of these records durable, which were handled before.
    pub(crate) fn refer(&mut self, now: Micros, range: LogRange, except: &[i64]) {
        if let Some(part) = self.part {
            self.stepper.batch.refer(now, range, part, except.to_vec());
        }
    }

    pub(crate) fn robots(&self) -> &Robots {
        &self.robots
    }

    pub(crate) fn robots_mut(&mut self) -> &mut Robots {
        &mut self.robots
    }

    pub(crate) fn stepper(&self) -> &Stepper {
        &self.stepper
    }

    pub(crate) fn stepper_mut(&mut self) -> &mut Stepper {
        &mut self.stepper
    }

    /// The robots, and the stepper for their events.
    pub(crate) fn parts(&mut self) -> (&mut Robots, &mut Stepper) {
        (&mut self.robots, &mut self.stepper)
    }

    #[cfg(test)]
    pub(crate) fn metrics(&self) -> &crate::metrics::FleetMetrics {
        &self.stepper.metrics
    }

    /// The open batch.
    pub(crate) fn batch(&self) -> &OpenBatch {
        &self.stepper.batch
    }

    pub(crate) fn batch_mut(&mut self) -> &mut OpenBatch {
        &mut self.stepper.batch
    }

    pub(crate) fn refused_robots(&self) -> &RefusedRobots {
        &self.refused_robots
    }

    pub(crate) fn refused_robots_mut(&mut self) -> &mut RefusedRobots {
        &mut self.refused_robots
    }

    /// Sets the allow list. Robots that are allowed now are no longer listed as refused.
    pub(crate) fn set_allow_list(&mut self, list: AllowList) {
        self.refused_robots.retain(|robot| !list.permits(robot));
        self.allow_list = list;
        for known in self.robots.values_mut() {
            let is_excluded = !self.allow_list.permits(&known.name);
            if is_excluded != known.is_excluded {
                self.stepper.exclude(known, is_excluded);
            }
        }
    }

    /// Refuses a robot whose state a newer version of the program has written.
    pub(crate) fn leave_to_newer_program(&mut self, name: Name, robot_id: i64) {
        self.of_newer_program.insert(name, robot_id);
    }

    /// The robots that wait for a newer version of the program.
    pub(crate) fn of_newer_program(&self) -> &BTreeMap<Name, i64> {
        &self.of_newer_program
    }

    /// Takes a robot out of supervision, for [`Self::forget`] or [`Self::put_back`].
    pub(crate) fn take_out(&mut self, name: &Name) -> Option<KnownRobot> {
        self.robots.shift_remove(name)
    }

    /// Supervises a robot again.
    pub(crate) fn put_back(&mut self, mut known: KnownRobot) {
        self.stepper.batch.checkpoint(&mut known);
        self.robots.insert(known.name.clone(), known);
    }

    /// Forgets a robot that was decommissioned, and clears its retained messages at the broker.
    pub(crate) fn forget(&mut self, known: KnownRobot) {
        let name = known.name;
        self.announced.take(&name);
        known.withdrawal.withdraw();
        self.stepper.clear_retained(&name);
        let former = Former { seqs: known.seqs, next_version: known.robot.next_version(), is_cleared: true };
        self.former.insert(name, former);
    }

    /// Makes the retained messages of decommissioned robots due to be cleared again.
    pub(super) fn repeat_clearing(&mut self) {
        self.former.values_mut().for_each(|former| former.is_cleared = false);
    }

    /// Clears the retained messages of decommissioned robots that are due, but for those that have announced themselves anew.
    pub(super) fn clear_former(&mut self) {
        let due = self.former.iter_mut().filter(|(name, former)| !former.is_cleared && !self.announced.has(name));
        for (name, former) in due.take(CLEARED_AT_ONCE) {
            former.is_cleared = true;
            self.stepper.clear_retained(name);
        }
    }

    /// Steps one robot; `None` if it is not known.
    pub(crate) fn step_robot(&mut self, name: &Name, now: Micros, event: &Event<'_>) -> Option<Outcome> {
        Some(self.stepper.step(self.robots.get_mut(name)?, now, event, None))
    }

    /// Whether the current tick was interrupted.
    pub(crate) fn is_tick_under_way(&self) -> bool {
        self.tick_resumes_at.is_some()
    }

    /// Steps a tick through the robots, beginning with the first that has not got it yet, until so many whiskers need a
    /// checkpoint. The limit keeps an event that affects a whole fleet from blocking everything else with one long
    /// transaction. Returns false if the tick is interrupted.
    ///
    /// The tick of a delayed robot is not later than its oldest message that waits. Otherwise the robot would seem silent.
    /// With a partitioned log all robots have the same time, because the journal has one entry for the tick of all.
    pub(crate) fn tick(&mut self, now: Micros, delayed: &Delayed, whiskers_max: usize) -> bool {
        let is_one_for_all = self.part.is_some();
        let time_of = |name: &Name| match delayed.get(name.as_str().as_bytes()) {
            Some(oldest) if !is_one_for_all => now.min(*oldest),
            Some(_) | None => now,
        };
        let first = self.tick_resumes_at.take().unwrap_or_default();
        let journal_before = self.stepper.batch.journal_bytes();
        if first == 0 {
            self.announced.tick(&mut self.stepper, now);
        }
        for (index, known) in self.robots.values_mut().enumerate().skip(first) {
            if known.rests || known.is_excluded {
                continue;
            }
            let own = time_of(&known.name);
            self.stepper.accept_refused_boot(known, own);
            self.stepper.step(known, own, &Event::Tick, None);
            let whose = Whose { robot_id: known.robot_id, name: &known.name };
            if let Some(recorder) = &mut known.recorder {
                recorder.tick(&known.robot, whose, own);
            }
            if self.stepper.batch.decided_whiskers() >= whiskers_max {
                self.tick_resumes_at = Some(index + 1);
                return false;
            }
        }
        // A newer program would replay the tick of all for the robots that wait for it, which have none here.
        if let Some(part) = self.part.filter(|_| first == 0 && self.of_newer_program.is_empty()) {
            self.stepper.batch.tick_all(journal_before, now, part);
        }
        true
    }

    /// Restarts the silence timers of all robots, because this supervisor was deaf. Each robot's is restarted before a
    /// step that would need it: a checkpoint of all robots at once would be a transaction too large for the database.
    pub(crate) fn restart_silence_timers(&mut self, now: Micros) {
        self.stepper.excuse_silence_until(now);
    }

    /// Restarts the robot's silence timer after its messages were shed, likewise.
    pub(crate) fn restart_silence_timer(&mut self, name: &Name, now: Micros) {
        if let Some(known) = self.robots.get_mut(name) {
            known.deaf_until = now;
        }
    }

    /// Closes finished minutes and hours of at most `left` whiskers, including silent ones.
    pub(super) fn close_history(&mut self, now: Micros, left: &mut usize) {
        for known in self.robots.values_mut().filter(|known| !known.rests) {
            let rows = self.stepper.batch.rows_mut();
            if known.history.close(now, &known.whisker_ids, left, rows) {
                self.stepper.batch.checkpoint(known);
                *left = left.saturating_sub(known.whisker_ids.len());
            }
        }
    }

    /// Records a message that was published to a robot.
    pub(crate) fn published(&mut self, Publication { robot, message, .. }: &Publication, at: Micros) {
        if let Some(known) = self.robots.get_mut(robot)
            && self.stepper.has_box(known, at)
        {
            self.stepper.keep_message(known, message.topic(), at, &message.encoded());
        }
    }

    /// Ends the open black boxes before their time, because supervision ends.
    pub(super) fn end_boxes(&mut self, now: Micros) {
        for known in self.robots.values_mut() {
            let whose = Whose { robot_id: known.robot_id, name: &known.name };
            if let Some(recorder) = &mut known.recorder {
                recorder.end(whose, now);
            }
        }
    }

    /// Whether a checkpoint without a decision is due.
    pub(super) fn is_checkpoint_due(&mut self, now: Micros) -> bool {
        self.stepper.batch.checkpoints().is_due(&self.robots, now)
    }

    /// Number of the first journal entry that a recovery of this worker's robots needs; `None` if it needs none.
    pub(crate) fn oldest_entry(&mut self) -> Option<i64> {
        self.stepper.batch.checkpoints().oldest(&self.robots).map(|(number, _)| number)
    }
}
