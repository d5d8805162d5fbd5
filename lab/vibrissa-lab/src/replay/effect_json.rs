//! Events of the replay as lines of JSON, with the names of the database and the contract, units last.

mod errors;

use std::io::{self, Write};

use serde::Serialize;
use vibrissa_core::mechanics::CONTACT_RATIOS;
use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::{
    CandidateRecord, Command, CommandKey, ContactRecord, Decision, Effect, Response, Trim,
};
use vibrissa_core::units::Megapascal;
use vibrissa_edge::words::Word;
use vibrissa_protocol as protocol;

use super::replayer::{Happened, What};
use errors::{ErrorLine, RefinementLine, error_line, refinement_line};

/// Writes an event as one line.
///
/// # Errors
/// The output cannot be written.
pub fn write(happened: &Happened<'_>, out: &mut dyn Write) -> io::Result<()> {
    let what = match &happened.what {
        What::Effect { effect, source, .. } => json_form(effect, *source, happened.robot.map(|(_, _, robot)| robot)),
        What::Refused { reason, problem, topic } => Some(Told::Refused { reason, problem, topic }),
    };
    let Some(what) = what else { return Ok(()) };
    let line = Line {
        received_us: happened.at.0,
        fleet: happened.robot.map(|(fleet, _, _)| fleet.as_str()),
        robot: happened.robot.map(|(_, robot, _)| robot.as_str()),
        assumed: matches!(happened.what, What::Effect { assumed: true, .. }),
        what,
    };
    serde_json::to_writer(&mut *out, &line).map_err(io::Error::from)?;
    out.write_all(b"\n")
}

#[derive(Serialize)]
struct Line<'a> {
    received_us: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    fleet: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    robot: Option<&'a str>,
    /// Whether it depends on a setpoint that is assumed to be applied.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    assumed: bool,
    #[serde(flatten)]
    what: Told<'a>,
}

/// A whisker by its array and number.
#[derive(Serialize)]
struct WhiskerJson<'a> {
    array: &'a str,
    whisker: u16,
}

/// An effect, in the words of the tables that the service writes.
#[derive(Serialize)]
#[serde(tag = "effect", rename_all = "SCREAMING_SNAKE_CASE")]
enum Told<'a> {
    Contact(ContactLine<'a>),
    UnknownWhisker {
        position: usize,
    },
    BadTime {
        position: usize,
    },
    Condition(Change<'a>),
    Fault(Change<'a>),
    Trim(TrimLine<'a>),
    Decision(DecisionLine<'a>),
    Ended {
        compensation: u32,
        end_reason: &'static str,
    },
    Setpoint(SetpointLine<'a>),
    SetpointAgain(SetpointLine<'a>),
    SetpointState {
        epoch: u64,
        version: u64,
        state: &'static str,
        error: Option<&'static str>,
        pressure_mpa: Option<f64>,
    },
    MissedTouch {
        #[serde(flatten)]
        place: WhiskerJson<'a>,
    },
    TouchTest {
        #[serde(flatten)]
        place: WhiskerJson<'a>,
        epoch: u64,
        version: u64,
        kind: &'static str,
        reason: &'static str,
        contacts: u16,
    },
    TestProposed {
        #[serde(flatten)]
        place: WhiskerJson<'a>,
        epoch: u64,
        version: u64,
        kind: &'static str,
        reason: &'static str,
        contacts: u16,
    },
    TestState {
        epoch: u64,
        version: u64,
        state: &'static str,
        error: Option<&'static str>,
    },
    Response(ResponseLine),
    Error(ErrorLine),
    Refinement(RefinementLine),
    Approved {
        compensation: u32,
    },
    Alarm {
        #[serde(flatten)]
        place: WhiskerJson<'a>,
        kind: &'static str,
    },
    AlarmCleared {
        #[serde(flatten)]
        place: WhiskerJson<'a>,
        kind: &'static str,
    },
    RobotAlarm {
        kind: &'static str,
    },
    RobotAlarmCleared {
        kind: &'static str,
    },
    Gone {
        #[serde(flatten)]
        place: WhiskerJson<'a>,
        alarms: Vec<&'static str>,
    },
    Request {
        request: &'static str,
    },
    Refused {
        reason: &'a str,
        problem: &'a str,
        topic: &'a str,
    },
}

#[derive(Serialize)]
struct Change<'a> {
    #[serde(flatten)]
    place: WhiskerJson<'a>,
    was: Option<&'static str>,
    becomes: Option<&'static str>,
}

#[derive(Serialize)]
struct ContactLine<'a> {
    #[serde(flatten)]
    place: WhiskerJson<'a>,
    boot_id: Option<&'a str>,
    seq: Option<u64>,
    position: usize,
    t_us: Option<u64>,
    used: &'static str,
    residual: Option<f64>,
    length_mm: f64,
    length_sd_mm: f64,
}

#[derive(Serialize)]
struct TrimLine<'a> {
    trim: u32,
    #[serde(flatten)]
    place: WhiskerJson<'a>,
    length_before_mm: f64,
    length_after_mm: f64,
    length_after_sd_mm: f64,
    contacts_to_detect: u32,
}

#[derive(Serialize)]
struct DecisionLine<'a> {
    compensation: u32,
    #[serde(flatten)]
    target: WhiskerJson<'a>,
    target_length_mm: f64,
    target_pressure_mpa: f64,
    candidates: Vec<CandidateLine>,
}

#[derive(Serialize)]
struct CandidateLine {
    whisker: Option<u16>,
    compensation_case: &'static str,
    length_mm: f64,
    length_sd_mm: f64,
    pressure_before_mpa: f64,
    pressure_mpa: Option<f64>,
    predicted_error: Option<f64>,
    predicted_error_low: Option<f64>,
    predicted_error_high: Option<f64>,
    predicted_error_by_ratio: Option<[f64; CONTACT_RATIOS.len()]>,
    gives_up_own_role: bool,
    chosen: bool,
    refused: Option<&'static str>,
}

#[derive(Serialize)]
struct SetpointLine<'a> {
    epoch: u64,
    version: u64,
    #[serde(flatten)]
    place: WhiskerJson<'a>,
    compensation: Option<u32>,
    robot_boot_id: &'a str,
    pressure_mpa: f64,
    slew_mpa_per_s: f64,
    issued_us: u64,
    expires_us: u64,
    reason: &'static str,
    gain: Option<Vec<(f64, f64)>>,
}

#[derive(Serialize)]
struct ResponseLine {
    compensation: u32,
    t_us: Option<u64>,
    ratio: f64,
    deflection_mm: f64,
    after_strain: f64,
    before_strain: f64,
    before_origin: &'static str,
    target_strain: f64,
    target_origin: &'static str,
}

/// `None` for an effect on a whisker that the robot does not have, which no step produces.
fn json_form<'a>(
    effect: &'a Effect,
    source: Option<&'a protocol::Contacts>,
    robot: Option<&'a Robot>,
) -> Option<Told<'a>> {
    let robot = robot?;
    let place =
        |index: usize| robot.whisker(index).map(|view| WhiskerJson { array: view.array, whisker: view.sheet.number });
    Some(match effect {
        Effect::Contact(contact) => Told::Contact(contact_line(contact, place(contact.whisker)?, source)),
        Effect::UnknownWhisker { position } => Told::UnknownWhisker { position: *position },
        Effect::BadTime { position } => Told::BadTime { position: *position },
        Effect::Condition { whisker, from, to } => {
            Told::Condition(Change { place: place(*whisker)?, was: Some(from.word()), becomes: Some(to.word()) })
        }
        Effect::Fault { whisker, from, to } => {
            Told::Fault(Change { place: place(*whisker)?, was: from.map(Word::word), becomes: to.map(Word::word) })
        }
        Effect::Trim(trim) => Told::Trim(trim_line(trim, place(trim.whisker)?)),
        Effect::Decided(decision) => Told::Decision(decision_line(decision, place(decision.target)?, robot)),
        Effect::Ended { compensation, reason, .. } => {
            Told::Ended { compensation: *compensation, end_reason: reason.word() }
        }
        Effect::Command(command) => Told::Setpoint(setpoint_line(command, place(command.whisker)?)),
        Effect::Resend(command) => Told::SetpointAgain(setpoint_line(command, place(command.whisker)?)),
        Effect::CommandState { command: CommandKey { epoch, version }, state, rejection, pressure, .. } => {
            Told::SetpointState {
                epoch: *epoch,
                version: *version,
                state: state.word(),
                error: rejection.map(Word::word),
                pressure_mpa: pressure.map(Megapascal::mpa),
            }
        }
        Effect::Response(response) => Told::Response(response_line(response, source)),
        Effect::Error(error) => Told::Error(error_line(error)),
        Effect::Refined(look) => Told::Refinement(refinement_line(look)),
        Effect::Alarm { whisker, kind } => Told::Alarm { place: place(*whisker)?, kind: kind.word() },
        Effect::Approved { compensation } => Told::Approved { compensation: *compensation },
        Effect::AlarmCleared { whisker, kind } => Told::AlarmCleared { place: place(*whisker)?, kind: kind.word() },
        Effect::RobotAlarm { kind } => Told::RobotAlarm { kind: kind.word() },
        Effect::RobotAlarmCleared { kind } => Told::RobotAlarmCleared { kind: kind.word() },
        Effect::Gone { array, number, alarms } => Told::Gone {
            place: WhiskerJson { array, whisker: *number },
            alarms: alarms.iter().map(|kind| kind.word()).collect(),
        },
        Effect::MissedTouch { whisker } => Told::MissedTouch { place: place(*whisker)? },
        Effect::Test(test) => Told::TouchTest {
            place: place(test.whisker)?,
            epoch: test.key.epoch,
            version: test.key.version,
            kind: test.kind.word(),
            reason: test.reason.word(),
            contacts: test.contacts,
        },
        Effect::TestProposed(test) => Told::TestProposed {
            place: place(test.whisker)?,
            epoch: test.key.epoch,
            version: test.key.version,
            kind: test.kind.word(),
            reason: test.reason.word(),
            contacts: test.contacts,
        },
        Effect::TestState { test: CommandKey { epoch, version }, state, rejection, .. } => {
            Told::TestState { epoch: *epoch, version: *version, state: state.word(), error: rejection.map(Word::word) }
        }
        Effect::AskForFactsheet => Told::Request { request: protocol::RequestKind::Factsheet.as_str() },
    })
}

fn felt_at(source: Option<&protocol::Contacts>, position: usize) -> Option<u64> {
    source?.contacts.get(position).map(|contact| contact.t_us)
}

fn contact_line<'a>(
    contact: &ContactRecord,
    place: WhiskerJson<'a>,
    source: Option<&'a protocol::Contacts>,
) -> ContactLine<'a> {
    ContactLine {
        place,
        boot_id: source.map(|source| source.boot_id.as_str()),
        seq: source.map(|source| source.seq),
        position: contact.position,
        t_us: felt_at(source, contact.position),
        used: contact.used.word(),
        residual: contact.residual,
        length_mm: contact.length.length.mm(),
        length_sd_mm: contact.length.sd_mm,
    }
}

fn trim_line<'a>(trim: &Trim, place: WhiskerJson<'a>) -> TrimLine<'a> {
    TrimLine {
        trim: trim.id,
        place,
        length_before_mm: trim.length_before.mm(),
        length_after_mm: trim.length_after.length.mm(),
        length_after_sd_mm: trim.length_after.sd_mm,
        contacts_to_detect: trim.contacts_to_detect,
    }
}

fn decision_line<'a>(decision: &Decision, target: WhiskerJson<'a>, robot: &Robot) -> DecisionLine<'a> {
    let line = |(at, one): (usize, &CandidateRecord)| CandidateLine {
        whisker: robot.whisker(one.whisker).map(|view| view.sheet.number),
        compensation_case: one.case.word(),
        length_mm: one.length.length.mm(),
        length_sd_mm: one.length.sd_mm,
        pressure_before_mpa: one.pressure_before.mpa(),
        pressure_mpa: one.pressure.map(Megapascal::mpa),
        predicted_error: one.predicted_error,
        predicted_error_low: one.predicted_error_interval.map(|(low, _)| low),
        predicted_error_high: one.predicted_error_interval.map(|(_, high)| high),
        predicted_error_by_ratio: one.predicted_error_by_ratio,
        gives_up_own_role: one.gives_up_own_role,
        chosen: decision.chosen == Some(at),
        refused: one.refused.map(Word::word),
    };
    DecisionLine {
        compensation: decision.compensation,
        target,
        target_length_mm: decision.target_length.mm(),
        target_pressure_mpa: decision.target_pressure.mpa(),
        candidates: decision.candidates.iter().enumerate().map(line).collect(),
    }
}

fn setpoint_line<'a>(command: &'a Command, place: WhiskerJson<'a>) -> SetpointLine<'a> {
    SetpointLine {
        epoch: command.key.epoch,
        version: command.key.version,
        place,
        compensation: command.compensation,
        robot_boot_id: &command.robot_boot_id,
        pressure_mpa: command.pressure.mpa(),
        slew_mpa_per_s: command.slew_mpa_per_s,
        issued_us: command.issued.0,
        expires_us: command.expires.0,
        reason: command.reason.word(),
        gain: command.gain.map(|gain| CONTACT_RATIOS.into_iter().zip(gain).collect()),
    }
}

fn response_line(response: &Response, source: Option<&protocol::Contacts>) -> ResponseLine {
    ResponseLine {
        compensation: response.compensation,
        t_us: felt_at(source, response.position),
        ratio: response.ratio.a(),
        deflection_mm: response.deflection.mm(),
        after_strain: response.after.ratio(),
        before_strain: response.before,
        before_origin: response.before_origin.word(),
        target_strain: response.target,
        target_origin: response.target_origin.word(),
    }
}
