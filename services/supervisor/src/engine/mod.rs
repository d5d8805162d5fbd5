//! Processing of messages: received, decoded, stepped through the core, committed, and only then answered.
//!
//! In the order of the data:
//! - [`dispatch`]: messages are distributed to the workers.
//! - [`worker`]: each robot's state has one owner, which steps its events and collects the effects in an open batch.
//! - [`commit`]: the open batches of some milliseconds become one transaction, while the next messages are stepped; then
//!   setpoints and receipts are published.
//! - [`quarantine`]: robots whose rows the database rejects.
//! - [`changes`], [`actions`], [`allow_list_sources`]: changes by operators.
//! - [`rollout`]: changes that only some robots have so far.
//! - [`birth_watch`]: robots whose births were not received; [`hearing`]: receipts and factsheets that do not arrive.
//! - [`start`]: loads a fleet.
//!
//! Everything published is committed, and robots send again whatever is not committed.

mod actions;
mod allow_list;
mod allow_list_sources;
mod birth_watch;
mod changes;
mod commit;
mod decommission;
mod dispatch;
mod fleet_metrics;
mod hearing;
mod ledger;
mod message;
mod part;
mod pipeline;
mod quarantine;
mod robot;
pub(crate) mod rollout;
mod start;
mod worker;

pub use robot::limits::Limits;
pub use robot::retention::ContactRetention;
pub use robot::rollup;
pub(crate) use start::EngineOptions;

use std::future::pending;
use std::sync::Arc;

use tokio::runtime::Handle;
use tokio::sync::{Notify, mpsc};
use tokio::task::yield_now;
use tokio::time::{Duration, Instant, Interval, MissedTickBehavior, interval_at, sleep_until};
use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;

use crate::action_notifier::ActionNotifier;
use crate::black_box::FleetBoxes;
use crate::clocks::RobotClocks;
use crate::ending::Ending;
use crate::inbox::Inbox;
use crate::log_inbox::{LogBatch, LogSource, NextOffsets};
use crate::metrics::{FleetMetrics, Metrics};
use crate::outbox::{Losses, Publication};
use crate::promises::Promises;
use crate::readiness::Readiness;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::fault::{self, Fault};

use crate::births::BirthCause;
use actions::ParamsInForce;
use allow_list_sources::AllowListSources;
use birth_watch::BirthWatch;
use commit::committer::{LeaseLost, Written};
use pipeline::Pipeline;
use pipeline::schedule::{RECEIPTS, TICK};
use quarantine::suspects::Suspects;
use robot::limits::Bucket;
use rollout::Rollout;
use worker::workers::Workers;

/// Largest number of messages taken from the inbox at a time.
const MESSAGES_AT_A_TIME: usize = 1024;
/// Ticks between two checks of the allow list (4 s).
const TICKS_PER_ALLOW_LIST: u32 = 16;
/// Ticks between two comparisons of the errors of a roll-out (5 s).
const TICKS_PER_REVIEW: u32 = 20;
/// Ticks between two statements of the archive's horizon (5 s).
const TICKS_PER_HORIZON: u32 = 20;
/// Age of the archive's horizon, µs. Contacts that take longer from their receipt to the batch get its time instead.
const HORIZON_AGE_US: i64 = 5_000_000;
/// Ticks between two surveys of all robots for the metrics (1 s).
const TICKS_PER_SURVEY: u32 = 4;
/// A survey takes at most one part in this many of the time; otherwise surveys are less frequent.
const SURVEY_SHARE: u32 = 50;

/// Supervision of one fleet: workers that own its robots, and a sequence of transactions.
pub(crate) struct Engine {
    fleet: Name,
    workers: Workers,
    pipeline: Pipeline,
    suspects: Suspects,
    in_force: ParamsInForce,
    /// Roll-out that is running or paused.
    rollout: Option<Rollout>,
    allow_list: AllowListSources,
    action_notifier: ActionNotifier,
    /// Notified when an action for the fleet is sent to this supervisor.
    action_sent: Arc<Notify>,
    birth_watch: BirthWatch,
    limits: Limits,
    /// Limits the rate of new robots.
    new_robots: Bucket,
    /// Runtime for work that would block the engine's own thread.
    background: Handle,
    boxes: FleetBoxes,
    /// Where the partitioned log is to be read from.
    log_from: NextOffsets,
    /// The partitioned log that contacts come from, if there is one.
    log: Option<LogSource>,
    /// Whether factsheets were missing at the last look.
    lacked_factsheets: bool,
    /// Notified when a transaction with events is committed.
    events: Option<Arc<Notify>>,
    /// Metrics shared by all fleets.
    program: Metrics,
    readiness: Readiness,
    metrics: FleetMetrics,
    promises: Promises,
    /// Takes the clocks of the robots.
    robot_clocks: RobotClocks,
    /// Time of the next survey of the robots, at the earliest.
    survey_from: Instant,
    /// Time of the next notice about refused messages, at the earliest.
    refusals_told_from: Instant,
    /// The last robot whose refusals were written; those after it are next.
    refusals_written_to: i64,
    /// Whether the contacts are archived.
    is_archived: bool,
    /// When the engine did something last.
    awake: Instant,
}

/// Why the engine does something.
enum Cause {
    /// A transaction was written, or cannot be.
    Written(Box<Written>),
    /// The open batches are to be committed.
    CommitDue,
    /// So many messages have come; 0 after the last.
    Messages(usize),
    /// Records of the log have come.
    Log(LogBatch),
    /// A period is over.
    Tick,
    /// An operator has asked for something.
    Action,
    /// Receipts may be due.
    Receipts,
}

impl Engine {
    /// Runs until no more messages can arrive and all are committed, or until the lease is lost. In the latter case
    /// robots send their uncommitted messages again to the new owner.
    pub(crate) async fn run(
        mut self,
        (inbox, log): (Inbox, Option<mpsc::Receiver<LogBatch>>),
        outbox: mpsc::Sender<Publication>,
        losses: Losses,
    ) -> Ending {
        self.pipeline.connect(outbox, losses);
        let ending = match self.work(inbox, log).await {
            Ok(()) => Ending::Stopped,
            Err(LeaseLost) => Ending::LeaseLost,
        };
        self.workers.end_traces(ending);
        ending
    }

    async fn work(&mut self, mut inbox: Inbox, mut log: Option<mpsc::Receiver<LogBatch>>) -> Result<(), LeaseLost> {
        let between_receipts = if self.log.is_some() { TICK } else { RECEIPTS };
        let (mut ticks, mut receipts) = (every(TICK), every(between_receipts));
        let action_sent = self.action_sent.clone();
        let mut messages = Vec::with_capacity(MESSAGES_AT_A_TIME);
        let (mut is_ticking, mut number) = (false, 0_u32);
        loop {
            let has_room = self.workers.has_room();
            inbox.begin_round(self.pipeline.schedule().number());
            let due = self.pipeline.due();
            let are_few = self.pipeline.schedule().are_few();
            let cause = tokio::select! {
                written = self.pipeline.written() => Cause::Written(Box::new(written)),
                () = async { sleep_until(due.unwrap_or_else(Instant::now)).await }, if due.is_some() => Cause::CommitDue,
                count = inbox.recv_many(&mut messages, MESSAGES_AT_A_TIME), if has_room => Cause::Messages(count),
                // The reader of the log ends before the engine only by a panic: then the fleet is taken up anew.
                batch = next_batch(&mut log), if has_room => batch.map_or(Cause::Messages(0), Cause::Log),
                _ = ticks.tick() => Cause::Tick,
                () = action_sent.notified() => Cause::Action,
                _ = receipts.tick(), if !are_few => Cause::Receipts,
            };
            self.excuse_own_standstill();
            match cause {
                Cause::Written(written) => drop(self.committed(*written).await?),
                Cause::CommitDue => {}
                Cause::Messages(0) => break,
                Cause::Messages(count) => {
                    self.take_in(&mut messages).await?;
                    if fault::is(Fault::ReceiptBeforeCommit) {
                        // A fault planted by a test: receipts are published before the commit.
                        self.pipeline.publish(self.workers.take_publications(), |_| {});
                    }
                    self.pipeline.took(count as u64, &self.workers);
                    if inbox.is_throttling() {
                        self.pipeline.schedule().hurry();
                    }
                    if self.pipeline.is_writing() {
                        // The commit may run in this thread.
                        yield_now().await;
                    }
                }
                Cause::Log(batch) => {
                    self.take_in_log(batch).await?;
                    if self.pipeline.is_writing() {
                        yield_now().await;
                    }
                }
                Cause::Tick => {
                    number = number.wrapping_add(1);
                    self.at_tick(&inbox, number).await?;
                    is_ticking = true;
                }
                Cause::Action => {
                    self.handle_actions(now(&inbox)).await?;
                    self.allow_list.expect_change();
                    self.refresh_allow_list().await?;
                }
                Cause::Receipts => self.check_receipts(),
            }
            self.excuse_own_standstill();
            if !self.suspects.is_empty() {
                self.step_suspects().await?;
            }
            if self.allow_list.take_changed() {
                inbox.want_births(BirthCause::Allowed);
            }
            if is_ticking && self.workers.has_room() {
                is_ticking = !self.workers.tick(now(&inbox), &inbox.delayed());
                self.pipeline.stepped(0, &self.workers);
            }
            if self.pipeline.is_due(&self.workers) {
                self.begin_commit();
            }
        }
        self.finish().await
    }

    /// Periodic work besides the core's ticks. It is done together, because each wake-up finds cold caches and costs
    /// far more than a message.
    async fn at_tick(&mut self, inbox: &Inbox, number: u32) -> Result<(), LeaseLost> {
        self.settle().await?;
        self.restart_silence_timers_if_deaf(inbox);
        let is_round = self.pipeline.schedule().tick(number);
        if is_round {
            self.publish_estimates();
            self.check_receipts();
        }
        if number.is_multiple_of(TICKS_PER_ALLOW_LIST) {
            self.refresh_allow_list().await?;
            self.write_refusals().await?;
        }
        if number.is_multiple_of(TICKS_PER_REVIEW) {
            self.review_rollout(now(inbox)).await?;
        }
        if self.is_archived && number.is_multiple_of(TICKS_PER_HORIZON) {
            self.state_horizon().await?;
        }
        if number.is_multiple_of(TICKS_PER_SURVEY) {
            self.watch_births(inbox);
            fleet_metrics::show_queues(&self.metrics, inbox, self.pipeline.outbox_filling());
            if self.survey_from <= Instant::now() {
                let begun = Instant::now();
                fleet_metrics::survey_robots(&mut self.workers, &self.fleet, &self.program, &self.metrics);
                // From a log messages come late, so they tell nothing about the time.
                if self.log.is_none() {
                    let ahead_us = fleet_metrics::clocks_ahead_us(&self.workers, wall_clock());
                    self.robot_clocks.show(&self.fleet, ahead_us);
                }
                self.survey_from = begun + begun.elapsed() * SURVEY_SHARE;
            }
            self.judge_hearing(now(inbox));
            self.workers.close_history(now(inbox));
            self.pipeline.stepped(0, &self.workers);
        }
        Ok(())
    }

    /// Requests births that were not received.
    fn watch_births(&mut self, inbox: &Inbox) {
        if !inbox.link().hears() {
            return;
        }
        let has_unannounced = self.workers.take_unannounced();
        let has_unheard = || self.workers.robots().any(|known| !known.is_heard && !known.is_excluded);
        if let Some(cause) = self.birth_watch.due(Instant::now(), has_unannounced, has_unheard) {
            inbox.want_births(cause);
        }
    }

    /// Commits and receipts everything. Checkpoints are written, too, so that the next owner need not replay the
    /// journal; in a very large fleet only some of them, because time is limited.
    async fn finish(&mut self) -> Result<(), LeaseLost> {
        self.settle().await?;
        self.pipeline.prepare_last();
        // A transaction with a setpoint leaves receipts and checkpoints to the next one.
        for _ in 0..2 {
            self.workers.make_checkpoints_due();
            self.begin_commit();
            self.settle().await?;
        }
        self.workers.end_boxes(wall_clock());
        self.boxes.flush().await;
        Ok(())
    }

    /// Where the partitioned log is to be read from, if contacts come from one.
    pub(crate) fn log_from(&self) -> Option<NextOffsets> {
        self.log.as_ref().map(|_| self.log_from.clone())
    }

    /// Seals the open batches and starts to write them.
    fn begin_commit(&mut self) {
        // A suspect's checkpoint may be rejected, so its journal entries are needed for longer.
        let holds_journal = !self.suspects.is_empty() || self.workers.leave_robots();
        self.pipeline.begin(&mut self.workers, holds_journal);
    }

    /// Waits until no transaction is being written.
    async fn settle(&mut self) -> Result<(), LeaseLost> {
        self.settle_naming().await.map(drop)
    }

    /// As [`Self::settle`]; returns the numbers of the robots whose rows the database refuses.
    async fn settle_naming(&mut self) -> Result<Vec<i64>, LeaseLost> {
        if !self.pipeline.is_writing() {
            return Ok(Vec::new());
        }
        let written = self.pipeline.written().await;
        self.committed(written).await
    }

    /// Handles the end of a write: the publications go out. Returns the numbers of the robots whose rows the database refuses.
    async fn committed(&mut self, written: Written) -> Result<Vec<i64>, LeaseLost> {
        let mut done = self.pipeline.committed(written)?;
        if done.committed.was_away {
            self.restart_silence_timers();
        }
        let offenders = std::mem::take(&mut done.committed.offenders);
        let refused = offenders.iter().map(|offender| offender.robot_id).collect();
        if !offenders.is_empty() {
            self.suspects.reject(offenders, &mut done.transaction, &mut self.workers, &mut self.pipeline);
        }
        if done.transaction.has_moves() && !self.excludes_all_that_the_list_does().await {
            // They are sent again, because the robots do not answer them.
            done.transaction.withhold_moves();
        }
        self.suspects.committed(done.transaction.number());
        if let Some(events) = self.events.as_ref().filter(|_| done.transaction.has_events()) {
            events.notify_one();
        }
        self.action_notifier.answered(done.transaction.take_answered());
        if done.transaction.has_records() {
            self.action_notifier.changed();
        }
        self.pipeline.publish_committed(done, &mut self.workers);
        Ok(refused)
    }

    /// States up to which time of receipt all contacts are committed. If the database is unreachable, this does not wait.
    ///
    /// All sealed transactions are written by then, and later ones get contacts from the horizon on only.
    async fn state_horizon(&mut self) -> Result<(), LeaseLost> {
        self.settle().await?;
        let now_us = wall_clock().0 as i64;
        // A fault planted by a test: the horizon is stated, but not kept. Half of each file's span lies in the past, so that every
        // file has contacts.
        let is_early = fault::is(Fault::EarlyHorizon);
        let horizon_us = if is_early { now_us + HORIZON_AGE_US / 2 } else { now_us - HORIZON_AGE_US };
        if !is_early {
            self.pipeline.set_contacts_from(horizon_us);
        }
        let Some(committer) = self.pipeline.idle_committer() else { return Ok(()) };
        let (writer, lease) = committer.database();
        if let Err(problem) = writer.state_horizon(lease, horizon_us).await {
            committer.failed(&problem, "cannot state the archive's horizon");
        }
        Ok(())
    }

    /// Tells robots the lengths of their whiskers if they have changed, and other tools the wear. While many publications
    /// wait for the broker, this waits, too: only the newest retained message of a robot matters.
    fn publish_estimates(&mut self) {
        if self.pipeline.take_losses() {
            self.workers.repeat_retained();
        }
        if self.pipeline.outbox_filling().is_none_or(|(waiting, most)| waiting < most / 2) {
            self.workers.publish_estimates(Instant::now());
            if let Some(every) = self.limits.maintenance_every {
                self.workers.publish_maintenance(Instant::now(), every);
            }
            self.pipeline.stepped(0, &self.workers);
        }
    }

    /// Schedules a commit if receipts are due, or if checkpoints have waited long enough.
    fn check_receipts(&mut self) {
        if self.workers.is_round_due(wall_clock()) {
            self.pipeline.schedule().receipts_are_due(Instant::now());
        }
    }
}

/// Ticks with this period, the first one after it.
fn every(period: Duration) -> Interval {
    let mut ticks = interval_at(Instant::now() + period, period);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    ticks
}

/// The next records of the log; waits for ever without a log. Cancel safe.
async fn next_batch(log: &mut Option<mpsc::Receiver<LogBatch>>) -> Option<LogBatch> {
    match log {
        Some(batches) => batches.recv().await,
        None => pending().await,
    }
}

/// Time for the core: not later than the receipt of the oldest message that waits.
fn now(inbox: &Inbox) -> Micros {
    let now = wall_clock();
    inbox.oldest().map_or(now, |oldest| oldest.min(now))
}

#[cfg(test)]
mod tests;
