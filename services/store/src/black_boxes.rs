//! Black boxes: the messages of a robot around an event, of bounded number per robot.

use std::time::Duration;

use super::database::{Either, on};
use super::from_row::from_row;
use super::{Lease, Model, Store, StoreError, Writer, failed};

/// Number of boxes of a robot that are stored; the oldest are deleted first.
pub const BOXES_PER_ROBOT: i64 = 20;

/// Time limit for one attempt.
const PATIENCE: Duration = Duration::from_secs(10);
const WHAT: &str = "write a black box";

/// A black box; docs/schema.md documents the columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewBlackBox {
    /// Number of the robot in the database.
    pub robot_id: i64,
    /// Number of the whisker of the first event.
    pub whisker_id: i64,
    /// `TRIM`, or the kind of fault or alarm.
    pub cause: &'static str,
    /// Time of the first event, µs since 1970 UTC by the supervisor's clock.
    pub event_us: i64,
    /// Time from which on all messages are in it, by the same clock.
    pub began_us: i64,
    /// Planned end, by the same clock.
    pub ends_us: i64,
    /// Time of the newest message, by the same clock.
    pub last_us: i64,
    /// `RECORDING`, `COMPLETE` or `PARTIAL`.
    pub state: &'static str,
    /// Number of messages in it.
    pub messages: i64,
    /// Messages that the limit of memory left out.
    pub left_out: i64,
    /// Whether it begins with the robot's state.
    pub has_state: bool,
    /// Size of the lines, bytes.
    pub bytes: i64,
    /// The lines, compressed (gzip).
    pub body: Vec<u8>,
}

from_row! {
    /// The lines of a black box, and what its first line says.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct BlackBoxBody {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// `TRIM`, or the kind of fault or alarm.
        pub cause: String,
        /// Time of the first event, µs since 1970 UTC by the supervisor's clock.
        pub event_us: i64,
        /// Time from which on all messages are in it, by the same clock.
        pub began_us: i64,
        /// Planned end, by the same clock.
        pub ends_us: i64,
        /// `RECORDING`, `COMPLETE` or `PARTIAL`.
        pub state: String,
        /// Messages that the limit of memory left out.
        pub left_out: i64,
        /// The lines, compressed (gzip).
        pub body: Vec<u8>,
    }
}

impl Writer {
    /// Writes a box, or replaces the same box of an earlier time, and deletes the oldest boxes of the robot beyond
    /// [`BOXES_PER_ROBOT`].
    ///
    /// # Errors
    /// The database cannot be written now, or the lease is lost.
    pub async fn write_black_box(&mut self, lease: &Lease, one: &NewBlackBox) -> Result<(), StoreError> {
        const WRITE: &str = "INSERT INTO black_boxes (robot_id, whisker_id, cause, event_us, began_us, ends_us, last_us, \
             state, messages, left_out, has_state, bytes, body) \
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13) \
             ON CONFLICT (robot_id, event_us) DO UPDATE SET began_us = excluded.began_us, ends_us = excluded.ends_us, \
             last_us = excluded.last_us, state = excluded.state, messages = excluded.messages, \
             left_out = excluded.left_out, has_state = excluded.has_state, bytes = excluded.bytes, body = excluded.body";
        // By number: boxes of a time at which the clock was ahead are not newer.
        const LIMIT: &str = "DELETE FROM black_boxes WHERE robot_id = $1 AND black_box_id <= \
             (SELECT black_box_id FROM black_boxes WHERE robot_id = $1 ORDER BY black_box_id DESC LIMIT 1 OFFSET $2)";
        let model = |model: &mut dyn Model| Ok(lease.hold_in(model)?.write_black_box(lease, one)?);
        self.attempt(WHAT, PATIENCE, model, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            on!(&mut tx, |tx| sqlx::query(WRITE)
                .bind(one.robot_id)
                .bind(one.whisker_id)
                .bind(one.cause)
                .bind(one.event_us)
                .bind(one.began_us)
                .bind(one.ends_us)
                .bind(one.last_us)
                .bind(one.state)
                .bind(one.messages)
                .bind(one.left_out)
                .bind(one.has_state)
                .bind(one.bytes)
                .bind(&one.body)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            on!(&mut tx, |tx| sqlx::query(LIMIT)
                .bind(one.robot_id)
                .bind(BOXES_PER_ROBOT)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            // Last, so that the row of the lease, which each commit updates, is locked for a short time.
            lease.hold(&mut tx).await?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }

    /// Marks the boxes of a fleet's robots that its earlier owner has not finished as `PARTIAL`.
    ///
    /// # Errors
    /// The database cannot be written now, or the lease is lost.
    pub async fn end_black_boxes(&mut self, lease: &Lease) -> Result<(), StoreError> {
        const SQL: &str = "UPDATE black_boxes SET state = 'PARTIAL' WHERE state = 'RECORDING' AND robot_id IN \
             (SELECT robot_id FROM robots WHERE fleet = $1)";
        let model = |model: &mut dyn Model| lease.hold_in(model).map(|model| model.end_black_boxes(lease));
        self.attempt(WHAT, PATIENCE, model, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            on!(&mut tx, |tx| sqlx::query(SQL).bind(lease.fleet().as_str()).execute(&mut **tx).await.map(drop))
                .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }
}

impl Store {
    /// The lines of a box; `None` if there is no such box.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn black_box(&self, black_box_id: i64) -> Result<Option<BlackBoxBody>, StoreError> {
        const SQL: &str = "SELECT fleet, robot, cause, event_us, began_us, ends_us, x.state, left_out, body \
             FROM black_boxes x JOIN robots USING (robot_id) WHERE black_box_id = $1";
        on!(&self.pool, |pool| sqlx::query_as(SQL).bind(black_box_id).fetch_optional(pool).await)
            .map_err(failed("read a black box"))
    }

    /// Deletes the oldest boxes before a time, at most `most`; returns how many.
    pub(super) async fn remove_black_boxes(&self, before_us: i64, most: i64) -> sqlx::Result<u64> {
        const SQL: &str = "DELETE FROM black_boxes WHERE black_box_id IN \
             (SELECT black_box_id FROM black_boxes WHERE event_us < $1 ORDER BY event_us LIMIT $2)";
        match &self.pool {
            Either::Sqlite(pool) => {
                sqlx::query(SQL).bind(before_us).bind(most).execute(pool).await.map(|done| done.rows_affected())
            }
            Either::Postgres(pool) => {
                sqlx::query(SQL).bind(before_us).bind(most).execute(pool).await.map(|done| done.rows_affected())
            }
        }
    }
}
