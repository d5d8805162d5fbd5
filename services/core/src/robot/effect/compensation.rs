//! Effects about compensations: decisions, measured errors and refinements.

use borsh::{BorshDeserialize, BorshSerialize};

use super::WhiskerIndex;
use crate::estimation::LengthEstimate;
use crate::mechanics::CONTACT_RATIOS;
use crate::policy::{Case, Refused};
use crate::units::{ContactRatio, Megapascal, Millimetre, Strain};

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
    /// Its setpoints have failed.
    SetpointFailed,
    /// One of the two whiskers was replaced by a new one.
    Replaced,
    /// It was proposed, and an operator refused it.
    Refused,
    /// An operator set its compensator's pressure by hand, or had it learned anew before the approval.
    Operator,
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
    /// Mean over the contact ratios about which contacts tell, and over the cases that they leave open, as a ratio: of the
    /// reading, with the reading gain in force where the robot applies one.
    pub mean: f64,
    /// Standard deviation of the mean. It includes what the gain may have wandered.
    pub sd: f64,
    /// The mean without the reading gain, with its standard deviation. None where the robot applies none: `mean` is that of
    /// the air alone.
    pub air_alone: Option<(f64, f64)>,
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
