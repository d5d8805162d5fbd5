//! Setpoints and their histories.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::list::{Kind, List, Sort};
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// A setpoint that was sent to a robot.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Setpoint {
        /// Its name, a UUID.
        pub command_id: String,
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// The compensation that it belongs to.
        #[schema(minimum = 0)]
        pub compensation_id: Option<i64>,
        /// Epoch of the supervisor that decided it.
        #[schema(minimum = 0)]
        pub epoch: i64,
        /// Number on its robot; the greatest of the greatest epoch counts.
        #[schema(minimum = 0)]
        pub version: i64,
        /// Pressure to hold.
        pub pressure_mpa: f64,
        /// How fast to move there, MPa per second.
        pub slew_mpa_per_s: f64,
        /// Why: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER`, `LONGER_FOR_SHORTER`, `REFINEMENT` or `RELEASE`.
        pub reason: String,
        /// How far it is: `PENDING`, `RECEIVED`, `APPLYING`, `APPLIED`, `REJECTED`, `FAILED`, `SUPERSEDED`, `EXPIRED` or
        /// `ABANDONED`.
        pub state: String,
        /// Why the robot refused it.
        pub error: Option<String>,
        /// The pressure that was reached.
        pub reached_mpa: Option<f64>,
        /// When it was decided, by the supervisor's clock.
        pub issued_at: Time,
        /// Until when the robot may take it, by the robot's clock.
        pub expires_at: Time,
    }

    /// A state that a setpoint came into.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct SetpointState {
        /// When.
        pub at: Time,
        /// The state.
        pub state: String,
        /// Why the robot refused it.
        pub error: Option<String>,
        /// Where the pressure was.
        pub pressure_mpa: Option<f64>,
    }
}

sorts! {
    /// What a list of setpoints may be sorted by.
    pub enum SetpointSort {
        /// When they were decided.
        IssuedAt = "issued_at" Whole Down,
        /// Pressure to hold.
        PressureMpa = "pressure_mpa" Real Up,
    }
}

/// Setpoints. Their number is that of their first state, which is written with them.
pub static SETPOINTS: List = List {
    what: "list the setpoints",
    select: "SELECT (SELECT min(setpoint_state_id) FROM setpoint_states h WHERE h.command_id = s.command_id) \
             AS setpoint_id, s.command_id, fleet, robot, \"array\", w.whisker, s.compensation_id, epoch, version, \
             s.pressure_mpa, slew_mpa_per_s, reason, s.state, s.error, reached_mpa, issued_us AS issued_at, \
             expires_us AS expires_at FROM setpoints s JOIN whiskers w ON w.whisker_id = s.whisker_id \
             JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id",
    sorts: SetpointSort::SORTS,
    id: "setpoint_id",
};

/// What became of setpoints, in order.
pub static SETPOINT_STATES: List = List {
    what: "list what became of a setpoint",
    select: "SELECT setpoint_state_id, command_id, recorded_us AS at, state, error, pressure_mpa FROM setpoint_states",
    sorts: &[Sort { column: "setpoint_state_id", kind: Kind::Whole, descending: false }],
    id: "setpoint_state_id",
};
