//! The world of a run: supervisors, robots, broker and store in one thread with tokio's paused clock.

mod strikes;

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::time::{Instant, sleep, sleep_until};
use vibrissa_protocol::{ConnectionState, Message, Topic, decode};
use vibrissa_simulator::{Robot, RobotConfig};

use crate::broker::{Limits, ModelBroker, Observed};
use crate::history::{History, Step};
use crate::invariants::{Invariant, Violation};
use crate::log::{Bridge, ModelLog, PARTITIONS, TOPIC};
use crate::member::Member;
use crate::panics;
use crate::plan::Plan;
use crate::process::LOG_HOST;
use crate::receivers::Receivers;
use crate::record::{Record, Snapshot};
use crate::robots::SimulatedRobot;
use crate::scenario;
use crate::server::StoreServer;
use crate::store::ModelStore;

/// True time at the start, µs since 1970 UTC.
const BEGUN_US: i64 = 1_800_000_000_000_000;
/// Time in which everything must settle after the last fault.
const SETTLED_WITHIN: Duration = Duration::from_secs(180);
/// Steps of a history that are kept: enough for a diagram of its end.
const NEWEST: usize = 400;
/// Interval between two checks.
const CHECKED_EVERY: Duration = Duration::from_millis(500);

/// Result of a run.
#[derive(Debug)]
pub struct Outcome {
    /// The violations, in the order in which they were found.
    pub violations: Vec<Violation>,
    /// Simulated time.
    pub simulated: Duration,
    /// Contacts that robots made, setpoints that were decided, trims that were found.
    pub counts: [u64; 3],
    /// Events that receivers of webhooks have taken.
    pub delivered: u64,
    /// Raised alarms by kind.
    pub alarms: BTreeMap<String, u64>,
    /// Time from the end of the faults until all was settled.
    pub settled_after: Duration,
    /// Hash of the history.
    pub hash: u64,
    /// Number of steps of the history.
    pub steps_in_all: u64,
    /// The newest steps of the history.
    pub steps: Vec<Step>,
}

/// Parts that observers share.
#[derive(Debug)]
pub(crate) struct Observations {
    pub(crate) record: Record,
    pub(crate) history: History,
    /// Topics and payloads of the newest messages of robots.
    heard: VecDeque<(String, Vec<u8>)>,
}

/// Number of messages that a hostile client copies.
const HEARD: usize = 32;

/// The world.
pub(crate) struct World {
    begun: Instant,
    pub(crate) broker: ModelBroker,
    pub(crate) log: ModelLog,
    /// Carries contacts and statuses from the broker to the log.
    pub(crate) bridge: Bridge,
    pub(crate) server: StoreServer,
    pub(crate) members: Vec<Member>,
    pub(crate) robots: Vec<SimulatedRobot>,
    receivers: Receivers,
    observations: Arc<Mutex<Observations>>,
    /// The state before a failover under way.
    failover: Option<(ModelStore, Snapshot)>,
    /// When the faults were over.
    settling: Option<Instant>,
    /// Number of fleets.
    fleets: usize,
}

/// Runs a plan in a runtime of its own.
///
/// # Panics
/// The runtime cannot be made.
#[must_use]
pub fn run(plan: &Plan) -> Outcome {
    run_keeping(NEWEST, plan)
}

/// As [`run`], with at most so many steps of the history.
///
/// # Panics
/// The runtime cannot be made.
#[must_use]
pub fn run_keeping(steps: usize, plan: &Plan) -> Outcome {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    builder.enable_time().start_paused(true);
    #[cfg(tokio_unstable)]
    builder.rng_seed(tokio::runtime::RngSeed::from_bytes(&plan.seed.to_le_bytes()));
    let runtime = builder.build().expect("a runtime without I/O");
    let (mut outcome, panics) = panics::watched(|| {
        let outcome = runtime.block_on(async { World::new(steps, plan).run(plan).await });
        // Tasks that wait for ever are dropped.
        drop(runtime);
        outcome
    });
    let panics = panics.into_iter().map(|what| Violation { invariant: Invariant::NoPanic, what });
    outcome.violations.extend(panics);
    outcome
}

impl World {
    fn new(steps: usize, plan: &Plan) -> Self {
        let begun = Instant::now();
        let mut random = ChaCha8Rng::seed_from_u64(plan.seed ^ 0x0077_6f72_6c64);
        let broker = ModelBroker::new(plan.seed, Limits::default());
        let server = StoreServer::new(BEGUN_US + random.random_range(-100_000..100_000));
        let receivers = Receivers::new(&server);
        let log = ModelLog::new(LOG_HOST, 9092);
        log.create(TOPIC, PARTITIONS);
        let fleets: Vec<_> = (0..plan.fleets).map(scenario::fleet).collect();
        let (scenarios, cut) = scenario::scenarios(plan);
        let mut robots = Vec::new();
        for (fleet, one) in scenarios.iter().enumerate() {
            for (number, config) in RobotConfig::all(one).enumerate() {
                let robot = Robot::new(config, plan.seed, BEGUN_US as u64).expect("a valid scenario");
                let seed = plan.seed ^ ((fleet as u64) << 32) ^ number as u64;
                robots.push(SimulatedRobot::start(robot, &broker, (begun, BEGUN_US), seed));
            }
        }
        let mut record = Record::default();
        record.cut.extend(cut);
        let (history, heard) = (History::keeping(steps), VecDeque::new());
        let observations = Arc::new(Mutex::new(Observations { record, history, heard }));
        let mut members = Vec::new();
        for number in 0..plan.supervisors {
            let (ahead_us, drift_ppm) = (random.random_range(-200_000..200_000), random.random_range(-50..50));
            let mut member = Member::new(
                number,
                (plan.seed, BEGUN_US + ahead_us, drift_ppm),
                &fleets,
                (&broker, &server, &receivers),
                (&log, plan.is_from_log),
            );
            member.start();
            members.push(member);
        }
        let heard = observations.clone();
        let talked = move |robot: &str| locked(&heard).record.talked(robot, false);
        let bridge = Bridge::start(&log, plan.seed, talked);
        let world = Self {
            begun,
            broker,
            log,
            bridge,
            server,
            members,
            robots,
            receivers,
            observations,
            failover: None,
            settling: None,
            fleets: plan.fleets,
        };
        world.observe(plan.is_from_log);
        world
    }

    /// Compares each message with what is committed when the broker accepts it.
    fn observe(&self, is_from_log: bool) {
        let (observations, server, robots) = (self.observations.clone(), self.server.clone(), self.robots.clone());
        let (begun, bridge) = (self.begun, self.bridge.clone());
        let observer = move |observed: &Observed<'_>| {
            if observed.to.is_some() {
                return;
            }
            let is_of_supervisor = observed.from.starts_with("vibrissa-");
            let is_bridged = is_from_log && bridge.take(observed.topic, observed.payload);
            let mut observations = locked(&observations);
            let Observations { record, history, heard } = &mut *observations;
            let from = match observed.from.strip_prefix("vibrissa-") {
                Some(of_supervisor) => of_supervisor.rsplit_once('-').map_or(of_supervisor, |(before, _)| before),
                None => observed.from,
            };
            history.add(Step {
                at: observed.at - begun,
                from: from.to_owned(),
                to: "broker".to_owned(),
                what: format!("{} {}", observed.topic, String::from_utf8_lossy(observed.payload)),
            });
            if is_of_supervisor {
                record.drain(&robots, &mut server.data());
                record.published(observed.topic, observed.payload);
            } else if !observed.from.starts_with("hostile-") {
                if heard.len() == HEARD {
                    heard.pop_front();
                }
                heard.push_back((observed.topic.to_owned(), observed.payload.to_vec()));
                if let Some((_, robot)) = observed.from.rsplit_once('-').filter(|_| !is_bridged) {
                    record.talked(robot, is_end(observed));
                }
            }
        };
        self.broker.observe(Box::new(observer));
    }

    async fn run(mut self, plan: &Plan) -> Outcome {
        let mut steps: Vec<(Instant, usize, bool)> = Vec::new();
        for (number, strike) in plan.strikes.iter().enumerate() {
            steps.push((self.begun + strike.at, number, true));
            steps.push((self.begun + strike.at + strike.lasts, number, false));
        }
        steps.sort_unstable();
        let mut steps = steps.into_iter().peekable();
        let end = self.begun + plan.length;
        let mut checked = Instant::now();
        loop {
            let next = steps.peek().map(|step| step.0);
            let until = next.unwrap_or(end).min(checked + CHECKED_EVERY);
            sleep_until(until).await;
            while let Some((_, number, is_begin)) = steps.next_if(|step| step.0 <= Instant::now()) {
                let strike = &plan.strikes[number];
                self.note("world", if is_begin { "begins" } else { "ends" }, &strike.to_string());
                if is_begin { self.begin(strike) } else { self.end(strike) }
            }
            if Instant::now() >= checked + CHECKED_EVERY {
                checked = Instant::now();
                if self.check() {
                    return self.outcome();
                }
            }
            if steps.peek().is_none() && Instant::now() >= end {
                break;
            }
        }
        // Each fault has ended. An upgrade goes on to its end, and supervisors that have ended in order start again.
        for member in self.members.iter_mut().filter(|member| member.way.program() < self.server.program()) {
            member.kill();
        }
        self.members.iter_mut().for_each(Member::start);
        for robot in &self.robots {
            robot.with(Robot::rest);
        }
        self.settling = Some(Instant::now());
        let settled_by = Instant::now() + SETTLED_WITHIN;
        while !self.is_settled() && Instant::now() < settled_by {
            self.receivers.redeliver();
            sleep(CHECKED_EVERY).await;
            if self.check() {
                return self.outcome();
            }
        }
        self.judge();
        self.outcome()
    }

    /// Takes in what has happened. Returns whether an invariant is violated.
    fn check(&self) -> bool {
        let mut observations = self.observations();
        for Violation { invariant, what } in self.receivers.take_violations() {
            observations.record.violated(invariant, what);
        }
        for robot_id in self.server.data().take_overwritten() {
            let what = format!("robot {robot_id} has the state of an earlier program");
            observations.record.violated(Invariant::NewerStateKept, what);
        }
        self.receivers.take_steps().into_iter().for_each(|step| observations.history.add(step));
        if self.failover.is_none() {
            observations.record.drain(&self.robots, &mut self.server.data());
        }
        !observations.record.violations().is_empty()
    }

    fn is_settled(&self) -> bool {
        self.robots.iter().all(SimulatedRobot::is_receipted)
            && self.observations().record.pending().is_empty()
            && self.fleets().all(|fleet| self.server.data().is_owned(&fleet))
            && self.receivers.first_missing().is_none()
    }

    fn fleets(&self) -> impl Iterator<Item = String> {
        (0..self.fleets).map(|number| scenario::fleet(number).to_string())
    }

    /// Compares the end with the invariants.
    fn judge(&self) {
        let mut observations = self.observations();
        let record = &mut observations.record;
        for robot in self.robots.iter().filter(|robot| !robot.is_receipted()) {
            let (name, kept) = robot.with(|robot| (robot.name().to_string(), robot.messages_kept()));
            record.violated(Invariant::ContactRecorded, format!("{name} has {kept} messages without a receipt"));
        }
        let boots: Vec<_> = self.robots.iter().map(|robot| robot.with(|robot| robot.boot_id().to_string())).collect();
        if let Some(missing) = record.first_missing(&boots) {
            record.violated(Invariant::ContactRecorded, missing);
        }
        let pending = record.pending();
        if let Some(first) = pending.first() {
            record.violated(Invariant::SetpointEnds, format!("{} setpoints, the first {first}", pending.len()));
        }
        if let Some(id) = self.receivers.first_missing() {
            record.violated(Invariant::WebhookDelivered, format!("{id} was not taken"));
        }
        record.check_setpoints();
        for fleet in self.fleets() {
            if !self.server.data().is_owned(&fleet) {
                record.violated(Invariant::FleetOwned, format!("{fleet} has no owner"));
            }
        }
    }

    fn outcome(&self) -> Outcome {
        let observations = self.observations();
        let (record, history) = (&observations.record, &observations.history);
        let mut steps: Vec<Step> = history.steps().cloned().collect();
        // Requests to receivers are added later.
        steps.sort_by_key(|step| step.at);
        Outcome {
            violations: record.violations().to_vec(),
            simulated: self.begun.elapsed(),
            counts: record.counts(),
            delivered: self.receivers.taken(),
            alarms: record.alarms().clone(),
            settled_after: self.settling.map_or(Duration::ZERO, |since| since.elapsed()),
            hash: history.hash(),
            steps_in_all: history.count(),
            steps,
        }
    }

    pub(crate) fn note(&self, from: &str, to: &str, what: &str) {
        let (from, to, what) = (from.to_owned(), to.to_owned(), what.to_owned());
        self.observations().history.add(Step { at: self.begun.elapsed(), from, to, what });
    }

    fn observations(&self) -> MutexGuard<'_, Observations> {
        locked(&self.observations)
    }
}

/// Whether a message says that its robot is not connected: a last will, or a farewell.
fn is_end(observed: &Observed<'_>) -> bool {
    let Ok(topic) = Topic::parse(observed.topic) else { return false };
    matches!(decode(&topic, observed.payload), Ok(Message::Connection(connection)) if connection.state != ConnectionState::Online)
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
