//! What operators ask: read, carried out in order, and answered in the transaction that has the effects.

use std::sync::Arc;

use serde::Deserialize;
use tracing::{error, info, warn};
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Params, Place};
use vibrissa_core::units::Micros;
use vibrissa_edge::actions::{self, ActionKind, PolicyChange, Request, Subject};
use vibrissa_edge::words::{Word, named};
use vibrissa_protocol::Name;

use super::{Engine, wall_clock};
use crate::calibration_file::CalibrationFile;
use crate::store::actions::{Action, PolicyReading};
use crate::store::batch::{PolicyRow, Record};
use crate::store::calibrations::{ActivationRow, ActiveCalibration};

/// Actions that are read at a time.
const ACTIONS_MAX: i64 = 100;

/// The kind of an action that puts a calibration in force.
pub const CALIBRATION: &str = "CALIBRATION";

/// Why an action is refused: a word for programs, a colon, and a text for people.
type Problem = String;

impl Engine {
    /// Carries out what waits. A database that is away is not waited for here: what is asked stays asked.
    pub(super) async fn open_mail(&mut self, now: Micros) {
        let pending = match self.writer.pending(&self.lease, ACTIONS_MAX).await {
            Ok(pending) => pending,
            Err(problem) => {
                self.program.database_failed();
                warn!(%problem, fleet = %self.fleet, "cannot see what operators ask; looking again");
                return;
            }
        };
        if pending.len() as i64 == ACTIONS_MAX {
            self.bell.notify_one();
        }
        for action in pending {
            let is_expired = wall_clock().0 as i64 >= action.expires_us;
            let (state, problem) = match (!is_expired).then(|| self.carry_out(&action, now)) {
                None => ("EXPIRED", None),
                Some(Ok(())) => ("DONE", None),
                Some(Err(problem)) => ("REFUSED", Some(problem)),
            };
            let kind = match named(ActionKind::ALL, &action.kind) {
                Some(kind) => kind.word(),
                None if action.kind == CALIBRATION => CALIBRATION,
                None => "UNKNOWN",
            };
            self.metrics.actions.count([kind, state]);
            info!(fleet = %self.fleet, action = action.action_id, kind, state, problem, actor = action.actor, "asked");
            let (action_id, done_us) = (action.action_id, wall_clock().0 as i64);
            self.batch.records.push(Record::Answer { action_id, state, problem, done_us });
            self.answered.push(action_id);
        }
    }

    fn carry_out(&mut self, action: &Action, now: Micros) -> Result<(), Problem> {
        let compensation = action.compensation_id.map(|id| self.number_of(action, id)).transpose()?;
        let whisker =
            action.whisker.map(u16::try_from).transpose().map_err(|_| refused(ActionProblem::UnknownWhisker))?;
        let subject = Subject { array: action.array.as_deref(), whisker, compensation };
        if action.kind == CALIBRATION {
            return self.change_calibration(action, now);
        }
        let request = actions::request(&action.kind, &action.parameters, subject);
        match request.map_err(|problem| format!("{}: {problem}", problem.word()))? {
            Request::Operator(asked) => self.operate(action, &asked, now),
            Request::Policy(change) => self.change_policy(action, &change, now),
        }
    }

    fn robot_of(&self, action: &Action) -> Result<Name, Problem> {
        let name = action.robot.as_deref().and_then(|name| Name::robot(name).ok());
        name.filter(|name| self.robots.contains_key(name))
            .ok_or_else(|| "UNKNOWN_ROBOT: there is no such robot in the fleet".to_owned())
    }

    /// A compensation's number on its robot; in the database the robot's is in front.
    fn number_of(&self, action: &Action, compensation_id: i64) -> Result<u32, Problem> {
        let robot_id = self.robots[&self.robot_of(action)?].robot_id;
        let number = compensation_id as u32;
        let is_its = super::record::wide_id(robot_id, number) == compensation_id;
        is_its.then_some(number).ok_or_else(|| refused(ActionProblem::NotProposed))
    }

    fn operate(&mut self, action: &Action, asked: &OperatorAction<'_>, now: Micros) -> Result<(), Problem> {
        let name = self.robot_of(action)?;
        match self.step(&name, now, &Event::Operator(asked), None) {
            Some(Outcome::Refused(problem)) => Err(refused(problem)),
            Some(Outcome::Taken | Outcome::Duplicate | Outcome::NotYet(_) | Outcome::OldBoot) | None => Ok(()),
        }
    }

    /// Another calibration of a model, in force from this transaction on; its whiskers are learned anew, at the lengths
    /// that are estimated now.
    fn change_calibration(&mut self, action: &Action, now: Micros) -> Result<(), Problem> {
        let malformed = |problem: String| format!("MALFORMED: {problem}");
        let told: Activation =
            serde_json::from_str(&action.parameters).map_err(|problem| malformed(problem.to_string()))?;
        let row = ActivationRow {
            fleet: self.fleet.to_string(),
            model: told.calibration.name.clone(),
            calibration_id: told.calibration_id,
            activated_us: wall_clock().0 as i64,
            activated_by: action.actor.clone(),
        };
        let name = told.calibration.name.clone();
        self.params = with_model(&self.params, &told.calibration).map_err(malformed)?;
        self.batch.records.push(Record::Activation(Box::new(row)));
        let concerned: Vec<(Name, String, u16)> = self
            .robots
            .iter()
            .flat_map(|(robot, known)| {
                let views = (0..known.robot.whisker_count()).filter_map(|index| known.robot.whisker(index));
                let its = views.filter(|view| view.sheet.model == name);
                its.map(|view| (robot.clone(), view.array.to_owned(), view.sheet.number)).collect::<Vec<_>>()
            })
            .collect();
        for (robot, array, whisker) in concerned {
            let asked = OperatorAction::Rebaseline(Place { array: &array, whisker });
            self.step(&robot, now, &Event::Operator(&asked), None);
        }
        Ok(())
    }

    /// Another policy for the whole fleet, in force from this transaction on.
    fn change_policy(&mut self, action: &Action, change: &PolicyChange, now: Micros) -> Result<(), Problem> {
        let in_force = self.policy_version;
        if change.expected_version != in_force {
            return Err(format!("VERSION: version {in_force} is in force, not {}", change.expected_version));
        }
        let policy = change.over(self.params.policy);
        self.params = Arc::new(Params { policy, ..(*self.params).clone() });
        self.policy_version += 1;
        self.batch.records.push(Record::Policy(Box::new(self.policy_row(action, &policy))));
        self.show_params();
        let names: Vec<Name> = self.robots.keys().cloned().collect();
        for name in names {
            self.step(&name, now, &Event::PolicyChanged, None);
        }
        Ok(())
    }

    fn policy_row(&self, action: &Action, policy: &PolicyParams) -> PolicyRow {
        PolicyRow {
            fleet: self.fleet.to_string(),
            version: self.policy_version,
            mode: policy.mode.word(),
            objective: policy.objective.word(),
            longer_for_shorter: policy.longer_for_shorter.word(),
            predicted_error_max: policy.predicted_error_max,
            own_role_cost: policy.own_role_cost,
            change_margin: policy.change_margin,
            changed_us: wall_clock().0 as i64,
            changed_by: action.actor.clone(),
            reason: action.reason.clone(),
            action_id: action.action_id,
        }
    }
}

/// Which calibration shall be in force.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Activation {
    calibration_id: i64,
    calibration: CalibrationFile,
}

/// The parameters with another calibration of a model, or with one model more.
fn with_model(params: &Params, file: &CalibrationFile) -> Result<Arc<Params>, String> {
    let formulation = params.models.first().map_or_else(Formulation::default, |(_, model)| model.formulation());
    let model = Model::new(file.geometry(), file.calibration(), formulation).map_err(|problem| problem.to_string())?;
    let mut params = params.clone();
    match params.models.iter_mut().find(|(name, _)| *name == file.name) {
        Some((_, known)) => *known = model,
        None => params.models.push((file.name.clone(), model)),
    }
    Ok(Arc::new(params))
}

/// The parameters with the calibrations that the fleet works with over the configuration's.
pub(crate) fn with_calibrations(params: Arc<Params>, active: &[ActiveCalibration]) -> Arc<Params> {
    active.iter().fold(params, |params, one| {
        let read = serde_json::from_str(&one.calibration).map_err(|problem| problem.to_string());
        read.and_then(|file| with_model(&params, &file)).unwrap_or_else(|problem| {
            error!(
                calibration = one.calibration_id,
                problem, "a calibration that cannot be used: the configuration's is taken"
            );
            params
        })
    })
}

fn refused(problem: ActionProblem) -> Problem {
    format!("{}: {problem}", problem.word())
}

/// The parameters with the policy that an operator has set over the configuration's.
pub(crate) fn with_policy(params: Arc<Params>, set: Option<&PolicyReading>) -> Arc<Params> {
    let Some(set) = set else { return params };
    let words = (
        actions::mode(&set.mode),
        actions::objective(&set.objective),
        actions::longer_for_shorter(&set.longer_for_shorter),
    );
    let (Some(mode), Some(objective), Some(longer_for_shorter)) = words else {
        error!(fleet = set.fleet, version = set.version, "a policy with unknown words: the configuration's is taken");
        return params;
    };
    let policy = PolicyParams {
        mode,
        objective,
        longer_for_shorter,
        predicted_error_max: set.predicted_error_max,
        own_role_cost: set.own_role_cost,
        change_margin: set.change_margin,
    };
    Arc::new(Params { policy, ..(*params).clone() })
}
