//! Events of whiskers: trims and changes of health.

use serde::Serialize;
use utoipa::ToSchema;

use super::black_boxes::box_of;
use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A detected trim of a whisker.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Trim {
        /// Number of the trim.
        #[schema(minimum = 0)]
        pub trim_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Time of the detection, by the supervisor's clock.
        pub detected_at: Time,
        /// Estimated length before the trim, mm.
        pub length_before_mm: f64,
        /// Estimated length after the trim, mm.
        pub length_after_mm: f64,
        /// Lower bound of the 95 % interval of `length_after_mm`, mm.
        pub length_after_low_mm: f64,
        /// Upper bound of the 95 % interval of `length_after_mm`, mm.
        pub length_after_high_mm: f64,
        /// Number of contacts from the most likely moment of the cut to its detection.
        #[schema(minimum = 0)]
        pub contacts_to_detect: i64,
        /// Pressure of the whisker at the detection, MPa; null if it is unknown, as for trims detected by an earlier version.
        pub pressure_mpa: Option<f64>,
        /// Number of the black box with the robot's messages around it; null without a box.
        #[schema(minimum = 0)]
        pub black_box_id: Option<i64>,
    }

    /// A change of a whisker's condition or fault.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct HealthChange {
        /// Number of the change.
        #[schema(minimum = 0)]
        pub health_change_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// `CONDITION` or `FAULT`: the property that changed.
        pub kind: String,
        /// Condition or fault before the change; null for no fault.
        pub was: Option<String>,
        /// Condition or fault after the change; null for no fault.
        pub becomes: Option<String>,
        /// Time of the change, by the supervisor's clock.
        pub recorded_at: Time,
    }
}

sorts! {
    /// Sort keys of the list of trims.
    pub enum TrimSort {
        /// By time of the detection.
        DetectedAt = "detected_at" Whole Down,
        /// By estimated length after the trim.
        LengthAfterMm = "length_after_mm" Real Up,
        /// By number of contacts until the detection.
        ContactsToDetect = "contacts_to_detect" Whole Down,
    }
}

sorts! {
    /// Sort keys of the list of changes of health.
    pub enum HealthChangeSort {
        /// By time of the change.
        RecordedAt = "recorded_at" Whole Down,
    }
}

/// All detected trims.
pub static TRIMS: List = List {
    what: "list the trims",
    select: concat!(
        "SELECT trim_id, fleet, robot, \"array\", w.whisker, detected_us AS detected_at, length_before_mm, \
         length_after_mm, length_after_mm - 1.959963984540054 * length_after_sd_mm AS length_after_low_mm, \
         length_after_mm + 1.959963984540054 * length_after_sd_mm AS length_after_high_mm, contacts_to_detect, \
         t.pressure_mpa, ",
        box_of!("r.robot_id", "t.detected_us"),
        " AS black_box_id FROM trims t JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
         JOIN robots r ON r.robot_id = w.robot_id"
    ),
    details: "",
    keys: &[],
    sorts: TrimSort::SORTS,
    id: "trim_id",
};

/// All changes of condition and fault.
pub static HEALTH_CHANGES: List = List {
    what: "list the changes of health",
    select: "SELECT health_change_id, fleet, robot, \"array\", w.whisker, kind, was, becomes, \
             recorded_us AS recorded_at FROM health_changes h JOIN whiskers w USING (whisker_id) \
             JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id",
    details: "",
    keys: &[],
    sorts: HealthChangeSort::SORTS,
    id: "health_change_id",
};
