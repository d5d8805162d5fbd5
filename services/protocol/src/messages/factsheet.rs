use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{LENGTH_MM, PLACE_MM, PRESSURE_MPA};
use crate::name::short_text;
use crate::{ARRAYS_MAX, ArrayType, BootId, Name, OnSupervisorLoss, Refusal, Timestamp, WHISKERS_MAX, check, schema};

/// `factsheet`: what is on a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Factsheet {
    /// The robot's boot.
    pub boot_id: BootId,
    /// From 0 in each boot.
    #[schemars(transform = schema::exact_integer)]
    pub seq: u64,
    /// When it was written.
    pub timestamp: Timestamp,
    /// The robot's model.
    #[serde(deserialize_with = "short_text")]
    #[schemars(schema_with = "schema::identifier_field")]
    pub model: String,
    /// What the robot does when the supervisor is gone.
    pub on_supervisor_loss: OnSupervisorLoss,
    /// Each of another name.
    #[schemars(length(max = ARRAYS_MAX))]
    pub arrays: Vec<ArrayFacts>,
}

/// One array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ArrayFacts {
    /// Its name.
    pub array: Name,
    /// What it can do about a shortened whisker.
    #[serde(rename = "type")]
    pub array_type: ArrayType,
    /// Each of another number.
    #[schemars(length(max = WHISKERS_MAX))]
    pub whiskers: Vec<WhiskerFacts>,
}

/// One whisker as it was built in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WhiskerFacts {
    /// Its number in the array.
    pub whisker: u16,
    /// Where it stands, in mm.
    #[schemars(transform = PLACE_MM.in_schema())]
    pub x_mm: f64,
    /// Where it stands, in mm.
    #[schemars(transform = PLACE_MM.in_schema())]
    pub y_mm: f64,
    /// The calibration to use, such as `nguyen-2021`.
    #[serde(deserialize_with = "short_text")]
    #[schemars(schema_with = "schema::identifier_field")]
    pub model: String,
    /// Its length without the chamber's elongation, in mm.
    #[schemars(transform = LENGTH_MM.in_schema())]
    pub length_mm: f64,
    /// The chamber's nominal gauge pressure in MPa; at most `pressure_max_mpa`.
    #[schemars(transform = PRESSURE_MPA.in_schema())]
    pub pressure_mpa: f64,
    /// The highest pressure that the robot lets into the chamber, in MPa.
    #[schemars(transform = PRESSURE_MPA.in_schema())]
    pub pressure_max_mpa: f64,
    /// Whiskers of the same array that can take its place: numbers of others that the array has.
    #[schemars(length(max = WHISKERS_MAX))]
    pub neighbours: Vec<u16>,
}

impl Checked for Factsheet {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::count("arrays", self.arrays.len(), ARRAYS_MAX)?;
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
