//! Processing of messages: received, decoded, stepped through the core, committed, and only then answered.
//!
//! Each robot's state has one owner, a [`shard`]. The effects of some milliseconds of messages are collected there and
//! become one transaction ([`commit`]), while the next messages are stepped; then setpoints and receipts are published.
//! Thus everything published is committed, and robots send again whatever is not committed.

pub mod actions;
mod allowed;
mod announced;
mod boots;
mod commands;
mod commit;
mod dispatch;
mod fingerprints;
mod fleet_metrics;
mod history;
mod intake;
mod limits;
mod publication;
mod quarantine;
mod record;
pub mod retention;
pub mod rollup;
mod shard;

pub use limits::Limits;
pub use retention::Keep;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use tokio::runtime::Handle;
use tokio::sync::{Notify, mpsc};
use tokio::task::{JoinHandle, yield_now};
use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until};
use tracing::info;
use vibrissa_core::robot::Params;
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_protocol::{BootId, Name};

use crate::ending::Ending;
use crate::inbox::Inbox;
use crate::mailroom::Mailroom;
use crate::metrics::{FleetMetrics, Metrics};
use crate::outbox::Publication;
use crate::params;
use crate::readiness::Readiness;
use crate::trace::{Lives, Traces};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::fault::{self, Fault};
use vibrissa_store::{Lease, StoreError, Writer};

use allowed::AllowedSource;
use announced::Announced;
use commit::batch::{Gathering, Sealed};
use commit::checkpoint::Pace;
use commit::committer::{Committer, LeaseLost};
use commit::pipeline::{Done, done};
use commit::schedule::{RECEIPTS, Rounds, TICK};
use limits::Bucket;
use quarantine::suspects::Suspect;
use shard::{Shard, shard_of};

/// Largest number of messages taken from the inbox at a time.
const MESSAGES_AT_A_TIME: usize = 1024;
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
/// Ticks between two checks of the allow list (4 s).
const TICKS_A_LIST: u32 = 16;
/// Ticks between two reads of the actions sent to other supervisors, and between two surveys of all robots for the
/// metrics (1 s).
const TICKS_A_LOOK: u32 = 4;
/// A survey takes at most one part in this many of the time; otherwise surveys are less frequent.
const SURVEY_SHARE: u32 = 50;
/// Largest number of shards per fleet.
const SHARDS_MAX: usize = 16;

/// Supervision of one fleet: shards that own its robots, and a sequence of transactions.
pub struct Engine {
    fleet: Name,
    lease: Lease,
    params: Arc<Params>,
    shards: Vec<Shard>,
    /// `None` while a transaction is being written.
    committer: Option<Committer>,
    committing: Option<JoinHandle<Done>>,
    /// Transactions whose intents are committed, and whose rows must be written, in order.
    kept: VecDeque<Sealed>,
    outbox: Option<mpsc::Sender<Publication>>,
    /// Runtime for work that would block the engine's own thread.
    workers: Handle,
    /// Metrics shared by all fleets.
    program: Metrics,
    metrics: FleetMetrics,
    /// Schedule of the commits.
    rounds: Rounds,
    /// Time of the next survey of the robots, at the earliest.
    survey_from: Instant,
    /// No more messages arrive: all receipts are sent at once.
    is_ending: bool,
    /// Number of the last sealed transaction.
    number: i64,
    /// Transactions whose entries are still in the journal, with the number of their contacts.
    journal: VecDeque<(i64, usize)>,
    /// Number of contacts in the journal.
    journal_contacts: usize,
    pace: Pace,
    mailroom: Mailroom,
    /// Notified when an action for the fleet is sent to this supervisor.
    bell: Arc<Notify>,
    /// Actions whose answers are in the open batch.
    answered: Vec<i64>,
    /// Version of the policy in force; 0 while it is the configuration's.
    policy_version: i64,
    /// Robots whose rows the database has rejected.
    suspects: BTreeMap<Name, Suspect>,
    readiness: Readiness,
    limits: Limits,
    /// Limits the rate of new robots.
    new_robots: Bucket,
    allowed: AllowedSource,
}

/// One shard per core.
fn shard_count() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from).min(SHARDS_MAX)
}

impl Engine {
    /// Loads every robot of a fleet as of the last commit.
    ///
    /// # Errors
    /// The database cannot be used, or the lease is lost.
    pub async fn start(
        lease: Lease,
        boot_id: BootId,
        params: Arc<Params>,
        mut writer: Writer,
        program: Metrics,
        readiness: Readiness,
        mailroom: Mailroom,
    ) -> Result<Self, StoreError> {
        let (fleet, epoch) = (lease.fleet().clone(), lease.epoch());
        let policy = writer.policy(&lease).await?;
        let params = params::with_policy(params, policy.as_ref());
        let params = params::with_calibrations(params, &writer.calibrations(&lease).await?);
        let metrics = program.of_fleet(&fleet);
        let shard = || Shard {
            robots: Default::default(),
            announced: Announced::of_shards(shard_count()),
            epoch,
            told_until: None,
            gathering: Gathering::new(fleet.clone(), boot_id.clone(), params.clone(), metrics.clone()),
        };
        let mut shards: Vec<Shard> = (0..shard_count()).map(|_| shard()).collect();
        let allowed = writer.allowed_robots(&lease, 0).await?;
        let last = commit::recovery::take_up(&mut writer, &lease, &mut shards).await?;
        let robots: usize = shards.iter().map(|shard| shard.robots.len()).sum();
        info!(%fleet, epoch, robots, "fleet loaded, supervision starts");
        // As if a contact had just arrived, so that a silent fleet counts as silent from now on.
        metrics.last_contact_timestamp_seconds.set(wall_clock().as_s());
        let committer = Committer {
            fleet: fleet.clone(),
            lease: lease.clone(),
            writer,
            program: program.clone(),
            metrics: metrics.clone(),
            readiness: readiness.clone(),
        };
        let mut engine = Self {
            bell: mailroom.bell(&fleet),
            mailroom,
            answered: Vec::new(),
            policy_version: policy.map_or(0, |policy| policy.version),
            suspects: BTreeMap::new(),
            readiness,
            fleet,
            lease,
            params,
            shards,
            committer: Some(committer),
            committing: None,
            kept: VecDeque::new(),
            outbox: None,
            workers: Handle::current(),
            program,
            metrics,
            rounds: Rounds::new(Instant::now()),
            survey_from: Instant::now(),
            is_ending: false,
            number: last,
            // The journal so far was replayed; it is deleted once the first checkpoints are written.
            journal: (last > 0).then_some((last, 0)).into_iter().collect(),
            journal_contacts: 0,
            pace: Pace::new(wall_clock()),
            limits: Limits::default(),
            new_robots: Bucket::new(0, 0),
            allowed: AllowedSource::default(),
        };
        engine = engine.limited(Limits::default());
        if let Some(allowed) = &allowed {
            engine.set_allowed(allowed);
        }
        engine.number_gatherings();
        engine.show_params();
        engine.survey_robots();
        Ok(engine)
    }

    /// Adds traces, if there is a collector; those of setpoints under way are continued.
    #[must_use]
    pub(crate) fn traced(mut self, traces: Option<&Traces>) -> Self {
        for shard in &mut self.shards {
            shard.gathering.lives = traces.map(|traces| {
                let mut lives = Lives::new(traces.clone(), self.fleet.clone());
                for known in shard.robots.values() {
                    lives.take_up(&known.name, known.robot_id, &known.robot);
                }
                lives
            });
        }
        self
    }

    /// Sets which contacts get a row of their own.
    #[must_use]
    pub(crate) fn keeping(mut self, keep: Keep) -> Self {
        for shard in &mut self.shards {
            shard.gathering.keep = keep;
            for known in shard.robots.values_mut() {
                known.history.keep(keep);
            }
        }
        self
    }

    /// Sets the limits on the number of robots.
    #[must_use]
    pub(crate) fn limited(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self.new_robots = Bucket::new(limits.new_robots_per_minute, limits.new_robots_per_minute);
        self
    }

    /// Runs until no more messages can arrive and all are committed, or until the lease is lost. In the latter case
    /// robots send their uncommitted messages again to the new owner.
    pub async fn run(mut self, inbox: Inbox, outbox: mpsc::Sender<Publication>) -> Ending {
        self.outbox = Some(outbox);
        let ending = match self.work(inbox).await {
            Ok(()) => Ending::Stopped,
            Err(LeaseLost) => Ending::LeaseLost,
        };
        for lives in self.shards.iter_mut().filter_map(|shard| shard.gathering.lives.as_mut()) {
            lives.end(ending);
        }
        ending
    }

    async fn work(&mut self, mut inbox: Inbox) -> Result<(), LeaseLost> {
        let every = |period| {
            let mut ticks = interval(period);
            ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
            ticks
        };
        let (mut ticks, mut receipts) = (every(TICK), every(RECEIPTS));
        let bell = self.bell.clone();
        let mut messages = Vec::with_capacity(MESSAGES_AT_A_TIME);
        let mut is_ticking = false;
        loop {
            let has_room = self.has_room();
            inbox.begin_round(self.rounds.number());
            let due = self.rounds.due().filter(|_| self.committing.is_none());
            tokio::select! {
                done = done(&mut self.committing) => self.committed(done)?,
                () = async { sleep_until(due.unwrap_or_else(Instant::now)).await }, if due.is_some() => {}
                count = inbox.recv_many(&mut messages, MESSAGES_AT_A_TIME), if has_room => {
                    if count == 0 {
                        break;
                    }
                    self.take_in(&mut messages).await?;
                    if inbox.is_throttling() {
                        self.rounds.are_waited_for();
                    }
                    if self.committing.is_some() {
                        // The commit may run in this thread.
                        yield_now().await;
                    }
                }
                _ = ticks.tick() => {
                    self.at_tick(&inbox).await?;
                    is_ticking = true;
                }
                () = bell.notified() => {
                    self.open_mail(self.now(&inbox)).await?;
                    self.look_at_allowed().await?;
                }
                _ = receipts.tick(), if !self.rounds.are_few() => self.look_at_receipts(),
            }
            if !self.suspects.is_empty() {
                self.go_on_with_suspects().await?;
            }
            if std::mem::take(&mut self.allowed.has_changed) {
                inbox.want_retained();
            }
            if is_ticking && self.has_room() {
                is_ticking = !self.tick(self.now(&inbox));
            }
            if self.is_due() {
                self.begin_commit();
            }
        }
        self.finish().await
    }

    /// Periodic work besides the core's ticks. It is done together, because each wake-up finds cold caches and costs
    /// far more than a message.
    async fn at_tick(&mut self, inbox: &Inbox) -> Result<(), LeaseLost> {
        self.settle().await?;
        self.listen_anew_if_deaf(inbox);
        let (number, is_round) = self.rounds.tick();
        if is_round {
            self.look_at_receipts();
        }
        if number.is_multiple_of(TICKS_A_LIST) {
            self.look_at_allowed().await?;
        }
        if number.is_multiple_of(TICKS_A_LOOK) {
            // Actions may have been sent to another supervisor.
            self.open_mail(self.now(inbox)).await?;
            self.survey_queues(inbox);
            if self.survey_from <= Instant::now() {
                let begun = Instant::now();
                self.survey_robots();
                self.survey_from = begun + begun.elapsed() * SURVEY_SHARE;
            }
            self.close_history(self.now(inbox));
        }
        Ok(())
    }

    /// Commits and receipts everything. Checkpoints are written, too, so that the next owner need not replay the
    /// journal; in a very large fleet only some of them, because time is limited.
    async fn finish(&mut self) -> Result<(), LeaseLost> {
        self.settle().await?;
        self.rounds.receipts_are_due(Instant::now());
        self.is_ending = true;
        self.pace = Pace::at_the_end(wall_clock());
        for shard in &mut self.shards {
            shard.no_longer_wait();
        }
        self.begin_commit();
        self.settle().await
    }

    /// Whether the open batches may take more.
    fn has_room(&self) -> bool {
        let gatherings = || self.shards.iter().map(|shard| &shard.gathering);
        gatherings().map(|one| one.batch.contacts.len()).sum::<usize>() < CONTACTS_MAX
            && gatherings().map(|one| one.journal.bytes()).sum::<usize>() < JOURNAL_BYTES_MAX
            && gatherings().map(|one| one.messages.len()).sum::<usize>() < MESSAGES_MAX
            && gatherings().map(|one| one.waiting.next_whiskers()).sum::<usize>() < DECIDED_MAX
    }

    /// Schedules a commit after `messages` messages, or other work with effects.
    fn gathered(&mut self, messages: usize) {
        self.rounds.heard(messages);
        let now = Instant::now();
        if self.is_urgent() {
            self.rounds.due_by(now);
        } else if self.shards.iter().any(|shard| !shard.gathering.is_empty()) {
            self.rounds.has_gathered(now);
        }
    }

    fn is_due(&self) -> bool {
        let is_now = |due: Instant| due <= Instant::now();
        self.committing.is_none()
            && (self.rounds.due().is_some_and(is_now) || !self.has_room() || !self.kept.is_empty())
    }

    /// Schedules a commit if receipts are due, or if checkpoints have waited long enough.
    fn look_at_receipts(&mut self) {
        let now = wall_clock();
        let is_state_due = self.shards.iter_mut().any(|shard| shard.is_state_due(now));
        let is_receipt_due = self.shards.iter().any(|shard| !shard.gathering.receipts_due.is_empty());
        if fault::is(Fault::ReceiptBeforeCommit) {
            self.receipt_at_once();
        }
        if is_receipt_due || is_state_due {
            self.rounds.receipts_are_due(Instant::now());
        }
    }

    /// Time for the core: not later than the receipt of the oldest message that waits.
    fn now(&self, inbox: &Inbox) -> Micros {
        let now = wall_clock();
        inbox.oldest().map_or(now, |oldest| oldest.min(now))
    }

    /// Steps the tick through all robots. Returns false if it stopped because the batches are full; then it must
    /// continue later.
    fn tick(&mut self, now: Micros) -> bool {
        let whiskers_max = DECIDED_MAX / self.shards.len();
        let is_under_way = self.shards.iter().any(|shard| shard.told_until.is_some());
        let mut is_done = true;
        for shard in &mut self.shards {
            // A shard that is done waits for the others.
            if !is_under_way || shard.told_until.is_some() {
                is_done &= shard.tick(now, whiskers_max);
            }
        }
        self.gathered(0);
        is_done
    }

    /// Restarts silence timers after the broker was unreachable or messages were shed, because the robots may have
    /// sent.
    fn listen_anew_if_deaf(&mut self, inbox: &Inbox) {
        let (robots, others) = inbox.take_shed();
        if self.metrics.broker_connected.get() == 0 || others > 0 {
            return self.listen_anew();
        }
        let now = wall_clock();
        let names = robots.iter().filter_map(|shed| Name::robot(std::str::from_utf8(&shed.robot).ok()?).ok());
        for name in names {
            let at = shard_of(&name, self.shards.len());
            self.shards[at].listen_to_one_from(&name, now);
        }
    }

    /// Restarts the silence timers of all robots, because this supervisor was deaf.
    fn listen_anew(&mut self) {
        let now = wall_clock();
        for shard in &mut self.shards {
            shard.listen_from(now);
        }
    }
}

/// A pressure in MPa, if there is one.
fn mpa(pressure: Option<Megapascal>) -> Option<f64> {
    pressure.map(Megapascal::mpa)
}

#[cfg(test)]
mod tests;
