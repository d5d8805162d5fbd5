//! Test bench for a robot: without a network, with a simulated clock.

mod connection;
mod delivery;
mod estimates;
mod events;
mod gains;
mod journal;
mod setpoints;
mod touch_tests;

use vibrissa_protocol::{
    Connection, ConnectionState, Contacts, Factsheet, Gauge, OnSupervisorLoss, Receipt, Regulator, Request, Setpoint,
    SetpointError, SetpointOutcome, SetpointReason, SetpointState, Status, SupervisorRequest, SupervisorRequestKind,
    Timestamp, encode,
};

use super::*;
use crate::scenario::Change;

const S: u64 = 1_000_000;
const START: u64 = 1_795_248_000 * S;

const SCENARIO: &str = r#"
fleet = "f"
seed = 7
[behaviour]
contacts_per_second = 2.0
[[robots]]
robot = "r"
[[robots.arrays]]
array = "left"
type = "TYPE_1"
whiskers = [{ whisker = 0, neighbours = [1] }, { whisker = 1, length_mm = 65.0 }]
"#;

fn left() -> Name {
    Name::new("left").unwrap()
}

/// The robot of an edited scenario, and a time that only moves forward.
struct Bench {
    robot: Robot,
    now_us: u64,
    messages: Vec<Message>,
    restarts: usize,
}

impl Bench {
    fn new(edit: impl FnOnce(&mut Scenario)) -> Self {
        let mut scenario = Scenario::from_toml_str(SCENARIO).unwrap();
        edit(&mut scenario);
        scenario.check().unwrap();
        let config = RobotConfig::all(&scenario).next().unwrap();
        let robot = Robot::new(config, scenario.seed, START).unwrap();
        Self { robot, now_us: START, messages: Vec::new(), restarts: 0 }
    }

    fn connected(edit: impl FnOnce(&mut Scenario)) -> Self {
        let mut bench = Self::new(edit);
        bench.connect();
        bench
    }

    fn with_events(events: impl IntoIterator<Item = Event>) -> Self {
        Self::connected(|scenario| scenario.robots[0].events.extend(events))
    }

    fn connect(&mut self) {
        let outgoing = self.robot.connected(self.now_us);
        self.take(outgoing);
    }

    fn take(&mut self, outgoing: Vec<Outgoing>) {
        for item in outgoing {
            match item {
                Outgoing::Restart => self.restarts += 1,
                Outgoing::Publish { topic, payload } => {
                    let topic = topic.of(self.robot.fleet(), self.robot.name());
                    self.messages.push(decode(&topic, &payload).expect("a robot keeps the contract"));
                }
            }
        }
    }

    /// Moves the time from deadline to deadline.
    fn run(&mut self, seconds: f64) {
        let until_us = self.now_us + (seconds * 1e6) as u64;
        while self.robot.next_deadline() <= until_us {
            self.now_us = self.now_us.max(self.robot.next_deadline());
            let outgoing = self.robot.poll(self.now_us);
            self.take(outgoing);
        }
        self.now_us = until_us;
    }

    fn send(&mut self, topic: RobotTopic, payload: &[u8]) {
        let outgoing = self.robot.receive(topic, payload, self.now_us);
        self.take(outgoing);
    }

    fn receipt(&mut self, next: u64) {
        let robot_boot_id = self.robot.boot_id().clone();
        let receipt = Receipt { boot_id: supervisor(), seq: 0, robot_boot_id, next, held: vec![] };
        self.send(RobotTopic::Receipt, &encode(&receipt));
    }

    fn setpoint(&mut self, version: u64, pressure_mpa: f64) -> Setpoint {
        self.setpoint_with_gain(version, pressure_mpa, None)
    }

    fn setpoint_with_gain(&mut self, version: u64, pressure_mpa: f64, reading_gain: Option<f64>) -> Setpoint {
        let setpoint = Setpoint {
            boot_id: supervisor(),
            seq: version,
            command_id: format!("command-{version}"),
            epoch: 1,
            version,
            robot_boot_id: self.robot.boot_id().clone(),
            array: left(),
            whisker: 0,
            pressure_mpa,
            slew_mpa_per_s: 0.02,
            issued: Timestamp(self.now_us),
            expires_us: self.now_us + 30 * S,
            reason: SetpointReason::SelfCompensation,
            gain: vec![(1.0, 1.0)],
            reading_gain,
        };
        self.send(RobotTopic::Setpoint, &encode(&setpoint));
        setpoint
    }

    /// Messages sent since the last call.
    fn sent(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }

    fn contacts(&mut self) -> Vec<Contacts> {
        self.sent().into_iter().filter_map(|m| if let Message::Contacts(c) = m { Some(c) } else { None }).collect()
    }

    fn statuses(&mut self) -> Vec<Status> {
        self.sent().into_iter().filter_map(|m| if let Message::Status(s) = m { Some(s) } else { None }).collect()
    }

    fn states(&mut self) -> Vec<SetpointState> {
        let states = self.sent().into_iter();
        states.filter_map(|m| if let Message::SetpointState(s) = m { Some(s) } else { None }).collect()
    }

    fn outcomes(&mut self) -> Vec<(String, SetpointOutcome, Option<SetpointError>)> {
        self.states().into_iter().map(|state| (state.command_id, state.state, state.error)).collect()
    }

    fn first(&self) -> &Whisker {
        &self.robot.whiskers()[0]
    }
}

fn supervisor() -> BootId {
    BootId::new("s3").unwrap()
}

fn seqs(contacts: &[Contacts]) -> Vec<u64> {
    contacts.iter().map(|message| message.seq).collect()
}
