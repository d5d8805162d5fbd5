//! The parts of events.

use serde::Serialize;
use utoipa::ToSchema;

use crate::one_of::{AlarmKindWord, CaseWord, EndReasonWord, SetpointReasonWord, SetpointStateWord};

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

/// A compensation that is approved, or that has ended.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct CompensationPart {
    /// Number of the compensation, unique in the database.
    pub compensation_id: i64,
    /// Case of the paper; null if it is not known any more.
    pub case: Option<CaseWord>,
    /// Why it ended; null unless it has ended.
    pub end_reason: Option<EndReasonWord>,
}

/// A setpoint, or a state of it.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct SetpointPart {
    /// Identifier of the setpoint, a UUID.
    pub command_id: String,
    /// State of the setpoint.
    pub state: SetpointStateWord,
    /// Pressure of the setpoint, MPa; in `SETPOINT_STATE` the pressure that the robot reports, if it does.
    pub pressure_mpa: Option<f64>,
    /// Why the robot rejected it.
    pub rejection: Option<&'static str>,
    /// Number of the compensation that it belongs to; null in `SETPOINT_STATE`.
    pub compensation_id: Option<i64>,
    /// Reason of the setpoint; null in `SETPOINT_STATE`.
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

/// An alarm.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct AlarmPart {
    /// Kind of the alarm.
    pub kind: AlarmKindWord,
}
