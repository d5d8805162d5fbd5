//! Handling of messages in a shard: decoded, checked against the robot's state, and passed to the core as events.

use std::time::Instant;

use bytes::Bytes;
use tracing::{debug, warn};
use vibrissa_core::robot::event::{Contact, Factsheet, Link, WhiskerStatus};
use vibrissa_core::robot::{Admission, Event, Outcome, Sequence};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Message, Name, Refusal, RobotTopic, Topic};

use super::commands::Plausibility;
use super::commit::batch::{Gathering, Source};
use super::commit::committer::Committer;
use super::fingerprints;
use super::fleet_metrics;
use super::shard::{Known, Shard};
use crate::metrics::FleetMetrics;
use vibrissa_edge as edge;
use vibrissa_edge::ids::command_id;
use vibrissa_store::StoreError;
use vibrissa_store::batch::LayoutRow;

const OLD_BIRTH: &str = "a birth of a boot that a newer one has replaced";
const OLD_FACTSHEET: &str = "a factsheet of a boot that a newer one has replaced";

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
    /// Counts a refused message, and logs the reason at level debug.
    pub(super) fn refuse(&self, reason: &'static str, problem: impl std::fmt::Display, topic: &str) {
        self.messages_refused.count([reason]);
        debug!(reason, %problem, topic, "message refused");
    }
}

impl Shard {
    /// Handles a message that needs no row ids from the database.
    pub(super) fn handle(&mut self, parcel: &Parcel) {
        if !self.permits(parcel) {
            return;
        }
        if parcel.kind == RobotTopic::Contacts {
            return self.handle_contacts(parcel);
        }
        let (Some(message), now) = (self.decode(parcel), parcel.received) else { return };
        if let Message::Connection(told) = &message {
            return self.take_connection(parcel, told);
        }
        let gathering = &mut self.gathering;
        let Some(known) = self.robots.get_mut(&parcel.robot) else { return self.unknown(parcel, None) };
        match &message {
            // Handled above.
            Message::Contacts(_) => {}
            Message::Status(told) => gathering.take_status(known, told, now),
            Message::SetpointState(told) => gathering.take_setpoint_state(known, told, now),
            // Handled by [`Self::take_connection`] and [`Self::handle_factsheet`].
            Message::Connection(_) | Message::Factsheet(_) => {}
            // Not published by robots: the subscriptions exclude them.
            Message::Receipt(_) | Message::Setpoint(_) | Message::Request(_) | Message::SupervisorState(_) => {}
        }
    }

    /// Handles a `contacts` message. These are frequent, so the list of contacts is reused.
    fn handle_contacts(&mut self, parcel: &Parcel) {
        let list = std::mem::take(&mut self.gathering.list);
        match protocol::decode_contacts(&parcel.payload, list) {
            Ok(told) => {
                match self.robots.get_mut(&parcel.robot) {
                    Some(known) => {
                        let content = fingerprints::of_content(&self.gathering.hashers, &told);
                        self.gathering.take_contacts(known, &told, Some(content), parcel.received);
                    }
                    None => self.unknown(parcel, Some((told.boot_id.as_str(), told.seq))),
                }
                self.gathering.list = told.contacts;
            }
            Err(refusal) => self.refused(parcel, &refusal),
        }
    }

    /// Whether the fleet's allow list permits the robot; a refusal is counted.
    fn permits(&mut self, parcel: &Parcel) -> bool {
        let is_allowed = self.gathering.allowed.permits(&parcel.robot);
        if !is_allowed {
            let problem = "the robot is not on the allow list";
            self.gathering.metrics.refuse("not_allowed", problem, parcel.robot.as_str());
            self.gathering.turned_away.count(&parcel.robot, parcel.received);
        }
        is_allowed
    }

    /// Handles a message of an unknown robot. Contacts are refused, and lead to a request for the factsheet if the
    /// robot was announced; the robot sends its other messages again after the factsheet.
    fn unknown(&mut self, parcel: &Parcel, contacts: Option<(&str, u64)>) {
        let (gathering, name) = (&mut self.gathering, &parcel.robot);
        let (reason, problem) = match (self.announced.has(name), contacts) {
            (true, None) => return,
            (true, Some((boot_id, seq))) => {
                let event = Event::Contacts { boot_id, seq, contacts: &[] };
                self.announced.early(gathering, name, parcel.received, &event);
                ("unknown_boot", "no factsheet was received from this robot")
            }
            (false, _) => ("unknown_robot", "neither birth nor factsheet was received from this robot"),
        };
        gathering.metrics.refuse(reason, problem, name.as_str());
    }

    /// Handles a birth or a farewell. An unknown robot is only remembered: its factsheet makes it known.
    fn take_connection(&mut self, parcel: &Parcel, told: &protocol::Connection) {
        let event = Event::Connection { boot_id: told.boot_id.as_str(), link: edge::link(told.state) };
        let is_birth = told.state == protocol::ConnectionState::Online;
        let Some(known) = self.robots.get_mut(&parcel.robot) else {
            let epoch = self.epoch;
            return self.announced.connection(&mut self.gathering, (&parcel.robot, epoch), parcel.received, &event);
        };
        if is_birth && known.boots.is_old(told.boot_id.as_str()) {
            self.gathering.suspect("old_boot", OLD_BIRTH, &known.name);
            return;
        }
        let is_new = is_birth && known.robot.connection_state().0 != Some(told.boot_id.as_str());
        if is_new && !known.new_boots.take(Instant::now()) {
            let problem = "too many new boots: the last accepted boot stays in force until the limit allows another";
            self.gathering.metrics.refuse("too_many_boots", problem, parcel.robot.as_str());
            known.refused_boot = Some(told.boot_id.clone());
            return;
        }
        if is_birth || known.refused_boot.as_ref() == Some(&told.boot_id) {
            known.refused_boot = None;
        }
        let outcome = self.gathering.step(known, parcel.received, &event, None);
        if is_birth && outcome == Outcome::OldBoot {
            self.gathering.suspect("old_boot", OLD_BIRTH, &known.name);
        } else if is_birth {
            self.gathering.ask_after_setpoints(known);
        }
    }

    /// Decodes a factsheet that needs row ids. `None` if it is refused, which is counted, or if all its whiskers have
    /// ids: then it is handled here.
    pub(super) fn factsheet(&mut self, parcel: &Parcel) -> Option<protocol::Factsheet> {
        if !self.permits(parcel) {
            return None;
        }
        let Message::Factsheet(told) = self.decode(parcel)? else { return None };
        let factsheet = self.gathering.factsheet(&told, &parcel.robot)?;
        let boot_id = told.boot_id.as_str();
        if let Some(known) = self.robots.get(&parcel.robot).filter(|known| known.boots.is_old(boot_id)) {
            self.gathering.suspect("old_boot", OLD_FACTSHEET, &known.name);
            return None;
        }
        if let Some(known) = self.robots.get_mut(&parcel.robot)
            && known.boots.get(boot_id).is_some()
            && known.is_laid_out(&factsheet)
        {
            self.gathering.step(known, parcel.received, &Event::Factsheet { boot_id, factsheet: &factsheet }, None);
            return None;
        }
        if !self.robots.contains_key(&parcel.robot) && !self.announced.has_boot(&parcel.robot, boot_id) {
            let problem = "no birth of this boot was received from this robot";
            self.gathering.metrics.refuse("unknown_robot", problem, parcel.robot.as_str());
            return None;
        }
        Some(told)
    }

    /// Refuses the factsheet of a new robot, because a limit is reached.
    pub(super) fn refuse_new(&mut self, parcel: &Parcel, reason: &'static str) {
        let problem =
            "no more new robots are accepted now: see limits.robots_per_fleet and limits.new_robots_per_minute";
        self.gathering.metrics.refuse(reason, problem, parcel.robot.as_str());
        self.announced.ask_later(&mut self.gathering, &parcel.robot, parcel.received);
    }

    /// Handles a factsheet, which makes a robot known. Earlier contacts are not accepted, and the robot sends them
    /// again. The broker retains the factsheet. `is_again` is true if the database was unreachable the first time.
    pub(super) async fn handle_factsheet(
        &mut self,
        parcel: &Parcel,
        (told, is_again): (&protocol::Factsheet, bool),
        committer: &mut Committer,
    ) -> Result<(), StoreError> {
        if !self.robots.contains_key(&parcel.robot) {
            self.make_known(parcel, committer).await?;
        }
        let Some(known) = self.robots.get_mut(&parcel.robot) else { return Ok(()) };
        self.gathering.take_factsheet(known, (told, is_again), parcel.received, committer).await
    }

    /// Decodes a message; `None` if it is refused, which is counted.
    fn decode(&mut self, parcel: &Parcel) -> Option<Message> {
        match protocol::decode(&parcel.topic, &parcel.payload) {
            Ok(message) => Some(message),
            Err(refusal) => {
                self.refused(parcel, &refusal);
                None
            }
        }
    }

    /// Counts a refused message. A `contacts` message whose `seq` is readable is receipted, because the robot would
    /// send it again and again, before all later ones.
    fn refused(&mut self, parcel: &Parcel, refusal: &Refusal) {
        self.gathering.metrics.refuse(refusal.label(), refusal, &parcel.topic.to_string());
        self.receipt_alone(parcel);
    }

    /// Admits the `seq` of a `contacts` message, without its contacts.
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

    async fn make_known(&mut self, parcel: &Parcel, committer: &mut Committer) -> Result<(), StoreError> {
        let (name, now_us) = (&parcel.robot, parcel.received.0 as i64);
        let robot_id = committer.writer.robot_id(&committer.lease, name.as_str(), now_us).await?;
        if let Some(announcement) = self.announced.take(name) {
            let mut known = Known::new(name.clone(), robot_id, announcement.robot, self.gathering.keep);
            known.seqs = announcement.seqs;
            self.robots.insert(name.clone(), known);
        }
        Ok(())
    }
}

impl Gathering {
    /// Accepts the last refused boot, once the limit allows it.
    pub(super) fn take_refused_boot(&mut self, known: &mut Known, now: Micros) {
        let Some(boot_id) = known.refused_boot.clone() else { return };
        if known.new_boots.take(Instant::now()) {
            known.refused_boot = None;
            self.step(known, now, &Event::Connection { boot_id: boot_id.as_str(), link: Link::Online }, None);
        }
    }

    /// Parses a factsheet. `None` if it is unusable; then it is counted as refused.
    fn factsheet(&self, told: &protocol::Factsheet, robot: &Name) -> Option<Factsheet> {
        let models: Vec<&str> = self.params.models.iter().map(|(name, _)| name.as_str()).collect();
        match edge::factsheet(told, &models) {
            Ok(factsheet) => Some(factsheet),
            Err(problem) => {
                warn!(%robot, %problem, "factsheet refused");
                self.metrics.refuse(problem.label(), problem, "factsheet");
                None
            }
        }
    }

    async fn take_factsheet(
        &mut self,
        known: &mut Known,
        (told, is_again): (&protocol::Factsheet, bool),
        now: Micros,
        committer: &mut Committer,
    ) -> Result<(), StoreError> {
        let Some(factsheet) = self.factsheet(told, &known.name) else { return Ok(()) };
        let boot_id = told.boot_id.as_str();
        if known.boots.is_old(boot_id) {
            self.suspect("old_boot", OLD_FACTSHEET, &known.name);
            return Ok(());
        }
        // A retained factsheet of an older boot, or one of a boot that was not announced or not accepted. It gets no
        // row ids, because numbers must increase with newer boots.
        if known.robot.connection_state().0 != Some(boot_id) {
            return Ok(());
        }
        let is_numbered = known.is_laid_out(&factsheet);
        if !is_numbered && !is_again && !known.new_layouts.take(Instant::now()) {
            let problem = "too many new layouts: the last one stays in force until the limit allows another";
            self.metrics.refuse("too_many_layouts", problem, known.name.as_str());
            return Ok(());
        }
        let Committer { lease, writer, .. } = committer;
        if known.boots.get(boot_id).is_none() {
            let boot = writer.boot(lease, known.robot_id, boot_id, now.0 as i64).await?;
            if known.boots.newest().is_some_and(|newest| newest > boot) {
                self.suspect("old_boot", OLD_FACTSHEET, &known.name);
                return Ok(());
            }
            known.boots.insert(boot_id, boot);
        }
        if !is_numbered {
            // Row ids are assigned using a copy, so that an unreachable database changes nothing.
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
                    self.suspect("bad_time", "a status with an implausible time", &known.name);
                }
            }
            Err(problem) => self.metrics.refuse(problem.label(), problem, "status"),
        }
    }

    /// Handles contacts. `content` is their fingerprint; `None` for a refused message that is only receipted.
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
                self.metrics.refuse(reason, "contacts that cannot be accepted yet", known.name.as_str());
                return;
            }
            Outcome::OldBoot => {
                self.suspect("old_boot", "contacts of a boot that newer ones have replaced", &known.name);
                return;
            }
            Outcome::Duplicate => {
                self.metrics.messages_duplicate.inc();
                let boot = known.boot(boot_id);
                if content.is_some_and(|content| known.fingerprints.contradict(boot, told.seq, content)) {
                    let problem = "a contacts message with the seq of another one and different content";
                    self.suspect("conflicting_duplicate", problem, &known.name);
                }
            }
            Outcome::Taken => {
                known.fingerprints.remember(known.boot(boot_id), told.seq, content.unwrap_or(fingerprints::REFUSED));
                if told.seq < end {
                    self.metrics.messages_resent.inc();
                }
                let felt = told.contacts.last().map(|last| Micros(last.t_us));
                self.taken.push(fleet_metrics::Taken { felt, received: now });
            }
            Outcome::BadTime | Outcome::Refused(_) => {}
        }
        let given_up = counted(known, boot_id).0 - given_up_before;
        if given_up > 0 {
            warn!(robot = %known.name, messages = given_up, "contacts lost, the robot has not sent them again");
            self.metrics.messages_given_up.inc_by(given_up);
        }
        self.receipt(known, boot_id);
    }

    fn take_setpoint_state(&mut self, known: &mut Known, told: &protocol::SetpointState, now: Micros) {
        let boot_id = told.boot_id.as_str();
        if known.robot.connection_state().0 != Some(boot_id) {
            let reason = if known.boots.get(boot_id).is_some() { "old_boot" } else { "unknown_boot" };
            return self.suspect(reason, "a setpoint state from a boot that is not the newest", &known.name);
        }
        let found = known
            .robot
            .commands_under_way()
            .find(|command| command_id(&self.fleet, &known.name, command.key) == told.command_id)
            .map(|command| (fleet_metrics::Answering::to(command), command.pressure));
        match known.commands.judge(told, known.boot(boot_id), found.is_some()) {
            Plausibility::Fits => {}
            Plausibility::UnknownCommand => {
                let problem = "a state of a setpoint that was not sent to this robot";
                return self.suspect("unknown_command", problem, &known.name);
            }
            Plausibility::Backward => {
                let problem = "a setpoint state that precedes one reported before";
                return self.suspect("state_backward", problem, &known.name);
            }
        }
        let Some((answering, pressure)) = found else {
            let command_id = &told.command_id;
            debug!(robot = %known.name, command_id, "state of a finished setpoint");
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

/// Number of a boot's `contacts` messages that are given up, and the first `seq` beyond all received ones.
fn counted(known: &Known, boot_id: &str) -> (u64, u64) {
    known.robot.sequence(boot_id).map_or((0, 0), |sequence: &Sequence| (sequence.given_up(), sequence.end()))
}
