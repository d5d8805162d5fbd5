//! The lines of the driver.

use vibrissa_protocol::{BootId, Contact, Contacts, MissedTouch, PlaceKind, TouchTestOutcome, decode_contacts, encode};

use super::chamber::Reading;
use super::{Agent, Output};
use crate::contract::Now;
use crate::driver::words::is_own;
use crate::driver::words::{self, HelloWhisker, Origin, Progress, cut};
use crate::driver::{BadLine, FromDriver, LINE_MAX_BYTES, ToDriver, VERSION};

/// Refused lines that are answered, per second; all are counted.
pub(super) const ERRORS_PER_S: f64 = 20.0;
/// Answers to `hello`, per second: each is a line for each whisker.
pub(super) const GREETINGS_PER_S: f64 = 5.0;

const WHISKERS: &str = "name a whisker of agent.toml; `array` is needed if the robot has several";
const PLACES: &str = "send the place that agent.toml states for the whisker as `place`, or change it there";
const RANGES: &str = "keep the ranges of docs/driver-interface.md";

impl Agent {
    /// Greets a driver, and tells it all it needs.
    pub(super) fn greet(&mut self, now: Now, out: &mut Vec<Output>) {
        let whiskers = self.chambers.iter().map(|chamber| HelloWhisker {
            array: chamber.array.clone(),
            whisker: chamber.number,
            pressure_mpa: chamber.target_mpa,
            pressure_max_mpa: chamber.max_mpa,
        });
        out.push(Output::Tell(ToDriver::Hello { version: VERSION, whiskers: whiskers.collect() }));
        for at in 0..self.chambers.len() {
            self.tell_pressure(at, now, out);
            out.extend(self.chambers[at].estimate.clone().map(Output::Tell));
        }
    }

    /// The driver has gone. Its chambers are reported as before until it is known to be absent.
    pub(super) fn driver_ended(&mut self, now: Now, out: &mut Vec<Output>) {
        self.driver.is_there = false;
        self.chambers.iter_mut().for_each(|chamber| chamber.wait(now, &self.limits));
        while !self.under_way.is_empty() {
            self.end_test(0, TouchTestOutcome::Failed, now, out);
        }
    }

    /// Takes a line; a bad one is answered and counted.
    pub(super) fn line(&mut self, line: Option<&[u8]>, now: Now, out: &mut Vec<Output>) {
        self.counts.lines += 1;
        self.driver.lines += 1;
        let taken = match line {
            Some(line) if is_own(line) => return self.echo(out),
            Some(line) => FromDriver::read(line).and_then(|word| self.word(word, now, out)),
            None => Err(BadLine::new(
                format!("the line is longer than {LINE_MAX_BYTES} bytes"),
                "end each line with a line feed, and send fewer samples in a line",
            )),
        };
        match taken {
            // Noise of a serial line is no sign of life.
            Ok(()) => {
                self.driver.heard = now.at;
                if !std::mem::replace(&mut self.driver.is_there, true) {
                    self.greet(now, out);
                }
            }
            Err(BadLine { problem, remedy }) => {
                self.counts.lines_refused += 1;
                if self.error_rate.takes(now.at) {
                    let line = self.driver.lines;
                    out.push(Output::Tell(ToDriver::Error { line, problem, remedy }));
                }
            }
        }
    }

    /// Takes one of the agent's own lines, which a device sends back. To answer each would never end.
    fn echo(&mut self, out: &mut Vec<Output>) {
        self.counts.lines_echoed += 1;
        self.driver.echoes += 1;
        if self.driver.echoes == 1 {
            let problem = "the device sends the agent's own lines back".to_owned();
            let remedy = "switch the echo of the board, the terminal or the converter off";
            out.push(Output::Tell(ToDriver::Error { line: self.driver.lines, problem, remedy }));
        }
    }

    fn word(&mut self, word: FromDriver, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        match word {
            FromDriver::Hello(hello) => self.hello(&hello, now, out),
            FromDriver::Contact(contact) => self.contact(contact, now, out),
            FromDriver::Strain(strain) => self.strain(&strain, now, out),
            FromDriver::Pressure(pressure) => self.pressure(&pressure, now, out),
            FromDriver::Fault(fault) => {
                let (at, _) = self.place(&fault.origin(), now)?;
                if fault.gauge.is_none() && fault.regulator.is_none() {
                    return Err(BadLine::new(
                        "neither gauge nor regulator is given",
                        "send the condition that changed",
                    ));
                }
                self.chambers[at].fault(fault.regulator, fault.gauge);
                Ok(())
            }
            FromDriver::TestState(state) => self.test_state(&state, now, out),
        }
    }

    fn hello(&mut self, hello: &words::Hello, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        if hello.version != VERSION {
            let problem = format!("version {} of the interface is not known", hello.version);
            return Err(BadLine::new(problem, "send version 1"));
        }
        if !self.greeting_rate.takes(now.at) {
            let problem = format!("more than {GREETINGS_PER_S} hello lines a second");
            return Err(BadLine::new(problem, "send hello once, when the driver starts"));
        }
        self.greet(now, out);
        Ok(())
    }

    /// Index of a line's whisker, and the time of the line.
    pub(super) fn place(&mut self, origin: &Origin, now: Now) -> Result<(usize, u64), BadLine> {
        let array = match (&origin.array, &self.facts.arrays[..]) {
            (Some(array), _) => array.clone(),
            (None, [only]) => only.array.clone(),
            (None, _) => return Err(BadLine::new("`array` is missing", WHISKERS)),
        };
        let number = origin.whisker;
        let Some(&at) = self.places.get(&(array.clone(), number)) else {
            return Err(BadLine::new(format!("the robot has no whisker {array}/{number}"), WHISKERS));
        };
        let t_us = self.driver.times.of(origin.t_us, origin.t_ms, now);
        let t_us = t_us.map_err(|why| BadLine::new(why, "leave t_us and t_ms out, or set the clock"))?;
        Ok((at, t_us))
    }

    fn pressure(&mut self, line: &words::Pressure, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        let (at, _) = self.place(&line.origin(), now)?;
        let range = |name: &str, value: Option<f64>, least: f64, most: f64| match value {
            Some(value) if !(least..=most).contains(&value) => {
                Err(BadLine::new(format!("{name} is {value}, but must be between {least} and {most}"), RANGES))
            }
            Some(_) | None => Ok(()),
        };
        range("pressure_mpa", Some(line.pressure_mpa), 0.0, 1.0)?;
        range("temperature_c", line.temperature_c, -100.0, 300.0)?;
        range("supply_mpa", line.supply_mpa, 0.0, 10.0)?;
        let chamber = &mut self.chambers[at];
        // The receipt of the line counts: a reading that was on its way for long is still the newest one.
        chamber.read(Reading { pressure_mpa: line.pressure_mpa, at: now.at }, &self.limits);
        chamber.state(line.regulator, line.temperature_c, line.supply_mpa);
        out.extend(chamber.pulse(now).map(Output::Tell));
        Ok(())
    }

    fn test_at(&self, test_id: Option<&str>, whisker: Option<usize>) -> Result<Option<usize>, BadLine> {
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

    fn test_state(&mut self, state: &words::TestState, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        let Some(at) = self.test_at(Some(&state.test_id), None)? else { return Ok(()) };
        match state.state {
            Progress::Running => self.run_test(at, now, out),
            Progress::Done => self.end_test(at, TouchTestOutcome::Done, now, out),
            Progress::Failed => self.end_test(at, TouchTestOutcome::Failed, now, out),
        }
        Ok(())
    }

    pub(super) fn contact(&mut self, line: words::Contact, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        let (at, t_us) = self.place(&line.origin(), now)?;
        let test = self.test_at(line.test_id.as_deref(), Some(at))?;
        if test.is_some_and(|test| self.under_way[test].touches_left == 0) {
            return Err(BadLine::new("the touch test has all its touches", "send test_state DONE"));
        }
        let message = match line.touched {
            Some(false) => self.missed_of(line, at, t_us)?,
            Some(true) | None => self.contact_of(line, at, t_us, test.is_some())?,
        };
        // The contract's own check, so that no supervisor refuses the message.
        decode_contacts(&encode(&message), Vec::new()).map_err(|why| BadLine::new(cut(&why.to_string()), RANGES))?;
        if !self.contact_rate.takes(now.at) {
            let problem = format!("more than {} contacts a second", self.limits.contacts_per_s);
            return Err(BadLine::new(problem, "send fewer, or raise contacts.per_s_max in agent.toml"));
        }
        self.counts.contacts += 1;
        if let Some(test) = test {
            self.run_test(test, now, out);
            self.under_way[test].touches_left -= 1;
        }
        self.batch.extend(message.contacts);
        self.missed.extend(message.missed);
        if self.batch.len() + self.missed.len() >= self.limits.contacts_per_message {
            self.flush(now, out);
        } else {
            self.batch_until.get_or_insert(now.at + self.limits.message_after_us);
        }
        Ok(())
    }

    fn contact_of(&self, line: words::Contact, at: usize, t_us: u64, is_test: bool) -> Result<Contacts, BadLine> {
        let chamber = &self.chambers[at];
        let missing =
            |name| BadLine::new(format!("missing field `{name}`"), "compare the line with docs/driver-interface.md");
        let place = match (line.ratio, line.tip, line.distance_mm) {
            (Some(_), ..) => PlaceKind::Ratio,
            (None, true, _) => PlaceKind::Tip,
            (None, false, Some(_)) => PlaceKind::Distance,
            (None, false, None) => PlaceKind::Unknown,
        };
        // A driver that divides by the length has no ratio before the first estimate, nor beyond the length. A touch test has
        // its own places.
        let lacks_length = (chamber.place, place) == (PlaceKind::Ratio, PlaceKind::Distance);
        if place != chamber.place && !lacks_length && !is_test {
            let problem = format!("the place is {place}, but agent.toml states {} for the whisker", chamber.place);
            return Err(BadLine::new(problem, PLACES));
        }
        let pressure_mpa = line.pressure_mpa.or(chamber.present_reading().map(|reading| reading.pressure_mpa));
        let contact = Contact {
            array: chamber.array.clone(),
            whisker: chamber.number,
            t_us,
            ratio: line.ratio,
            ratio_sd: line.ratio_sd,
            distance_mm: line.distance_mm,
            distance_sd_mm: line.distance_sd_mm,
            tip: line.tip,
            deflection_mm: line.deflection_mm.ok_or_else(|| missing("deflection_mm"))?,
            strain: line.strain.ok_or_else(|| missing("strain"))?,
            pressure_mpa: pressure_mpa.ok_or_else(|| {
                BadLine::new(
                    "no pressure of the whisker is known",
                    "send `pressure` before contacts, or pressure_mpa with each",
                )
            })?,
            temperature_c: line.temperature_c.or(chamber.temperature_c).unwrap_or(self.limits.temperature_c),
            test_id: line.test_id,
        };
        Ok(self.alone(vec![contact], vec![]))
    }

    fn missed_of(&self, line: words::Contact, at: usize, t_us: u64) -> Result<Contacts, BadLine> {
        let chamber = &self.chambers[at];
        let distance_mm = line.distance_mm.ok_or_else(|| {
            BadLine::new(
                "a touch that did not come needs distance_mm",
                "send the distance at which it should have come",
            )
        })?;
        let missed = MissedTouch {
            array: chamber.array.clone(),
            whisker: chamber.number,
            t_us,
            distance_mm,
            distance_sd_mm: line.distance_sd_mm,
            test_id: line.test_id,
        };
        Ok(self.alone(vec![], vec![missed]))
    }

    /// A message with one contact, only to check it.
    fn alone(&self, contacts: Vec<Contact>, missed: Vec<MissedTouch>) -> Contacts {
        let boot_id: BootId = self.voice.boot_id().clone();
        Contacts { boot_id, seq: 0, contacts, missed }
    }
}
