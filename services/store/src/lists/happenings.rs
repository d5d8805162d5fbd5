//! What happened to whiskers: trims, changes of health, alarms.

use serde::Serialize;
use utoipa::ToSchema;

use super::counts::alarms;
use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// A trim that was found.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Trim {
        /// Number.
        #[schema(minimum = 0)]
        pub trim_id: i64,
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// When it was found.
        pub detected_at: Time,
        /// Estimated length before.
        pub length_before_mm: f64,
        /// Estimated length after.
        pub length_after_mm: f64,
        /// Lower bound of its 95 % interval.
        pub length_after_low_mm: f64,
        /// Upper bound.
        pub length_after_high_mm: f64,
        /// Contacts from the likeliest moment of the cut to the decision.
        #[schema(minimum = 0)]
        pub contacts_to_detect: i64,
    }

    /// A change of condition or of fault.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct HealthChange {
        /// Number.
        #[schema(minimum = 0)]
        pub health_change_id: i64,
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// `CONDITION` or `FAULT`.
        pub kind: String,
        /// Before; null for no fault.
        pub was: Option<String>,
        /// Now; null for no fault.
        pub becomes: Option<String>,
        /// When.
        pub recorded_at: Time,
    }

    /// What people were told.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct Alarm {
        /// Number.
        #[schema(minimum = 0)]
        pub alarm_id: i64,
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// What: `UNCOMPENSATED`, `SETPOINT_FAILED`, `SENSITIVITY_LOSS`, `ERODING`, `ARRAY_SHIFT`, `BASELINE_DRIFT`, or
        /// `PROPOSED`, or a fault.
        pub kind: String,
        /// When.
        pub raised_at: Time,
        /// Whether its cause is there still.
        pub standing: bool,
        /// When its cause was over.
        pub cleared_at: Option<Time>,
        /// When it was acknowledged.
        pub acknowledged_at: Option<Time>,
        /// By whom.
        pub acknowledged_by: Option<String>,
        /// Why, or what was done.
        pub acknowledged_reason: Option<String>,
        /// Until when it, and others of its kind about this whisker, shall be quiet; null if they shall not.
        pub shelved_until: Option<Time>,
        /// Who has shelved it.
        pub shelved_by: Option<String>,
        /// Why.
        pub shelved_reason: Option<String>,
        /// What there is to do: `UNACKNOWLEDGED`, `ACKNOWLEDGED`, `SHELVED` or `CLEARED`.
        pub state: String,
    }
}

sorts! {
    /// What a list of trims may be sorted by.
    pub enum TrimSort {
        /// When they were found.
        DetectedAt = "detected_at" Whole Down,
        /// Estimated length after.
        LengthAfterMm = "length_after_mm" Real Up,
        /// Contacts that it took to find them.
        ContactsToDetect = "contacts_to_detect" Whole Down,
    }
}

sorts! {
    /// What a list of changes of health may be sorted by.
    pub enum HealthChangeSort {
        /// When.
        RecordedAt = "recorded_at" Whole Down,
    }
}

sorts! {
    /// What a list of alarms may be sorted by.
    pub enum AlarmSort {
        /// When.
        RaisedAt = "raised_at" Whole Down,
        /// What.
        Kind = "kind" Text Up,
    }
}

/// Trims that were found.
pub static TRIMS: List = List {
    what: "list the trims",
    select: "SELECT trim_id, fleet, robot, \"array\", w.whisker, detected_us AS detected_at, length_before_mm, \
             length_after_mm, length_after_mm - 1.959963984540054 * length_after_sd_mm AS length_after_low_mm, \
             length_after_mm + 1.959963984540054 * length_after_sd_mm AS length_after_high_mm, contacts_to_detect \
             FROM trims t JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id",
    sorts: TrimSort::SORTS,
    id: "trim_id",
};

/// Changes of condition and of fault.
pub static HEALTH_CHANGES: List = List {
    what: "list the changes of health",
    select: "SELECT health_change_id, fleet, robot, \"array\", w.whisker, kind, was, becomes, \
             recorded_us AS recorded_at FROM health_changes h JOIN whiskers w USING (whisker_id) \
             JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id",
    sorts: HealthChangeSort::SORTS,
    id: "health_change_id",
};

/// What people were told.
pub static ALARMS: List = List {
    what: "list the alarms",
    select: concat!(
        "SELECT s.alarm_id, fleet, robot, \"array\", w.whisker, s.kind, s.raised_us AS raised_at, standing, \
         cleared_us AS cleared_at, acknowledged_us AS acknowledged_at, acknowledged_by, acknowledged_reason, \
         shelved_until_us AS shelved_until, shelved_by, shelved_reason, \
         CASE WHEN NOT standing THEN 'CLEARED' WHEN shelved_until_us IS NOT NULL THEN 'SHELVED' \
         WHEN acknowledged_us IS NULL THEN 'UNACKNOWLEDGED' ELSE 'ACKNOWLEDGED' END AS state FROM ",
        alarms!(),
        " s JOIN whiskers w ON w.whisker_id = s.whisker_id JOIN arrays y ON y.array_id = w.array_id \
         JOIN robots r ON r.robot_id = w.robot_id"
    ),
    sorts: AlarmSort::SORTS,
    id: "alarm_id",
};
