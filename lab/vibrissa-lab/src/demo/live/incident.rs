//! Incidents of the demo's whiskers: parsed from a typed line and from JSON.

use std::fmt;
use std::str::FromStr;

use vibrissa_protocol::Name;

/// A whisker of the demo's fleet; written `ROBOT/ARRAY/NUMBER`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::demo) struct WhiskerName {
    /// Name of the robot.
    pub robot: Name,
    /// Name of the array.
    pub array: Name,
    /// Number of the whisker in its array.
    pub whisker: u16,
}

impl fmt::Display for WhiskerName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.robot, self.array, self.whisker)
    }
}

impl FromStr for WhiskerName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || format!("{text:?} is not a whisker: write ROBOT/ARRAY/NUMBER, such as crawler-2/nose/0");
        let mut parts = text.split('/');
        let (Some(robot), Some(array), Some(whisker), None) = (parts.next(), parts.next(), parts.next(), parts.next())
        else {
            return Err(bad());
        };
        Ok(Self {
            robot: Name::robot(robot).map_err(|_| bad())?,
            array: Name::new(array).map_err(|_| bad())?,
            whisker: whisker.parse().map_err(|_| bad())?,
        })
    }
}

/// An incident of a whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::demo) enum Incident {
    /// It loses this length at once, mm.
    Cut {
        /// Lost length, mm.
        by_mm: f64,
    },
    /// Each contact wears it off from now on.
    Erode,
    /// Its chamber leaks from now on.
    Leak,
    /// The whiskers of its array get warmer, or colder if negative.
    Heat {
        /// Change of the temperature, K.
        by_k: f64,
    },
    /// A new whisker is installed in its place and reported to the supervisor.
    Replace,
}
