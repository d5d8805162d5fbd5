//! What operators ask: read, carried out in order, and answered in the transaction that has the effects.

use std::sync::Arc;

use tracing::{error, info, warn};
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Params};
use vibrissa_core::units::Micros;
use vibrissa_edge::actions::{self, ActionKind, PolicyChange, Request, Subject};
use vibrissa_edge::words::{Word, named};
use vibrissa_protocol::Name;

use super::{Engine, wall_clock};
use crate::store::actions::{Action, PolicyReading};
use crate::store::batch::{PolicyRow, Record};

/// Actions that are read at a time.
const ACTIONS_MAX: i64 = 100;

/// Why an action is refused: a word for programs, a colon, and a text for people.
type Problem = String;

impl Engine {
    /// Carries out what waits. A database that is away is not waited for here: what is asked stays asked.
    pub(super) async fn open_mail(&mut self, now: Micros) {
        let pending = match self.writer.pending(&self.lease, ACTIONS_MAX).await {
            Ok(pending) => pending,
            Err(problem) => {
                self.metrics.database_errors.inc();
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
            let kind = named(ActionKind::ALL, &action.kind).map_or("UNKNOWN", Word::word);
            self.metrics.actions.with_label_values(&[kind, state]).inc();
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

fn refused(problem: ActionProblem) -> Problem {
    format!("{}: {problem}", problem.word())
}

/// The parameters with the policy that an operator has set over the configuration's.
pub(super) fn with_policy(params: Arc<Params>, set: Option<&PolicyReading>) -> Arc<Params> {
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
