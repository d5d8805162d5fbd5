//! One robot: the contract's rules around whiskers and their regulators, without sockets and clock.
//!
//! Call [`Robot::will`] before connecting, [`Robot::connected`] after subscribing, then [`Robot::poll`] at each
//! [`Robot::next_deadline`], [`Robot::receive`] for each message, and [`Robot::receive_request_to_all`] for each one on
//! `supervisor/request`; send the returned messages in order. Call
//! [`Robot::disconnected`] after the connection is lost: the robot continues and keeps its contacts. All times are
//! in microseconds since 1970 UTC by the robot's clock.

mod births;
mod estimates;
mod events;
mod misbehaviour;
mod outgoing;
mod resume;
mod setpoints;
mod timers;
mod touch_tests;
mod whisker;

use std::collections::{BTreeMap, VecDeque};

use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{Formulation, Model, ModelError};
use vibrissa_protocol::{
    self as protocol, BootId, Contact, Message, MissedTouch, Name, Receipt, RequestKind, RobotTopic, decode,
};
pub use vibrissa_robot::contract::Outgoing;
use vibrissa_robot::contract::{
    Births, Commands, EstimateOrder, Facts, Moment, Outbox, Supervision, TouchTests, Voice,
};

pub(crate) use resume::RobotState;
pub use whisker::Whisker;

use touch_tests::UnderWay;

use crate::journal::{Journal, JournalEntry};
use crate::link::Link;
use crate::random::{Purpose, boot_text, stream};
use crate::regulator::{SUPPLY_MPA, TICK_US};
use crate::scenario::{Behaviour, Event, Misbehaviour, Noise, RobotScenario, Scenario};
use timers::Contacts;
pub(crate) use timers::contact_of;

/// Largest number of timers in one [`Robot::poll`]; a late robot catches up in several polls.
const STEPS_PER_POLL: usize = 4096;

/// Configuration of one robot.
#[derive(Debug, Clone)]
pub struct RobotConfig {
    /// Name of the fleet.
    pub fleet: Name,
    /// Behaviour of the robot.
    pub behaviour: Behaviour,
    /// Noise of the sensors.
    pub noise: Noise,
    /// Largest relative deviation of the whiskers' calibrations.
    pub calibration_error: f64,
    /// Mechanics of its whiskers without deviations.
    pub model: Model,
    /// Name of these mechanics in the factsheet: that of the scenario's calibration, or of the built-in one.
    pub model_name: String,
    /// Scenario of the robot.
    pub robot: RobotScenario,
}

impl RobotConfig {
    /// Configurations of a scenario's robots, in its order.
    pub fn all(scenario: &Scenario) -> impl Iterator<Item = Self> {
        // Scenario::check refuses a calibration without a model.
        let model = scenario.model().unwrap_or_else(|_| Model::nguyen_2021(Formulation::Consistent));
        scenario.robots.iter().map(move |robot| Self {
            fleet: scenario.fleet.clone(),
            behaviour: scenario.behaviour.clone(),
            noise: scenario.noise.clone(),
            calibration_error: scenario.calibration_error,
            model: model.clone(),
            model_name: scenario.calibration.as_ref().map_or("nguyen-2021", |own| own.name.as_str()).to_owned(),
            robot: robot.clone(),
        })
    }
}

/// One simulated robot.
#[derive(Debug)]
pub struct Robot {
    config: RobotConfig,
    seed: u64,
    start_us: u64,
    boots: u64,
    voice: Voice,
    facts: Facts,
    connected: bool,
    whiskers: Vec<Whisker>,
    places: BTreeMap<(Name, u16), usize>,
    supply_mpa: f64,
    commands: Commands,
    births: Births,
    birth_delays: ChaCha8Rng,
    estimates: EstimateOrder,
    outbox: Outbox,
    link: Link,
    /// Contacts of the incomplete message, and the time at which it is sent.
    batch: Vec<Contact>,
    /// Touches of tests that did not come, of the incomplete message.
    missed: Vec<MissedTouch>,
    touch_tests: TouchTests,
    tests_under_way: VecDeque<UnderWay>,
    batch_until_us: Option<u64>,
    contacts: Contacts,
    tick_at_us: u64,
    /// Time of the newest message received.
    received_us: u64,
    status_at_us: u64,
    status_sent_us: u64,
    events: VecDeque<(u64, Event)>,
    supervision: Supervision,
    /// Whether the robot has said its farewell, since its last connection.
    is_leaving: bool,
    /// Messages that the fault of dropping the newest has dropped in this boot.
    dropped_newest: u64,
    refused: u64,
    journal: Journal,
    /// Whether something has happened since the last [`Robot::take_change`].
    has_changed: bool,
}

impl Robot {
    /// A robot that starts at the given time, with whole whiskers at their nominal pressure, not connected.
    ///
    /// # Errors
    /// A whisker's calibration is invalid: the configuration was not checked with [`Scenario::check`].
    pub fn new(config: RobotConfig, seed: u64, start_us: u64) -> Result<Self, ModelError> {
        Self::begin(config, seed, start_us, start_us)
    }

    /// A robot whose scenario began at `start_us`, and which makes contacts from `now_us` on.
    fn begin(config: RobotConfig, seed: u64, start_us: u64, now_us: u64) -> Result<Self, ModelError> {
        let name = config.robot.robot.clone();
        let mut whiskers = Vec::new();
        for (array, whisker) in config.robot.whiskers() {
            whiskers.push(Whisker::new(&config, array, whisker, seed)?);
        }
        let places = whiskers.iter().enumerate().map(|(at, w)| ((w.array().clone(), w.number()), at)).collect();
        let mut robot = Self {
            voice: Voice::new(boot_id(seed, &name, start_us, 0)),
            facts: outgoing::facts(&config),
            seed,
            start_us,
            boots: 0,
            connected: false,
            places,
            supply_mpa: SUPPLY_MPA,
            commands: Commands::default(),
            births: Births::default(),
            birth_delays: stream(seed, name.as_str(), "", 0, Purpose::Birth),
            estimates: EstimateOrder::default(),
            outbox: misbehaviour::outbox(&config.behaviour),
            link: Link::new(stream(seed, name.as_str(), "", 0, Purpose::Link)),
            batch: Vec::new(),
            missed: Vec::new(),
            touch_tests: TouchTests::default(),
            tests_under_way: VecDeque::new(),
            batch_until_us: None,
            contacts: Contacts::new(now_us, config.behaviour.contacts_per_second),
            tick_at_us: now_us + TICK_US,
            received_us: 0,
            status_at_us: now_us,
            status_sent_us: now_us,
            events: VecDeque::new(),
            supervision: Supervision::new((config.behaviour.supervisor_lost_after_s * 1e6) as u64),
            is_leaving: false,
            dropped_newest: 0,
            refused: 0,
            journal: Journal::new(config.behaviour.journal),
            has_changed: false,
            whiskers,
            config,
        };
        robot.plan_events();
        robot.plan_contacts();
        Ok(robot)
    }

    /// Handles an established connection with its subscriptions: sends birth, factsheet and status; all stored
    /// contacts messages become due.
    pub fn connected(&mut self, now_us: u64) -> Vec<Outgoing> {
        let mut out = Vec::new();
        self.connected = true;
        self.is_leaving = false;
        self.link.reconnected();
        self.outbox.reconnected();
        self.births.sent();
        self.birth(now_us, &mut out);
        if !self.breaks(Misbehaviour::NoFactsheetAtBirth) {
            self.factsheet(now_us, &mut out);
        }
        self.status(now_us, &mut out);
        out
    }

    /// Handles the loss of the connection; contacts are stored until the next one.
    pub fn disconnected(&mut self) {
        self.connected = false;
    }

    /// Does a limited part of the work that is due; after the limit, the next deadline lies in the past.
    pub fn poll(&mut self, now_us: u64) -> Vec<Outgoing> {
        let mut out = Vec::new();
        for _ in 0..STEPS_PER_POLL {
            match self.next_timer() {
                Some((at_us, timer)) if at_us <= now_us => self.expire(timer, at_us, now_us, &mut out),
                Some(_) | None => break,
            }
        }
        out
    }

    /// Latest time of the next [`Robot::poll`].
    #[must_use]
    pub fn next_deadline(&self) -> u64 {
        self.next_timer().map_or(u64::MAX, |(at_us, _)| at_us)
    }

    /// Handles a message on one of the robot's topics; an invalid one is counted and has no effect.
    pub fn receive(&mut self, topic: RobotTopic, payload: &[u8], now_us: u64) -> Vec<Outgoing> {
        self.received_us = now_us;
        let mut out = Vec::new();
        let Ok(message) = decode(&topic.of(&self.config.fleet, &self.config.robot.robot), payload) else {
            self.on_invalid(&mut out);
            return out;
        };
        if self.ignores(&message, payload) {
            return out;
        }
        // The broker keeps the last estimate: at each connection it comes again, even if its supervisor is gone.
        if let Message::Estimate(estimate) = &message
            && !self.accepts_estimate(estimate)
        {
            return out;
        }
        self.supervision.heard(Moment::of_us(now_us));
        match message {
            Message::Receipt(receipt) => self.receipt(&receipt, now_us),
            Message::Setpoint(setpoint) => self.setpoint(&setpoint, now_us, &mut out),
            Message::Request(protocol::Request { touch_test: Some(test), .. }) => {
                self.touch_test(test, now_us, &mut out)
            }
            Message::Estimate(estimate) => self.estimate(&estimate),
            Message::Request(request) => match request.request {
                RequestKind::Factsheet if self.breaks(Misbehaviour::IgnoresFactsheetRequest) => {}
                RequestKind::Factsheet => self.factsheet(now_us, &mut out),
                RequestKind::Status if self.breaks(Misbehaviour::IgnoresStatusRequest) => {}
                RequestKind::Status => self.status(now_us, &mut out),
                // It carries its test, handled above.
                RequestKind::TouchTest => {}
            },
            // A robot does not subscribe to robots' topics, nor to those of tools.
            Message::Connection(_)
            | Message::Factsheet(_)
            | Message::Contacts(_)
            | Message::Status(_)
            | Message::SetpointState(_)
            | Message::TestState(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => self.refused += 1,
        }
        out
    }

    fn receipt(&mut self, receipt: &Receipt, now_us: u64) {
        if receipt.robot_boot_id == *self.boot_id() || self.breaks(Misbehaviour::TakesAnyReceipt) {
            self.outbox.receipt(&self.receipt_as_read(receipt), Moment::of_us(now_us));
        }
    }

    /// Stops making contacts; the existing ones are sent until they are receipted.
    pub fn rest(&mut self) {
        self.contacts.stop();
        self.batch_until_us = self.batch_until_us.map(|_| 0);
    }

    /// Makes contacts from now on at this rate of each whisker, also after [`Robot::rest`]. The rate is limited to the range
    /// of [`Behaviour::contacts_per_second`](crate::scenario::Behaviour::contacts_per_second).
    pub fn touch_at_rate(&mut self, contacts_per_second: f64, now_us: u64) {
        self.contacts.restart(now_us, contacts_per_second.clamp(1e-6, 10_000.0));
    }

    /// Makes each further contact of a whisker at this contact ratio; `None`: at random ones, as at the start.
    pub fn touch_at_place(&mut self, array: &Name, number: u16, ratio: Option<f64>) {
        if let Some(whisker) = self.places.get(&(array.clone(), number)).and_then(|&at| self.whiskers.get_mut(at)) {
            whisker.plant.touch_at_place(ratio);
        }
    }

    /// Whether the robot is connected.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.connected
    }

    /// Fleet of the robot.
    #[must_use]
    pub fn fleet(&self) -> &Name {
        &self.config.fleet
    }

    /// Name of the robot.
    #[must_use]
    pub fn name(&self) -> &Name {
        &self.config.robot.robot
    }

    /// Id of the present boot.
    #[must_use]
    pub fn boot_id(&self) -> &BootId {
        self.voice.boot_id()
    }

    /// Start of the robot, in microseconds since 1970 UTC; the scenario's seconds count from it.
    #[must_use]
    pub fn start_us(&self) -> u64 {
        self.start_us
    }

    /// Whiskers of the robot, in the order of the scenario.
    #[must_use]
    pub fn whiskers(&self) -> &[Whisker] {
        &self.whiskers
    }

    /// Whisker with this array and number.
    #[must_use]
    pub fn whisker(&self, array: &Name, number: u16) -> Option<&Whisker> {
        self.whiskers.get(*self.places.get(&(array.clone(), number))?)
    }

    /// True length without the chamber's elongation, in mm; `None` if there is no such whisker.
    #[must_use]
    pub fn true_length_mm(&self, array: &Name, number: u16) -> Option<f64> {
        Some(self.whisker(array, number)?.plant().length_mm())
    }

    /// Number of contacts made by all whiskers so far.
    #[must_use]
    pub fn contacts_made(&self) -> u64 {
        self.whiskers.iter().map(|whisker| whisker.plant().contacts()).sum()
    }

    /// Number of contacts messages without a receipt.
    #[must_use]
    pub fn messages_kept(&self) -> usize {
        self.outbox.len()
    }

    /// Highest sequence number of a contacts message of this boot that a receipt has covered.
    #[must_use]
    pub fn newest_receipted(&self) -> Option<u64> {
        self.outbox.newest_covered()
    }

    /// Number of contacts messages of this boot dropped because the outbox was full, plus those lost in the restart
    /// before.
    #[must_use]
    pub fn messages_dropped(&self) -> u64 {
        self.outbox.dropped() + self.dropped_newest
    }

    /// Journal entries since the last call; empty unless [`Behaviour::journal`] is set.
    pub fn take_journal(&mut self) -> Vec<JournalEntry> {
        self.journal.take()
    }

    /// Number of received messages that were refused.
    #[must_use]
    pub fn messages_refused(&self) -> u64 {
        self.refused
    }
}

/// Boot id of a robot's boot.
fn boot_id(seed: u64, robot: &Name, start_us: u64, boot: u64) -> BootId {
    BootId::new(&boot_text(seed, robot.as_str(), start_us, boot)).expect("a short text of hexadecimal digits")
}

#[cfg(test)]
mod tests;
