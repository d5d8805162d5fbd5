use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{LENGTH_MM, LENGTH_TOLERANCE_MM, PLACE_MM, PRESSURE_MPA, STRAIN_MAX};
use crate::name::short_text;
use crate::{
    ARRAYS_MAX, AirControl, ArrayType, BootId, Name, OnSupervisorLoss, PlaceKind, Refusal, SOFTWARE_MAX, SoftwareKind,
    Task, Timestamp, TouchTestKind, WHISKERS_MAX, check,
};

/// `factsheet`: arrays and whiskers of a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Factsheet {
    /// Boot id of the robot.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Time at which the message was written.
    pub timestamp: Timestamp,
    /// Model of the robot.
    #[serde(deserialize_with = "short_text")]
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub model: String,
    /// Behaviour of the robot without a supervisor.
    pub on_supervisor_loss: OnSupervisorLoss,
    /// Arrays of the robot, with distinct names.
    #[cfg_attr(feature = "documents", schemars(length(max = ARRAYS_MAX)))]
    #[serde(deserialize_with = "crate::shape::objects")]
    pub arrays: Vec<ArrayFacts>,
    /// Touch tests that the robot can do by itself.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "documents", schemars(length(max = 2)))]
    pub touch_tests: Vec<TouchTestKind>,
    /// Whether the robot multiplies its readings by `reading_gain`; false if absent.
    #[serde(default, skip_serializing_if = "super::contacts::is_false")]
    pub applies_gain: bool,
    /// Ways in which the robot can change the pressure of its chambers; `FILL_AND_VENT` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub air_control: Option<AirControl>,
    /// Programs of the robot that are known, for people; absent if none is.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "crate::shape::objects")]
    #[cfg_attr(feature = "documents", schemars(length(max = SOFTWARE_MAX)))]
    pub software: Vec<Software>,
}

/// A program of a robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Software {
    /// Kind of the program.
    pub kind: SoftwareKind,
    /// Name of the program.
    #[serde(deserialize_with = "short_text")]
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub name: String,
    /// Version of the program.
    #[serde(deserialize_with = "short_text")]
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub version: String,
}

/// One array of whiskers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct ArrayFacts {
    /// Name of the array.
    pub array: Name,
    /// Ways in which the array can compensate for a shortened whisker.
    #[serde(rename = "type")]
    pub array_type: ArrayType,
    /// Use of the array's readings; `RATIO` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<Task>,
    /// Whiskers of the array, with distinct numbers.
    #[cfg_attr(feature = "documents", schemars(length(max = WHISKERS_MAX)))]
    #[serde(deserialize_with = "crate::shape::objects")]
    pub whiskers: Vec<WhiskerFacts>,
}

/// One whisker as installed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct WhiskerFacts {
    /// Number of the whisker in the array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// Position of the whisker along x, in mm.
    #[cfg_attr(feature = "documents", schemars(transform = PLACE_MM.in_schema()))]
    pub x_mm: f64,
    /// Position of the whisker along y, in mm.
    #[cfg_attr(feature = "documents", schemars(transform = PLACE_MM.in_schema()))]
    pub y_mm: f64,
    /// Name of the whisker's calibration, such as `nguyen-2021`.
    #[serde(deserialize_with = "short_text")]
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub model: String,
    /// Length without the chamber's elongation, in mm.
    #[cfg_attr(feature = "documents", schemars(transform = LENGTH_MM.in_schema()))]
    pub length_mm: f64,
    /// Half the width of the 95 % interval of `length_mm`, in mm; 0.5 if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = LENGTH_TOLERANCE_MM.in_schema()))]
    pub length_tolerance_mm: Option<f64>,
    /// The chamber's nominal gauge pressure in MPa; at most `pressure_max_mpa`.
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub pressure_mpa: f64,
    /// Highest pressure that the robot permits in the chamber, in MPa.
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub pressure_max_mpa: f64,
    /// Numbers of other whiskers of the same array that can compensate for this one.
    #[cfg_attr(feature = "documents", schemars(length(max = WHISKERS_MAX)))]
    #[serde(deserialize_with = "crate::shape::wholes")]
    pub neighbours: Vec<u16>,
    /// Place of contacts that the robot can provide for this whisker; `RATIO` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<PlaceKind>,
    /// Largest strain that the whisker's gauge reads, in m/m; absent if it is not known. With `applies_gain` the supervisor
    /// chooses pressures at which the usual contacts stay below it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = STRAIN_MAX.in_schema()))]
    pub strain_max: Option<f64>,
}

impl Checked for Factsheet {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::count("touch_tests", self.touch_tests.len(), TouchTestKind::ALL.len())?;
        check::count("arrays", self.arrays.len(), ARRAYS_MAX)?;
        check::count("software", self.software.len(), SOFTWARE_MAX)?;
        check::each("arrays", &self.arrays, ArrayFacts::check)?;
        let mut names = BTreeSet::new();
        for (index, array) in self.arrays.iter().enumerate() {
            if !names.insert(&array.array) {
                return Err(duplicate("array", format!("array {}", array.array)).within("arrays", index));
            }
        }
        Ok(())
    }
}

impl ArrayFacts {
    fn check(&self) -> Result<(), Refusal> {
        check::count("whiskers", self.whiskers.len(), WHISKERS_MAX)?;
        check::each("whiskers", &self.whiskers, WhiskerFacts::check)?;
        let mut numbers = BTreeSet::new();
        for (index, whisker) in self.whiskers.iter().enumerate() {
            if !numbers.insert(whisker.whisker) {
                let again = duplicate("whisker", format!("whisker {}", whisker.whisker));
                return Err(again.within("whiskers", index));
            }
        }
        check::each("whiskers", &self.whiskers, |whisker| whisker.check_neighbours(&numbers))
    }
}

impl WhiskerFacts {
    fn check(&self) -> Result<(), Refusal> {
        PLACE_MM.check("x_mm", self.x_mm)?;
        PLACE_MM.check("y_mm", self.y_mm)?;
        LENGTH_MM.check("length_mm", self.length_mm)?;
        PRESSURE_MPA.check("pressure_mpa", self.pressure_mpa)?;
        PRESSURE_MPA.check("pressure_max_mpa", self.pressure_max_mpa)?;
        if self.pressure_mpa > self.pressure_max_mpa {
            return Err(Refusal::OutOfRange {
                path: "pressure_mpa".to_owned(),
                value: self.pressure_mpa,
                allowed: "at most pressure_max_mpa",
            });
        }
        if let Some(tolerance_mm) = self.length_tolerance_mm {
            LENGTH_TOLERANCE_MM.check("length_tolerance_mm", tolerance_mm)?;
        }
        if let Some(strain_max) = self.strain_max {
            STRAIN_MAX.check("strain_max", strain_max)?;
        }
        check::count("neighbours", self.neighbours.len(), WHISKERS_MAX)
    }

    fn check_neighbours(&self, numbers: &BTreeSet<u16>) -> Result<(), Refusal> {
        check::each("neighbours", &self.neighbours, |&neighbour| {
            let why = if neighbour == self.whisker {
                "it is the whisker itself"
            } else if !numbers.contains(&neighbour) {
                "the array has no such whisker"
            } else {
                return Ok(());
            };
            Err(Refusal::WrongNeighbour { path: String::new(), neighbour, why })
        })
    }
}

fn duplicate(path: &str, what: String) -> Refusal {
    Refusal::Duplicate { path: path.to_owned(), what }
}
