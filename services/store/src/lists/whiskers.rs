//! The whiskers that are on a robot now.

use serde::Serialize;
use utoipa::ToSchema;

use super::counts::presence;
use super::sorts;
use crate::from_row::from_row;
use crate::labels::RobotLabels;
use crate::list::{Filter, Keys, List};
use crate::time::Time;

from_row! {
    /// A whisker with its estimated length and its health.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Whisker {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// `TYPE_1` (whiskers compensate for one another) or `TYPE_2` (each whisker compensates only for itself).
        pub array_type: String,
        /// Number of the whisker in its array.
        pub whisker: i64,
        /// Name of the whisker model, which selects its calibration.
        pub model: String,
        /// Position on the array, x coordinate, mm.
        pub x_mm: f64,
        /// Position on the array, y coordinate, mm.
        pub y_mm: f64,
        /// Length by the factsheet, mm.
        pub whole_length_mm: f64,
        /// Estimated length, mm.
        pub length_mm: f64,
        /// Lower bound of the 95 % interval of `length_mm`, mm.
        pub length_low_mm: f64,
        /// Upper bound of the 95 % interval of `length_mm`, mm.
        pub length_high_mm: f64,
        /// Mechanical condition, such as `HEALTHY`: one of the values of the filter `condition`.
        pub condition: String,
        /// Fault, such as `LEAK` or `STALE`; null without a fault.
        pub fault: Option<String>,
        /// How far its contacts can be relied on that the robot finds in samples of strain, by the newest status: `READY`,
        /// `LEARNING`, `LOST`, `CLIPPED`, `NOISY` or `INVERTED`; null if the robot does not say.
        pub segmenter: Option<String>,
        /// Pressure as last measured, MPa; null before the first measurement.
        pub pressure_mpa: Option<f64>,
        /// Pressure that the robot holds or moves to, MPa.
        pub setpoint_mpa: f64,
        /// Nominal pressure by the factsheet, MPa.
        pub nominal_pressure_mpa: f64,
        /// Highest pressure by the factsheet, MPa.
        pub pressure_max_mpa: f64,
        /// Number of contacts that were used for the estimate.
        pub contacts: i64,
        /// Time of the last message about the whisker, by the supervisor's clock; null before the first.
        pub heard_at: Option<Time>,
        /// Connection state of the robot: `ONLINE`, `SILENT`, `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Leak rate: relative loss of gauge pressure per second while the pressure is held; null until it can be
        /// estimated.
        pub leak_per_s: Option<f64>,
        /// Lower bound of the 95 % interval of `leak_per_s`.
        pub leak_low_per_s: Option<f64>,
        /// Upper bound of the 95 % interval of `leak_per_s`.
        pub leak_high_per_s: Option<f64>,
        /// Loss of length per contact, mm; null unless the whisker erodes.
        pub erosion_mm_per_contact: Option<f64>,
        /// Lower bound of the 95 % interval of `erosion_mm_per_contact`, mm.
        pub erosion_low_mm_per_contact: Option<f64>,
        /// Upper bound of the 95 % interval of `erosion_mm_per_contact`, mm.
        pub erosion_high_mm_per_contact: Option<f64>,
        /// Predicted number of contacts until the whisker is too short for self-compensation; null unless it erodes.
        pub contacts_left: Option<f64>,
        /// Lower bound of the 95 % interval of `contacts_left`.
        pub contacts_left_low: Option<f64>,
        /// Upper bound of the 95 % interval of `contacts_left`; null if the whisker may not erode at all.
        pub contacts_left_high: Option<f64>,
        /// Whether an operator holds the whisker or its robot: no automatic setpoint is sent to a held whisker.
        pub held: bool,
        /// Labels of the robot, by key.
        #[schema(value_type = std::collections::BTreeMap<String, String>)]
        pub labels: RobotLabels,
        /// Number of the compensation in force for this whisker; null if no whisker compensates for it.
        pub compensated_by: Option<i64>,
        /// Number of the compensator of that compensation in the array; null without one.
        pub compensator_whisker: Option<i64>,
        /// Number of the compensation in force in which this whisker is the compensator; null if it compensates for no
        /// whisker.
        pub serves_in: Option<i64>,
        /// Number of the whisker in the array that this whisker compensates for, which may be itself; null without one.
        pub target_whisker: Option<i64>,
    }
}

sorts! {
    /// Sort keys of the list of whiskers.
    pub enum WhiskerSort {
        /// By the order in which they became known.
        WhiskerId = "whisker_id" Whole Up,
        /// By name of the robot.
        Robot = "robot" Text Up,
        /// By mechanical condition.
        Condition = "condition" Text Up,
        /// By estimated length.
        LengthMm = "length_mm" Real Up,
        /// By number of contacts that were used.
        Contacts = "contacts" Whole Down,
    }
}

/// All whiskers that are on a robot now.
pub static WHISKERS: List = List {
    what: "list the whiskers",
    select: concat!(
        "SELECT w.whisker_id, w.robot_id, w.array_id, fleet, robot, \"array\", array_type, w.whisker, w.model, x_mm, y_mm, whole_length_mm, \
             length_mm, length_mm - 1.959963984540054 * length_sd_mm AS length_low_mm, \
             length_mm + 1.959963984540054 * length_sd_mm AS length_high_mm, condition, fault, segmenter, pressure_mpa, \
             setpoint_mpa, nominal_pressure_mpa, pressure_max_mpa, contacts, heard_us AS heard_at, ",
        presence!("r"),
        " AS connection, r.labels, CASE WHEN w.held OR r.held THEN true ELSE false END AS held, \
             leak_per_s, leak_low_per_s, leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact, \
             erosion_high_mm_per_contact, contacts_left, contacts_left_low, contacts_left_high \
             FROM whiskers w JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id \
             WHERE position IS NOT NULL"
    ),
    details: ", (SELECT max(compensation_id) FROM compensations c WHERE c.target_whisker_id = q.whisker_id \
              AND c.ended_us IS NULL AND c.compensator_whisker_id IS NOT NULL AND approval <> 'PROPOSED') AS compensated_by, \
              (SELECT k.whisker FROM compensations c JOIN whiskers k ON k.whisker_id = c.compensator_whisker_id \
              WHERE c.target_whisker_id = q.whisker_id AND c.ended_us IS NULL AND approval <> 'PROPOSED' \
              ORDER BY compensation_id DESC LIMIT 1) AS compensator_whisker, \
              (SELECT max(compensation_id) FROM compensations c WHERE c.compensator_whisker_id = q.whisker_id \
              AND c.ended_us IS NULL AND approval <> 'PROPOSED') AS serves_in, \
              (SELECT t.whisker FROM compensations c JOIN whiskers t ON t.whisker_id = c.target_whisker_id \
              WHERE c.compensator_whisker_id = q.whisker_id AND c.ended_us IS NULL AND approval <> 'PROPOSED' \
              ORDER BY compensation_id DESC LIMIT 1) AS target_whisker",
    keys: &[
        Keys {
            select: "SELECT whisker_id, robot_id, array_id, whisker, model, length_mm, condition, fault, contacts FROM whiskers \
                     WHERE position IS NOT NULL",
            columns: &[
                "whisker_id",
                "robot_id",
                "array_id",
                "whisker",
                "model",
                "length_mm",
                "condition",
                "fault",
                "contacts",
            ],
        },
        Keys {
            select: concat!(
                "SELECT w.whisker_id, w.robot_id, w.array_id, fleet, robot, w.whisker, w.model, length_mm, condition, fault, \
                 contacts, ",
                presence!("r"),
                " AS connection FROM whiskers w JOIN robots r ON r.robot_id = w.robot_id WHERE position IS NOT NULL"
            ),
            columns: &[
                "whisker_id",
                "robot_id",
                "array_id",
                "fleet",
                "robot",
                "whisker",
                "model",
                "length_mm",
                "condition",
                "fault",
                "contacts",
                "connection",
            ],
        },
    ],
    sorts: WhiskerSort::SORTS,
    id: "whisker_id",
};

/// The condition that the name of fleet, robot or array contains a text.
#[must_use]
pub fn named(text: String) -> Filter {
    Filter::IsNamed {
        column: "array_id",
        select: "SELECT y.array_id FROM arrays y JOIN robots b ON b.robot_id = y.robot_id",
        names: &["b.fleet", "b.robot", "y.\"array\""],
        text,
    }
}
