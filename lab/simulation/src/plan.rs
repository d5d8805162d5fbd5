//! A run as data: the size of the world, and its faults with their times. Everything is drawn from the seed.

use std::fmt;
use std::time::Duration;

use rand::seq::{IndexedRandom as _, SliceRandom as _};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use vibrissa_simulator::scenario::Misbehaviour;

/// Time without faults at the beginning, in which supervisors take the fleets and robots connect.
const CALM: Duration = Duration::from_secs(10);

/// Whether the program can read contacts from a partitioned log.
const HAS_LOG: bool = cfg!(feature = "kafka");
/// One seed of so many reads contacts from the log.
const LOG_EVERY: u64 = 4;

/// A kind of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// A supervisor is killed at one of its await points, and started again later.
    SupervisorKilled,
    /// A supervisor ends in order, and is started again later.
    SupervisorStopped,
    /// A supervisor ends in order, and the next version of the program starts in its place.
    SupervisorUpgraded,
    /// A supervisor stands still, and goes on later.
    SupervisorFrozen,
    /// The host's clock of a supervisor is stepped, and later set right.
    HostClockStepped,
    /// Nothing goes from a supervisor to the broker.
    ToBrokerCut,
    /// Nothing goes from the broker to a supervisor.
    FromBrokerCut,
    /// The connections of a supervisor to the broker are reset.
    BrokerLinkReset,
    /// The broker forgets the subscriptions of a supervisor.
    SubscriptionsForgotten,
    /// The broker restarts with its memory.
    BrokerRestarted,
    /// The broker restarts without its memory.
    BrokerReplaced,
    /// The broker accepts bytes and answers nothing.
    BrokerFrozen,
    /// The broker delivers messages twice.
    Repetitions,
    /// The broker's deliveries take longer, and overtake those of other clients.
    SlowBroker,
    /// The broker's deliveries take longer, and those of a topic overtake those of others.
    TopicsOvertake,
    /// A robot's connection breaks.
    RobotCut,
    /// A robot cannot connect.
    RobotAway,
    /// A robot restarts without its memory.
    RobotRestarted,
    /// A client publishes damaged copies of robots' messages as another robot.
    Hostile,
    /// Requests of a supervisor do not reach the store.
    ToStoreCut,
    /// The store's answers do not reach a supervisor.
    FromStoreCut,
    /// The store does what a supervisor asks, and the answers are lost at once.
    AnswersLost,
    /// The store is slow for all.
    StoreSlow,
    /// The store is away for all.
    StoreAway,
    /// The store's disk is full.
    StoreFull,
    /// The store's clock is stepped for good.
    StoreClockStepped,
    /// The store gets a new leader, which lacks the last commits.
    StoreFailover,
    /// An operator holds a whisker, and resumes it later.
    OperatorHolds,
    /// A receiver of a webhook takes events after a time, which may be too long.
    ReceiverSlow,
    /// A receiver of a webhook answers with an error.
    ReceiverFails,
    /// A receiver of a webhook does not answer.
    ReceiverSilent,
    /// A receiver of a webhook takes events, and closes the connection without an answer.
    ReceiverCuts,
    /// Nothing goes from a supervisor to the partitioned log.
    ToLogCut,
    /// Nothing goes from the partitioned log to a supervisor.
    FromLogCut,
    /// The log closes its connections, and accepts none.
    LogDown,
    /// The log accepts requests and answers nothing.
    LogFrozen,
    /// A partition of the log has no leader.
    PartitionAway,
    /// The bridge writes records twice.
    RecordsRepeated,
    /// The bridge writes records late.
    RecordsLate,
    /// The log deletes all records of a partition, also those that nobody has read. No run draws it.
    RecordsDeleted,
    /// The newest batch of a partition is damaged, if nobody has read it.
    RecordDamaged,
}

impl Kind {
    /// Kinds of a run whose contacts come from the partitioned log, beside all others.
    pub const OF_LOG: [Self; 9] = [
        Self::ToLogCut,
        Self::FromLogCut,
        Self::LogDown,
        Self::LogFrozen,
        Self::PartitionAway,
        Self::RecordsRepeated,
        Self::RecordsLate,
        Self::RecordsDeleted,
        Self::RecordDamaged,
    ];

    /// Kinds of each run.
    pub const OF_EACH: [Self; 32] = [
        Self::SupervisorKilled,
        Self::SupervisorStopped,
        Self::SupervisorUpgraded,
        Self::SupervisorFrozen,
        Self::HostClockStepped,
        Self::ToBrokerCut,
        Self::FromBrokerCut,
        Self::BrokerLinkReset,
        Self::SubscriptionsForgotten,
        Self::BrokerRestarted,
        Self::BrokerReplaced,
        Self::BrokerFrozen,
        Self::Repetitions,
        Self::SlowBroker,
        Self::TopicsOvertake,
        Self::RobotCut,
        Self::RobotAway,
        Self::RobotRestarted,
        Self::Hostile,
        Self::ToStoreCut,
        Self::FromStoreCut,
        Self::AnswersLost,
        Self::StoreSlow,
        Self::StoreAway,
        Self::StoreFull,
        Self::StoreClockStepped,
        Self::StoreFailover,
        Self::OperatorHolds,
        Self::ReceiverSlow,
        Self::ReceiverFails,
        Self::ReceiverSilent,
        Self::ReceiverCuts,
    ];

    /// The kinds of each run and those of the log.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::OF_EACH.into_iter().chain(Self::OF_LOG)
    }

    /// Its name in outputs.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::SupervisorKilled => "supervisor killed",
            Self::SupervisorStopped => "supervisor stopped",
            Self::SupervisorUpgraded => "supervisor upgraded",
            Self::SupervisorFrozen => "supervisor frozen",
            Self::HostClockStepped => "host's clock stepped",
            Self::ToBrokerCut => "way to the broker cut",
            Self::FromBrokerCut => "way from the broker cut",
            Self::BrokerLinkReset => "connections to the broker reset",
            Self::SubscriptionsForgotten => "subscriptions forgotten",
            Self::BrokerRestarted => "broker restarted",
            Self::BrokerReplaced => "broker replaced",
            Self::BrokerFrozen => "broker frozen",
            Self::Repetitions => "messages repeated",
            Self::SlowBroker => "messages late",
            Self::TopicsOvertake => "messages out of order",
            Self::RobotCut => "robot's connection cut",
            Self::RobotAway => "robot away",
            Self::RobotRestarted => "robot restarted",
            Self::Hostile => "hostile robot",
            Self::ToStoreCut => "way to the store cut",
            Self::FromStoreCut => "way from the store cut",
            Self::AnswersLost => "store's answers lost",
            Self::StoreSlow => "store slow",
            Self::StoreAway => "store away",
            Self::StoreFull => "store's disk full",
            Self::StoreClockStepped => "store's clock stepped",
            Self::StoreFailover => "store's last commits lost",
            Self::OperatorHolds => "operator holds a whisker",
            Self::ReceiverSlow => "receiver slow",
            Self::ReceiverFails => "receiver fails",
            Self::ReceiverSilent => "receiver silent",
            Self::ReceiverCuts => "receiver's answers lost",
            Self::ToLogCut => "way to the log cut",
            Self::FromLogCut => "way from the log cut",
            Self::LogDown => "log down",
            Self::LogFrozen => "log frozen",
            Self::PartitionAway => "log's partition away",
            Self::RecordsRepeated => "records repeated",
            Self::RecordsLate => "records late",
            Self::RecordsDeleted => "records deleted",
            Self::RecordDamaged => "record damaged",
        }
    }

    /// Range of its duration, ms.
    const fn lasts_ms(self) -> std::ops::Range<u64> {
        match self {
            Self::SupervisorKilled | Self::SupervisorStopped | Self::SupervisorUpgraded => 100..6_000,
            Self::ToStoreCut | Self::FromStoreCut => 50..5_000,
            Self::HostClockStepped => 500..8_000,
            // Longer than a robot may be silent.
            Self::SupervisorFrozen => 50..20_000,
            Self::ToBrokerCut | Self::FromBrokerCut | Self::RobotAway => 100..20_000,
            Self::BrokerLinkReset
            | Self::SubscriptionsForgotten
            | Self::RobotCut
            | Self::RobotRestarted
            | Self::Hostile
            | Self::RecordsDeleted
            | Self::RecordDamaged
            | Self::StoreClockStepped => 1..2,
            Self::BrokerRestarted | Self::BrokerReplaced | Self::BrokerFrozen => 50..8_000,
            Self::Repetitions | Self::SlowBroker | Self::TopicsOvertake => 500..10_000,
            Self::RecordsRepeated | Self::RecordsLate => 500..10_000,
            Self::LogDown | Self::LogFrozen | Self::PartitionAway => 50..12_000,
            Self::ToLogCut | Self::FromLogCut => 100..12_000,
            Self::AnswersLost | Self::StoreAway | Self::StoreSlow | Self::StoreFull => 20..6_000,
            Self::StoreFailover => 20..1_000,
            Self::OperatorHolds => 1_000..20_000,
            Self::ReceiverSlow | Self::ReceiverFails | Self::ReceiverSilent | Self::ReceiverCuts => 500..20_000,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// A fault at its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strike {
    /// From the start of the run.
    pub at: Duration,
    /// Its kind.
    pub kind: Kind,
    /// How long it lasts.
    pub lasts: Duration,
    /// Number of the robot, supervisor or receiver that it strikes, modulo their number.
    pub victim: usize,
    /// Its measure: polls until a kill, size of a step, length of a delay; each fault takes its own range of it.
    pub measure: u64,
}

impl fmt::Display for Strike {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (at_s, lasts_s) = (self.at.as_secs_f64(), self.lasts.as_secs_f64());
        write!(f, "{at_s:9.3} s  {} ({lasts_s:.3} s, victim {}, measure {})", self.kind, self.victim, self.measure)
    }
}

/// The world of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Seed of everything that the plan leaves open.
    pub seed: u64,
    /// Number of supervisors.
    pub supervisors: usize,
    /// Number of fleets.
    pub fleets: usize,
    /// Number of robots.
    pub robots: usize,
    /// Contacts of each whisker per second.
    pub contacts_per_second: f64,
    /// Time in which faults begin.
    pub length: Duration,
    /// The faults, in the order of their times.
    pub strikes: Vec<Strike>,
    /// A rule of the contract that all robots break.
    pub misbehaviour: Option<Misbehaviour>,
    /// Whether contacts and statuses come from the partitioned log; otherwise over MQTT.
    pub is_from_log: bool,
}

/// Sizes of the worlds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Most supervisors.
    pub supervisors: usize,
    /// Most robots.
    pub robots: usize,
    /// Time in which faults begin.
    pub length: Duration,
    /// Whether each world has these sizes; otherwise they are drawn.
    pub are_fixed: bool,
}

impl Default for Sizes {
    fn default() -> Self {
        Self { supervisors: 3, robots: 20, length: Duration::from_secs(120), are_fixed: false }
    }
}

impl Plan {
    /// Draws a plan: which kinds of faults occur, how often, and when.
    #[must_use]
    pub fn draw(seed: u64, sizes: Sizes) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let supervisors = if sizes.are_fixed { sizes.supervisors } else { random.random_range(1..=sizes.supervisors) };
        let robots = if sizes.are_fixed { sizes.robots } else { random.random_range(1..=sizes.robots) };
        let strikes = strikes(&mut random, &Kind::OF_EACH, CALM + sizes.length);
        let plan = Self {
            seed,
            supervisors,
            fleets: random.random_range(1..=supervisors),
            robots,
            contacts_per_second: 0.2 * 20.0_f64.powf(random.random::<f64>()),
            length: CALM + sizes.length,
            strikes,
            misbehaviour: None,
            is_from_log: false,
        };
        if HAS_LOG && seed % LOG_EVERY == 1 { plan.from_log() } else { plan }
    }

    /// The plan with contacts and statuses from the partitioned log, and with faults of the log beside the others.
    #[must_use]
    pub fn from_log(&self) -> Self {
        if self.is_from_log {
            return self.clone();
        }
        let mut random = ChaCha8Rng::seed_from_u64(self.seed ^ 0x006c_6f67);
        let mut all = self.strikes.clone();
        let of_log = strikes(&mut random, &Kind::OF_LOG, self.length).into_iter();
        // Operators must keep records for an hour (docs/kafka.md).
        all.extend(of_log.filter(|strike| strike.kind != Kind::RecordsDeleted));
        all.sort_by_key(|strike| strike.at);
        Self { is_from_log: true, ..self.with(all) }
    }

    /// The plan with these faults in the place of all.
    #[must_use]
    pub fn with(&self, strikes: Vec<Strike>) -> Self {
        Self { strikes, ..self.clone() }
    }

    /// The plan without the faults of these kinds.
    #[must_use]
    pub fn without(&self, kinds: &[Kind]) -> Self {
        self.with(self.strikes.iter().copied().filter(|strike| !kinds.contains(&strike.kind)).collect())
    }

    /// The plan with faults of these kinds alone, as many as before. Each fault keeps its duration, which may be longer than
    /// the range of its new kind.
    #[must_use]
    pub fn only(&self, kinds: &[Kind]) -> Self {
        let strike = |strike: &Strike| Strike { kind: kinds[strike.victim % kinds.len()], ..*strike };
        self.with(self.strikes.iter().map(strike).collect())
    }
}

/// Draws which of these kinds of faults occur, how often, and when.
fn strikes(random: &mut ChaCha8Rng, kinds: &[Kind], end: Duration) -> Vec<Strike> {
    let mut kinds: Vec<Kind> = kinds.iter().copied().filter(|_| random.random_bool(0.5)).collect();
    kinds.shuffle(random);
    // From a fault in ten seconds to five in a second.
    let mean = Duration::from_secs_f64(0.2 * 50.0_f64.powf(random.random::<f64>()));
    let mut strikes = Vec::new();
    let mut at = CALM;
    loop {
        at += mean.mul_f64(-(1.0 - random.random::<f64>()).ln());
        if at >= end {
            return strikes;
        }
        let Some(&kind) = kinds.choose(random) else { return strikes };
        strikes.push(Strike {
            at,
            kind,
            lasts: Duration::from_millis(random.random_range(kind.lasts_ms())),
            victim: random.random_range(0..1_000),
            measure: random.random(),
        });
    }
}
