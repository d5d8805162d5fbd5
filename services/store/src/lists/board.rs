//! The board of robots: one lean row for each robot, and the worst whiskers. Both read the few whiskers that are not sound by
//! an index, so that a fleet of ten thousand robots takes tens of milliseconds.

use sqlx::{Database, Encode, QueryBuilder, Type};
use vibrissa_edge::clock::wall_clock;

use super::counts::{alarm_counts, need_counts, presence};
use crate::from_row::from_row;
use crate::labels::RobotLabels;
use crate::list::{Filter, push_filters};
use crate::overview::rows;
use crate::time::Time;
use crate::{Store, StoreError};

/// Most robots of a board.
pub const ROBOTS_MAX: i64 = 100_000;

from_row! {
    /// A robot of the board.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct BoardRow {
        /// Number of the robot.
        pub robot_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Connection state: `ONLINE`, `SILENT`, `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Labels of the robot.
        pub labels: RobotLabels,
        /// Number of trimmed whiskers without a compensation in force.
        pub uncompensated: i64,
        /// Number of whiskers with a fault, except uncompensated ones.
        pub faulty: i64,
        /// Number of worn or suspected whiskers without a fault.
        pub worn: i64,
        /// Number of trimmed whiskers with a compensation in force and without a fault.
        pub compensated: i64,
        /// Number of whiskers that are being learned.
        pub learning: i64,
        /// Number of standing alarms that are not shelved.
        pub alarms: i64,
    }

    /// A whisker that is not sound.
    #[derive(Debug, Clone, PartialEq)]
    pub struct WorstRow {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        pub whisker: i64,
        /// Connection state of the robot.
        pub connection: String,
        /// Mechanical condition, such as `TRIMMED`.
        pub condition: String,
        /// Fault; null without one.
        pub fault: Option<String>,
        /// Number of the compensation in force; null without one.
        pub compensated_by: Option<i64>,
        /// Length that is missing, mm.
        pub lost_mm: f64,
        /// Newest measured error of the compensation in force, as a ratio.
        pub error: Option<f64>,
        /// Time of the cut, or of the standing alarm about the whisker; null without both.
        pub since: Option<Time>,
    }
}

/// The statement of the robots; the filters concern the columns `r.fleet` and `r.robot_id`.
fn robots<DB: Database>(filters: &[Filter]) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let select = concat!(
        "SELECT r.robot_id, r.fleet, r.robot, ",
        presence!("r"),
        " AS connection, r.labels, coalesce(whiskers_uncompensated, 0) AS uncompensated, \
         coalesce(whiskers_faulty, 0) AS faulty, coalesce(whiskers_worn, 0) AS worn, \
         coalesce(whiskers_compensated, 0) AS compensated, coalesce(whiskers_learning, 0) AS learning, \
         coalesce(alarms, 0) AS alarms FROM robots r LEFT JOIN ",
        need_counts!("w.robot_id"),
        " w ON w.robot_id = r.robot_id LEFT JOIN ",
        alarm_counts!("r.robot_id"),
        " a ON a.robot_id = r.robot_id WHERE r.decommissioned_us IS NULL"
    );
    let mut sql = QueryBuilder::<DB>::new(select.replace("{now_us}", &wall_clock().0.to_string()));
    push_filters(&mut sql, filters);
    sql.push(" ORDER BY r.fleet, r.robot LIMIT ").push_bind(ROBOTS_MAX);
    sql
}

/// The statement of the worst whiskers: cut ones without a compensation, then faulty ones, worn ones and compensated ones, each by
/// the length that is missing. Whiskers of a robot that is not heard have no fault of their own. Connection, error and time
/// are read for the few rows of the answer alone.
fn worst<DB: Database>(filters: &[Filter], limit: i64) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new(concat!(
        "SELECT p.fleet, p.robot, y.\"array\", q.whisker, ",
        presence!("p"),
        " AS connection, q.condition, q.fault, compensated_by, lost_mm, \
         (SELECT error FROM compensation_errors e WHERE e.compensation_error_id = \
          (SELECT max(compensation_error_id) FROM compensation_errors n \
           WHERE n.compensation_id = q.compensated_by)) AS error, \
         coalesce(CASE WHEN q.condition = 'TRIMMED' THEN \
           (SELECT max(detected_us) FROM trims t WHERE t.whisker_id = q.whisker_id) END, \
          (SELECT max(raised_us) FROM alarms a WHERE a.whisker_id = q.whisker_id AND cleared_us IS NULL)) AS since \
         FROM (SELECT w.robot_id, w.array_id, w.whisker_id, w.whisker, w.condition, w.fault, \
          c.served AS compensated_by, w.whole_length_mm - w.length_mm AS lost_mm, \
          CASE WHEN w.condition = 'TRIMMED' AND c.served IS NULL THEN 0 WHEN w.fault IS NOT NULL THEN 1 \
           WHEN w.condition <> 'TRIMMED' THEN 2 ELSE 3 END AS urgency \
          FROM whiskers w JOIN robots r ON r.robot_id = w.robot_id LEFT JOIN \
          (SELECT target_whisker_id, max(compensation_id) AS served FROM compensations WHERE ended_us IS NULL \
           AND compensator_whisker_id IS NOT NULL AND approval <> 'PROPOSED' GROUP BY target_whisker_id) c \
           ON c.target_whisker_id = w.whisker_id \
          WHERE w.position IS NOT NULL AND (w.condition <> 'HEALTHY' OR w.fault IS NOT NULL) \
          AND (w.condition NOT IN ('HEALTHY', 'LEARNING') OR w.fault <> 'STALE' OR ",
        presence!("r"),
        " = 'ONLINE') AND (w.condition <> 'LEARNING' OR w.fault IS NOT NULL)"
    ));
    push_filters(&mut sql, filters);
    sql.push(" ORDER BY urgency, lost_mm DESC, w.whisker_id LIMIT ").push_bind(limit);
    sql.push(
        ") q JOIN arrays y ON y.array_id = q.array_id JOIN robots p ON p.robot_id = q.robot_id \
         ORDER BY urgency, lost_mm DESC, q.whisker_id",
    );
    sql
}

impl Store {
    /// All robots in service that the filters select, by fleet and name, at most [`ROBOTS_MAX`]. The filters concern the
    /// columns `r.fleet` and `r.robot_id`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn board_robots(&self, filters: &[Filter]) -> Result<Vec<BoardRow>, StoreError> {
        rows!(self, "read the board of robots", robots(filters))
    }

    /// The worst whiskers, at most as many as the limit says. The filters concern the columns `r.fleet` and `r.robot_id`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn worst_whiskers(&self, filters: &[Filter], limit: i64) -> Result<Vec<WorstRow>, StoreError> {
        rows!(self, "list the worst whiskers", worst(filters, limit))
    }
}
