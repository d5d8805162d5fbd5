//! Writes a whole transaction as one statement: a single round trip to the server.
//!
//! The first part advances the commit counter in the lease of each shard; the other parts write nothing if it did not
//! advance all of them. No part sees the rows that other parts write; foreign keys are checked at the end of the
//! statement.

use std::sync::LazyLock;

use sqlx::postgres::PgConnection;
use sqlx::{Connection, Row};

use super::copy::{are_copied, copy_contacts};
use super::parts::{Parts, Text};
use super::sorted::Sorted;
use crate::batch::{ContactRow, JournalRow, ResponseRow, RobotRow, RollupRow, WhiskerRow};
use crate::events::write::EventRow;
use crate::records::tell_of_rollups;
use crate::tables::{
    ALARMS, ANSWERED, BINS, CANDIDATES, CLEARED, CONTACTS, DECISIONS, ENDED, ERRORS, EVENTS, HEALTH, InFleet, InShard,
    JOURNAL, JOURNAL_DONE, LOG_POSITIONS, LogPositionRow, REFINEMENTS, RESPONSES, ROBOT_ALARMS, ROBOT_CLEARED, ROBOTS,
    SETPOINTS, STATES, ShardNumber, TOUCH_TEST_PROGRESS, TOUCH_TESTS, TRIMS, WHISKERS,
};
use crate::{Batch, Lease, Resolution, StoreError, failed, tables};

/// Statements of the transactions of one shard, and of several shards together.
static OF_ONE: LazyLock<Statements> = LazyLock::new(|| Statements::beginning_with(Text::of_one));
static OF_SEVERAL: LazyLock<Statements> = LazyLock::new(|| Statements::beginning_with(Text::of_several));

/// The texts of the statements.
struct Statements {
    /// For a transaction that contains only contacts and journal entries.
    ordinary: String,
    /// For one that contains checkpoints, or positions in a log, too: nearly half of those of a quiet fleet. `whole`
    /// takes the server twice as long for them (5.6 instead of 2.6 ms in a run with 64 shards).
    checkpoints: String,
    /// For one with all kinds of rows; most of its parts usually write nothing.
    whole: String,
}

impl Statements {
    fn beginning_with(begin: fn() -> Text) -> Self {
        let rows = Whole::default();
        Self {
            ordinary: rows.ordinary(begin()).counting(&["counted"]),
            checkpoints: rows.checkpoints(rows.ordinary(begin())).counting(&["counted"]),
            whole: rows.rest(rows.checkpoints(rows.ordinary(begin()))).counting(&[
                "counted",
                "minutes_new",
                "hours_new",
            ]),
        }
    }
}

impl Batch {
    /// Whether one statement can write it: there are no layouts and no rare records.
    #[must_use]
    pub fn fits_one_statement(&self) -> bool {
        self.layouts.is_empty() && Sorted::of(&self.records).is_some()
    }
}

/// The rows of one statement: those of a batch, or of the batches of several shards.
#[derive(Default)]
pub(in super::super) struct Whole<'b> {
    leases: Vec<&'b Lease>,
    contacts: Vec<&'b ContactRow>,
    journal: Vec<(InShard<'b>, &'b JournalRow)>,
    journal_done: Vec<ShardNumber<'b>>,
    log_positions: Vec<LogPositionRow<'b>>,
    robots: Vec<&'b RobotRow>,
    whiskers: Vec<&'b WhiskerRow>,
    sorted: Sorted<'b>,
    has_records: bool,
    responses: Vec<&'b ResponseRow>,
    events: Vec<(InFleet<'b>, &'b EventRow)>,
    minutes: Vec<&'b RollupRow>,
    hours: Vec<&'b RollupRow>,
}

impl<'b> Whole<'b> {
    /// The rows of batches, each of another shard. `None` if a batch has layouts or rare records, which need statements
    /// of their own.
    pub(in super::super) fn of(batches: &[(&'b Lease, &'b Batch)]) -> Option<Self> {
        let mut rows =
            Self { sorted: Sorted::of(batches.iter().flat_map(|(_, batch)| &batch.records))?, ..Self::default() };
        for (lease, batch) in batches {
            if !batch.layouts.is_empty() {
                return None;
            }
            rows.add(lease, batch);
        }
        Some(rows)
    }

    fn add(&mut self, lease: &'b Lease, batch: &'b Batch) {
        let at = InShard::of(lease);
        self.leases.push(lease);
        self.contacts.extend(&batch.contacts);
        self.journal.extend(batch.journal.iter().map(|row| (at, row)));
        self.journal_done.extend(batch.journal_done.map(|number| ShardNumber::new(at, number)));
        self.has_records |= !batch.records.is_empty();
        self.log_positions.extend(batch.log.rows(lease));
        self.robots.extend(&batch.robots);
        self.whiskers.extend(&batch.whiskers);
        self.responses.extend(&batch.responses);
        self.events.extend(batch.events.iter().map(|event| (InFleet { fleet: at.fleet }, event)));
        for row in &batch.rollups {
            match row.resolution {
                Resolution::Minute => self.minutes.push(row),
                Resolution::Hour => self.hours.push(row),
            }
        }
    }

    /// Writes all rows and advances the commit counters. Returns false, and writes nothing, if a counter did not
    /// advance.
    ///
    /// Many contacts are written by `COPY`, which needs a transaction around both. They are written before the
    /// leases' rows are locked: a `COPY` lasts as long as its bytes take to arrive, and a supervisor that freezes in it
    /// must not block others from acquiring the fleet.
    pub(in super::super) async fn write(mut self, link: &mut PgConnection) -> Result<bool, StoreError> {
        if !are_copied(self.contacts.len()) {
            return self.write_rows(link).await.map_err(failed("commit"));
        }
        let contacts = std::mem::take(&mut self.contacts);
        let mut tx = link.begin().await.map_err(failed("begin a transaction"))?;
        copy_contacts(&mut tx, &contacts).await.map_err(failed("append contacts"))?;
        if !self.write_rows(&mut tx).await.map_err(failed("write rows"))? {
            tx.rollback().await.map_err(failed("roll back"))?;
            return Ok(false);
        }
        tx.commit().await.map_err(failed("commit"))?;
        Ok(true)
    }

    async fn write_rows(&self, link: &mut PgConnection) -> sqlx::Result<bool> {
        let has_rest = self.has_records
            || !(self.events.is_empty()
                && self.responses.is_empty()
                && self.minutes.is_empty()
                && self.hours.is_empty());
        let statements = if self.leases.len() == 1 { &*OF_ONE } else { &*OF_SEVERAL };
        let has_checkpoints = !(self.robots.is_empty() && self.whiskers.is_empty() && self.log_positions.is_empty());
        let sql: &'static str = match (has_rest, has_checkpoints) {
            (true, _) => &statements.whole,
            (false, true) => &statements.checkpoints,
            (false, false) => &statements.ordinary,
        };
        let statement = match self.leases.as_slice() {
            [lease] => lease.bind(sqlx::query(sql)),
            several => Lease::bind_several(several, sqlx::query(sql)),
        };
        let mut statement = self.ordinary(statement);
        if has_rest || has_checkpoints {
            statement = self.checkpoints(statement);
        }
        if has_rest {
            statement = self.rest(statement);
        }
        let written = statement.fetch_one(link).await?;
        if written.try_get::<i64, _>(0)? == 0 {
            return Ok(false);
        }
        if has_rest {
            for (resolution, rows, at) in [(Resolution::Minute, &self.minutes, 1), (Resolution::Hour, &self.hours, 2)] {
                tell_of_rollups(resolution, rows.len(), written.try_get::<i64, _>(at)? as u64);
            }
        }
        Ok(true)
    }

    /// The parts of all three statements.
    fn ordinary<P: Parts>(&self, parts: P) -> P {
        parts.rows("journal_new", &JOURNAL, &self.journal).rows("journal_done", &JOURNAL_DONE, &self.journal_done).rows(
            "contacts_new",
            &CONTACTS,
            &self.contacts,
        )
    }

    /// The parts of the two statements with checkpoints.
    fn checkpoints<P: Parts>(&self, parts: P) -> P {
        parts.rows("robots_now", &ROBOTS, &self.robots).rows("whiskers_now", &WHISKERS, &self.whiskers).rows(
            "log_positions_now",
            &LOG_POSITIONS,
            &self.log_positions,
        )
    }

    /// The further parts of the statement with all kinds of rows.
    fn rest<P: Parts>(&self, parts: P) -> P {
        let sorted = &self.sorted;
        parts
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
            .rows("responses_new", &RESPONSES, &self.responses)
            .rows("events_new", &EVENTS, &self.events)
            .rows("minutes_new", tables::rollups(Resolution::Minute), &self.minutes)
            .rows("hours_new", tables::rollups(Resolution::Hour), &self.hours)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_part_is_written_without_the_lease() {
        let statements = [&*OF_ONE, &*OF_SEVERAL];
        let texts = statements.into_iter().flat_map(|of| [&of.ordinary, &of.checkpoints, &of.whole]);
        for sql in texts {
            let parts: usize =
                [" AS (INSERT", " AS (UPDATE", " AS (DELETE"].map(|begin| sql.matches(begin).count()).iter().sum();
            let counted = usize::from(!sql.contains("counted AS (UPDATE"));
            let gates = sql.matches("EXISTS (SELECT FROM counted)").count();
            assert!(parts > 1 && gates == parts - 1 + counted, "{parts} parts, {gates} conditions: {sql}");
        }
    }
}
