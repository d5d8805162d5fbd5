//! A robot connected directly to the core, in simulated time: real messages, no network, no waiting.

use vibrissa_core::robot::effect::{Command, CommandKey, Effect, TouchTest};
use vibrissa_core::robot::{Event, Numbers, OperatorAction, Outcome, Params, Robot};
use vibrissa_core::units::Micros;
use vibrissa_edge as edge;
use vibrissa_edge::contract::setpoint_reason;
use vibrissa_protocol::{self as protocol, BootId, Message, Name, RobotTopic, Timestamp, decode, encode};
use vibrissa_simulator::robot::Outgoing;
use vibrissa_simulator::{Robot as SimulatedRobot, RobotConfig, Scenario};

/// Start of the simulated time, in microseconds since 1970 UTC: arbitrary, so that nothing depends on the present
/// date.
pub const START_US: u64 = 1_795_248_000_000_000;
const TICK_US: u64 = 250_000;

/// A robot in simulated time. Times are in microseconds since 1970 UTC.
pub trait Peer {
    /// Its fleet.
    fn fleet(&self) -> &Name;
    /// Its name in the fleet.
    fn name(&self) -> &Name;
    /// The connection to the broker is established.
    fn connected(&mut self, now_us: u64) -> Vec<Outgoing>;
    /// Latest time of the next call of `poll`.
    fn next_deadline(&self) -> u64;
    /// Does all that is due until now.
    fn poll(&mut self, now_us: u64) -> Vec<Outgoing>;
    /// Takes a message.
    fn receive(&mut self, topic: RobotTopic, payload: &[u8], now_us: u64) -> Vec<Outgoing>;
}

impl Peer for SimulatedRobot {
    fn fleet(&self) -> &Name {
        self.fleet()
    }

    fn name(&self) -> &Name {
        self.name()
    }

    fn connected(&mut self, now_us: u64) -> Vec<Outgoing> {
        self.connected(now_us)
    }

    fn next_deadline(&self) -> u64 {
        self.next_deadline()
    }

    fn poll(&mut self, now_us: u64) -> Vec<Outgoing> {
        self.poll(now_us)
    }

    fn receive(&mut self, topic: RobotTopic, payload: &[u8], now_us: u64) -> Vec<Outgoing> {
        self.receive(topic, payload, now_us)
    }
}

/// One robot, and the core that supervises it.
pub struct World<R = SimulatedRobot> {
    /// The robot with its true whiskers.
    pub robot: R,
    /// State of the robot in the core.
    pub core: Robot,
    /// Parameters of the core.
    pub params: Params,
    /// Effects of the core with their times, except single contacts and responses.
    pub effects: Vec<(Micros, Effect)>,
    /// Number of recorded contacts.
    pub contacts: u64,
    /// Number of contacts that entered estimation.
    pub used: u64,
    /// Whether an operator approves each proposal immediately.
    pub approves_at_once: bool,
    now_us: u64,
    next_tick_us: u64,
    seq: u64,
}

impl World<SimulatedRobot> {
    /// The first robot of a scenario, connected.
    pub fn new(scenario: &Scenario, params: Params) -> Self {
        scenario.check().expect("a valid scenario");
        let config = RobotConfig::all(scenario).next().expect("a robot");
        Self::of(SimulatedRobot::new(config, scenario.seed, START_US).expect("a robot"), params)
    }
}

impl<R: Peer> World<R> {
    /// A robot that connects now.
    pub fn of(robot: R, params: Params) -> Self {
        let mut world = Self {
            robot,
            core: Robot::new(1, Numbers::default()),
            params,
            effects: Vec::new(),
            contacts: 0,
            used: 0,
            approves_at_once: false,
            now_us: START_US,
            next_tick_us: START_US,
            seq: 0,
        };
        let births = world.robot.connected(START_US);
        world.deliver(births);
        world
    }

    /// Seconds since the start.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        (self.now_us - START_US) as f64 / 1e6
    }

    /// Runs until `seconds` after the start.
    pub fn run_until_s(&mut self, seconds: f64) {
        let end_us = START_US + (seconds * 1e6) as u64;
        while self.now_us < end_us {
            self.now_us = self.robot.next_deadline().min(self.next_tick_us).clamp(self.now_us, end_us);
            let said = self.robot.poll(self.now_us);
            self.deliver(said);
            if self.now_us >= self.next_tick_us {
                self.next_tick_us += TICK_US;
                self.step(&Event::Tick);
            }
        }
    }

    /// Time passes, but the robot's messages are lost.
    pub fn silent_for_s(&mut self, seconds: f64) {
        let end_us = self.now_us + (seconds * 1e6) as u64;
        while self.now_us < end_us {
            self.now_us += TICK_US;
            self.robot.poll(self.now_us);
            self.step(&Event::Tick);
        }
        self.next_tick_us = self.now_us;
    }

    fn deliver(&mut self, said: Vec<Outgoing>) {
        for outgoing in said {
            match outgoing {
                Outgoing::Publish { topic, payload } => self.receive(topic, &payload),
                Outgoing::Restart => {
                    let births = self.robot.connected(self.now_us);
                    self.deliver(births);
                }
            }
        }
    }

    fn receive(&mut self, kind: RobotTopic, payload: &[u8]) {
        let topic = kind.of(self.robot.fleet(), self.robot.name());
        match decode(&topic, payload).expect("the simulator keeps the contract") {
            Message::Connection(connection) => {
                self.step(&Event::Connection {
                    boot_id: connection.boot_id.as_str(),
                    link: edge::link(connection.state),
                });
            }
            Message::Factsheet(sheet) => {
                let factsheet = edge::factsheet(&sheet, &["nguyen-2021"]).expect("a known model");
                self.step(&Event::Factsheet { boot_id: sheet.boot_id.as_str(), factsheet: &factsheet });
            }
            Message::Contacts(message) => {
                let missed: Vec<_> = message.missed.iter().map(|one| edge::missed(one).expect("in range")).collect();
                let contacts: Vec<_> =
                    message.contacts.iter().map(|one| edge::contact(one).expect("in range")).collect();
                self.step(&Event::Contacts {
                    boot_id: message.boot_id.as_str(),
                    seq: message.seq,
                    contacts: &contacts,
                    missed: &missed,
                });
                self.receipt(&message.boot_id);
            }
            Message::Status(status) => {
                let whiskers: Vec<_> = status.whiskers.iter().map(|one| edge::status(one).expect("in range")).collect();
                let robot_time = Micros(status.t_us);
                self.step(&Event::Status { boot_id: status.boot_id.as_str(), robot_time, whiskers: &whiskers });
            }
            Message::SetpointState(message) => self.setpoint_state(&message),
            Message::TestState(message) => self.test_state(&message),
            other => panic!("a robot does not send {other:?}"),
        }
    }

    fn setpoint_state(&mut self, state: &protocol::SetpointState) {
        let Some((command, pressure)) = self
            .core
            .commands_under_way()
            .find(|command| name_of(command.key) == state.command_id)
            .map(|command| (command.key, command.pressure))
        else {
            return;
        };
        let report = edge::setpoint_report(state, pressure).expect("in range");
        let robot_time = Micros(state.t_us);
        self.step(&Event::Setpoint { boot_id: state.boot_id.as_str(), command, report, robot_time });
    }

    fn test_state(&mut self, state: &protocol::TestState) {
        let mut tests = self.core.tests_under_way().map(|(test, _)| test);
        let Some(test) = tests.find(|test| name_of(*test) == state.test_id) else { return };
        drop(tests);
        let (boot_id, robot_time) = (state.boot_id.as_str(), Micros(state.t_us));
        self.step(&Event::TouchTest { boot_id, test, report: edge::touch_tests::report(state), robot_time });
    }

    /// Steps the core and executes its effects.
    pub fn step(&mut self, event: &Event<'_>) -> Outcome {
        let mut effects = Vec::new();
        let outcome = self.core.step(&self.params, Micros(self.now_us), event, &mut effects);
        if self.approves_at_once {
            self.approve_all(&mut effects);
        }
        for effect in effects {
            match &effect {
                Effect::Contact(contact) => {
                    self.contacts += 1;
                    self.used += u64::from(contact.residual.is_some());
                    continue;
                }
                Effect::Response(_) => continue,
                Effect::Command(command) | Effect::Resend(command) => self.send(command),
                Effect::Test(test) => self.request(test),
                _ => {}
            }
            self.effects.push((Micros(self.now_us), effect));
        }
        outcome
    }

    fn approve_all(&mut self, effects: &mut Vec<Effect>) {
        let waiting: Vec<u32> =
            self.core.compensations().iter().filter(|one| one.is_proposed()).map(|one| one.id()).collect();
        for compensation in waiting {
            let approve = OperatorAction::Approve { compensation };
            self.core.step(&self.params, Micros(self.now_us), &Event::Operator(&approve), effects);
        }
    }

    fn next_seq(&mut self) -> u64 {
        self.seq += 1;
        self.seq - 1
    }

    fn send(&mut self, command: &Command) {
        let whisker = self.core.whisker(command.whisker).expect("there");
        let (gain, reading_gain) = edge::gain(command.gain.as_ref());
        let setpoint = protocol::Setpoint {
            boot_id: BootId::new("s").expect("a boot id"),
            seq: self.seq,
            command_id: name_of(command.key),
            epoch: command.key.epoch,
            version: command.key.version,
            robot_boot_id: BootId::new(&command.robot_boot_id).expect("a boot id"),
            array: Name::new(whisker.array).expect("a name"),
            whisker: whisker.sheet.number,
            pressure_mpa: command.pressure.mpa(),
            slew_mpa_per_s: command.slew_mpa_per_s,
            issued: Timestamp(command.issued.0),
            expires_us: command.expires.0,
            reason: setpoint_reason(command.reason),
            gain,
            reading_gain,
        };
        self.next_seq();
        let answers = self.robot.receive(RobotTopic::Setpoint, &encode(&setpoint), self.now_us);
        self.deliver(answers);
    }

    fn request(&mut self, test: &TouchTest) {
        let sender = (BootId::new("s").expect("a boot id"), self.next_seq());
        let request = edge::touch_tests::request(&self.core, test, name_of(test.key), sender).expect("there");
        let answers = self.robot.receive(RobotTopic::Request, &encode(&request), self.now_us);
        self.deliver(answers);
    }

    fn receipt(&mut self, boot_id: &BootId) {
        let Some(sequence) = self.core.sequence(boot_id.as_str()) else { return };
        let receipt = protocol::Receipt {
            boot_id: BootId::new("s").expect("a boot id"),
            seq: self.seq,
            robot_boot_id: boot_id.clone(),
            next: sequence.next(),
            held: sequence.held().to_vec(),
        };
        self.next_seq();
        let answers = self.robot.receive(RobotTopic::Receipt, &encode(&receipt), self.now_us);
        self.deliver(answers);
    }

    /// The effects that `pick` selects, in order.
    pub fn picked<T>(&self, pick: impl Fn(&Effect) -> Option<T>) -> Vec<T> {
        self.effects.iter().filter_map(|(_, effect)| pick(effect)).collect()
    }
}

fn name_of(key: CommandKey) -> String {
    format!("{}-{}", key.epoch, key.version)
}
