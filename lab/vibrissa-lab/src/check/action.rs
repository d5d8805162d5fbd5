//! Actions of the helper, a person or a script at the robot.

use std::fmt;
use std::time::Duration;

use vibrissa_protocol::Name;

/// A whisker, as `ARRAY/NUMBER`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spot {
    /// Name of the array.
    pub array: Name,
    /// Number of the whisker in its array.
    pub whisker: u16,
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.array, self.whisker)
    }
}

/// Something that the helper must do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Action {
    /// Cut the robot's power and restore it.
    CutPower,
    /// Close the air supply of this whisker's chamber.
    CloseSupply(Spot),
    /// Open it again.
    OpenSupply(Spot),
    /// Touch whiskers until [`Action::Rest`].
    Touch,
    /// No longer touch whiskers, or as often as before.
    Rest,
    /// Stop the robot's program in an orderly way.
    Stop,
    /// Start the robot's program again.
    Start,
    /// Touch this whisker at the same place again and again, until [`Action::Rest`].
    TouchPlace(Spot),
}

impl Action {
    /// Name of the action, the first argument of an assistant.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::CutPower => "cut-power",
            Self::CloseSupply(_) => "close-supply",
            Self::OpenSupply(_) => "open-supply",
            Self::Touch => "touch",
            Self::Rest => "rest",
            Self::Stop => "stop",
            Self::Start => "start",
            Self::TouchPlace(_) => "touch-place",
        }
    }

    /// The whisker that the action concerns, the second argument of an assistant.
    #[must_use]
    pub fn spot(&self) -> Option<&Spot> {
        match self {
            Self::CloseSupply(spot) | Self::OpenSupply(spot) | Self::TouchPlace(spot) => Some(spot),
            Self::CutPower | Self::Touch | Self::Rest | Self::Stop | Self::Start => None,
        }
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CutPower => f.write_str("cut the robot's power and restore it"),
            Self::CloseSupply(spot) => write!(f, "close the air supply of {spot}, and leave it closed"),
            Self::OpenSupply(spot) => write!(f, "open the air supply of {spot} again"),
            Self::Touch => f.write_str("touch whiskers again and again, until you are told to stop"),
            Self::Rest => f.write_str("stop touching"),
            Self::Stop => {
                f.write_str("stop the robot's program in an orderly way (not by its power), for instance with SIGTERM")
            }
            Self::Start => f.write_str("start the robot's program again"),
            Self::TouchPlace(spot) => {
                write!(f, "touch {spot} at the same place again and again, near its middle, until you are told to stop")
            }
        }
    }
}

/// Progress of a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Progress {
    /// A step begins.
    Step(&'static str),
    /// The helper must do this within the time.
    Act(Action, Duration),
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(what) => f.write_str(what),
            Self::Act(action, limit) => write!(f, "NOW {action} (within {} s)", limit.as_secs()),
        }
    }
}
