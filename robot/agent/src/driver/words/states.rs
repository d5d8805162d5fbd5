//! Words of a driver about itself.

use serde::Deserialize;
use vibrissa_protocol::Name;

/// `hello`: the driver introduces itself.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Hello {
    /// Version of the interface.
    pub version: u32,
    /// Name of the driver, for logs and for the factsheet.
    #[serde(default)]
    pub name: String,
    /// Version of the driver's program on a computer.
    #[serde(default)]
    pub software_version: Option<String>,
    /// Version of the program on the board.
    #[serde(default)]
    pub firmware_version: Option<String>,
    /// Source of a board's configuration.
    #[serde(default)]
    pub configuration: Option<Source>,
}

/// Source of a board's configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Source {
    /// That of a new board.
    Default,
    /// Its EEPROM.
    Stored,
    /// None: the record in its EEPROM is damaged, or of another program.
    Broken,
    /// One of a later version.
    #[serde(other)]
    Other,
}

/// `configured`: a board has taken a line that configures it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct Configured {
    /// State of the changes.
    pub changes: Changes,
}

/// State of the changes of a board's configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Changes {
    /// Its valves are closed, and it sends no readings, until they are saved or discarded.
    Unsaved,
    /// It works with them.
    Saved,
    /// It works with the configuration before.
    Discarded,
}

/// `configuration`: a part of a board's configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct Configuration {
    /// Its source, in the first line.
    #[serde(default)]
    pub record: Option<Source>,
}

/// `error` of a board: it has refused a line of a person.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Problem {
    /// Description of the error.
    pub problem: String,
    /// Array of the whisker whose order was refused.
    pub array: Option<Name>,
    /// Number of that whisker; absent if the line was no order.
    pub whisker: Option<u16>,
}

/// `driving`: the robot moves from now on, or stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct Driving {
    /// Whether it moves.
    pub driving: bool,
}

/// `task`: the robot is in a task from now on, or not any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct Task {
    /// Whether it is in a task.
    pub task: bool,
}

/// `test_state`: progress of a touch test.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct TestState {
    /// The test.
    pub test_id: String,
    /// Its state.
    pub state: Progress,
}

/// State of a touch test, as a driver knows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Progress {
    /// The driver has begun.
    Running,
    /// All touches are done.
    Done,
    /// The driver cannot finish.
    Failed,
}
