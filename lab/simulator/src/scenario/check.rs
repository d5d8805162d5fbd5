//! Checks a scenario and names the place of the first error.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use vibrissa_protocol::{ARRAYS_MAX, CONTACTS_MAX, WHISKERS_MAX};

use super::event::Target;
use super::{ArrayScenario, Change, Event, RobotScenario, Scenario, WhiskerScenario};
use crate::plant::FULL_SCALE_STRAIN;

/// Why a scenario is invalid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BadScenario {
    /// The text cannot be parsed; the message has line and column.
    #[error("cannot parse the scenario: {0}")]
    NotToml(String),
    /// A number is outside its range.
    #[error("{place} is {value}, but must be {allowed}")]
    OutOfRange {
        /// Place of the number in the scenario.
        place: String,
        /// The given value.
        value: f64,
        /// The permitted range.
        allowed: String,
    },
    /// A name occurs twice.
    #[error("{place}: {name} occurs more than once")]
    Twice {
        /// Place of the list in the scenario.
        place: String,
        /// The repeated name.
        name: String,
    },
    /// A value does not fit the rest of the scenario.
    #[error("{place}: {problem}")]
    Unfitting {
        /// Place of the value in the scenario.
        place: String,
        /// Description of the error.
        problem: String,
    },
}

type Checked = Result<(), BadScenario>;

/// Checks that a number is in a closed range.
fn within(place: String, value: f64, range: RangeInclusive<f64>) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    Err(BadScenario::OutOfRange { place, value, allowed: format!("between {} and {}", range.start(), range.end()) })
}

fn unfitting(place: &str, problem: impl Into<String>) -> BadScenario {
    BadScenario::Unfitting { place: place.to_owned(), problem: problem.into() }
}

/// Checks that all names are distinct.
fn distinct(place: &str, names: impl Iterator<Item = String>) -> Checked {
    let mut seen = BTreeSet::new();
    for name in names {
        if seen.contains(&name) {
            return Err(BadScenario::Twice { place: place.to_owned(), name });
        }
        seen.insert(name);
    }
    Ok(())
}

impl Scenario {
    /// Checks a scenario as a whole; [`Scenario::from_toml_str`] has already done so.
    ///
    /// # Errors
    /// The first invalid value; the message names its place.
    pub fn check(&self) -> Result<(), BadScenario> {
        let b = &self.behaviour;
        within("behaviour.contacts_per_second".into(), b.contacts_per_second, 1e-6..=10_000.0)?;
        within("behaviour.contacts_per_message".into(), b.contacts_per_message as f64, 1.0..=CONTACTS_MAX as f64)?;
        within("behaviour.message_after_s".into(), b.message_after_s, 0.01..=60.0)?;
        within("behaviour.status_every_s".into(), b.status_every_s, 0.1..=10.0)?;
        within("behaviour.kept_messages".into(), b.kept_messages as f64, 1.0..=1e6)?;
        within("behaviour.supervisor_lost_after_s".into(), b.supervisor_lost_after_s, 1.0..=86_400.0)?;
        within("noise.strain_relative".into(), self.noise.strain_relative, 0.0..=1.0)?;
        within("noise.strain_floor".into(), self.noise.strain_floor, 0.0..=0.1)?;
        within("noise.deflection_relative".into(), self.noise.deflection_relative, 0.0..=1.0)?;
        within("noise.ratio".into(), self.noise.ratio, 0.0..=0.5)?;
        within("calibration_error".into(), self.calibration_error, 0.0..=0.5)?;
        self.model().map_err(|problem| unfitting("calibration", problem.to_string()))?;
        distinct("robots", self.robots.iter().map(|robot| robot.robot.to_string()))?;
        self.robots.iter().try_for_each(RobotScenario::check)
    }
}

impl RobotScenario {
    fn check(&self) -> Checked {
        let place = format!("robot {}", self.robot);
        if self.robot.as_str() == vibrissa_protocol::Name::RESERVED {
            return Err(unfitting(&place, "this name is reserved for the supervisor"));
        }
        within(format!("{place}: number of arrays"), self.arrays.len() as f64, 1.0..=ARRAYS_MAX as f64)?;
        distinct(&place, self.arrays.iter().map(|array| format!("array {}", array.array)))?;
        self.arrays.iter().try_for_each(|array| array.check(&place))?;
        self.events
            .iter()
            .enumerate()
            .try_for_each(|(index, event)| event.check(&format!("{place} events[{index}]"), self))
    }
}

impl ArrayScenario {
    fn check(&self, robot: &str) -> Checked {
        let place = format!("{robot} array {}", self.array);
        within(format!("{place}: number of whiskers"), self.whiskers.len() as f64, 1.0..=WHISKERS_MAX as f64)?;
        distinct(&place, self.whiskers.iter().map(|whisker| format!("whisker {}", whisker.whisker)))?;
        for whisker in &self.whiskers {
            let place = format!("{place} whisker {}", whisker.whisker);
            whisker.check(&place)?;
            for neighbour in &whisker.neighbours {
                if *neighbour == whisker.whisker || !self.whiskers.iter().any(|other| other.whisker == *neighbour) {
                    return Err(unfitting(&place, format!("{neighbour} is not another whisker of this array")));
                }
            }
        }
        Ok(())
    }
}

impl WhiskerScenario {
    fn check(&self, place: &str) -> Checked {
        within(format!("{place} x_mm"), self.x_mm, -100_000.0..=100_000.0)?;
        within(format!("{place} y_mm"), self.y_mm, -100_000.0..=100_000.0)?;
        length(format!("{place} length_mm"), self.length_mm)?;
        if let Some(rubber) = &self.rubber {
            let factors = [("c", rubber.c), ("a", rubber.a), ("b", rubber.b), ("elongation", rubber.elongation)];
            for (name, factor) in factors {
                within(format!("{place} rubber.{name}"), factor, 0.5..=1.5)?;
            }
        }
        within(format!("{place} length_tolerance_mm"), self.length_tolerance_mm.unwrap_or(0.0), 0.0..=20.0)?;
        within(format!("{place} strain_max"), self.strain_max.unwrap_or(FULL_SCALE_STRAIN), 1e-6..=FULL_SCALE_STRAIN)?;
        within(format!("{place} pressure_max_mpa"), self.pressure_max_mpa, 0.0..=0.2)?;
        within(format!("{place} pressure_mpa"), self.pressure_mpa, 0.0..=self.pressure_max_mpa)
    }
}

/// Checks that contacts at a ratio of 0.45 still lie beyond the chamber at the highest pressure (which then ends up
/// to 17.5 mm from the base), and that the body's cone is long enough.
fn length(place: String, length_mm: f64) -> Checked {
    within(place, length_mm, 40.0..=150.0)
}

impl Event {
    pub(crate) fn check(&self, place: &str, robot: &RobotScenario) -> Checked {
        match (self.at_s, self.at_contact) {
            (Some(at_s), None) => within(format!("{place} at_s"), at_s, 0.0..=1e9)?,
            (None, Some(_)) => {}
            (Some(_), Some(_)) | (None, None) => {
                return Err(unfitting(place, "needs either at_s or at_contact"));
            }
        }
        self.check_target(place, robot)?;
        self.change.check(place)
    }

    fn check_target(&self, place: &str, robot: &RobotScenario) -> Checked {
        let array = match &self.array {
            None => None,
            Some(name) => Some(
                robot
                    .arrays
                    .iter()
                    .find(|array| array.array == *name)
                    .ok_or_else(|| unfitting(place, format!("the robot has no array {name}")))?,
            ),
        };
        match (self.change.target(), array, self.whisker) {
            (Target::Whisker, Some(array), Some(number)) => {
                if !array.whiskers.iter().any(|whisker| whisker.whisker == number) {
                    return Err(unfitting(place, format!("array {} has no whisker {number}", array.array)));
                }
                return Ok(());
            }
            (Target::Whisker, None, _) | (Target::Whisker, _, None) => {
                return Err(unfitting(place, "affects one whisker: needs array and whisker"));
            }
            (Target::RobotOrArray, _, None) | (Target::Robot, None, None) => {}
            (Target::RobotOrArray, _, Some(_)) => {
                return Err(unfitting(place, "affects a robot or an array: must not have whisker"));
            }
            (Target::Robot, _, _) => {
                return Err(unfitting(place, "affects the whole robot: must not have array or whisker"));
            }
        }
        if self.at_contact.is_some() {
            return Err(unfitting(place, "at_contact counts the contacts of one whisker: needs at_s here"));
        }
        Ok(())
    }
}

impl Change {
    fn check(&self, place: &str) -> Checked {
        let field = |name: &str| format!("{place} {name}");
        match *self {
            Self::Trim { length_mm } => length(field("length_mm"), length_mm),
            Self::Erode { rate_mm_per_contact, until_length_mm } => {
                within(field("rate_mm_per_contact"), rate_mm_per_contact, 0.0..=10.0)?;
                length(field("until_length_mm"), until_length_mm)
            }
            Self::Leak { rate_mpa_per_s } => within(field("rate_mpa_per_s"), rate_mpa_per_s, 0.0..=10.0),
            Self::ValvesBroken
            | Self::ValvesOk
            | Self::GaugeOpen
            | Self::GaugeShort
            | Self::GaugeOk
            | Self::Replace
            | Self::Restart => Ok(()),
            Self::BaselineDrift { strain_per_contact, until_strain } => {
                within(field("strain_per_contact"), strain_per_contact, -0.01..=0.01)?;
                within(field("until_strain"), until_strain, -0.5..=0.5)?;
                if strain_per_contact * until_strain < 0.0 {
                    return Err(unfitting(place, "strain_per_contact and until_strain have opposite signs"));
                }
                Ok(())
            }
            Self::Silent { for_s } => within(field("for_s"), for_s, 0.0..=1e9),
            Self::DeflectionScale { factor } => within(field("factor"), factor, 0.1..=10.0),
            Self::GaugeSaturated { limit_strain } => within(field("limit_strain"), limit_strain, 0.0..=1.0),
            Self::Temperature { sensitivity_factor, temperature_c } => {
                within(field("sensitivity_factor"), sensitivity_factor, 0.1..=10.0)?;
                within(field("temperature_c"), temperature_c, -50.0..=100.0)
            }
            Self::Lose { fraction, for_s } | Self::Repeat { fraction, for_s } | Self::Reorder { fraction, for_s } => {
                within(field("fraction"), fraction, 0.0..=1.0)?;
                within(field("for_s"), for_s, 0.0..=1e9)
            }
            Self::SupplyLow { supply_mpa } => within(field("supply_mpa"), supply_mpa, 0.0..=1.0),
        }
    }
}
