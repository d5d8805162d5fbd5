//! Conversion of the core's effects into rows and publications.

use vibrissa_core::robot::effect::{CommandState, Condition, Effect, TestState};
use vibrissa_core::robot::event::Rejection;
use vibrissa_core::units::{ContactRatio, Megapascal, Micros};
use vibrissa_protocol::{self as protocol, RobotTopic};

use super::log;
use super::publication::Sent;
use super::rows::{decision_row, error_row, refinement_row, response_time, setpoint_row};
use super::stepper::Stepper;
use super::touch_tests::{is_over, progress_row, proposed_test_row, test_row};
use crate::engine::commit::batch::Source;
use crate::engine::robot::KnownRobot;
use crate::metrics::{APPROVED, NO_CASE, PROPOSED, STARTED, UNSERVED};
use vibrissa_edge::ids::{command_id, wide_id};
use vibrissa_edge::words::Word;
use vibrissa_store::batch::{
    AlarmClearedRow, AlarmRow, ContactRow, EndedRow, HealthRow, Record, ResponseRow, RobotAlarmClearedRow,
    RobotAlarmRow, SetpointStateRow, TouchTestProgressRow, TrimRow,
};

impl Stepper {
    /// Adds one effect to the batch or to the publications.
    pub(super) fn record(&mut self, known: &mut KnownRobot, now: Micros, effect: Effect, source: Option<Source<'_>>) {
        if !self.admit(known, now, &effect) {
            return;
        }
        log::effect(known, &effect);
        self.tell(known, now, &effect, source);
        let robot_id = known.robot_id;
        let recorded_us = now.0 as i64;
        let name = known.name.clone();
        let whisker_id = |index: usize| known.whisker_id(index);
        match effect {
            Effect::Contact(contact) => {
                self.metrics.contacts.count([contact.used.word()]);
                let Some((source, sent)) =
                    source.and_then(|source| Some((source, source.message.contacts.get(contact.position)?)))
                else {
                    return;
                };
                let row = ContactRow {
                    whisker_id: whisker_id(contact.whisker),
                    boot: source.boot,
                    seq: source.message.seq as i64,
                    position: contact.position as i64,
                    t_us: sent.t_us as i64,
                    received_us: recorded_us,
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
                };
                known.estimates.contact(contact.whisker, &contact.length);
                known.history.add_contact(contact.whisker, contact.used, row, self.batch.rows_mut());
            }
            Effect::UnknownWhisker { position } => {
                let problem = format!("contacts[{position}] names a whisker that is not in the factsheet");
                self.refuse(known, (RobotTopic::Contacts, "unknown_whisker"), &problem, now);
                self.metrics.contacts_refused.inc();
            }
            Effect::BadTime { position } => {
                self.metrics.contacts_bad_time.inc();
                let problem = format!(
                    "the time of contact {position} is far from the robot's clock; the contact is recorded, its time \
                     is not used"
                );
                self.warn_seldom("bad_time", &problem, &name);
            }
            Effect::Condition { whisker, from, to } => {
                self.batch.rows_mut().records.push(Record::Health(HealthRow {
                    whisker_id: whisker_id(whisker),
                    recorded_us,
                    kind: "CONDITION",
                    was: Some(from.word()),
                    becomes: Some(to.word()),
                }));
                known.history.keep_recent(whisker, self.batch.rows_mut());
                if to == Condition::Learning {
                    let id = known.whisker_id(whisker);
                    known.maintenance.replaced(id);
                }
            }
            Effect::Fault { whisker, from, to } => {
                self.batch.rows_mut().records.push(Record::Health(HealthRow {
                    whisker_id: whisker_id(whisker),
                    recorded_us,
                    kind: "FAULT",
                    was: from.map(Word::word),
                    becomes: to.map(Word::word),
                }));
                known.history.keep_recent(whisker, self.batch.rows_mut());
                if let Some(fault) = to {
                    Self::keep_event(known, fault.word(), whisker, now);
                }
            }
            Effect::Trim(trim) => {
                self.metrics.trims.inc();
                self.metrics.trim_detection_contacts.observe(f64::from(trim.contacts_to_detect));
                self.batch.rows_mut().records.push(Record::Trim(TrimRow {
                    trim_id: wide_id(robot_id, trim.id),
                    robot_id,
                    whisker_id: whisker_id(trim.whisker),
                    detected_us: recorded_us,
                    length_before_mm: trim.length_before.mm(),
                    length_after_mm: trim.length_after.length.mm(),
                    length_after_sd_mm: trim.length_after.sd_mm,
                    contacts_to_detect: i64::from(trim.contacts_to_detect),
                    pressure_mpa: known
                        .robot
                        .whisker(trim.whisker)
                        .and_then(|whisker| whisker.pressure)
                        .map(Megapascal::mpa),
                }));
                known.history.keep_recent(trim.whisker, self.batch.rows_mut());
                Self::keep_event(known, "TRIM", trim.whisker, now);
            }
            Effect::Decided(decision) => {
                let row = decision_row(robot_id, recorded_us, &decision, whisker_id);
                self.metrics.compensations.count(match row.candidates.iter().find(|one| one.chosen) {
                    None => [NO_CASE, UNSERVED],
                    Some(one) if decision.proposed => [one.case, PROPOSED],
                    Some(one) => [one.case, STARTED],
                });
                self.batch.rows_mut().records.push(Record::Decision(Box::new(row)));
                for whisker in decision.candidates.iter().map(|one| one.whisker).chain([decision.target]) {
                    known.history.keep_recent(whisker, self.batch.rows_mut());
                }
            }
            Effect::Ended { compensation, case, reason, .. } => {
                self.metrics.compensations.count([case.word(), reason.word()]);
                self.batch.rows_mut().records.push(Record::Ended(EndedRow {
                    compensation_id: wide_id(robot_id, compensation),
                    ended_us: recorded_us,
                    end_reason: reason.word(),
                }));
            }
            Effect::Command(command) => {
                self.metrics.setpoints.count([CommandState::Pending.word()]);
                let row = setpoint_row(robot_id, &self.fleet, &name, &command, whisker_id(command.whisker));
                self.batch.rows_mut().records.push(Record::Setpoint(Box::new(row)));
                self.publish_setpoint(known, &command, Sent::First);
            }
            Effect::Resend(command) => self.publish_setpoint(known, &command, Sent::Again),
            Effect::CommandState { command, state, rejection, pressure, .. } => {
                // A task is no failure: alerts count the states.
                if rejection != Some(Rejection::InTask) {
                    self.metrics.setpoints.count([state.word()]);
                }
                if let Some(rejection) = rejection {
                    self.metrics.setpoints_rejected.count([rejection.word()]);
                }
                if state == CommandState::Applied {
                    self.observe_application(command);
                }
                self.batch.rows_mut().records.push(Record::SetpointState(SetpointStateRow {
                    command_id: command_id(&self.fleet, &name, command),
                    robot_id,
                    recorded_us,
                    state: state.word(),
                    error: rejection.map(Word::word),
                    pressure_mpa: pressure.map(Megapascal::mpa),
                }));
            }
            Effect::Response(response) => {
                let t_us = source
                    .and_then(|source| source.message.contacts.get(response.position))
                    .map_or(0, |sent| sent.t_us);
                let ahead_us = known.robot.clock_ahead_us(now);
                self.batch.rows_mut().responses.push(ResponseRow {
                    compensation_id: wide_id(robot_id, response.compensation),
                    t_us: response_time(t_us as i64, ahead_us, recorded_us),
                    ratio: response.ratio.a(),
                    deflection_mm: response.deflection.mm(),
                    after_strain: response.after.ratio(),
                    before_strain: response.before,
                    before_origin: response.before_origin.word(),
                    target_strain: response.target,
                    target_origin: response.target_origin.word(),
                });
                known.history.keep_last(self.batch.rows_mut());
            }
            Effect::Error(error) => {
                known.errors.measured(&error);
                if let Some(target) = known.target_of(error.compensation) {
                    let target = (target, known.whisker_id(target));
                    known.history.add_error(target, now, error.mean, self.batch.rows_mut());
                }
                if let Some(case) = known.case_of(error.compensation) {
                    self.metrics.compensation_error_ratio.of(case.word()).observe(error.mean);
                }
                self.batch.rows_mut().records.push(Record::Error(Box::new(error_row(robot_id, recorded_us, &error))));
            }
            Effect::Refined(refinement) => {
                let row = refinement_row(robot_id, recorded_us, &refinement);
                self.metrics.refinements.count([row.outcome]);
                self.batch.rows_mut().records.push(Record::Refinement(Box::new(row)));
            }
            Effect::Alarm { whisker, kind } => {
                self.metrics.alarms_raised.count([kind.word()]);
                self.batch.rows_mut().records.push(Record::Alarm(AlarmRow {
                    whisker_id: whisker_id(whisker),
                    raised_us: recorded_us,
                    kind: kind.word(),
                }));
                Self::keep_event(known, kind.word(), whisker, now);
            }
            Effect::RobotAlarm { kind } => {
                self.metrics.alarms_raised.count([kind.word()]);
                let row = RobotAlarmRow { robot_id, raised_us: recorded_us, kind: kind.word() };
                self.batch.rows_mut().records.push(Record::RobotAlarm(row));
            }
            Effect::RobotAlarmCleared { kind } => {
                let row = RobotAlarmClearedRow { robot_id, cleared_us: recorded_us, kind: kind.word() };
                self.batch.rows_mut().records.push(Record::RobotAlarmCleared(row));
            }
            Effect::Approved { compensation } => {
                if let Some(case) = known.case_of(compensation) {
                    self.metrics.compensations.count([case.word(), APPROVED]);
                }
                self.batch
                    .rows_mut()
                    .records
                    .push(Record::Approved { compensation_id: wide_id(robot_id, compensation) })
            }
            Effect::AlarmCleared { whisker, kind } => {
                self.batch.rows_mut().records.push(Record::AlarmCleared(AlarmClearedRow {
                    whisker_id: whisker_id(whisker),
                    cleared_us: recorded_us,
                    kind: kind.word(),
                }));
            }
            Effect::Gone { array, number, .. } => {
                let whisker = i64::from(number);
                self.batch.rows_mut().records.push(Record::Gone { robot_id, array, whisker, cleared_us: recorded_us });
            }
            Effect::MissedTouch { .. } => self.metrics.missed_touches.inc(),
            Effect::Test(test) => {
                self.metrics.touch_tests.count([TestState::Pending.word()]);
                self.metrics.touch_tests_begun.count([test.reason.word()]);
                let row = test_row(robot_id, &self.fleet, &name, &test, whisker_id(test.whisker));
                self.batch.rows_mut().records.push(Record::TouchTest(Box::new(row)));
                self.publish_test(known, &test);
            }
            Effect::TestProposed(test) => {
                self.metrics.touch_tests.count([TestState::Proposed.word()]);
                self.metrics.touch_tests_begun.count([test.reason.word()]);
                let ids = (robot_id, whisker_id(test.whisker));
                let row = proposed_test_row(ids, recorded_us, &self.fleet, &name, &test);
                self.batch.rows_mut().records.push(Record::TouchTest(Box::new(row)));
            }
            Effect::TestState { test, whisker, state, rejection } => {
                self.metrics.touch_tests.count([state.word()]);
                let error = rejection.map(Word::word);
                let length = whisker.and_then(|whisker| known.robot.whisker(whisker)).map(|view| view.length);
                let length = length.filter(|_| state == TestState::Done);
                if let Some(whisker) = whisker.filter(|_| state == TestState::Done && self.publishes_maintenance) {
                    let id = known.whisker_id(whisker);
                    known.maintenance.tested(id, recorded_us);
                }
                self.batch.rows_mut().records.push(Record::TouchTestProgress(Box::new(TouchTestProgressRow {
                    state: Some(state.word()),
                    error,
                    ended_us: is_over(state).then_some(recorded_us),
                    length_mm: length.map(|length| length.length.mm()),
                    length_sd_mm: length.map(|length| length.sd_mm),
                    ..progress_row(robot_id, command_id(&self.fleet, &name, test), recorded_us)
                })));
            }
            Effect::AskForFactsheet => {
                self.publish_request(&known.name, &mut known.seqs, protocol::RequestKind::Factsheet);
            }
        }
    }
}
