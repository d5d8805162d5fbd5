//! Saves a robot's true state for a later process, and restores it.
//!
//! Whiskers keep their state. The robot's own memory (stored messages, setpoints seen) is lost, as in every
//! restart: it has a new boot, its chambers still have their pressures, and it sets them to the factsheet's.

use serde::{Deserialize, Serialize};
use vibrissa_protocol::Name;
use vibrissa_robot::contract::Voice;

use super::{Robot, RobotConfig, boot_id};
use crate::plant::PlantState;

/// State of one robot that survives a restart of the process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RobotState {
    robot: Name,
    /// Start of the scenario, in microseconds since 1970 UTC.
    start_us: u64,
    boots: u64,
    supply_mpa: f64,
    /// Number of timed events that are still to come.
    events_left: usize,
    whiskers: Vec<WhiskerState>,
}

/// State of one whisker that survives a restart of the process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WhiskerState {
    array: Name,
    whisker: u16,
    pressure_mpa: f64,
    leak_mpa_per_s: f64,
    #[serde(default)]
    valves_broken: bool,
    silent_until_us: u64,
    /// Number of events by contact count that are still to come.
    events_left: usize,
    plant: PlantState,
}

impl Robot {
    /// The state to write to the state file.
    pub(crate) fn state(&self) -> RobotState {
        let whisker = |whisker: &super::Whisker| WhiskerState {
            array: whisker.array().clone(),
            whisker: whisker.number(),
            pressure_mpa: whisker.regulator.pressure_mpa(),
            leak_mpa_per_s: whisker.leak_mpa_per_s,
            valves_broken: whisker.regulator.is_broken(),
            silent_until_us: whisker.silent_until_us,
            events_left: whisker.events.len(),
            plant: whisker.plant.state(),
        };
        RobotState {
            robot: self.name().clone(),
            start_us: self.start_us,
            boots: self.boots,
            supply_mpa: self.supply_mpa,
            // A requested restart is not an event of the scenario, so it is not counted.
            events_left: self.events.iter().filter(|(at_us, _)| *at_us >= self.start_us).count(),
            whiskers: self.whiskers.iter().map(whisker).collect(),
        }
    }

    /// Whether something has happened to the robot since the last call.
    pub(crate) fn take_change(&mut self) -> bool {
        std::mem::take(&mut self.has_changed)
    }

    /// Restores a robot, in its next boot.
    ///
    /// # Errors
    /// The first value that is invalid or does not fit the configuration.
    pub(crate) fn resume(config: RobotConfig, seed: u64, state: &RobotState, now_us: u64) -> Result<Self, String> {
        let name = &config.robot.robot;
        if state.robot != *name {
            return Err(format!("found robot {} instead of robot {name}", state.robot));
        }
        let of_robot = |why: String| format!("robot {}: {why}", state.robot);
        let mut robot = Self::begin(config, seed, state.start_us, now_us).map_err(|why| of_robot(why.to_string()))?;
        robot.boots = state.boots.checked_add(1).ok_or_else(|| of_robot("boots has its highest value".to_owned()))?;
        robot.voice = Voice::new(boot_id(seed, &state.robot, state.start_us, robot.boots));
        if !(0.0..=1.0).contains(&state.supply_mpa) {
            return Err(of_robot(format!("supply_mpa is {}, but must be between 0 and 1", state.supply_mpa)));
        }
        robot.supply_mpa = state.supply_mpa;
        let over = robot.events.len().checked_sub(state.events_left);
        robot.events.drain(..over.ok_or_else(|| of_robot("events_left is above the number of events".to_owned()))?);
        if state.whiskers.len() != robot.whiskers.len() {
            return Err(of_robot(format!("{} whiskers instead of {}", state.whiskers.len(), robot.whiskers.len())));
        }
        for (whisker, state) in robot.whiskers.iter_mut().zip(&state.whiskers) {
            whisker.take_up(state).map_err(|why| of_robot(format!("{}/{}: {why}", state.array, state.whisker)))?;
        }
        Ok(robot)
    }
}

impl super::Whisker {
    fn take_up(&mut self, state: &WhiskerState) -> Result<(), String> {
        if state.array != *self.array() || state.whisker != self.number() {
            return Err(format!("expected {}/{} here", self.array(), self.number()));
        }
        for (name, value) in [("pressure_mpa", state.pressure_mpa), ("leak_mpa_per_s", state.leak_mpa_per_s)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(format!("{name} is {value}, but must be between 0 and 1"));
            }
        }
        let over = self.events.len().checked_sub(state.events_left);
        self.events.drain(..over.ok_or("events_left is above the number of events")?);
        self.plant.take_up(&state.plant)?;
        self.leak_mpa_per_s = state.leak_mpa_per_s;
        self.silent_until_us = state.silent_until_us;
        self.regulator.set_broken(state.valves_broken);
        self.regulator.find(state.pressure_mpa);
        self.restart();
        Ok(())
    }
}
