//! Scenario of a simulation: the fleet, its noise, and its events. Read from TOML or built in code.

mod check;
mod event;
mod misbehaviour;

use serde::{Deserialize, Serialize};
use vibrissa_core::mechanics::{Formulation, Model, ModelError};
use vibrissa_edge::calibration_file::CalibrationFile;
use vibrissa_protocol::{AirControl, ArrayType, Name, OnSupervisorLoss, Task, TouchTestKind, plain};

pub use check::BadScenario;
pub use event::{Change, Event};
pub use misbehaviour::Misbehaviour;

use crate::places::Places;

/// A whole simulation.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Seed of all randomness: the same seed and inputs give the same contacts.
    #[serde(default)]
    pub seed: u64,
    /// Name of the fleet.
    pub fleet: Name,
    /// Behaviour of the robots.
    #[serde(default)]
    pub behaviour: Behaviour,
    /// Noise of the sensors.
    #[serde(default)]
    pub noise: Noise,
    /// Largest relative deviation of the whiskers' calibrations, 0 to 0.5: the factors on k2's c, a and b and on
    /// the elongation gain are each uniform within ± this.
    #[serde(default = "default_calibration_error")]
    pub calibration_error: f64,
    /// Dimensions and calibration of the whiskers before their deviations, as in a calibration file; those of the paper if
    /// absent. The factsheets name it as the whiskers' model.
    #[serde(default)]
    pub calibration: Option<CalibrationFile>,
    /// The robots, with distinct names.
    pub robots: Vec<RobotScenario>,
}

/// Behaviour of the robots.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Behaviour {
    /// Contacts of each whisker per second; above 0, at most 10000.
    pub contacts_per_second: f64,
    /// Number of contacts in a full message, 1 to 1000.
    pub contacts_per_message: usize,
    /// Seconds after which an incomplete message is sent.
    pub message_after_s: f64,
    /// Seconds between two `status` messages, 0.1 to 10.
    pub status_every_s: f64,
    /// Contacts messages that a robot stores until they are receipted; beyond it the oldest are dropped.
    pub kept_messages: usize,
    /// Seconds without a message from the supervisor after which a robot behaves as its `on_supervisor_loss`
    /// states.
    pub supervisor_lost_after_s: f64,
    /// Place that robots state with each contact.
    pub places: Places,
    /// Touch tests that robots can do.
    pub touch_tests: Vec<TouchTestKind>,
    /// Ways in which robots can change the pressure of their chambers, as their factsheets state it.
    pub air_control: Option<AirControl>,
    /// Use of the readings of all arrays, as factsheets state it.
    pub task: Option<Task>,
    /// Whether robots detect leaks and broken gauges; otherwise they report both as OK.
    pub notices_faults: bool,
    /// Whether robots keep a journal; the caller must then empty it regularly with [`crate::Robot::take_journal`].
    #[serde(skip)]
    pub journal: bool,
    /// Fault by which the robots break a rule of the contract, for tests that must detect it.
    pub misbehaviour: Option<Misbehaviour>,
}

impl Default for Behaviour {
    fn default() -> Self {
        Self {
            contacts_per_second: 1.0,
            contacts_per_message: 10,
            message_after_s: 1.0,
            status_every_s: 1.0,
            kept_messages: 2000,
            supervisor_lost_after_s: 60.0,
            places: Places::Ratio,
            touch_tests: Vec::new(),
            air_control: None,
            task: None,
            notices_faults: true,
            journal: false,
            misbehaviour: None,
        }
    }
}

/// Noise of the sensors: standard deviations of normal errors.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Noise {
    /// Strain noise, relative.
    pub strain_relative: f64,
    /// Strain noise, absolute in m/m, in addition to the relative one.
    pub strain_floor: f64,
    /// Deflection noise, relative.
    pub deflection_relative: f64,
    /// Contact ratio noise, absolute.
    pub ratio: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self { strain_relative: 0.02, strain_floor: 5e-6, deflection_relative: 0.01, ratio: 0.01 }
    }
}

/// One robot of a scenario.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotScenario {
    /// Name of the robot.
    pub robot: Name,
    /// Model of the robot, as in the factsheet.
    #[serde(default = "default_model")]
    pub model: String,
    /// Behaviour without a supervisor.
    #[serde(default = "default_on_supervisor_loss")]
    pub on_supervisor_loss: OnSupervisorLoss,
    /// Whether it multiplies its readings by `reading_gain`, as its factsheet then states.
    #[serde(default)]
    pub applies_gain: bool,
    /// Arrays of the robot, with distinct names.
    pub arrays: Vec<ArrayScenario>,
    /// Events that happen to the robot.
    #[serde(default)]
    pub events: Vec<Event>,
}

/// One array of a robot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArrayScenario {
    /// Name of the array.
    pub array: Name,
    /// Ways in which the array can compensate for a shortened whisker.
    #[serde(rename = "type")]
    pub array_type: ArrayType,
    /// Whiskers of the array, with distinct numbers.
    pub whiskers: Vec<WhiskerScenario>,
}

/// One whisker as installed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WhiskerScenario {
    /// Number of the whisker in the array.
    pub whisker: u16,
    /// Position along x, in mm.
    pub x_mm: f64,
    /// Position along y, in mm.
    pub y_mm: f64,
    /// Length without the chamber's elongation, in mm.
    pub length_mm: f64,
    /// Nominal gauge pressure of the chamber, in MPa.
    pub pressure_mpa: f64,
    /// Error of the length as the factsheet states it, in mm; it states none if absent.
    pub length_tolerance_mm: Option<f64>,
    /// Highest pressure that the robot permits in the chamber, in MPa; at most 0.2.
    pub pressure_max_mpa: f64,
    /// Numbers of whiskers of the same array that can compensate for this one.
    pub neighbours: Vec<u16>,
    /// Largest strain that the gauge reads, in m/m, as the factsheet then states it; a simulated amplifier ends at 0.5.
    pub strain_max: Option<f64>,
    /// True rubber of the whisker; random within the scenario's `calibration_error` if absent.
    pub rubber: Option<Rubber>,
}

/// True deviation of a whisker from the scenario's calibration: factors on its parameters, and the true formulation
/// of the mechanics.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rubber {
    /// Factor on k2's c, 0.5 to 1.5.
    pub c: f64,
    /// Factor on k2's a, 0.5 to 1.5.
    pub a: f64,
    /// Factor on k2's b, 0.5 to 1.5.
    pub b: f64,
    /// Factor on the elongation gain, 0.5 to 1.5.
    pub elongation: f64,
    /// True reading of a factor that the paper misprints.
    pub formulation: TrueFormulation,
}

/// Reading of a factor that the paper misprints; see [`vibrissa_core::mechanics::Formulation`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum TrueFormulation {
    /// The factor as printed, at zero pressure.
    Published,
    /// The factor under pressure, consistent with the other equations.
    Consistent,
}

impl Default for Rubber {
    fn default() -> Self {
        Self { c: 1.0, a: 1.0, b: 1.0, elongation: 1.0, formulation: TrueFormulation::Consistent }
    }
}

impl Default for WhiskerScenario {
    fn default() -> Self {
        Self {
            whisker: 0,
            x_mm: 0.0,
            y_mm: 0.0,
            length_mm: 70.0,
            pressure_mpa: 0.1,
            pressure_max_mpa: 0.2,
            neighbours: Vec::new(),
            length_tolerance_mm: None,
            strain_max: None,
            rubber: None,
        }
    }
}

fn default_calibration_error() -> f64 {
    0.03
}

fn default_model() -> String {
    "simulated".to_owned()
}

fn default_on_supervisor_loss() -> OnSupervisorLoss {
    OnSupervisorLoss::Hold
}

impl Scenario {
    /// Mechanics of its whiskers without deviations.
    ///
    /// # Errors
    /// The numbers of its calibration do not give a valid model.
    pub fn model(&self) -> Result<Model, ModelError> {
        let formulation = Formulation::Consistent;
        self.calibration.as_ref().map_or_else(|| Ok(Model::nguyen_2021(formulation)), |file| file.model(formulation))
    }

    /// Parses a scenario and checks it as a whole.
    ///
    /// # Errors
    /// The text is not TOML, has an unknown or missing field, or has an invalid value; the message names the place.
    pub fn from_toml_str(text: &str) -> Result<Self, BadScenario> {
        let scenario: Self = toml::from_str(text)
            .map_err(|error| BadScenario::NotToml(plain::in_file(text, error.span(), error.message())))?;
        scenario.check()?;
        Ok(scenario)
    }
}

impl RobotScenario {
    /// The robot's whiskers with their arrays, in the order of the scenario.
    pub fn whiskers(&self) -> impl Iterator<Item = (&ArrayScenario, &WhiskerScenario)> {
        self.arrays.iter().flat_map(|array| array.whiskers.iter().map(move |whisker| (array, whisker)))
    }
}

#[cfg(test)]
mod tests;
