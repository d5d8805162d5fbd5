//! One message's way: received, decoded, stepped through the core, committed, and only then answered.
//!
//! One task owns every robot's state. It gathers messages for a few milliseconds, steps each through the
//! core, writes all that came of them in one transaction, and then publishes setpoints and receipts. What
//! is published is therefore always committed; what is not committed is sent again by the robots.

mod publication;
mod record;

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, SystemTime};

use bytes::Bytes;
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout_at};
use tracing::{debug, error, info, warn};
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::{Admission, Event, Outcome, Params, Robot};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_protocol::{self as protocol, BootId, Message, Name, RobotTopic, Topic};

use crate::edge;
use crate::metrics::Metrics;
use crate::mqtt::Inbox;
use crate::store::{Batch, Store, StoreError, StoredRobot, batch::LayoutRow};
use crate::words::Word;

pub use publication::Publication;

/// How long messages are gathered for one commit.
const GATHER: Duration = Duration::from_millis(10);
/// Messages of one commit at the most.
const GATHER_MAX: usize = 4096;
/// How often time is told to the core.
const TICK: Duration = Duration::from_millis(250);
/// Robots of one fleet at the most: names come from topics, and whoever may publish can make them up.
const ROBOTS_MAX: usize = 10_000;
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
}

/// The owner of a fleet's robots.
pub struct Engine {
    fleet: Name,
    boot_id: BootId,
    epoch: u64,
    params: Params,
    store: Store,
    metrics: Metrics,
    robots: BTreeMap<Name, Known>,
    batch: Batch,
    effects: Vec<Effect>,
    publications: Vec<Publication>,
    touched: BTreeSet<Name>,
    receipts_due: BTreeSet<(Name, String)>,
}

/// The time now, by the supervisor's clock.
#[must_use]
pub fn wall_clock() -> Micros {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    Micros(u64::try_from(since.as_micros()).unwrap_or(u64::MAX))
}

impl Engine {
    /// Begins a new epoch and takes up every robot where its last commit left it.
    ///
    /// # Errors
    /// The database cannot be used.
    pub async fn start(
        fleet: Name,
        boot_id: BootId,
        params: Params,
        store: Store,
        metrics: Metrics,
    ) -> Result<Self, StoreError> {
        let epoch = store.begin_epoch(boot_id.as_str(), wall_clock().0 as i64).await?;
        let mut robots = BTreeMap::new();
        for stored in store.robots(fleet.as_str()).await? {
            if let Ok(name) = Name::robot(&stored.robot) {
                robots.insert(name, take_up(stored, epoch));
            }
        }
        info!(%fleet, epoch, robots = robots.len(), "supervising");
        Ok(Self {
            fleet,
            boot_id,
            epoch,
            params,
            store,
            metrics,
            robots,
            batch: Batch::default(),
            effects: Vec::new(),
            publications: Vec::new(),
            touched: BTreeSet::new(),
            receipts_due: BTreeSet::new(),
        })
    }

    /// The epoch of this start.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Runs until no more messages can come; what was taken in is committed first.
    pub async fn run(mut self, mut inbox: Inbox, outbox: mpsc::Sender<Publication>) {
        let mut ticks = interval(TICK);
        let mut receipts = interval(RECEIPTS);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        receipts.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            tokio::select! {
                first = inbox.recv() => match first {
                    None => break,
                    Some(first) => self.gather(first, &mut inbox).await,
                },
                _ = ticks.tick() => self.tick(),
                _ = receipts.tick() => self.receipts(&outbox),
            }
            self.commit().await;
            self.publish(&outbox);
        }
        self.receipts(&outbox);
    }

    /// Steps a message and those that come within [`GATHER`].
    async fn gather(&mut self, first: Incoming, inbox: &mut Inbox) {
        let deadline = Instant::now() + GATHER;
        self.handle_until_numbered(&first).await;
        for _ in 1..GATHER_MAX {
            match timeout_at(deadline, inbox.recv()).await {
                Ok(Some(incoming)) => self.handle_until_numbered(&incoming).await,
                Ok(None) | Err(_) => return,
            }
        }
    }

    /// Handles a message; numbers for new robots, boots and whiskers come from the database, so a database
    /// that is away is waited for. Nothing is stepped before its numbers are there.
    async fn handle_until_numbered(&mut self, incoming: &Incoming) {
        let mut backoff = Backoff::default();
        while let Err(problem) = self.handle(incoming).await {
            self.metrics.database_errors.inc();
            error!(%problem, "the database does not answer; trying again");
            backoff.wait().await;
        }
    }

    async fn handle(&mut self, incoming: &Incoming) -> Result<(), StoreError> {
        let Ok(text) = std::str::from_utf8(&incoming.topic) else {
            self.refuse("unknown_topic", "a topic that is not UTF-8", "");
            return Ok(());
        };
        let topic = match Topic::parse(text) {
            Ok(topic) => topic,
            Err(refusal) => {
                self.refuse(refusal.label(), &refusal, text);
                return Ok(());
            }
        };
        let Topic::Robot { fleet, robot, kind } = &topic else { return Ok(()) };
        if *fleet != self.fleet || !kind.is_from_robot() {
            return Ok(());
        }
        self.metrics.messages.with_label_values(&[kind.as_str()]).inc();
        match protocol::decode(&topic, &incoming.payload) {
            Ok(message) => self.take(robot, &message, incoming.received).await,
            Err(refusal) => {
                self.refuse(refusal.label(), &refusal, text);
                if *kind == RobotTopic::Contacts {
                    self.account_for_refused(robot, &incoming.payload, incoming.received).await?;
                }
                Ok(())
            }
        }
    }

    /// A refused `contacts` message whose number can be read is receipted: sent again it would be refused
    /// again, for ever, before everything that comes after it.
    async fn account_for_refused(&mut self, robot: &Name, payload: &[u8], now: Micros) -> Result<(), StoreError> {
        let Some(envelope) = protocol::envelope(payload) else { return Ok(()) };
        let contacts = protocol::Contacts { boot_id: envelope.boot_id, seq: envelope.seq, contacts: Vec::new() };
        self.take(robot, &Message::Contacts(contacts), now).await
    }

    fn refuse(&self, reason: &'static str, problem: impl std::fmt::Display, topic: &str) {
        self.metrics.refused.with_label_values(&[reason]).inc();
        debug!(reason, %problem, topic, "refused");
    }

    async fn take(&mut self, name: &Name, message: &Message, now: Micros) -> Result<(), StoreError> {
        if !self.robots.contains_key(name) && !self.make_known(name, message).await? {
            return Ok(());
        }
        match message {
            Message::Connection(told) => {
                let event = Event::Connection { boot_id: told.boot_id.as_str(), link: edge::link(told.state) };
                self.step(name, now, &event, None);
                if told.state == protocol::ConnectionState::Online {
                    self.ask_after_setpoints(name);
                }
            }
            Message::Factsheet(told) => self.take_factsheet(name, told, now).await?,
            Message::Contacts(told) => self.take_contacts(name, told, now),
            Message::Status(told) => {
                let whiskers: Result<Vec<_>, _> = told.whiskers.iter().map(edge::status).collect();
                match whiskers {
                    Ok(whiskers) => {
                        let robot_time = Micros(told.t_us);
                        let event = Event::Status { boot_id: told.boot_id.as_str(), robot_time, whiskers: &whiskers };
                        self.step(name, now, &event, None);
                    }
                    Err(problem) => self.refuse(problem.label(), problem, "status"),
                }
            }
            Message::SetpointState(told) => self.take_setpoint_state(name, told, now),
            // Not from robots: other supervisors' messages, which the subscriptions leave out.
            Message::Receipt(_) | Message::Setpoint(_) | Message::Request(_) | Message::SupervisorState(_) => {}
        }
        Ok(())
    }

    /// A robot becomes known by its birth or factsheet, which the broker retains: what comes before is not
    /// taken, and sent again. False if it is not taken.
    async fn make_known(&mut self, name: &Name, message: &Message) -> Result<bool, StoreError> {
        if !matches!(message, Message::Connection(_) | Message::Factsheet(_)) {
            self.refuse("unknown_robot", "neither birth nor factsheet was received of this robot", name.as_str());
            return Ok(false);
        }
        if self.robots.len() >= ROBOTS_MAX {
            self.refuse("too_many_robots", format!("the fleet has {ROBOTS_MAX} robots already"), name.as_str());
            return Ok(false);
        }
        let known = Known {
            robot_id: self.store.robot_id(self.fleet.as_str(), name.as_str()).await?,
            robot: Robot::new(self.epoch),
            whisker_ids: Vec::new(),
            boots: BTreeMap::new(),
            seqs: publication::Seqs::default(),
        };
        self.robots.insert(name.clone(), known);
        Ok(true)
    }

    async fn take_factsheet(&mut self, name: &Name, told: &protocol::Factsheet, now: Micros) -> Result<(), StoreError> {
        let models: Vec<&str> = self.params.models.iter().map(|(name, _)| name.as_str()).collect();
        let factsheet = match edge::factsheet(told, &models) {
            Ok(factsheet) => factsheet,
            Err(problem) => {
                warn!(robot = %name, %problem, "factsheet refused");
                self.refuse(problem.label(), problem, "factsheet");
                return Ok(());
            }
        };
        let Some(known) = self.robots.get_mut(name) else { return Ok(()) };
        let boot_id = told.boot_id.as_str();
        if !known.boots.contains_key(boot_id) {
            let boot = self.store.boot(known.robot_id, boot_id, now.0 as i64).await?;
            known.boots.insert(boot_id.to_owned(), boot);
        }
        // The layout is numbered from a copy first, so that a database that is away changes nothing.
        let mut laid_out = known.robot.clone();
        laid_out.step(&self.params, now, &Event::Factsheet { boot_id, factsheet: &factsheet }, &mut Vec::new());
        let ids = self.store.whisker_ids(known.robot_id, &laid_out).await?;
        if ids != known.whisker_ids {
            known.whisker_ids = ids;
            self.batch.layouts.push(LayoutRow { robot_id: known.robot_id, model: told.model.clone() });
        }
        self.step(name, now, &Event::Factsheet { boot_id, factsheet: &factsheet }, None);
        Ok(())
    }

    fn take_contacts(&mut self, name: &Name, told: &protocol::Contacts, now: Micros) {
        let mut contacts = Vec::with_capacity(told.contacts.len());
        for contact in &told.contacts {
            match edge::contact(contact) {
                Ok(contact) => contacts.push(contact),
                Err(problem) => self.refuse(problem.label(), problem, "contacts"),
            }
        }
        let boot_id = told.boot_id.as_str();
        let event = Event::Contacts { boot_id, seq: told.seq, contacts: &contacts };
        match self.step(name, now, &event, Some(told)) {
            Some(Outcome::NotYet(admission)) => {
                let reason = match admission {
                    Admission::TooManyGaps => "too_many_gaps",
                    Admission::UnknownBoot | Admission::New | Admission::Duplicate => "unknown_boot",
                };
                self.refuse(reason, "contacts that cannot be taken yet", name.as_str());
                return;
            }
            Some(Outcome::Duplicate) => self.metrics.duplicates.inc(),
            Some(Outcome::Taken | Outcome::OldBoot) | None => {}
        }
        self.receipts_due.insert((name.clone(), boot_id.to_owned()));
    }

    fn take_setpoint_state(&mut self, name: &Name, told: &protocol::SetpointState, now: Micros) {
        let Some(known) = self.robots.get(name) else { return };
        let found = known
            .robot
            .commands_under_way()
            .find(|command| publication::command_id(&self.fleet, name, command.key) == told.command_id)
            .map(|command| (command.key, command.pressure));
        let Some((command, pressure)) = found else {
            debug!(robot = %name, command_id = told.command_id, "a state of a setpoint that is not under way");
            return;
        };
        match edge::setpoint_report(told, pressure) {
            Ok(report) => {
                let robot_time = Micros(told.t_us);
                let event = Event::Setpoint { boot_id: told.boot_id.as_str(), command, report, robot_time };
                self.step(name, now, &event, None);
            }
            Err(problem) => self.refuse(problem.label(), problem, "setpoint_state"),
        }
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
        for effect in effects.drain(..) {
            self.record(name, now, effect, source);
        }
        self.effects = effects;
        Some(outcome)
    }

    fn tick(&mut self) {
        let now = wall_clock();
        let names: Vec<Name> = self.robots.keys().cloned().collect();
        for name in names {
            self.step(&name, now, &Event::Tick, None);
        }
        self.count_whiskers();
    }

    fn count_whiskers(&self) {
        let mut counts: BTreeMap<&'static str, i64> = BTreeMap::new();
        for known in self.robots.values() {
            for view in (0..known.robot.whisker_count()).filter_map(|index| known.robot.whisker(index)) {
                *counts.entry(view.fault.map_or(view.condition.word(), Word::word)).or_default() += 1;
            }
        }
        self.metrics.set_whiskers(&counts);
    }

    /// Writes the batch; a database that is away is waited for, while the inbox fills and then sheds.
    async fn commit(&mut self) {
        self.snapshot();
        if self.batch.is_empty() {
            return;
        }
        let mut backoff = Backoff::default();
        loop {
            let begun = Instant::now();
            match self.store.commit(&self.batch).await {
                Ok(()) => {
                    self.metrics.commit_seconds.observe(begun.elapsed().as_secs_f64());
                    self.metrics.ready(true);
                    break;
                }
                Err(problem) => {
                    self.metrics.ready(false);
                    self.metrics.database_errors.inc();
                    error!(%problem, "commit failed; trying again");
                    backoff.wait().await;
                }
            }
        }
        self.batch = Batch::default();
    }

    /// Sends what waited for the commit. Nothing is lost if the broker is away: setpoints are sent again
    /// until answered, receipts with the next message.
    fn publish(&mut self, outbox: &mpsc::Sender<Publication>) {
        for publication in self.publications.drain(..) {
            if outbox.try_send(publication).is_err() {
                self.metrics.unpublished.inc();
            }
        }
    }
}

/// A robot as it was stored. Bytes of another version of the program cannot be used: then it starts anew.
fn take_up(stored: StoredRobot, epoch: u64) -> Known {
    let restored = stored.state.as_ref().map(|state| Robot::from_bytes(state, &stored.whisker_states, epoch));
    let (robot, whisker_ids) = match restored {
        Some(Ok(robot)) => (robot, stored.whisker_ids),
        Some(Err(problem)) => {
            error!(robot = stored.robot, %problem, "starting anew: what was learned of its whiskers is lost");
            (Robot::new(epoch), Vec::new())
        }
        None => (Robot::new(epoch), Vec::new()),
    };
    Known { robot_id: stored.robot_id, robot, whisker_ids, boots: stored.boots, seqs: publication::Seqs::default() }
}

/// Waits longer each time, up to 5 s.
#[derive(Default)]
struct Backoff {
    tries: u32,
}

impl Backoff {
    async fn wait(&mut self) {
        let wait = Duration::from_millis(100 << self.tries.min(6)).min(Duration::from_secs(5));
        self.tries += 1;
        tokio::time::sleep(wait).await;
    }
}

/// A pressure as a bare number, if there is one.
fn mpa(pressure: Option<Megapascal>) -> Option<f64> {
    pressure.map(Megapascal::mpa)
}
