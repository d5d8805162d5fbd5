//! The traces of a fleet's setpoints: each begins with the contact that raised the suspicion, or with what an operator asked
//! for, and ends with the last answer.
//!
//! Nothing is told that is not committed. The root, which spans the whole, is told by the supervisor that sees the end;
//! one that gives the fleet away leaves it to the next, which knows the same name.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, SystemTime};

use opentelemetry::KeyValue;
use opentelemetry::trace::{SpanKind, Status};
use uuid::Uuid;
use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::{Command, CommandState, Condition, Effect, WhiskerIndex};
use vibrissa_edge::words::Word;
use vibrissa_protocol::{Name, RobotTopic};

use super::Traces;
use super::span::{Draft, Place, time};
use super::story::{self, Asked, Step, is_final, known_pressure};
use crate::ending::Ending;
use vibrissa_edge::ids::command_uuid;
use vibrissa_edge::ids::compensation_uuid;
use vibrissa_edge::ids::wide_id;

/// Setpoints under way that are followed at a time, and suspicions that are remembered.
const OPEN_MAX: usize = 4096;

/// A whisker by its names, which outlast a new layout.
type Whisker = (Name, String, u16);

/// The traces of a fleet that are not over.
pub(crate) struct Lives {
    traces: Traces,
    fleet: Name,
    open: BTreeMap<Uuid, Life>,
    /// Steps of which there was something to tell.
    steps: u64,
    /// What raised the suspicions that are being looked into, each with the number of its step.
    suspicions: BTreeMap<Whisker, (u64, Draft)>,
    /// What is being carried out.
    asked: Option<Asked>,
    untold: Untold,
}

/// What a commit makes true.
#[derive(Default)]
pub(crate) struct Untold {
    /// Spans.
    spans: Vec<(Draft, Place)>,
    /// The lives that they belong to.
    touched: BTreeSet<Uuid>,
    over: Vec<Uuid>,
    /// Setpoints among the publications.
    sending: Vec<Uuid>,
}

/// A trace that is not over.
struct Life {
    name: String,
    robot: Name,
    began: SystemTime,
    attributes: Vec<KeyValue>,
    status: Status,
    /// Whether what it begins with is committed.
    is_committed: bool,
}

impl Lives {
    pub(crate) fn new(traces: Traces, fleet: Name) -> Self {
        Self {
            traces,
            fleet,
            open: BTreeMap::new(),
            steps: 0,
            suspicions: BTreeMap::new(),
            asked: None,
            untold: Untold::default(),
        }
    }

    /// Goes on with the setpoints of a robot that another supervisor, or an earlier start, has sent.
    pub(crate) fn take_up(&mut self, name: &Name, robot_id: i64, robot: &Robot) {
        for command in robot.commands_under_way() {
            let id = command_uuid(&self.fleet, name, command.key);
            let life = self.life(name, robot, robot_id, command, id);
            if self.begin(id, Life { is_committed: true, ..life }) {
                self.moment(id, "take up", None);
            }
        }
    }

    /// What is carried out from now on; nothing after it.
    pub(crate) fn asked(&mut self, asked: Option<Asked>) {
        self.asked = asked;
    }

    /// The core has taken a step of which there is something to tell.
    pub(crate) fn stepped(&mut self, step: &Step<'_>) {
        self.steps += 1;
        let draft = story::processing(step, self.asked.as_ref());
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
            } else if let Effect::CommandState { command, state, rejection, pressure } = effect {
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

    /// Remembers what has raised a suspicion, until it is dismissed or a trim is called.
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
            // A trim may follow: the length is looked at first.
            Condition::Trimmed | Condition::Eroding | Condition::SensitivityLoss => {}
        }
    }

    /// A setpoint was decided: its trace begins, with what came before.
    fn commanded(&mut self, step: &Step<'_>, command: &Command, target: Option<WhiskerIndex>, draft: &Draft) {
        let id = command_uuid(&self.fleet, step.name, command.key);
        let mut life = self.life(step.name, step.robot, step.robot_id, command, id);
        if let Some(asked) = &self.asked {
            life.began = asked.asked.min(life.began);
            life.attributes.extend(asked.attributes());
        }
        self.tell_beginning(step, id, life, target, draft);
    }

    /// A decision from which no setpoint follows yet: nobody can serve, or somebody must approve. Its trace is over.
    fn decided(&mut self, step: &Step<'_>, number: u32, target: WhiskerIndex, draft: &Draft) {
        let id = compensation_uuid(&self.fleet, step.name, number);
        let mut attributes = story::robot_of(&self.fleet, step.name).to_vec();
        attributes.extend(story::whisker_of(step.robot, target));
        attributes.push(KeyValue::new("vibrissa.compensation_id", wide_id(step.robot_id, number)));
        let name = "decision".to_owned();
        let life = Life {
            name,
            robot: step.name.clone(),
            began: draft.start,
            attributes,
            status: Status::Unset,
            is_committed: false,
        };
        self.tell_beginning(step, id, life, Some(target), draft);
        self.untold.over.push(id);
    }

    fn tell_beginning(
        &mut self,
        step: &Step<'_>,
        id: Uuid,
        mut life: Life,
        target: Option<WhiskerIndex>,
        draft: &Draft,
    ) {
        let suspicion = target.and_then(|target| self.suspicions.get(&whisker(step, target)?)).cloned();
        // The same message may have raised the suspicion and confirmed it.
        let suspicion = suspicion.filter(|(number, _)| *number < self.steps).map(|(_, before)| before);
        if let Some(before) = &suspicion {
            life.began = life.began.min(before.start);
        }
        if self.begin(id, life) {
            for draft in suspicion.into_iter().chain([draft.clone()]) {
                self.untold.spans.push((draft, Place::root(id).child()));
            }
            self.untold.touched.insert(id);
        }
    }

    /// A setpoint has come into another state.
    fn answered(&mut self, id: Uuid, state: CommandState, error: Option<&'static str>, draft: Draft) {
        let Some(life) = self.open.get_mut(&id) else { return };
        self.untold.spans.push((draft, Place::root(id).child()));
        self.untold.touched.insert(id);
        if is_final(state) {
            life.attributes.push(KeyValue::new("vibrissa.setpoint_state", state.word()));
            life.attributes.extend(error.map(|error| KeyValue::new("error.type", error)));
            if !matches!(state, CommandState::Applied | CommandState::Superseded) {
                life.status = Status::error(state.word());
            }
            self.untold.over.push(id);
        }
    }

    /// What was stepped so far is one transaction; what comes now is the next one's.
    pub(crate) fn seal(&mut self) -> Untold {
        std::mem::take(&mut self.untold)
    }

    /// What was sealed is committed, which took that long.
    pub(crate) fn committed(&mut self, untold: &mut Untold, took: Duration) {
        let done = SystemTime::now();
        for (draft, place) in untold.spans.drain(..) {
            self.traces.tell(draft, place);
        }
        for id in std::mem::take(&mut untold.touched) {
            if let Some(life) = self.open.get_mut(&id) {
                life.is_committed = true;
            }
            let period = (done.checked_sub(took).unwrap_or(done), done);
            let draft = Draft::new("commit", SpanKind::Client, period)
                .with("db.system.name", self.traces.0.database)
                .with("db.operation.name", "COMMIT");
            self.traces.tell(draft, Place::root(id).child());
        }
        for id in std::mem::take(&mut untold.over) {
            let Some(life) = self.open.remove(&id) else { continue };
            let mut root = Draft::new(life.name, SpanKind::Internal, (life.began, done));
            root.attributes = life.attributes;
            root.status = life.status;
            self.traces.tell(root, Place::root(id));
        }
    }

    /// A setpoint is among the publications.
    pub(crate) fn sending(&mut self, name: &Name, command: &Command) {
        self.untold.sending.push(command_uuid(&self.fleet, name, command.key));
    }

    /// The publications were given to the connection then, or some of them could not be.
    pub(crate) fn published(&mut self, untold: Untold, now: SystemTime, all: bool) {
        for id in untold.sending {
            let Some(life) = self.open.get(&id) else { continue };
            let draft = Draft::new("send setpoint", SpanKind::Producer, (now, now));
            let mut draft = story::messaging(draft, RobotTopic::Setpoint, &self.fleet, &life.robot, "publish");
            if !all {
                draft.status = Status::error("not everything was published; what is not answered is sent again");
            }
            self.traces.tell(draft, Place::root(id).child());
        }
    }

    /// The fleet is somebody else's from now on, or nobody's.
    pub(crate) fn end(&mut self, ending: Ending) {
        let word = match ending {
            Ending::Stopped => "STOPPED",
            Ending::LeaseLost => "LEASE_LOST",
        };
        for (id, _) in std::mem::take(&mut self.open).into_iter().filter(|(_, life)| life.is_committed) {
            self.moment(id, "hand over", Some(word));
        }
    }

    /// A setpoint's trace, as everybody knows it who knows the setpoint.
    fn life(&self, name: &Name, robot: &Robot, robot_id: i64, command: &Command, id: Uuid) -> Life {
        let mut attributes = story::robot_of(&self.fleet, name).to_vec();
        attributes.extend(story::setpoint(robot, robot_id, command, id.to_string()));
        Life {
            name: format!("setpoint {}", command.reason.word()),
            robot: name.clone(),
            began: time(command.issued),
            attributes,
            status: Status::Unset,
            is_committed: false,
        }
    }

    /// False if too many are under way to follow this one.
    fn begin(&mut self, id: Uuid, life: Life) -> bool {
        let is_followed = self.open.len() < OPEN_MAX;
        if is_followed {
            self.open.insert(id, life);
        } else {
            self.traces.drop_one();
        }
        is_followed
    }

    fn moment(&self, id: Uuid, name: &'static str, ending: Option<&'static str>) {
        let now = SystemTime::now();
        let mut draft = Draft::new(name, SpanKind::Internal, (now, now));
        draft.attributes.extend(ending.map(|ending| KeyValue::new("vibrissa.ending", ending)));
        self.traces.tell(draft, Place::root(id).child());
    }
}

/// A whisker by its names.
fn whisker(step: &Step<'_>, index: WhiskerIndex) -> Option<Whisker> {
    let view = step.robot.whisker(index)?;
    Some((step.name.clone(), view.array.to_owned(), view.sheet.number))
}
