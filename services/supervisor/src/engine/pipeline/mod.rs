//! The commit pipeline: open batches become transactions, one after the other, and their publications go out.
//!
//! - [`schedule`]: group commit, the time at which the open batches become a transaction.
//! - [`release`]: the last check of a publication, which must not leave before its commit.
//! - [`recovery`]: checkpoints are loaded, and the journal is replayed through the core.
//!
//! A transaction with a setpoint is sealed at once and kept short: it leaves receipts, and checkpoints that may wait, to the next
//! one.

pub(crate) mod recovery;
mod release;
pub(crate) mod schedule;

use std::collections::BTreeMap;
use std::future::pending;

use tokio::runtime::Handle;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::Instant;
use vibrissa_host::task;

use crate::engine::commit::checkpoint::{CheckpointRate, due_after};
use crate::engine::commit::committer::{Committed, Committer, LeaseLost, Written};
use crate::engine::commit::journal::index::JournalIndex;
use crate::engine::commit::transaction::{SealedTransaction, answers};
use crate::engine::fleet_metrics;
use crate::engine::worker::publication::Receipts;
use crate::engine::worker::workers::Workers;
use crate::metrics::FleetMetrics;
use crate::outbox::{Losses, Publication};
use release::may_go_out;
use schedule::Schedule;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::{Lease, LogPositions};

/// Number of contacts and whiskers' checkpoints up to which a transaction is written in the engine's own thread.
const SMALL: usize = 200;
/// Number of robots that get receipts at a time, ten times a second. If more are due, each robot's receipts are less
/// frequent.
const RECEIPTS_AT_ONCE: usize = 500;
/// Number of consecutive transactions that may leave due receipts to the next one.
const PASSED_OVER_MAX: u32 = 8;

/// A committed transaction that is not published yet.
pub(crate) struct CommittedTransaction {
    pub(crate) transaction: SealedTransaction,
    pub(crate) committed: Committed,
}

/// The transactions of one fleet.
pub(crate) struct Pipeline {
    lease: Lease,
    metrics: FleetMetrics,
    /// `None` while a transaction is being written.
    committer: Option<Committer>,
    /// The running write, if there is one.
    writing: Option<JoinHandle<Written>>,
    schedule: Schedule,
    journal: JournalIndex,
    /// Number of the newest committed transaction.
    committed: i64,
    rate: CheckpointRate,
    /// Actions whose answers are in the open batches.
    answered: Vec<i64>,
    /// Number of received messages whose effects are in the open batches.
    received: u64,
    /// Limit of the robots that get receipts with one transaction.
    receipts_max: usize,
    /// No contact is recorded as received before this time, µs since 1970 UTC: earlier ones may be archived.
    contacts_from_us: i64,
    /// Positions in the log that the open batches change; `None` without a log.
    log: Option<LogPositions>,
    outbox: Option<mpsc::Sender<Publication>>,
    /// Publications that may not have reached the broker.
    losses: Losses,
    /// Runtime for writes that would block the engine's own thread.
    background: Handle,
}

impl Pipeline {
    /// The pipeline of a recovered fleet, whose last transaction was `last`.
    pub(crate) fn new(committer: Committer, last: i64, metrics: FleetMetrics, background: Handle) -> Self {
        Self {
            lease: committer.lease().clone(),
            metrics,
            committer: Some(committer),
            writing: None,
            schedule: Schedule::new(Instant::now()),
            journal: JournalIndex::recovered(last),
            committed: last,
            rate: CheckpointRate::new(wall_clock()),
            answered: Vec::new(),
            received: 0,
            receipts_max: RECEIPTS_AT_ONCE,
            contacts_from_us: 0,
            log: None,
            outbox: None,
            losses: Losses::default(),
            background,
        }
    }

    /// Sets the channel of the publications, and the notes of its losses.
    pub(crate) fn connect(&mut self, outbox: mpsc::Sender<Publication>, losses: Losses) {
        (self.outbox, self.losses) = (Some(outbox), losses);
    }

    /// Sets the time before which no further contact is recorded as received; it never goes back.
    pub(crate) fn set_contacts_from(&mut self, at_us: i64) {
        self.contacts_from_us = self.contacts_from_us.max(at_us);
    }

    /// Prepares for contacts that come from a topic of a partitioned log.
    pub(crate) fn use_log(&mut self, topic: &str) {
        self.log = Some(LogPositions { topic: topic.into(), next: BTreeMap::new() });
        self.schedule.gather_for_a_tick();
    }

    /// Sets the first record of a partition that is not stepped.
    pub(crate) fn set_log_next(&mut self, partition: u32, next: i64) {
        if let Some(log) = &mut self.log {
            log.next.insert(partition, next);
        }
    }

    /// Whether publications may have been lost since the last call.
    pub(crate) fn take_losses(&mut self) -> bool {
        self.losses.take()
    }

    /// Number of publications that wait for the connection, and their limit.
    pub(crate) fn outbox_filling(&self) -> Option<(usize, usize)> {
        let outbox = self.outbox.as_ref()?;
        Some((outbox.max_capacity() - outbox.capacity(), outbox.max_capacity()))
    }

    /// When commits begin.
    pub(crate) fn schedule(&mut self) -> &mut Schedule {
        &mut self.schedule
    }

    /// When the next commit is due, if no other is being written.
    pub(crate) fn due(&self) -> Option<Instant> {
        self.schedule.due().filter(|_| self.writing.is_none())
    }

    /// Makes a commit of the open batches due now.
    pub(crate) fn commit_now(&mut self) {
        self.schedule.due_by(Instant::now());
    }

    /// Schedules a commit after `messages` messages, or other work with effects.
    pub(crate) fn stepped(&mut self, messages: usize, workers: &Workers) {
        self.schedule.count(messages);
        let now = Instant::now();
        if workers.is_urgent() {
            self.schedule.due_by(now);
        } else if !workers.is_empty() {
            self.schedule.has_gathered(now);
        }
    }

    /// Notes that `count` received messages are handled: they wait for the commit of the open batches, unless these are
    /// empty.
    pub(crate) fn took(&mut self, count: u64, workers: &Workers) {
        self.received += count;
        if workers.is_empty() {
            self.metrics.promises.committed(std::mem::take(&mut self.received));
        }
    }

    /// Whether a commit must begin now.
    pub(crate) fn is_due(&self, workers: &Workers) -> bool {
        let is_now = |due: Instant| due <= Instant::now();
        self.writing.is_none() && (self.schedule.due().is_some_and(is_now) || !workers.has_room())
    }

    /// Whether a transaction is being written.
    pub(crate) fn is_writing(&self) -> bool {
        self.writing.is_some()
    }

    /// Access to the database while no transaction is being written.
    pub(crate) fn idle_committer(&mut self) -> Option<&mut Committer> {
        self.committer.as_mut()
    }

    /// Number of the transaction that the open batches become.
    pub(crate) fn open_number(&self) -> i64 {
        self.journal.next()
    }

    /// Notes that the answer of an action is in the open batches.
    pub(crate) fn answer(&mut self, action_id: i64) {
        self.answered.push(action_id);
        self.commit_now();
    }

    /// Whether the open batches contain answers of actions.
    pub(crate) fn has_answers(&self) -> bool {
        !self.answered.is_empty()
    }

    /// Prepares the last transaction, which contains all receipts, and as many checkpoints as time allows.
    pub(crate) fn prepare_last(&mut self) {
        self.schedule.receipts_are_due(Instant::now());
        self.receipts_max = usize::MAX;
        self.rate = CheckpointRate::at_the_end(wall_clock());
    }

    /// Seals the open batches and starts to write them. `holds_journal` if checkpoints may be rejected, or robots are left to a
    /// newer program, so that journal entries are needed for longer.
    pub(crate) fn begin(&mut self, workers: &mut Workers, holds_journal: bool) {
        let Some(committer) = self.committer.take() else { return };
        let mut transaction = self.seal(workers, holds_journal);
        if transaction.is_empty() {
            self.metrics.promises.committed(transaction.received);
            self.committer = Some(committer);
            return;
        }
        if let Some(log) = &mut self.log
            && !transaction.rows.is_empty()
        {
            // Positions without rows wait for the next transaction.
            let next = std::mem::take(&mut log.next);
            transaction.rows.log = LogPositions { topic: log.topic.clone(), next };
        }
        let rows = transaction.rows.contacts.len() + transaction.rows.whiskers.len();
        let write = committer.write(transaction);
        // A small transaction is written in this thread, which avoids waking another.
        self.writing = Some(if rows <= SMALL { task::spawn(write) } else { task::spawn_on(&self.background, write) });
    }

    /// Seals the open batches of all workers, with the checkpoints that are due.
    fn seal(&mut self, workers: &mut Workers, holds_journal: bool) -> SealedTransaction {
        let now = wall_clock();
        let is_short = workers.is_urgent() && self.schedule.passed_over() < PASSED_OVER_MAX;
        let has_receipts = self.schedule.begin(is_short, Instant::now());
        self.rate.refill(now, self.journal.contacts());
        let mut transaction = SealedTransaction::new(self.journal.next(), std::mem::take(&mut self.answered));
        transaction.received = std::mem::take(&mut self.received);
        workers.set_checkpoints_after(due_after(self.log.is_some(), self.journal.contacts()));
        let receipts = has_receipts.then(|| Receipts { now, robots_max: self.receipts_max / workers.count() });
        workers.seal_into(&mut transaction, &mut self.rate, receipts);
        if self.contacts_from_us > 0 {
            for contact in &mut transaction.rows.contacts {
                contact.received_us = contact.received_us.max(self.contacts_from_us);
            }
        }
        self.journal.append(&transaction);
        self.journal.truncate(workers.oldest_entry(), (has_receipts, holds_journal), &mut transaction);
        workers.set_number(self.journal.next());
        transaction
    }

    /// Waits for the end of the running write; forever if there is none. Cancel safe.
    pub(crate) async fn written(&mut self) -> Written {
        let Some(task) = &mut self.writing else { return pending().await };
        let written = task.await;
        self.writing = None;
        // The task is never aborted, so an error means that it has panicked.
        written.unwrap_or_else(|ended| std::panic::resume_unwind(ended.into_panic()))
    }

    /// Takes the result of a write. The transaction must be given to [`Self::publish_committed`].
    pub(crate) fn committed(&mut self, written: Written) -> Result<CommittedTransaction, LeaseLost> {
        let Written { committer, mut transaction, result } = written;
        let committed = result?;
        self.metrics.promises.committed(std::mem::take(&mut transaction.received));
        self.metrics.promises.recorded();
        self.committed = transaction.number();
        self.committer = Some(committer);
        Ok(CommittedTransaction { transaction, committed })
    }

    /// Publishes after a commit.
    pub(crate) fn publish_committed(&self, committed: CommittedTransaction, workers: &mut Workers) {
        let CommittedTransaction { transaction, committed } = committed;
        fleet_metrics::observe_commit(&self.metrics, &transaction.times);
        let SealedTransaction { mut spans, publications, .. } = transaction;
        workers.spans_committed(&mut spans, committed.took);
        // Taken before publishing, because a robot may answer before `publish` returns.
        let at = wall_clock();
        let all = self.publish(publications, |publication| workers.published(publication, at));
        workers.spans_published(spans, at, all);
    }

    /// Publishes; returns false if messages were dropped. Nothing is lost if the broker is unreachable or the lease may
    /// have expired: setpoints are sent again until they are answered, receipts with the next message, and estimates
    /// after each loss. A retained message must not replace one of the next owner, so it goes out only while the lease
    /// holds. A receipt goes out also after that: the commit was fenced, so that the next owner, too, has the contacts.
    /// Otherwise a disk that needs longer than the lease's time to live would stop the fleet. `note` gets each one that
    /// goes out.
    pub(crate) fn publish(&self, publications: Vec<Publication>, mut note: impl FnMut(&Publication)) -> bool {
        let Some(outbox) = &self.outbox else { return true };
        let mut dropped = publications.len();
        let (is_fresh, fresh_until) = (self.lease.is_fresh(), self.lease.fresh_until());
        for one in publications {
            if one.is_withdrawn() {
                dropped -= 1;
                continue;
            }
            let is_allowed = is_fresh || one.states_a_commit();
            if !is_allowed || !may_go_out(&one, self.committed, self.lease.fleet(), &self.metrics) {
                continue;
            }
            let one = if one.is_retained() { Publication { until: fresh_until, ..one } } else { one };
            // Noted before the robot may answer.
            let Ok(place) = outbox.try_reserve() else { continue };
            self.metrics.promises.receipts_due(u64::from(one.states_a_commit()));
            note(&one);
            place.send(one);
            dropped -= 1;
        }
        if dropped > 0 {
            self.losses.note();
        }
        self.metrics.publications_dropped.inc_by(dropped as u64);
        dropped == 0
    }

    /// Forgets answers that are no longer in the open batches: their actions are pending again.
    pub(crate) fn retain_answers(&mut self, workers: &Workers) {
        let open: Vec<_> = workers.iter().map(|worker| answers(&worker.batch().rows().records)).collect();
        self.answered.retain(|action_id| open.iter().any(|ids| ids.contains(action_id)));
    }
}
