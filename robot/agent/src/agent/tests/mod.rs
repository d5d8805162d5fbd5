//! Test bench for an agent: without a network and a driver, with a simulated clock.

mod driver;
mod fuzz;
mod gains;
mod locate;
mod restart;
mod setpoints;
mod several;
mod slide;
mod strain;
mod valves;

use std::path::Path;

use vibrissa_protocol::{
    BootId, Contacts, Message, Name, Receipt, Setpoint, SetpointError, SetpointOutcome, SetpointReason, Status,
    Timestamp, TouchTest, TouchTestKind, TouchTestOutcome, TouchTestReason, encode,
};

use super::*;
use crate::config::tests::EXAMPLE;

const S: u64 = 1_000_000;
const START: u64 = 1_795_248_000 * S;

fn left() -> Name {
    Name::new("left").unwrap()
}

fn supervisor() -> BootId {
    BootId::new("s3").unwrap()
}

/// An agent, a time that only moves forward, and what the agent has done.
struct Bench {
    agent: Agent,
    now_us: u64,
    /// Difference of the system's clock since it was set, in microseconds.
    stepped_us: i64,
    messages: Vec<Message>,
    to_driver: Vec<ToDriver>,
    /// Lines to drivers other than the first one.
    to_others: Vec<ToDriver>,
    warnings: Vec<String>,
    /// Contacts that have no room in memory, and how many of them were taken back.
    disk: VecDeque<Vec<u8>>,
    taken: u64,
    records: Vec<Record>,
    restarts: usize,
    reconnects: usize,
}

impl Bench {
    fn new(edit: impl FnOnce(&mut Config)) -> Self {
        Self::after(edit, "b1", Stored::default(), START)
    }

    /// An agent that starts with what others have stored.
    fn after(edit: impl FnOnce(&mut Config), boot: &str, stored: Stored, now_us: u64) -> Self {
        let mut config = Config::from_toml_str(EXAMPLE, Path::new("")).unwrap();
        edit(&mut config);
        let (agent, records) = Agent::new(&config, BootId::new(boot).unwrap(), stored, Now::of_us(now_us));
        Self {
            agent,
            now_us,
            stepped_us: 0,
            messages: vec![],
            to_driver: vec![],
            to_others: vec![],
            warnings: vec![],
            disk: VecDeque::new(),
            taken: 0,
            records,
            restarts: 0,
            reconnects: 0,
        }
    }

    /// A connected agent whose driver reports its pressures.
    fn running() -> Self {
        let mut bench = Self::new(|_| {});
        bench.step(Input::Connected);
        bench.step(Input::DriverStarted(0));
        bench.read(0, 0.1);
        bench.read(1, 0.1);
        bench.take();
        bench
    }

    fn step(&mut self, input: Input<'_>) {
        let mut is_asked_back = self.step_once(input);
        while is_asked_back {
            let contacts = self.disk.pop_front();
            self.taken += u64::from(contacts.is_some());
            let position = (1, self.taken);
            is_asked_back = self.step_once(Input::CameBack(contacts.as_deref().map(|contacts| (contacts, position))));
        }
    }

    /// Returns whether the agent asks for a message from the disk.
    fn step_once(&mut self, input: Input<'_>) -> bool {
        let system_us = self.now_us.saturating_add_signed(self.stepped_us);
        let now = Now { system_us, ..Now::of_us(self.now_us) };
        let mut is_asked_back = false;
        for output in self.agent.step(now, input) {
            match output {
                Output::Publish(topic, payload) => {
                    let topic = topic.of(&self.agent.fleet, &self.agent.robot);
                    self.messages.push(decode(&topic, &payload).expect("an agent keeps the contract"));
                }
                Output::Tell(0, line) => self.to_driver.push(line),
                Output::Tell(_, line) => self.to_others.push(line),
                Output::Warn(text) => self.warnings.push(text),
                Output::Spool(contacts) => self.disk.push_back(contacts),
                Output::TakeBack => is_asked_back = true,
                Output::Store(record) => self.records.push(record),
                Output::RestartDriver(..) => self.restarts += 1,
                Output::Reconnect => self.reconnects += 1,
            }
        }
        is_asked_back
    }

    /// Moves the time from deadline to deadline.
    fn run(&mut self, seconds: f64) {
        let until_us = self.now_us + (seconds * 1e6) as u64;
        while self.agent.next_deadline().as_us() <= until_us {
            self.now_us = self.now_us.max(self.agent.next_deadline().as_us());
            let before = self.agent.next_deadline();
            self.step(Input::Tick);
            assert!(self.agent.next_deadline() > before.min(Moment::of_us(self.now_us)), "a deadline must pass");
        }
        self.now_us = until_us;
    }

    fn line(&mut self, line: &str) {
        self.step(Input::Line(0, Some(line.as_bytes())));
    }

    fn read(&mut self, whisker: u16, pressure_mpa: f64) {
        self.line(&format!(r#"{{"type":"pressure","whisker":{whisker},"pressure_mpa":{pressure_mpa}}}"#));
    }

    /// Reads the same pressures for a time.
    fn hold(&mut self, pressures_mpa: [f64; 2], seconds: f64) {
        for _ in 0..(seconds * 10.0) as usize {
            self.run(0.1);
            self.read(0, pressures_mpa[0]);
            self.read(1, pressures_mpa[1]);
        }
    }

    fn touch(&mut self, whisker: u16) {
        self.line(&format!(
            r#"{{"type":"contact","whisker":{whisker},"deflection_mm":2.0,"strain":0.01,"ratio":0.8}}"#
        ));
    }

    fn send(&mut self, topic: RobotTopic, message: &impl serde::Serialize) {
        self.step(Input::Message(topic, &encode(message)));
    }

    fn receipt(&mut self, boot: &str, next: u64) {
        let robot_boot_id = BootId::new(boot).unwrap();
        self.send(RobotTopic::Receipt, &Receipt { boot_id: supervisor(), seq: 0, robot_boot_id, next, held: vec![] });
    }

    fn setpoint(&self, version: u64, pressure_mpa: f64) -> Setpoint {
        Setpoint {
            boot_id: supervisor(),
            seq: version,
            command_id: format!("command-{version}"),
            epoch: 1,
            version,
            robot_boot_id: self.agent.boot_id().clone(),
            array: left(),
            whisker: 0,
            pressure_mpa,
            slew_mpa_per_s: 0.02,
            issued: Timestamp(self.now_us),
            expires_us: self.now_us + 30 * S,
            reason: SetpointReason::SelfCompensation,
            gain: vec![],
            reading_gain: None,
        }
    }

    fn order(&mut self, version: u64, pressure_mpa: f64) {
        let setpoint = self.setpoint(version, pressure_mpa);
        self.send(RobotTopic::Setpoint, &setpoint);
    }

    /// Forgets what the agent has done, and returns it.
    fn take(&mut self) -> (Vec<Message>, Vec<ToDriver>) {
        (std::mem::take(&mut self.messages), std::mem::take(&mut self.to_driver))
    }

    fn outcomes(&mut self) -> Vec<(SetpointOutcome, Option<SetpointError>)> {
        let states = self.take().0.into_iter();
        states.filter_map(|m| if let Message::SetpointState(s) = m { Some((s.state, s.error)) } else { None }).collect()
    }

    fn contacts(&mut self) -> Vec<Contacts> {
        self.take().0.into_iter().filter_map(|m| if let Message::Contacts(c) = m { Some(c) } else { None }).collect()
    }

    fn statuses(&mut self) -> Vec<Status> {
        self.take().0.into_iter().filter_map(|m| if let Message::Status(s) = m { Some(s) } else { None }).collect()
    }

    /// Pressures that the driver was told for a whisker.
    fn pressures(&self, number: u16) -> Vec<f64> {
        let lines = self.to_driver.iter();
        lines
            .filter_map(|line| {
                if let ToDriver::SetPressure { whisker, pressure_mpa, .. } = line {
                    (*whisker == number).then_some(*pressure_mpa)
                } else {
                    None
                }
            })
            .collect()
    }

    fn problems(&mut self) -> Vec<String> {
        let lines = self.take().1.into_iter();
        lines.filter_map(|line| if let ToDriver::Error { problem, .. } = line { Some(problem) } else { None }).collect()
    }

    /// The state that a restart would find.
    fn stored(&self) -> Stored {
        let mut stored = Stored::default();
        for record in &self.records {
            let json = serde_json::to_string(record).unwrap();
            stored.take(serde_json::from_str(&json).unwrap());
        }
        stored
    }
}
