//! Spans and attributes of a step of the core.

use std::time::SystemTime;

use opentelemetry::trace::{Event as SpanEvent, SpanKind};
use opentelemetry::{KeyValue, Value};
use vibrissa_core::robot::effect::{Command, CommandState, ContactRecord, Decision, Effect, Trim, WhiskerIndex};
use vibrissa_core::robot::{Event, Robot};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_edge::words::Word;
use vibrissa_protocol::{Name, RobotTopic};

use super::span::{Draft, known, now, time};
use vibrissa_edge::ids::wide_id;
use vibrissa_store::actions::Action;

/// A step of the core.
pub(crate) struct Step<'a> {
    /// Fleet of the robot.
    pub(crate) fleet: &'a Name,
    /// Name of the robot.
    pub(crate) name: &'a Name,
    /// Row id of the robot in the database.
    pub(crate) robot_id: i64,
    /// The robot after the step.
    pub(crate) robot: &'a Robot,
    /// Time of the step: receipt of the message, or the time of a tick.
    pub(crate) now: Micros,
    /// Event that the core was given.
    pub(crate) event: &'a Event<'a>,
    /// The effects of the step.
    pub(crate) effects: &'a [Effect],
}

/// An operator's action.
#[derive(Debug, Clone)]
pub(crate) struct TracedAction {
    action_id: i64,
    request_id: String,
    kind: String,
    /// Time of the request, by the clock of the supervisor that received it.
    pub(super) requested: SystemTime,
}

impl TracedAction {
    /// The trace's view of a row of the table `actions`.
    pub(crate) fn of(action: &Action) -> Self {
        let requested = time(Micros(u64::try_from(action.asked_us).unwrap_or_default()));
        let (request_id, kind) = (action.request_id.clone(), action.kind.clone());
        Self { action_id: action.action_id, request_id, kind, requested }
    }

    pub(super) fn attributes(&self) -> [KeyValue; 3] {
        [
            KeyValue::new("vibrissa.action_id", self.action_id),
            KeyValue::new("vibrissa.action", self.kind.clone()),
            KeyValue::new("vibrissa.request_id", self.request_id.clone()),
        ]
    }
}

/// Whether a step is traced: steps with ordinary contacts only are not.
pub(crate) fn is_traced(effects: &[Effect]) -> bool {
    effects.iter().any(|effect| {
        matches!(
            effect,
            Effect::Condition { .. }
                | Effect::Trim(_)
                | Effect::Decided(_)
                | Effect::Command(_)
                | Effect::CommandState { .. }
        )
    })
}

/// Whether a setpoint's state is final.
pub(super) fn is_final(state: CommandState) -> bool {
    match state {
        CommandState::Pending | CommandState::Received | CommandState::Applying => false,
        CommandState::Applied
        | CommandState::Rejected
        | CommandState::Failed
        | CommandState::Superseded
        | CommandState::Expired
        | CommandState::Abandoned => true,
    }
}

/// The span of a step, from the receipt of the message until now.
pub(super) fn processing(step: &Step<'_>, action: Option<&TracedAction>) -> Draft {
    let (what, boot_id, seq) = match *step.event {
        Event::Contacts { boot_id, seq, .. } => (Some(RobotTopic::Contacts), Some(boot_id), Some(seq)),
        Event::Setpoint { boot_id, .. } => (Some(RobotTopic::SetpointState), Some(boot_id), None),
        Event::TouchTest { boot_id, .. } => (Some(RobotTopic::TestState), Some(boot_id), None),
        Event::Status { boot_id, .. } => (Some(RobotTopic::Status), Some(boot_id), None),
        Event::Connection { boot_id, .. } => (Some(RobotTopic::Connection), Some(boot_id), None),
        Event::Factsheet { boot_id, .. } => (Some(RobotTopic::Factsheet), Some(boot_id), None),
        Event::Operator(_) | Event::PolicyChanged | Event::Tick => (None, None, None),
    };
    let period = (time(step.now), now());
    let mut draft = match (what, action) {
        (Some(topic), _) => {
            let draft = Draft::new(format!("process {topic}"), SpanKind::Consumer, period);
            messaging(draft, topic, step.fleet, step.name, "process")
        }
        (None, Some(action)) => {
            let mut draft = Draft::new("carry out action", SpanKind::Internal, period);
            draft.attributes.extend(action.attributes());
            draft
        }
        (None, None) => Draft::new("tick", SpanKind::Internal, period),
    };
    draft.attributes.extend(known([
        ("vibrissa.boot_id", boot_id.map(|boot_id| boot_id.to_owned().into())),
        ("vibrissa.seq", seq.map(whole)),
    ]));
    draft.events = events(step, draft.end);
    draft
}

/// Adds the attributes of OpenTelemetry's semantic conventions for messaging.
pub(super) fn messaging(draft: Draft, topic: RobotTopic, fleet: &Name, robot: &Name, operation: &'static str) -> Draft {
    let kind = if operation == "process" { "process" } else { "send" };
    draft
        .with("messaging.system", "mqtt")
        .with("messaging.operation.name", operation)
        .with("messaging.operation.type", kind)
        .with("messaging.destination.name", topic.of(fleet, robot).to_string())
        .with("messaging.destination.template", format!("whisker/v1/{{fleet}}/{{robot}}/{topic}"))
}

/// Events of the span: condition changes, trims and decisions, in the order of the effects.
fn events(step: &Step<'_>, at: SystemTime) -> Vec<SpanEvent> {
    let mut last_contact: Option<&ContactRecord> = None;
    let mut events = Vec::new();
    let mut add = |name: &'static str, attributes| events.push(SpanEvent::new(name, at, attributes, 0));
    for effect in step.effects {
        if let Effect::Contact(contact) = effect {
            last_contact = Some(contact);
        } else if let Effect::Condition { whisker, from, to } = effect {
            let mut attributes = whisker_of(step.robot, *whisker);
            attributes.push(KeyValue::new("vibrissa.condition_before", from.word()));
            attributes.push(KeyValue::new("vibrissa.condition", to.word()));
            attributes.extend(
                last_contact.filter(|contact| contact.whisker == *whisker).into_iter().flat_map(contact_attributes),
            );
            add("condition", attributes);
        } else if let Effect::Trim(trim) = effect {
            add("trimmed", trimmed(step, trim));
        } else if let Effect::Decided(decision) = effect {
            add("decided", decided(step, decision));
        }
    }
    events
}

/// Attributes of the contact that changed the condition.
fn contact_attributes(contact: &ContactRecord) -> impl Iterator<Item = KeyValue> + use<> {
    known([
        ("vibrissa.contact_position", Some(whole(contact.position as u64))),
        ("vibrissa.standardised_innovation", contact.standardised.map(Value::from)),
        ("vibrissa.length_mm", Some(contact.length.length.mm().into())),
        ("vibrissa.length_sd_mm", Some(contact.length.sd_mm.into())),
    ])
}

fn trimmed(step: &Step<'_>, trim: &Trim) -> Vec<KeyValue> {
    let mut attributes = whisker_of(step.robot, trim.whisker);
    attributes.extend([
        KeyValue::new("vibrissa.trim_id", wide_id(step.robot_id, trim.id)),
        KeyValue::new("vibrissa.length_before_mm", trim.length_before.mm()),
        KeyValue::new("vibrissa.length_mm", trim.length_after.length.mm()),
        KeyValue::new("vibrissa.length_sd_mm", trim.length_after.sd_mm),
        KeyValue::new("vibrissa.contacts_to_detect", i64::from(trim.contacts_to_detect)),
    ]);
    attributes
}

fn decided(step: &Step<'_>, decision: &Decision) -> Vec<KeyValue> {
    let chosen = decision.chosen.and_then(|at| decision.candidates.get(at));
    let mut attributes = whisker_of(step.robot, decision.target);
    attributes.extend([
        KeyValue::new("vibrissa.compensation_id", wide_id(step.robot_id, decision.compensation)),
        KeyValue::new("vibrissa.case", chosen.map_or("NONE", |chosen| chosen.case.word())),
        KeyValue::new("vibrissa.candidates", whole(decision.candidates.len() as u64)),
        KeyValue::new("vibrissa.waits_for_approval", decision.proposed),
    ]);
    let number = chosen.and_then(|chosen| step.robot.whisker(chosen.whisker)).map(|view| view.sheet.number);
    attributes.extend(known([
        ("vibrissa.compensator", number.map(|number| i64::from(number).into())),
        ("vibrissa.predicted_error", chosen.and_then(|chosen| chosen.predicted_error).map(Value::from)),
        ("vibrissa.pressure_mpa", chosen.and_then(|chosen| chosen.pressure).map(Megapascal::mpa).map(Value::from)),
    ]));
    attributes
}

/// Attributes that identify a whisker.
pub(super) fn whisker_of(robot: &Robot, whisker: WhiskerIndex) -> Vec<KeyValue> {
    robot.whisker(whisker).map_or_else(Vec::new, |view| {
        vec![
            KeyValue::new("vibrissa.array", view.array.to_owned()),
            KeyValue::new("vibrissa.whisker", i64::from(view.sheet.number)),
        ]
    })
}

/// Attributes that identify a robot.
pub(super) fn robot_of(fleet: &Name, robot: &Name) -> [KeyValue; 2] {
    [KeyValue::new("vibrissa.fleet", fleet.to_string()), KeyValue::new("vibrissa.robot", robot.to_string())]
}

/// Attributes of a setpoint.
pub(super) fn setpoint(robot: &Robot, robot_id: i64, command: &Command, command_id: String) -> Vec<KeyValue> {
    let mut attributes = whisker_of(robot, command.whisker);
    attributes.extend([
        KeyValue::new("vibrissa.command_id", command_id),
        KeyValue::new("vibrissa.epoch", whole(command.key.epoch)),
        KeyValue::new("vibrissa.version", whole(command.key.version)),
        KeyValue::new("vibrissa.reason", command.reason.word()),
        KeyValue::new("vibrissa.pressure_mpa", command.pressure.mpa()),
    ]);
    attributes.extend(known([(
        "vibrissa.compensation_id",
        command.compensation.map(|number| wide_id(robot_id, number).into()),
    )]));
    attributes
}

/// Attribute of a reported pressure, if there is one.
pub(super) fn known_pressure(pressure: Option<Megapascal>) -> impl Iterator<Item = KeyValue> {
    known([("vibrissa.pressure_mpa", pressure.map(|pressure| pressure.mpa().into()))])
}

fn whole(number: u64) -> Value {
    i64::try_from(number).unwrap_or(i64::MAX).into()
}
