//! The parts of events.

use serde::Serialize;
use utoipa::ToSchema;

use crate::one_of::{
    AlarmKindWord, CaseWord, ConditionWord, EndReasonWord, SetpointReasonWord, SetpointStateWord, TestStateWord,
};

/// Contacts of one message of a robot. (`boot_id`, `seq`) names the message.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ContactsPart {
    /// Boot of the robot.
    pub boot_id: String,
    /// Sequence number of the message in its boot.
    #[schema(minimum = 0)]
    pub seq: u64,
    /// Accepted contacts of the robot that were left out before this event, because too many events waited for the log.
    /// Missing if there are none. Those before a restart of the supervisor are not counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1)]
    pub left_out: Option<u64>,
    /// The accepted contacts, in order.
    pub contacts: Vec<ContactPart>,
}

/// A contact, and the estimate of the whisker's length after it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ContactPart {
    /// Index of the contact in the robot's message.
    #[schema(minimum = 0)]
    pub position: i64,
    /// Name of the whisker's array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Time of the contact, µs since 1970 UTC by the robot's clock.
    pub t_us: i64,
    /// Kind of place that the robot stated: RATIO, DISTANCE, TIP or UNKNOWN.
    pub place: &'static str,
    /// Contact ratio, 0 at the base, 1 at the tip; null if the place is not known.
    pub ratio: Option<f64>,
    /// Measured distance from the base, mm.
    pub distance_mm: Option<f64>,
    /// Deflection at the contact, mm.
    pub deflection_mm: f64,
    /// Measured strain, m/m.
    pub strain: f64,
    /// Pressure of the chamber, MPa.
    pub pressure_mpa: f64,
    /// Temperature of the whisker, °C.
    pub temperature_c: f64,
    /// Use of the contact: USED, LEARNING, or why it was not used.
    pub used: &'static str,
    /// ln(measured / predicted sensitivity); null if the contact was not used.
    pub residual: Option<f64>,
    /// Estimated length after the contact, mm.
    pub length_mm: f64,
    /// Standard deviation of that length, mm.
    pub length_sd_mm: f64,
}

/// A detected trim.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct TrimPart {
    /// Number of the trim, unique in the database.
    pub trim_id: i64,
    /// Length before, mm.
    pub length_before_mm: f64,
    /// Length after, mm.
    pub length_after_mm: f64,
    /// Standard deviation of the length after, mm.
    pub length_after_sd_mm: f64,
    /// Contacts from the most likely moment of the cut to its detection.
    pub contacts_to_detect: u32,
}

/// A decision of the policy about a trimmed whisker.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct DecisionPart {
    /// Number of the compensation, unique in the database.
    pub compensation_id: i64,
    /// Whether the chosen candidate waits for an operator's approval.
    pub proposed: bool,
    /// The candidates; none is chosen if none can serve.
    pub candidates: Vec<CandidatePart>,
}

/// A candidate of a decision.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct CandidatePart {
    /// Number of the whisker in the array of the event's whisker.
    pub whisker: Option<u16>,
    /// Case of the paper.
    pub case: CaseWord,
    /// Pressure that it would hold, MPa.
    pub pressure_mpa: Option<f64>,
    /// Predicted compensation error (Eq. 35), as a ratio.
    pub predicted_error: Option<f64>,
    /// Whether it was chosen.
    pub chosen: bool,
    /// Why it was not chosen.
    pub refused: Option<&'static str>,
}

/// A compensation that has begun or ended. The event's whisker is its target.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct CompensationPart {
    /// Number of the compensation, unique in the database.
    pub compensation_id: i64,
    /// Case of the paper; null if it is not known any more.
    pub case: Option<CaseWord>,
    /// Number of the compensating whisker in the array; null when it ends.
    pub compensator_whisker: Option<i64>,
    /// Pressure that the compensator shall hold, MPa; null when it ends.
    pub pressure_mpa: Option<f64>,
    /// Predicted compensation error (Eq. 35), as a ratio; null when it ends.
    pub predicted_error: Option<f64>,
    /// Why it ended; null when it begins.
    pub end_reason: Option<EndReasonWord>,
}

/// A setpoint, or a state of it.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct SetpointPart {
    /// Identifier of the setpoint, a UUID.
    pub command_id: String,
    /// State of the setpoint.
    pub state: SetpointStateWord,
    /// Pressure of the setpoint, MPa.
    pub pressure_mpa: Option<f64>,
    /// Pressure that the robot reports as reached, MPa; null unless it is applied.
    pub reached_mpa: Option<f64>,
    /// Why the robot rejected it; null otherwise.
    pub rejection: Option<&'static str>,
    /// Number of the compensation that it belongs to; null in a later state.
    pub compensation_id: Option<i64>,
    /// Reason of the setpoint.
    pub reason: Option<SetpointReasonWord>,
}

/// A measured compensation error (Eq. 35).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ErrorPart {
    /// Number of the compensation, unique in the database.
    pub compensation_id: i64,
    /// Contacts of the compensator since its pressure was applied.
    pub contacts: u32,
    /// Pressure at which the error was measured, MPa.
    pub pressure_mpa: f64,
    /// Mean error over the contact ratios, as a ratio.
    pub error: f64,
    /// Standard deviation of the error.
    pub error_sd: f64,
}

/// An evaluation of a compensation's pressure and gain.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RefinementPart {
    /// Number of the compensation, unique in the database.
    pub compensation_id: i64,
    /// Outcome: REFINED, or why the pressure stays.
    pub outcome: &'static str,
    /// Pressure that was evaluated, MPa.
    pub pressure_from_mpa: f64,
    /// Best pressure by the measured responses, MPa; null if the model has no solution.
    pub pressure_best_mpa: Option<f64>,
}

/// An alarm. Of the alarms of a whisker, or of a robot as a whole, at most one of a kind stands: fleet, robot, array, whisker and
/// kind name it when it is raised and when it is cleared.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct AlarmPart {
    /// Kind of the alarm.
    pub kind: AlarmKindWord,
    /// Advice in one or two sentences.
    pub hint: String,
    /// Path of the runbook on the supervisor.
    pub runbook: String,
}

/// A change of a whisker's condition.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct ConditionPart {
    /// Condition before the change.
    pub was: ConditionWord,
    /// Condition after the change.
    pub becomes: ConditionWord,
}

/// A change of a whisker's fault.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct FaultPart {
    /// Fault before; null for none.
    pub was: Option<&'static str>,
    /// Fault after; null for none.
    pub becomes: Option<&'static str>,
}

/// A touch test, or its new state.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct TouchTestPart {
    /// Identifier of the test, a UUID.
    pub test_id: String,
    /// State of the test; null if it is as before.
    pub state: Option<TestStateWord>,
    /// Touches that came since the last event.
    #[schema(minimum = 0)]
    pub touches: i64,
    /// Touches that did not come since the last event.
    #[schema(minimum = 0)]
    pub missed: i64,
}

/// A whisker that has left the robot.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct GonePart {
    /// Name of its array.
    pub array: String,
    /// Number of the whisker in the array.
    pub whisker: u16,
}

/// An action of an operator, with its answer.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct ActionPart {
    /// Number of the action.
    pub action_id: i64,
    /// DONE, REFUSED or EXPIRED.
    pub state: &'static str,
}

/// A policy that is in force.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct PolicyPart {
    /// Version of the fleet's policy.
    pub version: i64,
}

/// A calibration that is in force.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct CalibrationPart {
    /// Number of the calibration.
    pub calibration_id: i64,
    /// Name of the whisker model.
    pub model: String,
}

/// A staged roll-out.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct RolloutPart {
    /// Number of the roll-out.
    pub rollout_id: i64,
    /// RUNNING, PAUSED, ROLLED_BACK or COMPLETED.
    pub state: String,
    /// FEW, QUARTER or ALL.
    pub stage: String,
}

/// A message in quarantine.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct QuarantinePart {
    /// Name of the robot that sent it.
    pub robot: String,
    /// Topic below the robot's level, such as `contacts`.
    pub topic: &'static str,
    /// Class of the database's error.
    pub cause: &'static str,
}

/// Declares the parts of events.
macro_rules! parts {
    ($($(#[$meta:meta])* $name:ident: $type:ty,)+) => {
        /// Data of an event. Parts that do not concern the kind of the event are missing.
        #[derive(Debug, Clone, Default, Serialize, ToSchema)]
        pub struct Parts {
            $($(#[$meta])* #[serde(skip_serializing_if = "Option::is_none")] pub $name: Option<$type>,)+
        }
    };
}

parts! {
    /// The trim of `TRIM`.
    trim: TrimPart,
    /// The change of `CONDITION_CHANGED`.
    condition: ConditionPart,
    /// The change of `FAULT_CHANGED`.
    fault: FaultPart,
    /// The whisker of `WHISKER_GONE`.
    gone: GonePart,
    /// The decision of `DECISION`; the event's whisker is its target.
    decision: DecisionPart,
    /// The compensation of `COMPENSATION_BEGUN`, `COMPENSATION_ENDED` and `PROPOSAL_ENDED`; the event's whisker is its target.
    compensation: CompensationPart,
    /// The setpoint of `SETPOINT`, `SETPOINT_STATE` and `SETPOINT_FAILED`.
    setpoint: SetpointPart,
    /// The error of `ERROR`.
    error: ErrorPart,
    /// The evaluation of `REFINEMENT`.
    refinement: RefinementPart,
    /// The test of `TOUCH_TEST`.
    touch_test: TouchTestPart,
    /// The action of `ACTION`; missing if it changed labels or notes.
    action: ActionPart,
    /// The policy of `POLICY`.
    policy: PolicyPart,
    /// The calibration of `CALIBRATION`.
    calibration: CalibrationPart,
    /// The roll-out of `ROLLOUT`.
    rollout: RolloutPart,
    /// The message of `QUARANTINED`.
    quarantine: QuarantinePart,
    /// The message of `CONTACTS`.
    contacts: ContactsPart,
}
