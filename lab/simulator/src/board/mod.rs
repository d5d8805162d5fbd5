//! A simulated board: gauges, valves and pressure sensors of one robot behind the driver interface.
//!
//! It speaks the lines of docs/driver-interface.md, as the firmware of a real board does, and knows nothing of MQTT. It keeps
//! a log of its own, with which tests compare what the supervisor has recorded. [`Board`] is pure: its caller passes the time
//! and the lines. [`run`] drives it.

mod gauge;
mod link;
mod plan;
mod valves;

pub use link::run;
pub use plan::BoardPlan;

use std::collections::{BTreeMap, VecDeque};

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use serde_json::{Value, json};
use vibrissa_core::mechanics::ModelError;
use vibrissa_protocol::{Contact, Name, TouchTestKind};

use gauge::Gauge;
use valves::{Chamber, Opening, Pulse, READ_EVERY_US};

use crate::places::Places;
use crate::plant::Reading;
use crate::random::{Purpose, stream};
use crate::regulator::{SUPPLY_MPA, TICK_US};
use crate::{RobotConfig, Whisker};

/// Time between two `pressure` lines of a whisker, in microseconds.
const PRESSURE_EVERY_US: u64 = 100_000;

/// Something that the board does.
#[derive(Debug, Clone, PartialEq)]
pub enum Doing {
    /// Send a line to the agent.
    Say(Value),
    /// Write a line to the board's log.
    Log(Value),
}

/// A touch test that the board is doing.
#[derive(Debug)]
struct Test {
    line: TestLine,
    at: usize,
    touches: u16,
}

#[derive(Debug, Clone, Deserialize)]
struct TestLine {
    test_id: String,
    array: Name,
    whisker: u16,
    kind: TouchTestKind,
    distances_mm: Vec<f64>,
    deflections_mm: Vec<f64>,
    contacts: u16,
}

/// The lines that the board obeys.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Line {
    SetPressure {
        array: Name,
        whisker: u16,
        pressure_mpa: f64,
        slew_mpa_per_s: f64,
    },
    Valve {
        array: Name,
        whisker: u16,
        open: Opening,
        for_ms: f64,
    },
    Test(TestLine),
    Estimate {
        array: Name,
        whisker: u16,
        length_mm: f64,
    },
    Error {
        problem: String,
    },
    /// A line of the control channel: the whisker loses its tip.
    Cut {
        array: Option<Name>,
        whisker: u16,
        length_mm: f64,
    },
    #[serde(other)]
    Other,
}

/// One robot's board.
#[derive(Debug)]
pub struct Board {
    config: RobotConfig,
    whiskers: Vec<Whisker>,
    places: BTreeMap<(Name, u16), usize>,
    /// Time of the next contact of each whisker.
    touches: Vec<(u64, ChaCha8Rng)>,
    tests: VecDeque<Test>,
    /// Gauges that are sampled all the time; none if the board sends contacts.
    gauges: Vec<Gauge>,
    /// Chambers whose valves the agent opens; none if the board regulates.
    chambers: Vec<Chamber>,
    tick_at_us: u64,
    pressure_at_us: u64,
    heard_us: u64,
    watchdog_us: u64,
    is_vented: bool,
    supply_mpa: f64,
    is_supply_closed: bool,
}

impl Board {
    /// A board that starts now. It vents all chambers after `watchdog_us` without a line from the agent.
    ///
    /// # Errors
    /// A whisker's calibration is invalid.
    pub fn new(config: RobotConfig, seed: u64, watchdog_us: u64, now_us: u64) -> Result<Self, ModelError> {
        let mut whiskers = Vec::new();
        let mut touches = Vec::new();
        for (array, whisker) in config.robot.whiskers() {
            whiskers.push(Whisker::new(&config, array, whisker, seed)?);
            let (robot, array) = (config.robot.robot.as_str(), array.array.as_str());
            // Each start has contacts at other times.
            touches.push((now_us, stream(seed ^ now_us, robot, array, whisker.whisker, Purpose::Timing)));
        }
        let places = whiskers.iter().enumerate().map(|(at, w)| ((w.array().clone(), w.number()), at)).collect();
        let mut board = Self {
            config,
            whiskers,
            places,
            touches,
            tests: VecDeque::new(),
            gauges: Vec::new(),
            chambers: Vec::new(),
            tick_at_us: now_us + TICK_US,
            pressure_at_us: now_us,
            heard_us: now_us,
            watchdog_us,
            is_vented: false,
            supply_mpa: SUPPLY_MPA,
            is_supply_closed: false,
        };
        (0..board.touches.len()).for_each(|at| board.plan_touch(at, now_us));
        Ok(board)
    }

    /// Sends samples of the gauges, of which the agent makes contacts.
    #[must_use]
    pub fn sampling(mut self, seed: u64, now_us: u64) -> Self {
        let robot = self.config.robot.robot.as_str();
        let gauge = |one: &Whisker| {
            Gauge::new(stream(seed, robot, one.array().as_str(), one.number(), Purpose::Samples), now_us)
        };
        self.gauges = self.whiskers.iter().map(gauge).collect();
        self
    }

    /// Has only valves, which the agent opens. The first chamber leaks.
    #[must_use]
    pub fn with_valves(mut self, seed: u64, supply_mpa: f64, leak_mpa_per_s: f64, now_us: u64) -> Self {
        self.supply_mpa = supply_mpa;
        let robot = self.config.robot.robot.as_str();
        let chamber = |(at, one): (usize, &Whisker)| {
            let noise = stream(seed ^ now_us, robot, one.array().as_str(), one.number(), Purpose::Regulator);
            let leak_mpa_per_s = if at == 0 { leak_mpa_per_s } else { 0.0 };
            Chamber::new(one.regulator.pressure_mpa(), supply_mpa, leak_mpa_per_s, noise, now_us)
        };
        self.chambers = self.whiskers.iter().enumerate().map(chamber).collect();
        self
    }

    /// Is touched at this contact ratio only.
    #[must_use]
    pub fn touched_at(mut self, ratio: f64) -> Self {
        self.whiskers.iter_mut().for_each(|whisker| whisker.plant.touch_at_place(Some(ratio)));
        self
    }

    /// Closes the air supply of all chambers, or opens it again.
    pub fn turn_supply(&mut self, now_us: u64) -> Vec<Doing> {
        self.is_supply_closed = !self.is_supply_closed;
        let supply_mpa = self.present_supply_mpa();
        self.chambers.iter_mut().for_each(|chamber| chamber.set_supply(supply_mpa));
        vec![Doing::Log(json!({"log": "supply", "supply_mpa": supply_mpa, "t_us": now_us}))]
    }

    fn present_supply_mpa(&self) -> f64 {
        if self.is_supply_closed { 0.0 } else { self.supply_mpa }
    }

    /// The first line.
    #[must_use]
    pub fn hello(&self) -> Value {
        json!({"type": "hello", "version": vibrissa_robot::driver::VERSION, "name": "simulated board"})
    }

    fn plan_touch(&mut self, at: usize, from_us: u64) {
        let interval_us = 1e6 / self.config.behaviour.contacts_per_second;
        let (next_us, stream) = &mut self.touches[at];
        *next_us = from_us + ((0.5 + stream.random::<f64>()) * interval_us) as u64 + 1;
    }

    /// Takes a line of the agent, or of the control channel.
    pub fn line(&mut self, line: &[u8], now_us: u64) -> Vec<Doing> {
        self.heard_us = now_us;
        if std::mem::take(&mut self.is_vented) {
            // The valves obey the agent again.
            for chamber in &mut self.chambers {
                chamber.obey(Opening::Close, 0.0, now_us);
            }
        }
        match serde_json::from_slice(line) {
            Ok(Line::SetPressure { array, whisker, pressure_mpa, slew_mpa_per_s }) => {
                let Some(&at) = self.places.get(&(array.clone(), whisker)) else { return Vec::new() };
                let regulator = &mut self.whiskers[at].regulator;
                // A repeated line changes nothing: the chamber is settled already.
                if regulator.target_mpa() == pressure_mpa {
                    return Vec::new();
                }
                regulator.set(pressure_mpa, slew_mpa_per_s);
                vec![Doing::Log(json!({"log": "set_pressure", "array": array, "whisker": whisker, "t_us": now_us,
                                       "pressure_mpa": pressure_mpa}))]
            }
            Ok(Line::Valve { array, whisker, open, for_ms }) => self.valve(&array, whisker, open, for_ms, now_us),
            Ok(Line::Test(line)) => match self.places.get(&(line.array.clone(), line.whisker)) {
                Some(&at) => {
                    let answer = json!({"type": "test_state", "test_id": line.test_id, "state": "RUNNING"});
                    self.tests.push_back(Test { line, at, touches: 0 });
                    vec![Doing::Say(answer)]
                }
                None => vec![Doing::Say(json!({"type": "test_state", "test_id": line.test_id, "state": "FAILED"}))],
            },
            Ok(Line::Estimate { array, whisker, length_mm }) => {
                if let Some(&at) = self.places.get(&(array, whisker)) {
                    self.whiskers[at].learn_length(length_mm);
                }
                Vec::new()
            }
            Ok(Line::Cut { array, whisker, length_mm }) => {
                let array = array.unwrap_or_else(|| self.config.robot.arrays[0].array.clone());
                self.cut(&array, whisker, length_mm, now_us).into_iter().collect()
            }
            Ok(Line::Error { problem }) => vec![Doing::Log(json!({"log": "error", "problem": problem}))],
            Ok(Line::Other) => Vec::new(),
            Err(problem) => vec![Doing::Log(json!({"log": "not_understood", "problem": problem.to_string()}))],
        }
    }

    fn valve(&mut self, array: &Name, whisker: u16, open: Opening, for_ms: f64, now_us: u64) -> Vec<Doing> {
        let Some(&at) = self.places.get(&(array.clone(), whisker)) else { return Vec::new() };
        let Some(chamber) = self.chambers.get_mut(at) else {
            return vec![Doing::Log(json!({"log": "not_understood", "problem": "this board regulates by itself"}))];
        };
        let ended = chamber.obey(open, for_ms, now_us);
        let log = json!({"log": "valve", "whisker": whisker, "t_us": now_us, "is_fill": open == Opening::Fill,
                         "for_ms": for_ms});
        ended.map(|pulse| pulsed(whisker, pulse, now_us)).into_iter().chain([Doing::Log(log)]).collect()
    }

    /// Actions of a board with valves while no agent hears it.
    pub fn alone(&mut self, now_us: u64) -> Vec<Doing> {
        let mut doings = Vec::new();
        if !self.chambers.is_empty() {
            self.guard(now_us, &mut doings);
            self.breathe(now_us, &mut doings);
        }
        doings
    }

    /// Vents all chambers if the agent was silent for too long.
    fn guard(&mut self, now_us: u64, doings: &mut Vec<Doing>) {
        if now_us >= self.heard_us + self.watchdog_us && !self.is_vented {
            self.is_vented = true;
            doings.push(Doing::Log(json!({"log": "watchdog", "t_us": now_us})));
            self.whiskers.iter_mut().for_each(|whisker| whisker.regulator.set(0.0, 0.02));
        }
    }

    /// Lets the air of all chambers move, and reads their pressures.
    fn breathe(&mut self, now_us: u64, doings: &mut Vec<Doing>) {
        let is_due = self.pressure_at_us <= now_us;
        for (chamber, whisker) in self.chambers.iter_mut().zip(&self.whiskers) {
            if self.is_vented {
                chamber.obey(Opening::Vent, 1000.0, now_us);
            } else if let Some(pulse) = chamber.advance(now_us) {
                doings.push(pulsed(whisker.number(), pulse, now_us));
            }
            if is_due {
                doings.push(Doing::Log(json!({"log": "air", "whisker": whisker.number(), "t_us": now_us,
                                              "pressure_mpa": chamber.pressure_mpa()})));
                doings.push(Doing::Say(json!({
                    "type": "pressure", "array": whisker.array(), "whisker": whisker.number(),
                    "pressure_mpa": chamber.reading_mpa(), "temperature_c": whisker.plant.temperature_c(),
                    "supply_mpa": chamber.supply_mpa()})));
            }
        }
        if is_due {
            self.pressure_at_us = now_us + READ_EVERY_US;
        }
    }

    /// Cuts a whisker, unless it is shorter already.
    pub fn cut(&mut self, array: &Name, whisker: u16, length_mm: f64, now_us: u64) -> Option<Doing> {
        let at = *self.places.get(&(array.clone(), whisker))?;
        self.whiskers[at].plant.trim(now_us, length_mm.max(40.0));
        Some(Doing::Log(
            json!({"log": "cut", "array": array, "whisker": whisker, "t_us": now_us, "length_mm": length_mm}),
        ))
    }

    /// Does what is due until now.
    pub fn poll(&mut self, now_us: u64) -> Vec<Doing> {
        let mut doings = Vec::new();
        let supply_mpa = self.present_supply_mpa();
        while self.tick_at_us <= now_us {
            self.tick_at_us += TICK_US;
            for whisker in &mut self.whiskers {
                whisker.regulator.tick(whisker.leak_mpa_per_s, supply_mpa);
            }
            self.follow_tests(now_us, &mut doings);
        }
        self.guard(now_us, &mut doings);
        if !self.chambers.is_empty() {
            self.breathe(now_us, &mut doings);
        } else if self.pressure_at_us <= now_us {
            self.pressure_at_us = now_us + PRESSURE_EVERY_US;
            doings.extend(self.whiskers.iter().map(|whisker| pressure(whisker, supply_mpa)));
        }
        for (gauge, whisker) in self.gauges.iter_mut().zip(&self.whiskers) {
            while gauge.line_at_us() <= now_us {
                doings.push(Doing::Say(gauge.line(whisker.array().as_str(), whisker.number())));
            }
        }
        for at in 0..self.touches.len() {
            let at_us = self.touches[at].0;
            if at_us <= now_us {
                doings.extend(self.touch(at, at_us));
                // A late board leaves contacts out.
                self.plan_touch(at, at_us.max(now_us.saturating_sub(100_000)));
            }
        }
        doings
    }

    /// Latest time of the next [`Board::poll`].
    #[must_use]
    pub fn next_deadline(&self) -> u64 {
        let touch_us = self.touches.iter().map(|&(at_us, _)| at_us).min().unwrap_or(u64::MAX);
        let line_us = self.gauges.iter().map(Gauge::line_at_us).min().unwrap_or(u64::MAX);
        touch_us.min(self.tick_at_us).min(self.pressure_at_us).min(line_us)
    }

    /// True pressure of a chamber.
    fn pressure_mpa(&self, at: usize) -> f64 {
        let regulated_mpa = self.whiskers[at].regulator.pressure_mpa();
        self.chambers.get(at).map_or(regulated_mpa, Chamber::pressure_mpa)
    }

    fn touch(&mut self, at: usize, at_us: u64) -> Vec<Doing> {
        let places = self.config.behaviour.places;
        let pressure_mpa = self.pressure_mpa(at);
        let whisker = &mut self.whiskers[at];
        // A board does not report a contact on the chamber, nor an object out of reach.
        let Ok(Some((reading, touch))) = whisker.plant.touch_at(places, pressure_mpa) else {
            return Vec::new();
        };
        let mut contact = contact_of(whisker, &reading, at_us);
        if let Some(chamber) = self.chambers.get_mut(at) {
            contact.pressure_mpa = chamber.reading_mpa();
        }
        places.state(&mut contact, &touch, whisker.estimated_length_mm());
        match self.gauges.get_mut(at) {
            None => said(&contact),
            Some(gauge) => {
                let log = said(&contact).into_iter().filter(|doing| matches!(doing, Doing::Log(_))).collect();
                gauge.touch(at_us, contact);
                log
            }
        }
    }

    /// Makes the next touch of each test.
    fn follow_tests(&mut self, now_us: u64, doings: &mut Vec<Doing>) {
        for mut test in std::mem::take(&mut self.tests) {
            doings.extend(self.touch_on_request(&test, now_us));
            test.touches += 1;
            if test.touches < test.line.contacts {
                self.tests.push_back(test);
                continue;
            }
            doings.push(Doing::Say(json!({"type": "test_state", "test_id": test.line.test_id, "state": "DONE"})));
        }
    }

    fn touch_on_request(&mut self, test: &Test, at_us: u64) -> Vec<Doing> {
        let line = &test.line;
        let turn = |list: &[f64]| list.get(usize::from(test.touches) % list.len().max(1)).copied();
        let pressure_mpa = self.pressure_mpa(test.at);
        let whisker = &mut self.whiskers[test.at];
        let distance_mm = turn(&line.distances_mm).filter(|_| line.kind == TouchTestKind::Wall);
        match (whisker.plant.touch_on_request(distance_mm, turn(&line.deflections_mm), pressure_mpa), distance_mm) {
            (Ok(Some((reading, touch))), _) => {
                let mut contact = contact_of(whisker, &reading, at_us);
                contact.test_id = Some(line.test_id.clone());
                if let Some(chamber) = self.chambers.get_mut(test.at) {
                    contact.pressure_mpa = chamber.reading_mpa();
                }
                let places = if line.kind == TouchTestKind::Tip { Places::TipDistance } else { Places::Distance };
                places.state(&mut contact, &touch, None);
                said(&contact)
            }
            (Ok(None), Some(distance_mm)) => vec![Doing::Say(json!({
                "type": "contact", "array": line.array, "whisker": line.whisker, "t_us": at_us, "touched": false,
                "distance_mm": distance_mm, "test_id": line.test_id}))],
            // A touch on the chamber gives no strain.
            (Ok(None), None) | (Err(_), _) => Vec::new(),
        }
    }
}

/// Logs a pulse that has ended.
fn pulsed(whisker: u16, pulse: Pulse, now_us: u64) -> Doing {
    Doing::Log(json!({"log": "pulse", "whisker": whisker, "t_us": now_us, "is_fill": pulse.is_fill,
                      "lasted_us": pulse.lasted_us}))
}

fn contact_of(whisker: &Whisker, reading: &Reading, at_us: u64) -> Contact {
    crate::robot::contact_of(whisker, reading, at_us)
}

/// Logs a contact, and then says it.
fn said(contact: &Contact) -> Vec<Doing> {
    let Ok(Value::Object(mut line)) = serde_json::to_value(contact) else { return Vec::new() };
    let log = json!({"log": "contact", "array": contact.array, "whisker": contact.whisker, "t_us": contact.t_us});
    line.insert("type".to_owned(), json!("contact"));
    vec![Doing::Log(log), Doing::Say(Value::Object(line))]
}

fn pressure(whisker: &Whisker, supply_mpa: f64) -> Doing {
    Doing::Say(json!({
        "type": "pressure", "array": whisker.array(), "whisker": whisker.number(),
        "pressure_mpa": whisker.regulator.reading_mpa(), "regulator": whisker.regulator.condition(),
        "temperature_c": whisker.plant.temperature_c(), "supply_mpa": supply_mpa}))
}
