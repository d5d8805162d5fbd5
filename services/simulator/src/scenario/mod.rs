//! What is simulated: the fleet, its noise, and what happens to it. Read from TOML or built in code.

mod check;
mod event;
mod misbehaviour;

use serde::{Deserialize, Serialize};
use vibrissa_protocol::{ArrayType, Name, OnSupervisorLoss};

pub use check::BadScenario;
pub use event::{Change, Event};
pub use misbehaviour::Misbehaviour;

/// A whole simulation.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Where all randomness starts: the same seed and inputs give the same contacts.
    #[serde(default)]
    pub seed: u64,
    /// The fleet's name.
    pub fleet: Name,
    /// How the robots behave.
    #[serde(default)]
    pub behaviour: Behaviour,
    /// What the sensors add to the truth.
    #[serde(default)]
    pub noise: Noise,
    /// How far each whisker's calibration may be off, relative: its factors on k2's c, a and b and on the
    /// elongation gain are each uniform within ± this. 0 to 0.5.
    #[serde(default = "default_calibration_error")]
    pub calibration_error: f64,
    /// The robots, each of another name.
    pub robots: Vec<RobotScenario>,
}

/// How the robots behave.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Behaviour {
    /// Contacts that each whisker makes per second; above 0, at most 10000.
    pub contacts_per_second: f64,
    /// Contacts in one message, 1 to 1000.
    pub contacts_per_message: usize,
    /// A message that does not fill up is sent after this many seconds.
    pub message_after_s: f64,
    /// Seconds between two `status` messages, 0.1 to 10.
    pub status_every_s: f64,
    /// Contacts messages that a robot keeps until they are receipted; the oldest are dropped beyond it.
    pub kept_messages: usize,
    /// A robot that has heard nothing from the supervisor for this many seconds does what its
    /// `on_supervisor_loss` says.
    pub supervisor_lost_after_s: f64,
    /// Whether robots notice leaks and gauges that are out of order; one that does not says OK of both.
    pub notices_faults: bool,
    /// Whether robots keep a journal; whoever lets them takes it now and then with [`crate::Robot::take_journal`].
    #[serde(skip)]
    pub journal: bool,
    /// A rule of the contract that the robots break, so that a test can see that it notices.
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
            notices_faults: true,
            journal: false,
            misbehaviour: None,
        }
    }
}

/// What the sensors add to the truth: standard deviations of normal errors.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Noise {
    /// Of the strain, relative.
    pub strain_relative: f64,
    /// Of the strain, absolute in m/m, on top of the relative one.
    pub strain_floor: f64,
    /// Of the deflection, relative.
    pub deflection_relative: f64,
    /// Of the contact ratio, absolute.
    pub ratio: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self { strain_relative: 0.02, strain_floor: 5e-6, deflection_relative: 0.01, ratio: 0.01 }
    }
}

/// One robot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotScenario {
    /// Its name.
    pub robot: Name,
    /// Its model, as in the factsheet.
    #[serde(default = "default_model")]
    pub model: String,
    /// What it does when the supervisor is gone.
    #[serde(default = "default_on_supervisor_loss")]
    pub on_supervisor_loss: OnSupervisorLoss,
    /// Its arrays, each of another name.
    pub arrays: Vec<ArrayScenario>,
    /// What happens to it.
    #[serde(default)]
    pub events: Vec<Event>,
}

/// One array.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArrayScenario {
    /// Its name.
    pub array: Name,
    /// What it can do about a shortened whisker.
    #[serde(rename = "type")]
    pub array_type: ArrayType,
    /// Its whiskers, each of another number.
    pub whiskers: Vec<WhiskerScenario>,
}

/// One whisker as it was built in.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WhiskerScenario {
    /// Its number in the array.
    pub whisker: u16,
    /// Where it stands, in mm.
    pub x_mm: f64,
    /// Where it stands, in mm.
    pub y_mm: f64,
    /// Its length without the chamber's elongation, in mm.
    pub length_mm: f64,
    /// The chamber's nominal gauge pressure in MPa.
    pub pressure_mpa: f64,
    /// The highest pressure that the robot lets into the chamber, in MPa; at most 0.2.
    pub pressure_max_mpa: f64,
    /// Whiskers of the same array that can take its place.
    pub neighbours: Vec<u16>,
    /// How its rubber truly is; drawn by chance within the scenario's `calibration_error` if not said.
    pub rubber: Option<Rubber>,
}

/// How a whisker truly differs from the built-in calibration: factors on its parameters, and which formulation
/// of the mechanics is true.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rubber {
    /// On k2's c, 0.5 to 1.5.
    pub c: f64,
    /// On k2's a, 0.5 to 1.5.
    pub a: f64,
    /// On k2's b, 0.5 to 1.5.
    pub b: f64,
    /// On the elongation gain, 0.5 to 1.5.
    pub elongation: f64,
    /// How a factor that the paper misprints is to be read.
    pub formulation: TrueFormulation,
}

/// How a factor that the paper misprints is to be read; see [`vibrissa_core::mechanics::Formulation`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum TrueFormulation {
    /// As printed.
    Published,
    /// Under pressure, as the rest is.
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
    /// Reads a scenario and checks it as a whole.
    ///
    /// # Errors
    /// The text is not TOML, has an unknown or missing field, or says something that cannot be; the
    /// message names the place.
    pub fn from_toml_str(text: &str) -> Result<Self, BadScenario> {
        let scenario: Self = toml::from_str(text).map_err(|error| BadScenario::NotToml(error.to_string()))?;
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
