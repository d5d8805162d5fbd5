//! Robots and their arrays, with counts of their whiskers, alarms and proposals.

use serde::Serialize;
use utoipa::ToSchema;

use super::counts::{alarm_counts, need_counts, presence, proposal_counts};
use super::sorts;
use crate::from_row::from_row;
use crate::labels::RobotLabels;
use crate::list::List;
use crate::programs::RobotPrograms;
use crate::time::Time;

from_row! {
    /// A robot with counts of its whiskers, alarms and proposals.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct RobotSummary {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Model of the robot, by its factsheet; null before the first factsheet.
        pub model: Option<String>,
        /// Programs of the robot by its factsheet, such as agent, drivers and firmware; empty if it names none.
        #[schema(value_type = Vec<crate::programs::RobotProgram>)]
        pub software: RobotPrograms,
        /// Connection state: `ONLINE`, `SILENT` (connected, but not heard), `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Newest boot of the robot; null before the first.
        pub boot_id: Option<String>,
        /// Time of the last change of the robot's record, by the supervisor's clock; null before the first message
        /// was committed.
        pub updated_at: Option<Time>,
        /// Number of arrays on the robot now.
        #[schema(minimum = 0)]
        pub arrays: i64,
        /// Number of whiskers on the robot now.
        #[schema(minimum = 0)]
        pub whiskers: i64,
        /// Number of whiskers in condition `HEALTHY` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_healthy: i64,
        /// Number of whiskers in condition `LEARNING` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_learning: i64,
        /// Number of whiskers in condition `SUSPECTED`, `ERODING` or `SENSITIVITY_LOSS` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_worn: i64,
        /// Number of trimmed whiskers with a compensation in force and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_compensated: i64,
        /// Number of whiskers in condition `TRIMMED`, which the other counts contain, too.
        #[schema(minimum = 0)]
        pub whiskers_trimmed: i64,
        /// Number of trimmed whiskers without a compensation in force, with or without a fault.
        #[schema(minimum = 0)]
        pub whiskers_uncompensated: i64,
        /// Number of whiskers with a fault, except uncompensated ones.
        #[schema(minimum = 0)]
        pub whiskers_faulty: i64,
        /// Number of standing alarms that are not shelved.
        #[schema(minimum = 0)]
        pub alarms: i64,
        /// Number of standing alarms that are shelved.
        #[schema(minimum = 0)]
        pub alarms_shelved: i64,
        /// Number of compensations that wait for an operator's approval.
        #[schema(minimum = 0)]
        pub proposals: i64,
        /// Whether an operator holds the robot: no automatic setpoint is sent to a held robot.
        pub held: bool,
        /// Labels that operators put on the robot, by key.
        #[schema(value_type = std::collections::BTreeMap<String, String>)]
        pub labels: RobotLabels,
        /// Number of things that need attention: `alarms`. Each thing has one alarm, such as a silent robot or a proposal.
        #[schema(minimum = 0)]
        pub attention: i64,
    }

    /// An array with counts of its whiskers and alarms.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct ArraySummary {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// `TYPE_1` (whiskers compensate for one another) or `TYPE_2` (each whisker compensates only for itself).
        pub array_type: String,
        /// Connection state of the robot: `ONLINE`, `SILENT` (connected, but not heard), `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Number of whiskers on the array now.
        #[schema(minimum = 0)]
        pub whiskers: i64,
        /// Number of whiskers in condition `HEALTHY` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_healthy: i64,
        /// Number of whiskers in condition `LEARNING` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_learning: i64,
        /// Number of whiskers in condition `SUSPECTED`, `ERODING` or `SENSITIVITY_LOSS` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_worn: i64,
        /// Number of trimmed whiskers with a compensation in force and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_compensated: i64,
        /// Number of whiskers in condition `TRIMMED`, which the other counts contain, too.
        #[schema(minimum = 0)]
        pub whiskers_trimmed: i64,
        /// Number of trimmed whiskers without a compensation in force, with or without a fault.
        #[schema(minimum = 0)]
        pub whiskers_uncompensated: i64,
        /// Number of whiskers with a fault, except uncompensated ones.
        #[schema(minimum = 0)]
        pub whiskers_faulty: i64,
        /// Number of standing alarms that are not shelved.
        #[schema(minimum = 0)]
        pub alarms: i64,
        /// Number of standing alarms that are shelved.
        #[schema(minimum = 0)]
        pub alarms_shelved: i64,
        /// Number of things that need attention: `alarms`. An alarm about the whole robot is not among them.
        #[schema(minimum = 0)]
        pub attention: i64,
    }
}

sorts! {
    /// Sort keys of the list of robots.
    pub enum RobotSort {
        /// By number of things that need attention.
        Attention = "attention" Whole Down,
        /// By name of the robot.
        Robot = "robot" Text Up,
        /// By connection state.
        Connection = "connection" Text Up,
        /// By number of trimmed whiskers.
        WhiskersTrimmed = "whiskers_trimmed" Whole Down,
        /// By number of trimmed whiskers without a compensation in force.
        WhiskersUncompensated = "whiskers_uncompensated" Whole Down,
        /// By number of standing alarms.
        Alarms = "alarms" Whole Down,
        /// By the order in which they became known.
        RobotId = "robot_id" Whole Up,
    }
}

sorts! {
    /// Sort keys of the list of arrays.
    pub enum ArraySort {
        /// By number of things that need attention.
        Attention = "attention" Whole Down,
        /// By the order in which they became known.
        ArrayId = "array_id" Whole Up,
    }
}

/// All robots in service.
pub static ROBOTS: List = List {
    what: "list the robots",
    select: concat!(
        "SELECT r.robot_id, r.fleet, r.robot, r.model, r.software, ",
        presence!("r"),
        " AS connection, r.boot_id, \
         CASE WHEN updated_us > 0 THEN updated_us END AS updated_at, \
         coalesce(whiskers_unsound, 0) AS whiskers_unsound, \
         coalesce(whiskers_learning, 0) AS whiskers_learning, coalesce(whiskers_worn, 0) AS whiskers_worn, \
         coalesce(whiskers_compensated, 0) AS whiskers_compensated, \
         coalesce(whiskers_trimmed, 0) AS whiskers_trimmed, \
         coalesce(whiskers_uncompensated, 0) AS whiskers_uncompensated, \
         coalesce(whiskers_faulty, 0) AS whiskers_faulty, coalesce(alarms, 0) AS alarms, \
         coalesce(alarms_shelved, 0) AS alarms_shelved, coalesce(proposals, 0) AS proposals, r.held, r.labels, \
         coalesce(alarms, 0) AS attention FROM robots r LEFT JOIN ",
        need_counts!("w.robot_id"),
        " w ON w.robot_id = r.robot_id LEFT JOIN ",
        alarm_counts!("r.robot_id"),
        " a ON a.robot_id = r.robot_id LEFT JOIN ",
        proposal_counts!("r.robot_id"),
        " o ON o.robot_id = r.robot_id WHERE r.decommissioned_us IS NULL"
    ),
    details: ", (SELECT count(*) FROM arrays y WHERE y.robot_id = q.robot_id AND whiskers > 0) AS arrays, \
              (SELECT CAST(coalesce(sum(whiskers), 0) AS BIGINT) FROM arrays y WHERE y.robot_id = q.robot_id) AS whiskers, \
              (SELECT CAST(coalesce(sum(whiskers), 0) AS BIGINT) FROM arrays y WHERE y.robot_id = q.robot_id) \
              - whiskers_unsound AS whiskers_healthy",
    keys: &[],
    sorts: RobotSort::SORTS,
    id: "robot_id",
};

/// The arrays that are on a robot now.
pub static ARRAYS: List = List {
    what: "list the arrays",
    select: concat!(
        "SELECT y.array_id, fleet, robot, \"array\", array_type, ",
        presence!("b"),
        " AS connection, y.whiskers, \
         y.whiskers - coalesce(whiskers_unsound, 0) AS whiskers_healthy, \
         coalesce(whiskers_unsound, 0) AS whiskers_unsound, \
         coalesce(whiskers_learning, 0) AS whiskers_learning, coalesce(whiskers_worn, 0) AS whiskers_worn, \
         coalesce(whiskers_compensated, 0) AS whiskers_compensated, \
         coalesce(whiskers_trimmed, 0) AS whiskers_trimmed, \
         coalesce(whiskers_uncompensated, 0) AS whiskers_uncompensated, \
         coalesce(whiskers_faulty, 0) AS whiskers_faulty, coalesce(alarms, 0) AS alarms, \
         coalesce(alarms_shelved, 0) AS alarms_shelved, coalesce(alarms, 0) AS attention \
         FROM arrays y JOIN robots b ON b.robot_id = y.robot_id LEFT JOIN ",
        need_counts!("w.array_id"),
        " w ON w.array_id = y.array_id LEFT JOIN ",
        alarm_counts!("w.array_id"),
        " a ON a.array_id = y.array_id \
         WHERE y.whiskers > 0"
    ),
    details: "",
    keys: &[],
    sorts: ArraySort::SORTS,
    id: "array_id",
};
