//! Statistics of alarms as ISA-18.2 names them: how many, how often, how long, and which ones most. The database
//! computes them over the newest [`ALARMS_MAX`] alarms of a span.

use serde::Serialize;
use sqlx::{Database, Encode, QueryBuilder, Type};
use utoipa::ToSchema;

use super::from_row::from_row;
use super::list::{Filter, push_filters};
use super::overview::rows;
use super::time::Time;
use super::{Store, StoreError};

/// Most alarms over which statistics are computed: the newest ones.
pub const ALARMS_MAX: i64 = 100_000;
/// Number of alarms in ten minutes above which nobody can answer each of them: a flood.
pub const FLOOD: i64 = 10;
/// Length of the intervals in which floods are looked for, and time within which three alarms of one kind and subject
/// chatter, µs: ten minutes. A whisker gets a contact every few seconds, so that its alarms chatter slower than those
/// of a process, for which the standard's example is a minute.
const TEN_MINUTES_US: i64 = 600_000_000;
/// Time after which a standing alarm counts as stale, µs: a day.
const DAY_US: i64 = 86_400_000_000;
/// Most rows of each list.
const ROWS_MAX: i64 = 10;

from_row! {
    /// Numbers of alarms of a span.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct AlarmNumbers {
        /// Number of alarms that were raised, at most [`ALARMS_MAX`].
        pub alarms: i64,
        /// Largest number of alarms in ten minutes.
        pub busiest: i64,
        /// Number of intervals of ten minutes with more than [`FLOOD`] alarms.
        pub floods: i64,
        /// Number of these alarms that are over.
        pub cleared: i64,
        /// Median time from raising to clearing of those that are over, µs.
        pub median_us: Option<i64>,
        /// Longest time from raising to clearing of those that are over, µs.
        pub longest_us: Option<i64>,
        /// Number of alarms that stand now, whenever they were raised.
        pub standing: i64,
        /// Number of alarms that have stood for more than a day.
        pub stale: i64,
    }

    /// Number of alarms of a kind.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct KindCount {
        /// Kind of alarm.
        pub kind: String,
        /// Number of alarms.
        pub alarms: i64,
    }

    /// Alarms of one kind about one whisker, or about one robot as a whole.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct AlarmsOfSubject {
        /// Kind of alarm.
        pub kind: String,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array; null for alarms about the robot as a whole.
        pub array: Option<String>,
        /// Number of the whisker in its array; null for alarms about the robot as a whole.
        #[schema(minimum = 0)]
        pub whisker: Option<i64>,
        /// Number of alarms that were raised in the span.
        #[schema(minimum = 1)]
        pub alarms: i64,
        /// Number of them that were the third within ten minutes, or a later one.
        #[schema(minimum = 0)]
        pub chattering: i64,
        /// Time at which the last of them was raised.
        pub last_raised_at: Time,
    }

    /// An alarm that has stood for more than a day.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct StaleAlarm {
        /// Number of the alarm.
        #[schema(minimum = 0)]
        pub alarm_id: i64,
        /// Kind of alarm.
        pub kind: String,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array; null for an alarm about the robot as a whole.
        pub array: Option<String>,
        /// Number of the whisker in its array; null for an alarm about the robot as a whole.
        #[schema(minimum = 0)]
        pub whisker: Option<i64>,
        /// Time at which it was raised.
        pub raised_at: Time,
    }
}

/// The alarms of a span, and the fleets that are concerned: the filters concern the column `r.fleet`.
#[derive(Debug, Clone)]
pub struct Span {
    /// Conditions on the fleets.
    pub filters: Vec<Filter>,
    /// Earliest time of raising, µs since 1970 UTC.
    pub from_us: i64,
    /// Latest time of raising, exclusive.
    pub to_us: i64,
    /// The present time.
    pub now_us: i64,
}

/// Statistics of the alarms of a span.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AlarmStatistics {
    /// The numbers of the whole span.
    pub numbers: AlarmNumbers,
    /// Numbers by kind.
    pub kinds: Vec<KindCount>,
    /// The ten subjects with the most alarms.
    pub top: Vec<AlarmsOfSubject>,
    /// At most ten subjects whose alarms chatter, those with the most alarms first.
    pub chattering: Vec<AlarmsOfSubject>,
    /// At most ten alarms that have stood for more than a day, the oldest first.
    pub stale: Vec<StaleAlarm>,
}

const RAISED: &str = "WITH raised AS (SELECT a.alarm_id, a.kind, a.whisker_id, r.robot_id, a.raised_us, a.cleared_us FROM alarms a \
     LEFT JOIN whiskers w ON w.whisker_id = a.whisker_id JOIN robots r ON r.robot_id = coalesce(a.robot_id, w.robot_id) \
     WHERE a.raised_us >= ";
const STANDING: &str = "SELECT count(*) FROM alarms a LEFT JOIN whiskers w ON w.whisker_id = a.whisker_id \
     JOIN robots r ON r.robot_id = coalesce(a.robot_id, w.robot_id) WHERE a.cleared_us IS NULL";

/// Begins a statement with the common table `raised`.
fn raised<DB: Database>(span: &Span) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new(RAISED);
    sql.push_bind(span.from_us).push(" AND a.raised_us < ").push_bind(span.to_us);
    push_filters(&mut sql, &span.filters);
    sql.push(" ORDER BY a.raised_us DESC, a.alarm_id DESC LIMIT ").push_bind(ALARMS_MAX).push(")");
    sql
}

/// The statement of [`AlarmNumbers`].
fn numbers<DB: Database>(span: &Span) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = raised::<DB>(span);
    sql.push(format!(
        ", tens AS (SELECT raised_us / {TEN_MINUTES_US} AS ten, count(*) AS n FROM raised GROUP BY 1), \
         ended AS (SELECT cleared_us - raised_us AS d FROM raised WHERE cleared_us IS NOT NULL), \
         sorted AS (SELECT d, row_number() OVER (ORDER BY d) AS nth, count(*) OVER () AS many FROM ended) \
         SELECT (SELECT count(*) FROM raised) AS alarms, coalesce((SELECT max(n) FROM tens), 0) AS busiest, \
         (SELECT count(*) FROM tens WHERE n > {FLOOD}) AS floods, (SELECT count(*) FROM ended) AS cleared, \
         (SELECT CAST(avg(d) AS BIGINT) FROM sorted WHERE nth IN ((many + 1) / 2, (many + 2) / 2)) AS median_us, \
         (SELECT max(d) FROM ended) AS longest_us, ("
    ));
    sql.push(STANDING);
    push_filters(&mut sql, &span.filters);
    sql.push(") AS standing, (").push(STANDING).push(" AND a.raised_us < ").push_bind(span.now_us - DAY_US);
    push_filters(&mut sql, &span.filters);
    sql.push(") AS stale");
    sql
}

/// The statement of the numbers by kind.
fn kinds<DB: Database>(span: &Span) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = raised::<DB>(span);
    sql.push(" SELECT kind, count(*) AS alarms FROM raised GROUP BY kind ORDER BY alarms DESC, kind");
    sql
}

/// The statement of the subjects with the most alarms, of all or of those that chatter.
fn subjects<DB: Database>(span: &Span, is_chattering: bool) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = raised::<DB>(span);
    sql.push(format!(
        ", steps AS (SELECT raised.*, CASE WHEN raised_us - lag(raised_us, 2) OVER \
         (PARTITION BY kind, robot_id, whisker_id ORDER BY raised_us, alarm_id) <= {TEN_MINUTES_US} THEN 1 ELSE 0 END AS third \
         FROM raised), \
         most AS (SELECT kind, robot_id, whisker_id, count(*) AS alarms, sum(third) AS chattering, \
          max(raised_us) AS last_raised_at FROM steps GROUP BY kind, robot_id, whisker_id HAVING sum(third) >= {} \
          ORDER BY alarms DESC, last_raised_at DESC LIMIT {ROWS_MAX}) \
         SELECT most.kind, fleet, robot, \"array\", w.whisker, alarms, chattering, last_raised_at FROM most \
         JOIN robots r ON r.robot_id = most.robot_id LEFT JOIN whiskers w ON w.whisker_id = most.whisker_id \
         LEFT JOIN arrays y ON y.array_id = w.array_id ORDER BY alarms DESC, last_raised_at DESC",
        i64::from(is_chattering)
    ));
    sql
}

/// The statement of the alarms that have stood for more than a day.
fn stale<DB: Database>(span: &Span) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new(
        "SELECT a.alarm_id, a.kind, fleet, robot, \"array\", w.whisker, a.raised_us AS raised_at FROM alarms a \
         LEFT JOIN whiskers w ON w.whisker_id = a.whisker_id LEFT JOIN arrays y ON y.array_id = w.array_id \
         JOIN robots r ON r.robot_id = coalesce(a.robot_id, w.robot_id) WHERE a.cleared_us IS NULL AND a.raised_us < ",
    );
    sql.push_bind(span.now_us - DAY_US);
    push_filters(&mut sql, &span.filters);
    sql.push(" ORDER BY a.raised_us, a.alarm_id LIMIT ").push_bind(ROWS_MAX);
    sql
}

impl Store {
    /// Statistics of the alarms of a span.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn alarm_statistics(&self, span: &Span) -> Result<AlarmStatistics, StoreError> {
        let found: Vec<AlarmNumbers> = rows!(self, "count the alarms of a span", numbers(span))?;
        let none = AlarmNumbers {
            alarms: 0,
            busiest: 0,
            floods: 0,
            cleared: 0,
            median_us: None,
            longest_us: None,
            standing: 0,
            stale: 0,
        };
        Ok(AlarmStatistics {
            numbers: found.into_iter().next().unwrap_or(none),
            kinds: rows!(self, "count the alarms by kind", kinds(span))?,
            top: rows!(self, "find the most frequent alarms", subjects(span, false))?,
            chattering: rows!(self, "find the chattering alarms", subjects(span, true))?,
            stale: rows!(self, "find the alarms that stand for long", stale(span))?,
        })
    }
}
