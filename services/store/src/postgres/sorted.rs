//! Sorts the records of batches by kind, if one statement can write them all.

use std::borrow::Cow;
use std::collections::HashSet;

use crate::batch::{
    AlarmClearedRow, AlarmRow, CandidateRow, DecisionRow, EndedRow, ErrorBinRow, ErrorRow, HealthRow, Record,
    RefinementRow, RobotAlarmClearedRow, RobotAlarmRow, SetpointRow, SetpointStateRow, TouchTestProgressRow,
    TouchTestRow, TrimRow,
};
use crate::tables::{BinKey, CandidateKey};

/// The records of batches by kind, each kind in its order.
#[derive(Default)]
pub(super) struct Sorted<'b> {
    pub(super) health: Vec<&'b HealthRow>,
    pub(super) trims: Vec<&'b TrimRow>,
    pub(super) decisions: Vec<&'b DecisionRow>,
    pub(super) candidates: Vec<(CandidateKey, &'b CandidateRow)>,
    pub(super) ended: Vec<&'b EndedRow>,
    pub(super) setpoints: Vec<&'b SetpointRow>,
    /// States of setpoints, also the first ones of `setpoints`.
    pub(super) states: Vec<Cow<'b, SetpointStateRow>>,
    /// For each older setpoint of `states`, its last state with the last pressure that the robot reported for it.
    pub(super) answered: Vec<SetpointStateRow>,
    pub(super) errors: Vec<&'b ErrorRow>,
    pub(super) bins: Vec<(BinKey, &'b ErrorBinRow)>,
    pub(super) refinements: Vec<&'b RefinementRow>,
    pub(super) alarms: Vec<&'b AlarmRow>,
    pub(super) cleared: Vec<&'b AlarmClearedRow>,
    pub(super) robot_alarms: Vec<&'b RobotAlarmRow>,
    pub(super) robot_cleared: Vec<&'b RobotAlarmClearedRow>,
    pub(super) tests: Vec<&'b TouchTestRow>,
    /// For each older touch test, its progress added up.
    pub(super) test_progress: Vec<TouchTestProgressRow>,
}

/// A row that a record inserts or updates. The parts of one statement do not see each other's rows, so each row may
/// be touched once only. States of a setpoint may follow each other.
#[derive(PartialEq, Eq, Hash)]
enum Touched<'b> {
    Compensation(i64),
    Error(i64, i64),
    Setpoint(&'b str),
    Alarm(i64, &'b str),
    RobotAlarm(i64, &'b str),
    Test(i64, &'b str),
}

impl<'b> Sorted<'b> {
    /// Sorts the records; `None` if a kind is too rare to be part of the statement, or a row is touched twice.
    pub(super) fn of(records: impl IntoIterator<Item = &'b Record>) -> Option<Self> {
        let (mut sorted, mut touched) = (Self::default(), HashSet::new());
        for record in records {
            let is_first = match record {
                Record::Health(_) | Record::Trim(_) | Record::Refinement(_) => true,
                Record::Decision(row) => touched.insert(Touched::Compensation(row.compensation_id)),
                Record::Ended(row) => touched.insert(Touched::Compensation(row.compensation_id)),
                Record::Setpoint(row) => touched.insert(Touched::Setpoint(&row.command_id)),
                Record::SetpointState(row) => {
                    touched.insert(Touched::Setpoint(&row.command_id)) || sorted.answered(row).is_some()
                }
                Record::Error(row) => touched.insert(Touched::Error(row.compensation_id, row.recorded_us)),
                Record::Alarm(row) => touched.insert(Touched::Alarm(row.whisker_id, row.kind)),
                Record::AlarmCleared(row) => touched.insert(Touched::Alarm(row.whisker_id, row.kind)),
                Record::RobotAlarm(row) => touched.insert(Touched::RobotAlarm(row.robot_id, row.kind)),
                Record::RobotAlarmCleared(row) => touched.insert(Touched::RobotAlarm(row.robot_id, row.kind)),
                Record::TouchTest(row) => touched.insert(Touched::Test(row.robot_id, &row.test_id)),
                Record::TouchTestProgress(row) => {
                    touched.insert(Touched::Test(row.robot_id, &row.test_id)) || sorted.progress(row).is_some()
                }
                Record::Activation(_)
                | Record::Approved { .. }
                | Record::Gone { .. }
                | Record::Answer { .. }
                | Record::Policy(_)
                | Record::Quarantined(_)
                | Record::AlarmsForgotten { .. }
                | Record::Decommissioned { .. }
                | Record::TestOfAction { .. }
                | Record::Rollout(_) => false,
            };
            if !is_first {
                return None;
            }
            sorted.put(record);
        }
        Some(sorted)
    }

    fn answered(&mut self, row: &SetpointStateRow) -> Option<&mut SetpointStateRow> {
        self.answered.iter_mut().find(|last| last.command_id == row.command_id)
    }

    fn progress(&mut self, row: &TouchTestProgressRow) -> Option<&mut TouchTestProgressRow> {
        let test = (row.robot_id, &row.test_id);
        self.test_progress.iter_mut().find(|before| (before.robot_id, &before.test_id) == test)
    }

    fn put(&mut self, record: &'b Record) {
        match record {
            Record::Health(row) => self.health.push(row),
            Record::Trim(row) => self.trims.push(row),
            Record::Decision(row) => {
                self.decisions.push(row);
                self.candidates.extend(row.rows());
            }
            Record::Ended(row) => self.ended.push(row),
            Record::Setpoint(row) => {
                self.setpoints.push(row);
                self.states.push(Cow::Owned(row.first_state()));
            }
            Record::SetpointState(row) => {
                self.states.push(Cow::Borrowed(row));
                match self.answered(row) {
                    Some(last) => {
                        let pressure_mpa = row.pressure_mpa.or(last.pressure_mpa);
                        *last = SetpointStateRow { pressure_mpa, ..row.clone() };
                    }
                    None => self.answered.push(row.clone()),
                }
            }
            Record::Error(row) => {
                self.errors.push(row);
                self.bins.extend(row.rows());
            }
            Record::Refinement(row) => self.refinements.push(row),
            Record::Alarm(row) => self.alarms.push(row),
            Record::AlarmCleared(row) => self.cleared.push(row),
            Record::RobotAlarm(row) => self.robot_alarms.push(row),
            Record::RobotAlarmCleared(row) => self.robot_cleared.push(row),
            Record::TouchTest(row) => self.tests.push(row),
            Record::TouchTestProgress(row) => match self.progress(row) {
                Some(before) => before.add(row),
                None => self.test_progress.push(TouchTestProgressRow::clone(row)),
            },
            Record::Activation(_)
            | Record::Approved { .. }
            | Record::Gone { .. }
            | Record::Answer { .. }
            | Record::Policy(_)
            | Record::Quarantined(_)
            | Record::AlarmsForgotten { .. }
            | Record::Decommissioned { .. }
            | Record::TestOfAction { .. }
            | Record::Rollout(_) => {}
        }
    }
}
