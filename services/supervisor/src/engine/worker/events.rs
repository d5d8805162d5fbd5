//! Events for the log, made from the core's effects beside the rows.

use vibrissa_core::robot::Compensation;
use vibrissa_core::robot::effect::{
    Asked, Command, CommandKey, CommandState, CompensationError, Decision, Effect, Refinement, TestState, Trim,
    WhiskerIndex,
};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_edge::events::EventKind;
use vibrissa_edge::ids::{command_id, wide_id};
use vibrissa_edge::words::Word;
use vibrissa_store::events::write::EventRow;

use super::stepper::Stepper;
use crate::engine::commit::batch::Source;
use crate::engine::robot::KnownRobot;
use crate::events::{
    CandidatePart, CompensationPart, ConditionPart, DecisionPart, ErrorPart, FaultPart, GonePart, Parts,
    RefinementPart, SetpointPart, TouchTestPart, TrimPart, event,
};
use crate::one_of::OneOf;

impl Stepper {
    /// Adds the events of an effect to the batch.
    pub(super) fn tell(&mut self, known: &KnownRobot, now: Micros, effect: &Effect, source: Option<Source<'_>>) {
        if let Effect::Contact(contact) = effect {
            if let (Some(maker), Some(source)) = (&mut self.contact_events, source) {
                maker.take(known, contact, source);
            }
            return;
        }
        let id = |key| command_id(&self.fleet, &known.name, key);
        let Some(published_event) = published_event(known, effect, id) else { return };
        self.add_event(known, now, published_event);
        if let Effect::Decided(decision) = effect
            && let Some(begun) = begun(known, decision)
        {
            self.add_event(known, now, begun);
        }
    }

    /// Adds the event of a message's contacts, if there are any.
    pub(super) fn tell_contacts(&mut self, known: &KnownRobot, now: Micros, source: Option<Source<'_>>) {
        let made = self.contact_events.as_mut().and_then(|maker| maker.make(known, source));
        if let Some((kind, parts)) = made {
            self.add_event(known, now, Told::new(kind, None, parts));
        }
    }

    fn add_event(&mut self, known: &KnownRobot, now: Micros, published_event: Told) {
        let Told { kind, word, whisker, parts } = published_event;
        let row = EventRow {
            word,
            whisker_id: whisker.map(|whisker| known.whisker_id(whisker)),
            ..event(kind, now.0 as i64, &parts).of_robot(known.robot_id)
        };
        if let Some(maker) = &self.contact_events {
            maker.added(&row);
        }
        self.batch.rows_mut().events.push(row);
    }
}

/// An event of a robot.
struct Told {
    kind: EventKind,
    word: Option<&'static str>,
    whisker: Option<WhiskerIndex>,
    parts: Parts,
}

impl Told {
    fn new(kind: EventKind, whisker: Option<WhiskerIndex>, parts: Parts) -> Self {
        Self { kind, word: None, whisker, parts }
    }

    /// An alarm, or a state of a setpoint.
    fn with_word(self, word: &'static str) -> Self {
        Self { word: Some(word), ..self }
    }
}

/// The event of an effect; `None` for one that is no event.
fn published_event(known: &KnownRobot, effect: &Effect, id: impl Fn(CommandKey) -> String) -> Option<Told> {
    let (robot_id, none) = (known.robot_id, Parts::default);
    Some(match effect {
        Effect::Trim(trim) => {
            let part = Some(trim_part(robot_id, trim));
            Told::new(EventKind::Trim, Some(trim.whisker), Parts { trim: part, ..none() })
        }
        Effect::Condition { whisker, from, to } => {
            let part = Some(ConditionPart { was: OneOf(*from), becomes: OneOf(*to) });
            Told::new(EventKind::ConditionChanged, Some(*whisker), Parts { condition: part, ..none() })
        }
        Effect::Fault { whisker, from, to } => {
            let part = Some(FaultPart { was: from.map(Word::word), becomes: to.map(Word::word) });
            Told::new(EventKind::FaultChanged, Some(*whisker), Parts { fault: part, ..none() })
        }
        Effect::Decided(decision) => {
            let part = Some(decision_part(known, decision));
            Told::new(EventKind::Decision, Some(decision.target), Parts { decision: part, ..none() })
        }
        Effect::Approved { compensation } => begun_part(known, compensation_of(known, *compensation)?),
        Effect::Ended { compensation, target, case, reason, was_proposed } => {
            let kind = if *was_proposed { EventKind::ProposalEnded } else { EventKind::CompensationEnded };
            let part = Some(CompensationPart {
                compensation_id: wide_id(robot_id, *compensation),
                case: Some(OneOf(*case)),
                compensator_whisker: None,
                pressure_mpa: None,
                predicted_error: None,
                end_reason: Some(OneOf(*reason)),
            });
            Told::new(kind, Some(*target), Parts { compensation: part, ..none() })
        }
        Effect::Command(command) => {
            let part = Some(setpoint_part(robot_id, command, id(command.key)));
            Told::new(EventKind::Setpoint, Some(command.whisker), Parts { setpoint: part, ..none() })
        }
        Effect::CommandState { command, whisker, asked, state, rejection, pressure } => {
            let kind = match state {
                CommandState::Rejected | CommandState::Failed | CommandState::Expired => EventKind::SetpointFailed,
                CommandState::Pending
                | CommandState::Received
                | CommandState::Applying
                | CommandState::Applied
                | CommandState::Superseded
                | CommandState::Abandoned => EventKind::SetpointState,
            };
            let Asked { pressure: wanted, reason } = asked;
            let part = Some(SetpointPart {
                command_id: id(*command),
                state: OneOf(*state),
                pressure_mpa: Some(wanted.mpa()),
                reached_mpa: pressure.map(Megapascal::mpa),
                rejection: rejection.map(Word::word),
                compensation_id: None,
                reason: Some(OneOf(*reason)),
            });
            Told::new(kind, *whisker, Parts { setpoint: part, ..none() }).with_word(state.word())
        }
        Effect::Error(error) => {
            let part = Some(error_part(robot_id, error));
            Told::new(EventKind::Error, known.target_of(error.compensation), Parts { error: part, ..none() })
        }
        Effect::Refined(refinement) => {
            let part = Some(refinement_part(robot_id, refinement));
            let target = known.target_of(refinement.compensation);
            Told::new(EventKind::Refinement, target, Parts { refinement: part, ..none() })
        }
        Effect::Alarm { whisker, kind } => {
            Told::new(EventKind::AlarmRaised, Some(*whisker), none()).with_word(kind.word())
        }
        Effect::AlarmCleared { whisker, kind } => {
            Told::new(EventKind::AlarmCleared, Some(*whisker), none()).with_word(kind.word())
        }
        Effect::RobotAlarm { kind } => Told::new(EventKind::AlarmRaised, None, none()).with_word(kind.word()),
        Effect::RobotAlarmCleared { kind } => Told::new(EventKind::AlarmCleared, None, none()).with_word(kind.word()),
        Effect::Test(test) => test_event(Some(test.whisker), id(test.key), TestState::Pending),
        Effect::TestProposed(test) => test_event(Some(test.whisker), id(test.key), TestState::Proposed),
        Effect::TestState { test, whisker, state, .. } => test_event(*whisker, id(*test), *state),
        Effect::Gone { array, number, .. } => {
            let part = Some(GonePart { array: array.clone(), whisker: *number });
            Told::new(EventKind::WhiskerGone, None, Parts { gone: part, ..none() })
        }
        Effect::Contact(_)
        | Effect::UnknownWhisker { .. }
        | Effect::BadTime { .. }
        | Effect::Resend(_)
        | Effect::Response(_)
        | Effect::MissedTouch { .. }
        | Effect::AskForFactsheet => return None,
    })
}

/// The beginning of a compensation that needs no approval; `None` without a compensator, and for a proposal.
fn begun(known: &KnownRobot, decision: &Decision) -> Option<Told> {
    compensation_of(known, decision.compensation)
        .filter(|compensation| decision.chosen.is_some() && !compensation.is_proposed())
        .map(|compensation| begun_part(known, compensation))
}

fn begun_part(known: &KnownRobot, compensation: &Compensation) -> Told {
    let part = CompensationPart {
        compensation_id: wide_id(known.robot_id, compensation.id()),
        case: Some(OneOf(compensation.case())),
        compensator_whisker: number_of(known, compensation.compensator()).map(i64::from),
        pressure_mpa: Some(compensation.pressure().mpa()),
        predicted_error: Some(compensation.predicted_error()),
        end_reason: None,
    };
    let parts = Parts { compensation: Some(part), ..Parts::default() };
    Told::new(EventKind::CompensationBegun, Some(compensation.target()), parts)
}

/// A compensation that is in force or proposed.
fn compensation_of(known: &KnownRobot, number: u32) -> Option<&Compensation> {
    known.robot.compensations().iter().find(|one| one.id() == number)
}

/// Number of a whisker in its array.
fn number_of(known: &KnownRobot, whisker: WhiskerIndex) -> Option<u16> {
    known.robot.whisker(whisker).map(|view| view.sheet.number)
}

fn test_event(whisker: Option<WhiskerIndex>, test_id: String, state: TestState) -> Told {
    let part = TouchTestPart { test_id, state: Some(OneOf(state)), touches: 0, missed: 0 };
    Told::new(EventKind::TouchTest, whisker, Parts { touch_test: Some(part), ..Parts::default() })
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
        whisker: number_of(known, one.whisker),
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
        reached_mpa: None,
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

fn refinement_part(robot_id: i64, refinement: &Refinement) -> RefinementPart {
    RefinementPart {
        compensation_id: wide_id(robot_id, refinement.compensation),
        outcome: refinement.outcome.word(),
        pressure_from_mpa: refinement.pressure_from.mpa(),
        pressure_best_mpa: refinement.pressure_best.map(Megapascal::mpa),
    }
}
