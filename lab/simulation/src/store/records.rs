//! The rarer rows of batches.

use vibrissa_edge::events::EventKind;
use vibrissa_store::Lease;
use vibrissa_store::batch::{DecisionRow, EventRow, PolicyRow, Record, SetpointRow};
use vibrissa_store::calibrations::{ActivationRow, ActiveCalibration};
use vibrissa_store::model::Violation;
use vibrissa_store::rollouts::RolloutRow;

use super::{ModelStore, check, known, unique};

/// Greatest pressure of a setpoint, MPa.
const PRESSURE_MAX_MPA: f64 = 0.2;

/// A decision.
#[derive(Debug, Clone)]
pub(super) struct Compensation {
    pub(super) robot_id: i64,
    pub(super) decided_us: i64,
    pub(super) has_compensator: bool,
    /// The newest measured error, as a ratio.
    pub(super) error: Option<f64>,
}

/// A standing alarm, about a whisker or a robot.
#[derive(Debug, Clone)]
pub(super) struct Alarm {
    pub(super) whisker_id: Option<i64>,
    pub(super) robot_id: Option<i64>,
    pub(super) kind: &'static str,
}

impl ModelStore {
    /// Writes one of the rarer rows, as far as it is loaded or others refer to it.
    pub(super) fn write_record(&mut self, lease: &Lease, record: &Record) -> Result<(), Violation> {
        match record {
            Record::Health(row) => known(self.whiskers.has(&row.whisker_id), "whiskers"),
            Record::Trim(row) => {
                self.known_whisker(row.robot_id, row.whisker_id)?;
                unique(self.trims.has(&row.trim_id), "trims")?;
                self.trims.set(row.trim_id, row.robot_id);
                Ok(())
            }
            Record::Decision(row) => self.write_decision(row),
            Record::Setpoint(row) => self.write_setpoint(row),
            Record::SetpointState(row) => known(self.setpoints.has(&row.command_id), "setpoints"),
            Record::Error(row) => {
                known(self.compensations.has(&row.compensation_id), "compensations")?;
                self.compensations.change(&row.compensation_id, |one| one.error = Some(row.error.mean));
                Ok(())
            }
            Record::Refinement(row) => known(self.compensations.has(&row.compensation_id), "compensations"),
            Record::Activation(row) => self.activate(row),
            Record::Alarm(row) => self.raise(Some(row.whisker_id), None, row.kind),
            Record::RobotAlarm(row) => self.raise(None, Some(row.robot_id), row.kind),
            Record::AlarmCleared(row) => {
                self.clear_one(|one| one.whisker_id == Some(row.whisker_id) && one.kind == row.kind);
                Ok(())
            }
            Record::RobotAlarmCleared(row) => {
                self.clear_one(|one| one.robot_id == Some(row.robot_id) && one.kind == row.kind);
                Ok(())
            }
            Record::Gone { robot_id, array, whisker, cleared_us } => {
                self.clear_alarms(lease, *robot_id, Some((array, *whisker)), *cleared_us);
                Ok(())
            }
            Record::AlarmsForgotten { robot_id, cleared_us } => {
                self.clear_alarms(lease, *robot_id, None, *cleared_us);
                Ok(())
            }
            Record::Decommissioned { robot_id, left_us } => {
                self.decommission(lease, *robot_id, *left_us);
                Ok(())
            }
            Record::Answer { action_id, state, problem, done_us, .. } => {
                self.answer(*action_id, state, problem.as_deref(), *done_us);
                Ok(())
            }
            Record::Policy(row) => self.write_policy(row),
            Record::TouchTest(row) => {
                self.known_whisker(row.robot_id, row.whisker_id)?;
                unique(self.touch_tests.has(&row.test_id), "touch_tests")?;
                self.touch_tests.set(row.test_id.clone(), ());
                Ok(())
            }
            Record::Rollout(change) => self.write_rollout(&change.row),
            Record::Ended(_)
            | Record::Approved { .. }
            | Record::Quarantined(_)
            | Record::TouchTestProgress(_)
            | Record::TestOfAction { .. } => Ok(()),
        }
    }

    fn known_whisker(&self, robot_id: i64, whisker_id: i64) -> Result<(), Violation> {
        known(self.robots.has(&robot_id), "robots")?;
        known(self.whiskers.has(&whisker_id), "whiskers")
    }

    fn write_decision(&mut self, row: &DecisionRow) -> Result<(), Violation> {
        self.known_whisker(row.robot_id, row.target_whisker_id)?;
        unique(self.compensations.has(&row.compensation_id), "compensations")?;
        for candidate in &row.candidates {
            known(self.whiskers.has(&candidate.whisker_id), "whiskers")?;
        }
        let has_compensator = row.candidates.iter().any(|one| one.chosen);
        let (robot_id, decided_us, error) = (row.robot_id, row.decided_us, None);
        self.compensations.set(row.compensation_id, Compensation { robot_id, decided_us, has_compensator, error });
        Ok(())
    }

    fn write_setpoint(&mut self, row: &SetpointRow) -> Result<(), Violation> {
        let is_possible = (0.0..=PRESSURE_MAX_MPA).contains(&row.pressure_mpa);
        check(is_possible, "23514", || format!("setpoints: {} MPa are impossible", row.pressure_mpa))?;
        self.known_whisker(row.robot_id, row.whisker_id)?;
        known(row.compensation_id.is_none_or(|id| self.compensations.has(&id)), "compensations")?;
        let version = (row.robot_id, row.epoch, row.version);
        unique(self.setpoints.has(&row.command_id) || self.versions.has(&version), "setpoints")?;
        self.setpoints.set(row.command_id.clone(), row.robot_id);
        self.versions.set(version, ());
        Ok(())
    }

    fn activate(&mut self, row: &ActivationRow) -> Result<(), Violation> {
        known(self.calibrations.has(&row.calibration_id), "calibrations")?;
        let calibration = self.calibrations.get(&row.calibration_id).cloned().unwrap_or_default();
        let active = ActiveCalibration { calibration_id: row.calibration_id, calibration };
        self.active_calibrations.set((row.fleet.clone(), row.model.clone()), active);
        Ok(())
    }

    fn raise(&mut self, whisker_id: Option<i64>, robot_id: Option<i64>, kind: &'static str) -> Result<(), Violation> {
        known(whisker_id.is_none_or(|id| self.whiskers.has(&id)), "whiskers")?;
        known(robot_id.is_none_or(|id| self.robots.has(&id)), "robots")?;
        let alarm_id = self.next_number();
        self.alarms.set(alarm_id, Alarm { whisker_id, robot_id, kind });
        Ok(())
    }

    fn clear_one(&mut self, is_it: impl Fn(&Alarm) -> bool) {
        let found = self.alarms.iter().find(|(_, alarm)| is_it(alarm)).map(|(id, _)| *id);
        found.iter().for_each(|alarm_id| self.alarms.remove(alarm_id));
    }

    /// Clears the alarms of a robot and its whiskers, or of one whisker, each with its event.
    pub(super) fn clear_alarms(
        &mut self,
        lease: &Lease,
        robot_id: i64,
        whisker: Option<(&String, i64)>,
        cleared_us: i64,
    ) {
        let mut whiskers = self.whiskers_of(robot_id);
        if let Some(place) = whisker {
            whiskers.retain(|id| self.whiskers.get(id).is_some_and(|row| (&row.array, row.whisker) == place));
        }
        let is_robot = |alarm: &Alarm| whisker.is_none() && alarm.robot_id == Some(robot_id);
        let is_whisker = |alarm: &Alarm| alarm.whisker_id.is_some_and(|id| whiskers.contains(&id));
        for alarm_id in self.alarms.keys_of(|_, alarm| is_robot(alarm) || is_whisker(alarm)) {
            let Some(alarm) = self.alarms.get(&alarm_id).cloned() else { continue };
            self.alarms.remove(&alarm_id);
            let event = EventRow::new(EventKind::AlarmCleared, cleared_us).of_robot(robot_id);
            let event = EventRow { word: Some(alarm.kind), whisker_id: alarm.whisker_id, ..event };
            self.append_event(lease, event);
        }
    }

    /// Answers an action. An answer stays, unless a request for many was stopped and the action was done all the same.
    fn answer(&mut self, action_id: i64, state: &str, problem: Option<&str>, done_us: i64) {
        self.actions.change(&action_id, |action| {
            let is_stopped = action.state == "REFUSED" && action.refusal().is_some_and(|(code, _)| code == "STOPPED");
            if action.is_pending() || is_stopped && state == "DONE" {
                (action.state, action.problem) = (state.to_owned(), problem.map(str::to_owned));
                action.done_us = Some(done_us);
            }
        });
    }

    fn write_policy(&mut self, row: &PolicyRow) -> Result<(), Violation> {
        let key = (row.fleet.clone(), row.version);
        unique(self.policies.has(&key), "policies")?;
        known(self.actions.has(&row.action_id), "actions")?;
        self.policies.set(key, row.into());
        Ok(())
    }

    fn write_rollout(&mut self, new: &RolloutRow) -> Result<(), Violation> {
        known(self.actions.has(&new.rollout_id), "actions")?;
        let is_open = ["RUNNING", "PAUSED"].contains(&&*new.state);
        unique(is_open && self.has_other_rollout(new), "rollouts")?;
        let first = self.rollouts.get(&new.rollout_id).unwrap_or(new).clone();
        // What it began with stays.
        let (level, robots, started_us) = (first.level, first.robots, first.started_us);
        let RolloutRow { fleet, kind, change, started_by, reason, .. } = first;
        let begun = RolloutRow { fleet, kind, change, level, robots, started_us, started_by, reason, ..new.clone() };
        self.rollouts.set(new.rollout_id, begun);
        Ok(())
    }
}
