//! Staged roll-outs, with the result of the newest comparison.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::{Json, from_row};
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A staged roll-out of a policy or a calibration in a fleet.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Rollout {
        /// Number of the roll-out, which is that of the action that began it.
        pub rollout_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Kind of the change: `POLICY` or `CALIBRATION`.
        pub kind: String,
        /// The policy, or number and content of the calibration.
        #[schema(value_type = Object)]
        pub change: Json,
        /// `RUNNING`; `PAUSED` by a person; `ROLLED_BACK`, by a person or because the changed robots were worse; `COMPLETED`: the
        /// change is in force in the whole fleet.
        pub state: String,
        /// Share of the robots that are changed: `FEW` (5 %), `QUARTER` (25 %) or `ALL`.
        pub stage: String,
        /// Probability that a change without an effect is rolled back, at most.
        pub level: f64,
        /// Number of changed robots with an error that complete a stage.
        #[schema(minimum = 4)]
        pub robots: i64,
        /// Number of comparisons in this stage so far, at most 3.
        #[schema(minimum = 0)]
        pub looks: i64,
        /// Probability that chance alone makes the changed robots look so much worse, by the newest comparison; null before it.
        pub probability: Option<f64>,
        /// Number of changed robots with an error in this stage.
        #[schema(minimum = 0)]
        pub changed_robots: i64,
        /// Number of unchanged robots with an error in this stage.
        #[schema(minimum = 0)]
        pub unchanged_robots: i64,
        /// Median error of the changed robots, as a ratio; null without one.
        pub changed_error: Option<f64>,
        /// Median error of the unchanged robots, as a ratio; null without one.
        pub unchanged_error: Option<f64>,
        /// Time at which it began, by the supervisor's clock.
        pub started_at: Time,
        /// Time at which its stage began, by the supervisor's clock.
        pub stage_at: Time,
        /// Time of its newest change, by the supervisor's clock.
        pub updated_at: Time,
        /// Person or token that began it.
        pub started_by: String,
        /// Reason that the person gave, as free text; null if none was given.
        pub reason: Option<String>,
    }
}

sorts! {
    /// Sort keys of the list of roll-outs.
    pub enum RolloutSort {
        /// By number, which is the order in which they began.
        RolloutId = "rollout_id" Whole Down,
    }
}

/// All roll-outs of all fleets.
pub static ROLLOUTS: List = List {
    what: "list the roll-outs",
    select: "SELECT rollout_id, fleet, kind, change, state, stage, level, robots, looks, probability, changed_robots, \
             unchanged_robots, changed_error, unchanged_error, started_us AS started_at, stage_us AS stage_at, \
             updated_us AS updated_at, started_by, reason FROM rollouts",
    details: "",
    keys: &[],
    sorts: RolloutSort::SORTS,
    id: "rollout_id",
};
