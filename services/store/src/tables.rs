//! The statements that write a batch, one for each kind of row. Their columns come from the declarations of the rows.

use super::batch::{
    AlarmClearedRow, AlarmRow, CandidateRow, ContactRow, DecisionRow, EndedRow, ErrorBinRow, ErrorRow, EventRow,
    HealthRow, JournalRow, PolicyRow, QuarantineRow, RefinementRow, ResponseRow, RobotAlarmClearedRow, RobotAlarmRow,
    RobotRow, RollupRow, SetpointRow, SetpointStateRow, TouchTestProgressRow, TouchTestRow, TrimRow, WhiskerRow,
};
use super::row::{Declared, Parent, Statement, columns};
use crate::{Lease, Resolution};

/// The fleet of a row that does not name it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InFleet<'b> {
    pub(crate) fleet: &'b str,
}

impl<'b> InFleet<'b> {
    pub(crate) fn of(lease: &'b Lease) -> Self {
        Self { fleet: lease.fleet().as_str() }
    }
}

columns! {
    InFleet<'b> { fleet: &'b str, }
}

/// The number of a fleet's row in the journal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JournalNumber<'b> {
    pub(crate) fleet: &'b str,
    pub(crate) number: i64,
}

columns! {
    JournalNumber<'b> { fleet: &'b str, number: i64, }
}

/// A position in a partitioned log.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LogPositionRow<'b> {
    pub(crate) fleet: &'b str,
    pub(crate) topic: &'b str,
    pub(crate) log_partition: i64,
    pub(crate) next: i64,
}

columns! {
    LogPositionRow<'b> { fleet: &'b str, topic: &'b str, log_partition: i64, next: i64, }
}

/// The decision of a candidate, and the candidate's position in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CandidateKey {
    compensation_id: i64,
    ordinal: i64,
}

columns! {
    CandidateKey { compensation_id: i64, ordinal: i64, }
}

impl DecisionRow {
    /// The candidates, with their keys.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (CandidateKey, &CandidateRow)> {
        let key = |ordinal| CandidateKey { compensation_id: self.compensation_id, ordinal };
        self.candidates.iter().zip(0..).map(move |(row, ordinal)| (key(ordinal), row))
    }
}

/// The measured error of a bin; the database numbers errors when it inserts them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BinKey {
    compensation_id: i64,
    recorded_us: i64,
}

columns! {
    BinKey { compensation_id: i64, recorded_us: i64, }
}

impl ErrorRow {
    /// The bins, with their key.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (BinKey, &ErrorBinRow)> {
        let key = BinKey { compensation_id: self.compensation_id, recorded_us: self.recorded_us };
        self.bins.iter().map(move |row| (key, row))
    }
}

pub(crate) static ROBOTS: Statement<RobotRow> = Statement::update("robots", "");
pub(crate) static WHISKERS: Statement<WhiskerRow> = Statement::update("whiskers", "");
pub(crate) static CONTACTS: Statement<ContactRow> = Statement::insert("contacts");
pub(crate) static RESPONSES: Statement<ResponseRow> = Statement::insert("compensation_responses");
pub(crate) static JOURNAL: Statement<(InFleet<'static>, &JournalRow)> = Statement::insert("journal");
/// Deletes the journal's rows up to a number.
pub(crate) static JOURNAL_DONE: Statement<JournalNumber<'static>> = Statement::custom(
    "journal",
    "DELETE FROM journal AS t USING ROWS WHERE t.fleet = n.fleet AND t.number <= n.number AND OWNED",
);
pub(crate) static EVENTS: Statement<(InFleet<'static>, &EventRow)> = Statement::insert("events");
pub(crate) static LOG_POSITIONS: Statement<LogPositionRow<'static>> = Statement::insert("log_positions")
    .on_conflict(" ON CONFLICT (fleet, topic, log_partition) DO UPDATE SET next = excluded.next");
pub(crate) static HEALTH: Statement<HealthRow> = Statement::insert("health_changes");
pub(crate) static TRIMS: Statement<TrimRow> = Statement::insert("trims");
pub(crate) static DECISIONS: Statement<DecisionRow> = Statement::insert("compensations");
pub(crate) static CANDIDATES: Statement<(CandidateKey, &CandidateRow)> = Statement::insert("compensation_candidates");
pub(crate) static SETPOINTS: Statement<SetpointRow> = Statement::insert("setpoints");
pub(crate) static STATES: Statement<SetpointStateRow> = Statement::insert("setpoint_states");
pub(crate) static REFINEMENTS: Statement<RefinementRow> = Statement::insert("compensation_refinements");
pub(crate) static ALARMS: Statement<AlarmRow> = Statement::insert("alarms");
pub(crate) static ROBOT_ALARMS: Statement<RobotAlarmRow> = Statement::insert("alarms");
pub(crate) static POLICIES: Statement<PolicyRow> = Statement::insert("policies");
pub(crate) static QUARANTINE: Statement<(InFleet<'static>, &QuarantineRow)> = Statement::insert("quarantine");

/// Existing aggregates are left unchanged.
static MINUTES: Statement<RollupRow> = Statement::insert("contact_minutes").unless_exists().returning("start_us");
static HOURS: Statement<RollupRow> = Statement::insert("contact_hours").unless_exists().returning("start_us");

/// The statement that writes aggregates.
pub(crate) fn rollups(resolution: Resolution) -> &'static Statement<RollupRow> {
    match resolution {
        Resolution::Minute => &MINUTES,
        Resolution::Hour => &HOURS,
    }
}

pub(crate) static ERRORS: Statement<ErrorRow> =
    Statement::insert("compensation_errors").returning("compensation_error_id, compensation_id, recorded_us");
pub(crate) static BINS: Statement<(BinKey, &ErrorBinRow)> = Statement::insert_below(
    "compensation_error_bins",
    Parent {
        table: "compensation_errors",
        part: "errors_new",
        number: "compensation_error_id",
        keys: ["compensation_id", "recorded_us"],
    },
);

/// Journal rows of a test that plants a fault: two owners write the same numbers, and the conflict would protect each
/// from the damage that the test waits for.
pub(crate) static JOURNAL_UNFENCED: Statement<(InFleet<'static>, &JournalRow)> =
    Statement::insert("journal").unless_exists();

pub(crate) static ENDED: Statement<EndedRow> = Statement::update(
    "compensations",
    "approval = CASE WHEN n.end_reason = 'REFUSED' THEN 'REFUSED' ELSE approval END",
);

/// The newest state of setpoints. A state without a pressure leaves the reported one unchanged.
pub(crate) static ANSWERED: Statement<SetpointStateRow> = Statement::custom(
    "setpoints",
    "UPDATE setpoints AS t SET state = n.state, error = n.error, \
     reached_mpa = COALESCE(n.pressure_mpa, reached_mpa) FROM ROWS WHERE t.command_id = n.command_id AND OWNED",
);

/// Each alarm is looked up with its own subquery. PostgreSQL's estimate of the number of standing alarms can be wrong
/// by a factor of a thousand when a fleet goes offline, and a join planned with it would compare every alarm with
/// every other.
pub(crate) static CLEARED: Statement<AlarmClearedRow> = Statement::custom(
    "alarms",
    "UPDATE alarms AS t SET cleared_us = m.cleared_us FROM (SELECT n.cleared_us, (SELECT s.alarm_id FROM alarms s \
     WHERE s.whisker_id = n.whisker_id AND s.kind = n.kind AND s.cleared_us IS NULL LIMIT 1) AS alarm_id \
     FROM ROWS) AS m WHERE t.alarm_id = m.alarm_id AND OWNED",
);

/// As [`CLEARED`], for alarms about robots.
pub(crate) static ROBOT_CLEARED: Statement<RobotAlarmClearedRow> = Statement::custom(
    "alarms",
    "UPDATE alarms AS t SET cleared_us = m.cleared_us FROM (SELECT n.cleared_us, (SELECT s.alarm_id FROM alarms s \
     WHERE s.robot_id = n.robot_id AND s.kind = n.kind AND s.cleared_us IS NULL LIMIT 1) AS alarm_id \
     FROM ROWS) AS m WHERE t.alarm_id = m.alarm_id AND OWNED",
);

pub(crate) static TOUCH_TESTS: Statement<TouchTestRow> = Statement::insert("touch_tests");

/// The newest state of touch tests. Progress without a state leaves it unchanged.
pub(crate) static TOUCH_TEST_PROGRESS: Statement<TouchTestProgressRow> = Statement::custom(
    "touch_tests",
    "UPDATE touch_tests AS t SET updated_us = n.updated_us, state = COALESCE(n.state, t.state), \
     error = COALESCE(n.error, t.error), ended_us = COALESCE(n.ended_us, t.ended_us), \
     touches = t.touches + n.touches, missed = t.missed + n.missed, \
     length_mm = COALESCE(n.length_mm, t.length_mm), length_sd_mm = COALESCE(n.length_sd_mm, t.length_sd_mm) \
     FROM ROWS WHERE t.test_id = n.test_id AND t.robot_id = n.robot_id AND OWNED",
);

/// Columns that the program writes into a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Name of the table.
    pub table: &'static str,
    /// Whether rows are inserted, not only updated.
    pub inserts: bool,
    /// Columns, each with its type in SQLite and in PostgreSQL.
    pub columns: Vec<(&'static str, &'static str, &'static str)>,
}

/// The columns of all statements, as the rows are declared.
#[must_use]
pub fn written() -> Vec<Written> {
    let all: [&dyn Declared; 29] = [
        &ROBOTS,
        &WHISKERS,
        &CONTACTS,
        &RESPONSES,
        &JOURNAL,
        &EVENTS,
        &LOG_POSITIONS,
        &HEALTH,
        &TRIMS,
        &DECISIONS,
        &CANDIDATES,
        &SETPOINTS,
        &STATES,
        &REFINEMENTS,
        &ALARMS,
        &POLICIES,
        &QUARANTINE,
        &MINUTES,
        &HOURS,
        &ERRORS,
        &BINS,
        &JOURNAL_UNFENCED,
        &ENDED,
        &ANSWERED,
        &CLEARED,
        &ROBOT_ALARMS,
        &ROBOT_CLEARED,
        &TOUCH_TESTS,
        &TOUCH_TEST_PROGRESS,
    ];
    let names = |one: &dyn Declared| {
        one.written().into_iter().map(|column| (column.name, column.kind.sqlite(), column.kind.postgres())).collect()
    };
    all.into_iter().map(|one| Written { table: one.table(), inserts: one.inserts(), columns: names(one) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::statement::ROWS_A_STATEMENT;

    #[test]
    fn no_statement_has_more_parameters_than_sqlite_accepts() {
        for one in written() {
            assert!(one.columns.len() * ROWS_A_STATEMENT <= 32_766, "{one:?}");
        }
    }
}
