//! What happens to a robot, and when.

use serde::Deserialize;
use vibrissa_protocol::Name;

/// Something that happens once: at a time, or when a whisker has made a number of contacts.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// Seconds after the robot's start. Either this or `at_contact`.
    #[serde(default)]
    pub at_s: Option<f64>,
    /// After that many contacts of the whisker: the contact with this index (from 0) is the first after
    /// the change.
    #[serde(default)]
    pub at_contact: Option<u64>,
    /// The array that it happens to; see [`Change`] for which need one.
    #[serde(default)]
    pub array: Option<Name>,
    /// The whisker that it happens to.
    #[serde(default)]
    pub whisker: Option<u16>,
    /// What happens.
    pub change: Change,
}

/// What can happen.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
pub enum Change {
    /// To a whisker: cut to a length in mm, counted without the chamber's elongation.
    #[serde(rename = "TRIM")]
    Trim {
        /// What remains.
        length_mm: f64,
    },
    /// To a whisker: wears off with every contact.
    #[serde(rename = "ERODE")]
    Erode {
        /// How much each contact takes off.
        rate_mm_per_contact: f64,
        /// Where it ends.
        until_length_mm: f64,
    },
    /// To a whisker: its chamber loses air.
    #[serde(rename = "LEAK")]
    Leak {
        /// How fast, without refilling.
        rate_mpa_per_s: f64,
    },
    /// To a whisker: its gauge's circuit breaks; it reads full scale.
    #[serde(rename = "GAUGE_OPEN")]
    GaugeOpen,
    /// To a whisker: its gauge's circuit is shorted; it reads zero and noise.
    #[serde(rename = "GAUGE_SHORT")]
    GaugeShort,
    /// To a whisker: its gauge reads nothing beyond a limit.
    #[serde(rename = "GAUGE_SATURATED")]
    GaugeSaturated {
        /// The limit in m/m.
        #[serde(default = "default_limit_strain")]
        limit_strain: f64,
    },
    /// To a whisker: its gauge is in order again.
    #[serde(rename = "GAUGE_OK")]
    GaugeOk,
    /// To a whisker: its gauge's zero wanders with every contact, as it does under cyclic load.
    #[serde(rename = "BASELINE_DRIFT")]
    BaselineDrift {
        /// How much each contact adds to the zero, in m/m; either sign.
        strain_per_contact: f64,
        /// Where it ends, in m/m, with the same sign.
        until_strain: f64,
    },
    /// To a whisker: nothing is told of it any more, neither contacts nor condition.
    #[serde(rename = "SILENT")]
    Silent {
        /// For how long.
        #[serde(default = "default_silent_s")]
        for_s: f64,
    },
    /// To a robot, or to one array: the deflections that it tells are the true ones times a factor.
    #[serde(rename = "DEFLECTION_SCALE")]
    DeflectionScale {
        /// The factor, against the truth.
        factor: f64,
    },
    /// To a robot, or to one array: the temperature changes, and with it every sensitivity alike.
    #[serde(rename = "TEMPERATURE")]
    Temperature {
        /// The factor on every sensitivity, against the start.
        sensitivity_factor: f64,
        /// The new temperature in degrees Celsius.
        #[serde(default = "default_temperature_c")]
        temperature_c: f64,
    },
    /// To a robot: contacts messages get lost on their first way.
    #[serde(rename = "LOSE")]
    Lose {
        /// Which part of them, 0 to 1.
        fraction: f64,
        /// For how long.
        for_s: f64,
    },
    /// To a robot: contacts messages are sent twice.
    #[serde(rename = "REPEAT")]
    Repeat {
        /// Which part of them, 0 to 1.
        fraction: f64,
        /// For how long.
        for_s: f64,
    },
    /// To a robot: contacts messages overtake each other.
    #[serde(rename = "REORDER")]
    Reorder {
        /// Which part of them is held back until the next has gone, 0 to 1.
        fraction: f64,
        /// For how long.
        for_s: f64,
    },
    /// To a robot: it restarts without a farewell, with a new boot id and without the messages it kept.
    #[serde(rename = "RESTART")]
    Restart,
    /// To a robot: its air supply falls to a pressure and stays there.
    #[serde(rename = "SUPPLY_LOW")]
    SupplyLow {
        /// The pressure that is left.
        #[serde(default = "default_supply_mpa")]
        supply_mpa: f64,
    },
}

fn default_limit_strain() -> f64 {
    0.01
}

/// For good.
fn default_silent_s() -> f64 {
    1e9
}

fn default_temperature_c() -> f64 {
    30.0
}

fn default_supply_mpa() -> f64 {
    0.03
}

impl Event {
    /// Something that happens to a whisker after that many of its contacts.
    #[must_use]
    pub fn at_contact(contact: u64, array: Name, whisker: u16, change: Change) -> Self {
        Self { at_s: None, at_contact: Some(contact), array: Some(array), whisker: Some(whisker), change }
    }

    /// Something that happens to a whisker that many seconds after the robot's start.
    #[must_use]
    pub fn whisker_at_s(seconds: f64, array: Name, whisker: u16, change: Change) -> Self {
        Self { at_s: Some(seconds), at_contact: None, array: Some(array), whisker: Some(whisker), change }
    }

    /// Something that happens to the robot that many seconds after its start.
    #[must_use]
    pub fn robot_at_s(seconds: f64, change: Change) -> Self {
        Self { at_s: Some(seconds), at_contact: None, array: None, whisker: None, change }
    }
}

/// Whom a change can happen to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Target {
    /// One whisker: array and whisker are needed.
    Whisker,
    /// The robot or one of its arrays.
    RobotOrArray,
    /// The robot as a whole.
    Robot,
}

impl Change {
    /// Whom it can happen to.
    pub(crate) fn target(&self) -> Target {
        match self {
            Self::Trim { .. }
            | Self::Erode { .. }
            | Self::Leak { .. }
            | Self::GaugeOpen
            | Self::GaugeShort
            | Self::GaugeSaturated { .. }
            | Self::GaugeOk
            | Self::BaselineDrift { .. }
            | Self::Silent { .. } => Target::Whisker,
            Self::Temperature { .. } | Self::DeflectionScale { .. } => Target::RobotOrArray,
            Self::Lose { .. } | Self::Repeat { .. } | Self::Reorder { .. } | Self::Restart | Self::SupplyLow { .. } => {
                Target::Robot
            }
        }
    }
}
