//! The audit log of actions that people requested, and the policies that operators have set.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
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
        /// Kind of action: `APPROVE`, `REFUSE`, `SETPOINT`, `HOLD`, `RELEASE`, `REPLACED`, `REBASELINE`, `POLICY`,
        /// `ALARM_ACKNOWLEDGE`, `ALARM_SHELVE`, `ALARM_UNSHELVE` ...
        pub kind: String,
        /// Parameters of the action: a JSON object, as text.
        pub parameters: String,
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
    }

    /// A policy: the rules by which a fleet's compensations are decided.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    #[schema(as = Policy)]
    pub struct PolicyRow {
        /// Name of the fleet.
        pub fleet: String,
        /// Version of the fleet's policy, from 1; 0 is the policy of the configuration.
        pub version: i64,
        /// `AUTOMATIC`: compensations start without approval; `ADVISE`: each waits for an operator's approval.
        pub mode: String,
        /// Quantity that a setpoint is solved for: `TIP` (equal sensitivity at the tip) or `MEAN` (least mean error).
        pub objective: String,
        /// Whether a longer whisker may compensate for a shorter one: `NEVER`, `LAST_RESORT` or `ALLOWED`.
        pub longer_for_shorter: String,
        /// Highest predicted mean error (Eq. 35) at which a compensation may start, as a ratio.
        pub predicted_error_max: f64,
        /// Cost of a neighbour that gives up its own role, in units of mean error.
        pub own_role_cost: f64,
        /// Least gain for which an assignment in force is changed, in units of mean error.
        pub change_margin: f64,
        /// Time at which this version was set; null for the policy of the configuration.
        pub changed_at: Option<Time>,
        /// Person or token that set this version; null for the policy of the configuration.
        pub changed_by: Option<String>,
        /// Reason that the person gave; null if none was given.
        pub reason: Option<String>,
    }
}

sorts! {
    /// Sort keys of the audit log.
    pub enum ActionSort {
        /// By number, which is the order of the requests.
        ActionId = "action_id" Whole Down,
    }
}

sorts! {
    /// Sort keys of a fleet's policies.
    pub enum PolicySort {
        /// By version, which is the order in which they came into force.
        Version = "version" Whole Down,
    }
}

/// The audit log.
pub static ACTIONS: List = List {
    what: "list the actions",
    select: "SELECT action_id, fleet, robot, \"array\", whisker, compensation_id, alarm_id, kind, parameters, reason, actor, \
             role, request_id, asked_us AS asked_at, state, problem, done_us AS done_at FROM actions",
    sorts: ActionSort::SORTS,
    id: "action_id",
};

/// The policies that operators have set, in all versions.
pub static POLICIES: List = List {
    what: "list the policies",
    select: "SELECT fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, \
             change_margin, changed_us AS changed_at, changed_by, reason FROM policies",
    sorts: PolicySort::SORTS,
    id: "version",
};
