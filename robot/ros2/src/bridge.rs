//! The bridge between the agent and ROS, without clock and network: `step(now, input)` returns what to send.

mod mapped;
mod messages;

use std::collections::BTreeMap;

use mapped::Mapped;
use ros2_client::builtin_interfaces::Time;

use crate::health::{self, Counts};
use crate::lifecycle::Activity;
use crate::lines::{estimate_message, goal_of};
use crate::mapping::{Mapping, Value};
use crate::messages::{
    Contact, DiagnosticArray, Estimate as EstimateMessage, Fault, Float64, FluidPressure, Header, Strain, TouchTestGoal,
};
use crate::touch::Progress;
use crate::units::Pressures;
use crate::whisker::Whisker;
use crate::words::{Estimate, FromAgent, LINE_MAX, Named, ToAgent, VERSION};

/// Most whiskers of a robot: each has four or five topics.
pub const WHISKERS_MAX: usize = 256;
/// Interval of reports on `/diagnostics`, seconds.
const REPORT_EVERY_S: f64 = 1.0;

/// An event for the bridge.
#[derive(Debug)]
pub enum Input {
    /// The way to the agent is open: at the start, and again after a loss.
    Linked,
    /// A line from the agent, or the reason why none could be read.
    Line(Result<String, String>),
    /// A contact, or the reason why it cannot be decoded.
    Contact(Result<Contact, String>),
    /// A reading of a whisker's chamber, by its index in the agent's `hello`, or the reason why it cannot be decoded.
    Pressure(usize, Result<FluidPressure, String>),
    /// Samples of a whisker's strain, by its index, or the reason why they cannot be decoded.
    Strain(usize, Result<Strain, String>),
    /// States of gauge and regulator, or the reason why they cannot be decoded.
    Fault(Result<Fault, String>),
    /// A message of the mapped topic with this index, or the reason why it cannot be decoded.
    Mapped(usize, Result<Value, String>),
    /// What the bridge does from now on.
    Activity(Activity),
    /// Progress of the touch test with this identifier.
    Test(String, Progress),
    /// Messages that came faster than the bridge can pass them on.
    Shed(u64),
    /// Time has passed.
    Tick,
}

/// An action of the bridge.
#[derive(Debug, PartialEq)]
pub enum Output {
    /// Sends a line to the agent.
    Line(ToAgent),
    /// Opens the topics of these whiskers.
    Open(Vec<Named>),
    /// Publishes the setpoint of a whisker, by index. With a mapping the pressure is the number of the mapped field.
    Setpoint(usize, FluidPressure),
    /// Publishes the factor on the readings of a whisker, by index.
    ReadingGain(usize, Float64),
    /// Publishes the estimate of a whisker, by index.
    Estimate(usize, EstimateMessage),
    /// Begins a touch test.
    Test(TouchTestGoal),
    /// Publishes a report.
    Report(DiagnosticArray),
    /// Logs a problem.
    Log(String),
    /// Ends the program; the agent starts it again.
    Stop(String),
}

/// Settings of the bridge.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Name of the robot in reports.
    pub robot: String,
    /// Meaning of pressures in ROS messages.
    pub pressures: Pressures,
    /// What the bridge does at first: nothing, if the node has a lifecycle.
    pub activity: Activity,
    /// Topics that exist already, and their values of whiskers.
    pub mapping: Option<Mapping>,
}

/// The state of the bridge.
#[derive(Debug)]
pub struct Bridge {
    settings: Settings,
    whiskers: Vec<Whisker>,
    index: BTreeMap<(String, u16), usize>,
    activity: Activity,
    mapped: Option<Mapped>,
    counts: Counts,
    reported_at_s: f64,
}

impl Bridge {
    /// A bridge that knows no whiskers yet.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            activity: settings.activity,
            settings,
            mapped: None,
            whiskers: Vec::new(),
            index: BTreeMap::new(),
            counts: Counts::default(),
            reported_at_s: f64::NEG_INFINITY,
        }
    }

    /// Handles an input. `now_s` is a clock that never goes back; `stamp` is the time for ROS.
    pub fn step(&mut self, now_s: f64, stamp: Time, input: Input) -> Vec<Output> {
        let outputs = match input {
            Input::Linked => {
                let (name, software_version) = ("vibrissa-ros2".to_owned(), env!("CARGO_PKG_VERSION"));
                Ok(vec![Output::Line(ToAgent::Hello { version: VERSION, name, software_version })])
            }
            Input::Contact(_) | Input::Pressure(..) | Input::Strain(..) | Input::Fault(_) | Input::Mapped(..)
                if self.activity == Activity::Idle =>
            {
                Ok(Vec::new())
            }
            Input::Activity(activity) => {
                self.activity = activity;
                Ok(Vec::new())
            }
            Input::Line(line) => self.line(now_s, stamp, line),
            Input::Contact(contact) => self.contact(stamp, contact),
            Input::Pressure(index, reading) => self.pressure(now_s, stamp, index, reading),
            Input::Strain(index, samples) => self.strain(stamp, index, samples),
            Input::Fault(fault) => self.fault(fault),
            Input::Mapped(topic, message) => self.mapped_message(now_s, stamp, topic, message),
            Input::Test(test_id, progress) => Ok(self.test(stamp, &test_id, progress)),
            Input::Shed(count) => {
                self.counts.shed += count;
                Ok(Vec::new())
            }
            Input::Tick => Ok(self.tick(now_s, stamp)),
        };
        outputs.unwrap_or_else(|problem| vec![self.refuse(problem)])
    }

    fn refuse(&mut self, problem: String) -> Output {
        self.counts.refuse(&problem);
        Output::Log(problem)
    }

    fn line(&mut self, now_s: f64, stamp: Time, line: Result<String, String>) -> Result<Vec<Output>, String> {
        let line = line?;
        if line.len() > LINE_MAX {
            return Err(format!("the agent sent a line of more than {LINE_MAX} bytes"));
        }
        let word =
            serde_json::from_str(&line).map_err(|problem| format!("the agent sent an unreadable line: {problem}"))?;
        match word {
            FromAgent::Hello { version, whiskers } => Ok(self.hello(now_s, version, whiskers)),
            FromAgent::SetPressure { array, whisker, pressure_mpa, slew_mpa_per_s } => {
                let index = self.find(&array, whisker)?;
                self.whiskers[index].command(now_s, pressure_mpa, slew_mpa_per_s)?;
                Ok(Vec::new())
            }
            FromAgent::ReadingGain { array, whisker, reading_gain } => {
                let index = self.find(&array, whisker)?;
                self.whiskers[index].multiply(reading_gain)?;
                Ok(vec![Output::ReadingGain(index, Float64 { data: reading_gain })])
            }
            FromAgent::Valve {} => Err("the agent pulses valves: set regulate = false for a ROS robot".to_owned()),
            FromAgent::Test(order) => {
                self.find(&order.array, order.whisker)?;
                self.counts.tests += 1;
                if self.activity != Activity::Active {
                    return Ok(self.test(stamp, &order.test_id, Progress::Failed("the node is not active".to_owned())));
                }
                Ok(vec![Output::Test(goal_of(order)?)])
            }
            FromAgent::Estimate(estimate) => self.estimate(stamp, estimate),
            FromAgent::Error { problem } => Err(format!("the agent refused a line: {problem}")),
            FromAgent::Other => Ok(Vec::new()),
        }
    }

    fn hello(&mut self, now_s: f64, version: u32, whiskers: Vec<Named>) -> Vec<Output> {
        if version != VERSION {
            return vec![Output::Stop(format!(
                "the agent speaks version {version} of the interface, this program {VERSION}"
            ))];
        }
        let known = |whisker: &Named| self.index.contains_key(&(whisker.array.clone(), whisker.whisker));
        if !self.whiskers.is_empty() {
            // The agent says hello at the start and again as an answer.
            let is_same = whiskers.len() == self.whiskers.len() && whiskers.iter().all(known);
            let stop = || Output::Stop("the robot has other whiskers now: starting anew".to_owned());
            if !is_same {
                return vec![stop()];
            }
            for named in whiskers {
                if let Some(&index) = self.index.get(&(named.array.clone(), named.whisker)) {
                    self.whiskers[index].rename(named);
                }
            }
            // A new agent knows no state of a topic that is published on a change only.
            let states = self.mapped.iter().flat_map(Mapped::states);
            return self.whiskers.iter().filter_map(Whisker::reported).chain(states).map(Output::Line).collect();
        }
        if whiskers.len() > WHISKERS_MAX {
            let many = whiskers.len();
            return vec![Output::Stop(format!("the robot has {many} whiskers; this program carries {WHISKERS_MAX}"))];
        }
        self.index =
            whiskers.iter().enumerate().map(|(index, one)| ((one.array.clone(), one.whisker), index)).collect();
        if self.index.len() != whiskers.len() {
            return vec![Output::Stop("the agent names a whisker twice".to_owned())];
        }
        if let Some(mut mapping) = self.settings.mapping.clone() {
            if let Err(problem) = mapping.bind(&self.index) {
                return vec![Output::Stop(problem)];
            }
            self.mapped = Some(Mapped::new(mapping, whiskers.len(), now_s));
        }
        let is_passive = |index: usize| self.mapping().is_some_and(|mapping| mapping.setpoint_of(index).is_none());
        let known = whiskers.iter().cloned().enumerate();
        self.whiskers = known.map(|(index, named)| Whisker::new(now_s, named, is_passive(index))).collect();
        vec![Output::Open(whiskers)]
    }

    /// The mapping, once the whiskers are known.
    #[must_use]
    pub fn mapping(&self) -> Option<&Mapping> {
        self.mapped.as_ref().map(|mapped| &*mapped.mapping)
    }

    fn estimate(&mut self, stamp: Time, estimate: Estimate) -> Result<Vec<Output>, String> {
        let index = self.find(&estimate.array, estimate.whisker)?;
        let message = estimate_message(stamp, &estimate);
        self.whiskers[index].estimate = Some(estimate);
        Ok(vec![Output::Estimate(index, message)])
    }

    fn find(&self, array: &str, whisker: u16) -> Result<usize, String> {
        let found = self.index.get(&(array.to_owned(), whisker)).copied();
        found.ok_or_else(|| format!("no whisker {array:.64}/{whisker}: the robot's agent.toml names its whiskers"))
    }

    fn tick(&mut self, now_s: f64, stamp: Time) -> Vec<Output> {
        let mut outputs = self.mapped_tick(now_s);
        for (index, whisker) in self.whiskers.iter_mut().enumerate() {
            outputs.extend(whisker.silence(now_s).map(Output::Line));
            if self.activity != Activity::Active || whisker.is_passive() {
                whisker.release();
            } else if let Some(pressure_mpa) = whisker.setpoint(now_s) {
                let header = Header { stamp, frame_id: whisker.name() };
                let pa = self.settings.pressures.pa(pressure_mpa);
                let mapped = self.mapped.as_ref().and_then(|mapped| mapped.mapping.setpoint_of(index));
                let fluid_pressure = mapped.map_or(pa, |mapped| mapped.number.inverse(pa));
                outputs.push(Output::Setpoint(index, FluidPressure { header, fluid_pressure, variance: 0.0 }));
            }
        }
        if now_s - self.reported_at_s >= REPORT_EVERY_S {
            self.reported_at_s = now_s;
            let header = Header { stamp, frame_id: String::new() };
            let silent = self.mapped.as_ref().map_or_else(Vec::new, |mapped| mapped.silent(now_s));
            let state = (&self.counts, self.activity, silent);
            let status = health::report(&self.settings.robot, now_s, &self.whiskers, state);
            outputs.push(Output::Report(DiagnosticArray { header, status }));
        }
        outputs
    }
}
