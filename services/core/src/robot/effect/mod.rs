//! The outputs of a step: a closed set of effects, which the caller commits first and then carries out.

mod compensation;
mod health;
mod setpoint;
mod touch_test;

pub use compensation::{
    CandidateRecord, CompensationError, Decision, EndReason, ErrorBin, Origin, Refinement, RefinementOutcome, Response,
};
pub use health::{AlarmKind, Condition, Fault, Trim};
pub use setpoint::{Asked, Command, CommandState, Reason};
pub use touch_test::{ProposedTest, TestKind, TestReason, TestState, TouchTest};

pub use super::command_key::CommandKey;
use super::event::Rejection;
use crate::estimation::LengthEstimate;
use crate::policy::Case;
use crate::units::{ContactRatio, Megapascal};

/// Index of a whisker in its robot, valid until the next factsheet; see [`super::Robot::whisker`].
pub type WhiskerIndex = usize;

/// One output of [`super::Robot::step`].
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    /// Record this contact.
    Contact(ContactRecord),
    /// This contact of the message names a whisker that the factsheet does not have.
    UnknownWhisker {
        /// Position in the message.
        position: usize,
    },
    /// A touch that was expected and did not come is evidence of the whisker's length.
    MissedTouch {
        /// The whisker concerned.
        whisker: WhiskerIndex,
    },
    /// The time of this contact is far from its robot's clock. The contact counts, its time does not.
    BadTime {
        /// Position in the message.
        position: usize,
    },
    /// Record a change of condition.
    Condition {
        /// The whisker concerned.
        whisker: WhiskerIndex,
        /// Condition before the change.
        from: Condition,
        /// Condition from now on.
        to: Condition,
    },
    /// Record a fault that came, changed or went.
    Fault {
        /// The whisker concerned.
        whisker: WhiskerIndex,
        /// Fault before the change, if any.
        from: Option<Fault>,
        /// Fault from now on, if any.
        to: Option<Fault>,
    },
    /// Record a trim.
    Trim(Trim),
    /// Record a decision with all its candidates.
    Decided(Box<Decision>),
    /// Record that a compensation is over.
    Ended {
        /// Number of the compensation on this robot.
        compensation: u32,
        /// The broken whisker that it served.
        target: WhiskerIndex,
        /// Case of the paper.
        case: Case,
        /// Reason for the end.
        reason: EndReason,
        /// It never began: no operator had approved it.
        was_proposed: bool,
    },
    /// Record this setpoint, then publish it.
    Command(Box<Command>),
    /// Publish this setpoint once more.
    Resend(Box<Command>),
    /// Record the new state of a setpoint.
    CommandState {
        /// Key of the setpoint.
        command: CommandKey,
        /// The whisker concerned; `None` if it is not on the robot any more.
        whisker: Option<WhiskerIndex>,
        /// Pressure and reason of the setpoint.
        asked: Asked,
        /// New state of the setpoint.
        state: CommandState,
        /// Reason of the robot, if it rejected the setpoint.
        rejection: Option<Rejection>,
        /// Pressure reached, if the setpoint was applied.
        pressure: Option<Megapascal>,
    },
    /// Record the three responses of Eq. 35 at a compensator's contact.
    Response(Response),
    /// Record the measured compensation error.
    Error(Box<CompensationError>),
    /// Record the evaluation of a setpoint, whether it was refined or not.
    Refined(Box<Refinement>),
    /// Record that a proposed compensation was approved.
    Approved {
        /// Number of the compensation on this robot.
        compensation: u32,
    },
    /// Raise an alarm. It stands until it is cleared, and is not raised again before.
    Alarm {
        /// The whisker concerned.
        whisker: WhiskerIndex,
        /// Kind of alarm.
        kind: AlarmKind,
    },
    /// Clear an alarm, because its cause is over.
    AlarmCleared {
        /// The whisker concerned.
        whisker: WhiskerIndex,
        /// Kind of alarm.
        kind: AlarmKind,
    },
    /// Raise an alarm about the robot as a whole. It stands until it is cleared, and is not raised again before.
    RobotAlarm {
        /// Kind of alarm.
        kind: AlarmKind,
    },
    /// Clear an alarm about the robot as a whole, because its cause is over.
    RobotAlarmCleared {
        /// Kind of alarm.
        kind: AlarmKind,
    },
    /// A whisker is not on the robot any more: these alarms are cleared, and no index names it.
    Gone {
        /// Its array, by name.
        array: String,
        /// Its number in the array.
        number: u16,
        /// The alarms that stood.
        alarms: Vec<AlarmKind>,
    },
    /// Record this touch test, then publish it.
    Test(Box<TouchTest>),
    /// Record the proposal of a touch test, which waits for an operator.
    TestProposed(ProposedTest),
    /// Record the new state of a touch test.
    TestState {
        /// Key of the test or of its proposal.
        test: CommandKey,
        /// The whisker concerned; `None` if it is not on the robot any more.
        whisker: Option<WhiskerIndex>,
        /// New state of the test.
        state: TestState,
        /// Reason of the robot, if it rejected the test.
        rejection: Option<Rejection>,
    },
    /// Ask the robot for its factsheet.
    AskForFactsheet,
}

/// A contact and its evaluation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRecord {
    /// Position in the message.
    pub position: usize,
    /// The whisker concerned.
    pub whisker: WhiskerIndex,
    /// Contact ratio: the robot's, or its distance / the length estimate before the contact; `None` if the place is not
    /// known.
    pub ratio: Option<ContactRatio>,
    /// Use that was made of the contact.
    pub used: ContactUse,
    /// Log sensitivity against the prediction, if it was used.
    pub residual: Option<f64>,
    /// The residual in expected standard deviations; standard normal while nothing changes.
    pub standardised: Option<f64>,
    /// Length estimate after the contact.
    pub length: LengthEstimate,
}

/// Use that was made of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactUse {
    /// Estimation during the cold start.
    Learning,
    /// Estimation and detection.
    Used,
    /// Nothing: the pressure was on its way.
    Unsettled,
    /// Nothing: it happened before a change of the whisker or its pressure, and arrived after it.
    Late,
    /// Nothing: strain too small.
    TooWeak,
    /// Nothing: the strain is negative, so the gauge's sign is wrong.
    NegativeStrain,
    /// Nothing: the strain was at the end of the gauge's range, as the robot states.
    Saturated,
    /// Nothing: on the chamber, where the model does not hold.
    OnChamber,
    /// Nothing: the robot does not know where on the whisker it was.
    NoPlace,
    /// Nothing: its distance is beyond the estimated length by more than the errors of both explain.
    BeyondTip,
    /// Nothing: the gauge is faulty.
    GaugeFault,
    /// Nothing: the numbers would make an estimate leave its possible range.
    Implausible,
}
