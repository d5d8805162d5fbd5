//! Touch tests and their progress.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A touch test: touches that a robot makes on request, to measure a whisker's length or the error of a compensation.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct TouchTest {
        /// Identifier of the test, a UUID.
        pub test_id: String,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Kind of test: `TIP` (an object is swept over the tip) or `WALL` (touches of a known surface at given distances).
        pub kind: String,
        /// Reason for the test: `SUSPICION`, `SETPOINT`, `OPERATOR`, `PAUSE`, `SCHEDULE` or `CHANGE`.
        pub reason: String,
        /// Number of requested touches.
        #[schema(minimum = 1, maximum = 1000)]
        pub contacts: i64,
        /// State: `PROPOSED`, `PENDING`, `ACCEPTED`, `RUNNING`, `DONE`, `REJECTED`, `FAILED`, `EXPIRED`, `ABANDONED`,
        /// `WITHDRAWN` or `REFUSED`.
        pub state: String,
        /// Reason that the robot gave for rejecting the test, such as `NOT_READY`; null unless it was rejected.
        pub error: Option<String>,
        /// Time of the request or proposal, by the supervisor's clock.
        pub requested_at: Time,
        /// Time of the last change of the test, by the supervisor's clock.
        pub updated_at: Time,
        /// Time of the end, by the supervisor's clock; null before the end.
        pub ended_at: Option<Time>,
        /// Touches that came and were received before the end.
        #[schema(minimum = 0)]
        pub touches: i64,
        /// Touches that did not come because the whisker does not reach that far, received before the end.
        #[schema(minimum = 0)]
        pub missed: i64,
        /// Estimated length after the test, mm; null unless the test is done.
        pub length_mm: Option<f64>,
        /// Lower bound of the 95 % interval of `length_mm`, mm; null unless the test is done.
        pub length_low_mm: Option<f64>,
        /// Upper bound of the 95 % interval of `length_mm`, mm; null unless the test is done.
        pub length_high_mm: Option<f64>,
    }
}

sorts! {
    /// Sort keys of the list of touch tests.
    pub enum TouchTestSort {
        /// By time of the request or proposal.
        RequestedAt = "requested_at" Whole Down,
        /// By time of the last change.
        UpdatedAt = "updated_at" Whole Down,
    }
}

/// All touch tests.
pub static TOUCH_TESTS: List = List {
    what: "list the touch tests",
    select: "SELECT touch_test_id, test_id, fleet, robot, \"array\", w.whisker, t.kind, t.reason, t.contacts, t.state, \
             t.error, requested_us AS requested_at, t.updated_us AS updated_at, ended_us AS ended_at, touches, missed, \
             t.length_mm, t.length_mm - 1.959963984540054 * t.length_sd_mm AS length_low_mm, \
             t.length_mm + 1.959963984540054 * t.length_sd_mm AS length_high_mm FROM touch_tests t \
             JOIN whiskers w ON w.whisker_id = t.whisker_id JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id",
    details: "",
    keys: &[],
    sorts: TouchTestSort::SORTS,
    id: "touch_test_id",
};
