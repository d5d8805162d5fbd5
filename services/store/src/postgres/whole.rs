//! Writes a whole transaction as one statement: a single round trip to the server.
//!
//! The first part advances the commit counter in the lease; the other parts write nothing if it did not. No part sees the rows that other parts write; foreign keys are checked at the end of the
//! statement.

use std::sync::LazyLock;

use sqlx::postgres::PgConnection;
use sqlx::{Connection, Row};

use super::copy::{are_copied, copy_contacts};
use super::parts::{Parts, Text};
use super::sorted::Sorted;
use crate::batch::{ContactRow, EventRow, JournalRow, ResponseRow, RobotRow, RollupRow, WhiskerRow};
use crate::records::tell_of_rollups;
use crate::tables::{
    ALARMS, ANSWERED, BINS, CANDIDATES, CLEARED, CONTACTS, DECISIONS, ENDED, ERRORS, EVENTS, HEALTH, InFleet, JOURNAL,
    JOURNAL_DONE, JournalNumber, LOG_POSITIONS, LogPositionRow, REFINEMENTS, RESPONSES, ROBOT_ALARMS, ROBOT_CLEARED,
    ROBOTS, SETPOINTS, STATES, TOUCH_TEST_PROGRESS, TOUCH_TESTS, TRIMS, WHISKERS,
};
use crate::{Batch, Lease, Resolution, StoreError, failed, tables};

/// Statements of the transactions.
static STATEMENTS: LazyLock<Statements> = LazyLock::new(Statements::new);

/// The texts of the statements.
struct Statements {
    /// For a transaction that contains only contacts and journal entries.
    ordinary: String,
    /// For one that contains checkpoints, or positions in a log, too: nearly half of those of a quiet fleet. `whole`
    /// takes the server twice as long for them (5.6 instead of 2.6 ms in a run with 64 fleets).
    checkpoints: String,
    /// For one with all kinds of rows; most of its parts usually write nothing.
    whole: String,
}

impl Statements {
    fn new() -> Self {
        let rows = Rows::default();
        Self {
            ordinary: rows.ordinary(Text::new()).counting(&["counted"]),
            checkpoints: rows.checkpoints(rows.ordinary(Text::new())).counting(&["counted"]),
            whole: rows.rest(rows.checkpoints(rows.ordinary(Text::new()))).counting(&[
                "counted",
                "minutes_new",
                "hours_new",
            ]),
        }
    }
}

/// A batch, with the lease under which it is written.
pub(in super::super) struct Whole<'b> {
    lease: &'b Lease,
    rows: Rows<'b>,
}

/// The rows of one statement.
#[derive(Default)]
struct Rows<'b> {
    contacts: Vec<&'b ContactRow>,
    journal: Option<(InFleet<'b>, &'b JournalRow)>,
    journal_done: Option<JournalNumber<'b>>,
    log_positions: Vec<LogPositionRow<'b>>,
    robots: &'b [RobotRow],
    whiskers: &'b [WhiskerRow],
    has_records: bool,
    sorted: Sorted<'b>,
    responses: &'b [ResponseRow],
    events: Vec<(InFleet<'b>, &'b EventRow)>,
    minutes: Vec<&'b RollupRow>,
    hours: Vec<&'b RollupRow>,
}

impl<'b> Whole<'b> {
    /// The rows of a batch. `None` if it has layouts or rare records, which need statements of their own.
    pub(in super::super) fn of(lease: &'b Lease, batch: &'b Batch) -> Option<Self> {
        let sorted = Sorted::of(&batch.records).filter(|_| batch.layouts.is_empty())?;
        let at = InFleet::of(lease);
        let of = |resolution| batch.rollups.iter().filter(move |row| row.resolution == resolution).collect();
        let rows = Rows {
            contacts: batch.contacts.iter().collect(),
            journal: batch.journal.as_ref().map(|row| (at, row)),
            journal_done: batch.journal_done.map(|number| JournalNumber { fleet: at.fleet, number }),
            log_positions: batch.log.rows(lease).collect(),
            robots: &batch.robots,
            whiskers: &batch.whiskers,
            has_records: !batch.records.is_empty(),
            sorted,
            responses: &batch.responses,
            events: batch.events.iter().map(|event| (at, event)).collect(),
            minutes: of(Resolution::Minute),
            hours: of(Resolution::Hour),
        };
        Some(Self { lease, rows })
    }

    /// Writes all rows and advances the commit counter. Returns false, and writes nothing, if it did not advance.
    ///
    /// Many contacts are written by `COPY`, which needs a transaction around both. They are written before the
    /// lease's row is locked: a `COPY` lasts as long as its bytes take to arrive, and a supervisor that freezes in it
    /// must not block others from acquiring the fleet.
    pub(in super::super) async fn write(mut self, link: &mut PgConnection) -> Result<bool, StoreError> {
        if !are_copied(self.rows.contacts.len()) {
            return self.write_rows(link).await.map_err(failed("commit"));
        }
        let contacts = std::mem::take(&mut self.rows.contacts);
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
        let rows = &self.rows;
        let (has_rest, has_checkpoints) = (rows.has_rest(), rows.has_checkpoints());
        let sql: &'static str = match (has_rest, has_checkpoints) {
            (true, _) => &STATEMENTS.whole,
            (false, true) => &STATEMENTS.checkpoints,
            (false, false) => &STATEMENTS.ordinary,
        };
        let mut statement = rows.ordinary(self.lease.bind(sqlx::query(sql)));
        if has_rest || has_checkpoints {
            statement = rows.checkpoints(statement);
        }
        if has_rest {
            statement = rows.rest(statement);
        }
        let written = statement.fetch_one(link).await?;
        if written.try_get::<i64, _>(0)? == 0 {
            return Ok(false);
        }
        if has_rest {
            for (resolution, rollups, at) in
                [(Resolution::Minute, &rows.minutes, 1), (Resolution::Hour, &rows.hours, 2)]
            {
                tell_of_rollups(resolution, rollups.len(), written.try_get::<i64, _>(at)? as u64);
            }
        }
        Ok(true)
    }
}

impl Rows<'_> {
    /// Whether there are rows of other kinds than contacts, journal and checkpoints.
    fn has_rest(&self) -> bool {
        self.has_records
            || !(self.events.is_empty()
                && self.responses.is_empty()
                && self.minutes.is_empty()
                && self.hours.is_empty())
    }

    /// Whether there are checkpoints, or positions in a log.
    fn has_checkpoints(&self) -> bool {
        !(self.robots.is_empty() && self.whiskers.is_empty() && self.log_positions.is_empty())
    }

    /// The parts of all three statements.
    fn ordinary<P: Parts>(&self, parts: P) -> P {
        parts
            .rows("journal_new", &JOURNAL, self.journal.as_slice())
            .rows("journal_done", &JOURNAL_DONE, self.journal_done.as_slice())
            .rows("contacts_new", &CONTACTS, &self.contacts)
    }

    /// The parts of the two statements with checkpoints.
    fn checkpoints<P: Parts>(&self, parts: P) -> P {
        parts.rows("robots_now", &ROBOTS, self.robots).rows("whiskers_now", &WHISKERS, self.whiskers).rows(
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
            .rows("responses_new", &RESPONSES, self.responses)
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
        for sql in [&STATEMENTS.ordinary, &STATEMENTS.checkpoints, &STATEMENTS.whole] {
            let parts: usize =
                [" AS (INSERT", " AS (UPDATE", " AS (DELETE"].map(|begin| sql.matches(begin).count()).iter().sum();
            let counted = usize::from(!sql.contains("counted AS (UPDATE"));
            let gates = sql.matches("EXISTS (SELECT FROM counted)").count();
            assert!(parts > 1 && gates == parts - 1 + counted, "{parts} parts, {gates} conditions: {sql}");
        }
    }
}
