//! Conversion of the core's effects into rows and publications.

use tracing::{info, warn};
use vibrissa_core::robot::effect::{Command, CommandState, CompensationError, Decision, Effect, ErrorBin, Refinement};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Name};

use super::commit::batch::{Gathering, Source};
use super::mpa;
use super::publication::Sent;
use super::shard::Known;
use crate::metrics::{APPROVED, NO_CASE, PROPOSED, STARTED, UNSERVED};
use vibrissa_edge::ids::{command_id, wide_id};
use vibrissa_edge::words::{Word, Z95};
use vibrissa_store::batch::{
    AlarmClearedRow, AlarmRow, CandidateRow, ContactRow, DecisionRow, EndedRow, ErrorBinRow, ErrorRow, HealthRow,
    Interval, Record, RefinementRow, ResponseRow, SetpointRow, SetpointStateRow, TrimRow,
};

impl Gathering {
    /// Adds one effect to the batch or to the publications.
    pub(super) fn record(&mut self, known: &mut Known, now: Micros, effect: Effect, source: Option<Source<'_>>) {
        let robot_id = known.robot_id;
        let recorded_us = now.0 as i64;
        let name = known.name.clone();
        let whisker_id = |index: usize| known.whisker_id(index);
        match effect {
            Effect::Contact(contact) => {
                self.metrics.contacts.count([contact.used.word()]);
                let Some((source, felt)) =
                    source.and_then(|source| Some((source, source.told.contacts.get(contact.position)?)))
                else {
                    return;
                };
                let row = ContactRow {
                    whisker_id: whisker_id(contact.whisker),
                    boot: source.boot,
                    seq: source.told.seq as i64,
                    position: contact.position as i64,
                    t_us: felt.t_us as i64,
                    received_us: recorded_us,
                    ratio: felt.ratio,
                    deflection_mm: felt.deflection_mm,
                    strain: felt.strain,
                    pressure_mpa: felt.pressure_mpa,
                    temperature_c: felt.temperature_c,
                    used: contact.used.word(),
                    residual: contact.residual,
                    length_mm: contact.length.length.mm(),
                    length_sd_mm: contact.length.sd_mm,
                };
                known.history.felt(contact.whisker, contact.used, row, &mut self.batch);
            }
            Effect::UnknownWhisker { position } => {
                self.metrics.refuse(
                    "unknown_whisker",
                    format!("contact {position} names a whisker that is not in the factsheet"),
                    name.as_str(),
                );
            }
            Effect::BadTime { position } => {
                let problem = format!("contact {position} has an implausible time");
                self.suspect("bad_time", &problem, &name);
            }
            Effect::Condition { whisker, from, to } => {
                self.batch.records.push(Record::Health(HealthRow {
                    whisker_id: whisker_id(whisker),
                    recorded_us,
                    kind: "CONDITION",
                    was: Some(from.word()),
                    becomes: Some(to.word()),
                }));
                known.history.decided(whisker, &mut self.batch);
            }
            Effect::Fault { whisker, from, to } => {
                self.batch.records.push(Record::Health(HealthRow {
                    whisker_id: whisker_id(whisker),
                    recorded_us,
                    kind: "FAULT",
                    was: from.map(Word::word),
                    becomes: to.map(Word::word),
                }));
                known.history.decided(whisker, &mut self.batch);
            }
            Effect::Trim(trim) => {
                self.metrics.trims.inc();
                self.metrics.trim_detection_contacts.observe(f64::from(trim.contacts_to_detect));
                info!(robot = %name, whisker = trim.whisker, length_mm = trim.length_after.length.mm(), "trim found");
                self.batch.records.push(Record::Trim(TrimRow {
                    trim_id: wide_id(robot_id, trim.id),
                    robot_id,
                    whisker_id: whisker_id(trim.whisker),
                    detected_us: recorded_us,
                    length_before_mm: trim.length_before.mm(),
                    length_after_mm: trim.length_after.length.mm(),
                    length_after_sd_mm: trim.length_after.sd_mm,
                    contacts_to_detect: i64::from(trim.contacts_to_detect),
                }));
                known.history.decided(trim.whisker, &mut self.batch);
            }
            Effect::Decided(decision) => {
                let row = decision_row(robot_id, recorded_us, &decision, whisker_id);
                self.metrics.compensations.count(match row.candidates.iter().find(|one| one.chosen) {
                    None => [NO_CASE, UNSERVED],
                    Some(one) if decision.proposed => [one.case, PROPOSED],
                    Some(one) => [one.case, STARTED],
                });
                self.batch.records.push(Record::Decision(Box::new(row)));
                for whisker in decision.candidates.iter().map(|one| one.whisker).chain([decision.target]) {
                    known.history.decided(whisker, &mut self.batch);
                }
            }
            Effect::Ended { compensation, case, reason } => {
                self.metrics.compensations.count([case.word(), reason.word()]);
                self.batch.records.push(Record::Ended(EndedRow {
                    compensation_id: wide_id(robot_id, compensation),
                    ended_us: recorded_us,
                    end_reason: reason.word(),
                }));
            }
            Effect::Command(command) => {
                self.metrics.setpoints.count([CommandState::Pending.word()]);
                let row = setpoint_row(robot_id, &self.fleet, &name, &command, whisker_id(command.whisker));
                self.batch.records.push(Record::Setpoint(Box::new(row)));
                self.publish_setpoint(known, &command, Sent::First);
            }
            Effect::Resend(command) => self.publish_setpoint(known, &command, Sent::Again),
            Effect::CommandState { command, state, rejection, pressure } => {
                self.metrics.setpoints.count([state.word()]);
                if let Some(rejection) = rejection {
                    self.metrics.setpoints_rejected.count([rejection.word()]);
                }
                if state == CommandState::Applied {
                    self.time_applied(command);
                }
                self.batch.records.push(Record::SetpointState(SetpointStateRow {
                    command_id: command_id(&self.fleet, &name, command),
                    robot_id,
                    recorded_us,
                    state: state.word(),
                    error: rejection.map(Word::word),
                    pressure_mpa: mpa(pressure),
                }));
            }
            Effect::Response(response) => {
                let t_us =
                    source.and_then(|source| source.told.contacts.get(response.position)).map_or(0, |felt| felt.t_us);
                self.batch.responses.push(ResponseRow {
                    compensation_id: wide_id(robot_id, response.compensation),
                    t_us: t_us as i64,
                    ratio: response.ratio.a(),
                    deflection_mm: response.deflection.mm(),
                    after_strain: response.after.ratio(),
                    before_strain: response.before,
                    before_origin: response.before_origin.word(),
                    target_strain: response.target,
                    target_origin: response.target_origin.word(),
                });
                known.history.serves(&mut self.batch);
            }
            Effect::Error(error) => {
                known.stated.state(&error);
                if let Some(target) = known.target_of(error.compensation) {
                    let target = (target, known.whisker_id(target));
                    known.history.stated(target, now, error.mean, &mut self.batch);
                }
                if let Some(case) = known.case_of(error.compensation) {
                    self.metrics.compensation_error_ratio.of(case.word()).observe(error.mean);
                }
                self.batch.records.push(Record::Error(Box::new(error_row(robot_id, recorded_us, &error))));
            }
            Effect::Refined(look) => {
                let row = refinement_row(robot_id, recorded_us, &look);
                self.metrics.refinements.count([row.outcome]);
                info!(robot = %name, outcome = row.outcome, error = look.error, "setpoint reviewed");
                self.batch.records.push(Record::Refinement(Box::new(row)));
            }
            Effect::Alarm { whisker, kind } => {
                self.metrics.alarms_raised.count([kind.word()]);
                warn!(robot = %name, whisker, alarm = kind.word(), "alarm raised");
                self.batch.records.push(Record::Alarm(AlarmRow {
                    whisker_id: whisker_id(whisker),
                    raised_us: recorded_us,
                    kind: kind.word(),
                }));
            }
            Effect::Approved { compensation } => {
                if let Some(case) = known.case_of(compensation) {
                    self.metrics.compensations.count([case.word(), APPROVED]);
                }
                self.batch.records.push(Record::Approved { compensation_id: wide_id(robot_id, compensation) })
            }
            Effect::AlarmCleared { whisker, kind } => {
                info!(robot = %name, whisker, alarm = kind.word(), "alarm cleared");
                self.batch.records.push(Record::AlarmCleared(AlarmClearedRow {
                    whisker_id: whisker_id(whisker),
                    cleared_us: recorded_us,
                    kind: kind.word(),
                }));
            }
            Effect::Gone { array, number, .. } => {
                let whisker = i64::from(number);
                self.batch.records.push(Record::Gone { robot_id, array, whisker, cleared_us: recorded_us });
            }
            Effect::AskForFactsheet => {
                self.publish_request(&known.name, &mut known.seqs, protocol::RequestKind::Factsheet);
            }
        }
    }
}

fn decision_row(robot_id: i64, decided_us: i64, decision: &Decision, whisker_id: impl Fn(usize) -> i64) -> DecisionRow {
    let candidates = decision.candidates.iter().enumerate().map(|(at, one)| CandidateRow {
        whisker_id: whisker_id(one.whisker),
        case: one.case.word(),
        length_mm: one.length.length.mm(),
        length_sd_mm: one.length.sd_mm,
        pressure_before_mpa: one.pressure_before.mpa(),
        pressure_mpa: mpa(one.pressure),
        predicted_error: one.predicted_error,
        predicted_error_interval: one.predicted_error_interval,
        predicted_error_by_ratio: one
            .predicted_error_by_ratio
            .and_then(|by_ratio| serde_json::to_string(&by_ratio).ok()),
        gives_up_own_role: one.gives_up_own_role,
        chosen: decision.chosen == Some(at),
        refused: one.refused.map(Word::word),
    });
    DecisionRow {
        compensation_id: wide_id(robot_id, decision.compensation),
        robot_id,
        target_whisker_id: whisker_id(decision.target),
        target_length_mm: decision.target_length.mm(),
        target_pressure_mpa: decision.target_pressure.mpa(),
        decided_us,
        approval: if decision.proposed { "PROPOSED" } else { "AUTOMATIC" },
        candidates: candidates.collect(),
    }
}

fn setpoint_row(robot_id: i64, fleet: &Name, robot: &Name, command: &Command, whisker_id: i64) -> SetpointRow {
    SetpointRow {
        command_id: command_id(fleet, robot, command.key),
        robot_id,
        whisker_id,
        compensation_id: command.compensation.map(|number| wide_id(robot_id, number)),
        epoch: command.key.epoch as i64,
        version: command.key.version as i64,
        robot_boot_id: command.robot_boot_id.clone(),
        pressure_mpa: command.pressure.mpa(),
        slew_mpa_per_s: command.slew_mpa_per_s,
        issued_us: command.issued.0 as i64,
        expires_us: command.expires.0 as i64,
        reason: command.reason.word(),
        gain: serde_json::to_string(&super::publication::gain(command)).ok(),
    }
}

fn error_row(robot_id: i64, recorded_us: i64, error: &CompensationError) -> ErrorRow {
    let bin_row = |bin: &ErrorBin| ErrorBinRow {
        ratio: bin.ratio,
        contacts: i64::from(bin.contacts),
        after_per_mm: bin.after_per_mm,
        before_per_mm: bin.before_per_mm,
        before_origin: bin.before_origin.word(),
        target_per_mm: bin.target_per_mm,
        target_origin: bin.target_origin.word(),
        error: interval(bin.error, bin.sd),
    };
    ErrorRow {
        compensation_id: wide_id(robot_id, error.compensation),
        recorded_us,
        contacts: i64::from(error.contacts),
        pressure_mpa: error.pressure.mpa(),
        error: interval(error.mean, error.sd),
        with_gain: error.with_gain.map(|(mean, sd)| interval(mean, sd)),
        bins: error.bins.iter().map(bin_row).collect(),
    }
}

fn refinement_row(robot_id: i64, recorded_us: i64, look: &Refinement) -> RefinementRow {
    RefinementRow {
        compensation_id: wide_id(robot_id, look.compensation),
        recorded_us,
        contacts: i64::from(look.contacts),
        outcome: look.outcome.word(),
        pressure_from_mpa: look.pressure_from.mpa(),
        pressure_best_mpa: mpa(look.pressure_best),
        error: interval(look.error, look.error_sd),
        error_best: look.error_best.map(|(mean, sd)| interval(mean, sd)),
        error_with_gain: look.error_with_gain,
        error_with_own_gain: look.error_with_own_gain,
        gain_published: look.gain_published,
    }
}

fn interval(mean: f64, sd: f64) -> Interval {
    Interval { mean, low: (mean - Z95 * sd).max(0.0), high: mean + Z95 * sd }
}
