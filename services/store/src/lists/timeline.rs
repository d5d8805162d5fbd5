//! The timeline: the recorded events with the actions of people, in the order of their times.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::{Json, from_row};
use crate::list::List;
use crate::time::Time;

from_row! {
    /// An event of the log, or an action of a person.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct TimelineRow {
        /// Number of the entry, unique in the timeline.
        #[schema(minimum = 0)]
        pub entry_id: i64,
        /// Time of the event or of the person's request, by the supervisor's clock.
        pub at: Time,
        /// Kind of the event, as in the stream of events; `ACTION` for an action of a person.
        pub kind: String,
        /// Kind of the alarm, state of the setpoint, or kind of the action; null for other events.
        pub word: Option<String>,
        /// Name of the fleet; null for an action that concerns no fleet.
        pub fleet: Option<String>,
        /// Name of the robot; null if the whole fleet is concerned.
        pub robot: Option<String>,
        /// Name of the array; null if no single whisker is concerned.
        pub array: Option<String>,
        /// Number of the whisker in its array; null if no single whisker is concerned.
        #[schema(minimum = 0)]
        pub whisker: Option<i64>,
        /// Person or token that requested the action; null for events.
        pub actor: Option<String>,
        /// Reason that the person gave; null without one.
        pub reason: Option<String>,
        /// State of the action: `PENDING`, `DONE`, `REFUSED` or `EXPIRED`; null for events.
        pub state: Option<String>,
        /// Number of the action in the audit log; null for events.
        #[schema(minimum = 0)]
        pub action_id: Option<i64>,
        /// Data of the event as in the stream of events, or parameters of the action.
        #[schema(value_type = Object)]
        pub data: Json,
    }
}

sorts! {
    /// Sort keys of the timeline.
    pub enum TimelineSort {
        /// By time of the event or the request.
        At = "at" Whole Down,
    }
}

/// Events without those of contacts, and actions. The events about actions are left out, because the actions say more.
/// The numbers of events are even, those of actions odd.
pub static TIMELINE: List = List {
    what: "list the timeline",
    select: "SELECT 2 * e.event_id AS entry_id, e.recorded_us AS at, e.kind, e.word, e.fleet, r.robot, y.\"array\", w.whisker, \
             NULL AS actor, NULL AS reason, NULL AS state, CAST(NULL AS BIGINT) AS action_id, e.data \
             FROM events e LEFT JOIN robots r ON r.robot_id = e.robot_id LEFT JOIN whiskers w ON w.whisker_id = e.whisker_id \
             LEFT JOIN arrays y ON y.array_id = w.array_id \
             WHERE e.audience <> 'KAFKA' AND e.kind NOT IN ('ACTION', 'ALARM_HANDLED') \
             UNION ALL \
             SELECT 2 * action_id + 1, asked_us, 'ACTION', kind, fleet, robot, \"array\", whisker, actor, reason, state, \
             action_id, parameters FROM actions",
    details: "",
    keys: &[],
    sorts: TimelineSort::SORTS,
    id: "entry_id",
};
