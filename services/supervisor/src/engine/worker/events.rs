//! Events for other programs, made from the core's effects beside the rows.

use std::collections::BTreeMap;

use vibrissa_core::robot::effect::{
    Command, CommandKey, CommandState, CompensationError, ContactRecord, Decision, Effect, Trim, WhiskerIndex,
};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros};
use vibrissa_edge::ids::{command_id, wide_id};
use vibrissa_edge::words::Word;
use vibrissa_store::batch::EventRow;
use vibrissa_store::time::Time;

use super::stepper::Stepper;
use crate::engine::commit::batch::Source;
use crate::engine::robot::KnownRobot;
use crate::events::{
    AlarmPart, CandidatePart, CompensationPart, ContactPart, ContactsPart, DecisionPart, ErrorPart, Event, EventSink,
    EventType, SetpointPart, TrimPart, VERSION,
};
use crate::one_of::OneOf;

/// Makes the events of a worker's steps.
#[derive(Debug)]
pub(crate) struct EventMaker {
    sink: EventSink,
    /// Contacts of the current message.
    contacts: Vec<ContactPart>,
    /// Number of contacts that are left out since the last event of contacts, by the robot's number in the database.
    left_out: BTreeMap<i64, u64>,
}

impl EventMaker {
    pub(crate) fn new(sink: EventSink) -> Self {
        Self { sink, contacts: Vec::new(), left_out: BTreeMap::new() }
    }
}

impl Stepper {
    /// Adds the event of an effect to the batch, if events are published.
    pub(super) fn tell(&mut self, known: &KnownRobot, now: Micros, effect: &Effect, source: Option<Source<'_>>) {
        let Some(maker) = &mut self.events else { return };
        if let Effect::Contact(contact) = effect {
            if maker.sink.has_contacts
                && let Some(source) = source
            {
                maker.contacts.extend(contact_part(known, contact, source));
            }
            return;
        }
        let event = Event {
            timestamp: Time(now.0 as i64),
            fleet: self.fleet.as_str().to_owned(),
            ..Event::none(known.name.as_str())
        };
        let Some(event) = told(event, known, effect, |key| command_id(&self.fleet, &known.name, key)) else { return };
        self.add_event(known, &event);
    }

    /// Adds the event of a message's contacts, if there are any.
    pub(super) fn tell_contacts(&mut self, known: &KnownRobot, now: Micros, source: Option<Source<'_>>) {
        let Some(maker) = &mut self.events else { return };
        let contacts = std::mem::take(&mut maker.contacts);
        let Some(source) = source.filter(|_| !contacts.is_empty()) else { return };
        let event = Event {
            timestamp: Time(now.0 as i64),
            fleet: self.fleet.as_str().to_owned(),
            ..Event::none(known.name.as_str())
        };
        let event = if maker.sink.room.is_full() {
            let more = contacts.len() as u64;
            maker.sink.room.leave_out(more);
            let left_out = maker.left_out.entry(known.robot_id).or_default();
            *left_out += more;
            if *left_out > more {
                return;
            }
            // Written now, because a restart forgets the number.
            Event { kind: EventType::ContactsLeftOut, ..event }
        } else {
            let left_out = maker.left_out.remove(&known.robot_id);
            let (boot_id, seq) = (source.message.boot_id.as_str().to_owned(), source.message.seq);
            Event { contacts: Some(ContactsPart { boot_id, seq, left_out, contacts }), ..event }
        };
        self.add_event(known, &event);
    }

    fn add_event(&mut self, known: &KnownRobot, event: &Event) {
        // An event has texts and numbers only, and infinite numbers become null.
        let Ok(body) = serde_json::to_string(event) else { return };
        let row = EventRow {
            robot_id: known.robot_id,
            robot: event.robot.clone(),
            is_contacts: matches!(event.kind, EventType::Contacts | EventType::ContactsLeftOut),
            body,
        };
        if let Some(maker) = &self.events {
            maker.sink.room.add(&row);
        }
        self.batch.rows_mut().events.push(row);
    }
}

impl Event {
    fn none(robot: &str) -> Self {
        Self {
            kind: EventType::Contacts,
            version: VERSION,
            timestamp: Time(0),
            fleet: String::new(),
            robot: robot.to_owned(),
            array: None,
            whisker: None,
            contacts: None,
            trim: None,
            decision: None,
            compensation: None,
            setpoint: None,
            error: None,
            alarm: None,
        }
    }

    fn about(self, known: &KnownRobot, whisker: WhiskerIndex) -> Self {
        match named(known, whisker) {
            Some((array, whisker)) => Self { array: Some(array), whisker: Some(whisker), ..self },
            None => self,
        }
    }
}

/// Array and number of a whisker.
fn named(known: &KnownRobot, whisker: WhiskerIndex) -> Option<(String, u16)> {
    known.robot.whisker(whisker).map(|view| (view.array.to_owned(), view.sheet.number))
}

fn contact_part(known: &KnownRobot, contact: &ContactRecord, source: Source<'_>) -> Option<ContactPart> {
    let sent = source.message.contacts.get(contact.position)?;
    Some(ContactPart {
        position: contact.position as i64,
        array: sent.array.as_str().to_owned(),
        whisker: sent.whisker,
        t_us: sent.t_us as i64,
        place: sent.place().word(),
        ratio: contact.ratio.map(ContactRatio::a),
        distance_mm: sent.distance_mm,
        deflection_mm: sent.deflection_mm,
        strain: sent.strain,
        pressure_mpa: sent.pressure_mpa,
        temperature_c: sent.temperature_c,
        used: contact.used.word(),
        residual: contact.residual,
        length_mm: contact.length.length.mm(),
        length_sd_mm: contact.length.sd_mm,
    })
    .filter(|_| known.robot.whisker(contact.whisker).is_some())
}

/// The event of an effect; `None` for one that is no event.
fn told(event: Event, known: &KnownRobot, effect: &Effect, id: impl Fn(CommandKey) -> String) -> Option<Event> {
    let robot_id = known.robot_id;
    let compensation = |number: u32| CompensationPart {
        compensation_id: wide_id(robot_id, number),
        case: known.case_of(number).map(OneOf),
        end_reason: None,
    };
    Some(match effect {
        Effect::Trim(trim) => {
            Event { kind: EventType::Trim, trim: Some(trim_part(robot_id, trim)), ..event.about(known, trim.whisker) }
        }
        Effect::Decided(decision) => Event {
            kind: EventType::Decision,
            decision: Some(decision_part(known, decision)),
            ..event.about(known, decision.target)
        },
        Effect::Approved { compensation: number } => {
            Event { kind: EventType::CompensationApproved, compensation: Some(compensation(*number)), ..event }
        }
        Effect::Ended { compensation: number, case, reason } => Event {
            kind: EventType::CompensationEnded,
            compensation: Some(CompensationPart {
                case: Some(OneOf(*case)),
                end_reason: Some(OneOf(*reason)),
                ..compensation(*number)
            }),
            ..event
        },
        Effect::Command(command) => Event {
            kind: EventType::Setpoint,
            setpoint: Some(setpoint_part(robot_id, command, id(command.key))),
            ..event.about(known, command.whisker)
        },
        Effect::CommandState { command, state, rejection, pressure, .. } => Event {
            kind: EventType::SetpointState,
            setpoint: Some(SetpointPart {
                command_id: id(*command),
                state: OneOf(*state),
                pressure_mpa: pressure.map(Megapascal::mpa),
                rejection: rejection.map(Word::word),
                compensation_id: None,
                reason: None,
            }),
            ..event
        },
        Effect::Error(error) => {
            let event = match known.target_of(error.compensation) {
                Some(target) => event.about(known, target),
                None => event,
            };
            Event { kind: EventType::Error, error: Some(error_part(robot_id, error)), ..event }
        }
        Effect::Alarm { whisker, kind } => Event {
            kind: EventType::AlarmRaised,
            alarm: Some(AlarmPart { kind: OneOf(*kind) }),
            ..event.about(known, *whisker)
        },
        Effect::AlarmCleared { whisker, kind } => Event {
            kind: EventType::AlarmCleared,
            alarm: Some(AlarmPart { kind: OneOf(*kind) }),
            ..event.about(known, *whisker)
        },
        Effect::RobotAlarm { kind } => {
            Event { kind: EventType::AlarmRaised, alarm: Some(AlarmPart { kind: OneOf(*kind) }), ..event }
        }
        Effect::RobotAlarmCleared { kind } => {
            Event { kind: EventType::AlarmCleared, alarm: Some(AlarmPart { kind: OneOf(*kind) }), ..event }
        }
        Effect::Gone { array, number, .. } => {
            Event { kind: EventType::WhiskerGone, array: Some(array.clone()), whisker: Some(*number), ..event }
        }
        Effect::Contact(_)
        | Effect::UnknownWhisker { .. }
        | Effect::BadTime { .. }
        | Effect::Condition { .. }
        | Effect::Fault { .. }
        | Effect::Resend(_)
        | Effect::Response(_)
        | Effect::Refined(_)
        | Effect::MissedTouch { .. }
        | Effect::Test(_)
        | Effect::TestProposed(_)
        | Effect::TestState { .. }
        | Effect::AskForFactsheet => return None,
    })
}

fn trim_part(robot_id: i64, trim: &Trim) -> TrimPart {
    TrimPart {
        trim_id: wide_id(robot_id, trim.id),
        length_before_mm: trim.length_before.mm(),
        length_after_mm: trim.length_after.length.mm(),
        length_after_sd_mm: trim.length_after.sd_mm,
        contacts_to_detect: trim.contacts_to_detect,
    }
}

fn decision_part(known: &KnownRobot, decision: &Decision) -> DecisionPart {
    let candidates = decision.candidates.iter().enumerate().map(|(at, one)| CandidatePart {
        whisker: named(known, one.whisker).map(|(_, whisker)| whisker),
        case: OneOf(one.case),
        pressure_mpa: one.pressure.map(Megapascal::mpa),
        predicted_error: one.predicted_error,
        chosen: decision.chosen == Some(at),
        refused: one.refused.map(Word::word),
    });
    DecisionPart {
        compensation_id: wide_id(known.robot_id, decision.compensation),
        proposed: decision.proposed,
        candidates: candidates.collect(),
    }
}

fn setpoint_part(robot_id: i64, command: &Command, command_id: String) -> SetpointPart {
    SetpointPart {
        command_id,
        state: OneOf(CommandState::Pending),
        pressure_mpa: Some(command.pressure.mpa()),
        rejection: None,
        compensation_id: command.compensation.map(|number| wide_id(robot_id, number)),
        reason: Some(OneOf(command.reason)),
    }
}

fn error_part(robot_id: i64, error: &CompensationError) -> ErrorPart {
    ErrorPart {
        compensation_id: wide_id(robot_id, error.compensation),
        contacts: error.contacts,
        pressure_mpa: error.pressure.mpa(),
        error: error.mean,
        error_sd: error.sd,
    }
}
