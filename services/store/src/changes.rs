//! What happened, in the order in which it was committed: what live pages follow.
//!
//! Rows are written in the transaction of what they tell of. A reader asks for what comes after a [`Mark`]; it never
//! misses one, also where several supervisors write at once.

use serde::Serialize;
use sqlx::{Database, Encode, QueryBuilder, Type};
use utoipa::ToSchema;

use super::batch::Record;
use super::database::{Either, Tx, on};
use super::readings::readings;
use super::time::Time;
use super::{Store, StoreError, failed};

/// Rows that are read at a time.
pub const CHANGES_MAX: i64 = 500;

/// Where a reader stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mark {
    /// The transaction.
    pub tx: i64,
    /// The row.
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

readings! {
    /// Something that happened.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct Change {
        /// Transaction.
        #[serde(skip)]
        pub tx: i64,
        /// Number.
        #[serde(skip)]
        pub change_id: i64,
        /// What: `HEALTH`, `TRIM`, `COMPENSATION`, `SETPOINT`, `ERROR`, `ALARM`, `ACTION` or `POLICY`.
        pub kind: String,
        /// When.
        pub at: Time,
        /// Fleet.
        pub fleet: String,
        /// Robot; null for a whole fleet.
        pub robot: Option<String>,
        /// Array; null for a whole robot.
        pub array: Option<String>,
        /// Number in the array.
        pub whisker: Option<i64>,
        /// Number of the trim, compensation or action.
        pub number: Option<i64>,
        /// The setpoint.
        pub command_id: Option<String>,
    }
}

impl Change {
    /// Where it stands.
    #[must_use]
    pub fn mark(&self) -> Mark {
        Mark { tx: self.tx, change_id: self.change_id }
    }
}

/// A change that is about to be written.
#[derive(Debug, Default)]
pub(super) struct NewChange<'a> {
    pub(super) recorded_us: i64,
    pub(super) kind: &'static str,
    pub(super) robot_id: Option<i64>,
    pub(super) whisker_id: Option<i64>,
    pub(super) number: Option<i64>,
    pub(super) command_id: Option<&'a str>,
}

impl<'a> NewChange<'a> {
    /// What a record changes.
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
            Record::AlarmsForgotten { robot_id, cleared_us } => {
                Self { kind: "ALARM", recorded_us: *cleared_us, robot_id: Some(*robot_id), ..Self::default() }
            }
            Record::Gone { robot_id, .. } => Self { kind: "HEALTH", robot_id: Some(*robot_id), ..Self::default() },
            Record::Answer { action_id, done_us, .. } => number("ACTION", *action_id, *done_us),
            Record::Activation(row) => Self { kind: "POLICY", recorded_us: row.activated_us, ..Self::default() },
            Record::Policy(row) => Self { kind: "POLICY", recorded_us: row.changed_us, ..Self::default() },
            Record::Quarantined(row) => Self { kind: "ALARM", recorded_us: row.quarantined_us, ..Self::default() },
        }
    }
}

/// Tells of the records of a fleet's batch.
pub(super) async fn write_of(tx: &mut Tx<'_>, fleet: &str, records: &[Record], now_us: i64) -> sqlx::Result<()> {
    let changes: Vec<NewChange<'_>> = records.iter().map(NewChange::of).collect();
    write(tx, fleet, &changes, now_us).await
}

/// Tells of changes; one without a time is of now.
pub(super) async fn write(tx: &mut Tx<'_>, fleet: &str, changes: &[NewChange<'_>], now_us: i64) -> sqlx::Result<()> {
    /// Rows of one statement: 7 values each, SQLite takes 32,766.
    const ROWS_A_STATEMENT: usize = 1000;
    for changes in changes.chunks(ROWS_A_STATEMENT) {
        match &mut *tx {
            Either::Sqlite(tx) => {
                statement(fleet, changes, now_us).build().persistent(false).execute(&mut **tx).await.map(drop)?;
            }
            Either::Postgres(tx) => {
                statement(fleet, changes, now_us).build().persistent(false).execute(&mut **tx).await.map(drop)?;
            }
        }
    }
    Ok(())
}

fn statement<DB: Database>(fleet: &str, changes: &[NewChange<'_>], now_us: i64) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    Option<i64>: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
    Option<String>: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut insert =
        QueryBuilder::new("INSERT INTO changes (recorded_us, fleet, kind, robot_id, whisker_id, number, command_id) ");
    insert.push_values(changes, |mut row, change| {
        row.push_bind(if change.recorded_us == 0 { now_us } else { change.recorded_us })
            .push_bind(fleet.to_owned())
            .push_bind(change.kind.to_owned())
            .push_bind(change.robot_id)
            .push_bind(change.whisker_id)
            .push_bind(change.number)
            .push_bind(change.command_id.map(ToOwned::to_owned));
    });
    insert
}

/// A change with the names of what it is about.
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
    /// What happened after a mark, the first of it, in order; transactions that are under way are waited for.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn changes_after(&self, mark: Mark) -> Result<Vec<Change>, StoreError> {
        const WHAT: &str = "read what has changed";
        match &self.pool {
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
        .map_err(failed(WHAT))
    }

    /// The first and the last mark that there are; none if nothing has happened for a day. What is under way comes after
    /// the last.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn marks(&self) -> Result<Option<(Mark, Mark)>, StoreError> {
        const WHAT: &str = "read where changes stand";
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

    /// Forgets changes of before a moment.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn forget_changes(&self, before_us: i64) -> Result<(), StoreError> {
        on!(&self.pool, |pool| sqlx::query("DELETE FROM changes WHERE recorded_us < $1")
            .bind(before_us)
            .execute(pool)
            .await
            .map(drop))
        .map_err(failed("forget old changes"))
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
