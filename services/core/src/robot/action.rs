//! Actions of operators, and the reasons for refusing them.

use crate::units::Megapascal;

/// One action of an operator on a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorAction<'a> {
    /// A proposed compensation shall begin.
    Approve {
        /// Its number on this robot.
        compensation: u32,
    },
    /// A proposed compensation shall not begin. The same compensator is not proposed again for the same target until
    /// the target is trimmed again or replaced, or the policy changes.
    Refuse {
        /// Its number on this robot.
        compensation: u32,
    },
    /// A whisker shall hold this pressure, once, and is held from then on. The compensation that it serves in ends.
    /// A setpoint that is unanswered when the robot goes offline or restarts is not sent again.
    Setpoint {
        /// Whisker that shall hold the pressure.
        whisker: Place<'a>,
        /// MPa, 0 to the lower of the factsheet's limit and [`Megapascal::EXAMINED_MAX`].
        pressure_mpa: f64,
    },
    /// No automatic setpoint goes to it, and no decision is made about it as a target, until it is released. A second
    /// hold changes nothing.
    Hold(Scope<'a>),
    /// The hold ends, and decisions are taken anew. A whisker at a manual pressure goes back to the pressure of its
    /// compensation, else to its nominal one. A setpoint that has failed is tried again.
    Release(Scope<'a>),
    /// A new whisker, as the factsheet describes it, is in the place of an old one. A hold goes on.
    Replaced(Place<'a>),
    /// A setpoint of a whisker that has failed shall be tried again at once.
    Retry(Place<'a>),
    /// The robot shall measure the length of a whisker by touches.
    TouchTest(Place<'a>),
    /// The proposed touch test of a whisker shall not be done. It is not proposed again for the same reason without new
    /// evidence.
    RefuseTouchTest(Place<'a>),
    /// The whisker is the same, but its readings must be learned anew, because its gauge was replaced, for example. See
    /// the module `rebaseline` for the state that stays.
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

/// Scope of a hold or a release.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope<'a> {
    /// All whiskers of the robot, also those that come later.
    Robot,
    /// This whisker alone.
    Whisker(Place<'a>),
}

/// Reason for refusing an action. The texts are shown to the operator.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ActionProblem {
    /// The factsheet does not list the whisker.
    #[error("there is no such whisker on the robot")]
    UnknownWhisker,
    /// The compensation never existed, has ended, or has begun already.
    #[error("there is no such compensation that waits for approval, or none any more")]
    NotProposed,
    /// The pressure is out of the range of this whisker.
    #[error("{asked_mpa} MPa is out of range: this whisker may hold 0 to {} MPa", highest.mpa())]
    PressureOutOfRange {
        /// Requested pressure, MPa.
        asked_mpa: f64,
        /// Highest pressure that the whisker may hold.
        highest: Megapascal,
    },
    /// A setpoint that cannot be sent now must not be sent later.
    #[error("the robot is not heard, so nothing was changed: a manual setpoint is sent now or not at all")]
    RobotOffline,
    /// The robot's times pass at another rate than the supervisor's.
    #[error(
        "the robot's times pass too slowly or too fast, so a setpoint would not expire in time: is t_us in microseconds?"
    )]
    WrongTimeUnit,
    /// The robot's factsheet names no touch test.
    #[error("the robot can do no touch test: its factsheet names none")]
    NoTouchTests,
    /// No touch test of this whisker waits for an operator.
    #[error("there is no touch test of this whisker that waits for an operator, or none any more")]
    NoProposedTest,
    /// A touch test of this whisker is under way.
    #[error("a touch test of this whisker is under way")]
    TestUnderWay,
    /// Held whiskers are not tested.
    #[error("the whisker is held, and held whiskers are not tested: release it first")]
    TestOfHeld,
    /// No setpoint of the whisker has failed.
    #[error("no setpoint of this whisker has failed, or it was taken since")]
    NoFailedSetpoint,
    /// Only an operator's setpoints go to a held whisker.
    #[error("the whisker is held: release it, or set its pressure by hand")]
    RetryOfHeld,
    /// The compensator of the proposed compensation is held.
    #[error("the whisker that would serve is held: release it first")]
    Held,
    /// One whisker of a held robot cannot be released.
    #[error("the whole robot is held: release the robot, then its whiskers")]
    RobotHeld,
}
