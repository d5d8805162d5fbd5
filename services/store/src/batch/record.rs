//! The rarer rows of a batch, in their order: health changes, trims, decisions, setpoints, errors, alarms and answers.

use super::{DecisionRow, ErrorRow, PolicyRow, RefinementRow, TouchTestProgressRow, TouchTestRow};
use crate::calibrations::ActivationRow;
use crate::rollouts::RolloutChange;
use crate::row::row;

/// One of the rarer rows of a batch.
#[derive(Debug, Clone)]
pub enum Record {
    /// A change of a whisker's condition or fault.
    Health(HealthRow),
    /// A detected trim.
    Trim(TrimRow),
    /// A decision with its candidates.
    Decision(Box<DecisionRow>),
    /// The end of a compensation.
    Ended(EndedRow),
    /// A new setpoint, in state `PENDING`.
    Setpoint(Box<SetpointRow>),
    /// A new state of a setpoint.
    SetpointState(SetpointStateRow),
    /// A measured compensation error.
    Error(Box<ErrorRow>),
    /// An evaluation of a setpoint, which may refine it.
    Refinement(Box<RefinementRow>),
    /// A calibration that is in force from now on.
    Activation(Box<ActivationRow>),
    /// The approval of a proposed compensation.
    Approved {
        /// Number of the compensation.
        compensation_id: i64,
    },
    /// A raised alarm.
    Alarm(AlarmRow),
    /// The end of an alarm's cause.
    AlarmCleared(AlarmClearedRow),
    /// A whisker that is not on the robot any more: all its alarms are cleared.
    Gone {
        /// Number of the robot in the database.
        robot_id: i64,
        /// Name of the whisker's array.
        array: String,
        /// Number of the whisker in its array.
        whisker: i64,
        /// Time of the change, µs since 1970 UTC by the supervisor's clock.
        cleared_us: i64,
    },
    /// The answer to an operator's action.
    Answer {
        /// Number of the action.
        action_id: i64,
        /// Number of the robot that the action concerns; 0 if it concerns the fleet or is unknown.
        robot_id: i64,
        /// State of the action: `DONE`, `REFUSED` or `EXPIRED`.
        state: &'static str,
        /// Why the action was refused: a code, a colon, and an explanation.
        problem: Option<String>,
        /// Time of the answer, µs since 1970 UTC by the supervisor's clock.
        done_us: i64,
    },
    /// A policy that an operator has set.
    Policy(Box<PolicyRow>),
    /// A robot whose stored state cannot be used and that starts with a new one: all its alarms are cleared.
    AlarmsForgotten {
        /// Number of the robot in the database.
        robot_id: i64,
        /// Time of the change, µs since 1970 UTC by the supervisor's clock.
        cleared_us: i64,
    },
    /// A robot that has left for good.
    Decommissioned {
        /// Number of the robot in the database.
        robot_id: i64,
        /// Time of the change, µs since 1970 UTC by the supervisor's clock.
        left_us: i64,
    },
    /// A message whose rows the database refused.
    Quarantined(Box<QuarantineRow>),
    /// A new touch test, requested or proposed.
    TouchTest(Box<TouchTestRow>),
    /// Progress of a touch test.
    TouchTestProgress(Box<TouchTestProgressRow>),
    /// The touch test that an operator's action requested at once.
    TestOfAction {
        /// Number of the action.
        action_id: i64,
        /// Number of the robot in the database.
        robot_id: i64,
        /// Identifier of the test, a UUID.
        test_id: String,
    },
    /// A raised alarm about a robot as a whole.
    RobotAlarm(RobotAlarmRow),
    /// The end of the cause of an alarm about a robot as a whole.
    RobotAlarmCleared(RobotAlarmClearedRow),
    /// A new state of a roll-out.
    Rollout(Box<RolloutChange>),
}

/// State of a new setpoint.
const PENDING: &str = "PENDING";

row! {
    /// A message whose rows the database refused; docs/schema.md documents the columns.
    pub struct QuarantineRow {
        /// Name of the robot that sent the message.
        pub robot: String,
        /// Topic below the robot's level, such as `contacts`.
        pub topic: &'static str,
        /// Boot of the robot that sent the message; `None` if the message does not name it.
        pub boot_id: Option<String>,
        /// Sequence number of the message; `None` if it has none.
        pub seq: Option<i64>,
        /// Time of receipt, µs since 1970 UTC by the supervisor's clock.
        pub received_us: i64,
        /// Time at which it was put into quarantine, µs since 1970 UTC by the supervisor's clock.
        pub quarantined_us: i64,
        /// Class of the error: a word of [`RejectionCause`](crate::RejectionCause).
        pub cause: &'static str,
        /// Error code of the database.
        pub code: String,
        /// Bytes of the message, truncated after [`PAYLOAD_BYTES_MAX`](Self::PAYLOAD_BYTES_MAX).
        pub payload: Vec<u8>,
    }

    /// A change of a whisker's condition or fault.
    pub struct HealthRow {
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Time of the change, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
        /// Changed property: `CONDITION` or `FAULT`.
        pub kind: &'static str,
        /// Condition or fault before the change; `None` for no fault.
        pub was: Option<&'static str>,
        /// Condition or fault after the change; `None` for no fault.
        pub becomes: Option<&'static str>,
    }

    /// A detected trim.
    pub struct TrimRow {
        /// Number of the trim: the robot's number in the upper 32 bits, a count in the lower.
        pub trim_id: i64,
        /// Number of the robot in the database.
        pub robot_id: i64,
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Time of the detection, µs since 1970 UTC by the supervisor's clock.
        pub detected_us: i64,
        /// Estimated length before the trim, mm.
        pub length_before_mm: f64,
        /// Estimated length after the trim, mm.
        pub length_after_mm: f64,
        /// Standard deviation of the estimated length after the trim, mm.
        pub length_after_sd_mm: f64,
        /// Number of contacts from the most likely moment of the cut to its detection.
        pub contacts_to_detect: i64,
        /// Pressure of the whisker at the detection, MPa; `None` if it is unknown.
        pub pressure_mpa: Option<f64>,
    }

    /// The end of a compensation.
    pub struct EndedRow {
        /// Number of the compensation.
        pub compensation_id: i64,
        /// Time of the end, µs since 1970 UTC by the supervisor's clock.
        pub ended_us: i64,
        /// Reason for the end, such as `REPLACED`.
        pub end_reason: &'static str,
    }

    /// A new state of a setpoint.
    pub struct SetpointStateRow {
        /// Identifier of the setpoint, a UUID.
        pub command_id: String,
        /// Number of the robot in the database.
        pub robot_id: i64 = [],
        /// Time of the change, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
        /// The new state, such as `APPLIED`.
        pub state: &'static str,
        /// Reason that the robot gave for rejecting the setpoint.
        pub error: Option<&'static str>,
        /// Pressure that the robot reported as reached, MPa.
        pub pressure_mpa: Option<f64>,
    }

    /// A raised alarm.
    pub struct AlarmRow {
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Time at which it was raised, µs since 1970 UTC by the supervisor's clock.
        pub raised_us: i64,
        /// Kind of alarm, such as `UNCOMPENSATED`.
        pub kind: &'static str,
    }

    /// The end of an alarm's cause.
    pub struct AlarmClearedRow {
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Time of the end, µs since 1970 UTC by the supervisor's clock.
        pub cleared_us: i64,
        /// Kind of alarm, such as `UNCOMPENSATED`.
        pub kind: &'static str,
    }

    /// A raised alarm about a robot as a whole.
    pub struct RobotAlarmRow {
        /// Number of the robot in the database.
        pub robot_id: i64,
        /// Time at which it was raised, µs since 1970 UTC by the supervisor's clock.
        pub raised_us: i64,
        /// Kind of alarm, such as `ROBOT_SILENT`.
        pub kind: &'static str,
    }

    /// The end of the cause of an alarm about a robot as a whole.
    pub struct RobotAlarmClearedRow {
        /// Number of the robot in the database.
        pub robot_id: i64,
        /// Time of the end, µs since 1970 UTC by the supervisor's clock.
        pub cleared_us: i64,
        /// Kind of alarm, such as `ROBOT_SILENT`.
        pub kind: &'static str,
    }

    /// A setpoint; docs/schema.md documents the columns.
    pub struct SetpointRow {
        /// Identifier of the setpoint, a UUID.
        pub command_id: String,
        /// Number of the robot in the database.
        pub robot_id: i64,
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Number of the compensation that it belongs to, if any.
        pub compensation_id: Option<i64>,
        /// Epoch of the supervisor that decided it.
        pub epoch: i64,
        /// Version of the setpoint on its robot.
        pub version: i64,
        /// The only boot of the robot that may apply it.
        pub robot_boot_id: String,
        /// Pressure to hold, MPa.
        pub pressure_mpa: f64,
        /// Rate at which the pressure approaches the setpoint, MPa per second.
        pub slew_mpa_per_s: f64,
        /// Time of the decision, µs since 1970 UTC by the supervisor's clock.
        pub issued_us: i64,
        /// Time from which on the robot must not apply it, µs since 1970 UTC by the robot's clock.
        pub expires_us: i64,
        /// Reason, such as `SELF_COMPENSATION` or `RELEASE`.
        pub reason: &'static str,
        /// Residual gain, as a JSON array of contact ratios and gains.
        pub gain: Option<String>,
    }
    also {
        state: &'static str = |_row| PENDING,
    }
}

impl QuarantineRow {
    /// Most bytes of a message that are stored.
    pub const PAYLOAD_BYTES_MAX: usize = 64 * 1024;
    /// Most messages of a fleet that are stored; the oldest are deleted first.
    pub const ROWS_MAX: i64 = 1000;
}

impl SetpointRow {
    /// The state that a new setpoint has.
    pub(crate) fn first_state(&self) -> SetpointStateRow {
        SetpointStateRow {
            command_id: self.command_id.clone(),
            robot_id: self.robot_id,
            recorded_us: self.issued_us,
            state: PENDING,
            error: None,
            pressure_mpa: None,
        }
    }
}
