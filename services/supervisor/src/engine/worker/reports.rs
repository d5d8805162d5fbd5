//! Reports of a known robot: factsheet, status, contacts and setpoint states become events of the core.

use std::fmt::Display;

use tokio::time::Instant;
use tracing::{debug, warn};
use vibrissa_core::robot::effect::CommandKey;
use vibrissa_core::robot::event::Factsheet;
use vibrissa_core::robot::{Admission, Event, Outcome, Sequence};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Refusal, RobotTopic};

use super::stepper::{AnsweredSetpoint, Stepper};
use crate::engine::commit::batch::Source;
use crate::engine::commit::committer::Committer;
use crate::engine::ledger;
use crate::engine::message::MessageTimes;
use crate::engine::robot::commands::Plausibility;
use crate::engine::robot::{KnownRobot, fingerprints};
use vibrissa_edge::ids::command_id;
use vibrissa_edge::invariants::{Invariant, is_new};
use vibrissa_edge::{self as edge, EdgeError};
use vibrissa_store::StoreError;
use vibrissa_store::batch::LayoutRow;
use vibrissa_store::fault::{self, Fault};

pub(super) const OLD_FACTSHEET: &str = "a factsheet of a boot that a newer one has replaced";

impl Stepper {
    /// Parses a factsheet.
    pub(super) fn factsheet(&self, message: &protocol::Factsheet) -> Result<Factsheet, EdgeError> {
        let models: Vec<&str> = self.params.models.iter().map(|(name, _)| name.as_str()).collect();
        edge::factsheet(message, &models)
    }

    pub(super) async fn take_factsheet(
        &mut self,
        known: &mut KnownRobot,
        (message, is_again): (&protocol::Factsheet, bool),
        now: Micros,
        committer: &mut Committer,
    ) -> Result<(), StoreError> {
        // [`Worker::factsheet`](super::Worker::factsheet) has refused others.
        let Ok(factsheet) = self.factsheet(message) else { return Ok(()) };
        let boot_id = message.boot_id.as_str();
        if known.boots.is_old(boot_id) {
            self.violation("old_boot", OLD_FACTSHEET, &known.name);
            return Ok(());
        }
        // One of a boot that was not announced or not accepted. It gets no row ids, because numbers must increase with
        // newer boots.
        if known.robot.connection_state().0 != Some(boot_id) {
            self.has_unannounced |= known.refused_boot.is_none();
            return Ok(());
        }
        let is_numbered = known.is_laid_out(&factsheet);
        if !is_numbered && !is_again && !self.admits_layout(known, &factsheet, now) {
            return Ok(());
        }
        let (writer, lease) = committer.database();
        if known.boots.get(boot_id).is_none() {
            let boot = writer.boot(lease, known.robot_id, boot_id, now.0 as i64).await?;
            if known.boots.newest().is_some_and(|newest| newest > boot) {
                self.violation("old_boot", OLD_FACTSHEET, &known.name);
                return Ok(());
            }
            known.boots.insert(boot_id, boot);
        }
        if !is_numbered {
            // Row ids are assigned using a copy, so that an unreachable database changes nothing.
            let mut laid_out = known.robot.clone();
            laid_out.step(
                self.params_of(&known.name),
                now,
                &Event::Factsheet { boot_id, factsheet: &factsheet },
                &mut Vec::new(),
            );
            let whiskers = writer.whisker_ids(lease, known.robot_id, &laid_out).await?;
            let ids: Vec<i64> = whiskers.iter().map(|(whisker_id, _)| *whisker_id).collect();
            if ids != known.whisker_ids {
                let gone = known.history.laid_out(&known.whisker_ids, &whiskers, now, self.batch.rows_mut());
                known.told.keep_only(&ids);
                known.whisker_ids = ids;
                self.batch.count_layout(known.whisker_ids.len());
                self.batch.rows_mut().layouts.push(LayoutRow {
                    robot_id: known.robot_id,
                    model: message.model.clone(),
                    gone,
                });
            }
        }
        self.step_factsheet(known, (message, &factsheet), now);
        Ok(())
    }

    /// Steps a factsheet whose whiskers have row ids, and keeps the names of the programs.
    pub(super) fn step_factsheet(
        &mut self,
        known: &mut KnownRobot,
        (message, factsheet): (&protocol::Factsheet, &Factsheet),
        now: Micros,
    ) {
        let event = Event::Factsheet { boot_id: message.boot_id.as_str(), factsheet };
        if self.step(known, now, &event, None) == Outcome::Taken {
            known.is_row_due |= known.told.take_software(&message.software);
        }
    }

    /// Charges a new layout to the accounts of the robot and its fleet. Returns false, and counts, if it is refused.
    pub(crate) fn admits_layout(&mut self, known: &mut KnownRobot, factsheet: &Factsheet, now: Micros) -> bool {
        let bytes = ledger::layout_cost(new_whiskers(known, factsheet));
        if !known.new_layouts.take(Instant::now()) {
            let problem = "too many new layouts: the last one stays in force until the limit allows another";
            self.refuse(known, (RobotTopic::Factsheet, "too_many_layouts"), &problem, now);
            return false;
        }
        let is_within =
            known.account.affords(ledger::ROBOT, now, bytes) && self.account.affords(ledger::FLEET, now, bytes);
        if !is_within {
            let problem = "too many new whiskers: the last layout stays in force until the budget allows another";
            self.refuse(known, (RobotTopic::Factsheet, "over_budget"), &problem, now);
            return false;
        }
        known.account.charge(ledger::ROBOT, now, bytes);
        self.account.charge(ledger::FLEET, now, bytes);
        true
    }

    /// Counts a refused message of a robot, or a refused entry of a message.
    pub(super) fn refuse(
        &self,
        known: &mut KnownRobot,
        (topic, reason): (RobotTopic, &'static str),
        problem: &dyn Display,
        now: Micros,
    ) {
        self.metrics.refuse(reason, problem, topic.as_str());
        known.refusals.count((topic, reason), problem, now);
    }

    /// Counts refused entries of a message.
    fn refuse_entries(&self, known: &mut KnownRobot, topic: RobotTopic, refused: &[Refusal], now: Micros) {
        for refusal in refused {
            self.refuse(known, (topic, refusal.label()), refusal, now);
        }
    }

    /// Entries of a message in the core's form. The contract's ranges are within the core's, so none is refused.
    fn converted<'m, T, U>(
        &self,
        known: &mut KnownRobot,
        (topic, entries): (RobotTopic, &'m [T]),
        now: Micros,
        convert: impl Fn(&'m T) -> Result<U, EdgeError>,
    ) -> Vec<U> {
        let mut converted = Vec::with_capacity(entries.len());
        for entry in entries {
            match convert(entry) {
                Ok(entry) => converted.push(entry),
                Err(problem) => self.refuse(known, (topic, problem.label()), &problem, now),
            }
        }
        converted
    }

    /// Handles a status. `refused` are the refusals of entries that it does not contain any more.
    pub(super) fn take_status(
        &mut self,
        known: &mut KnownRobot,
        message: &protocol::Status,
        refused: &[Refusal],
        now: Micros,
    ) {
        self.refuse_entries(known, RobotTopic::Status, refused, now);
        let whiskers = self.converted(known, (RobotTopic::Status, &message.whiskers[..]), now, edge::status);
        if whiskers.is_empty() && !refused.is_empty() {
            return;
        }
        let robot_time = if fault::is(Fault::LateStatusCounts) { now } else { Micros(message.t_us) };
        let boot_id = message.boot_id.as_str();
        let event = Event::Status { boot_id, robot_time, whiskers: &whiskers };
        let outcome = self.step(known, now, &event, None);
        self.has_unannounced |= outcome == Outcome::OldBoot && is_unannounced(known, boot_id);
        if outcome == Outcome::Taken {
            let KnownRobot { told, robot, whisker_ids, .. } = known;
            told.take_segmenters(&message.whiskers, |entry| {
                let index = robot.find(entry.array.as_str(), entry.whisker)?;
                whisker_ids.get(index).copied()
            });
        }
        if known.robot.has_wrong_time_unit() {
            let problem = "its times pass too slowly or too fast: is t_us in microseconds? No setpoint is sent";
            self.violation_of(known, (RobotTopic::Status, "time_unit"), problem, now);
        }
        if outcome == Outcome::BadTime {
            self.violation("bad_time", "a status with an implausible time", &known.name);
        }
    }

    /// Handles contacts, and the refusals of those that the message does not contain any more. `content` is their
    /// fingerprint; `None` for a refused message that is only receipted.
    pub(super) fn take_contacts(
        &mut self,
        known: &mut KnownRobot,
        (message, refused): (&protocol::Contacts, &[Refusal]),
        content: Option<u32>,
        now: Micros,
    ) {
        let contacts = self.converted(known, (RobotTopic::Contacts, &message.contacts[..]), now, edge::contact);
        let boot_id = message.boot_id.as_str();
        let missed = self.converted(known, (RobotTopic::Contacts, &message.missed[..]), now, edge::missed);
        let event = Event::Contacts { boot_id, seq: message.seq, contacts: &contacts, missed: &missed };
        let (given_up_before, end) = counted(known, boot_id);
        let numbers = known.robot.sequence(boot_id);
        let is_new = numbers.is_none_or(|numbers| is_new(message.seq, numbers.next(), numbers.held()));
        let source = Source { message, boot: known.boot(boot_id) };
        // The step may end a test.
        let progress = self.test_progress(known, message, now);
        match self.step(known, now, &event, Some(source)) {
            Outcome::NotYet(admission) => {
                self.has_unannounced |= is_unannounced(known, boot_id);
                let reason = match admission {
                    Admission::TooManyGaps => "too_many_gaps",
                    Admission::TwoRobots => "duplicate_robot",
                    Admission::UnknownBoot | Admission::New | Admission::Duplicate => "unknown_boot",
                };
                self.metrics.refuse(reason, "contacts that cannot be accepted yet", known.name.as_str());
                return;
            }
            Outcome::OldBoot => {
                self.violation("old_boot", "contacts of a boot that newer ones have replaced", &known.name);
                return;
            }
            Outcome::Duplicate => {
                self.metrics.messages_duplicate.inc();
                let boot = known.boot(boot_id);
                known.repeats.repeated(boot, message.seq, now);
                if content.is_some_and(|content| known.fingerprints.contradict(boot, message.seq, content)) {
                    let problem = "a contacts message with the seq of another one and different content";
                    self.violation("conflicting_duplicate", problem, &known.name);
                }
            }
            Outcome::Taken => {
                if !is_new {
                    let what = format!("message {} of boot {boot_id} is taken a second time", message.seq);
                    self.metrics.violations.count(Invariant::ContactOnce, &known.full_name(), &what);
                }
                self.record_progress(progress);
                self.refuse_entries(known, RobotTopic::Contacts, refused, now);
                self.metrics.contacts_refused.inc_by(refused.len() as u64);
                known.fingerprints.remember(known.boot(boot_id), message.seq, content.unwrap_or(fingerprints::REFUSED));
                if message.seq < end {
                    self.metrics.messages_resent.inc();
                }
                let newest_contact = message.contacts.last().map(|last| Micros(last.t_us));
                self.batch.push_times(MessageTimes { newest_contact, received: now });
            }
            Outcome::BadTime | Outcome::Refused(_) => {}
        }
        let given_up = counted(known, boot_id).0 - given_up_before;
        if given_up > 0 {
            warn!(robot = %known.full_name(), messages = given_up, "contacts lost, the robot has not sent them again");
            self.metrics.messages_given_up.inc_by(given_up);
        }
        self.receipt(known, boot_id);
    }

    /// Handles the state of a touch test. One of a test that is over, or of an earlier supervisor, changes nothing.
    pub(super) fn take_test_state(&mut self, known: &mut KnownRobot, message: &protocol::TestState, now: Micros) {
        let boot_id = message.boot_id.as_str();
        if known.robot.connection_state().0 != Some(boot_id) {
            let reason = if known.boots.get(boot_id).is_some() { "old_boot" } else { "unknown_boot" };
            return self.violation(reason, "a test state from a boot that is not the newest", &known.name);
        }
        let is_of = |test: &CommandKey| command_id(&self.fleet, &known.name, *test) == message.test_id;
        let found = known.robot.tests_under_way().map(|(test, _)| test).find(is_of);
        let Some(test) = found else {
            debug!(robot = %known.full_name(), test_id = message.test_id, "state of a touch test that is over");
            return;
        };
        let (report, robot_time) = (edge::touch_tests::report(message), Micros(message.t_us));
        self.step(known, now, &Event::TouchTest { boot_id, test, report, robot_time }, None);
    }

    pub(super) fn take_setpoint_state(
        &mut self,
        known: &mut KnownRobot,
        message: &protocol::SetpointState,
        now: Micros,
    ) {
        let boot_id = message.boot_id.as_str();
        if known.robot.connection_state().0 != Some(boot_id) {
            let reason = if known.boots.get(boot_id).is_some() { "old_boot" } else { "unknown_boot" };
            return self.violation(reason, "a setpoint state from a boot that is not the newest", &known.name);
        }
        let found = known
            .robot
            .commands_under_way()
            .find(|command| command_id(&self.fleet, &known.name, command.key) == message.command_id)
            .map(|command| (AnsweredSetpoint::of(command), command.pressure));
        match known.commands.judge(message, known.boot(boot_id), found.is_some()) {
            Plausibility::Fits => {}
            Plausibility::UnknownCommand => {
                let problem = "a state of a setpoint that was not sent to this robot";
                return self.violation("unknown_command", problem, &known.name);
            }
            Plausibility::Backward => {
                let problem = "a setpoint state that precedes one reported before";
                return self.violation("state_backward", problem, &known.name);
            }
        }
        let Some((answered, pressure)) = found else {
            let command_id = &message.command_id;
            debug!(robot = %known.full_name(), command_id, "state of a finished setpoint");
            return;
        };
        match edge::setpoint_report(message, pressure) {
            Ok(report) => {
                let robot_time = Micros(message.t_us);
                let event = Event::Setpoint {
                    boot_id: message.boot_id.as_str(),
                    command: answered.command,
                    report,
                    robot_time,
                };
                self.answered = Some(answered);
                self.step(known, now, &event, None);
                self.answered = None;
            }
            Err(problem) => self.refuse(known, (RobotTopic::SetpointState, problem.label()), &problem, now),
        }
    }
}

/// Number of whiskers in a factsheet that the present layout does not have.
fn new_whiskers(known: &KnownRobot, factsheet: &Factsheet) -> usize {
    let all = factsheet.arrays.iter().flat_map(|array| array.whiskers.iter().map(|sheet| (&array.name, sheet.number)));
    all.filter(|&(array, number)| known.robot.find(array, number).is_none()).count()
}

/// Whether the birth of this boot was not received. One that the rate limit refused was received.
fn is_unannounced(known: &KnownRobot, boot_id: &str) -> bool {
    let is_newest = known.robot.connection_state().0 == Some(boot_id);
    !is_newest && known.boots.get(boot_id).is_none() && known.refused_boot.is_none()
}

/// Number of a boot's `contacts` messages that are given up, and the first `seq` beyond all received ones.
fn counted(known: &KnownRobot, boot_id: &str) -> (u64, u64) {
    known.robot.sequence(boot_id).map_or((0, 0), |sequence: &Sequence| (sequence.given_up(), sequence.end()))
}
