//! What people have asked for, and the policies that they have set.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// Something that somebody has asked for: an entry of the audit log.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    #[schema(as = Action)]
    pub struct ActionRow {
        /// Number, in the order of asking.
        pub action_id: i64,
        /// The fleet; null where no fleet is concerned.
        pub fleet: Option<String>,
        /// The robot; null for a whole fleet.
        pub robot: Option<String>,
        /// The whisker's array.
        pub array: Option<String>,
        /// The whisker's number.
        pub whisker: Option<i64>,
        /// The compensation.
        pub compensation_id: Option<i64>,
        /// The alarm.
        pub alarm_id: Option<i64>,
        /// What: `APPROVE`, `REFUSE`, `SETPOINT`, `HOLD`, `RELEASE`, `REPLACED`, `REBASELINE`, `POLICY`,
        /// `ALARM_ACKNOWLEDGE`, `ALARM_SHELVE`, `ALARM_UNSHELVE` ...
        pub kind: String,
        /// Its details: a JSON object, as text.
        pub parameters: String,
        /// Why, in the person's words.
        pub reason: Option<String>,
        /// Who asked.
        pub actor: String,
        /// In which role.
        pub role: String,
        /// The request that it came with.
        pub request_id: String,
        /// When it was asked.
        pub asked_at: Time,
        /// `PENDING`, `DONE`, `REFUSED` or `EXPIRED`.
        pub state: String,
        /// Why it was refused.
        pub problem: Option<String>,
        /// When it was answered; null while it is pending.
        pub done_at: Option<Time>,
    }

    /// A policy: how compensations are decided in a fleet.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    #[schema(as = Policy)]
    pub struct PolicyRow {
        /// The fleet.
        pub fleet: String,
        /// Number, from 1; 0 is the configuration's.
        pub version: i64,
        /// `AUTOMATIC`, or `ADVISE`: compensations wait for approval.
        pub mode: String,
        /// What a setpoint is solved for: `TIP` (equal sensitivity there) or `MEAN` (least mean error).
        pub objective: String,
        /// Whether a longer whisker may stand in for a shorter one: `NEVER`, `LAST_RESORT` or `ALLOWED`.
        pub longer_for_shorter: String,
        /// Highest mean predicted error of a compensation, as a ratio.
        pub predicted_error_max: f64,
        /// What it costs that a neighbour gives up its own role, in units of mean error.
        pub own_role_cost: f64,
        /// What a change of an assignment in force must gain, in units of mean error.
        pub change_margin: f64,
        /// Since when; null for the configuration's.
        pub changed_at: Option<Time>,
        /// Who set it; null for the configuration's.
        pub changed_by: Option<String>,
        /// Why.
        pub reason: Option<String>,
    }
}

sorts! {
    /// What the audit log may be sorted by.
    pub enum ActionSort {
        /// The order of asking.
        ActionId = "action_id" Whole Down,
    }
}

sorts! {
    /// What a fleet's policies may be sorted by.
    pub enum PolicySort {
        /// The order in which they were in force.
        Version = "version" Whole Down,
    }
}

/// Everything that was asked.
pub static ACTIONS: List = List {
    what: "list the actions",
    select: "SELECT action_id, fleet, robot, \"array\", whisker, compensation_id, alarm_id, kind, parameters, reason, actor, \
             role, request_id, asked_us AS asked_at, state, problem, done_us AS done_at FROM actions",
    sorts: ActionSort::SORTS,
    id: "action_id",
};

/// The policies that operators have set.
pub static POLICIES: List = List {
    what: "list the policies",
    select: "SELECT fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, \
             change_margin, changed_us AS changed_at, changed_by, reason FROM policies",
    sorts: PolicySort::SORTS,
    id: "version",
};
