//! The feed of changes that live pages follow, in the order of commits.
//!
//! Each change is written in the same transaction as the rows that it announces. A reader asks for the changes after
//! a [`Mark`] and never misses one, even if several supervisors write at once.

use serde::Serialize;
use sqlx::{ColumnIndex, Decode, FromRow, Row, Type};
use utoipa::ToSchema;

use super::batch::Record;
use super::database::{Either, Tx, on};
use super::from_row::from_row;
use super::set_aside::Tried;
use super::tables::{CHANGES, InFleet, NewChange};
use super::time::Time;
use super::{Store, StoreError, failed};

/// Most changes that one query returns.
pub const CHANGES_MAX: i64 = 500;

/// Position of a reader in the feed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mark {
    /// Number of the transaction.
    pub tx: i64,
    /// Number of the change.
    pub change_id: i64,
}

impl std::fmt::Display for Mark {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.tx, self.change_id)
    }
}

impl std::str::FromStr for Mark {
    type Err = std::num::ParseIntError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (tx, change_id) = text.split_once('.').unwrap_or((text, ""));
        Ok(Self { tx: tx.parse()?, change_id: change_id.parse()? })
    }
}

from_row! {
    /// A change of a fleet's data.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct Change {
        /// Number of the transaction.
        #[serde(skip)]
        pub tx: i64,
        /// Number of the change.
        #[serde(skip)]
        pub change_id: i64,
        /// Kind of change: `HEALTH`, `TRIM`, `COMPENSATION`, `SETPOINT`, `ERROR`, `ALARM`, `ACTION`, `POLICY` or
        /// `TOUCH_TEST`.
        pub kind: String,
        /// Time of the change, by the supervisor's clock.
        pub at: Time,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot; null if the change concerns the whole fleet.
        pub robot: Option<String>,
        /// Name of the array; null if the change concerns a whole robot or fleet.
        pub array: Option<String>,
        /// Number of the whisker in its array; null if the change concerns no single whisker.
        pub whisker: Option<i64>,
        /// Number of the trim, compensation or action; null for other changes.
        pub number: Option<i64>,
        /// Identifier of the setpoint; null for other changes.
        pub command_id: Option<String>,
    }
}

impl Change {
    /// Position of this change in the feed.
    #[must_use]
    pub fn mark(&self) -> Mark {
        Mark { tx: self.tx, change_id: self.change_id }
    }
}

/// A change with its mark, which is known also if the change cannot be read.
struct Marked {
    mark: Mark,
    change: Tried<Change>,
}

impl<'r, R: Row> FromRow<'r, R> for Marked
where
    usize: ColumnIndex<R>,
    &'static str: ColumnIndex<R>,
    i64: for<'v> Decode<'v, R::Database> + Type<R::Database>,
    Change: FromRow<'r, R>,
{
    fn from_row(row: &'r R) -> sqlx::Result<Self> {
        let mark = Mark { tx: row.try_get("tx")?, change_id: row.try_get("change_id")? };
        Ok(Self { mark, change: Tried::from_row(row)?.named("change_id", Some(mark.change_id)) })
    }
}

/// Kind of a change of a touch test.
const TOUCH_TEST: &str = "TOUCH_TEST";

impl<'a> NewChange<'a> {
    /// The change that a record causes.
    pub(super) fn of(record: &'a Record) -> Self {
        let whisker =
            |kind, whisker_id, recorded_us| Self { kind, recorded_us, whisker_id: Some(whisker_id), ..Self::default() };
        let number = |kind, number, recorded_us| Self { kind, recorded_us, number: Some(number), ..Self::default() };
        match record {
            Record::Health(row) => whisker("HEALTH", row.whisker_id, row.recorded_us),
            Record::Trim(row) => Self { number: Some(row.trim_id), ..whisker("TRIM", row.whisker_id, row.detected_us) },
            Record::Decision(row) => Self {
                number: Some(row.compensation_id),
                ..whisker("COMPENSATION", row.target_whisker_id, row.decided_us)
            },
            Record::Ended(row) => number("COMPENSATION", row.compensation_id, row.ended_us),
            Record::Approved { compensation_id } => number("COMPENSATION", *compensation_id, 0),
            Record::Setpoint(row) => {
                Self { command_id: Some(&row.command_id), ..whisker("SETPOINT", row.whisker_id, row.issued_us) }
            }
            Record::SetpointState(row) => Self {
                kind: "SETPOINT",
                recorded_us: row.recorded_us,
                command_id: Some(&row.command_id),
                ..Self::default()
            },
            Record::Error(row) => number("ERROR", row.compensation_id, row.recorded_us),
            Record::Refinement(row) => number("ERROR", row.compensation_id, row.recorded_us),
            Record::Alarm(row) => whisker("ALARM", row.whisker_id, row.raised_us),
            Record::AlarmCleared(row) => whisker("ALARM", row.whisker_id, row.cleared_us),
            Record::RobotAlarm(row) => {
                Self { kind: "ALARM", recorded_us: row.raised_us, robot_id: Some(row.robot_id), ..Self::default() }
            }
            Record::RobotAlarmCleared(row) => {
                Self { kind: "ALARM", recorded_us: row.cleared_us, robot_id: Some(row.robot_id), ..Self::default() }
            }
            Record::AlarmsForgotten { robot_id, cleared_us } => {
                Self { kind: "ALARM", recorded_us: *cleared_us, robot_id: Some(*robot_id), ..Self::default() }
            }
            Record::Gone { robot_id, .. } => Self { kind: "HEALTH", robot_id: Some(*robot_id), ..Self::default() },
            Record::Answer { action_id, done_us, .. } => number("ACTION", *action_id, *done_us),
            Record::Activation(row) => Self { kind: "POLICY", recorded_us: row.activated_us, ..Self::default() },
            Record::Policy(row) => Self { kind: "POLICY", recorded_us: row.changed_us, ..Self::default() },
            Record::TouchTest(row) => whisker(TOUCH_TEST, row.whisker_id, row.requested_us),
            Record::TouchTestProgress(row) => Self {
                kind: TOUCH_TEST,
                recorded_us: row.updated_us,
                robot_id: Some(row.robot_id),
                whisker_id: row.whisker_id,
                ..Self::default()
            },
            Record::TestOfAction { action_id, .. } => number("ACTION", *action_id, 0),
            Record::Rollout(change) => Self { kind: "POLICY", recorded_us: change.row.updated_us, ..Self::default() },
            Record::Quarantined(row) => Self { kind: "ALARM", recorded_us: row.quarantined_us, ..Self::default() },
        }
    }
}

/// The changes that records of a fleet cause.
pub(super) fn of<'b>(fleet: &'b str, records: &'b [Record], now_us: i64) -> Vec<(InFleet<'b>, NewChange<'b>)> {
    records.iter().map(|record| in_fleet(fleet, NewChange::of(record), now_us)).collect()
}

fn in_fleet<'b>(fleet: &'b str, change: NewChange<'b>, now_us: i64) -> (InFleet<'b>, NewChange<'b>) {
    let recorded_us = if change.recorded_us == 0 { now_us } else { change.recorded_us };
    (InFleet { fleet }, NewChange { recorded_us, ..change })
}

/// Writes the changes of a batch's records.
pub(super) async fn write_of(tx: &mut Tx<'_>, fleet: &str, records: &[Record], now_us: i64) -> sqlx::Result<()> {
    CHANGES.write(tx, &of(fleet, records, now_us)).await.map(drop)
}

/// Writes a change of a fleet.
pub(super) async fn write(tx: &mut Tx<'_>, fleet: &str, change: NewChange<'_>, now_us: i64) -> sqlx::Result<()> {
    CHANGES.write(tx, &[in_fleet(fleet, change, now_us)]).await.map(drop)
}

/// Query of changes with the names of their robot, array and whisker.
macro_rules! named_changes {
    ($order:literal) => {
        concat!(
            "SELECT c.tx, c.change_id, c.kind, c.recorded_us AS at, c.fleet, COALESCE(r.robot, k.robot) AS robot, \
             a.\"array\", w.whisker, c.number, c.command_id FROM changes c \
             LEFT JOIN setpoints s ON s.command_id = c.command_id \
             LEFT JOIN compensations p ON c.kind IN ('COMPENSATION', 'ERROR') AND p.compensation_id = c.number \
             LEFT JOIN whiskers w ON w.whisker_id = COALESCE(c.whisker_id, s.whisker_id, p.target_whisker_id) \
             LEFT JOIN arrays a ON a.array_id = w.array_id \
             LEFT JOIN robots r ON r.robot_id = COALESCE(c.robot_id, w.robot_id) \
             LEFT JOIN actions k ON c.kind = 'ACTION' AND k.action_id = c.number \
             WHERE (c.tx, c.change_id) > ($1, $2)",
            $order
        )
    };
}

impl Store {
    /// The oldest [`CHANGES_MAX`] changes after a mark, in order, each with its mark; `None` for one that cannot be
    /// read. Changes younger than a transaction that has not
    /// ended are left to the next query: an older change may still appear before them.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn changes_after(&self, mark: Mark) -> Result<Vec<(Mark, Option<Change>)>, StoreError> {
        const WHAT: &str = "read the changes";
        let rows: Vec<Marked> = match &self.pool {
            Either::Sqlite(pool) => {
                let sql = named_changes!(" ORDER BY c.tx, c.change_id LIMIT $3");
                sqlx::query_as(sql).bind(mark.tx).bind(mark.change_id).bind(CHANGES_MAX).fetch_all(pool).await
            }
            Either::Postgres(pool) => {
                let sql = named_changes!(
                    " AND c.tx < pg_snapshot_xmin(pg_current_snapshot())::text::bigint \
                     ORDER BY c.tx, c.change_id LIMIT $3"
                );
                sqlx::query_as(sql).bind(mark.tx).bind(mark.change_id).bind(CHANGES_MAX).fetch_all(pool).await
            }
        }
        .map_err(failed(WHAT))?;
        Ok(rows.into_iter().map(|row| (row.mark, self.set_aside.read("changes", row.change))).collect())
    }

    /// The first and the last mark of the feed; `None` if it is empty. Changes of transactions that have not ended
    /// come after the last mark.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn marks(&self) -> Result<Option<(Mark, Mark)>, StoreError> {
        const WHAT: &str = "read the marks of the changes";
        let end = match &self.pool {
            Either::Sqlite(pool) => {
                let sql = "SELECT tx, change_id FROM changes ORDER BY tx DESC, change_id DESC LIMIT 1";
                sqlx::query_as::<_, (i64, i64)>(sql).fetch_optional(pool).await
            }
            Either::Postgres(pool) => {
                let sql = "SELECT tx, change_id FROM changes \
                           WHERE tx < pg_snapshot_xmin(pg_current_snapshot())::text::bigint \
                           ORDER BY tx DESC, change_id DESC LIMIT 1";
                sqlx::query_as::<_, (i64, i64)>(sql).fetch_optional(pool).await
            }
        }
        .map_err(failed(WHAT))?;
        let begin: Option<(i64, i64)> =
            on!(&self.pool, |pool| sqlx::query_as("SELECT tx, change_id FROM changes ORDER BY tx, change_id LIMIT 1")
                .fetch_optional(pool)
                .await)
            .map_err(failed(WHAT))?;
        let mark = |(tx, change_id)| Mark { tx, change_id };
        Ok(begin.map(mark).zip(end.map(mark)))
    }

    /// Deletes the changes that were recorded before a time, µs since 1970 UTC.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn forget_changes(&self, before_us: i64) -> Result<(), StoreError> {
        on!(&self.pool, |pool| sqlx::query("DELETE FROM changes WHERE recorded_us < $1")
            .bind(before_us)
            .execute(pool)
            .await
            .map(drop))
        .map_err(failed("delete old changes"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_read_as_they_are_written_and_nothing_else_is() {
        let mark = Mark { tx: 7, change_id: 12 };
        assert_eq!(mark.to_string().parse(), Ok(mark));
        for text in ["", "7", "7.", ".1", "7.1.2", "a.1", "7,1"] {
            assert!(text.parse::<Mark>().is_err(), "{text}");
        }
    }
}
