//! The workers of a fleet.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::time::Instant;
use vibrissa_core::robot::{Event, Outcome, Params};
use vibrissa_core::units::Micros;
use vibrissa_host::task;
use vibrissa_protocol::Name;

use super::Worker;
use super::publication::Receipts;
use crate::ending::Ending;
use crate::engine::allow_list::AllowList;
use crate::engine::commit::checkpoint::CheckpointRate;
use crate::engine::commit::transaction::SealedTransaction;
use crate::engine::message::RawMessage;
use crate::engine::part::{Part, index_of};
use crate::engine::robot::KnownRobot;
use crate::engine::robot::retention::ContactRetention;
use crate::engine::rollout::trial::TrialParams;
use crate::inbox::Delayed;
use crate::outbox::Publication;
use crate::trace::{PendingSpans, TracedAction};
use vibrissa_store::allowed::TurnedAwayReading;
use vibrissa_store::batch::Record;
use vibrissa_store::events::write::EventRow;
use vibrissa_store::maintenance_facts::LastTest;

/// Limit of contacts per transaction: at the limit, no more messages are taken in until it is committed.
const CONTACTS_MAX: usize = 32_768;
/// Limit of journal bytes per transaction, likewise.
const JOURNAL_BYTES_MAX: usize = 16 * 1024 * 1024;
/// Limit of messages per transaction, likewise. They stay in memory until the commit succeeds, in case the database
/// rejects it.
const MESSAGES_MAX: usize = 65_536;
/// Limit of whiskers whose checkpoints a transaction must write because of decisions, likewise. Their rows and alarms
/// take some tenths of a second.
const DECIDED_MAX: usize = 2500;
/// Limit of the whiskers whose minutes are closed in one commit. Their checkpoints are written with them, and a robot's
/// checkpoint includes all its changed whiskers.
const CLOSED_AT_ONCE: usize = 5000;
/// Number of messages from which on the workers work in tasks of their own.
const WORTH_TASKS: usize = 128;
/// Payload bytes from which on the workers work in tasks, about a millisecond's work. Meanwhile this thread receives, so
/// that no robot's messages wait in the broker behind those of a robot that sends much.
const WORTH_A_TASK_BYTES: usize = 128 * 1024;

/// Limit of the whiskers whose estimates are published at a time, in all workers: 0.6 MB. After a takeover, a large fleet
/// gets its estimates within seconds.
const ESTIMATED_AT_ONCE: usize = 4000;

/// All robots of a fleet, each owned by one worker.
pub(crate) struct Workers {
    workers: Vec<Worker>,
}

impl Workers {
    /// At least one worker.
    pub(crate) fn new(workers: Vec<Worker>) -> Self {
        Self { workers }
    }

    /// Number of workers.
    pub(crate) fn count(&self) -> usize {
        self.workers.len()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Worker> {
        self.workers.iter()
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Worker> {
        self.workers.iter_mut()
    }

    /// The worker that owns a robot of this name.
    pub(crate) fn of(&mut self, robot: &Name) -> &mut Worker {
        let at = index_of(robot, self.workers.len());
        &mut self.workers[at]
    }

    /// A robot, if it is known.
    pub(crate) fn robot(&self, name: &Name) -> Option<&KnownRobot> {
        self.workers[index_of(name, self.workers.len())].robots().get(name)
    }

    /// All known robots.
    pub(crate) fn robots(&self) -> impl Iterator<Item = &KnownRobot> {
        self.workers.iter().flat_map(|worker| worker.robots().values())
    }

    /// The robots that the allow list does not exclude.
    pub(crate) fn in_service(&self) -> impl Iterator<Item = &KnownRobot> {
        self.robots().filter(|known| !known.is_excluded)
    }

    pub(crate) fn robots_mut(&mut self) -> impl Iterator<Item = &mut KnownRobot> {
        self.workers.iter_mut().flat_map(|worker| worker.robots_mut().values_mut())
    }

    /// Whether robots wait for a newer version of the program, which needs their journal entries.
    pub(crate) fn leave_robots(&self) -> bool {
        self.workers.iter().any(|worker| !worker.of_newer_program().is_empty())
    }

    /// The robots that wait for a newer version of the program, in words; `None` without any.
    pub(crate) fn left_to_newer_program(&self) -> Option<String> {
        const NAMES_MAX: usize = 10;
        let names: Vec<&str> =
            self.workers.iter().flat_map(|worker| worker.of_newer_program().keys()).map(Name::as_str).collect();
        let list = names.iter().take(NAMES_MAX).copied().collect::<Vec<_>>().join(", ");
        (!names.is_empty()).then(|| {
            format!(
                "a newer vibrissa has written the state of {} robots ({list}), which are not supervised: start the newer program",
                names.len()
            )
        })
    }

    /// Number of known robots.
    pub(crate) fn robot_count(&self) -> usize {
        self.workers.iter().map(|worker| worker.robots().len()).sum()
    }

    /// Whether the open batches may take more.
    pub(crate) fn has_room(&self) -> bool {
        let batches = || self.workers.iter().map(Worker::batch);
        self.contacts() < CONTACTS_MAX
            && batches().map(|batch| batch.journal_bytes()).sum::<usize>() < JOURNAL_BYTES_MAX
            && batches().map(|batch| batch.message_count()).sum::<usize>() < MESSAGES_MAX
            && batches().map(|batch| batch.decided_whiskers()).sum::<usize>() < DECIDED_MAX
    }

    /// Number of contacts with rows in the open batches.
    pub(crate) fn contacts(&self) -> usize {
        self.workers.iter().map(|worker| worker.batch().rows().contacts.len()).sum()
    }

    /// Whether a setpoint waits for the commit of the open batches.
    pub(crate) fn is_urgent(&self) -> bool {
        self.workers.iter().any(|worker| worker.batch().is_urgent())
    }

    /// Whether there is nothing to commit or to publish.
    pub(crate) fn is_empty(&self) -> bool {
        self.workers.iter().all(|worker| worker.batch().is_empty())
    }

    /// Whether receipts, or checkpoints that have waited long enough, are due.
    pub(crate) fn is_round_due(&mut self, now: Micros) -> bool {
        let is_checkpoint_due = self.workers.iter_mut().any(|worker| worker.is_checkpoint_due(now));
        is_checkpoint_due || self.workers.iter().any(Worker::is_receipt_due)
    }

    /// Handles messages, by worker. Many are handled by tasks of `background`; each worker is owned by one task until it is
    /// done.
    pub(crate) async fn handle(&mut self, messages: &mut [Vec<RawMessage>], are_in_log: bool, background: &Handle) {
        let busy = messages.iter().filter(|messages| !messages.is_empty()).count();
        let is_few = busy <= 1 || messages.iter().map(Vec::len).sum::<usize>() < WORTH_TASKS;
        let bytes: usize = messages.iter().flatten().map(|raw| raw.payload.len()).sum();
        if is_few && bytes < WORTH_A_TASK_BYTES {
            for (worker, messages) in self.workers.iter_mut().zip(messages) {
                worker.handle_all(messages, are_in_log);
            }
            return;
        }
        let mut tasks = Vec::with_capacity(self.workers.len());
        for (mut worker, messages) in self.workers.drain(..).zip(messages) {
            let mut messages = std::mem::take(messages);
            tasks.push(task::spawn_on(background, async move {
                worker.handle_all(&mut messages, are_in_log);
                worker
            }));
        }
        for task in tasks {
            // The task is never aborted, so an error means that it has panicked.
            let worker: Worker = task.await.unwrap_or_else(|ended| std::panic::resume_unwind(ended.into_panic()));
            self.workers.push(worker);
        }
    }

    /// Records a message that was published to a robot.
    pub(crate) fn published(&mut self, publication: &Publication, at: Micros) {
        self.of(&publication.robot).published(publication, at);
    }

    /// Ends the open black boxes before their time, because supervision ends.
    pub(crate) fn end_boxes(&mut self, now: Micros) {
        for worker in &mut self.workers {
            worker.end_boxes(now);
        }
    }

    /// Steps one robot; `None` if it is not known.
    pub(crate) fn step(&mut self, name: &Name, now: Micros, event: &Event<'_>) -> Option<Outcome> {
        self.of(name).step_robot(name, now, event)
    }

    /// Steps the tick through all robots. Returns false if it stopped because the batches are full; then it must
    /// continue later.
    pub(crate) fn tick(&mut self, now: Micros, delayed: &Delayed) -> bool {
        let whiskers_max = DECIDED_MAX / self.workers.len();
        let is_under_way = self.workers.iter().any(Worker::is_tick_under_way);
        let mut is_done = true;
        for worker in &mut self.workers {
            // A worker that is done waits for the others.
            if !is_under_way || worker.is_tick_under_way() {
                is_done &= worker.tick(now, delayed, whiskers_max);
            }
        }
        is_done
    }

    /// Whether a message of a robot came since the last call whose birth was not received.
    pub(crate) fn take_unannounced(&mut self) -> bool {
        let of_worker = |worker: &mut Worker| std::mem::take(&mut worker.stepper_mut().has_unannounced);
        self.workers.iter_mut().map(of_worker).fold(false, |any, one| any | one)
    }

    /// Restarts the silence timers of all robots, because this supervisor was deaf.
    pub(crate) fn restart_silence_timers(&mut self, now: Micros) {
        for worker in &mut self.workers {
            worker.restart_silence_timers(now);
        }
    }

    /// Publishes the estimates that are due with the next transaction, those of some robots later if there are many.
    pub(crate) fn publish_estimates(&mut self, now: Instant) {
        let each = ESTIMATED_AT_ONCE / self.workers.len();
        for worker in &mut self.workers {
            worker.publish_estimates(now, each);
            worker.clear_former();
        }
    }

    /// Publishes the facts for the maintenance of robots that are due, in the same way.
    pub(crate) fn publish_maintenance(&mut self, now: Instant, every: Duration) {
        let each = ESTIMATED_AT_ONCE / self.workers.len();
        for worker in &mut self.workers {
            worker.publish_maintenance(now, every, each);
        }
    }

    /// Makes the retained messages of all robots due, and the clearing of those of former robots: some may not have reached
    /// the broker.
    pub(crate) fn repeat_retained(&mut self) {
        for known in self.robots_mut() {
            known.estimates.repeat();
            known.maintenance.repeat();
        }
        self.workers.iter_mut().for_each(Worker::repeat_clearing);
    }

    /// Takes over when touch tests of whiskers have ended, by rows of whiskers.
    pub(crate) fn know_tests(&mut self, last: &[LastTest]) {
        let ended: BTreeMap<i64, i64> = last.iter().map(|one| (one.whisker_id, one.ended_us)).collect();
        for known in self.robots_mut() {
            for id in &known.whisker_ids {
                if let Some(&ended_us) = ended.get(id) {
                    known.maintenance.tested(*id, ended_us);
                }
            }
        }
    }

    /// Closes finished minutes and hours, including those of silent whiskers; in a large fleet a limited number at a
    /// time.
    pub(crate) fn close_history(&mut self, now: Micros) {
        let mut left = CLOSED_AT_ONCE;
        for worker in &mut self.workers {
            worker.close_history(now, &mut left);
        }
    }

    /// Adds a row that no effect of a robot has caused, and its event, after the rows of all workers so far.
    pub(crate) fn record(&mut self, record: Record, event: Option<EventRow>) {
        if let Some(last) = self.workers.last_mut() {
            let rows = last.batch_mut().rows_mut();
            rows.records.push(record);
            rows.events.extend(event);
        }
    }

    /// Sets which contacts get a row of their own. Contacts remembered so far are forgotten.
    pub(crate) fn set_retention(&mut self, retention: ContactRetention) {
        for worker in &mut self.workers {
            worker.stepper_mut().set_retention(retention);
            for known in worker.robots_mut().values_mut() {
                known.history.set_retention(retention);
            }
        }
    }

    /// Sets the parameters for all robots.
    pub(crate) fn set_params(&mut self, params: &Arc<Params>) {
        for worker in &mut self.workers {
            worker.stepper_mut().set_params(params.clone());
        }
    }

    /// Sets the parameters of the robots that a roll-out has changed; `None` without one.
    pub(crate) fn set_trial(&mut self, trial: Option<&TrialParams>) {
        for worker in &mut self.workers {
            worker.stepper_mut().set_trial(trial.cloned());
        }
    }

    /// Sets the allow list.
    pub(crate) fn set_allow_list(&mut self, list: &AllowList) {
        for worker in &mut self.workers {
            worker.set_allow_list(list.clone());
        }
    }

    /// Robots that are not on the allow list; `None` if none have been added or removed since they were written.
    pub(crate) fn refused_robots(&self) -> Option<Vec<TurnedAwayReading>> {
        let lists = || self.workers.iter().map(Worker::refused_robots);
        lists().any(|list| list.has_changed()).then(|| lists().flat_map(|list| list.rows()).collect())
    }

    /// Notes that the robots that are not on the allow list are written.
    pub(crate) fn refused_robots_written(&mut self) {
        for worker in &mut self.workers {
            worker.refused_robots_mut().written();
        }
    }

    /// Makes the journals refer to a partitioned log.
    pub(crate) fn use_log(&mut self) {
        let of = self.workers.len() as u16;
        for (worker, number) in self.workers.iter_mut().zip(0..) {
            worker.set_part(Part { number, of });
        }
    }

    /// Sets the age at which checkpoints are due.
    pub(crate) fn set_checkpoints_after(&mut self, after: Micros) {
        for worker in &mut self.workers {
            worker.batch_mut().checkpoints().set_after(after);
        }
    }

    /// Makes all waiting checkpoints due.
    pub(crate) fn make_checkpoints_due(&mut self) {
        for worker in &mut self.workers {
            worker.batch_mut().checkpoints().make_due();
        }
    }

    /// Seals the open batches, with the checkpoints that are due.
    pub(crate) fn seal_into(
        &mut self,
        transaction: &mut SealedTransaction,
        rate: &mut CheckpointRate,
        receipts: Option<Receipts>,
    ) {
        for worker in &mut self.workers {
            worker.seal_into(transaction, rate, receipts);
        }
    }

    /// Number of the first journal entry that a recovery needs; `None` if it needs none.
    pub(crate) fn oldest_entry(&mut self) -> Option<i64> {
        self.workers.iter_mut().filter_map(Worker::oldest_entry).min()
    }

    /// Sets the number of the transaction that the open batches become.
    pub(crate) fn set_number(&mut self, number: i64) {
        for worker in &mut self.workers {
            worker.batch_mut().set_number(number);
        }
    }

    /// Takes receipts and other publications without a commit, for a fault planted by a test.
    pub(crate) fn take_publications(&mut self) -> Vec<Publication> {
        let mut publications = Vec::new();
        for worker in &mut self.workers {
            worker.publish_receipts(usize::MAX);
            publications.append(&mut worker.batch_mut().take_publications());
        }
        publications
    }

    /// Sets the action in execution, which the traces of its effects name; `None` after it.
    pub(crate) fn set_action(&mut self, action: Option<&TracedAction>) {
        for traces in self.workers.iter_mut().filter_map(|worker| worker.stepper_mut().traces_mut()) {
            traces.set_action(action.cloned());
        }
    }

    /// Exports the spans of a transaction after its commit, by worker.
    pub(crate) fn spans_committed(&mut self, spans: &mut [PendingSpans], took: Duration) {
        for (worker, spans) in self.workers.iter_mut().zip(spans) {
            if let Some(traces) = worker.stepper_mut().traces_mut() {
                traces.committed(spans, took);
            }
        }
    }

    /// Adds the spans of the publications; `all` is false if some could not be published.
    pub(crate) fn spans_published(&mut self, spans: Vec<PendingSpans>, at: Micros, all: bool) {
        for (worker, spans) in self.workers.iter_mut().zip(spans) {
            if let Some(traces) = worker.stepper_mut().traces_mut() {
                traces.published(spans, at, all);
            }
        }
    }

    /// Ends the traces.
    pub(crate) fn end_traces(&mut self, ending: Ending) {
        for traces in self.workers.iter_mut().filter_map(|worker| worker.stepper_mut().traces_mut()) {
            traces.end(ending);
        }
    }
}
