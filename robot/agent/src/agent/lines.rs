//! The lines of the drivers.

use vibrissa_protocol::{Gauge, TouchTestOutcome};

use super::chamber::Reading;
use super::doubt::gauge_remedy;
use super::{Agent, Output};
use crate::contract::Now;
use crate::driver::told::is_own;
use crate::driver::words::{self, Changes, Origin, Progress, Source, cut};
use crate::driver::{BadLine, FromDriver, LINE_MAX_BYTES, ToDriver, VERSION};

/// Refused lines that are answered, per second; all are counted.
pub(super) const ERRORS_PER_S: f64 = 20.0;
/// Answers to `hello`, per second: each is a line for each whisker.
pub(super) const GREETINGS_PER_S: f64 = 5.0;

/// Largest reading below zero that is the zero of a sensor, in MPa: 5 % of the range of a chamber. Cheap sensors are off by
/// up to 2.5 % of their own range.
const ZERO_MPA: f64 = 0.01;
/// Noise of a sensor whose zero is known, in MPa.
const NOISE_MPA: f64 = 0.000_1;

const WHISKERS: &str = "name a whisker of agent.toml; `array` is needed if the robot has several";
const CLOCK: &str = "leave t_us and t_ms out, or send t_us in microseconds since 1970, or t_ms since the board's start";
pub(super) const RANGES: &str = "keep the ranges of docs/driver-interface.md";

impl Agent {
    /// Takes a line; a bad one is answered and counted.
    pub(super) fn line(&mut self, from: usize, line: Option<&[u8]>, now: Now, out: &mut Vec<Output>) {
        self.counts.lines += 1;
        self.drivers[from].lines += 1;
        let taken = match line {
            Some(line) if is_own(line) => return self.echo(from, out),
            Some(line) => FromDriver::read(line).and_then(|word| self.word(from, word, now, out)),
            None => Err(BadLine::noise(
                format!("the line is longer than {LINE_MAX_BYTES} bytes"),
                "end each line with a line feed, and send fewer samples in a line",
            )),
        };
        // Noise of a serial line is no sign of life. A driver whose values are refused is not silent.
        if taken.as_ref().err().is_none_or(|bad| bad.is_spoken) {
            self.drivers[from].heard = now.at;
            if !std::mem::replace(&mut self.drivers[from].is_there, true) {
                self.expect_readings(from, now);
                self.greet(from, now, out);
            }
            self.drivers[from].problem = None;
        }
        if let Err(bad) = taken {
            self.refuse(from, bad, now, out);
        }
    }

    /// Counts a refused line, or values of earlier lines that cannot be used, and tells the driver.
    pub(super) fn refuse(&mut self, from: usize, bad: BadLine, now: Now, out: &mut Vec<Output>) {
        let BadLine { problem, remedy, is_spoken } = bad;
        self.counts.lines_refused += 1;
        let driver = &mut self.drivers[from];
        driver.refused += 1;
        if !is_spoken {
            driver.problem = Some(problem.clone());
        }
        if driver.error_rate.takes(now.at) {
            out.push(Output::Tell(from, ToDriver::Error { line: driver.lines, problem, remedy }));
        }
    }

    /// Takes one of the agent's own lines, which a device sends back. To answer each would never end.
    fn echo(&mut self, from: usize, out: &mut Vec<Output>) {
        self.counts.lines_echoed += 1;
        let driver = &mut self.drivers[from];
        driver.echoes += 1;
        if driver.echoes == 1 {
            let problem = "the device sends the agent's own lines back".to_owned();
            let remedy = "switch the echo of the board, the terminal or the converter off";
            out.push(Output::Tell(from, ToDriver::Error { line: driver.lines, problem, remedy }));
        }
    }

    fn word(&mut self, from: usize, word: FromDriver, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        match word {
            FromDriver::Hello(hello) => self.hello(from, &hello, now, out),
            FromDriver::Contact(contact) => self.contact(from, contact, now, out),
            FromDriver::Strain(strain) => self.strain(from, &strain, now, out),
            FromDriver::Motion(motion) => self.motion(from, &motion, now, out),
            FromDriver::Pressure(pressure) => self.pressure(from, &pressure, now, out),
            FromDriver::Fault(fault) => {
                let (at, _) = self.place(from, &fault.origin(), now)?;
                if fault.gauge.is_none() && fault.regulator.is_none() {
                    return Err(BadLine::new(
                        "neither gauge nor regulator is given",
                        "send the condition that changed",
                    ));
                }
                let before = self.chambers[at].condition(now).1;
                self.chambers[at].fault(from, fault.regulator, fault.gauge);
                self.warn_of_driver(at, before, now, out);
                Ok(())
            }
            FromDriver::TestState(state) => self.test_state(from, &state, now, out),
            FromDriver::Driving(line) => {
                self.drivers[from].says_driving = line.driving;
                Ok(())
            }
            FromDriver::Task(line) => {
                self.drivers[from].says_task = line.task;
                Ok(())
            }
            FromDriver::Locate(line) => {
                let place = self.locate(from, line, now);
                out.push(Output::Tell(from, place));
                Ok(())
            }
            FromDriver::Configured(line) => {
                self.configured(from, line.changes, out);
                Ok(())
            }
            FromDriver::Configuration(line) => {
                self.warn_of_configuration(from, line.record, out);
                Ok(())
            }
            FromDriver::Error(problem) => self.refused_by_driver(from, problem, now, out),
        }
    }

    /// A driver has refused a line. A setpoint whose order it refuses has failed; the log names each refused pressure once,
    /// because orders are repeated.
    fn refused_by_driver(
        &mut self,
        from: usize,
        refusal: words::Problem,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let words::Problem { problem, array, whisker } = refusal;
        let Some(whisker) = whisker else {
            out.push(Output::Warn(format!("{} has refused a line: {}", self.drivers[from].label, cut(&problem))));
            return Ok(());
        };
        let (at, _) = self.place(from, &Origin { array, whisker, t_us: None, t_ms: None, span_us: 0 }, now)?;
        let (label, chamber) = (&self.drivers[from].label, &mut self.chambers[at]);
        if chamber.refuse(now) {
            let (array, target_mpa) = (&chamber.array, chamber.target_mpa);
            out.push(Output::Warn(format!(
                "whisker {array}/{whisker}: {label} refuses the order of {target_mpa} MPa: {}",
                cut(&problem)
            )));
        }
        Ok(())
    }

    fn hello(&mut self, from: usize, hello: &words::Hello, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        if hello.version != VERSION {
            let problem = format!("version {} of the interface is not known", hello.version);
            return Err(BadLine::new(problem, "send version 1"));
        }
        if !self.drivers[from].greeting_rate.takes(now.at) {
            let problem = format!("more than {GREETINGS_PER_S} hello lines a second");
            return Err(BadLine::new(problem, "send hello once, when the driver starts"));
        }
        self.chambers.iter_mut().for_each(|chamber| chamber.begin(from));
        self.greet(from, now, out);
        self.learn_software(from, hello, now, out);
        self.warn_of_configuration(from, hello.configuration, out);
        Ok(())
    }

    /// Names a gauge that its driver reports as bad from now on: no contact of it is used.
    fn warn_of_driver(&self, at: usize, before: Gauge, now: Now, out: &mut Vec<Output>) {
        let chamber = &self.chambers[at];
        let gauge = chamber.condition(now).1;
        if let Some(remedy) = gauge_remedy(gauge).filter(|_| gauge != before) {
            let (array, number) = (&chamber.array, chamber.number);
            out.push(Output::Warn(format!("whisker {array}/{number}: its driver reports the gauge {gauge}: {remedy}")));
        }
    }

    /// Somebody configures a board while the agent hears it.
    fn configured(&mut self, from: usize, changes: Changes, out: &mut Vec<Output>) {
        let driver = &mut self.drivers[from];
        let before = std::mem::replace(&mut driver.is_configured, changes == Changes::Unsaved);
        if driver.is_configured && !before {
            out.push(Output::Warn(format!(
                "{} is being configured: its valves are closed, and it sends no readings, until the changes are saved \
                 or discarded",
                driver.label
            )));
        }
    }

    /// A board whose record is broken opens no valve.
    fn warn_of_configuration(&self, from: usize, source: Option<Source>, out: &mut Vec<Output>) {
        if source == Some(Source::Broken) {
            out.push(Output::Warn(format!(
                "{} has a damaged configuration, or one of another program, and opens no valve: configure it \
                 (robot/boards/README.md)",
                self.drivers[from].label
            )));
        }
    }

    /// Index of a line's whisker, and the time of the line.
    pub(super) fn place(&mut self, from: usize, origin: &Origin, now: Now) -> Result<(usize, u64), BadLine> {
        let driver = &mut self.drivers[from];
        let array = match (&origin.array, &driver.array) {
            (Some(array), _) => array.clone(),
            (None, Some(only)) => only.clone(),
            (None, None) => return Err(BadLine::new("`array` is missing", WHISKERS)),
        };
        let number = origin.whisker;
        let Some(&at) = self.places.get(&(array.clone(), number)) else {
            return Err(BadLine::new(format!("the robot has no whisker {array}/{number}"), WHISKERS));
        };
        if !driver.serves.contains(&at) {
            let problem = format!("{} does not serve whisker {array}/{number}", driver.label);
            return Err(BadLine::new(problem, "name the whisker in the `whiskers` of the driver in agent.toml"));
        }
        let t_us = driver.times.of(origin, now).map_err(|why| BadLine::new(why, CLOCK))?;
        Ok((at, t_us))
    }

    fn pressure(
        &mut self,
        from: usize,
        line: &words::Pressure,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let (at, _) = self.place(from, &line.origin(), now)?;
        let range = |name: &str, value: Option<f64>, least: f64, most: f64| match value {
            Some(value) if !(least..=most).contains(&value) => {
                Err(BadLine::new(format!("{name} is {value}, but must be between {least} and {most}"), RANGES))
            }
            Some(_) | None => Ok(()),
        };
        let holder = self.chambers[at].holder.filter(|&holder| holder != from);
        if let Some(other) = holder.map(|holder| &self.drivers[holder]).filter(|other| other.is_there)
            && self.chambers[at].present_reading().is_some_and(|reading| now.at < reading.at + other.limits.silent_us)
        {
            let problem = format!("{} reads the pressure of this whisker already", other.label);
            return Err(BadLine::new(problem, "let one driver read the pressure of a whisker"));
        }
        let pressure_mpa = self.above_zero(at, line.pressure_mpa, out);
        let supply_mpa = line.supply_mpa.map(|mpa| if (-ZERO_MPA..0.0).contains(&mpa) { 0.0 } else { mpa });
        let ranges = range("pressure_mpa", Some(pressure_mpa), 0.0, 1.0)
            .and_then(|()| range("temperature_c", line.temperature_c, -100.0, 300.0))
            .and_then(|()| range("supply_mpa", supply_mpa, 0.0, 10.0));
        if let Err(bad) = ranges {
            // The regulator must know that the sensor gives nothing: it keeps no air at an unknown pressure.
            if self.moves_valves(at) == Some(from) {
                out.extend(self.chambers[at].pulse_blindly(now).map(|line| Output::Tell(from, line)));
            }
            return Err(bad);
        }
        let limits = self.drivers[from].limits;
        let chamber = &mut self.chambers[at];
        if chamber.holder != Some(from) {
            chamber.hand_over(from, limits);
        }
        // The receipt of the line counts: a reading that was on its way for long is still the newest one.
        chamber.read(Reading { pressure_mpa, at: now.at });
        chamber.state(line.regulator, line.temperature_c, supply_mpa);
        out.extend(chamber.pulse(now, pressure_mpa).map(|line| Output::Tell(from, line)));
        Ok(())
    }

    /// The pressure of a reading: without the zero of its sensor, and 0 a little below zero.
    pub(super) fn above_zero(&mut self, at: usize, mpa: f64, out: &mut Vec<Output>) -> f64 {
        let chamber = &mut self.chambers[at];
        let pressure_mpa = mpa - chamber.zero_mpa;
        if !(-ZERO_MPA..0.0).contains(&pressure_mpa) {
            return pressure_mpa;
        }
        if pressure_mpa < -NOISE_MPA && !std::mem::replace(&mut chamber.told_below_zero, true) {
            out.push(Output::Warn(format!(
                "whisker {}/{}: the pressure reads {mpa} MPa, and counts as 0: measure the zero of its sensor \
                 (vibrissa-robot calibrate)",
                chamber.array, chamber.number
            )));
        }
        0.0
    }

    pub(super) fn test_at(&self, test_id: Option<&str>, whisker: Option<usize>) -> Result<Option<usize>, BadLine> {
        let Some(test_id) = test_id else { return Ok(None) };
        let at = self
            .under_way
            .iter()
            .position(|one| one.test_id == test_id && whisker.is_none_or(|whisker| whisker == one.whisker));
        at.map(Some).ok_or_else(|| {
            let problem = format!("no touch test {:?} of this whisker is under way", cut(test_id));
            BadLine::new(problem, "send the test_id of the last `test`, and only until its test_state DONE")
        })
    }

    fn test_state(
        &mut self,
        from: usize,
        state: &words::TestState,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let Some(at) = self.test_at(Some(&state.test_id), None)? else { return Ok(()) };
        self.under_way[at].driver = Some(from);
        match state.state {
            Progress::Running => self.run_test(at, now, out),
            Progress::Done => self.test_done(at, now, out),
            Progress::Failed => self.end_test(at, TouchTestOutcome::Failed, now, out),
        }
        Ok(())
    }
}
