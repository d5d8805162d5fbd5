//! Black boxes: the messages of robots around trims, faults and alarms.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A black box: the messages from and to a robot around a trim, a fault or an alarm.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct BlackBox {
        /// Number of the box.
        #[schema(minimum = 0)]
        pub black_box_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array of the first event.
        pub array: String,
        /// Number of the whisker of the first event in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// First event: `TRIM`, or the kind of fault or alarm.
        pub cause: String,
        /// Time of the first event, by the supervisor's clock.
        pub event_at: Time,
        /// Time from which on all messages are in the box, by the supervisor's clock.
        pub began_at: Time,
        /// Planned end, by the supervisor's clock.
        pub ends_at: Time,
        /// Time of the newest message in the box, by the supervisor's clock.
        pub last_at: Time,
        /// State: `RECORDING` (only the messages before the event can be downloaded yet), `COMPLETE`, or `PARTIAL` (messages
        /// are missing at its beginning or end).
        pub state: String,
        /// Number of messages in the box.
        #[schema(minimum = 0)]
        pub messages: i64,
        /// Messages that the limit of memory left out after the event.
        #[schema(minimum = 0)]
        pub left_out: i64,
        /// Whether the box begins with the robot's state, so that a replay has the same start.
        pub has_state: bool,
        /// Size of its lines, bytes.
        #[schema(minimum = 0)]
        pub bytes: i64,
    }
}

sorts! {
    /// Sort keys of the list of black boxes.
    pub enum BlackBoxSort {
        /// By the time of the first event.
        EventAt = "event_at" Whole Down,
    }
}

/// All black boxes.
pub static BLACK_BOXES: List = List {
    what: "list the black boxes",
    select: "SELECT black_box_id, fleet, robot, \"array\", w.whisker, x.cause, event_us AS event_at, \
             began_us AS began_at, ends_us AS ends_at, last_us AS last_at, x.state, messages, left_out, \
             CASE WHEN has_state THEN true ELSE false END AS has_state, bytes FROM black_boxes x \
             JOIN whiskers w ON w.whisker_id = x.whisker_id JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = x.robot_id",
    details: "",
    keys: &[],
    sorts: BlackBoxSort::SORTS,
    id: "black_box_id",
};

/// Subquery: the box with an event of a robot at a time.
macro_rules! box_of {
    ($robot_id:literal, $at:literal) => {
        concat!(
            "(SELECT max(x.black_box_id) FROM black_boxes x WHERE x.robot_id = ",
            $robot_id,
            " AND ",
            $at,
            " BETWEEN x.event_us AND x.ends_us)"
        )
    };
}
pub(super) use box_of;
