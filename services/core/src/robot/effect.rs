//! What a step says must be done: the closed set of outputs, to be committed first and then carried out.

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
    /// This contact of the message says a time that cannot be right: nothing is made of it.
    BadTime {
        /// Position in the message.
        position: usize,
    },
    /// Record a change of condition.
    Condition {
        /// Whose.
        whisker: WhiskerIndex,
        /// Before.
        from: Condition,
        /// Now.
        to: Condition,
    },
    /// Record a fault that came, changed or went.
    Fault {
        /// Whose.
        whisker: WhiskerIndex,
        /// Before.
        from: Option<Fault>,
        /// Now.
        to: Option<Fault>,
    },
    /// Record a trim.
    Trim(Trim),
    /// Record a decision with all its candidates.
    Decided(Box<Decision>),
    /// Record that a compensation is over.
    Ended {
        /// Which.
        compensation: u32,
        /// Its case.
        case: Case,
        /// Why.
        reason: EndReason,
    },
    /// Record this setpoint, then publish it.
    Command(Box<Command>),
    /// Publish this setpoint once more.
    Resend(Box<Command>),
    /// Record what became of a setpoint.
    CommandState {
        /// Which.
        command: CommandKey,
        /// What.
        state: CommandState,
        /// Why, if the robot refused it.
        rejection: Option<Rejection>,
        /// The pressure that was reached, if applied.
        pressure: Option<Megapascal>,
    },
    /// Record the three responses of Eq. 35 at a compensator's contact.
    Response(Response),
    /// Record the measured compensation error.
    Error(Box<CompensationError>),
    /// Record a look at a setpoint, whether it was refined or not.
    Refined(Box<Refinement>),
    /// Record that a proposed compensation was approved.
    Approved {
        /// Which.
        compensation: u32,
    },
    /// Tell people. It stands until it is cleared, and is not raised again before.
    Alarm {
        /// About which whisker.
        whisker: WhiskerIndex,
        /// What.
        kind: AlarmKind,
    },
    /// Tell people that the cause of an alarm is over.
    AlarmCleared {
        /// About which whisker.
        whisker: WhiskerIndex,
        /// What.
        kind: AlarmKind,
    },
    /// A whisker is not on the robot any more: these alarms are cleared, and no index names it.
    Gone {
        /// Its array, by name.
        array: String,
        /// Its number.
        number: u16,
        /// The alarms that stood.
        alarms: Vec<AlarmKind>,
    },
    /// Ask the robot for its factsheet.
    AskForFactsheet,
}

/// A contact with what was made of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRecord {
    /// Position in the message.
    pub position: usize,
    /// Whose.
    pub whisker: WhiskerIndex,
    /// What it was used for.
    pub used: ContactUse,
    /// Log sensitivity against the prediction, if it was used.
    pub residual: Option<f64>,
    /// The residual in standard deviations of what was expected; standard normal while nothing changes.
    pub standardised: Option<f64>,
    /// Length after it.
    pub length: LengthEstimate,
}

/// What a contact was used for.
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
    /// Nothing: the gauge is not to be trusted.
    GaugeFault,
    /// Nothing: with these numbers an estimate would leave the range of what can be.
    Implausible,
}

/// Mechanical condition of a whisker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum Condition {
    /// Cold start.
    #[default]
    Learning,
    /// As the factsheet says.
    Healthy,
    /// The detector has raised an alarm that is being looked into.
    Suspected,
    /// Shorter than whole, by a cut.
    Trimmed,
    /// Becoming shorter.
    Eroding,
    /// Less sensitive, which no trim explains.
    SensitivityLoss,
}

/// Why a whisker cannot be relied on at all, whatever its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Fault {
    /// Nothing was heard of it.
    Stale,
    /// Its gauge: as the robot says, or as its contacts show.
    Gauge(GaugeState),
    /// Its pressure is not held.
    Leak,
    /// Its regulator is out of order.
    Regulator,
    /// Too little air to fill it.
    SupplyLow,
}

/// A trim that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trim {
    /// Number on this robot.
    pub id: u32,
    /// Whose.
    pub whisker: WhiskerIndex,
    /// Before.
    pub length_before: Millimetre,
    /// Now.
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
    /// Its whole length.
    pub target_length: Millimetre,
    /// Its nominal pressure.
    pub target_pressure: Megapascal,
    /// Who was asked, and what came of it.
    pub candidates: Vec<CandidateRecord>,
    /// Position of the chosen one in `candidates`; none if no one can serve.
    pub chosen: Option<usize>,
    /// Whether the chosen one waits for an operator's approval.
    pub proposed: bool,
}

/// A candidate of a decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidateRecord {
    /// Who.
    pub whisker: WhiskerIndex,
    /// Case of the paper.
    pub case: Case,
    /// Its length.
    pub length: LengthEstimate,
    /// Pressure before: the nominal one, whatever it may hold for somebody else.
    pub pressure_before: Megapascal,
    /// Pressure to hold, or the clamped one where there is none in range.
    pub pressure: Option<Megapascal>,
    /// Predicted error by contact ratio.
    pub predicted_error_by_ratio: Option<[f64; CONTACT_RATIOS.len()]>,
    /// Predicted mean error (Eq. 35), as a ratio.
    pub predicted_error: Option<f64>,
    /// Its 95 % interval, with all that is not known of the whiskers.
    pub predicted_error_interval: Option<(f64, f64)>,
    /// Whether it would give up its own role.
    pub gives_up_own_role: bool,
    /// Why it was not chosen.
    pub refused: Option<Refused>,
}

/// Why a compensation ended.
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
    /// Names it.
    pub key: CommandKey,
    /// For whom.
    pub whisker: WhiskerIndex,
    /// The only boot that may take it.
    pub robot_boot_id: String,
    /// Pressure to hold.
    pub pressure: Megapascal,
    /// How fast to move, MPa per second.
    pub slew_mpa_per_s: f64,
    /// By the supervisor's clock.
    pub issued: Micros,
    /// By the robot's clock.
    pub expires: Micros,
    /// Why.
    pub reason: Reason,
    /// The compensation that it belongs to.
    pub compensation: Option<u32>,
    /// Residual gain at [`CONTACT_RATIOS`].
    pub gain: Option<[f64; CONTACT_RATIOS.len()]>,
}

/// Why a setpoint is sent.
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

/// How far a setpoint is.
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
    /// Which compensation.
    pub compensation: u32,
    /// Contact ratio.
    pub ratio: ContactRatio,
    /// Deflection.
    pub deflection: Millimetre,
    /// The compensator's strain after the change of pressure: measured, this contact.
    pub after: Strain,
    /// The compensator's strain before it.
    pub before: f64,
    /// Where `before` comes from.
    pub before_origin: Origin,
    /// The target's strain while it was whole.
    pub target: f64,
    /// Where `target` comes from.
    pub target_origin: Origin,
}

/// Where a response comes from.
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
    /// Which compensation.
    pub compensation: u32,
    /// The pressure that it is measured at.
    pub pressure: Megapascal,
    /// Contacts of the compensator since that was applied.
    pub contacts: u32,
    /// The bins that are measured.
    pub bins: Vec<ErrorBin>,
    /// Mean over the bins, as a ratio.
    pub mean: f64,
    /// Standard deviation of the mean.
    pub sd: f64,
    /// The same with the gain in force applied, over all contact ratios, with its standard deviation: from
    /// contacts since that gain was published. None while these are too few.
    pub with_gain: Option<(f64, f64)>,
}

/// A look at a compensation's setpoint: errors are means of Eq. 35 over the contact ratios, as ratios.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Which compensation.
    pub compensation: u32,
    /// Contacts at the pressure that was looked at.
    pub contacts: u32,
    /// What came of it.
    pub outcome: RefinementOutcome,
    /// The pressure that was held.
    pub pressure_from: Megapascal,
    /// The best pressure; none where the mechanics have no answer.
    pub pressure_best: Option<Megapascal>,
    /// Error as felt, through smoothed responses.
    pub error: f64,
    /// Its standard deviation.
    pub error_sd: f64,
    /// Error to be expected at the best pressure, with its standard deviation.
    pub error_best: Option<(f64, f64)>,
    /// Error with the published gain.
    pub error_with_gain: f64,
    /// Error to be expected with a gain from these contacts.
    pub error_with_own_gain: f64,
    /// Whether a new gain was published.
    pub gain_published: bool,
}

/// What came of a look at a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefinementOutcome {
    /// The pressure is moved to the best one.
    Refined,
    /// It stays: the best one is nearer than a regulator's dither.
    HeldDither,
    /// It stays: the best one is hardly better.
    HeldMargin,
    /// It stays: the contacts do not tell yet that the best one is better.
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
    /// Compensator after.
    pub after_per_mm: f64,
    /// Compensator before.
    pub before_per_mm: f64,
    /// Where `before_per_mm` comes from.
    pub before_origin: Origin,
    /// Whole target.
    pub target_per_mm: f64,
    /// Where `target_per_mm` comes from.
    pub target_origin: Origin,
    /// Eq. 35 as a ratio.
    pub error: f64,
    /// Its standard deviation.
    pub sd: f64,
}

/// What people are told. Each kind stands until what is said of it here; all of them until the whisker is gone.
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
    /// The whole array reads more or less than before: deflection mis-scaled, or temperature. Taken out. Until the
    /// whisker that it was told of has felt a thousand contacts with no more of it, or is learned anew.
    ArrayShift,
    /// The gauge's baseline drifts. It is followed and taken out, but a gauge that has drifted goes on to be suspect:
    /// until a person has it learned anew, or replaces the whisker.
    BaselineDrift,
    /// A fault: until it goes or becomes another.
    Fault(Fault),
    /// A compensation for this whisker waits for approval: until it is approved, refused or over.
    Proposed,
}
