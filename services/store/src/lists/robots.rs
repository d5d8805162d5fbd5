//! Robots and their arrays, with how many of what they have.

use serde::Serialize;
use utoipa::ToSchema;

use super::counts::{alarm_counts, proposal_counts, whisker_counts};
use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// A robot with its counts.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct RobotSummary {
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Its model, of the factsheet; null before the first one.
        pub model: Option<String>,
        /// Whether it is connected: `ONLINE`, `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Its newest boot; null before the first one.
        pub boot_id: Option<String>,
        /// When anything of it changed last, by the supervisor's clock; null before the first message was committed.
        pub updated_at: Option<Time>,
        /// Arrays that are on it.
        #[schema(minimum = 0)]
        pub arrays: i64,
        /// Whiskers that are on it.
        #[schema(minimum = 0)]
        pub whiskers: i64,
        /// Those in condition `HEALTHY` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_healthy: i64,
        /// Those in condition `TRIMMED`.
        #[schema(minimum = 0)]
        pub whiskers_trimmed: i64,
        /// Trimmed ones that no compensation in force serves.
        #[schema(minimum = 0)]
        pub whiskers_uncompensated: i64,
        /// Those with a fault.
        #[schema(minimum = 0)]
        pub whiskers_faulty: i64,
        /// Alarms that stand and are not shelved.
        #[schema(minimum = 0)]
        pub alarms: i64,
        /// Decisions that wait for somebody's word.
        #[schema(minimum = 0)]
        pub proposals: i64,
        /// Whether an operator holds it: nothing moves its whiskers but by hand.
        pub held: bool,
        /// How much there is to look at: alarms, faulty and uncompensated whiskers, proposals, added up; one more if it is
        /// not connected.
        #[schema(minimum = 0)]
        pub attention: i64,
    }

    /// An array with its counts.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct ArraySummary {
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// `TYPE_1` (whiskers compensate for one another) or `TYPE_2` (single ones, for themselves).
        pub array_type: String,
        /// Whether its robot is connected: `ONLINE`, `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Whiskers that are on it.
        #[schema(minimum = 0)]
        pub whiskers: i64,
        /// Those in condition `HEALTHY` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_healthy: i64,
        /// Those in condition `TRIMMED`.
        #[schema(minimum = 0)]
        pub whiskers_trimmed: i64,
        /// Trimmed ones that no compensation in force serves.
        #[schema(minimum = 0)]
        pub whiskers_uncompensated: i64,
        /// Those with a fault.
        #[schema(minimum = 0)]
        pub whiskers_faulty: i64,
        /// Alarms that stand.
        #[schema(minimum = 0)]
        pub alarms: i64,
        /// How much there is to look at: alarms, faulty and uncompensated whiskers, added up.
        #[schema(minimum = 0)]
        pub attention: i64,
    }
}

sorts! {
    /// What a list of robots may be sorted by.
    pub enum RobotSort {
        /// How much there is to look at.
        Attention = "attention" Whole Down,
        /// Name.
        Robot = "robot" Text Up,
        /// The order in which they became known.
        RobotId = "robot_id" Whole Up,
    }
}

sorts! {
    /// What a list of arrays may be sorted by.
    pub enum ArraySort {
        /// How much there is to look at.
        Attention = "attention" Whole Down,
        /// The order in which they became known.
        ArrayId = "array_id" Whole Up,
    }
}

/// Robots that were ever heard of.
pub static ROBOTS: List = List {
    what: "list the robots",
    select: concat!(
        "SELECT r.robot_id, r.fleet, r.robot, r.model, r.connection, r.boot_id, \
         CASE WHEN updated_us > 0 THEN updated_us END AS updated_at, coalesce(arrays, 0) AS arrays, \
         coalesce(whiskers, 0) AS whiskers, coalesce(whiskers_healthy, 0) AS whiskers_healthy, \
         coalesce(whiskers_trimmed, 0) AS whiskers_trimmed, \
         coalesce(whiskers_uncompensated, 0) AS whiskers_uncompensated, \
         coalesce(whiskers_faulty, 0) AS whiskers_faulty, coalesce(alarms, 0) AS alarms, \
         coalesce(proposals, 0) AS proposals, r.held, \
         coalesce(alarms, 0) + coalesce(proposals, 0) + coalesce(whiskers_faulty, 0) + coalesce(whiskers_uncompensated, 0) \
         + CASE WHEN connection = 'ONLINE' THEN 0 ELSE 1 END AS attention FROM robots r \
         LEFT JOIN (SELECT robot_id, count(DISTINCT array_id) AS arrays FROM whiskers WHERE position IS NOT NULL \
          GROUP BY robot_id) n ON n.robot_id = r.robot_id \
         LEFT JOIN ",
        whisker_counts!("w.robot_id"),
        " w ON w.robot_id = r.robot_id LEFT JOIN ",
        alarm_counts!("w.robot_id"),
        " a ON a.robot_id = r.robot_id LEFT JOIN ",
        proposal_counts!("r.robot_id"),
        " o ON o.robot_id = r.robot_id"
    ),
    sorts: RobotSort::SORTS,
    id: "robot_id",
};

/// Arrays that are on a robot now.
pub static ARRAYS: List = List {
    what: "list the arrays",
    select: concat!(
        "SELECT y.array_id, fleet, robot, \"array\", array_type, connection, whiskers, whiskers_healthy, \
         whiskers_trimmed, whiskers_uncompensated, whiskers_faulty, coalesce(alarms, 0) AS alarms, \
         coalesce(alarms, 0) + whiskers_faulty + whiskers_uncompensated AS attention \
         FROM arrays y JOIN robots b ON b.robot_id = y.robot_id JOIN ",
        whisker_counts!("w.array_id"),
        " w ON w.array_id = y.array_id LEFT JOIN ",
        alarm_counts!("w.array_id"),
        " a ON a.array_id = y.array_id"
    ),
    sorts: ArraySort::SORTS,
    id: "array_id",
};
