//! The audit log of actions that people requested.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::{Json, from_row};
use crate::list::List;
use crate::time::Time;

from_row! {
    /// An action that a person requested: an entry of the audit log.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    #[schema(as = Action)]
    pub struct ActionRow {
        /// Number of the action; later requests have higher numbers.
        pub action_id: i64,
        /// Name of the fleet; null if the action concerns no fleet.
        pub fleet: Option<String>,
        /// Name of the robot; null if the action concerns a whole fleet or no fleet.
        pub robot: Option<String>,
        /// Name of the array; set exactly if `whisker` is set.
        pub array: Option<String>,
        /// Number of the whisker in its array; null unless the action concerns a single whisker.
        pub whisker: Option<i64>,
        /// Number of the compensation that was approved or refused; null for other actions.
        pub compensation_id: Option<i64>,
        /// Number of the alarm that was acknowledged or shelved; null for other actions.
        pub alarm_id: Option<i64>,
        /// Kind of action: `APPROVE`, `REFUSE`, `SETPOINT`, `HOLD`, `RELEASE`, `REPLACED`, `REBASELINE`, `TOUCH_TEST`,
        /// `REFUSE_TOUCH_TEST`, `RETRY`, `POLICY`, `ALARM_ACKNOWLEDGE`, `ALARM_SHELVE`, `ALARM_UNSHELVE` ...
        pub kind: String,
        /// Parameters of the action, which depend on its kind: for example `pressure_mpa` of `SETPOINT`.
        #[schema(value_type = Object)]
        pub parameters: Json,
        /// Reason that the person gave, as free text; null if none was given.
        pub reason: Option<String>,
        /// Person or token that requested the action.
        pub actor: String,
        /// Role in which the action was requested: `VIEWER`, `OPERATOR`, `ENGINEER` or `ADMIN`.
        pub role: String,
        /// Identifier of the HTTP request that carried the action; `command line` for commands.
        pub request_id: String,
        /// Time of the request, by the supervisor's clock.
        pub asked_at: Time,
        /// State of the action: `PENDING`, `DONE`, `REFUSED` or `EXPIRED`.
        pub state: String,
        /// Why the action was refused: a code, a colon, and an explanation; null unless it was refused.
        pub problem: Option<String>,
        /// Time at which the action was done, refused or expired; null while it is pending.
        pub done_at: Option<Time>,
        /// Identifier of the touch test that the action `TOUCH_TEST` requested: the `test_id` of `/v1/touch-tests`; null
        /// for other actions, and if the request had to wait.
        pub test_id: Option<String>,
        /// Number of the request for many of which the action is a part: an `action_id` of `/v1/bulk-actions`; null for other
        /// actions.
        pub parent_id: Option<i64>,
    }
}

sorts! {
    /// Sort keys of the audit log.
    pub enum ActionSort {
        /// By number, which is the order of the requests.
        ActionId = "action_id" Whole Down,
    }
}

/// The audit log.
pub static ACTIONS: List = List {
    what: "list the actions",
    select: "SELECT action_id, fleet, robot, \"array\", whisker, compensation_id, alarm_id, kind, parameters, reason, actor, \
             role, request_id, asked_us AS asked_at, state, problem, done_us AS done_at, test_id, parent_id FROM actions",
    details: "",
    keys: &[],
    sorts: ActionSort::SORTS,
    id: "action_id",
};
