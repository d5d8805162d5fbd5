//! Writes a whole transaction as one statement: a single round trip to the server.
//!
//! The first part advances the commit counter in the fleet's lease; the other parts write nothing if it did not
//! advance. No part sees the rows that other parts write; foreign keys are checked at the end of the statement.

use std::sync::LazyLock;

use sqlx::postgres::PgConnection;
use sqlx::{Connection, Row};

use super::Query;
use super::copy::{are_copied, copy_contacts};
use super::parts::{Parts, Text};
use super::sorted::Sorted;
use crate::batch::{ContactRow, RollupRow};
use crate::records::tell_of_rollups;
use crate::tables::{
    ALARMS, ANSWERED, BINS, CANDIDATES, CHANGES, CLEARED, CONTACTS, DECISIONS, ENDED, ERRORS, HEALTH, InShard, JOURNAL,
    OUTBOX, OutboxRow, REFINEMENTS, RESPONSES, ROBOT_ALARMS, ROBOT_CLEARED, ROBOTS, SETPOINTS, STATES,
    TOUCH_TEST_PROGRESS, TOUCH_TESTS, TRIMS, WHISKERS,
};
use crate::{Batch, Lease, Resolution, StoreError, changes, failed, outbox, tables};

const JOURNAL_DONE: &str = "DELETE FROM journal WHERE fleet = $1 AND shard = $2 AND number <= $3 AND OWNED";

const REDO: &str = "INSERT INTO redo (fleet, shard, number, rows) SELECT $1::text, $2::bigint, $3::bigint, $4::bytea \
    WHERE OWNED";

const REDO_DONE: &str = "DELETE FROM redo WHERE fleet = $1 AND shard = $2 AND number = $3 AND OWNED";

/// The shard while only the text of a statement is made.
const NOWHERE: InShard<'static> = InShard { fleet: "", shard: 0 };

/// Statement of a transaction that writes only an intent.
static INTENT: LazyLock<String> =
    LazyLock::new(|| Text::new().sql("intent", REDO, |statement| statement).counting(&["counted"]));

/// The statement that writes an intent; its parameters are those of the lease, then fleet, shard, number and bytes.
pub(in super::super) fn intent() -> &'static str {
    &INTENT
}

/// Statement of a transaction that contains only contacts and journal entries.
static ORDINARY: LazyLock<String> = LazyLock::new(|| {
    let batch = Batch::default();
    Whole::empty(&batch).ordinary(Text::new(), NOWHERE, &[]).counting(&["counted"])
});

/// Statement of a transaction that contains checkpoints, too: nearly half of those of a quiet fleet. [`WHOLE`] takes the server
/// twice as long for them (5.6 instead of 2.6 ms in a run with 64 shards).
static CHECKPOINTS: LazyLock<String> = LazyLock::new(|| {
    let batch = Batch::default();
    let whole = Whole::empty(&batch);
    whole.checkpoints(whole.ordinary(Text::new(), NOWHERE, &[])).counting(&["counted"])
});

/// Statement of a transaction with all kinds of rows; most of its parts usually write nothing.
static WHOLE: LazyLock<String> = LazyLock::new(|| {
    let batch = Batch::default();
    let whole = Whole::empty(&batch);
    let checkpoints = whole.checkpoints(whole.ordinary(Text::new(), NOWHERE, &[]));
    let text = whole.rest(checkpoints, NOWHERE, (&[], 0));
    text.counting(&["counted", "minutes_new", "hours_new"])
});

/// A batch that one statement can write.
pub(in super::super) struct Whole<'b> {
    batch: &'b Batch,
    sorted: Sorted<'b>,
}

impl<'b> Whole<'b> {
    fn empty(batch: &'b Batch) -> Self {
        Self { batch, sorted: Sorted::default() }
    }

    /// `None` if the batch has layouts or rare records, which need statements of their own.
    pub(in super::super) fn of(batch: &'b Batch) -> Option<Self> {
        if !batch.layouts.is_empty() {
            return None;
        }
        Some(Self { batch, sorted: Sorted::of(&batch.records)? })
    }

    /// Writes the whole batch and advances the commit counter. Returns false, and writes nothing, if the counter did
    /// not advance.
    ///
    /// Many contacts are written by `COPY`, which needs a transaction around both. They are written before the
    /// lease's row is locked: a `COPY` lasts as long as its bytes take to arrive, and a supervisor that freezes in it
    /// must not block others from acquiring the fleet.
    pub(in super::super) async fn write(
        &self,
        link: &mut PgConnection,
        lease: &Lease,
        now_us: i64,
    ) -> Result<bool, StoreError> {
        let contacts = self.batch.contacts.as_slice();
        if !are_copied(contacts) {
            return self.write_rows(link, lease, contacts, now_us).await.map_err(failed("commit"));
        }
        let mut tx = link.begin().await.map_err(failed("begin a transaction"))?;
        copy_contacts(&mut tx, contacts).await.map_err(failed("append contacts"))?;
        if !self.write_rows(&mut tx, lease, &[], now_us).await.map_err(failed("write rows"))? {
            tx.rollback().await.map_err(failed("roll back"))?;
            return Ok(false);
        }
        tx.commit().await.map_err(failed("commit"))?;
        Ok(true)
    }

    async fn write_rows(
        &self,
        link: &mut PgConnection,
        lease: &Lease,
        contacts: &[ContactRow],
        now_us: i64,
    ) -> sqlx::Result<bool> {
        let batch = self.batch;
        let has_checkpoints = !batch.robots.is_empty() || !batch.whiskers.is_empty();
        let has_rest = !(batch.records.is_empty()
            && batch.events.is_empty()
            && batch.responses.is_empty()
            && batch.redo_done.is_none()
            && batch.rollups.is_empty());
        let at = InShard::of(lease);
        let sql: &'static str = match (has_rest, has_checkpoints) {
            (true, _) => &WHOLE,
            (false, true) => &CHECKPOINTS,
            (false, false) => &ORDINARY,
        };
        let mut statement = self.ordinary(lease.bind(sqlx::query(sql), batch.log_next), at, contacts);
        if has_rest || has_checkpoints {
            statement = self.checkpoints(statement);
        }
        if has_rest {
            let outbox: Vec<OutboxRow<'_>> = outbox::row(lease, &batch.events).into_iter().collect();
            statement = self.rest(statement, at, (&outbox, now_us));
        }
        let written = statement.fetch_one(link).await?;
        if written.try_get::<i64, _>(0)? == 0 {
            return Ok(false);
        }
        if has_rest {
            for (resolution, at) in [(Resolution::Minute, 1), (Resolution::Hour, 2)] {
                tell_of_rollups(resolution, self.rollups(resolution).len(), written.try_get::<i64, _>(at)? as u64);
            }
        }
        Ok(true)
    }

    fn rollups(&self, resolution: Resolution) -> Vec<&'b RollupRow> {
        self.batch.rollups.iter().filter(|row| row.resolution == resolution).collect()
    }

    /// The parts of all three statements.
    fn ordinary<P: Parts>(&self, parts: P, at: InShard<'_>, contacts: &[ContactRow]) -> P {
        let journal: Vec<_> = self.batch.journal.iter().map(|row| (at, row)).collect();
        let journal_done = self.batch.journal_done.unwrap_or(-1);
        parts
            .rows("journal_new", &JOURNAL, &journal)
            .sql("journal_done", JOURNAL_DONE, |statement: Query| {
                statement.bind(at.fleet).bind(at.shard).bind(journal_done)
            })
            .rows("contacts_new", &CONTACTS, contacts)
    }

    /// The parts of the two statements with checkpoints.
    fn checkpoints<P: Parts>(&self, parts: P) -> P {
        parts.rows("robots_now", &ROBOTS, &self.batch.robots).rows("whiskers_now", &WHISKERS, &self.batch.whiskers)
    }

    /// The further parts of the statement with all kinds of rows.
    fn rest<P: Parts>(&self, parts: P, at: InShard<'_>, (outbox, now_us): (&[OutboxRow<'_>], i64)) -> P {
        let (batch, sorted) = (self.batch, &self.sorted);
        let redo_done = batch.redo_done.unwrap_or(-1);
        parts
            .sql("redo_done", REDO_DONE, |statement: Query| statement.bind(at.fleet).bind(at.shard).bind(redo_done))
            .rows("health_new", &HEALTH, &sorted.health)
            .rows("trims_new", &TRIMS, &sorted.trims)
            .rows("compensations_new", &DECISIONS, &sorted.decisions)
            .rows("candidates_new", &CANDIDATES, &sorted.candidates)
            .rows("compensations_ended", &ENDED, &sorted.ended)
            .rows("setpoints_new", &SETPOINTS, &sorted.setpoints)
            .rows("setpoints_answered", &ANSWERED, &sorted.answered)
            .rows("setpoint_states_new", &STATES, &sorted.states)
            .rows("errors_new", &ERRORS, &sorted.errors)
            .rows("bins_new", &BINS, &sorted.bins)
            .rows("refinements_new", &REFINEMENTS, &sorted.refinements)
            .rows("alarms_new", &ALARMS, &sorted.alarms)
            .rows("alarms_cleared", &CLEARED, &sorted.cleared)
            .rows("robot_alarms_new", &ROBOT_ALARMS, &sorted.robot_alarms)
            .rows("robot_alarms_cleared", &ROBOT_CLEARED, &sorted.robot_cleared)
            .rows("touch_tests_new", &TOUCH_TESTS, &sorted.tests)
            .rows("touch_tests_now", &TOUCH_TEST_PROGRESS, &sorted.test_progress)
            .rows("responses_new", &RESPONSES, &batch.responses)
            .rows("outbox_new", &OUTBOX, outbox)
            .rows("changes_new", &CHANGES, &changes::of(at.fleet, &batch.records, now_us))
            .rows("minutes_new", tables::rollups(Resolution::Minute), &self.rollups(Resolution::Minute))
            .rows("hours_new", tables::rollups(Resolution::Hour), &self.rollups(Resolution::Hour))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_part_is_written_without_the_lease() {
        for sql in [&*INTENT, &*ORDINARY, &*CHECKPOINTS, &*WHOLE] {
            let (parts, gates) = (
                sql.matches(" AS (INSERT").count()
                    + sql.matches(" AS (UPDATE").count()
                    + sql.matches(" AS (DELETE").count(),
                sql.matches("EXISTS (SELECT FROM counted)").count(),
            );
            assert!(parts > 1 && gates == parts - 1, "{parts} parts, {gates} conditions");
        }
    }
}
