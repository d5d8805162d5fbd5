//! A simulated board: gauges, valves and pressure sensors of one robot behind the driver interface.
//!
//! It speaks the lines of docs/driver-interface.md, as the firmware of a real board does, and knows nothing of MQTT. It keeps
//! a log of its own, with which tests compare what the supervisor has recorded. [`Board`] is pure: its caller passes the time
//! and the lines. [`run`] drives it.

mod gauge;
mod link;
mod plan;

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
    Test(TestLine),
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
    tick_at_us: u64,
    pressure_at_us: u64,
    heard_us: u64,
    watchdog_us: u64,
    is_vented: bool,
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
            tick_at_us: now_us + TICK_US,
            pressure_at_us: now_us,
            heard_us: now_us,
            watchdog_us,
            is_vented: false,
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
        self.is_vented = false;
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
            Ok(Line::Test(line)) => match self.places.get(&(line.array.clone(), line.whisker)) {
                Some(&at) => {
                    let told = json!({"type": "test_state", "test_id": line.test_id, "state": "RUNNING"});
                    self.tests.push_back(Test { line, at, touches: 0 });
                    vec![Doing::Say(told)]
                }
                None => vec![Doing::Say(json!({"type": "test_state", "test_id": line.test_id, "state": "FAILED"}))],
            },
            Ok(Line::Cut { array, whisker, length_mm }) => {
                let array = array.unwrap_or_else(|| self.config.robot.arrays[0].array.clone());
                self.cut(&array, whisker, length_mm, now_us).into_iter().collect()
            }
            Ok(Line::Error { problem }) => vec![Doing::Log(json!({"log": "error", "problem": problem}))],
            Ok(Line::Other) => Vec::new(),
            Err(problem) => vec![Doing::Log(json!({"log": "not_understood", "problem": problem.to_string()}))],
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
        while self.tick_at_us <= now_us {
            self.tick_at_us += TICK_US;
            for whisker in &mut self.whiskers {
                whisker.regulator.tick(whisker.leak_mpa_per_s, SUPPLY_MPA);
            }
            self.follow_tests(now_us, &mut doings);
        }
        if now_us >= self.heard_us + self.watchdog_us && !self.is_vented {
            self.is_vented = true;
            doings.push(Doing::Log(json!({"log": "watchdog", "t_us": now_us})));
            self.whiskers.iter_mut().for_each(|whisker| whisker.regulator.set(0.0, 0.02));
        }
        if self.pressure_at_us <= now_us {
            self.pressure_at_us = now_us + PRESSURE_EVERY_US;
            doings.extend(self.whiskers.iter().map(pressure));
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

    fn touch(&mut self, at: usize, at_us: u64) -> Vec<Doing> {
        let places = self.config.behaviour.places;
        let whisker = &mut self.whiskers[at];
        // A board does not report a contact on the chamber, nor an object out of reach.
        let Ok(Some((reading, touch))) = whisker.plant.touch_at(places, whisker.regulator.pressure_mpa()) else {
            return Vec::new();
        };
        let mut contact = contact_of(whisker, &reading, at_us);
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
        let whisker = &mut self.whiskers[test.at];
        let pressure_mpa = whisker.regulator.pressure_mpa();
        let distance_mm = turn(&line.distances_mm).filter(|_| line.kind == TouchTestKind::Wall);
        match (whisker.plant.touch_on_request(distance_mm, turn(&line.deflections_mm), pressure_mpa), distance_mm) {
            (Ok(Some((reading, touch))), _) => {
                let mut contact = contact_of(whisker, &reading, at_us);
                contact.test_id = Some(line.test_id.clone());
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

fn pressure(whisker: &Whisker) -> Doing {
    Doing::Say(json!({
        "type": "pressure", "array": whisker.array(), "whisker": whisker.number(),
        "pressure_mpa": whisker.regulator.reading_mpa(), "regulator": whisker.regulator.condition(),
        "temperature_c": whisker.plant.temperature_c(), "supply_mpa": SUPPLY_MPA}))
}
