//! Whiskers that are on a robot now.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// A whisker with its estimate.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Whisker {
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// `TYPE_1` (whiskers compensate for one another) or `TYPE_2` (single ones, for themselves).
        pub array_type: String,
        /// Number in the array.
        pub whisker: i64,
        /// Name of its model, a calibration.
        pub model: String,
        /// Position on the array.
        pub x_mm: f64,
        /// Position on the array.
        pub y_mm: f64,
        /// Length of the factsheet.
        pub whole_length_mm: f64,
        /// Estimated length.
        pub length_mm: f64,
        /// Lower bound of the 95 % interval.
        pub length_low_mm: f64,
        /// Upper bound.
        pub length_high_mm: f64,
        /// Mechanical condition: `LEARNING`, `HEALTHY`, `SUSPECTED`, `TRIMMED`, `ERODING` or `SENSITIVITY_LOSS`.
        pub condition: String,
        /// Fault, if any.
        pub fault: Option<String>,
        /// Measured pressure.
        pub pressure_mpa: Option<f64>,
        /// Pressure that the robot holds or moves to.
        pub setpoint_mpa: f64,
        /// Pressure of the factsheet.
        pub nominal_pressure_mpa: f64,
        /// Highest pressure that the robot allows.
        pub pressure_max_mpa: f64,
        /// Contacts that were used.
        pub contacts: i64,
        /// When it was last heard of, by the supervisor's clock.
        pub heard_at: Option<Time>,
        /// Whether its robot is connected: `ONLINE`, `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Loss of gauge pressure while it is held, per second of itself; null until it can be told.
        pub leak_per_s: Option<f64>,
        /// Lower bound of the 95 % interval.
        pub leak_low_per_s: Option<f64>,
        /// Upper bound.
        pub leak_high_per_s: Option<f64>,
        /// Loss of length with each contact; null unless it erodes.
        pub erosion_mm_per_contact: Option<f64>,
        /// Lower bound of the 95 % interval.
        pub erosion_low_mm_per_contact: Option<f64>,
        /// Upper bound.
        pub erosion_high_mm_per_contact: Option<f64>,
        /// Contacts until it is too short to compensate for itself; null unless it erodes.
        pub contacts_left: Option<f64>,
        /// Lower bound of the 95 % interval.
        pub contacts_left_low: Option<f64>,
        /// Upper bound; null if it may not erode at all.
        pub contacts_left_high: Option<f64>,
        /// Whether an operator holds it, or its robot: nothing moves it but by hand.
        pub held: bool,
        /// The compensation that serves it.
        pub compensated_by: Option<i64>,
        /// The compensation that it serves in.
        pub serves_in: Option<i64>,
    }
}

sorts! {
    /// What a list of whiskers may be sorted by.
    pub enum WhiskerSort {
        /// The order in which they became known.
        WhiskerId = "whisker_id" Whole Up,
        /// Estimated length.
        LengthMm = "length_mm" Real Up,
        /// Contacts that were used.
        Contacts = "contacts" Whole Down,
    }
}

/// Whiskers that are on a robot now.
pub static WHISKERS: List = List {
    what: "list the whiskers",
    select: "SELECT w.whisker_id, fleet, robot, \"array\", array_type, w.whisker, w.model, x_mm, y_mm, whole_length_mm, \
             length_mm, length_mm - 1.959963984540054 * length_sd_mm AS length_low_mm, \
             length_mm + 1.959963984540054 * length_sd_mm AS length_high_mm, condition, fault, pressure_mpa, \
             setpoint_mpa, nominal_pressure_mpa, pressure_max_mpa, contacts, heard_us AS heard_at, connection, CASE WHEN w.held OR r.held THEN true ELSE false END AS held, \
             leak_per_s, leak_low_per_s, leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact, \
             erosion_high_mm_per_contact, contacts_left, contacts_left_low, contacts_left_high, \
             (SELECT max(compensation_id) FROM compensations c WHERE c.target_whisker_id = w.whisker_id \
              AND c.ended_us IS NULL AND c.compensator_whisker_id IS NOT NULL AND approval <> 'PROPOSED') AS compensated_by, \
             (SELECT max(compensation_id) FROM compensations c WHERE c.compensator_whisker_id = w.whisker_id \
              AND c.ended_us IS NULL AND approval <> 'PROPOSED') AS serves_in \
             FROM whiskers w JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id \
             WHERE position IS NOT NULL",
    sorts: WhiskerSort::SORTS,
    id: "whisker_id",
};
