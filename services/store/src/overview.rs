//! The overview of one or several fleets: changes since a time, and the distribution of measured errors. Each query reads
//! a bounded number of rows by an index, so that it costs the same in a fleet of ten robots and of ten thousand.

use serde::Serialize;
use sqlx::{Database, Encode, FromRow, QueryBuilder, Type};
use utoipa::ToSchema;

use super::from_row::from_row;
use super::list::{Filter, push_filters};
use super::set_aside::Tried;
use super::{Store, StoreError};

/// Most changes of a kind that are counted.
pub const CHANGES_MAX: i64 = 100_000;
/// Most compensations in force whose errors are counted; if there are more, some of them are.
pub const COMPENSATIONS_MAX: i64 = 20_000;

from_row! {
    /// Numbers of changes since a time, each at most [`CHANGES_MAX`].
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct Changes {
        /// Number of detected trims.
        pub trims: i64,
        /// Number of setpoints that were issued and applied.
        pub setpoints_applied: i64,
        /// Number of alarms that were raised.
        pub alarms: i64,
        /// Number of whiskers that people marked as replaced.
        pub whiskers_replaced: i64,
    }

    /// Number of changes of a kind in an hour.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct HourOfChanges {
        /// Name of the kind, as in [`Changes`].
        pub kind: String,
        /// Number of the hour, from 0 at the beginning of the span.
        pub hour: i64,
        /// Number of changes.
        pub changes: i64,
    }

    /// Number of compensations whose error is in a bin.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct ErrorBin {
        /// Number of the bin, from 0; its width is a part of the question. The last bin has no upper bound.
        pub bin: i64,
        /// Number of compensations.
        pub compensations: i64,
    }

    /// Whiskers of a model in a fleet.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct ModelUse {
        /// Name of the fleet.
        pub fleet: String,
        /// Number of robots with such whiskers.
        pub robots: i64,
        /// Number of such whiskers on robots now.
        pub whiskers: i64,
    }
}

from_row! {
    /// A robot of an overview, a row of the list of robots.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct RobotRow {
        /// Number of the robot.
        pub robot_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Connection state: `ONLINE`, `SILENT`, `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: String,
        /// Number of things that need attention.
        pub attention: i64,
    }

    /// A whisker of an overview, a row of the list of whiskers.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct OverviewWhisker {
        /// Number of its robot.
        #[serde(skip)]
        pub robot_id: i64,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Position on the array along x, mm.
        pub x_mm: f64,
        /// Position on the array along y, mm.
        pub y_mm: f64,
        /// Estimated present length, mm.
        pub length_mm: f64,
        /// Length of the whole whisker, mm.
        pub whole_length_mm: f64,
        /// Mechanical condition, such as `HEALTHY` or `TRIMMED`.
        pub condition: String,
        /// Fault, such as `LEAK`; null without one.
        pub fault: Option<String>,
        /// Number of the compensation in force for it; null without one.
        pub compensated_by: Option<i64>,
    }
}

/// Each kind of change: its name, the column of its time, its rows up to the time, and how to join them to the fleets'
/// robots. Without filters nothing is joined: the changes are counted from an index alone.
const CHANGES: [(&str, &str, &str, &str); 4] = [
    ("trims", "c.detected_us", "trims c WHERE c.detected_us >= ", OF_ROBOT),
    ("setpoints_applied", "c.issued_us", "setpoints c WHERE c.state = 'APPLIED' AND c.issued_us >= ", OF_ROBOT),
    (
        "alarms",
        "c.raised_us",
        "alarms c WHERE c.raised_us >= ",
        " AND coalesce(c.robot_id, (SELECT w.robot_id FROM whiskers w WHERE w.whisker_id = c.whisker_id)) \
         IN (SELECT r.robot_id FROM robots r WHERE true",
    ),
    (
        "whiskers_replaced",
        "r.asked_us",
        "actions r WHERE r.kind = 'REPLACED' AND r.state = 'DONE' AND r.asked_us >= ",
        " AND (true",
    ),
];
/// The condition that the robot of a change is one of those that the filters select, which follow.
const OF_ROBOT: &str = " AND c.robot_id IN (SELECT r.robot_id FROM robots r WHERE true";

/// Appends the statement of the changes since a time; the filters concern the column `r.fleet`.
fn changes<DB: Database>(filters: &[Filter], from_us: i64) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new("SELECT ");
    for (at, (name, _, rows, of_fleet)) in CHANGES.into_iter().enumerate() {
        sql.push(if at == 0 { "" } else { ", " }).push("(SELECT count(*) FROM (SELECT 1 AS one FROM ").push(rows);
        push_changes(&mut sql, filters, from_us, of_fleet);
        sql.push(" q) AS ").push(name);
    }
    sql
}

/// Appends the end of the statement of one kind of change: time, fleets and limit.
fn push_changes<DB: Database>(sql: &mut QueryBuilder<DB>, filters: &[Filter], from_us: i64, of_fleet: &str)
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    sql.push_bind(from_us);
    if !filters.is_empty() {
        sql.push(of_fleet);
        push_filters(sql, filters);
        sql.push(")");
    }
    sql.push(" LIMIT ").push_bind(CHANGES_MAX).push(")");
}

/// The statement of the changes since a time by hour; the filters concern the columns `r.fleet` and `r.robot_id`.
fn changes_by_hour<DB: Database>(filters: &[Filter], from_us: i64) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new("");
    for (at, (name, time, rows, of_fleet)) in CHANGES.into_iter().enumerate() {
        sql.push(if at == 0 { "SELECT '" } else { " UNION ALL SELECT '" }).push(name).push("' AS kind, (at_us - ");
        sql.push_bind(from_us).push(") / 3600000000 AS hour, count(*) AS changes FROM (SELECT ").push(time);
        sql.push(" AS at_us FROM ").push(rows);
        push_changes(&mut sql, filters, from_us, of_fleet);
        sql.push(" q GROUP BY 2");
    }
    sql
}

/// The statement of the newest measured errors of the compensations in force, counted in `bins` bins of equal width.
fn error_bins<DB: Database>(filters: &[Filter], width: f64, bins: i64) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new("SELECT CAST(CASE");
    for bin in 0..bins - 1 {
        #[expect(clippy::cast_precision_loss, reason = "there are few bins")]
        let end = width * (bin + 1) as f64;
        sql.push(" WHEN error < ").push_bind(end).push(" THEN ").push_bind(bin);
    }
    sql.push(" ELSE ").push_bind(bins - 1).push(
        " END AS BIGINT) AS bin, count(*) AS compensations FROM (SELECT (SELECT error FROM compensation_errors e \
         WHERE e.compensation_id = c.compensation_id ORDER BY recorded_us DESC, compensation_error_id DESC LIMIT 1) AS error \
         FROM compensations c CROSS JOIN robots r WHERE r.robot_id = c.robot_id AND ended_us IS NULL \
         AND compensator_whisker_id IS NOT NULL AND approval <> 'PROPOSED'",
    );
    push_filters(&mut sql, filters);
    sql.push(" LIMIT ").push_bind(COMPENSATIONS_MAX).push(") q WHERE error IS NOT NULL GROUP BY 1 ORDER BY 1");
    sql
}

/// The statement of the whiskers of a model by fleet.
fn model_use<DB: Database>(filters: &[Filter], model: &str) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new(
        "SELECT r.fleet, count(*) AS robots, CAST(sum(n.whiskers) AS BIGINT) AS whiskers FROM \
         (SELECT robot_id, count(*) AS whiskers FROM whiskers WHERE position IS NOT NULL AND model = ",
    );
    sql.push_bind(model.to_owned()).push(" GROUP BY robot_id) n JOIN robots r ON r.robot_id = n.robot_id WHERE true");
    push_filters(&mut sql, filters);
    sql.push(" GROUP BY r.fleet ORDER BY r.fleet");
    sql
}

/// Runs a statement of either database, for all its rows.
macro_rules! rows {
    ($store:expr, $what:literal, $statement:ident($($argument:expr),*)) => {
        match &$store.pool {
            $crate::database::Either::Sqlite(pool) => {
                let mut sql = $statement::<sqlx::Sqlite>($($argument),*);
                let found = sql.build_query_as().persistent(false).fetch_all(pool).await;
                $crate::overview::all::<_, sqlx::sqlite::SqliteRow, _>(found)
            }
            $crate::database::Either::Postgres(pool) => {
                let mut sql = $statement::<sqlx::Postgres>($($argument),*);
                let found = sql.build_query_as().persistent(false).fetch_all(pool).await;
                $crate::overview::all::<_, sqlx::postgres::PgRow, _>(found)
            }
        }
        .map_err($crate::failed($what))
        .map(|found| $store.set_aside.readable("an overview", found))
    };
}
pub(crate) use rows;

/// Names the row's type for the compiler.
pub(crate) fn all<T, R, E>(found: Result<Vec<Tried<T>>, E>) -> Result<Vec<Tried<T>>, E>
where
    R: sqlx::Row,
    T: for<'r> FromRow<'r, R>,
{
    found
}

impl Store {
    /// Numbers of changes since a time. The filters concern the column `r.fleet`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn changes_since(&self, filters: &[Filter], from_us: i64) -> Result<Changes, StoreError> {
        let found: Vec<Changes> = rows!(self, "count the changes", changes(filters, from_us))?;
        let none = Changes { trims: 0, setpoints_applied: 0, alarms: 0, whiskers_replaced: 0 };
        Ok(found.into_iter().next().unwrap_or(none))
    }

    /// Numbers of changes since a time by hour; hours without changes are missing. The filters concern the columns
    /// `r.fleet` and `r.robot_id`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn changes_by_hour(&self, filters: &[Filter], from_us: i64) -> Result<Vec<HourOfChanges>, StoreError> {
        rows!(self, "count the changes by hour", changes_by_hour(filters, from_us))
    }

    /// The newest measured errors of the compensations in force, counted in bins of a width; empty bins are missing. The
    /// filters concern the column `r.fleet`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn error_bins(&self, filters: &[Filter], width: f64, bins: i64) -> Result<Vec<ErrorBin>, StoreError> {
        rows!(self, "count the errors", error_bins(filters, width, bins))
    }

    /// The whiskers of a model by fleet. The filters concern the column `r.fleet`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn model_use(&self, filters: &[Filter], model: &str) -> Result<Vec<ModelUse>, StoreError> {
        rows!(self, "count the whiskers of a model", model_use(filters, model))
    }
}
