//! The log of events: table `events`, one row for each fact, written in the transaction of the fact.
//!
//! Its readers are live pages, webhooks and Kafka. Each has a [`Position`], and asks for the events after it; so a reader
//! misses none, even if several supervisors write at once. [`write`] appends, and [`published`] follows Kafka's position.
//! [`super::webhooks::upkeep`] removes old events, because webhooks count those that they lose.

pub mod published;
pub mod write;

use std::fmt;
use std::num::ParseIntError;
use std::str::FromStr;

use sqlx::{AssertSqlSafe, ColumnIndex, Decode, FromRow, Row, SqlSafeStr, Type};
use vibrissa_edge::events::{EventKind, Interest};
use vibrissa_edge::words::named;

pub use crate::batch::EVENT_VERSION as VERSION;

use super::database::{Either, on};
use super::from_row::from_row;
use super::set_aside::Tried;
use super::{Store, StoreError, failed};

/// Most events that one query returns.
pub const EVENTS_A_QUERY: i64 = 500;
/// The table, for names of unreadable rows.
pub(super) const EVENTS: &str = "events";

/// Position of an event in the log. Events of transactions that have ended are in the order of their positions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Number of the transaction in PostgreSQL; 0 in SQLite, which commits one after the other.
    pub tx: i64,
    /// Number of the event.
    pub event_id: i64,
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.tx, self.event_id)
    }
}

impl FromStr for Position {
    type Err = ParseIntError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (tx, event_id) = text.split_once('.').unwrap_or((text, ""));
        Ok(Self { tx: tx.parse()?, event_id: event_id.parse()? })
    }
}

from_row! {
    /// An event of the log.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct StoredEvent {
        /// Number of the event, unique in the database.
        pub event_id: i64,
        /// Number of the transaction.
        pub tx: i64,
        /// Time of the event, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
        /// Version of `data`.
        pub version: i64,
        /// Kind of the event.
        pub kind: String,
        /// Kind of the alarm, or state of the setpoint; `None` for other kinds.
        pub word: Option<String>,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot; `None` if the whole fleet is concerned.
        pub robot: Option<String>,
        /// Name of the array; `None` if no single whisker is concerned.
        pub array: Option<String>,
        /// Number of the whisker in its array; `None` if no single whisker is concerned.
        pub whisker: Option<i64>,
        /// Data of the event, a JSON object.
        pub data: String,
    }
}

impl StoredEvent {
    /// Kind of the event; `None` for a word of a newer version of the program.
    #[must_use]
    pub fn event_kind(&self) -> Option<EventKind> {
        named(&self.kind)
    }

    /// Position of the event in the log.
    #[must_use]
    pub fn position(&self) -> Position {
        Position { tx: self.tx, event_id: self.event_id }
    }

    /// Whether a webhook wants it.
    #[must_use]
    pub fn is_in(&self, interest: &Interest) -> bool {
        self.event_kind().is_some_and(|kind| interest.includes(&self.fleet, kind, self.word.as_deref()))
    }
}

/// An event with its position, which is known also if the event cannot be read.
pub(super) struct Positioned<T> {
    pub(super) at: Position,
    pub(super) event: Tried<T>,
}

impl<'r, R: Row, T: FromRow<'r, R>> FromRow<'r, R> for Positioned<T>
where
    usize: ColumnIndex<R>,
    &'static str: ColumnIndex<R>,
    i64: for<'v> Decode<'v, R::Database> + Type<R::Database>,
{
    fn from_row(row: &'r R) -> sqlx::Result<Self> {
        let at = Position { tx: row.try_get("tx")?, event_id: row.try_get("event_id")? };
        Ok(Self { at, event: Tried::from_row(row)? })
    }
}

/// The query of [`StoredEvent`] with an end that begins with JOIN or WHERE.
pub(super) fn select(end: &str) -> impl SqlSafeStr + use<> {
    AssertSqlSafe(format!(
        "SELECT e.event_id, e.tx, e.recorded_us, e.version, e.kind, e.word, e.fleet, r.robot, a.\"array\", w.whisker, e.data \
         FROM events e LEFT JOIN robots r ON r.robot_id = e.robot_id LEFT JOIN whiskers w ON w.whisker_id = e.whisker_id \
         LEFT JOIN arrays a ON a.array_id = w.array_id {end}"
    ))
}

/// Condition for events whose order is settled: in PostgreSQL an older transaction may still commit earlier events.
pub(super) fn settled<S, P>(database: &Either<S, P>) -> &'static str {
    match database {
        Either::Sqlite(_) => "",
        Either::Postgres(_) => "AND e.tx < pg_snapshot_xmin(pg_current_snapshot())::text::bigint",
    }
}

impl Store {
    /// The oldest [`EVENTS_A_QUERY`] events after a position, without those of contacts, in order, each with its position;
    /// `None` for one that cannot be read.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn events_after(&self, after: Position) -> Result<Vec<(Position, Option<StoredEvent>)>, StoreError> {
        let end = format!(
            "WHERE (e.tx, e.event_id) > ($1, $2) AND e.audience <> 'KAFKA' {} ORDER BY e.tx, e.event_id LIMIT {EVENTS_A_QUERY}",
            settled(&self.pool)
        );
        let rows: Vec<Positioned<StoredEvent>> = on!(&self.pool, |pool| sqlx::query_as(select(&end))
            .bind(after.tx)
            .bind(after.event_id)
            .fetch_all(pool)
            .await)
        .map_err(failed("read the events"))?;
        Ok(rows.into_iter().map(|row| (row.at, self.set_aside.read(EVENTS, row.event))).collect())
    }

    /// The first and the last position of the log, without events of contacts; `None` if it is empty. Events of
    /// unfinished transactions come after the last one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn log_ends(&self) -> Result<Option<(Position, Position)>, StoreError> {
        const WHAT: &str = "read the ends of the log of events";
        const FIRST: &str =
            "SELECT tx, event_id FROM events e WHERE e.audience <> 'KAFKA' ORDER BY tx, event_id LIMIT 1";
        let last = format!(
            "SELECT tx, event_id FROM events e WHERE e.audience <> 'KAFKA' {} ORDER BY tx DESC, event_id DESC LIMIT 1",
            settled(&self.pool)
        );
        let last: Option<(i64, i64)> =
            on!(&self.pool, |pool| sqlx::query_as(AssertSqlSafe(last)).fetch_optional(pool).await)
                .map_err(failed(WHAT))?;
        let first: Option<(i64, i64)> =
            on!(&self.pool, |pool| sqlx::query_as(FIRST).fetch_optional(pool).await).map_err(failed(WHAT))?;
        let position = |(tx, event_id)| Position { tx, event_id };
        Ok(first.map(position).zip(last.map(position)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_read_as_they_are_written_and_nothing_else_is() {
        let position = Position { tx: 7, event_id: 12 };
        assert_eq!(position.to_string().parse(), Ok(position));
        for text in ["", "7", "7.", ".1", "7.1.2", "a.1", "7,1"] {
            assert!(text.parse::<Position>().is_err(), "{text}");
        }
    }
}
