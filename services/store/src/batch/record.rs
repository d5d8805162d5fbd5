//! The rarer rows: what was found, decided, commanded and told.

use borsh::{BorshDeserialize, BorshSerialize};

use super::{Interval, words};
use crate::calibrations::ActivationRow;

/// One of the rarer rows.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub enum Record {
    /// A change of condition or fault.
    Health(HealthRow),
    /// A trim.
    Trim(TrimRow),
    /// A decision.
    Decision(Box<DecisionRow>),
    /// The end of a compensation.
    Ended(EndedRow),
    /// A setpoint.
    Setpoint(Box<SetpointRow>),
    /// What became of one.
    SetpointState(SetpointStateRow),
    /// The compensation error.
    Error(Box<ErrorRow>),
    /// A look at a setpoint.
    Refinement(Box<RefinementRow>),
    /// A calibration that is in force from now on.
    Activation(Box<ActivationRow>),
    /// The approval of a proposed compensation.
    Approved {
        /// Which.
        compensation_id: i64,
    },
    /// An alarm.
    Alarm(AlarmRow),
    /// An alarm's cause is over.
    AlarmCleared(AlarmClearedRow),
    /// A whisker is not on the robot any more: all its alarms are cleared, and nobody holds it.
    Gone {
        /// The robot.
        robot_id: i64,
        /// Its array.
        array: String,
        /// Its number.
        whisker: i64,
        /// When.
        cleared_us: i64,
    },
    /// What became of an action that an operator asked for.
    Answer {
        /// Which.
        action_id: i64,
        /// The robot that it is about; 0 if it is about the fleet, or not known.
        #[borsh(skip)]
        robot_id: i64,
        /// `DONE`, `REFUSED` or `EXPIRED`.
        #[borsh(deserialize_with = "words::word")]
        state: &'static str,
        /// Why it was refused: a word, a colon, and a text for people.
        problem: Option<String>,
        /// When.
        done_us: i64,
    },
    /// A policy that an operator has set.
    Policy(Box<PolicyRow>),
    /// A robot starts anew, because its stored state cannot be used: none of its alarms stands.
    AlarmsForgotten {
        /// The robot.
        robot_id: i64,
        /// When.
        cleared_us: i64,
    },
    /// A message that the database refuses, kept for people to look at.
    Quarantined(Box<QuarantineRow>),
}

/// A message that the database refuses; see the table for the columns.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct QuarantineRow {
    /// The robot that sent it.
    pub robot: String,
    /// Its topic below the robot's level, in the contract's words.
    #[borsh(deserialize_with = "words::word")]
    pub topic: &'static str,
    /// The boot that sent it, if the message says so.
    pub boot_id: Option<String>,
    /// Its number, if the message says so.
    pub seq: Option<i64>,
    /// When it was received, by the supervisor's clock.
    pub received_us: i64,
    /// When it was put into quarantine, by the supervisor's clock.
    pub quarantined_us: i64,
    /// Why: a word of [`RejectionCause`](crate::RejectionCause).
    #[borsh(deserialize_with = "words::word")]
    pub cause: &'static str,
    /// The database's own code.
    pub code: String,
    /// The message, cut off after [`PAYLOAD_BYTES_MAX`](Self::PAYLOAD_BYTES_MAX).
    pub payload: Vec<u8>,
}

impl QuarantineRow {
    /// Stored bytes of a message at most.
    pub const PAYLOAD_BYTES_MAX: usize = 64 * 1024;
    /// Stored messages of a fleet at most: the oldest go first.
    pub const ROWS_MAX: i64 = 1000;
}

/// A change of condition or fault.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct HealthRow {
    /// Whose.
    pub whisker_id: i64,
    /// When.
    pub recorded_us: i64,
    /// `CONDITION` or `FAULT`.
    #[borsh(deserialize_with = "words::word")]
    pub kind: &'static str,
    /// Before.
    #[borsh(deserialize_with = "words::word_if_any")]
    pub was: Option<&'static str>,
    /// Now.
    #[borsh(deserialize_with = "words::word_if_any")]
    pub becomes: Option<&'static str>,
}

/// A trim.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct TrimRow {
    /// Number.
    pub trim_id: i64,
    /// Robot.
    pub robot_id: i64,
    /// Whisker.
    pub whisker_id: i64,
    /// When.
    pub detected_us: i64,
    /// Length before.
    pub length_before_mm: f64,
    /// Length after.
    pub length_after_mm: f64,
    /// Its standard deviation.
    pub length_after_sd_mm: f64,
    /// Contacts since the likeliest moment of the cut.
    pub contacts_to_detect: i64,
}

/// The end of a compensation.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct EndedRow {
    /// Which.
    pub compensation_id: i64,
    /// When.
    pub ended_us: i64,
    /// Why.
    #[borsh(deserialize_with = "words::word")]
    pub end_reason: &'static str,
}

/// What became of a setpoint.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct SetpointStateRow {
    /// Which.
    pub command_id: String,
    /// The robot that it was sent to; 0 if it is not known, after it was read back from bytes.
    #[borsh(skip)]
    pub robot_id: i64,
    /// When.
    pub recorded_us: i64,
    /// What.
    #[borsh(deserialize_with = "words::word")]
    pub state: &'static str,
    /// Why.
    #[borsh(deserialize_with = "words::word_if_any")]
    pub error: Option<&'static str>,
    /// Where the pressure is.
    pub pressure_mpa: Option<f64>,
}

/// An alarm.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct AlarmRow {
    /// About whom.
    pub whisker_id: i64,
    /// When.
    pub raised_us: i64,
    /// What.
    #[borsh(deserialize_with = "words::word")]
    pub kind: &'static str,
}

/// An alarm whose cause is over.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct AlarmClearedRow {
    /// About whom.
    pub whisker_id: i64,
    /// When.
    pub cleared_us: i64,
    /// What.
    #[borsh(deserialize_with = "words::word")]
    pub kind: &'static str,
}

/// A policy; see the table for the columns.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct PolicyRow {
    /// Fleet.
    pub fleet: String,
    /// Number, from 1.
    pub version: i64,
    /// Mode.
    #[borsh(deserialize_with = "words::word")]
    pub mode: &'static str,
    /// What setpoints are solved for.
    #[borsh(deserialize_with = "words::word")]
    pub objective: &'static str,
    /// When a longer whisker may stand in for a shorter one.
    #[borsh(deserialize_with = "words::word")]
    pub longer_for_shorter: &'static str,
    /// Highest mean predicted error, as a ratio.
    pub predicted_error_max: f64,
    /// Cost of a neighbour's own role, in units of mean error.
    pub own_role_cost: f64,
    /// Gain that a change must have, in units of mean error.
    pub change_margin: f64,
    /// When.
    pub changed_us: i64,
    /// Who.
    pub changed_by: String,
    /// Why.
    pub reason: Option<String>,
    /// The action that asked for it.
    pub action_id: i64,
}

/// A decision with its candidates.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct DecisionRow {
    /// Number.
    pub compensation_id: i64,
    /// Robot.
    pub robot_id: i64,
    /// The broken whisker.
    pub target_whisker_id: i64,
    /// Its whole length.
    pub target_length_mm: f64,
    /// Its nominal pressure.
    pub target_pressure_mpa: f64,
    /// When.
    pub decided_us: i64,
    /// `PROPOSED` if it waits for approval, else `AUTOMATIC`.
    #[borsh(deserialize_with = "words::word")]
    pub approval: &'static str,
    /// Everyone who was asked.
    pub candidates: Vec<CandidateRow>,
}

/// A candidate of a decision.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct CandidateRow {
    /// Who.
    pub whisker_id: i64,
    /// Case of the paper.
    #[borsh(deserialize_with = "words::word")]
    pub case: &'static str,
    /// Length.
    pub length_mm: f64,
    /// Its standard deviation.
    pub length_sd_mm: f64,
    /// Pressure before.
    pub pressure_before_mpa: f64,
    /// Pressure to hold.
    pub pressure_mpa: Option<f64>,
    /// Predicted mean error.
    pub predicted_error: Option<f64>,
    /// Its 95 % interval.
    pub predicted_error_interval: Option<(f64, f64)>,
    /// The same by contact ratio, JSON.
    pub predicted_error_by_ratio: Option<String>,
    /// Whether it would give up its own role.
    pub gives_up_own_role: bool,
    /// Whether it was chosen.
    pub chosen: bool,
    /// Why not.
    #[borsh(deserialize_with = "words::word_if_any")]
    pub refused: Option<&'static str>,
}

/// A setpoint; see the table for the columns.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct SetpointRow {
    /// Name.
    pub command_id: String,
    /// Robot.
    pub robot_id: i64,
    /// Whisker.
    pub whisker_id: i64,
    /// Compensation that it belongs to.
    pub compensation_id: Option<i64>,
    /// Epoch.
    pub epoch: i64,
    /// Version.
    pub version: i64,
    /// The only boot that may take it.
    pub robot_boot_id: String,
    /// Pressure.
    pub pressure_mpa: f64,
    /// Slew.
    pub slew_mpa_per_s: f64,
    /// Supervisor's clock.
    pub issued_us: i64,
    /// Robot's clock.
    pub expires_us: i64,
    /// Why.
    #[borsh(deserialize_with = "words::word")]
    pub reason: &'static str,
    /// Residual gain, JSON.
    pub gain: Option<String>,
}

/// The compensation error with its bins.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct ErrorRow {
    /// Compensation.
    pub compensation_id: i64,
    /// When.
    pub recorded_us: i64,
    /// Contacts.
    pub contacts: i64,
    /// Pressure at which it is measured.
    pub pressure_mpa: f64,
    /// Mean and 95 % interval, as ratios.
    pub error: Interval,
    /// The same with the gain in force.
    pub with_gain: Option<Interval>,
    /// Bins.
    pub bins: Vec<ErrorBinRow>,
}

/// A look at a setpoint; see the table for the columns.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct RefinementRow {
    /// Compensation.
    pub compensation_id: i64,
    /// When.
    pub recorded_us: i64,
    /// Contacts at the pressure.
    pub contacts: i64,
    /// What came of it.
    #[borsh(deserialize_with = "words::word")]
    pub outcome: &'static str,
    /// The pressure that was held.
    pub pressure_from_mpa: f64,
    /// The best pressure.
    pub pressure_best_mpa: Option<f64>,
    /// Error as felt.
    pub error: Interval,
    /// Error to be expected at the best pressure.
    pub error_best: Option<Interval>,
    /// What the published gain leaves.
    pub error_with_gain: f64,
    /// What a gain from these contacts would leave.
    pub error_with_own_gain: f64,
    /// Whether a new gain went out.
    pub gain_published: bool,
}

/// One contact-ratio bin of an error.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct ErrorBinRow {
    /// Centre.
    pub ratio: f64,
    /// Contacts.
    pub contacts: i64,
    /// Strain per mm after.
    pub after_per_mm: f64,
    /// Strain per mm before.
    pub before_per_mm: f64,
    /// Where from.
    #[borsh(deserialize_with = "words::word")]
    pub before_origin: &'static str,
    /// Strain per mm of the whole target.
    pub target_per_mm: f64,
    /// Where from.
    #[borsh(deserialize_with = "words::word")]
    pub target_origin: &'static str,
    /// Eq. 35.
    pub error: Interval,
}
