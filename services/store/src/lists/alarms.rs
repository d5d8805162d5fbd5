//! Alarms: all of them, the standing ones with storms folded, and their counts.

use serde::Serialize;
use utoipa::ToSchema;

use super::black_boxes::box_of;
use super::counts::alarms;
use super::sorts;
use crate::from_row::from_row;
use crate::labels::RobotLabels;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// An alarm about a whisker, or about a robot as a whole.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct AlarmRow {
        /// Number of the alarm.
        #[schema(minimum = 0)]
        pub alarm_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array; null for an alarm about the robot as a whole.
        pub array: Option<String>,
        /// Number of the whisker in its array; null for an alarm about the robot as a whole.
        #[schema(minimum = 0)]
        pub whisker: Option<i64>,
        /// Kind of alarm, such as `UNCOMPENSATED`, or a fault, such as `LEAK`: one of the values of the filter `kind`.
        pub kind: String,
        /// Time at which it was raised, by the supervisor's clock.
        pub raised_at: Time,
        /// Whether its cause persists.
        pub standing: bool,
        /// Time at which its cause ended, by the supervisor's clock; null while it stands.
        pub cleared_at: Option<Time>,
        /// Time at which it was acknowledged; null if it was not.
        pub acknowledged_at: Option<Time>,
        /// Person or token that acknowledged it; null if it was not acknowledged.
        pub acknowledged_by: Option<String>,
        /// Comment given with the acknowledgement; null without a comment.
        pub acknowledged_reason: Option<String>,
        /// Time until which it is shelved, by a person or by a window of maintenance; null if it is not shelved.
        pub shelved_until: Option<Time>,
        /// Person or token that shelved it; null if it is not shelved.
        pub shelved_by: Option<String>,
        /// Reason given for shelving it; null if it is not shelved.
        pub shelved_reason: Option<String>,
        /// Number of the window of maintenance that shelves it; null unless one does.
        #[schema(minimum = 1)]
        pub maintenance_id: Option<i64>,
        /// State: `UNACKNOWLEDGED`, `ACKNOWLEDGED`, `SHELVED` or `CLEARED`.
        pub state: String,
        /// Number of the black box with the robot's messages around it; null without a box.
        #[schema(minimum = 0)]
        pub black_box_id: Option<i64>,
        /// Labels of the robot, by key.
        #[schema(value_type = std::collections::BTreeMap<String, String>)]
        pub labels: RobotLabels,
        /// Length that the whisker has lost by now, mm; null for an alarm about the robot as a whole.
        pub lost_mm: Option<f64>,
        /// Number of the newest decision about the whisker that has not ended; null without one.
        #[schema(minimum = 0)]
        pub compensation_id: Option<i64>,
        /// Most frequent reason for which that decision refused a candidate, such as `NEEDS_BELOW_RANGE`; null unless
        /// the whisker is not compensated.
        pub refused: Option<String>,
        /// Number of candidates that were refused for this reason; null unless the whisker is not compensated.
        #[schema(minimum = 0)]
        pub refused_candidates: Option<i64>,
        /// State of the newest setpoint of the whisker that was not applied: `REJECTED`, `FAILED` or `EXPIRED`; null
        /// unless the alarm is about setpoints and stands.
        pub failed_state: Option<String>,
        /// Reason that the robot gave for rejecting it; null without one.
        pub failed_error: Option<String>,
        /// Pressure that it was to reach, MPa; null unless the alarm is about setpoints and stands.
        pub failed_pressure_mpa: Option<f64>,
        /// Number of setpoints of the whisker that were not applied since the last one that was; null unless the alarm
        /// is about setpoints and stands.
        #[schema(minimum = 0)]
        pub failed_attempts: Option<i64>,
    }

    /// How many alarms a folded row stands for.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct Fold {
        /// Number of alarms: 1, or that of a storm of more than 10 alarms of this kind in this fleet, each raised within 5
        /// minutes of the one before. The other fields are those of its newest alarm.
        #[schema(minimum = 1)]
        pub alarms: i64,
        /// Number of robots that they concern.
        #[schema(minimum = 1)]
        pub robots: i64,
        /// Number of them that are not acknowledged and not shelved.
        #[schema(minimum = 0)]
        pub unacknowledged: i64,
        /// Time at which the first of them was raised.
        pub first_raised_at: Time,
        /// Time at which the last of them was raised.
        pub last_raised_at: Time,
    }

    /// Number of alarms of a kind in a fleet.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct AlarmCount {
        /// Name of the fleet.
        pub fleet: String,
        /// Kind of alarm.
        pub kind: String,
        /// Number of alarms.
        #[schema(minimum = 1)]
        pub alarms: i64,
        /// Number of them that are not acknowledged and not shelved.
        #[schema(minimum = 0)]
        pub unacknowledged: i64,
    }
}

/// A standing alarm, or the newest one of a storm.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldedRow {
    /// The alarm itself.
    pub row: AlarmRow,
    /// The alarms for which it stands.
    pub fold: Fold,
}

impl<'r, R: sqlx::Row> sqlx::FromRow<'r, R> for FoldedRow
where
    AlarmRow: sqlx::FromRow<'r, R>,
    Fold: sqlx::FromRow<'r, R>,
{
    fn from_row(row: &'r R) -> sqlx::Result<Self> {
        Ok(Self { row: AlarmRow::from_row(row)?, fold: Fold::from_row(row)? })
    }
}

sorts! {
    /// Sort keys of the list of alarms.
    pub enum AlarmSort {
        /// By the time at which they were raised.
        RaisedAt = "raised_at" Whole Down,
        /// By level, then by kind: the most urgent first.
        Urgency = "urgency" Whole Down,
        /// By kind of alarm.
        Kind = "kind" Text Up,
    }
}

sorts! {
    /// Sort keys of the list of folded alarms.
    pub enum FoldedSort {
        /// Arrays and storms by their most urgent alarm, then by the most length lost, then by their newest alarm; in
        /// an array by urgency.
        Place = "place" Whole Down,
    }
}

sorts! {
    /// Sort keys of the counts of alarms.
    pub enum CountSort {
        /// By level, then by kind: the most urgent first.
        Urgency = "urgency" Whole Down,
    }
}

/// The columns of [`AlarmRow`], of the alarms that meet a condition.
macro_rules! rows {
    ($condition:literal) => {
        concat!(
            "SELECT t.*, {urgency} AS urgency FROM (SELECT s.alarm_id, r.robot_id, r.labels, fleet, robot, \"array\", w.whisker, w.whisker_id, \
             w.whole_length_mm - w.length_mm AS lost_mm, s.kind, s.raised_us AS raised_at, standing, cleared_us AS cleared_at, acknowledged_us AS acknowledged_at, \
             acknowledged_by, acknowledged_reason, shelved_until_us AS shelved_until, shelved_by, shelved_reason, maintenance_id, \
             CASE WHEN NOT standing THEN 'CLEARED' WHEN shelved_until_us IS NOT NULL THEN 'SHELVED' \
             WHEN acknowledged_us IS NULL THEN 'UNACKNOWLEDGED' ELSE 'ACKNOWLEDGED' END AS state, ",
            box_of!("r.robot_id", "s.raised_us"),
            " AS black_box_id FROM ",
            alarms!($condition),
            " s LEFT JOIN whiskers w ON w.whisker_id = s.whisker_id LEFT JOIN arrays y ON y.array_id = w.array_id \
             JOIN robots r ON r.robot_id = coalesce(s.robot_id, w.robot_id)) t"
        )
    };
}

/// The newest setpoint of the row's whisker that was not applied, if the alarm is about setpoints: one of its columns.
macro_rules! failed {
    ($column:literal) => {
        concat!(
            "(SELECT p.",
            $column,
            " FROM setpoints p WHERE q.kind = 'SETPOINT_FAILED' AND q.standing AND p.whisker_id = q.whisker_id \
             AND p.state IN ('REJECTED', 'FAILED', 'EXPIRED') ORDER BY p.issued_us DESC LIMIT 1)"
        )
    };
}

/// The newest decision about the row's whisker that has not ended.
macro_rules! decision {
    () => {
        "SELECT max(c.compensation_id) FROM compensations c WHERE c.target_whisker_id = q.whisker_id AND c.ended_us IS NULL"
    };
}

/// The most frequent reason for which the newest decision about the row's whisker refused candidates: one column of it.
macro_rules! refused {
    ($column:literal) => {
        concat!(
            "(SELECT ",
            $column,
            " FROM compensation_candidates k WHERE q.kind = 'UNCOMPENSATED' AND k.refused IS NOT NULL AND k.compensation_id = (",
            decision!(),
            ") GROUP BY k.refused ORDER BY count(*) DESC, min(k.ordinal) LIMIT 1)"
        )
    };
}

/// How bad an alarm is, and why: for the rows of a page alone.
const WHY: &str = concat!(
    ", (",
    decision!(),
    ") AS compensation_id, ",
    refused!("k.refused"),
    " AS refused, ",
    refused!("count(*)"),
    " AS refused_candidates, ",
    failed!("state"),
    " AS failed_state, ",
    failed!("error"),
    " AS failed_error, ",
    failed!("pressure_mpa"),
    " AS failed_pressure_mpa, CASE WHEN q.kind = 'SETPOINT_FAILED' AND q.standing THEN (SELECT count(*) FROM setpoints p \
     WHERE p.whisker_id = q.whisker_id AND p.state IN ('REJECTED', 'FAILED', 'EXPIRED') AND p.issued_us > coalesce(\
     (SELECT max(t.issued_us) FROM setpoints t WHERE t.whisker_id = q.whisker_id AND t.state = 'APPLIED'), 0)) END \
     AS failed_attempts"
);

/// All alarms, standing and cleared.
pub static ALARMS: List = List {
    what: "list the alarms",
    select: rows!("true"),
    details: WHY,
    keys: &[],
    sorts: AlarmSort::SORTS,
    id: "alarm_id",
};

/// The standing alarms: without a look at the cleared ones.
pub static STANDING: List = List { what: "list the standing alarms", select: rows!("a.cleared_us IS NULL"), ..ALARMS };

/// The standing alarms by robot and array, with storms folded. `place` orders them: the urgency of the row's array or
/// storm, the length that its whiskers have lost at most, in tenths of a millimetre up to 102.3 mm, the number of the
/// newest alarm in it, and the row's own urgency, in one number.
pub static FOLDED: List = List {
    what: "list the folded alarms",
    select: concat!(
        "WITH wanted AS (SELECT * FROM (",
        rows!("a.cleared_us IS NULL"),
        ") u WHERE true {filters}), \
         stepped AS (SELECT wanted.*, CASE WHEN raised_at - lag(raised_at) OVER \
          (PARTITION BY fleet, kind ORDER BY raised_at, alarm_id) <= 300000000 THEN 0 ELSE 1 END AS begins FROM wanted), \
         burst AS (SELECT stepped.*, sum(begins) OVER \
          (PARTITION BY fleet, kind ORDER BY raised_at, alarm_id) AS burst FROM stepped), \
         folds AS (SELECT fleet AS of_fleet, kind AS of_kind, burst AS of_burst, count(*) AS alarms, \
          count(DISTINCT robot) AS robots, count(*) FILTER (WHERE state = 'UNACKNOWLEDGED') AS unacknowledged, \
          min(raised_at) AS first_raised_at, max(raised_at) AS last_raised_at, max(alarm_id) AS newest \
          FROM burst GROUP BY fleet, kind, burst HAVING count(*) > 10), \
         folded AS (SELECT burst.*, coalesce(alarms, 1) AS alarms, coalesce(robots, 1) AS robots, \
          coalesce(unacknowledged, CASE WHEN state = 'UNACKNOWLEDGED' THEN 1 ELSE 0 END) AS unacknowledged, \
          coalesce(first_raised_at, raised_at) AS first_raised_at, coalesce(last_raised_at, raised_at) AS last_raised_at, \
          newest FROM burst LEFT JOIN folds \
          ON of_fleet = fleet AND of_kind = kind AND of_burst = burst WHERE newest IS NULL OR newest = alarm_id), \
         placed AS (SELECT folded.*, \
          CASE WHEN newest IS NULL THEN max(urgency) OVER g ELSE urgency END AS most, \
          CASE WHEN newest IS NULL THEN max(lost) OVER g ELSE lost END AS worst, \
          coalesce(newest, max(alarm_id) OVER g) AS last FROM \
          (SELECT f.*, CASE WHEN lost_mm > 102.3 THEN 1023 WHEN lost_mm > 0 THEN CAST(10 * lost_mm AS BIGINT) ELSE 0 END AS lost \
          FROM folded f) folded \
          WINDOW g AS (PARTITION BY fleet, robot, \"array\", newest)) \
         SELECT placed.*, most * 288230376151711744 + worst * 281474976710656 + last * 32 + urgency AS place FROM placed"
    ),
    details: WHY,
    keys: &[],
    sorts: FoldedSort::SORTS,
    id: "alarm_id",
};

/// Numbers of standing alarms by fleet and kind.
pub static COUNTS: List = List {
    what: "count the alarms",
    select: concat!(
        "SELECT fleet, kind, urgency, count(*) AS alarms, \
         count(*) FILTER (WHERE state = 'UNACKNOWLEDGED') AS unacknowledged, max(alarm_id) AS alarm_id FROM (",
        rows!("a.cleared_us IS NULL"),
        ") u WHERE true {filters} GROUP BY fleet, kind, urgency"
    ),
    details: "",
    keys: &[],
    sorts: CountSort::SORTS,
    id: "alarm_id",
};
