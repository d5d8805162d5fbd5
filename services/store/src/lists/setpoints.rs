//! Setpoints and the history of their states.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::{ColumnKind, List, Sort};
use crate::time::Time;

from_row! {
    /// A setpoint that was sent to a robot.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Setpoint {
        /// Identifier of the setpoint, a UUID.
        pub command_id: String,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Number of the compensation that it belongs to; null if it belongs to none.
        #[schema(minimum = 0)]
        pub compensation_id: Option<i64>,
        /// Epoch of the supervisor that decided it.
        #[schema(minimum = 0)]
        pub epoch: i64,
        /// Version of the setpoint on its robot. The setpoint with the highest version of the highest epoch is in
        /// force.
        #[schema(minimum = 0)]
        pub version: i64,
        /// Pressure to hold, MPa.
        pub pressure_mpa: f64,
        /// Rate at which the pressure approaches the setpoint, MPa per second.
        pub slew_mpa_per_s: f64,
        /// Reason: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER`, `LONGER_FOR_SHORTER`, `REFINEMENT`, `RELEASE` or
        /// `OPERATOR`.
        pub reason: String,
        /// State: `PENDING`, `RECEIVED`, `APPLYING`, `APPLIED`, `REJECTED`, `FAILED`, `SUPERSEDED`, `EXPIRED` or
        /// `ABANDONED`.
        pub state: String,
        /// Reason that the robot gave for rejecting it, such as `OUT_OF_RANGE`; null unless it was rejected.
        pub error: Option<String>,
        /// Pressure that the robot reported as reached, MPa; null before it was applied.
        pub reached_mpa: Option<f64>,
        /// Time of the decision, by the supervisor's clock.
        pub issued_at: Time,
        /// Time from which on the robot must not apply it any more, by the robot's clock.
        pub expires_at: Time,
    }

    /// A state in the history of a setpoint.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct SetpointState {
        /// Time at which the setpoint entered the state, by the supervisor's clock.
        pub at: Time,
        /// State: `PENDING`, `RECEIVED`, `APPLYING`, `APPLIED`, `REJECTED`, `FAILED`, `SUPERSEDED`, `EXPIRED` or
        /// `ABANDONED`.
        pub state: String,
        /// Reason that the robot gave for rejecting the setpoint; null unless it was rejected.
        pub error: Option<String>,
        /// Pressure that the robot reported as reached, MPa; null unless the setpoint was applied.
        pub pressure_mpa: Option<f64>,
    }
}

sorts! {
    /// Sort keys of the list of setpoints.
    pub enum SetpointSort {
        /// By time of the decision.
        IssuedAt = "issued_at" Whole Down,
        /// By pressure to hold.
        PressureMpa = "pressure_mpa" Real Up,
    }
}

/// All setpoints. As their number serves that of their first state, which is written in the same transaction.
pub static SETPOINTS: List = List {
    what: "list the setpoints",
    select: "SELECT (SELECT min(setpoint_state_id) FROM setpoint_states h WHERE h.command_id = s.command_id) \
             AS setpoint_id, s.command_id, fleet, robot, \"array\", w.whisker, s.compensation_id, epoch, version, \
             s.pressure_mpa, slew_mpa_per_s, reason, s.state, s.error, reached_mpa, issued_us AS issued_at, \
             expires_us AS expires_at FROM setpoints s JOIN whiskers w ON w.whisker_id = s.whisker_id \
             JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id",
    details: "",
    keys: &[],
    sorts: SetpointSort::SORTS,
    id: "setpoint_id",
};

/// The states of setpoints, in the order in which they were recorded.
pub static SETPOINT_STATES: List = List {
    what: "list the states of a setpoint",
    select: "SELECT setpoint_state_id, command_id, recorded_us AS at, state, error, pressure_mpa FROM setpoint_states",
    details: "",
    keys: &[],
    sorts: &[Sort { column: "setpoint_state_id", kind: ColumnKind::Whole, descending: false }],
    id: "setpoint_state_id",
};
