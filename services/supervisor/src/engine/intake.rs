//! Messages in: decoded, held against what is known, and given to the core as events.

use bytes::Bytes;
use tracing::{debug, warn};
use vibrissa_core::robot::event::{Contact, WhiskerStatus};
use vibrissa_core::robot::{Admission, Event, Numbers, Outcome, Robot, Sequence};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Message, Name, Refusal, RobotTopic, Topic};

use super::commands::Plausibility;
use super::committer::Committer;
use super::gathering::{Gathering, Source};
use super::shard::{Known, Shard};
use super::{fingerprints, publication, survey};
use crate::metrics::FleetMetrics;
use crate::store::StoreError;
use crate::store::batch::LayoutRow;
use vibrissa_edge as edge;

/// Robots of one fleet at the most: names come from topics, and whoever may publish can make them up.
pub(super) const ROBOTS_MAX: usize = 10_000;

const OLD_BIRTH: &str = "a birth of a boot that another one has followed";
const OLD_FACTSHEET: &str = "a factsheet of a boot that another one has followed";

/// A message of a robot of the fleet.
#[derive(Debug, Clone)]
pub(super) struct Parcel {
    pub(super) topic: Topic,
    pub(super) robot: Name,
    pub(super) kind: RobotTopic,
    pub(super) payload: Bytes,
    pub(super) received: Micros,
}

impl FleetMetrics {
    /// Counts what is not taken, and says why.
    pub(super) fn refuse(&self, reason: &'static str, problem: impl std::fmt::Display, topic: &str) {
        self.messages_refused.count([reason]);
        debug!(reason, %problem, topic, "refused");
    }
}

impl Shard {
    /// A message for which nothing needs a number.
    pub(super) fn handle(&mut self, parcel: &Parcel) {
        if parcel.kind == RobotTopic::Contacts {
            return self.handle_contacts(parcel);
        }
        let (Some(message), now) = (self.decode(parcel), parcel.received) else { return };
        let gathering = &mut self.gathering;
        let Some(known) = self.robots.get_mut(&parcel.robot) else { return self.unknown(parcel) };
        match &message {
            // Handled above.
            Message::Contacts(_) => {}
            Message::Status(told) => gathering.take_status(known, told, now),
            Message::SetpointState(told) => gathering.take_setpoint_state(known, told, now),
            // Handled with their numbers.
            Message::Connection(_) | Message::Factsheet(_) => {}
            // Not from robots: other supervisors' messages, which the subscriptions leave out.
            Message::Receipt(_) | Message::Setpoint(_) | Message::Request(_) | Message::SupervisorState(_) => {}
        }
    }

    /// The many: their list of contacts is used again and again.
    fn handle_contacts(&mut self, parcel: &Parcel) {
        let list = std::mem::take(&mut self.gathering.list);
        match protocol::decode_contacts(&parcel.payload, list) {
            Ok(told) => {
                match self.robots.get_mut(&parcel.robot) {
                    Some(known) => {
                        let content = fingerprints::of_content(&self.gathering.hashers, &told);
                        self.gathering.take_contacts(known, &told, Some(content), parcel.received);
                    }
                    None => self.unknown(parcel),
                }
                self.gathering.list = told.contacts;
            }
            Err(refusal) => self.refused(parcel, &refusal),
        }
    }

    fn unknown(&self, parcel: &Parcel) {
        let problem = "neither birth nor factsheet was received of this robot";
        self.gathering.metrics.refuse("unknown_robot", problem, parcel.robot.as_str());
    }

    /// A birth, a farewell or a factsheet: a robot becomes known by it, and what comes before is not taken, and sent again.
    /// The broker retains both.
    pub(super) async fn handle_numbered(
        &mut self,
        parcel: &Parcel,
        committer: &mut Committer,
        is_full: bool,
    ) -> Result<(), StoreError> {
        let Some(message) = self.decode(parcel) else { return Ok(()) };
        if !self.robots.contains_key(&parcel.robot) {
            if is_full {
                let problem = format!("the fleet has {ROBOTS_MAX} robots already");
                self.gathering.metrics.refuse("too_many_robots", problem, parcel.robot.as_str());
                return Ok(());
            }
            self.make_known(&parcel.robot, committer).await?;
        }
        let Some(known) = self.robots.get_mut(&parcel.robot) else { return Ok(()) };
        match &message {
            Message::Connection(told) => {
                if told.state == protocol::ConnectionState::Online && known.boots.is_old(told.boot_id.as_str()) {
                    self.gathering.suspect("old_boot", OLD_BIRTH, &known.name);
                    return Ok(());
                }
                let event = Event::Connection { boot_id: told.boot_id.as_str(), link: edge::link(told.state) };
                let outcome = self.gathering.step(known, parcel.received, &event, None);
                if told.state == protocol::ConnectionState::Online {
                    if outcome == Outcome::OldBoot {
                        self.gathering.suspect("old_boot", OLD_BIRTH, &known.name);
                        return Ok(());
                    }
                    self.gathering.ask_after_setpoints(known);
                }
                Ok(())
            }
            Message::Factsheet(told) => self.gathering.take_factsheet(known, told, parcel.received, committer).await,
            Message::Contacts(_)
            | Message::Status(_)
            | Message::SetpointState(_)
            | Message::Receipt(_)
            | Message::Setpoint(_)
            | Message::Request(_)
            | Message::SupervisorState(_) => Ok(()),
        }
    }

    /// The message; none if it is refused, which is counted.
    fn decode(&mut self, parcel: &Parcel) -> Option<Message> {
        match protocol::decode(&parcel.topic, &parcel.payload) {
            Ok(message) => Some(message),
            Err(refusal) => {
                self.refused(parcel, &refusal);
                None
            }
        }
    }

    /// A refused `contacts` message whose number can be read is receipted: sent again it would be refused
    /// again, for ever, before everything that comes after it.
    fn refused(&mut self, parcel: &Parcel, refusal: &Refusal) {
        self.gathering.metrics.refuse(refusal.label(), refusal, &parcel.topic.to_string());
        self.receipt_alone(parcel);
    }

    /// Takes the number of a `contacts` message, and nothing else of it.
    pub(super) fn receipt_alone(&mut self, parcel: &Parcel) {
        if parcel.kind != RobotTopic::Contacts {
            return;
        }
        let (Some(envelope), Some(known)) = (protocol::envelope(&parcel.payload), self.robots.get_mut(&parcel.robot))
        else {
            return;
        };
        let contacts = protocol::Contacts { boot_id: envelope.boot_id, seq: envelope.seq, contacts: Vec::new() };
        self.gathering.take_contacts(known, &contacts, None, parcel.received);
    }

    async fn make_known(&mut self, name: &Name, committer: &mut Committer) -> Result<(), StoreError> {
        let robot_id = committer.writer.robot_id(&committer.lease, name.as_str()).await?;
        let robot = Robot::new(committer.lease.epoch(), Numbers::default());
        self.robots.insert(name.clone(), Known::new(name.clone(), robot_id, robot, self.gathering.keep));
        Ok(())
    }
}

impl Gathering {
    async fn take_factsheet(
        &mut self,
        known: &mut Known,
        told: &protocol::Factsheet,
        now: Micros,
        committer: &mut Committer,
    ) -> Result<(), StoreError> {
        let models: Vec<&str> = self.params.models.iter().map(|(name, _)| name.as_str()).collect();
        let factsheet = match edge::factsheet(told, &models) {
            Ok(factsheet) => factsheet,
            Err(problem) => {
                warn!(robot = %known.name, %problem, "factsheet refused");
                self.metrics.refuse(problem.label(), problem, "factsheet");
                return Ok(());
            }
        };
        let boot_id = told.boot_id.as_str();
        let Committer { lease, writer, .. } = committer;
        if known.boots.is_old(boot_id) {
            self.suspect("old_boot", OLD_FACTSHEET, &known.name);
            return Ok(());
        }
        if known.robot.connection_state().0 != Some(boot_id) {
            // Its birth is to come first. It has no number before that: a boot that has one is older than the next that gets one.
            return Ok(());
        }
        if known.boots.get(boot_id).is_none() {
            let boot = writer.boot(lease, known.robot_id, boot_id, now.0 as i64).await?;
            if known.boots.newest().is_some_and(|newest| newest > boot) {
                self.suspect("old_boot", OLD_FACTSHEET, &known.name);
                return Ok(());
            }
            known.boots.insert(boot_id, boot);
        }
        let is_numbered = known.robot.is_as_known(&factsheet) && known.whisker_ids.len() == known.robot.whisker_count();
        if !is_numbered {
            // The layout is numbered from a copy first, so that a database that is away changes nothing.
            let mut laid_out = known.robot.clone();
            laid_out.step(&self.params, now, &Event::Factsheet { boot_id, factsheet: &factsheet }, &mut Vec::new());
            let whiskers = writer.whisker_ids(lease, known.robot_id, &laid_out).await?;
            let ids: Vec<i64> = whiskers.iter().map(|(whisker_id, _)| *whisker_id).collect();
            if ids != known.whisker_ids {
                let gone = known.history.laid_out(&known.whisker_ids, &whiskers, now, &mut self.batch);
                known.whisker_ids = ids;
                self.waiting.laid_out(known.whisker_ids.len());
                self.batch.layouts.push(LayoutRow { robot_id: known.robot_id, model: told.model.clone(), gone });
            }
        }
        self.step(known, now, &Event::Factsheet { boot_id, factsheet: &factsheet }, None);
        Ok(())
    }

    fn take_status(&mut self, known: &mut Known, told: &protocol::Status, now: Micros) {
        let whiskers: Result<Vec<WhiskerStatus<'_>>, _> = told.whiskers.iter().map(edge::status).collect();
        match whiskers {
            Ok(whiskers) => {
                let (boot_id, robot_time) = (told.boot_id.as_str(), Micros(told.t_us));
                let event = Event::Status { boot_id, robot_time, whiskers: &whiskers };
                if self.step(known, now, &event, None) == Outcome::BadTime {
                    self.suspect(
                        "bad_time",
                        "a status with a time that cannot be right by the robot's clock",
                        &known.name,
                    );
                }
            }
            Err(problem) => self.metrics.refuse(problem.label(), problem, "status"),
        }
    }

    /// `content` is its fingerprint; none of a message that was refused and is only accounted for.
    fn take_contacts(&mut self, known: &mut Known, told: &protocol::Contacts, content: Option<u32>, now: Micros) {
        let mut contacts: Vec<Contact<'_>> = Vec::with_capacity(told.contacts.len());
        for contact in &told.contacts {
            match edge::contact(contact) {
                Ok(contact) => contacts.push(contact),
                Err(problem) => self.metrics.refuse(problem.label(), problem, "contacts"),
            }
        }
        let boot_id = told.boot_id.as_str();
        let event = Event::Contacts { boot_id, seq: told.seq, contacts: &contacts };
        let (given_up_before, end) = counted(known, boot_id);
        let source = Source { told, boot: known.boot(boot_id) };
        match self.step(known, now, &event, Some(source)) {
            Outcome::NotYet(admission) => {
                let reason = match admission {
                    Admission::TooManyGaps => "too_many_gaps",
                    Admission::UnknownBoot | Admission::New | Admission::Duplicate => "unknown_boot",
                };
                self.metrics.refuse(reason, "contacts that cannot be taken yet", known.name.as_str());
                return;
            }
            Outcome::OldBoot => {
                self.suspect("old_boot", "contacts of a boot that others have followed", &known.name);
                return;
            }
            Outcome::Duplicate => {
                self.metrics.messages_duplicate.inc();
                let boot = known.boot(boot_id);
                if content.is_some_and(|content| known.fingerprints.contradict(boot, told.seq, content)) {
                    let problem = "a contacts message with the number of another one and other content";
                    self.suspect("conflicting_duplicate", problem, &known.name);
                }
            }
            Outcome::Taken => {
                known.fingerprints.remember(known.boot(boot_id), told.seq, content.unwrap_or(fingerprints::REFUSED));
                if told.seq < end {
                    self.metrics.messages_resent.inc();
                }
                let felt = told.contacts.last().map(|last| Micros(last.t_us));
                self.taken.push(survey::Taken { felt, received: now });
            }
            Outcome::BadTime | Outcome::Refused(_) => {}
        }
        let given_up = counted(known, boot_id).0 - given_up_before;
        if given_up > 0 {
            warn!(robot = %known.name, messages = given_up, "lost: the robot has not sent them again");
            self.metrics.messages_given_up.inc_by(given_up);
        }
        self.receipt(known, boot_id);
    }

    fn take_setpoint_state(&mut self, known: &mut Known, told: &protocol::SetpointState, now: Micros) {
        let boot_id = told.boot_id.as_str();
        if known.robot.connection_state().0 != Some(boot_id) {
            let reason = if known.boots.get(boot_id).is_some() { "old_boot" } else { "unknown_boot" };
            return self.suspect(reason, "a state of a setpoint from a boot that is not the newest", &known.name);
        }
        let found = known
            .robot
            .commands_under_way()
            .find(|command| publication::command_id(&self.fleet, &known.name, command.key) == told.command_id)
            .map(|command| (survey::Answering::to(command), command.pressure));
        match known.commands.judge(told, known.boot(boot_id), found.is_some()) {
            Plausibility::Fits => {}
            Plausibility::UnknownCommand => {
                let problem = "a state of a setpoint that this robot was not sent";
                return self.suspect("unknown_command", problem, &known.name);
            }
            Plausibility::Backward => {
                let problem = "a state of a setpoint after a later one of the same";
                return self.suspect("state_backward", problem, &known.name);
            }
        }
        let Some((answering, pressure)) = found else {
            let command_id = &told.command_id;
            debug!(robot = %known.name, command_id, "a state of a setpoint that is not under way any more");
            return;
        };
        match edge::setpoint_report(told, pressure) {
            Ok(report) => {
                let robot_time = Micros(told.t_us);
                let event =
                    Event::Setpoint { boot_id: told.boot_id.as_str(), command: answering.command, report, robot_time };
                self.answering = Some(answering);
                self.step(known, now, &event, None);
                self.answering = None;
            }
            Err(problem) => self.metrics.refuse(problem.label(), problem, "setpoint_state"),
        }
    }
}

/// Contacts messages of a boot that are not waited for any more, and the first number beyond all that were received.
fn counted(known: &Known, boot_id: &str) -> (u64, u64) {
    known.robot.sequence(boot_id).map_or((0, 0), |sequence: &Sequence| (sequence.given_up(), sequence.end()))
}
