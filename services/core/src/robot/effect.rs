//! The outputs of a step: a closed set of effects, which the caller commits first and then carries out.

use borsh::{BorshDeserialize, BorshSerialize};

use super::event::{GaugeState, Rejection};
use crate::estimation::LengthEstimate;
use crate::mechanics::CONTACT_RATIOS;
use crate::policy::{Case, Refused};
use crate::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

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
    /// This contact of the message has an implausible time and is ignored.
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
        /// Case of the paper.
        case: Case,
        /// Reason for the end.
        reason: EndReason,
    },
    /// Record this setpoint, then publish it.
    Command(Box<Command>),
    /// Publish this setpoint once more.
    Resend(Box<Command>),
    /// Record the new state of a setpoint.
    CommandState {
        /// Key of the setpoint.
        command: CommandKey,
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
    /// Nothing: strain too small.
    TooWeak,
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

/// Mechanical condition of a whisker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum Condition {
    /// Cold start: offset and noise are being learned.
    #[default]
    Learning,
    /// As long and as sensitive as the factsheet says.
    Healthy,
    /// The detector has raised an alarm that is being looked into.
    Suspected,
    /// Shorter than whole, by a cut.
    Trimmed,
    /// Becoming shorter by wear.
    Eroding,
    /// Less sensitive, which no trim explains.
    SensitivityLoss,
}

/// Reason why a whisker cannot be relied on, whatever its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Fault {
    /// No contact or status of it was received in time, or the robot is not connected.
    Stale,
    /// Its gauge is faulty: reported by the robot, or found from its contacts.
    Gauge(GaugeState),
    /// Its pressure is not held.
    Leak,
    /// Its regulator is out of order.
    Regulator,
    /// Too little air to fill it.
    SupplyLow,
}

/// A detected trim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trim {
    /// Number on this robot.
    pub id: u32,
    /// The whisker concerned.
    pub whisker: WhiskerIndex,
    /// Length before the trim.
    pub length_before: Millimetre,
    /// Length estimate after the trim.
    pub length_after: LengthEstimate,
    /// Contacts from the likeliest moment of the cut to the decision.
    pub contacts_to_detect: u32,
}

/// A decision about one broken whisker.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// Number of the compensation on this robot.
    pub compensation: u32,
    /// The broken whisker.
    pub target: WhiskerIndex,
    /// Length of the target while it was whole.
    pub target_length: Millimetre,
    /// Nominal pressure of the target.
    pub target_pressure: Megapascal,
    /// All candidates that were evaluated: the target itself and, in a Type 1 array, its neighbours.
    pub candidates: Vec<CandidateRecord>,
    /// Position of the chosen one in `candidates`; none if no one can serve.
    pub chosen: Option<usize>,
    /// Whether the chosen one waits for an operator's approval.
    pub proposed: bool,
}

/// A candidate of a decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidateRecord {
    /// Whisker that is the candidate.
    pub whisker: WhiskerIndex,
    /// Case of the paper.
    pub case: Case,
    /// Length estimate of the candidate.
    pub length: LengthEstimate,
    /// Pressure before: the nominal one, whatever it may hold for somebody else.
    pub pressure_before: Megapascal,
    /// Pressure to hold; clamped to the range if the best one lies outside.
    pub pressure: Option<Megapascal>,
    /// Predicted error by contact ratio.
    pub predicted_error_by_ratio: Option<[f64; CONTACT_RATIOS.len()]>,
    /// Predicted mean error (Eq. 35), as a ratio.
    pub predicted_error: Option<f64>,
    /// 95 % interval of the mean error, from the uncertainty of lengths, responses and calibration.
    pub predicted_error_interval: Option<(f64, f64)>,
    /// Whether it would give up its own role.
    pub gives_up_own_role: bool,
    /// Reason why the candidate was not chosen.
    pub refused: Option<Refused>,
}

/// Reason for the end of a compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum EndReason {
    /// A factsheet does not have one of the two whiskers any more, or not as neighbours.
    LayoutChanged,
    /// The target was trimmed again.
    TargetTrimmedAgain,
    /// The compensator is broken itself.
    CompensatorBroken,
    /// A better assignment was found.
    Reassigned,
    /// Its setpoint failed for good.
    SetpointFailed,
    /// One of the two whiskers was replaced by a new one.
    Replaced,
    /// It was proposed, and an operator refused it.
    Refused,
    /// An operator set its compensator's pressure by hand, or had it learned anew before the approval.
    Operator,
}

/// Names a setpoint on its robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, BorshSerialize, BorshDeserialize)]
pub struct CommandKey {
    /// Epoch of the supervisor that decided it.
    pub epoch: u64,
    /// Number on this robot.
    pub version: u64,
}

/// A setpoint to publish.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Command {
    /// Epoch and version, which identify the setpoint.
    pub key: CommandKey,
    /// Whisker that shall hold the pressure.
    pub whisker: WhiskerIndex,
    /// The only boot that may take it.
    pub robot_boot_id: String,
    /// Pressure to hold.
    pub pressure: Megapascal,
    /// Rate of change on the way to the pressure, MPa/s.
    pub slew_mpa_per_s: f64,
    /// Time of issue by the supervisor's clock.
    pub issued: Micros,
    /// Time by the robot's clock after which the robot rejects the setpoint.
    pub expires: Micros,
    /// Reason for the setpoint.
    pub reason: Reason,
    /// The compensation that it belongs to.
    pub compensation: Option<u32>,
    /// Residual gain at [`CONTACT_RATIOS`].
    pub gain: Option<[f64; CONTACT_RATIOS.len()]>,
}

/// A request for touches that measure a whisker's length or response.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct TouchTest {
    /// Epoch and version, which identify the test; the version is of the same series as those of setpoints.
    pub key: CommandKey,
    /// Whisker to be touched.
    pub whisker: WhiskerIndex,
    /// The only boot that may take it.
    pub robot_boot_id: String,
    /// Kind of test.
    pub kind: TestKind,
    /// Distances from the base at which to touch, mm, for [`TestKind::Wall`].
    pub distances_mm: Vec<f64>,
    /// Deflections at which to touch, mm, for [`TestKind::Wall`].
    pub deflections_mm: Vec<f64>,
    /// Number of contacts.
    pub contacts: u16,
    /// Time of issue by the supervisor's clock.
    pub issued: Micros,
    /// Time by the robot's clock after which the robot rejects the test.
    pub expires: Micros,
    /// Reason for the test.
    pub reason: TestReason,
}

/// A touch test that an operator can start, in mode ADVISE.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProposedTest {
    /// Identifies the proposal. The version is of the series of setpoints; the test itself gets the next one.
    pub key: CommandKey,
    /// Whisker to be touched.
    pub whisker: WhiskerIndex,
    /// Kind of test.
    pub kind: TestKind,
    /// Number of contacts.
    pub contacts: u16,
    /// Reason for the test.
    pub reason: TestReason,
}

/// Kind of touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum TestKind {
    /// Sweeps an object so that the contact leaves over the tip.
    Tip,
    /// Presses against a known surface at given distances and deflections.
    Wall,
}

/// Reason for a touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum TestReason {
    /// The reach of the whisker has changed.
    Suspicion,
    /// A setpoint of a compensation was applied: its error is to be measured.
    Setpoint,
    /// An operator asked for it.
    Operator,
    /// The whisker was not touched for long, or the robot has started anew: it may have been cut meanwhile.
    Pause,
    /// The interval since the last test is over.
    Schedule,
    /// Its sensitivity rose, and its contacts left open whether it was cut or its gain wanders.
    Change,
}

/// State of a touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum TestState {
    /// Requested; not answered yet.
    Pending,
    /// The robot will do it.
    Accepted,
    /// The robot is at it.
    Running,
    /// All contacts are sent.
    Done,
    /// The robot will not do it.
    Rejected,
    /// The robot could not do it.
    Failed,
    /// No answer or no end in time.
    Expired,
    /// The robot started anew before the end, or the whisker is not on it any more.
    Abandoned,
    /// It waits for an operator, in mode ADVISE; nothing was sent.
    Proposed,
    /// It was proposed, and is requested now or not needed any more.
    Withdrawn,
    /// It was proposed, and an operator refused it.
    Refused,
}

/// Reason for a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Reason {
    /// A compensation begins.
    Compensation(Case),
    /// A compensation is over: back to the nominal pressure.
    Release,
    /// A compensation goes on at another pressure, or with another gain.
    Refinement,
    /// An operator asked for it.
    Operator,
}

/// State of a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum CommandState {
    /// Decided; not answered yet.
    Pending,
    /// The robot has it.
    Received,
    /// The robot is moving there.
    Applying,
    /// The robot is there.
    Applied,
    /// The robot will not take it.
    Rejected,
    /// The robot could not reach it.
    Failed,
    /// A newer one took its place.
    Superseded,
    /// No answer before its expiry.
    Expired,
    /// The robot started anew before it answered.
    Abandoned,
}

/// The responses of Eq. 35 at one contact of a compensator, at the same contact ratio and deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Position of the contact in the message.
    pub position: usize,
    /// Number of the compensation on this robot.
    pub compensation: u32,
    /// Contact ratio of the contact.
    pub ratio: ContactRatio,
    /// Deflection of the contact.
    pub deflection: Millimetre,
    /// The compensator's strain after the change of pressure: measured, this contact.
    pub after: Strain,
    /// The compensator's strain before the change of pressure.
    pub before: f64,
    /// Source of `before`.
    pub before_origin: Origin,
    /// The target's strain while it was whole.
    pub target: f64,
    /// Source of `target`.
    pub target_origin: Origin,
}

/// Source of a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Averaged from contacts in the same contact-ratio bin.
    Measured,
    /// The model, with the whisker's learned offset.
    Model,
}

/// The compensation error, from sensitivities averaged within contact-ratio bins.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationError {
    /// Number of the compensation on this robot.
    pub compensation: u32,
    /// Pressure at which the error is measured.
    pub pressure: Megapascal,
    /// Contacts of the compensator since the pressure was applied.
    pub contacts: u32,
    /// The bins that are measured.
    pub bins: Vec<ErrorBin>,
    /// Mean over the contact ratios about which contacts tell, and over the cases that they leave open, as a ratio.
    pub mean: f64,
    /// Standard deviation of the mean. It includes what the gain may have wandered.
    pub sd: f64,
    /// The same with the gain in force applied, over all contact ratios, with its standard deviation: from
    /// contacts since that gain was published. None while these are too few.
    pub with_gain: Option<(f64, f64)>,
}

/// An evaluation of a compensation's setpoint: errors are means of Eq. 35 over the contact ratios, as ratios.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Number of the compensation on this robot.
    pub compensation: u32,
    /// Contacts of the compensator at the evaluated pressure.
    pub contacts: u32,
    /// Outcome of the evaluation.
    pub outcome: RefinementOutcome,
    /// Pressure held until now.
    pub pressure_from: Megapascal,
    /// The best pressure; none where the mechanics have no answer.
    pub pressure_best: Option<Megapascal>,
    /// Measured error, from smoothed responses.
    pub error: f64,
    /// Standard deviation of `error`.
    pub error_sd: f64,
    /// Expected error at the best pressure, with its standard deviation.
    pub error_best: Option<(f64, f64)>,
    /// Error with the published gain.
    pub error_with_gain: f64,
    /// Expected error with a gain from these contacts.
    pub error_with_own_gain: f64,
    /// Whether a new gain was published.
    pub gain_published: bool,
}

/// Outcome of the evaluation of a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefinementOutcome {
    /// The pressure is moved to the best one.
    Refined,
    /// It stays: the best one is nearer than a regulator's dither.
    HeldDither,
    /// It stays: the best one is hardly better.
    HeldMargin,
    /// It stays: the contacts do not show yet that the best one is better.
    HeldUncertain,
    /// It stays: no steps are left.
    HeldSteps,
    /// It stays: the mechanics have no answer.
    HeldUnpredictable,
}

/// Eq. 35 in one contact-ratio bin, with sensitivities in strain per mm of deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorBin {
    /// Centre of the bin.
    pub ratio: f64,
    /// Contacts of the compensator in it.
    pub contacts: u32,
    /// Sensitivity of the compensator at its new pressure.
    pub after_per_mm: f64,
    /// Sensitivity of the compensator at its pressure before.
    pub before_per_mm: f64,
    /// Source of `before_per_mm`.
    pub before_origin: Origin,
    /// Sensitivity of the target while it was whole.
    pub target_per_mm: f64,
    /// Source of `target_per_mm`.
    pub target_origin: Origin,
    /// Eq. 35 as a ratio.
    pub error: f64,
    /// Standard deviation of `error`.
    pub sd: f64,
}

/// Kind of alarm. An alarm stands until the event that its kind names here, or until the whisker is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum AlarmKind {
    /// A trimmed whisker that no one can compensate for: until it is served or proposed to be, is replaced, or is not
    /// trimmed any more.
    Uncompensated,
    /// A setpoint failed for good: until it is tried anew, which a new boot, a new whisker and an operator do.
    SetpointFailed,
    /// A whisker has lost sensitivity, which no trim explains: until its condition is another.
    SensitivityLoss,
    /// A whisker erodes: until its condition is another.
    Eroding,
    /// The whole array reads more or less than before: deflection mis-scaled, or temperature. The shift is taken out.
    /// Until the whisker of the alarm has had a thousand contacts without more of it, or is learned anew.
    ArrayShift,
    /// The gauge's baseline drifts. The drift is followed and taken out, but the gauge stays suspect: until an operator
    /// has it learned anew, or replaces the whisker.
    BaselineDrift,
    /// A fault: until it goes or becomes another. A whisker has [`Fault::Stale`] as an alarm only while other whiskers of
    /// its robot are heard.
    Fault(Fault),
    /// A compensation for this whisker waits for approval: until it is approved, refused or over.
    Proposed,
    /// Contacts near the tip have failed to come for so long that chance does not explain it: the whisker is cut and the
    /// robot divides distances by an old length or knows only distances, or the robot has changed its habits. Until such
    /// contacts come again, a touch test decides, or a trim is called.
    ReachLost,
    /// No whisker of the robot is heard, or the robot is not connected: one alarm about the robot, until a whisker is
    /// heard again.
    RobotSilent,
}
