//! Writes a whole transaction as one statement: a single round trip to the server.
//!
//! The first part advances the commit counter in the fleet's lease; the other parts write nothing if it did not
//! advance. No part sees the rows that other parts write; foreign keys are checked at the end of the statement.

use sqlx::postgres::PgConnection;
use sqlx::{Connection, Row};

use super::copy::{append_contacts, are_copied};
use super::parts::{ORDINARY, WHOLE};
use super::rows::{Statement, bind_contacts, bind_each, bind_responses, bind_robots, bind_rollups, bind_whiskers};
use super::sorted::Sorted;
use crate::Resolution;
use crate::batch::{ContactRow, RollupRow};
use crate::changes::NewChange;
use crate::commit::tell_of_rollups;
use crate::{Batch, Lease, StoreError, failed};

/// A batch that one statement can write.
pub(in super::super) struct Whole<'b> {
    batch: &'b Batch,
    sorted: Sorted<'b>,
}

impl<'b> Whole<'b> {
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
        append_contacts(&mut tx, contacts).await.map_err(failed("append contacts"))?;
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
        let is_ordinary = batch.robots.is_empty()
            && batch.whiskers.is_empty()
            && batch.records.is_empty()
            && batch.responses.is_empty()
            && batch.redo_done.is_none()
            && batch.rollups.is_empty();
        let sql: &'static str = if is_ordinary { &ORDINARY } else { &WHOLE };
        let mut statement = lease.bind(sqlx::query(sql));
        statement = self.bind_journal(statement, lease);
        statement = bind_contacts(statement, contacts);
        if !is_ordinary {
            statement = statement.bind(lease.fleet().as_str()).bind(batch.redo_done.unwrap_or(-1));
            statement = bind_robots(statement, &batch.robots);
            statement = bind_whiskers(statement, &batch.whiskers);
            statement = self.bind_decisions(statement);
            statement = self.bind_setpoints(statement);
            statement = self.bind_errors(statement);
            statement = self.bind_alarms(statement);
            statement = bind_responses(statement, &batch.responses);
            statement = self.bind_changes(statement, lease, now_us);
            statement = bind_rollups(statement, &self.rollups(Resolution::Minute));
            statement = bind_rollups(statement, &self.rollups(Resolution::Hour));
        }
        let written = statement.fetch_one(link).await?;
        if written.try_get::<i64, _>(0)? == 0 {
            return Ok(false);
        }
        if !is_ordinary {
            for (resolution, at) in [(Resolution::Minute, 1), (Resolution::Hour, 2)] {
                tell_of_rollups(resolution, self.rollups(resolution).len(), written.try_get::<i64, _>(at)? as u64);
            }
        }
        Ok(true)
    }

    fn rollups(&self, resolution: Resolution) -> Vec<&'b RollupRow> {
        self.batch.rollups.iter().filter(|row| row.resolution == resolution).collect()
    }

    fn bind_journal(&self, statement: Statement, lease: &Lease) -> Statement {
        let fleet = lease.fleet().as_str();
        let statement = bind_each!(statement.bind(fleet), self.batch.journal, |row| row.number, row.entries.as_slice());
        statement.bind(fleet).bind(self.batch.journal_done.unwrap_or(-1))
    }

    fn bind_decisions(&self, statement: Statement) -> Statement {
        let sorted = &self.sorted;
        let statement =
            bind_each!(statement, sorted.health, |row| row.whisker_id, row.recorded_us, row.kind, row.was, row.becomes);
        let statement = bind_each!(
            statement,
            sorted.trims,
            |row| row.trim_id,
            row.robot_id,
            row.whisker_id,
            row.detected_us,
            row.length_before_mm,
            row.length_after_mm,
            row.length_after_sd_mm,
            row.contacts_to_detect,
        );
        let statement = bind_each!(
            statement,
            sorted.decisions,
            |one| one.row.compensation_id,
            one.row.robot_id,
            one.row.target_whisker_id,
            one.row.target_length_mm,
            one.row.target_pressure_mpa,
            one.chosen.map(|chosen| chosen.whisker_id),
            one.chosen.map(|chosen| chosen.case),
            one.chosen.map(|chosen| chosen.pressure_before_mpa),
            one.chosen.and_then(|chosen| chosen.pressure_mpa),
            one.chosen.and_then(|chosen| chosen.predicted_error),
            one.chosen.and_then(|chosen| chosen.predicted_error_interval).map(|interval| interval.0),
            one.chosen.and_then(|chosen| chosen.predicted_error_interval).map(|interval| interval.1),
            one.row.decided_us,
            one.row.approval,
        );
        let statement = bind_each!(
            statement,
            sorted.candidates,
            |one| one.compensation_id,
            one.ordinal,
            one.row.whisker_id,
            one.row.case,
            one.row.length_mm,
            one.row.length_sd_mm,
            one.row.pressure_before_mpa,
            one.row.pressure_mpa,
            one.row.predicted_error,
            one.row.predicted_error_interval.map(|interval| interval.0),
            one.row.predicted_error_interval.map(|interval| interval.1),
            one.row.predicted_error_by_ratio.as_deref(),
            one.row.gives_up_own_role,
            one.row.chosen,
            one.row.refused,
        );
        bind_each!(statement, sorted.ended, |row| row.compensation_id, row.ended_us, row.end_reason)
    }

    fn bind_setpoints(&self, statement: Statement) -> Statement {
        let statement = bind_each!(
            statement,
            self.sorted.setpoints,
            |row| row.command_id.as_str(),
            row.robot_id,
            row.whisker_id,
            row.compensation_id,
            row.epoch,
            row.version,
            row.robot_boot_id.as_str(),
            row.pressure_mpa,
            row.slew_mpa_per_s,
            row.issued_us,
            row.expires_us,
            row.reason,
            row.gain.as_deref(),
        );
        let statement = bind_each!(
            statement,
            self.sorted.answered,
            |one| one.last.command_id.as_str(),
            one.last.state,
            one.last.error,
            one.pressure_mpa,
        );
        bind_each!(
            statement,
            self.sorted.states,
            |row| row.command_id.as_str(),
            row.recorded_us,
            row.state,
            row.error,
            row.pressure_mpa
        )
    }

    fn bind_errors(&self, statement: Statement) -> Statement {
        let statement = bind_each!(
            statement,
            self.sorted.errors,
            |row| row.compensation_id,
            row.recorded_us,
            row.contacts,
            row.bins.len() as i64,
            row.error.mean,
            row.error.low,
            row.error.high,
            row.pressure_mpa,
            row.with_gain.map(|with_gain| with_gain.mean),
            row.with_gain.map(|with_gain| with_gain.low),
            row.with_gain.map(|with_gain| with_gain.high),
        );
        let statement = bind_each!(
            statement,
            self.sorted.bins,
            |bin| bin.of.compensation_id,
            bin.of.recorded_us,
            bin.row.ratio,
            bin.row.contacts,
            bin.row.after_per_mm,
            bin.row.before_per_mm,
            bin.row.before_origin,
            bin.row.target_per_mm,
            bin.row.target_origin,
            bin.row.error.mean,
            bin.row.error.low,
            bin.row.error.high,
        );
        bind_each!(
            statement,
            self.sorted.refinements,
            |row| row.compensation_id,
            row.recorded_us,
            row.contacts,
            row.outcome,
            row.pressure_from_mpa,
            row.pressure_best_mpa,
            row.error.mean,
            row.error.low,
            row.error.high,
            row.error_best.map(|best| best.mean),
            row.error_best.map(|best| best.low),
            row.error_best.map(|best| best.high),
            row.error_with_gain,
            row.error_with_own_gain,
            row.gain_published,
        )
    }

    fn bind_alarms(&self, statement: Statement) -> Statement {
        let statement = bind_each!(statement, self.sorted.alarms, |row| row.whisker_id, row.raised_us, row.kind);
        bind_each!(statement, self.sorted.cleared, |row| row.whisker_id, row.cleared_us, row.kind)
    }

    fn bind_changes(&self, statement: Statement, lease: &Lease, now_us: i64) -> Statement {
        let changes: Vec<NewChange<'_>> = self.batch.records.iter().map(NewChange::of).collect();
        bind_each!(
            statement.bind(lease.fleet().as_str()),
            changes,
            |row| if row.recorded_us == 0 { now_us } else { row.recorded_us },
            row.kind,
            row.robot_id,
            row.whisker_id,
            row.number,
            row.command_id,
        )
    }
}
