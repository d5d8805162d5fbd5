//! The drivers of a robot: which whiskers each serves, whether it is there, and what it is told.
//!
//! Each driver has its own silence, times, rates and counts, so that a faulty one costs only what it alone gives.

use vibrissa_protocol::{Name, SOFTWARE_MAX, Software, SoftwareKind, TouchTestOutcome};

use super::chamber::Chamber;
use super::lines::{ERRORS_PER_S, GREETINGS_PER_S};
use super::times::{Rate, Times};
use super::{Agent, Output};
use crate::config::{DriverConfig, DriverLimits, Limits};
use crate::contract::{Moment, Now};
use crate::driver::told::HelloWhisker;
use crate::driver::words::Hello;
use crate::driver::{ToDriver, VERSION};

/// Longest name or version in a factsheet, in characters.
const FACTS_TEXT_MAX: usize = 64;

/// A text of a driver as a factsheet may have it; `None` if nothing is left.
fn text_of_factsheet(text: &str) -> Option<String> {
    let text: String = text.chars().filter(|one| !one.is_control()).take(FACTS_TEXT_MAX).collect();
    Some(text).filter(|text| !text.is_empty())
}

/// State of a driver.
#[derive(Debug)]
pub(super) struct Driver {
    /// Subject of sentences about it.
    pub(super) label: String,
    /// Indices of its chambers.
    pub(super) serves: Vec<usize>,
    /// The array of all its whiskers, if it is one: its lines may leave it out.
    pub(super) array: Option<Name>,
    pub(super) limits: DriverLimits,
    pub(super) is_there: bool,
    /// It says that the robot moves.
    pub(super) says_driving: bool,
    /// It says that the robot is in a task.
    pub(super) says_task: bool,
    /// Moment of its last line, or of its start.
    pub(super) heard: Moment,
    /// Lines since its start.
    pub(super) lines: u64,
    /// Lines refused since the agent's start, and the newest problem.
    pub(super) refused: u64,
    pub(super) problem: Option<String>,
    pub(super) times: Times,
    /// Lines that are the agent's own, sent back.
    pub(super) echoes: u64,
    pub(super) contact_rate: Rate,
    pub(super) error_rate: Rate,
    pub(super) greeting_rate: Rate,
    /// Somebody configures the board, and has not saved the changes.
    pub(super) is_configured: bool,
    /// Its programs, as its last `hello` named them.
    pub(super) software: Vec<Software>,
}

impl Driver {
    pub(super) fn new(config: &DriverConfig, chambers: &[Chamber], limits: &Limits, now: Now) -> Self {
        let is_served = |chamber: &Chamber| config.whiskers.contains(&(chamber.array.clone(), chamber.number));
        let serves: Vec<usize> = (0..chambers.len()).filter(|&at| is_served(&chambers[at])).collect();
        let first = serves.first().map(|&at| chambers[at].array.clone());
        Self {
            label: config.label.clone(),
            array: first.filter(|array| serves.iter().all(|&at| chambers[at].array == *array)),
            serves,
            limits: config.limits,
            is_there: false,
            says_driving: false,
            says_task: false,
            heard: now.at,
            lines: 0,
            refused: 0,
            problem: None,
            times: Times::default(),
            echoes: 0,
            contact_rate: Rate::new(limits.contacts_per_s, now.at),
            error_rate: Rate::new(ERRORS_PER_S, now.at),
            greeting_rate: Rate::new(GREETINGS_PER_S, now.at),
            is_configured: false,
            software: Vec::new(),
        }
    }

    /// It can be heard from now on.
    fn start(&mut self, now: Now) {
        (self.is_there, self.is_configured, self.heard) = (true, false, now.at);
        (self.says_driving, self.says_task) = (false, false);
        (self.lines, self.echoes, self.problem, self.times) = (0, 0, None, Times::default());
    }

    /// Moment at which it counts as silent.
    pub(super) fn silent_at(&self) -> Option<Moment> {
        self.is_there.then(|| self.heard + self.limits.silent_us)
    }

    /// A sentence about its silence for a person.
    fn silence(&self) -> String {
        match &self.problem {
            Some(problem) => {
                format!("{} says nothing that is a line of the interface: the last one: {problem}", self.label)
            }
            None => format!("{} is silent", self.label),
        }
    }
}

impl Agent {
    /// A driver can be heard, from now on or anew.
    pub(super) fn driver_started(&mut self, from: usize, now: Now, out: &mut Vec<Output>) {
        self.drivers[from].start(now);
        self.expect_readings(from, now);
        self.greet(from, now, out);
        self.chambers.iter_mut().for_each(|chamber| chamber.begin(from));
    }

    /// A driver that is there from now on has yet to read the pressures of its chambers.
    pub(super) fn expect_readings(&mut self, from: usize, now: Now) {
        for at in self.drivers[from].serves.clone() {
            if self.reader(at) == Some(from) {
                self.chambers[at].expect_reading(now);
            }
        }
    }

    /// The driver that reads the pressure of a whisker; before the first reading, the first of its drivers.
    fn reader(&self, at: usize) -> Option<usize> {
        self.chambers[at].holder.or_else(|| self.drivers.iter().position(|one| one.serves.contains(&at)))
    }

    /// The driver whose valves the agent moves, if it is there.
    pub(super) fn moves_valves(&self, at: usize) -> Option<usize> {
        self.reader(at).filter(|&reader| self.drivers[reader].is_there && self.chambers[at].blind_at().is_some())
    }

    /// Makes the steps of the agent's regulators for which no reading comes.
    pub(super) fn miss_readings(&mut self, now: Now, out: &mut Vec<Output>) {
        for at in 0..self.chambers.len() {
            let Some(from) = self.moves_valves(at) else { continue };
            let chamber = &mut self.chambers[at];
            if chamber.blind_at().is_some_and(|due| due <= now.at) {
                out.extend(chamber.pulse_blindly(now).map(|line| Output::Tell(from, line)));
            }
        }
    }

    /// Moment of the next such step.
    pub(super) fn blind_at(&self) -> Option<Moment> {
        let moved = (0..self.chambers.len()).filter(|&at| self.moves_valves(at).is_some());
        moved.filter_map(|at| self.chambers[at].blind_at()).min()
    }

    /// Takes the versions that a driver tells, and tells them to supervisors and people if they are new.
    pub(super) fn learn_software(&mut self, from: usize, hello: &Hello, now: Now, out: &mut Vec<Output>) {
        let driver = &mut self.drivers[from];
        let name = text_of_factsheet(&hello.name).unwrap_or_else(|| driver.label.clone());
        let versions = [
            (SoftwareKind::Driver, hello.software_version.as_deref()),
            (SoftwareKind::Firmware, hello.firmware_version.as_deref()),
        ];
        let known = versions.into_iter().filter_map(|(kind, version)| Some((kind, text_of_factsheet(version?)?)));
        driver.software = known.map(|(kind, version)| Software { kind, name: name.clone(), version }).collect();
        let agent = self.facts.software.iter().filter(|one| one.kind == SoftwareKind::Agent);
        let drivers = self.drivers.iter().flat_map(|driver| &driver.software);
        let software: Vec<Software> = agent.chain(drivers).take(SOFTWARE_MAX).cloned().collect();
        if software != self.facts.software {
            self.facts.software = software;
            self.tell_facts(now, out);
        }
    }

    /// Greets a driver, and tells it all it needs.
    pub(super) fn greet(&mut self, from: usize, now: Now, out: &mut Vec<Output>) {
        let serves = self.drivers[from].serves.clone();
        let whiskers = serves.iter().map(|&at| &self.chambers[at]).map(|chamber| HelloWhisker {
            array: chamber.array.clone(),
            whisker: chamber.number,
            pressure_mpa: chamber.as_read(chamber.target_mpa),
            pressure_max_mpa: chamber.as_read(chamber.max_mpa),
        });
        out.push(Output::Tell(from, ToDriver::Hello { version: VERSION, whiskers: whiskers.collect() }));
        for at in serves {
            if !self.others(at, from).any(|other| other.is_there) {
                self.chambers[at].sent_at = now.at;
            }
            out.push(Output::Tell(from, self.chambers[at].set_pressure()));
            if self.facts.applies_gain && self.drivers[from].is_there {
                out.push(Output::Tell(from, self.chambers[at].reading_gain()));
            }
            out.extend(self.chambers[at].estimate.clone().map(|line| Output::Tell(from, line)));
        }
    }

    /// A driver has gone. The chambers whose pressures it reads are reported as before until it is known to be absent.
    pub(super) fn driver_ended(&mut self, from: usize, now: Now, out: &mut Vec<Output>) {
        self.drivers[from].is_there = false;
        for at in self.drivers[from].serves.clone() {
            let chamber = &mut self.chambers[at];
            if chamber.holder.is_none_or(|holder| holder == from) {
                chamber.wait(now);
            }
            chamber.lose(from);
        }
        while let Some(test) = self.under_way.iter().position(|test| match test.driver {
            Some(driver) => driver == from,
            None => !self.drivers.iter().any(|one| one.is_there && one.serves.contains(&test.whisker)),
        }) {
            self.end_test(test, TouchTestOutcome::Failed, now, out);
        }
    }

    /// Gives up drivers that are silent. The others go on.
    pub(super) fn miss_drivers(&mut self, now: Now, out: &mut Vec<Output>) {
        for from in 0..self.drivers.len() {
            if self.drivers[from].silent_at().is_none_or(|at| now.at < at) {
                continue;
            }
            self.counts.driver_silences += 1;
            self.driver_ended(from, now, out);
            let held = |chamber: &&mut Chamber| chamber.holder == Some(from);
            self.chambers.iter_mut().filter(held).for_each(Chamber::forget);
            out.push(Output::RestartDriver(from, self.drivers[from].silence()));
        }
    }

    fn others(&self, at: usize, from: usize) -> impl Iterator<Item = &Driver> {
        let serving = move |(index, driver): &(usize, &Driver)| *index != from && driver.serves.contains(&at);
        self.drivers.iter().enumerate().filter(serving).map(|(_, driver)| driver)
    }

    /// Whether a whisker has more than one driver, so that values of several may be joined.
    pub(super) fn is_shared(&self, at: usize) -> bool {
        self.drivers.iter().filter(|driver| driver.serves.contains(&at)).count() > 1
    }

    /// Whether a driver of a whisker says that the robot moves; `None` if none does.
    pub(super) fn drives(&self, at: usize) -> Option<bool> {
        self.drivers.iter().any(|one| one.is_there && one.says_driving && one.serves.contains(&at)).then_some(true)
    }

    /// Whether a driver says that the robot is in a task. It counts for all whiskers of the robot.
    pub(super) fn is_in_task(&self) -> bool {
        self.drivers.iter().any(|one| one.is_there && one.says_task)
    }

    /// Whether any driver of a whisker is there.
    pub(super) fn is_served(&self, at: usize) -> bool {
        self.drivers.iter().any(|driver| driver.is_there && driver.serves.contains(&at))
    }

    /// Whether the driver that reads the pressure of a whisker is there; before the first reading, any of its drivers.
    pub(super) fn is_held(&self, at: usize) -> bool {
        self.chambers[at].holder.map_or_else(|| self.is_served(at), |holder| self.drivers[holder].is_there)
    }

    /// Tells each driver of a whisker that is there.
    pub(super) fn tell(&self, at: usize, line: &ToDriver, out: &mut Vec<Output>) {
        let there = self.drivers.iter().enumerate().filter(|(_, one)| one.is_there && one.serves.contains(&at));
        out.extend(there.map(|(index, _)| Output::Tell(index, line.clone())));
    }
}
