//! The traces of a fleet's setpoints: each begins with the contact that raised the suspicion, or with an operator's
//! action, and ends with the last answer.
//!
//! Only committed spans are exported. The supervisor that sees the end of a trace exports its root span, which covers
//! the whole trace. If a fleet changes its owner, the next owner does so: the identifiers of trace and root span follow
//! from the setpoint's.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, SystemTime};

use opentelemetry::KeyValue;
use opentelemetry::trace::{SpanKind, Status};
use uuid::Uuid;
use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::{Command, CommandState, Condition, Effect, WhiskerIndex};
use vibrissa_core::units::Micros;
use vibrissa_edge::words::Word;
use vibrissa_protocol::{Name, RobotTopic};

use super::Traces;
use super::content::{self, Step, TracedAction, is_final, known_pressure};
use super::span::{Draft, SpanIds, now, time};
use crate::ending::Ending;
use vibrissa_edge::ids::command_uuid;
use vibrissa_edge::ids::compensation_uuid;
use vibrissa_edge::ids::wide_id;

/// Limit of the setpoints under way that are traced at a time, and of the remembered suspicions.
const OPEN_MAX: usize = 4096;

/// A whisker by the names of its robot and array and its number, which stay valid after a layout change.
type Whisker = (Name, String, u16);

/// The open traces of a fleet.
pub(crate) struct OpenTraces {
    traces: Traces,
    fleet: Name,
    open: BTreeMap<Uuid, OpenTrace>,
    /// Number of steps that have led to spans.
    steps: u64,
    /// The spans that raised the suspicions under review, each with the number of its step.
    suspicions: BTreeMap<Whisker, (u64, Draft)>,
    /// The operator's action in execution.
    action: Option<TracedAction>,
    pending: PendingSpans,
}

/// Spans that may be exported after a commit.
#[derive(Default)]
pub(crate) struct PendingSpans {
    /// Spans and their places.
    spans: Vec<(Draft, SpanIds)>,
    /// The traces that they belong to.
    touched: BTreeSet<Uuid>,
    ended: Vec<Uuid>,
    /// Setpoints among the publications.
    sending: Vec<Uuid>,
}

/// An open trace.
struct OpenTrace {
    name: String,
    robot: Name,
    began: SystemTime,
    attributes: Vec<KeyValue>,
    status: Status,
    /// Whether its first span is committed.
    is_committed: bool,
}

impl OpenTraces {
    pub(crate) fn new(traces: Traces, fleet: Name) -> Self {
        Self {
            traces,
            fleet,
            open: BTreeMap::new(),
            steps: 0,
            suspicions: BTreeMap::new(),
            action: None,
            pending: PendingSpans::default(),
        }
    }

    /// Continues the traces of a robot's setpoints that another supervisor, or an earlier start, has sent.
    pub(crate) fn take_up(&mut self, name: &Name, robot_id: i64, robot: &Robot) {
        for command in robot.commands_under_way() {
            let id = command_uuid(&self.fleet, name, command.key);
            let trace = self.trace(name, robot, robot_id, command, id);
            if self.begin(id, OpenTrace { is_committed: true, ..trace }) {
                self.moment(id, "take up", None);
            }
        }
    }

    /// Sets the operator's action in execution; `None` after it.
    pub(crate) fn set_action(&mut self, action: Option<TracedAction>) {
        self.action = action;
    }

    /// Adds the spans of a step of the core.
    pub(crate) fn stepped(&mut self, step: &Step<'_>) {
        self.steps += 1;
        let draft = content::processing(step, self.action.as_ref());
        let mut decided = BTreeMap::new();
        for effect in step.effects {
            if let Effect::Decided(decision) = effect {
                decided.insert(decision.compensation, decision.target);
            } else if let Effect::Condition { whisker, to, .. } = effect {
                self.suspect(step, *whisker, *to, &draft);
            }
        }
        for effect in step.effects {
            if let Effect::Command(command) = effect {
                let target = command.compensation.and_then(|number| decided.remove(&number));
                self.commanded(step, command, target, &draft);
            } else if let Effect::CommandState { command, state, rejection, pressure, .. } = effect {
                let mut draft = draft.clone().with("vibrissa.setpoint_state", state.word());
                draft.attributes.extend(known_pressure(*pressure));
                let error = rejection.map(Word::word);
                self.answered(command_uuid(&self.fleet, step.name, *command), *state, error, draft);
            }
        }
        for (number, target) in decided {
            self.decided(step, number, target, &draft);
        }
        for effect in step.effects {
            if let Effect::Trim(trim) = effect {
                whisker(step, trim.whisker).map(|whisker| self.suspicions.remove(&whisker));
            }
        }
    }

    /// Remembers the span that raised a suspicion, until the suspicion is dismissed or a trim is reported.
    fn suspect(&mut self, step: &Step<'_>, index: WhiskerIndex, to: Condition, draft: &Draft) {
        let Some(whisker) = whisker(step, index) else { return };
        match to {
            Condition::Suspected if self.suspicions.len() < OPEN_MAX => {
                self.suspicions.insert(whisker, (self.steps, draft.clone()));
            }
            Condition::Suspected => {}
            Condition::Learning | Condition::Healthy => {
                self.suspicions.remove(&whisker);
            }
            // A trim may follow, once the length is estimated.
            Condition::Trimmed | Condition::Eroding | Condition::SensitivityLoss => {}
        }
    }

    /// Begins the trace of a setpoint, with the suspicion that led to it.
    fn commanded(&mut self, step: &Step<'_>, command: &Command, target: Option<WhiskerIndex>, draft: &Draft) {
        let id = command_uuid(&self.fleet, step.name, command.key);
        let mut trace = self.trace(step.name, step.robot, step.robot_id, command, id);
        if let Some(action) = &self.action {
            trace.began = action.requested.min(trace.began);
            trace.attributes.extend(action.attributes());
        }
        self.begin_with_suspicion(step, id, trace, target, draft);
    }

    /// Makes a complete trace of a decision without a setpoint: no compensator is available, or an operator must
    /// approve it.
    fn decided(&mut self, step: &Step<'_>, number: u32, target: WhiskerIndex, draft: &Draft) {
        let id = compensation_uuid(&self.fleet, step.name, number);
        let mut attributes = content::robot_of(&self.fleet, step.name).to_vec();
        attributes.extend(content::whisker_of(step.robot, target));
        attributes.push(KeyValue::new("vibrissa.compensation_id", wide_id(step.robot_id, number)));
        let name = "decision".to_owned();
        let trace = OpenTrace {
            name,
            robot: step.name.clone(),
            began: draft.start,
            attributes,
            status: Status::Unset,
            is_committed: false,
        };
        self.begin_with_suspicion(step, id, trace, Some(target), draft);
        self.pending.ended.push(id);
    }

    fn begin_with_suspicion(
        &mut self,
        step: &Step<'_>,
        id: Uuid,
        mut trace: OpenTrace,
        target: Option<WhiskerIndex>,
        draft: &Draft,
    ) {
        let suspicion = target.and_then(|target| self.suspicions.get(&whisker(step, target)?)).cloned();
        // The same message may have raised the suspicion and confirmed it.
        let suspicion = suspicion.filter(|(number, _)| *number < self.steps).map(|(_, before)| before);
        if let Some(before) = &suspicion {
            trace.began = trace.began.min(before.start);
        }
        if self.begin(id, trace) {
            for draft in suspicion.into_iter().chain([draft.clone()]) {
                self.pending.spans.push((draft, SpanIds::root(id).child()));
            }
            self.pending.touched.insert(id);
        }
    }

    /// Adds the span of a setpoint's state change, and ends the trace at a final state.
    fn answered(&mut self, id: Uuid, state: CommandState, error: Option<&'static str>, draft: Draft) {
        let Some(trace) = self.open.get_mut(&id) else { return };
        self.pending.spans.push((draft, SpanIds::root(id).child()));
        self.pending.touched.insert(id);
        if is_final(state) {
            trace.attributes.push(KeyValue::new("vibrissa.setpoint_state", state.word()));
            trace.attributes.extend(error.map(|error| KeyValue::new("error.type", error)));
            if !matches!(state, CommandState::Applied | CommandState::Superseded) {
                trace.status = Status::error(state.word());
            }
            self.pending.ended.push(id);
        }
    }

    /// Takes the spans of the steps so far, which belong to one transaction.
    pub(crate) fn seal(&mut self) -> PendingSpans {
        std::mem::take(&mut self.pending)
    }

    /// Exports the spans of a transaction after its commit, which took `took`.
    pub(crate) fn committed(&mut self, pending: &mut PendingSpans, took: Duration) {
        let done = now();
        for (draft, ids) in pending.spans.drain(..) {
            self.traces.emit(draft, ids);
        }
        for id in std::mem::take(&mut pending.touched) {
            if let Some(trace) = self.open.get_mut(&id) {
                trace.is_committed = true;
            }
            let period = (done.checked_sub(took).unwrap_or(done), done);
            let draft = Draft::new("commit", SpanKind::Client, period)
                .with("db.system.name", self.traces.0.database)
                .with("db.operation.name", "COMMIT");
            self.traces.emit(draft, SpanIds::root(id).child());
        }
        for id in std::mem::take(&mut pending.ended) {
            let Some(trace) = self.open.remove(&id) else { continue };
            let mut root = Draft::new(trace.name, SpanKind::Internal, (trace.began, done));
            root.attributes = trace.attributes;
            root.status = trace.status;
            self.traces.emit(root, SpanIds::root(id));
        }
    }

    /// Notes that a setpoint is among the publications.
    pub(crate) fn sending(&mut self, name: &Name, command: &Command) {
        self.pending.sending.push(command_uuid(&self.fleet, name, command.key));
    }

    /// Adds the spans of the publications, handed to the connection `at` this time; `all` is false if some could not be.
    pub(crate) fn published(&mut self, pending: PendingSpans, at: Micros, all: bool) {
        let now = time(at);
        for id in pending.sending {
            let Some(trace) = self.open.get(&id) else { continue };
            let draft = Draft::new("send setpoint", SpanKind::Producer, (now, now));
            let mut draft = content::messaging(draft, RobotTopic::Setpoint, &self.fleet, &trace.robot, "publish");
            if !all {
                draft.status = Status::error("not all messages were published; unanswered setpoints are sent again");
            }
            self.traces.emit(draft, SpanIds::root(id).child());
        }
    }

    /// Ends supervision of the fleet: the open traces are left to the next owner.
    pub(crate) fn end(&mut self, ending: Ending) {
        let word = match ending {
            Ending::Stopped => "STOPPED",
            Ending::LeaseLost => "LEASE_LOST",
        };
        for (id, _) in std::mem::take(&mut self.open).into_iter().filter(|(_, trace)| trace.is_committed) {
            self.moment(id, "hand over", Some(word));
        }
    }

    /// A setpoint's trace. Every supervisor that knows the setpoint derives the same one.
    fn trace(&self, name: &Name, robot: &Robot, robot_id: i64, command: &Command, id: Uuid) -> OpenTrace {
        let mut attributes = content::robot_of(&self.fleet, name).to_vec();
        attributes.extend(content::setpoint(robot, robot_id, command, id.to_string()));
        OpenTrace {
            name: format!("setpoint {}", command.reason.word()),
            robot: name.clone(),
            began: time(command.issued),
            attributes,
            status: Status::Unset,
            is_committed: false,
        }
    }

    /// Opens a trace. False if too many traces are open.
    fn begin(&mut self, id: Uuid, trace: OpenTrace) -> bool {
        let is_followed = self.open.len() < OPEN_MAX;
        if is_followed {
            self.open.insert(id, trace);
        } else {
            self.traces.drop_one();
        }
        is_followed
    }

    fn moment(&self, id: Uuid, name: &'static str, ending: Option<&'static str>) {
        let at = now();
        let mut draft = Draft::new(name, SpanKind::Internal, (at, at));
        draft.attributes.extend(ending.map(|ending| KeyValue::new("vibrissa.ending", ending)));
        self.traces.emit(draft, SpanIds::root(id).child());
    }
}

/// A whisker by its names; `None` if the robot has no such whisker.
fn whisker(step: &Step<'_>, index: WhiskerIndex) -> Option<Whisker> {
    let view = step.robot.whisker(index)?;
    Some((step.name.clone(), view.array.to_owned(), view.sheet.number))
}
