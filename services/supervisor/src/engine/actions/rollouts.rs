//! Roll-outs as actions carry them out: robots get a change, stage by stage, or it is taken back.

use tracing::{error, info};
use vibrissa_core::robot::{Event, OperatorAction, Place};
use vibrissa_core::rollout::{Look, Stage, Verdict, limit, place};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::actions::Action;
use vibrissa_store::batch::Record;
use vibrissa_store::events::write::EventRow;
use vibrissa_store::rollouts::{Compared, RolloutChange, RolloutEvent, RolloutRow};

use super::{Execution, Problem};
use crate::engine::rollout::change::Change;
use crate::engine::rollout::compare::{Comparison, summary};
use crate::engine::rollout::{Order, Rollout, malformed};
use crate::events::{Parts, RolloutPart, event};

/// Actor of events that follow from the errors alone.
const SUPERVISOR: &str = "supervisor";

/// Parameters of the action that begins a roll-out.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Start {
    kind: String,
    change: serde_json::Value,
    level: f64,
    robots: u32,
}

/// Parameters of the other actions on a roll-out.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Which {
    rollout_id: i64,
}

impl Execution<'_> {
    /// Begins a roll-out with its first stage.
    pub(super) fn start_rollout(&mut self, action: &Action) -> Result<(), Problem> {
        if let Some(open) = self.rollout {
            return Err(format!("ROLLOUT_OPEN: roll-out {} has not ended yet", open.row.rollout_id));
        }
        let start: Start = serde_json::from_str(&action.parameters).map_err(|problem| malformed(&problem))?;
        let expected = start.change.get("expected_version").and_then(serde_json::Value::as_i64);
        if expected.is_some_and(|expected| expected != self.in_force.policy_version) {
            let in_force = self.in_force.policy_version;
            return Err(format!("VERSION: version {in_force} is in force, not {}", expected.unwrap_or_default()));
        }
        let change_json = start.change.to_string();
        let change = Change::read(&start.kind, &change_json, &self.in_force.params)?;
        let params = change.over(&self.in_force.params)?;
        let now_us = wall_clock().0 as i64;
        let row = RolloutRow {
            rollout_id: action.action_id,
            fleet: self.fleet.to_string(),
            kind: start.kind,
            change: change_json,
            state: "RUNNING".to_owned(),
            stage: Stage::Few.word().to_owned(),
            place_max: 0,
            level: start.level,
            robots: i64::from(start.robots),
            looks: 0,
            compared: Compared::default(),
            started_us: now_us,
            stage_us: now_us,
            updated_us: now_us,
            started_by: action.actor.clone(),
            reason: action.reason.clone(),
        };
        *self.rollout = Some(Rollout { row, change, params });
        let reason = action.reason.clone().unwrap_or_else(|| "an engineer began it".to_owned());
        self.enter(Stage::Few, None, ("STARTED", &action.actor, reason));
        Ok(())
    }

    /// Carries out an order of a person.
    pub(super) fn order_rollout(&mut self, action: &Action, order: Order) -> Result<(), Problem> {
        let Which { rollout_id } = serde_json::from_str(&action.parameters).map_err(|problem| malformed(&problem))?;
        let Some(open) = self.rollout.as_mut().filter(|open| open.row.rollout_id == rollout_id) else {
            return Err(format!("ROLLOUT_ENDED: roll-out {rollout_id} has ended, or never began"));
        };
        let (state, stage) = (open.row.state.clone(), open.stage());
        let actor = action.actor.as_str();
        let why = action.reason.clone().unwrap_or_else(|| "an engineer decided so".to_owned());
        match (order, state.as_str()) {
            (Order::Pause, "RUNNING") => self.note(("PAUSED", actor, why), "PAUSED"),
            (Order::Resume, "PAUSED") => self.note(("RESUMED", actor, why), "RUNNING"),
            (Order::Pause, _) => return Err("ROLLOUT_PAUSED: it is paused already".to_owned()),
            (Order::Resume, _) => return Err("ROLLOUT_RUNNING: it is running".to_owned()),
            (Order::Advance, _) => self.enter(stage.next(), None, ("ADVANCED", actor, why)),
            (Order::RollBack, _) => self.roll_back(("ROLLED_BACK", actor, why)),
        }
        Ok(())
    }

    /// After a comparison, waits, goes on or rolls back.
    pub(in crate::engine) fn review_rollout(&mut self, Comparison { verdict, is_new }: Comparison) {
        let Some(open) = self.rollout.as_mut() else { return };
        let look = match verdict {
            Verdict::Wait => {
                if is_new {
                    open.row.updated_us = wall_clock().0 as i64;
                    let row = open.row.clone();
                    let event = event_of(&row);
                    self.workers.record(Record::Rollout(Box::new(RolloutChange { row, event: None })), Some(event));
                }
                return;
            }
            Verdict::Continue(look) | Verdict::Advance(look) | Verdict::RollBack(look) => look,
        };
        open.row.looks = i64::from(look.looks);
        open.row.compared.probability = Some(look.probability);
        let (stage, note) = (open.stage(), summary(look, open.rules(), &open.row.compared));
        match verdict {
            Verdict::Wait => {}
            Verdict::Continue(_) => self.note(("LOOKED", SUPERVISOR, note), "RUNNING"),
            Verdict::Advance(_) => self.enter(stage.next(), Some(look), ("ADVANCED", SUPERVISOR, note)),
            Verdict::RollBack(_) => self.roll_back(("ROLLED_BACK", SUPERVISOR, note)),
        }
    }

    /// Notes a state in which no robot changes.
    fn note(&mut self, (event, actor, detail): (&'static str, &str, String), state: &str) {
        let Some(open) = self.rollout.as_mut() else { return };
        open.row.state = state.to_owned();
        open.row.updated_us = wall_clock().0 as i64;
        self.metrics.rollouts.count([event]);
        info!(fleet = %self.fleet, rollout = open.row.rollout_id, event, actor, detail, "roll-out");
        let event = RolloutEvent { event: event.to_owned(), actor: actor.to_owned(), detail };
        let change = RolloutChange { row: open.row.clone(), event: Some(event) };
        let event = event_of(&change.row);
        self.workers.record(Record::Rollout(Box::new(change)), Some(event));
    }

    /// Enters a stage: more robots change. In the last one the change comes into force, and the roll-out ends.
    fn enter(&mut self, stage: Stage, look: Option<Look>, event: (&'static str, &str, String)) {
        let Some(open) = self.rollout.as_mut() else { return };
        let before = (event.0 != "STARTED").then(|| open.trial());
        let seed = open.row.rollout_id as u64;
        let mut places: Vec<u32> = self.workers.robots().map(|known| place(seed, known.name.as_str())).collect();
        let last = before.as_ref().map_or(0, |trial| trial.place_max);
        open.row.place_max = i64::from(limit(stage, &mut places, last));
        open.row.stage = stage.word().to_owned();
        open.row.stage_us = wall_clock().0 as i64;
        open.row.looks = 0;
        open.row.compared = Compared { probability: look.map(|look| look.probability), ..Compared::default() };
        let (trial, change, row) = (open.trial(), open.change.clone(), open.row.clone());
        let newly: Vec<Name> = self.names(|name| trial.has(name) && !before.as_ref().is_some_and(|one| one.has(name)));
        if stage == Stage::All {
            let (_, actor, detail) = event;
            self.note(("COMPLETED", actor, detail), "COMPLETED");
            *self.rollout = None;
            self.workers.set_trial(None);
            match &change {
                Change::Policy(policy) => {
                    self.set_policy(policy, (&row.started_by, row.reason.clone(), row.rollout_id))
                }
                Change::Calibration(activation) => {
                    if let Err(problem) = self.activate(activation, &row.started_by) {
                        error!(fleet = %self.fleet, rollout = row.rollout_id, problem, "cannot activate a calibration");
                    }
                }
            }
        } else {
            self.note(event, "RUNNING");
            self.workers.set_trial(Some(&trial));
        }
        self.apply(&change, &newly);
    }

    /// Takes the change back from all changed robots. The roll-out ends.
    fn roll_back(&mut self, event: (&'static str, &str, String)) {
        let Some(open) = self.rollout.as_ref() else { return };
        let (trial, change) = (open.trial(), open.change.clone());
        self.note(event, "ROLLED_BACK");
        *self.rollout = None;
        self.workers.set_trial(None);
        let changed = self.names(|name| trial.has(name));
        self.apply(&change, &changed);
    }

    /// Robots of these names, also those that the allow list excludes: they may come back.
    pub(super) fn names(&self, is_wanted: impl Fn(&Name) -> bool) -> Vec<Name> {
        self.workers.robots().map(|known| known.name.clone()).filter(|name| is_wanted(name)).collect()
    }

    /// Tells robots that their parameters have changed.
    fn apply(&mut self, change: &Change, robots: &[Name]) {
        match change {
            Change::Policy(_) => {
                for name in robots {
                    self.workers.step(name, self.now, &Event::PolicyChanged);
                }
            }
            Change::Calibration(activation) => self.relearn(robots, &activation.calibration.name),
        }
    }

    /// Relearns the baselines of the whiskers of a model.
    pub(super) fn relearn(&mut self, robots: &[Name], model: &str) {
        for name in robots {
            let Some(known) = self.workers.robot(name) else { continue };
            let views = (0..known.robot.whisker_count()).filter_map(|index| known.robot.whisker(index));
            let its = views.filter(|view| *view.sheet.model == model);
            let whiskers: Vec<(String, u16)> = its.map(|view| (view.array.to_owned(), view.sheet.number)).collect();
            for (array, whisker) in whiskers {
                let operator_action = OperatorAction::Rebaseline(Place { array: &array, whisker });
                self.workers.step(name, self.now, &Event::Operator(&operator_action));
            }
        }
    }
}

/// The event of a roll-out's new state.
fn event_of(row: &RolloutRow) -> EventRow {
    let part = RolloutPart { rollout_id: row.rollout_id, state: row.state.clone(), stage: row.stage.clone() };
    event(EventKind::Rollout, row.updated_us, &Parts { rollout: Some(part), ..Parts::default() })
}
