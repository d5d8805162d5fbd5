//! The bridge between the agent and ROS, without clock and network: `step(now, input)` returns what to send.

use std::collections::BTreeMap;

use ros2_client::builtin_interfaces::Time;

use crate::health::{self, Counts};
use crate::lines::{contact_line, estimate_message, goal_of, span_us, states_of, strain_line};
use crate::messages::{self, Contact, DiagnosticArray, Fault, Float64, FluidPressure, Header, Strain, TouchTestGoal};
use crate::stamps::{Stamp, judge};
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
    /// Publishes the setpoint of a whisker, by index.
    Setpoint(usize, FluidPressure),
    /// Publishes the factor on the readings of a whisker, by index.
    ReadingGain(usize, Float64),
    /// Publishes the estimate of a whisker, by index.
    Estimate(usize, messages::Estimate),
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
}

/// The state of the bridge.
#[derive(Debug)]
pub struct Bridge {
    settings: Settings,
    whiskers: Vec<Whisker>,
    index: BTreeMap<(String, u16), usize>,
    counts: Counts,
    reported_at_s: f64,
}

impl Bridge {
    /// A bridge that knows no whiskers yet.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
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
                Ok(vec![Output::Line(ToAgent::Hello { version: VERSION, name: "vibrissa-ros2".to_owned() })])
            }
            Input::Line(line) => self.line(now_s, stamp, line),
            Input::Contact(contact) => self.contact(stamp, contact),
            Input::Pressure(index, reading) => self.pressure(now_s, stamp, index, reading),
            Input::Strain(index, samples) => self.strain(stamp, index, samples),
            Input::Fault(fault) => self.fault(fault),
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

    /// The time of a message for the agent; `None` if the time of receipt counts.
    fn time(&mut self, now: Time, header: &Header, extra_us: i64) -> Option<u64> {
        match judge(header.stamp, now, extra_us) {
            Stamp::Good(t_us) => return Some(t_us),
            Stamp::Unset => self.counts.unstamped += 1,
            Stamp::Implausible => self.counts.misstamped += 1,
        }
        None
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
            let reported = || self.whiskers.iter().filter_map(Whisker::reported).map(Output::Line).collect();
            return if is_same { reported() } else { vec![stop()] };
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
        self.whiskers = whiskers.iter().cloned().map(|named| Whisker::new(now_s, named)).collect();
        vec![Output::Open(whiskers)]
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

    fn contact(&mut self, now: Time, contact: Result<Contact, String>) -> Result<Vec<Output>, String> {
        let contact = contact.map_err(|problem| format!("an unreadable contact: {problem}"))?;
        Ok(vec![self.contact_of(now, 0, contact)?])
    }

    fn contact_of(&mut self, now: Time, extra_us: i64, contact: Contact) -> Result<Output, String> {
        self.find(&contact.array, contact.whisker)?;
        let t_us = self.time(now, &contact.header, extra_us);
        let line = contact_line(contact, t_us)?;
        self.counts.contacts += 1;
        Ok(Output::Line(ToAgent::Contact(line)))
    }

    fn pressure(
        &mut self,
        now_s: f64,
        now: Time,
        index: usize,
        reading: Result<FluidPressure, String>,
    ) -> Result<Vec<Output>, String> {
        let reading = reading.map_err(|problem| format!("an unreadable pressure: {problem}"))?;
        let t_us = self.time(now, &reading.header, 0);
        let whisker = self.whiskers.get_mut(index).ok_or("a pressure of an unknown whisker")?;
        let pressure_mpa = self.settings.pressures.gauge_mpa(reading.fluid_pressure);
        let pressure_mpa = pressure_mpa.map_err(|problem| format!("{}: {problem}", whisker.name()))?;
        self.counts.pressures += 1;
        Ok(whisker.read(now_s, t_us, pressure_mpa).map(Output::Line).into_iter().collect())
    }

    fn strain(&mut self, now: Time, index: usize, samples: Result<Strain, String>) -> Result<Vec<Output>, String> {
        let samples = samples.map_err(|problem| format!("an unreadable message of strain: {problem}"))?;
        let whisker = self.whiskers.get(index).ok_or("strain of an unknown whisker")?.named().clone();
        let name = format!("{}/{}", whisker.array, whisker.whisker);
        let span_us = i64::from(span_us(&name, &samples)?);
        let t_us = self.time(now, &samples.header, span_us);
        // The last sample has been taken now.
        let begun_us = u64::try_from(now.to_nanos() / 1000 - span_us).unwrap_or_default();
        let line = strain_line(&whisker, samples, t_us.unwrap_or(begun_us))?;
        self.counts.strains += 1;
        Ok(vec![Output::Line(ToAgent::Strain(line))])
    }

    fn fault(&mut self, fault: Result<Fault, String>) -> Result<Vec<Output>, String> {
        let fault = fault.map_err(|problem| format!("an unreadable fault: {problem}"))?;
        let index = self.find(&fault.array, fault.whisker)?;
        let states = states_of(&fault)?;
        Ok(vec![Output::Line(self.whiskers[index].report(states))])
    }

    fn test(&mut self, now: Time, test_id: &str, progress: Progress) -> Vec<Output> {
        let state = |state: &'static str| Output::Line(ToAgent::TestState { test_id: test_id.to_owned(), state });
        match progress {
            Progress::Running => vec![state("RUNNING")],
            Progress::Failed(problem) => {
                let problem = format!("the touch test {test_id:.64} has failed: {problem}");
                vec![self.refuse(problem), state("FAILED")]
            }
            Progress::Done { contacts, took_s } => {
                // A contact of a long test may be as old as the test.
                let extra_us = (took_s * 1e6) as i64;
                let mut outputs = Vec::new();
                for contact in contacts {
                    let contact = Contact { test_id: test_id.to_owned(), ..contact };
                    let output = self.contact_of(now, extra_us, contact);
                    outputs.push(output.unwrap_or_else(|problem| self.refuse(problem)));
                }
                outputs.push(state("DONE"));
                outputs
            }
        }
    }

    fn tick(&mut self, now_s: f64, stamp: Time) -> Vec<Output> {
        let mut outputs = Vec::new();
        for (index, whisker) in self.whiskers.iter_mut().enumerate() {
            outputs.extend(whisker.silence(now_s).map(Output::Line));
            if let Some(pressure_mpa) = whisker.setpoint(now_s) {
                let header = Header { stamp, frame_id: whisker.name() };
                let fluid_pressure = self.settings.pressures.pa(pressure_mpa);
                outputs.push(Output::Setpoint(index, FluidPressure { header, fluid_pressure, variance: 0.0 }));
            }
        }
        if now_s - self.reported_at_s >= REPORT_EVERY_S {
            self.reported_at_s = now_s;
            let header = Header { stamp, frame_id: String::new() };
            let status = health::report(&self.settings.robot, now_s, &self.whiskers, &self.counts);
            outputs.push(Output::Report(DiagnosticArray { header, status }));
        }
        outputs
    }
}
