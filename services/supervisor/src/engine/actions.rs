//! Operators' actions: read, executed in order, and answered in the transaction that contains their effects.

use std::sync::Arc;

use serde::Deserialize;
use tokio::time::Instant;
use tracing::{info, warn};
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Params, Place};
use vibrissa_core::units::Micros;
use vibrissa_edge::actions::{self, ActionKind, CALIBRATION, PolicyChange, Request, Subject};
use vibrissa_edge::words::{Word, named};
use vibrissa_protocol::Name;

use super::Engine;
use super::commit::committer::LeaseLost;
use super::shard::{Known, Shard, shard_of};
use crate::calibration_file::CalibrationFile;
use crate::params::with_model;
use crate::trace::Asked;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::actions::Action;
use vibrissa_store::batch::{PolicyChanged, PolicyRow, Record};
use vibrissa_store::calibrations::ActivationRow;

/// Limit of the actions read at a time.
const ACTIONS_MAX: i64 = 100;

/// Why an action is refused: a word for programs, a colon, and a text for people.
type Problem = String;

impl Engine {
    /// Executes the pending actions. If the database is unreachable, this does not wait: the actions stay pending.
    ///
    /// The answers so far are committed first, because actions without a committed answer would be read again.
    pub(super) async fn open_mail(&mut self, now: Micros) -> Result<(), LeaseLost> {
        self.settle().await?;
        let Some(committer) = self.committer.as_mut().filter(|_| self.answered.is_empty()) else { return Ok(()) };
        let pending = match committer.writer.pending(&self.lease, ACTIONS_MAX).await {
            Ok(pending) => pending,
            Err(problem) => {
                self.program.database_failed();
                warn!(%problem, fleet = %self.fleet, "cannot read operator actions, retrying");
                return Ok(());
            }
        };
        if pending.len() as i64 == ACTIONS_MAX {
            self.bell.notify_one();
        }
        for action in pending {
            let is_expired = wall_clock().0 as i64 >= action.expires_us;
            let robot = self.robot_of(&action).ok();
            if !is_expired && robot.as_ref().is_some_and(|name| self.suspects.contains_key(name)) {
                // The database might reject its effects: the action waits until the robot is no longer a suspect, or
                // until it expires.
                continue;
            }
            let robot_id = robot.and_then(|name| self.known(&name)).map_or(0, |known| known.robot_id);
            self.asked(Some(&action));
            let (state, problem) = match (!is_expired).then(|| self.carry_out(&action, now)) {
                None => ("EXPIRED", None),
                Some(Ok(())) => ("DONE", None),
                Some(Err(problem)) => ("REFUSED", Some(problem)),
            };
            self.asked(None);
            let kind = match named::<ActionKind>(&action.kind) {
                Some(kind) => kind.word(),
                None if action.kind == CALIBRATION => CALIBRATION,
                None => "UNKNOWN",
            };
            self.metrics.actions.count([kind, state]);
            info!(
                fleet = %self.fleet, action = action.action_id, kind, state, problem, actor = action.actor,
                "operator action handled"
            );
            let (action_id, done_us) = (action.action_id, wall_clock().0 as i64);
            self.record(Record::Answer { action_id, robot_id, state, problem, done_us });
            self.answered.push(action_id);
            self.rounds.due_by(Instant::now());
        }
        self.gathered(0);
        Ok(())
    }

    /// Sets the action in execution, which the traces of its effects name.
    fn asked(&mut self, action: Option<&Action>) {
        for lives in self.shards.iter_mut().filter_map(|shard| shard.gathering.lives.as_mut()) {
            lives.asked(action.map(Asked::of));
        }
    }

    /// Adds a row that belongs to no robot, after the rows of all shards so far.
    pub(super) fn record(&mut self, record: Record) {
        if let Some(last) = self.shards.last_mut() {
            last.gathering.batch.records.push(record);
        }
    }

    fn step(&mut self, name: &Name, now: Micros, event: &Event<'_>) -> Option<Outcome> {
        let at = shard_of(name, self.shards.len());
        let Shard { robots, gathering, .. } = &mut self.shards[at];
        Some(gathering.step(robots.get_mut(name)?, now, event, None))
    }

    fn known(&self, name: &Name) -> Option<&Known> {
        self.shards[shard_of(name, self.shards.len())].robots.get(name)
    }

    /// Sets the parameters for all robots.
    fn set_params(&mut self, params: Arc<Params>) {
        for shard in &mut self.shards {
            shard.gathering.params = params.clone();
        }
        self.params = params;
    }

    fn names(&self) -> Vec<Name> {
        self.shards.iter().flat_map(|shard| shard.robots.keys().cloned()).collect()
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
        name.filter(|name| self.known(name).is_some())
            .ok_or_else(|| "UNKNOWN_ROBOT: there is no such robot in the fleet".to_owned())
    }

    /// Number of a compensation on its robot. The id in the database combines it with the robot's id.
    fn number_of(&self, action: &Action, compensation_id: i64) -> Result<u32, Problem> {
        let name = self.robot_of(action)?;
        let robot_id = self.known(&name).map_or(0, |known| known.robot_id);
        let number = compensation_id as u32;
        let is_its = vibrissa_edge::ids::wide_id(robot_id, number) == compensation_id;
        is_its.then_some(number).ok_or_else(|| refused(ActionProblem::NotProposed))
    }

    fn operate(&mut self, action: &Action, asked: &OperatorAction<'_>, now: Micros) -> Result<(), Problem> {
        let name = self.robot_of(action)?;
        match self.step(&name, now, &Event::Operator(asked)) {
            Some(Outcome::Refused(problem)) => Err(refused(problem)),
            Some(Outcome::Taken | Outcome::Duplicate | Outcome::NotYet(_) | Outcome::OldBoot | Outcome::BadTime)
            | None => Ok(()),
        }
    }

    /// Puts another calibration of a model in force from this transaction on. The baselines of its whiskers are learned
    /// again, at the current estimates of length.
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
        self.set_params(with_model(&self.params, &told.calibration).map_err(malformed)?);
        self.record(Record::Activation(Box::new(row)));
        let concerned: Vec<(Name, String, u16)> = self
            .shards
            .iter()
            .flat_map(|shard| &shard.robots)
            .flat_map(|(robot, known)| {
                let views = (0..known.robot.whisker_count()).filter_map(|index| known.robot.whisker(index));
                let its = views.filter(|view| *view.sheet.model == name);
                its.map(|view| (robot.clone(), view.array.to_owned(), view.sheet.number)).collect::<Vec<_>>()
            })
            .collect();
        for (robot, array, whisker) in concerned {
            let asked = OperatorAction::Rebaseline(Place { array: &array, whisker });
            self.step(&robot, now, &Event::Operator(&asked));
        }
        Ok(())
    }

    /// Puts another policy of the whole fleet in force from this transaction on.
    fn change_policy(&mut self, action: &Action, change: &PolicyChange, now: Micros) -> Result<(), Problem> {
        let in_force = self.policy_version;
        if change.expected_version != in_force {
            return Err(format!("VERSION: version {in_force} is in force, not {}", change.expected_version));
        }
        let policy = change.over(self.params.policy);
        self.set_params(Arc::new(Params { policy, ..(*self.params).clone() }));
        self.policy_version += 1;
        self.record(Record::Policy(Box::new(self.policy_row(action, &policy))));
        self.show_params();
        for name in self.names() {
            self.step(&name, now, &Event::PolicyChanged);
        }
        Ok(())
    }

    fn policy_row(&self, action: &Action, policy: &PolicyParams) -> PolicyRow {
        let changed = PolicyChanged {
            fleet: self.fleet.to_string(),
            version: self.policy_version,
            changed_us: wall_clock().0 as i64,
            changed_by: action.actor.clone(),
            reason: action.reason.clone(),
            action_id: action.action_id,
        };
        PolicyRow::new(policy, changed)
    }
}

/// Parameters of an action that activates a calibration.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Activation {
    calibration_id: i64,
    calibration: CalibrationFile,
}

fn refused(problem: ActionProblem) -> Problem {
    format!("{}: {problem}", problem.word())
}
