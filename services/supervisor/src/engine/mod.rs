//! One message's way: received, decoded, stepped through the core, committed, and only then answered.
//!
//! Each robot's state has one owner, a [`shard`]. What comes of some milliseconds of messages is gathered there, and
//! becomes one transaction ([`commit`]), while the next messages are stepped already; then setpoints and receipts
//! are published. What is published is therefore always committed; what is not committed is sent again by the robots.

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

/// Messages that are taken in at a time.
const MESSAGES_AT_A_TIME: usize = 1024;
/// Contacts of one commit at the most: then no more messages are taken in before it is done.
const CONTACTS_MAX: usize = 32_768;
/// Bytes of its journal row at the most, likewise.
const JOURNAL_BYTES_MAX: usize = 16 * 1024 * 1024;
/// Messages behind one commit at most, likewise. They stay in memory until it succeeds, in case the database refuses it.
const MESSAGES_MAX: usize = 65_536;
/// Whiskers whose states it writes because something was decided, likewise: some tenths of a second with their alarms.
const DECIDED_MAX: usize = 2500;
/// Ticks until it is looked again which robots are allowed.
const TICKS_A_LIST: u32 = 16;
/// Ticks until what was asked of the fleet at other supervisors is looked at again, and all robots are counted for the metrics ...
const TICKS_A_LOOK: u32 = 4;
/// ... or less often, where it would take more than this part of the time.
const SURVEY_SHARE: u32 = 50;
/// Shards of one fleet at the most.
const SHARDS_MAX: usize = 16;

/// A fleet's supervision: shards that own its robots, and one transaction after the other.
pub struct Engine {
    fleet: Name,
    lease: Lease,
    params: Arc<Params>,
    shards: Vec<Shard>,
    /// Here while nothing is being written.
    committer: Option<Committer>,
    committing: Option<JoinHandle<Done>>,
    /// Transactions that are kept, and whose rows are to be written, in order.
    kept: VecDeque<Sealed>,
    outbox: Option<mpsc::Sender<Publication>>,
    /// Where work is done that would hold up the engine's own thread.
    workers: Handle,
    /// What all fleets count together.
    program: Metrics,
    metrics: FleetMetrics,
    /// When what is gathered is committed.
    rounds: Rounds,
    /// Robots are not counted before then.
    survey_from: Instant,
    /// No more messages come: all receipts are sent at once.
    is_ending: bool,
    /// The number of the transaction that is gathered for.
    number: i64,
    /// Transactions whose entries are still in the journal, with their contacts.
    journal: VecDeque<(i64, usize)>,
    /// Contacts in the journal.
    journal_contacts: usize,
    pace: Pace,
    mailroom: Mailroom,
    /// Rings when something was asked of the fleet at this supervisor.
    bell: Arc<Notify>,
    /// Actions whose answers are in the batch.
    answered: Vec<i64>,
    /// The version of the policy in force; 0 while it is the configuration's.
    policy_version: i64,
    /// Robots whose rows the database has refused.
    suspects: BTreeMap<Name, Suspect>,
    readiness: Readiness,
    limits: Limits,
    /// How many more new robots are taken.
    new_robots: Bucket,
    allowed: AllowedSource,
}

/// One shard for each core.
fn shard_count() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from).min(SHARDS_MAX)
}

impl Engine {
    /// Takes up every robot of a fleet where the last commit left it.
    ///
    /// # Errors
    /// The database cannot be used.
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
        info!(%fleet, epoch, robots, "supervising");
        // As if heard: a fleet that stays silent is silent from here on.
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
            // What is there was gone through: it is forgotten with the states that are written first.
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

    /// The same with traces, if there is a collector: those of setpoints that were sent before go on.
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

    /// The same with another policy of which contacts are kept one by one.
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

    /// The same engine with other limits on the number of robots.
    #[must_use]
    pub(crate) fn limited(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self.new_robots = Bucket::new(limits.new_robots_per_minute, limits.new_robots_per_minute);
        self
    }

    /// Runs until no more messages can come, and what was taken in is committed; or until the fleet is somebody
    /// else's, who has the robots send again what was not committed.
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
                        // It may be in this thread, too.
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

    /// What is done at each tick, beside telling the core what time it is. All of it together: each wake-up costs far more than a
    /// message, because it finds everything cold.
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
            // Asked at another supervisor, perhaps.
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

    /// Commits what is left, and receipts it. States are written, too, so that whoever takes the fleet up has nothing to go
    /// through; of very many only some, for there is little time.
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

    /// Whether more may be gathered for the next commit.
    fn has_room(&self) -> bool {
        let gatherings = || self.shards.iter().map(|shard| &shard.gathering);
        gatherings().map(|one| one.batch.contacts.len()).sum::<usize>() < CONTACTS_MAX
            && gatherings().map(|one| one.journal.bytes()).sum::<usize>() < JOURNAL_BYTES_MAX
            && gatherings().map(|one| one.messages.len()).sum::<usize>() < MESSAGES_MAX
            && gatherings().map(|one| one.waiting.next_whiskers()).sum::<usize>() < DECIDED_MAX
    }

    /// So many messages were handled, or something else was done: what has come of it is committed soon.
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

    /// Receipts are sent with the next transaction, or alone if there is none; states that have waited are written.
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

    /// The time for the core: not later than what it has yet to hear.
    fn now(&self, inbox: &Inbox) -> Micros {
        let now = wall_clock();
        inbox.oldest().map_or(now, |oldest| oldest.min(now))
    }

    /// Tells the core what time it is; false if there was not room enough for what comes of it, and it goes on later.
    fn tick(&mut self, now: Micros) -> bool {
        let whiskers_max = DECIDED_MAX / self.shards.len();
        let is_under_way = self.shards.iter().any(|shard| shard.told_until.is_some());
        let mut is_done = true;
        for shard in &mut self.shards {
            // A shard that is through waits for the others.
            if !is_under_way || shard.told_until.is_some() {
                is_done &= shard.tick(now, whiskers_max);
            }
        }
        self.gathered(0);
        is_done
    }

    /// No robot was silent while the broker was away, or while its messages were left out.
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

    /// No robot was silent while we were deaf.
    fn listen_anew(&mut self) {
        let now = wall_clock();
        for shard in &mut self.shards {
            shard.listen_from(now);
        }
    }
}

/// A pressure as a bare number, if there is one.
fn mpa(pressure: Option<Megapascal>) -> Option<f64> {
    pressure.map(Megapascal::mpa)
}

#[cfg(test)]
mod tests;
