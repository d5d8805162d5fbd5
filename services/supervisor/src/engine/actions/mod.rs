//! Operators' actions: read, executed in order, and answered in the transaction that contains their effects. Those on
//! roll-outs are in `rollouts`.

mod rollouts;

use std::sync::Arc;

use tracing::info;
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Params, Place};
use vibrissa_core::units::Micros;
use vibrissa_edge::actions::{self, ActionKind, PolicyChange, RecordedKind, Request, Subject};
use vibrissa_edge::events::EventKind;
use vibrissa_edge::full_name::FullName;
use vibrissa_edge::ids::command_id;
use vibrissa_edge::words::{Word, named};
use vibrissa_protocol::{Name, plain};

use super::fleet_metrics;
use super::pipeline::Pipeline;
use super::quarantine::suspects::Suspects;
use super::rollout::{Order, Rollout};
use super::worker::workers::Workers;
use crate::events::{ActionPart, CalibrationPart, Parts, PolicyPart, event};
use crate::metrics::FleetMetrics;
use crate::params::with_model;
use crate::trace::TracedAction;
use vibrissa_edge::calibration_file::Activation;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::actions::Action;
use vibrissa_store::batch::{PolicyChanged, PolicyRow, Record};
use vibrissa_store::calibrations::ActivationRow;
use vibrissa_store::events::write::EventRow;

/// Limit of the actions read at a time.
pub(super) const ACTIONS_MAX: i64 = 100;

/// Why an action is refused: a word for programs, a colon, and a text for people.
pub(super) type Problem = String;

/// The parameters in force, which operators can change.
pub(super) struct ParamsInForce {
    pub(super) params: Arc<Params>,
    /// Version of the policy; 0 while it is the configuration's.
    pub(super) policy_version: i64,
}

/// Execution of the actions of a fleet.
pub(super) struct Execution<'a> {
    pub(super) fleet: &'a Name,
    pub(super) workers: &'a mut Workers,
    pub(super) in_force: &'a mut ParamsInForce,
    /// Roll-out that is running or paused.
    pub(super) rollout: &'a mut Option<Rollout>,
    pub(super) metrics: &'a FleetMetrics,
    /// Time for the core.
    pub(super) now: Micros,
}

impl Execution<'_> {
    /// Executes an action, and adds its answer to the open batches. An action for a suspect waits, because the database
    /// might reject its effects, until the robot is no longer a suspect, or until the action expires.
    pub(super) fn handle(&mut self, action: &Action, suspects: &Suspects, pipeline: &mut Pipeline) {
        let is_expired = wall_clock().0 as i64 >= action.expires_us;
        let robot = self.robot_of(action).ok();
        if !is_expired && robot.as_ref().is_some_and(|name| suspects.has(name)) {
            return;
        }
        let robot_id = robot.and_then(|name| self.workers.robot(&name)).map_or(0, |known| known.robot_id);
        self.workers.set_action(Some(&TracedAction::of(action)));
        let done = (!is_expired).then(|| self.carry_out(action));
        self.workers.set_action(None);
        self.answer(action, robot_id, done, pipeline);
    }

    /// Records the answer of an action; `None` for one that has expired.
    pub(super) fn answer(
        &mut self,
        action: &Action,
        robot_id: i64,
        done: Option<Result<(), Problem>>,
        pipeline: &mut Pipeline,
    ) {
        let (state, problem) = match done {
            None => ("EXPIRED", None),
            Some(Ok(())) => ("DONE", None),
            Some(Err(problem)) => ("REFUSED", Some(problem)),
        };
        let kind = match named::<ActionKind>(&action.kind) {
            Some(kind) => kind.word(),
            None => named::<RecordedKind>(&action.kind)
                .filter(|kind| RecordedKind::OF_ENGINE.contains(kind))
                .map_or("UNKNOWN", RecordedKind::word),
        };
        self.metrics.actions.count([kind, state]);
        info!(
            fleet = %self.fleet, subject = subject_of(self.fleet, action).map(display), action = action.action_id, kind,
            state, problem, actor = action.actor, "operator action handled"
        );
        let (action_id, done_us) = (action.action_id, wall_clock().0 as i64);
        let entry = answered(action_id, state, done_us);
        let entry = if robot_id == 0 { entry } else { entry.of_robot(robot_id) };
        self.workers.record(Record::Answer { action_id, robot_id, state, problem, done_us }, Some(entry));
        pipeline.answer(action_id);
    }

    /// Refuses an action whose row cannot be read. Otherwise it would wait for ever, and hold up others.
    pub(super) fn refuse_unreadable(&mut self, action_id: i64, pipeline: &mut Pipeline) {
        let problem = "UNREADABLE: the stored request is damaged; request the action again".to_owned();
        self.metrics.actions.count(["UNKNOWN", "REFUSED"]);
        let (state, problem, done_us) = ("REFUSED", Some(problem), wall_clock().0 as i64);
        let entry = answered(action_id, state, done_us);
        self.workers.record(Record::Answer { action_id, robot_id: 0, state, problem, done_us }, Some(entry));
        pipeline.answer(action_id);
    }

    /// Sets the parameters for all robots.
    pub(super) fn set_params(&mut self, params: Arc<Params>) {
        self.workers.set_params(&params);
        self.in_force.params = params;
    }

    fn carry_out(&mut self, action: &Action) -> Result<(), Problem> {
        let compensation = action.compensation_id.map(|id| self.number_of(action, id)).transpose()?;
        let whisker =
            action.whisker.map(u16::try_from).transpose().map_err(|_| refused(ActionProblem::UnknownWhisker))?;
        let subject = Subject { array: action.array.as_deref(), whisker, compensation };
        let recorded = named::<RecordedKind>(&action.kind).filter(|kind| RecordedKind::OF_ENGINE.contains(kind));
        if let Some(kind) = recorded {
            return self.carry_out_recorded(action, kind);
        }
        let request = actions::request(&action.kind, &action.parameters, subject);
        match request.map_err(|problem| format!("{}: {problem}", problem.word()))? {
            Request::Operator(operator_action) => self.operate(action, &operator_action),
            Request::Policy(change) => self.change_policy(action, &change),
        }
    }

    fn carry_out_recorded(&mut self, action: &Action, kind: RecordedKind) -> Result<(), Problem> {
        #[allow(clippy::wildcard_enum_match_arm, reason = "only the kinds of the engine come here")]
        match kind {
            RecordedKind::Calibration => self.change_calibration(action),
            RecordedKind::RolloutStart => self.start_rollout(action),
            RecordedKind::RolloutPause => self.order_rollout(action, Order::Pause),
            RecordedKind::RolloutResume => self.order_rollout(action, Order::Resume),
            RecordedKind::RolloutAdvance => self.order_rollout(action, Order::Advance),
            RecordedKind::RolloutBack => self.order_rollout(action, Order::RollBack),
            _ => Err(format!("UNKNOWN_KIND: {} needs no engine", kind.word())),
        }
    }

    /// Refuses a change of what a roll-out changes, or compares with.
    fn without_rollout(&self) -> Result<(), Problem> {
        match self.rollout {
            Some(_) => Err("ROLLOUT_OPEN: a roll-out compares robots: complete it or roll it back first".to_owned()),
            None => Ok(()),
        }
    }

    fn robot_of(&self, action: &Action) -> Result<Name, Problem> {
        let name = action.robot.as_deref().and_then(|name| Name::robot(name).ok());
        let name = name.filter(|name| self.workers.robot(name).is_some());
        let name = name.ok_or_else(|| "UNKNOWN_ROBOT: there is no such robot in the fleet".to_owned())?;
        match self.workers.robot(&name).is_some_and(|known| known.is_excluded) {
            true => Err("ROBOT_NOT_ALLOWED: the fleet's allow list excludes the robot".to_owned()),
            false => Ok(name),
        }
    }

    /// Number of a compensation on its robot. The id in the database combines it with the robot's id.
    fn number_of(&self, action: &Action, compensation_id: i64) -> Result<u32, Problem> {
        let name = self.robot_of(action)?;
        let robot_id = self.workers.robot(&name).map_or(0, |known| known.robot_id);
        let number = compensation_id as u32;
        let is_its = vibrissa_edge::ids::wide_id(robot_id, number) == compensation_id;
        is_its.then_some(number).ok_or_else(|| refused(ActionProblem::NotProposed))
    }

    fn operate(&mut self, action: &Action, operator_action: &OperatorAction<'_>) -> Result<(), Problem> {
        let name = self.robot_of(action)?;
        let outcome = self.workers.step(&name, self.now, &Event::Operator(operator_action));
        if let (OperatorAction::TouchTest(place), Some(Outcome::Taken)) = (operator_action, &outcome) {
            self.name_test(action.action_id, &name, *place);
        }
        match outcome {
            Some(Outcome::Refused(problem)) => Err(refused(problem)),
            Some(Outcome::Taken | Outcome::Duplicate | Outcome::NotYet(_) | Outcome::OldBoot | Outcome::BadTime)
            | None => Ok(()),
        }
    }

    /// Records the test that an action has requested; none if the request has to wait.
    fn name_test(&mut self, action_id: i64, name: &Name, place: Place<'_>) {
        let Some(known) = self.workers.robot(name) else { return };
        let Some(whisker) = known.robot.find(place.array, place.whisker) else { return };
        let Some((test, _)) = known.robot.tests_under_way().find(|(_, of)| *of == whisker) else { return };
        let (robot_id, test_id) = (known.robot_id, command_id(self.fleet, name, test));
        // The event of the answer tells of it.
        self.workers.record(Record::TestOfAction { action_id, robot_id, test_id }, None);
    }

    /// Puts another calibration of a model in force from this transaction on. The baselines of its whiskers are learned
    /// again, at the current estimates of length.
    fn change_calibration(&mut self, action: &Action) -> Result<(), Problem> {
        let malformed = |problem: String| format!("MALFORMED: {problem}");
        let activation: Activation =
            serde_json::from_str(&action.parameters).map_err(|problem| malformed(plain::data(&problem.to_string())))?;
        self.without_rollout()?;
        self.activate(&activation, &action.actor).map_err(malformed)?;
        self.relearn(&self.names(|_| true), &activation.calibration.name);
        Ok(())
    }

    /// Puts a calibration in force, without a step of the robots.
    pub(super) fn activate(&mut self, activation: &Activation, actor: &str) -> Result<(), String> {
        self.set_params(with_model(&self.in_force.params, &activation.calibration)?);
        let row = ActivationRow {
            fleet: self.fleet.to_string(),
            model: activation.calibration.name.clone(),
            calibration_id: activation.calibration_id,
            activated_us: wall_clock().0 as i64,
            activated_by: actor.to_owned(),
        };
        let part = CalibrationPart { calibration_id: row.calibration_id, model: row.model.clone() };
        let parts = Parts { calibration: Some(part), ..Parts::default() };
        let entry = event(EventKind::Calibration, row.activated_us, &parts);
        self.workers.record(Record::Activation(Box::new(row)), Some(entry));
        Ok(())
    }

    /// Puts another policy of the whole fleet in force from this transaction on.
    fn change_policy(&mut self, action: &Action, change: &PolicyChange) -> Result<(), Problem> {
        let in_force = self.in_force.policy_version;
        let policy = change.over(self.in_force.params.policy);
        if change.expected_version != in_force {
            return Err(format!("VERSION: version {in_force} is in force, not {}", change.expected_version));
        }
        self.without_rollout()?;
        self.set_policy(&policy, (&action.actor, action.reason.clone(), action.action_id));
        for name in self.names(|_| true) {
            self.workers.step(&name, self.now, &Event::PolicyChanged);
        }
        Ok(())
    }

    /// Puts a policy in force, without a step of the robots. An actor set it for a reason, by an action.
    pub(super) fn set_policy(
        &mut self,
        policy: &PolicyParams,
        (actor, reason, action_id): (&str, Option<String>, i64),
    ) {
        let version = self.in_force.policy_version + 1;
        self.set_params(Arc::new(Params { policy: *policy, ..(*self.in_force.params).clone() }));
        self.in_force.policy_version = version;
        fleet_metrics::show_params(self.metrics, &self.in_force.params, version);
        let changed = PolicyChanged {
            fleet: self.fleet.to_string(),
            version,
            changed_us: wall_clock().0 as i64,
            changed_by: actor.to_owned(),
            reason,
            action_id,
        };
        let parts = Parts { policy: Some(PolicyPart { version: changed.version }), ..Parts::default() };
        let entry = event(EventKind::Policy, changed.changed_us, &parts);
        self.workers.record(Record::Policy(Box::new(PolicyRow::new(policy, changed))), Some(entry));
    }
}

/// The event of an action's answer.
fn answered(action_id: i64, state: &'static str, done_us: i64) -> EventRow {
    let parts = Parts { action: Some(ActionPart { action_id, state }), ..Parts::default() };
    event(EventKind::Action, done_us, &parts)
}

/// Full name of the robot or whisker that an action is about.
fn subject_of<'a>(fleet: &'a Name, action: &'a Action) -> Option<FullName<'a>> {
    let robot = FullName::robot(fleet.as_str(), action.robot.as_deref()?);
    let number = action.whisker.and_then(|whisker| u16::try_from(whisker).ok());
    Some(match (&action.array, number) {
        (Some(array), Some(number)) => robot.whisker(array, number),
        (Some(_), None) | (None, _) => robot,
    })
}

fn refused(problem: ActionProblem) -> Problem {
    format!("{}: {problem}", problem.word())
}
