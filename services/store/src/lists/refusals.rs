//! Refusals of robots, by topic and reason.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// Refusals of a robot for one reason. Refused contacts are not recorded; the others of their message are.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct RefusalCount {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Topic of the message below the robot's level, such as `contacts`.
        pub topic: String,
        /// Reason, as in the metric `vibrissa_messages_refused_total`.
        pub reason: String,
        /// Number of refused messages, and of refused contacts or other entries of messages.
        #[schema(minimum = 0)]
        pub refused: i64,
        /// Time of the first refusal, by the supervisor's clock.
        pub first_at: Time,
        /// Time of the newest refusal, by the supervisor's clock.
        pub refused_at: Time,
        /// The newest refusal in words, with the place in the message.
        pub problem: String,
    }
}

sorts! {
    /// Sort keys of the list of refusals.
    pub enum RefusalSort {
        /// By the time of the newest refusal.
        RefusedAt = "refused_at" Whole Down,
        /// By the number of refusals.
        Refused = "refused" Whole Down,
    }
}

/// Refusals of all robots.
pub static REFUSALS: List = List {
    what: "list the refusals",
    select: "SELECT refusal_id, fleet, robot, topic, reason, refused, first_us AS first_at, refused_us AS refused_at, \
             problem FROM refusals f JOIN robots r ON r.robot_id = f.robot_id",
    details: "",
    keys: &[],
    sorts: RefusalSort::SORTS,
    id: "refusal_id",
};
