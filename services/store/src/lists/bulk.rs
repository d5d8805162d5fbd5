//! Bulk actions, with their progress.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::{Json, from_row};
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A request for a bulk action on robots, whiskers, alarms or fleets, with its progress.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    #[schema(as = BulkAction)]
    pub struct BulkRow {
        /// Number of the request, which is that of its entry in the audit log. The actions of its subjects have it as
        /// `parent_id`.
        pub action_id: i64,
        /// Name of the fleet; null if the request concerns several fleets.
        pub fleet: Option<String>,
        /// Kind of action, such as `ROBOTS_HOLD`.
        pub kind: String,
        /// Parameters of the request, with the conditions `which`.
        #[schema(value_type = Object)]
        pub parameters: Json,
        /// Reason that the person gave, as free text; null if none was given.
        pub reason: Option<String>,
        /// Person or token that requested it.
        pub actor: String,
        /// Time of the request, by the supervisor's clock.
        pub asked_at: Time,
        /// Number of subjects.
        #[schema(minimum = 0)]
        pub subjects: i64,
        /// Number of subjects whose action was not executed yet.
        #[schema(minimum = 0)]
        pub pending: i64,
        /// Number of subjects whose action was executed.
        #[schema(minimum = 0)]
        pub done: i64,
        /// Number of subjects whose action was refused, or stopped before its turn.
        #[schema(minimum = 0)]
        pub refused: i64,
        /// Number of subjects whose action was not executed in time.
        #[schema(minimum = 0)]
        pub expired: i64,
    }
}

sorts! {
    /// Sort keys of the list of requests for many.
    pub enum BulkSort {
        /// By number, which is the order of the requests.
        ActionId = "action_id" Whole Down,
    }
}

/// The requests for many.
pub static BULK: List = List {
    what: "list the bulk actions",
    select: "SELECT action_id, fleet, kind, parameters, reason, actor, asked_us AS asked_at, subjects \
             FROM actions WHERE subjects IS NOT NULL",
    details: ", (SELECT count(*) FROM actions c WHERE c.parent_id = q.action_id AND c.state = 'PENDING') AS pending, \
              (SELECT count(*) FROM actions c WHERE c.parent_id = q.action_id AND c.state = 'DONE') AS done, \
              (SELECT count(*) FROM actions c WHERE c.parent_id = q.action_id AND c.state = 'REFUSED') AS refused, \
              (SELECT count(*) FROM actions c WHERE c.parent_id = q.action_id AND c.state = 'EXPIRED') AS expired",
    keys: &[],
    sorts: BulkSort::SORTS,
    id: "action_id",
};
