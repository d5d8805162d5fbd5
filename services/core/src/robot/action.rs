//! What operators may do, and why it may not be done.

use crate::units::Megapascal;

/// One thing that an operator asks of a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorAction<'a> {
    /// A proposed compensation shall begin.
    Approve {
        /// Its number on this robot.
        compensation: u32,
    },
    /// A proposed compensation shall not begin. The same compensator is not proposed again for the same target until
    /// that is trimmed again or replaced, or the policy changes.
    Refuse {
        /// Its number on this robot.
        compensation: u32,
    },
    /// A whisker shall hold this pressure, once, and is held from then on. The compensation that it serves in ends.
    /// What the robot has not answered when it goes offline or starts anew is not sent again.
    Setpoint {
        /// Which whisker.
        whisker: Place<'a>,
        /// MPa, 0 to the lower of the factsheet's limit and [`Megapascal::EXAMINED_MAX`].
        pressure_mpa: f64,
    },
    /// No automatic setpoint goes to it, and nothing is decided about it as a target, until it is released. Holding
    /// what is held already changes nothing.
    Hold(Scope<'a>),
    /// The hold ends, and decisions are taken anew. What held a manual pressure goes back to the pressure that it shall
    /// hold: that of its compensation, else its nominal one. A setpoint that had failed for good is tried anew.
    Release(Scope<'a>),
    /// Somebody has put a new whisker in the place of an old one, as the factsheet describes it. A hold goes on.
    Replaced(Place<'a>),
    /// The whisker is the same, but its readings are to be learned anew: its gauge was glued anew, say. See
    /// `rebaseline` for what stays.
    Rebaseline(Place<'a>),
}

/// Names a whisker on its robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place<'a> {
    /// Name of the array.
    pub array: &'a str,
    /// Number of the whisker.
    pub whisker: u16,
}

/// What is held or released.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope<'a> {
    /// All whiskers of the robot, also those that come later.
    Robot,
    /// One whisker.
    Whisker(Place<'a>),
}

/// Why an action is not done. The texts are for people.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ActionProblem {
    /// The factsheet does not have it.
    #[error("there is no such whisker on the robot")]
    UnknownWhisker,
    /// It never was, it is over, or it has begun already.
    #[error("there is no such compensation that waits for approval, or none any more")]
    NotProposed,
    /// Another pressure is needed.
    #[error("{asked_mpa} MPa is out of range: this whisker may hold 0 to {} MPa", highest.mpa())]
    PressureOutOfRange {
        /// What was asked, MPa.
        asked_mpa: f64,
        /// The highest that it may hold.
        highest: Megapascal,
    },
    /// A setpoint that cannot be sent now must not be sent later.
    #[error(
        "the robot is offline or silent, or has not said its time yet: a manual setpoint is sent now or not at all"
    )]
    RobotOffline,
    /// The compensator of what is to be approved is held.
    #[error("the whisker that would serve is held: release it first")]
    Held,
    /// One whisker of a held robot cannot be released.
    #[error("the whole robot is held: release the robot, then its whiskers")]
    RobotHeld,
}
