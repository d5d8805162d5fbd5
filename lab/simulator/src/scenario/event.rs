//! Events that happen to a robot.

use serde::Deserialize;
use vibrissa_protocol::Name;

/// An event that happens once: at a time, or after a number of contacts of a whisker.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// Time of the event, in seconds after the robot's start. Either this or `at_contact`.
    #[serde(default)]
    pub at_s: Option<f64>,
    /// Number of the whisker's contacts before the event: the contact with this index (from 0) is the first one
    /// after the change.
    #[serde(default)]
    pub at_contact: Option<u64>,
    /// Array that is affected; [`Change`] states which changes need one.
    #[serde(default)]
    pub array: Option<Name>,
    /// Number of the affected whisker.
    #[serde(default)]
    pub whisker: Option<u16>,
    /// The change that happens.
    pub change: Change,
}

/// Changes that can happen.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
pub enum Change {
    /// To a whisker: it is cut to a length, counted without the chamber's elongation.
    #[serde(rename = "TRIM")]
    Trim {
        /// Remaining length, in mm.
        length_mm: f64,
    },
    /// To a whisker: each contact wears it off.
    #[serde(rename = "ERODE")]
    Erode {
        /// Loss of length per contact, in mm.
        rate_mm_per_contact: f64,
        /// Length at which the wear stops, in mm.
        until_length_mm: f64,
    },
    /// To a whisker: its chamber loses air.
    #[serde(rename = "LEAK")]
    Leak {
        /// Loss without refills, in MPa/s.
        rate_mpa_per_s: f64,
    },
    /// To a whisker: the valves of its chamber open no more, and its regulator reports FAULT.
    #[serde(rename = "VALVES_BROKEN")]
    ValvesBroken,
    /// To a whisker: its valves work again.
    #[serde(rename = "VALVES_OK")]
    ValvesOk,
    /// To a whisker: the gauge's circuit breaks; it reads full scale.
    #[serde(rename = "GAUGE_OPEN")]
    GaugeOpen,
    /// To a whisker: the gauge's circuit is shorted; it reads zero and noise.
    #[serde(rename = "GAUGE_SHORT")]
    GaugeShort,
    /// To a whisker: its gauge saturates at a limit.
    #[serde(rename = "GAUGE_SATURATED")]
    GaugeSaturated {
        /// Limit of the reading, in m/m.
        #[serde(default = "default_limit_strain")]
        limit_strain: f64,
    },
    /// To a whisker: its gauge works again.
    #[serde(rename = "GAUGE_OK")]
    GaugeOk,
    /// To a whisker: a new one is installed in its place, as at the start, with a tight chamber and a working gauge.
    #[serde(rename = "REPLACE")]
    Replace,
    /// To a whisker: its gauge's zero drifts with each contact, as under cyclic load.
    #[serde(rename = "BASELINE_DRIFT")]
    BaselineDrift {
        /// Change of the zero per contact, in m/m; either sign.
        strain_per_contact: f64,
        /// Zero at which the drift stops, in m/m, with the same sign.
        until_strain: f64,
    },
    /// To a whisker: the robot sends nothing about it, neither contacts nor condition.
    #[serde(rename = "SILENT")]
    Silent {
        /// Duration, in seconds.
        #[serde(default = "default_silent_s")]
        for_s: f64,
    },
    /// To a robot, or to one array: it reports the true deflections times a factor.
    #[serde(rename = "DEFLECTION_SCALE")]
    DeflectionScale {
        /// Factor on the true deflection.
        factor: f64,
    },
    /// To a robot, or to one array: the temperature changes, and all sensitivities with it.
    #[serde(rename = "TEMPERATURE")]
    Temperature {
        /// Factor on all sensitivities, relative to the start.
        sensitivity_factor: f64,
        /// New temperature, in degrees Celsius.
        #[serde(default = "default_temperature_c")]
        temperature_c: f64,
    },
    /// To a robot: contacts messages are lost in their first transmission.
    #[serde(rename = "LOSE")]
    Lose {
        /// Share of lost messages, 0 to 1.
        fraction: f64,
        /// Duration, in seconds.
        for_s: f64,
    },
    /// To a robot: contacts messages are sent twice.
    #[serde(rename = "REPEAT")]
    Repeat {
        /// Share of repeated messages, 0 to 1.
        fraction: f64,
        /// Duration, in seconds.
        for_s: f64,
    },
    /// To a robot: contacts messages overtake each other.
    #[serde(rename = "REORDER")]
    Reorder {
        /// Share of messages that are held back until the next one has been sent, 0 to 1.
        fraction: f64,
        /// Duration, in seconds.
        for_s: f64,
    },
    /// To a robot: it restarts without a farewell, with a new boot id and without its stored messages.
    #[serde(rename = "RESTART")]
    Restart,
    /// To a robot: its air supply falls to a pressure and stays there.
    #[serde(rename = "SUPPLY_LOW")]
    SupplyLow {
        /// Remaining supply pressure, in MPa.
        #[serde(default = "default_supply_mpa")]
        supply_mpa: f64,
    },
}

fn default_limit_strain() -> f64 {
    0.01
}

/// Practically forever.
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
    /// A change of a whisker after a number of its contacts.
    #[must_use]
    pub fn at_contact(contact: u64, array: Name, whisker: u16, change: Change) -> Self {
        Self { at_s: None, at_contact: Some(contact), array: Some(array), whisker: Some(whisker), change }
    }

    /// A change of a whisker at a time in seconds after the robot's start.
    #[must_use]
    pub fn whisker_at_s(seconds: f64, array: Name, whisker: u16, change: Change) -> Self {
        Self { at_s: Some(seconds), at_contact: None, array: Some(array), whisker: Some(whisker), change }
    }

    /// A change of the robot at a time in seconds after its start.
    #[must_use]
    pub fn robot_at_s(seconds: f64, change: Change) -> Self {
        Self { at_s: Some(seconds), at_contact: None, array: None, whisker: None, change }
    }
}

/// Part of a robot that a change affects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Target {
    /// One whisker; the event needs array and whisker.
    Whisker,
    /// The robot or one of its arrays.
    RobotOrArray,
    /// The robot as a whole.
    Robot,
}

impl Change {
    /// The part of a robot that this change affects.
    pub(crate) fn target(&self) -> Target {
        match self {
            Self::Trim { .. }
            | Self::Erode { .. }
            | Self::Leak { .. }
            | Self::ValvesBroken
            | Self::ValvesOk
            | Self::GaugeOpen
            | Self::GaugeShort
            | Self::GaugeSaturated { .. }
            | Self::GaugeOk
            | Self::Replace
            | Self::BaselineDrift { .. }
            | Self::Silent { .. } => Target::Whisker,
            Self::Temperature { .. } | Self::DeflectionScale { .. } => Target::RobotOrArray,
            Self::Lose { .. } | Self::Repeat { .. } | Self::Reorder { .. } | Self::Restart | Self::SupplyLow { .. } => {
                Target::Robot
            }
        }
    }
}
