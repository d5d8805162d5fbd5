//! The programs of a robot, as its row has them: a JSON list in the words of the factsheet.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::from_row::text_columns;

/// A program of a robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct RobotProgram {
    /// Kind of the program: `AGENT`, `DRIVER` or `FIRMWARE`.
    pub kind: String,
    /// Name of the program.
    pub name: String,
    /// Version of the program.
    pub version: String,
}

/// All programs of a robot that it has named.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct RobotPrograms(pub Vec<RobotProgram>);

impl From<String> for RobotPrograms {
    /// A text that is no list has no programs: they are for people, and must not hide the robot.
    fn from(text: String) -> Self {
        Self(serde_json::from_str(&text).unwrap_or_default())
    }
}

text_columns!(RobotPrograms);
