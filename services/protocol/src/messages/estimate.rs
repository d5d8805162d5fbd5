use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{LENGTH_BOUND_MM, LENGTH_MM, PRESSURE_MPA};
use crate::{ARRAYS_MAX, BootId, Name, Refusal, Timestamp, WHISKERS_MAX, WhiskerCondition, check};

/// The rule about a length and its interval, in refusals.
pub(crate) const WITHIN_INTERVAL: &str = "from length_low_mm to length_high_mm";

/// `estimate`: present lengths of a robot's whiskers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Epoch of the supervisor, as in setpoints; (`epoch`, `version`) orders the estimates of a robot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub epoch: u64,
    /// Version of the estimate; it rises within an epoch. Versions of setpoints are counted apart.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub version: u64,
    /// Time at which the message was written, by the supervisor's clock.
    pub timestamp: Timestamp,
    /// One entry for each whisker of the factsheet. If the message would become too long, whiskers that work as
    /// installed are left out. A whisker that is not listed has no estimate.
    #[cfg_attr(feature = "documents", schemars(length(max = ARRAYS_MAX * WHISKERS_MAX)))]
    #[serde(deserialize_with = "crate::shape::objects")]
    pub whiskers: Vec<WhiskerEstimate>,
}

/// Present length and state of one whisker, as the supervisor knows them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct WhiskerEstimate {
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// Most likely present length without the chamber's elongation, in mm. Contact ratio = contact distance / this
    /// length.
    #[cfg_attr(feature = "documents", schemars(transform = LENGTH_MM.in_schema()))]
    pub length_mm: f64,
    /// Lower bound of the 95 % interval of the length, in mm; at most `length_mm`.
    #[cfg_attr(feature = "documents", schemars(transform = LENGTH_BOUND_MM.in_schema()))]
    pub length_low_mm: f64,
    /// Upper bound of the 95 % interval of the length, in mm; at least `length_mm`.
    #[cfg_attr(feature = "documents", schemars(transform = LENGTH_BOUND_MM.in_schema()))]
    pub length_high_mm: f64,
    /// Mechanical condition of the whisker.
    pub condition: WhiskerCondition,
    /// The setpoint in force as the supervisor knows it: gauge pressure in MPa.
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub pressure_mpa: f64,
    /// Correction in force: pairs of contact ratio and factor on the whisker's strain, by rising ratio, for
    /// interpolation. Empty if the strain needs none. It is the gain of the setpoint that the robot applied last.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::gain"))]
    pub gain: Vec<(f64, f64)>,
    /// Factor on each reading of the whisker that belongs to `pressure_mpa`; absent = 1. It is the `reading_gain` of the
    /// setpoint that the robot applied last. A robot uses it only before its first APPLIED of this boot for the whisker, and
    /// only while the pressure that it holds by itself is `pressure_mpa`. Never sent to robots without `applies_gain`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = crate::check::READING_GAIN.in_schema()))]
    pub reading_gain: Option<f64>,
    /// Response of the whisker at `pressure_mpa`, without any gain: distance of a touch from the base in mm, strain of
    /// the gauge per mm of deflection at 3 mm, and its standard deviation with that of a contact's strain. By rising
    /// distance and falling strain, from the chamber to the tip, for interpolation of the strain's logarithm. So a
    /// robot finds the place of a touch from its strain and deflection. Empty if it is not known, or if the message
    /// would become too long.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::response"))]
    pub response: Vec<(f64, f64, f64)>,
}

impl Estimate {
    /// Whether the estimate is newer than another one with this epoch and version. A robot ignores the others.
    #[must_use]
    pub fn is_newer_than(&self, other: Option<(u64, u64)>) -> bool {
        other.is_none_or(|other| (self.epoch, self.version) > other)
    }
}

impl WhiskerEstimate {
    fn check(&self) -> Result<(), Refusal> {
        LENGTH_MM.check("length_mm", self.length_mm)?;
        LENGTH_BOUND_MM.check("length_low_mm", self.length_low_mm)?;
        LENGTH_BOUND_MM.check("length_high_mm", self.length_high_mm)?;
        if !(self.length_low_mm..=self.length_high_mm).contains(&self.length_mm) {
            let (path, value) = ("length_mm".to_owned(), self.length_mm);
            return Err(Refusal::OutOfRange { path, value, allowed: WITHIN_INTERVAL });
        }
        PRESSURE_MPA.check("pressure_mpa", self.pressure_mpa)?;
        check::gain(&self.gain)?;
        check::reading_gain(self.reading_gain)?;
        check::response(&self.response)
    }
}

impl Checked for Estimate {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::integer("epoch", self.epoch)?;
        check::integer("version", self.version)?;
        check::count("whiskers", self.whiskers.len(), ARRAYS_MAX * WHISKERS_MAX)?;
        check::each("whiskers", &self.whiskers, WhiskerEstimate::check)?;
        let mut known = BTreeSet::new();
        for (index, one) in self.whiskers.iter().enumerate() {
            if !known.insert((&one.array, one.whisker)) {
                let what = format!("whisker {} of array {}", one.whisker, one.array);
                return Err(Refusal::Duplicate { path: "whisker".to_owned(), what }.within("whiskers", index));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_higher_epoch_or_a_higher_version_of_the_same_epoch_is_newer() {
        let estimate = |epoch, version| Estimate {
            boot_id: BootId::new("s").unwrap(),
            seq: 0,
            epoch,
            version,
            timestamp: Timestamp(0),
            whiskers: Vec::new(),
        };
        for (epoch, version, is_newer) in [(7, 4, true), (7, 3, false), (7, 2, false), (8, 0, true), (6, 9, false)] {
            assert_eq!(estimate(epoch, version).is_newer_than(Some((7, 3))), is_newer, "{epoch} {version}");
        }
        assert!(estimate(0, 0).is_newer_than(None));
    }
}
