//! A whole transaction as one statement: one way to the server and back, and one look at its plan.
//!
//! Its first part counts it in the fleet's lease; the others do nothing where that has not counted. What parts write no
//! other part sees, foreign keys are looked at in the end.

use std::sync::LazyLock;

use sqlx::postgres::PgConnection;
use sqlx::{Connection, Row};

use super::copy::{append_contacts, are_copied};
use super::rows::{
    CONTACTS, HOURS, MINUTES, RESPONSES, ROBOTS, Statement, WHISKERS, bind_contacts, bind_each, bind_responses,
    bind_robots, bind_rollups, bind_whiskers,
};
use super::sorted::Sorted;
use crate::engine::Resolution;
use crate::store::batch::{ContactRow, RollupRow};
use crate::store::changes::NewChange;
use crate::store::commit::tell_of_rollups;
use crate::store::{Batch, Lease, StoreError, failed};

/// Counts a transaction in the lease's row; also by itself.
pub(in super::super) const COUNTED: &str = "UPDATE leases SET commits = $4 + 1, expires_us = clock_us() + $5 \
    WHERE fleet = $1 AND epoch = $2 AND owner = $3 AND commits = $4 RETURNING fleet";

const JOURNAL: &str = "INSERT INTO journal (fleet, number, entries) \
    SELECT $1, n.* FROM unnest($2::bigint[], $3::bytea[]) AS n WHERE OWNED";

const JOURNAL_DONE: &str = "DELETE FROM journal WHERE fleet = $1 AND number <= $2 AND OWNED";

const REDO: &str = "INSERT INTO redo (fleet, number, rows) SELECT $1::text, $2::bigint, $3::bytea WHERE OWNED";

const REDO_DONE: &str = "DELETE FROM redo WHERE fleet = $1 AND number = $2 AND OWNED";

const HEALTH: &str = "INSERT INTO health_changes (whisker_id, recorded_us, kind, was, becomes) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::text[], $4::text[], $5::text[]) WHERE OWNED";

const TRIMS: &str = "INSERT INTO trims (trim_id, robot_id, whisker_id, detected_us, length_before_mm, length_after_mm, \
    length_after_sd_mm, contacts_to_detect) SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::bigint[], \
    $5::float8[], $6::float8[], $7::float8[], $8::bigint[]) WHERE OWNED";

const DECISIONS: &str = "INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, \
    target_pressure_mpa, compensator_whisker_id, compensation_case, pressure_before_mpa, pressure_mpa, \
    predicted_error, predicted_error_low, predicted_error_high, decided_us, approval) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::float8[], $5::float8[], $6::bigint[], $7::text[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::float8[], $13::bigint[], $14::text[]) WHERE OWNED";

const CANDIDATES: &str = "INSERT INTO compensation_candidates (compensation_id, ordinal, whisker_id, compensation_case, \
    length_mm, length_sd_mm, pressure_before_mpa, pressure_mpa, predicted_error, predicted_error_low, \
    predicted_error_high, predicted_error_by_ratio, gives_up_own_role, chosen, refused) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::text[], $5::float8[], $6::float8[], $7::float8[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::text[], $13::boolean[], $14::boolean[], $15::text[]) \
    WHERE OWNED";

const ENDED: &str = "UPDATE compensations c SET ended_us = n.ended_us, end_reason = n.end_reason, \
    approval = CASE WHEN n.end_reason = 'REFUSED' THEN 'REFUSED' ELSE approval END \
    FROM unnest($1::bigint[], $2::bigint[], $3::text[]) AS n (compensation_id, ended_us, end_reason) \
    WHERE c.compensation_id = n.compensation_id AND OWNED";

const SETPOINTS: &str = "INSERT INTO setpoints (command_id, robot_id, whisker_id, compensation_id, epoch, version, \
    robot_boot_id, pressure_mpa, slew_mpa_per_s, issued_us, expires_us, reason, gain, state) \
    SELECT *, 'PENDING' FROM unnest($1::text[], $2::bigint[], $3::bigint[], $4::bigint[], $5::bigint[], $6::bigint[], \
    $7::text[], $8::float8[], $9::float8[], $10::bigint[], $11::bigint[], $12::text[], $13::text[]) WHERE OWNED \
    RETURNING command_id, issued_us";

const FIRST_STATES: &str = "INSERT INTO setpoint_states (command_id, recorded_us, state) \
    SELECT command_id, issued_us, 'PENDING' FROM setpoints_new WHERE OWNED";

const ANSWERED: &str = "UPDATE setpoints s SET state = n.state, error = n.error, \
    reached_mpa = COALESCE(n.pressure_mpa, reached_mpa) \
    FROM unnest($1::text[], $2::text[], $3::text[], $4::float8[]) AS n (command_id, state, error, pressure_mpa) \
    WHERE s.command_id = n.command_id AND OWNED";

const STATES: &str = "INSERT INTO setpoint_states (command_id, recorded_us, state, error, pressure_mpa) \
    SELECT * FROM unnest($1::text[], $2::bigint[], $3::text[], $4::text[], $5::float8[]) WHERE OWNED";

const ERRORS: &str = "INSERT INTO compensation_errors (compensation_id, recorded_us, contacts, bins, error, error_low, \
    error_high, pressure_mpa, error_with_gain, error_with_gain_low, error_with_gain_high) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::bigint[], $5::float8[], $6::float8[], $7::float8[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[]) WHERE OWNED \
    RETURNING compensation_error_id, compensation_id, recorded_us";

const BINS: &str = "INSERT INTO compensation_error_bins (compensation_error_id, ratio, contacts, after_per_mm, \
    before_per_mm, before_origin, target_per_mm, target_origin, error, error_low, error_high) \
    SELECT e.compensation_error_id, n.ratio, n.contacts, n.after_per_mm, n.before_per_mm, n.before_origin, \
    n.target_per_mm, n.target_origin, n.error, n.error_low, n.error_high \
    FROM unnest($1::bigint[], $2::bigint[], $3::float8[], $4::bigint[], $5::float8[], $6::float8[], $7::text[], \
    $8::float8[], $9::text[], $10::float8[], $11::float8[], $12::float8[]) \
    AS n (compensation_id, recorded_us, ratio, contacts, after_per_mm, before_per_mm, before_origin, target_per_mm, \
    target_origin, error, error_low, error_high) \
    JOIN errors_new e USING (compensation_id, recorded_us) WHERE OWNED";

const REFINEMENTS: &str = "INSERT INTO compensation_refinements (compensation_id, recorded_us, contacts, outcome, \
    pressure_from_mpa, pressure_best_mpa, error, error_low, error_high, error_best, error_best_low, error_best_high, \
    error_with_gain, error_with_own_gain, gain_published) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::text[], $5::float8[], $6::float8[], $7::float8[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::float8[], $13::float8[], $14::float8[], \
    $15::boolean[]) WHERE OWNED";

const ALARMS: &str = "INSERT INTO alarms (whisker_id, raised_us, kind) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::text[]) WHERE OWNED";

const CLEARED: &str = "UPDATE alarms a SET cleared_us = n.cleared_us \
    FROM unnest($1::bigint[], $2::bigint[], $3::text[]) AS n (whisker_id, cleared_us, kind) \
    WHERE a.whisker_id = n.whisker_id AND a.kind = n.kind AND a.cleared_us IS NULL AND OWNED";

const CHANGES: &str = "INSERT INTO changes (fleet, recorded_us, kind, robot_id, whisker_id, number, command_id) \
    SELECT $1, n.* FROM unnest($2::bigint[], $3::text[], $4::bigint[], $5::bigint[], $6::bigint[], $7::text[]) AS n \
    WHERE OWNED";

/// A transaction that is kept as it is, for now.
static KEPT: LazyLock<String> = LazyLock::new(|| of_parts(&[("counted", COUNTED), ("kept", REDO)]));

/// The statement that keeps one: after what the lease asks for come fleet, number and bytes.
pub(in super::super) fn kept() -> &'static str {
    &KEPT
}

/// A transaction in which nothing but contacts has come.
static ORDINARY: LazyLock<String> = LazyLock::new(|| {
    of_parts(&[
        ("counted", COUNTED),
        ("journal_new", JOURNAL),
        ("journal_done", JOURNAL_DONE),
        ("contacts_new", CONTACTS),
    ])
});

/// A transaction with all that there may be; most of it is empty.
static WHOLE: LazyLock<String> = LazyLock::new(|| {
    of_parts(&[
        ("counted", COUNTED),
        ("journal_new", JOURNAL),
        ("journal_done", JOURNAL_DONE),
        ("contacts_new", CONTACTS),
        ("redo_done", REDO_DONE),
        ("robots_now", ROBOTS),
        ("whiskers_now", WHISKERS),
        ("health_new", HEALTH),
        ("trims_new", TRIMS),
        ("compensations_new", DECISIONS),
        ("candidates_new", CANDIDATES),
        ("compensations_ended", ENDED),
        ("setpoints_new", SETPOINTS),
        ("setpoint_states_first", FIRST_STATES),
        ("setpoints_answered", ANSWERED),
        ("setpoint_states_next", STATES),
        ("errors_new", ERRORS),
        ("bins_new", BINS),
        ("refinements_new", REFINEMENTS),
        ("alarms_new", ALARMS),
        ("alarms_cleared", CLEARED),
        ("responses_new", RESPONSES),
        ("changes_new", CHANGES),
        ("minutes_new", MINUTES),
        ("hours_new", HOURS),
    ])
});

/// One statement of named parts, each with its own numbers of parameters.
fn of_parts(parts: &[(&str, &str)]) -> String {
    let mut first = 0;
    let parts: Vec<String> = parts
        .iter()
        .map(|(name, sql)| {
            let mut pieces = sql.split('$');
            let mut whole = pieces.next().unwrap_or_default().to_owned();
            let before = first;
            for piece in pieces {
                let digits = piece.find(|c: char| !c.is_ascii_digit()).unwrap_or(piece.len());
                let number = before + piece[..digits].parse::<usize>().unwrap_or_default();
                first = first.max(number);
                whole += &format!("${number}{}", &piece[digits..]);
            }
            format!("{name} AS ({})", whole.replace("OWNED", "EXISTS (SELECT FROM counted)"))
        })
        .collect();
    let written = |name| if parts.iter().any(|part| part.starts_with(name)) { name } else { "counted" };
    format!(
        "WITH {} SELECT (SELECT count(*) FROM counted), (SELECT count(*) FROM {}), (SELECT count(*) FROM {})",
        parts.join(", "),
        written("minutes_new"),
        written("hours_new")
    )
}

/// A batch that one statement can write.
pub(in super::super) struct Whole<'b> {
    batch: &'b Batch,
    sorted: Sorted<'b>,
}

impl<'b> Whole<'b> {
    /// None if the batch has layouts or rare records, which are written one by one.
    pub(in super::super) fn of(batch: &'b Batch) -> Option<Self> {
        if !batch.layouts.is_empty() {
            return None;
        }
        Some(Self { batch, sorted: Sorted::of(&batch.records)? })
    }

    /// Writes it, all or nothing, and counts it; false, and nothing, if the lease's row says otherwise.
    ///
    /// Many contacts have a way of their own, which makes a transaction of it. They come before the lease is held:
    /// their `COPY` waits for as long as its bytes do, and who freezes in it must not keep the fleet from others.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_statement_have_parameters_of_their_own() {
        let parts = [
            ("counted", "UPDATE a SET b = $2 WHERE c = $1 RETURNING c"),
            ("next", "DELETE FROM d WHERE e = $1 AND OWNED"),
        ];
        assert_eq!(
            of_parts(&parts),
            "WITH counted AS (UPDATE a SET b = $2 WHERE c = $1 RETURNING c), \
             next AS (DELETE FROM d WHERE e = $3 AND EXISTS (SELECT FROM counted)) SELECT (SELECT count(*) FROM counted), \
             (SELECT count(*) FROM counted), (SELECT count(*) FROM counted)"
        );
    }

    #[test]
    fn no_part_is_written_without_the_lease() {
        for sql in [&*KEPT, &*ORDINARY, &*WHOLE] {
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
