//! One message's way: received, decoded, stepped through the core, committed, and only then answered.
//!
//! One task owns every robot's state. It gathers messages for a few milliseconds, steps each through the
//! core, writes all that came of them in one transaction, and then publishes setpoints and receipts. What
//! is published is therefore always committed; what is not committed is sent again by the robots.

mod history;
mod intake;
pub mod keep;
pub mod mail;
mod outage;
mod publication;
mod record;
pub mod rollup;
mod survey;

pub use keep::Keep;
pub(crate) use publication::{command_uuid, compensation_uuid};
pub(crate) use record::wide_id;
pub use rollup::Resolution;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::Bytes;
use tokio::sync::{Notify, mpsc};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout_at};
use tracing::{error, info};
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::{Event, OperatorAction, Outcome, Params, Robot, Scope};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_protocol::{self as protocol, BootId, Name};

use crate::fault::{self, Fault};
use crate::mailroom::Mailroom;
use crate::metrics::{FleetMetrics, Metrics};
use crate::mqtt::Inbox;
use crate::readiness::Readiness;
use crate::store::batch::Record;
use crate::store::{Batch, Lease, StoreError, StoredRobot, Writer};
use crate::trace::{Lives, Step, Traces, is_told};

pub use publication::{Publication, Stopwatch};

use history::History;
use outage::{LeaseLost, Outage};

/// How long messages are gathered for one commit.
const GATHER: Duration = Duration::from_millis(10);
/// Messages of one commit at the most.
const GATHER_MAX: usize = 4096;
/// How often time is told to the core.
const TICK: Duration = Duration::from_millis(250);
/// How often all robots are counted for the metrics.
const SURVEY: Duration = Duration::from_secs(1);
/// How often receipts are sent.
const RECEIPTS: Duration = Duration::from_millis(100);

/// A message as it came from the broker.
#[derive(Debug)]
pub struct Incoming {
    /// Its topic.
    pub topic: Bytes,
    /// Its payload.
    pub payload: Bytes,
    /// When, by the supervisor's clock.
    pub received: Micros,
}

/// A robot with its numbers in the database.
struct Known {
    robot_id: i64,
    robot: Robot,
    whisker_ids: Vec<i64>,
    boots: BTreeMap<String, i64>,
    /// Next `seq` of each topic to this robot.
    seqs: publication::Seqs,
    /// What was measured last of each compensation.
    stated: survey::Stated,
    /// What its whiskers felt, for the tables.
    history: History,
}

/// Why an engine has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// It was told to, and everything that it had is committed.
    Stopped,
    /// The fleet is somebody else's.
    LeaseLost,
}

/// The owner of a fleet's robots.
pub struct Engine {
    fleet: Name,
    boot_id: BootId,
    lease: Lease,
    params: Arc<Params>,
    writer: Writer,
    /// What all fleets count together.
    program: Metrics,
    metrics: FleetMetrics,
    readiness: Readiness,
    /// When the message was received that was handled last.
    handled: Micros,
    /// Messages that had been shed at the last look.
    shed: u64,
    robots: BTreeMap<Name, Known>,
    /// Which contacts are kept one by one.
    keep: Keep,
    batch: Batch,
    /// Times of the contacts messages in the batch.
    taken: Vec<survey::Taken>,
    /// The setpoint that the message in hand is an answer to.
    answering: Option<survey::Answering>,
    effects: Vec<Effect>,
    publications: Vec<Publication>,
    touched: BTreeSet<Name>,
    receipts_due: BTreeSet<(Name, String)>,
    mailroom: Mailroom,
    /// Rings when something was asked of the fleet at this supervisor.
    bell: Arc<Notify>,
    /// Actions whose answers are in the batch.
    answered: Vec<i64>,
    /// The version of the policy in force; 0 while it is the configuration's.
    policy_version: i64,
    /// The traces of setpoints under way, if there is a collector.
    lives: Option<Lives>,
}

/// The time now, by the supervisor's clock.
#[must_use]
pub fn wall_clock() -> Micros {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    Micros(u64::try_from(since.as_micros()).unwrap_or(u64::MAX))
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
        let params = mail::with_policy(params, policy.as_ref());
        let params = mail::with_calibrations(params, &writer.calibrations(&lease).await?);
        let (mut robots, mut batch) = (BTreeMap::new(), Batch::default());
        for stored in writer.robots(&lease).await? {
            if let Ok(name) = Name::robot(&stored.robot) {
                robots.insert(name, take_up(stored, epoch, &params, &mut batch));
            }
        }
        info!(%fleet, epoch, robots = robots.len(), "supervising");
        let metrics = program.of_fleet(&fleet);
        // As if heard: a fleet that stays silent is silent from here on.
        metrics.last_contact_timestamp_seconds.set(wall_clock().as_s());
        let mut engine = Self {
            bell: mailroom.bell(&fleet),
            mailroom,
            answered: Vec::new(),
            policy_version: policy.map_or(0, |policy| policy.version),
            fleet,
            boot_id,
            lease,
            params,
            writer,
            shed: metrics.messages_shed.get(),
            program,
            metrics,
            readiness,
            handled: Micros::default(),
            robots,
            keep: Keep::default(),
            batch,
            taken: Vec::new(),
            answering: None,
            effects: Vec::new(),
            publications: Vec::new(),
            touched: BTreeSet::new(),
            receipts_due: BTreeSet::new(),
            lives: None,
        };
        engine.show_params();
        engine.survey_robots();
        Ok(engine)
    }

    /// The same with traces, if there is a collector: those of setpoints that were sent before go on.
    #[must_use]
    pub(crate) fn traced(mut self, traces: Option<&Traces>) -> Self {
        self.lives = traces.map(|traces| {
            let mut lives = Lives::new(traces.clone(), self.fleet.clone());
            for (name, known) in &self.robots {
                lives.take_up(name, known.robot_id, &known.robot);
            }
            lives
        });
        self
    }

    /// The same with another policy of which contacts are kept one by one.
    #[must_use]
    pub(crate) fn keeping(mut self, keep: Keep) -> Self {
        self.keep = keep;
        for known in self.robots.values_mut() {
            known.history.keep(keep);
        }
        self
    }

    /// Runs until no more messages can come, and what was taken in is committed; or until the fleet is somebody
    /// else's, who has the robots send again what was not committed.
    pub async fn run(mut self, inbox: Inbox, outbox: mpsc::Sender<Publication>) -> Ending {
        let ending = self.work(inbox, outbox).await;
        if let Some(lives) = &mut self.lives {
            lives.end(ending);
        }
        ending
    }

    async fn work(&mut self, mut inbox: Inbox, outbox: mpsc::Sender<Publication>) -> Ending {
        let mut ticks = interval(TICK);
        let mut receipts = interval(RECEIPTS);
        let mut surveys = interval(SURVEY);
        surveys.set_missed_tick_behavior(MissedTickBehavior::Skip);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        receipts.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let bell = self.bell.clone();
        loop {
            let done = tokio::select! {
                first = inbox.recv() => match first {
                    None => break,
                    Some(first) => self.gather(first, &mut inbox).await,
                },
                _ = ticks.tick() => {
                    self.tick(&inbox);
                    // Asked at another supervisor, perhaps.
                    self.open_mail(self.now(&inbox)).await;
                    Ok(())
                }
                () = bell.notified() => {
                    self.open_mail(self.now(&inbox)).await;
                    Ok(())
                }
                _ = receipts.tick() => {
                    self.receipts(&outbox);
                    Ok(())
                }
                _ = surveys.tick() => {
                    self.survey_queues(&inbox, &outbox);
                    self.survey_robots();
                    self.close_history(self.now(&inbox));
                    Ok(())
                }
            };
            if fault::is(Fault::ReceiptBeforeCommit) {
                self.receipts(&outbox);
            }
            if done.is_err() || self.commit().await.is_err() {
                return Ending::LeaseLost;
            }
            self.publish(&outbox);
        }
        self.receipts(&outbox);
        Ending::Stopped
    }

    /// Steps a message and those that come within [`GATHER`].
    async fn gather(&mut self, first: Incoming, inbox: &mut Inbox) -> Result<(), LeaseLost> {
        let deadline = Instant::now() + GATHER;
        self.handle_until_numbered(&first).await?;
        for _ in 1..GATHER_MAX {
            match timeout_at(deadline, inbox.recv()).await {
                Ok(Some(incoming)) => self.handle_until_numbered(&incoming).await?,
                Ok(None) | Err(_) => break,
            }
        }
        Ok(())
    }

    /// Handles a message; numbers for new robots, boots and whiskers come from the database, so a database
    /// that is away is waited for. Nothing is stepped before its numbers are there.
    async fn handle_until_numbered(&mut self, incoming: &Incoming) -> Result<(), LeaseLost> {
        self.handled = incoming.received;
        let mut outage = Outage::default();
        while let Err(problem) = self.handle(incoming).await {
            self.wait_out(&mut outage, problem, "new things cannot be numbered").await?;
        }
        self.end_of(&outage);
        Ok(())
    }

    /// The core's step, and what comes of it into the batch.
    fn step(
        &mut self,
        name: &Name,
        now: Micros,
        event: &Event<'_>,
        source: Option<&protocol::Contacts>,
    ) -> Option<Outcome> {
        let known = self.robots.get_mut(name)?;
        let mut effects = std::mem::take(&mut self.effects);
        let outcome = known.robot.step(&self.params, now, event, &mut effects);
        self.touched.insert(name.clone());
        if let Some(lives) = &mut self.lives
            && is_told(&effects)
        {
            let (fleet, robot_id, robot, effects) = (&self.fleet, known.robot_id, &known.robot, &effects[..]);
            lives.stepped(&Step { fleet, name, robot_id, robot, now, event, effects });
        }
        for effect in effects.drain(..) {
            self.record(name, now, effect, source);
        }
        self.effects = effects;
        Some(outcome)
    }

    /// The time for the core: not later than what it has yet to hear.
    fn now(&self, inbox: &Inbox) -> Micros {
        if inbox.is_empty() { wall_clock() } else { self.handled }
    }

    /// Tells the core what time it is.
    fn tick(&mut self, inbox: &Inbox) {
        let now = self.now(inbox);
        let shed = self.metrics.messages_shed.get();
        if self.metrics.broker_connected.get() == 0 || shed != self.shed {
            self.listen_anew();
        }
        self.shed = shed;
        let names: Vec<Name> = self.robots.keys().cloned().collect();
        for name in names {
            self.step(&name, now, &Event::Tick, None);
        }
    }

    /// Writes the batch; a database that is away is waited for, while the inbox fills and then sheds.
    async fn commit(&mut self) -> Result<(), LeaseLost> {
        self.snapshot();
        if self.batch.is_empty() {
            return Ok(());
        }
        let mut outage = Outage::default();
        let first = Instant::now();
        loop {
            let begun = Instant::now();
            match self.writer.commit(&self.lease, &self.batch).await {
                Ok(()) => {
                    self.metrics.database_commit_seconds.observe(begun.elapsed().as_secs_f64());
                    break;
                }
                Err(problem) => self.wait_out(&mut outage, problem, "nothing is recorded").await?,
            }
        }
        self.end_of(&outage);
        if let Some(lives) = &mut self.lives {
            lives.committed(first.elapsed());
        }
        self.batch = Batch::default();
        self.time_taken();
        self.mailroom.answered(self.answered.drain(..));
        if !self.batch.records.is_empty() {
            self.mailroom.changed();
        }
        Ok(())
    }

    /// Sends what waited for the commit. Nothing is lost if the broker is away: setpoints are sent again
    /// until answered, receipts with the next message. Nor if the fleet may be somebody else's by now.
    fn publish(&mut self, outbox: &mpsc::Sender<Publication>) {
        let mut all = self.lease.is_fresh();
        if !all {
            self.metrics.publications_dropped.inc_by(self.publications.len() as u64);
            self.publications.clear();
        }
        for publication in self.publications.drain(..) {
            if outbox.try_send(publication).is_err() {
                self.metrics.publications_dropped.inc();
                all = false;
            }
        }
        if let Some(lives) = &mut self.lives {
            lives.published(all);
        }
    }
}

/// A robot as it was stored. Bytes of another version of the program cannot be used: then it starts anew, without the
/// alarms that stood, and all of it is held if anything of it was.
fn take_up(stored: StoredRobot, epoch: u64, params: &Params, batch: &mut Batch) -> Known {
    let restored =
        stored.state.as_ref().map(|state| Robot::from_bytes(state, &stored.whisker_states, epoch, wall_clock()));
    let (robot, whisker_ids) = match restored {
        Some(Ok(robot)) => (robot, stored.whisker_ids),
        Some(Err(problem)) => {
            error!(robot = stored.robot, %problem, "starting anew: what was learned of its whiskers is lost");
            let now = wall_clock();
            batch.records.push(Record::AlarmsForgotten { robot_id: stored.robot_id, cleared_us: now.0 as i64 });
            let mut robot = Robot::new(epoch, stored.numbers).taken_up();
            if stored.held {
                robot.step(params, now, &Event::Operator(&OperatorAction::Hold(Scope::Robot)), &mut Vec::new());
            }
            (robot, Vec::new())
        }
        None => (Robot::new(epoch, stored.numbers), Vec::new()),
    };
    let stated = survey::Stated::of(&robot, params);
    let seqs = publication::Seqs::default();
    let rollups = if whisker_ids.is_empty() { &[][..] } else { &stored.rollups };
    let history = History::taken_up(Keep::default(), rollups, wall_clock());
    Known { robot_id: stored.robot_id, robot, whisker_ids, boots: stored.boots, seqs, stated, history }
}

/// A pressure as a bare number, if there is one.
fn mpa(pressure: Option<Megapascal>) -> Option<f64> {
    pressure.map(Megapascal::mpa)
}
