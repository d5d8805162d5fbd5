//! Handling of messages in a worker: decoded, checked against allow list and limits, and passed on.

use std::fmt::Display;

use tokio::time::Instant;
use tracing::{info, warn};
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{Event, Outcome};
use vibrissa_protocol::{self as protocol, Message, Refusal, RobotTopic};

use super::Worker;
use super::reports::OLD_FACTSHEET;
use crate::engine::commit::committer::Committer;
use crate::engine::ledger;
use crate::engine::message::RawMessage;
use crate::engine::robot::{KnownRobot, fingerprints};
use vibrissa_edge as edge;
use vibrissa_edge::full_name::FullName;
use vibrissa_store::StoreError;
use vibrissa_store::decommission::Registered;

const OLD_BIRTH: &str = "a birth of a boot that a newer one has replaced";

impl Worker {
    /// Handles messages that need no row ids from the database, and keeps those with effects.
    pub(super) fn handle_all(&mut self, messages: &mut Vec<RawMessage>, are_in_log: bool) {
        self.stepper.batch.set_in_log(are_in_log);
        for raw in messages.drain(..) {
            self.stepper.has_stepped = false;
            self.handle(&raw);
            if self.stepper.has_stepped {
                self.stepper.batch.push_message(raw);
            }
        }
        self.stepper.batch.set_in_log(false);
    }

    /// Handles a message that needs no row ids from the database.
    pub(crate) fn handle(&mut self, raw: &RawMessage) {
        if raw.is_clearing() || !self.permits(raw) {
            return;
        }
        if let Some(known) = self.robots.get_mut(&raw.robot) {
            self.stepper.keep_message(known, raw.kind, raw.received, &raw.payload);
        }
        if raw.kind == RobotTopic::Contacts {
            return self.handle_contacts(raw);
        }
        let (Some(protocol::Received { message, refused }), now) = (self.decode(raw), raw.received) else { return };
        if let Message::Connection(message) = &message {
            return self.take_connection(raw, message);
        }
        let stepper = &mut self.stepper;
        let Some(known) = self.robots.get_mut(&raw.robot) else { return self.unknown(raw, None) };
        match &message {
            // Handled above.
            Message::Contacts(_) => {}
            Message::Status(message) => stepper.take_status(known, message, &refused, now),
            Message::SetpointState(message) => stepper.take_setpoint_state(known, message, now),
            Message::TestState(message) => stepper.take_test_state(known, message, now),
            // Handled by [`Self::take_connection`] and [`Self::handle_factsheet`].
            Message::Connection(_) | Message::Factsheet(_) => {}
            // Not published by robots: the subscriptions exclude them.
            Message::Receipt(_)
            | Message::Setpoint(_)
            | Message::Request(_)
            | Message::Estimate(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => {}
        }
    }

    /// Handles a `contacts` message. These are frequent, so the list of contacts is reused.
    fn handle_contacts(&mut self, raw: &RawMessage) {
        let contacts = std::mem::take(&mut self.contacts);
        match protocol::receive_contacts(&raw.payload, contacts) {
            Ok(protocol::Received { message, refused }) => {
                match self.robots.get_mut(&raw.robot) {
                    Some(known) => {
                        let content = fingerprints::of_content(&self.hashers, &message);
                        self.stepper.take_contacts(known, (&message, &refused[..]), Some(content), raw.received);
                    }
                    None => self.unknown(raw, Some((message.boot_id.as_str(), message.seq))),
                }
                self.contacts = message.contacts;
            }
            Err(refusal) => self.refused(raw, &refusal),
        }
    }

    /// Whether the fleet's allow list permits the robot, and this program can go on with its state; a refusal is counted.
    fn permits(&mut self, raw: &RawMessage) -> bool {
        if self.of_newer_program.contains_key(&raw.robot) {
            let problem = "a newer version of the program has written the robot's state: start that version";
            self.stepper.violation("newer_state", problem, &raw.robot);
            return false;
        }
        let is_allowed = self.allow_list.permits(&raw.robot);
        if !is_allowed {
            let problem = "the robot is not on the allow list";
            self.stepper.metrics.refuse("not_allowed", problem, raw.robot.as_str());
            if self.refused_robots.count(&raw.robot, raw.received) {
                let robot = FullName::robot(self.stepper.fleet.as_str(), raw.robot.as_str());
                warn!(%robot, "robot refused, not on the fleet's allow list");
            }
        }
        is_allowed
    }

    /// Handles a message of an unknown robot. Contacts are refused, and lead to a request for the factsheet if the
    /// robot was announced; the robot sends its other messages again after the factsheet.
    fn unknown(&mut self, raw: &RawMessage, contacts: Option<(&str, u64)>) {
        let (stepper, name) = (&mut self.stepper, &raw.robot);
        let (reason, problem) = match (self.announced.has(name), contacts) {
            (true, None) => return,
            (true, Some((boot_id, seq))) => {
                let event = Event::Contacts { boot_id, seq, contacts: &[], missed: &[] };
                self.announced.early(stepper, name, raw.received, &event);
                ("unknown_boot", "no factsheet was received from this robot")
            }
            (false, _) => {
                stepper.has_unannounced = true;
                ("unknown_robot", "neither birth nor factsheet was received from this robot")
            }
        };
        stepper.metrics.refuse(reason, problem, name.as_str());
    }

    /// Handles a birth or a farewell. An unknown robot is only remembered: its factsheet makes it known.
    fn take_connection(&mut self, raw: &RawMessage, message: &protocol::Connection) {
        let event = Event::Connection { boot_id: message.boot_id.as_str(), link: edge::link(message.state) };
        let is_birth = message.state == protocol::ConnectionState::Online;
        let Some(known) = self.robots.get_mut(&raw.robot) else {
            let epoch = self.epoch;
            return self.announced.connection(&mut self.stepper, (&raw.robot, epoch), raw, &event);
        };
        if is_birth && known.boots.is_old(message.boot_id.as_str()) {
            if known.robot.is_replaced(message.boot_id.as_str()) {
                self.stepper.step(known, raw.received, &event, None);
            }
            self.stepper.violation("old_boot", OLD_BIRTH, &known.name);
            return;
        }
        let (newest, link) = known.robot.connection_state();
        let is_new = is_birth && newest != Some(message.boot_id.as_str());
        let is_back = is_birth && !is_new && link != Link::Online;
        if is_back && !known.account.affords(ledger::ROBOT, raw.received, 0) {
            let refusal = (RobotTopic::Connection, "over_budget");
            self.stepper.violation_of(known, refusal, "its connection changes too often", raw.received);
            known.refused_boot = Some(message.boot_id.clone());
            return;
        }
        if is_new && !known.new_boots.take(Instant::now()) {
            let problem = "too many new boots: the last accepted boot stays in force until the limit allows another";
            self.stepper.refuse(known, (RobotTopic::Connection, "too_many_boots"), &problem, raw.received);
            known.refused_boot = Some(message.boot_id.clone());
            return;
        }
        if is_birth || known.refused_boot.as_ref() == Some(&message.boot_id) {
            known.refused_boot = None;
        }
        let outcome = self.stepper.step_connection(known, raw.received, &event);
        if is_birth && outcome == Outcome::OldBoot {
            self.stepper.violation("old_boot", OLD_BIRTH, &known.name);
        } else if is_birth {
            self.stepper.resend_setpoints(known);
            // The broker may have forgotten the retained one.
            known.estimates.repeat();
        }
    }

    /// Decodes a factsheet that needs row ids. `None` if it is refused, which is counted, or if all its whiskers have
    /// ids: then it is handled here.
    pub(crate) fn factsheet(&mut self, raw: &RawMessage) -> Option<protocol::Factsheet> {
        if raw.is_clearing() || !self.permits(raw) {
            return None;
        }
        if let Some(known) = self.robots.get_mut(&raw.robot) {
            self.stepper.keep_message(known, raw.kind, raw.received, &raw.payload);
        }
        let Message::Factsheet(message) = self.decode(raw)?.message else { return None };
        let factsheet = match self.stepper.factsheet(&message) {
            Ok(factsheet) => factsheet,
            Err(problem) => {
                let robot = FullName::robot(self.stepper.fleet.as_str(), raw.robot.as_str());
                warn!(%robot, %problem, "factsheet refused");
                self.count_refusal(raw, problem.label(), &problem);
                return None;
            }
        };
        let boot_id = message.boot_id.as_str();
        if let Some(known) = self.robots.get(&raw.robot).filter(|known| known.boots.is_old(boot_id)) {
            self.stepper.violation("old_boot", OLD_FACTSHEET, &known.name);
            return None;
        }
        if let Some(known) = self.robots.get_mut(&raw.robot)
            && known.boots.get(boot_id).is_some()
            && known.is_laid_out(&factsheet)
        {
            self.stepper.step_factsheet(known, (&message, &factsheet), raw.received);
            return None;
        }
        if !self.robots.contains_key(&raw.robot) && !self.announced.has_boot(&raw.robot, boot_id) {
            let problem = "no birth of this boot was received from this robot";
            self.stepper.has_unannounced = true;
            self.stepper.metrics.refuse("unknown_robot", problem, raw.robot.as_str());
            return None;
        }
        Some(message)
    }

    /// Refuses the factsheet of a new robot, because a limit is reached.
    pub(crate) fn refuse_new(&mut self, raw: &RawMessage, reason: &'static str) {
        let problem =
            "no more new robots are accepted now: see limits.robots_per_fleet and limits.new_robots_per_minute";
        self.stepper.metrics.refuse(reason, problem, raw.robot.as_str());
        self.announced.ask_later(&mut self.stepper, &raw.robot, raw.received);
    }

    /// Handles a factsheet, which makes a robot known. Earlier contacts are not accepted, and the robot sends them
    /// again. The broker retains the factsheet. `is_again` is true if the database was unreachable the first time.
    pub(crate) async fn handle_factsheet(
        &mut self,
        raw: &RawMessage,
        (message, is_again): (&protocol::Factsheet, bool),
        committer: &mut Committer,
    ) -> Result<(), StoreError> {
        if !self.robots.contains_key(&raw.robot) {
            self.make_known(raw, message, committer).await?;
        }
        let Some(known) = self.robots.get_mut(&raw.robot) else { return Ok(()) };
        self.stepper.take_factsheet(known, (message, is_again), raw.received, committer).await
    }

    /// Decodes a message; `None` if it is refused, which is counted.
    fn decode(&mut self, raw: &RawMessage) -> Option<protocol::Received<Message>> {
        match protocol::receive(&raw.topic, &raw.payload) {
            Ok(received) => Some(received),
            Err(refusal) => {
                self.refused(raw, &refusal);
                None
            }
        }
    }

    /// Counts a refused message. A `contacts` message whose `seq` is readable is receipted, because the robot would
    /// send it again and again, before all later ones.
    fn refused(&mut self, raw: &RawMessage, refusal: &Refusal) {
        self.count_refusal(raw, refusal.label(), refusal);
        self.receipt_alone(raw);
    }

    /// Counts a refused message, also of its robot if that is known.
    fn count_refusal(&mut self, raw: &RawMessage, reason: &'static str, problem: &dyn Display) {
        match self.robots.get_mut(&raw.robot) {
            Some(known) => self.stepper.refuse(known, (raw.kind, reason), problem, raw.received),
            None => self.stepper.metrics.refuse(reason, problem, &raw.topic.to_string()),
        }
    }

    /// Admits the `seq` of a `contacts` message, without its contacts.
    pub(crate) fn receipt_alone(&mut self, raw: &RawMessage) {
        if raw.kind != RobotTopic::Contacts {
            return;
        }
        let (Some(envelope), Some(known)) = (protocol::envelope(&raw.payload), self.robots.get_mut(&raw.robot)) else {
            return;
        };
        let contacts = protocol::Contacts {
            boot_id: envelope.boot_id,
            seq: envelope.seq,
            contacts: Vec::new(),
            missed: Vec::new(),
        };
        self.stepper.take_contacts(known, (&contacts, &[][..]), None, raw.received);
    }

    async fn make_known(
        &mut self,
        raw: &RawMessage,
        message: &protocol::Factsheet,
        committer: &mut Committer,
    ) -> Result<(), StoreError> {
        let (name, now_us) = (&raw.robot, raw.received.0 as i64);
        let (writer, lease) = committer.database();
        let registered = writer.register(lease, (name.as_str(), message.boot_id.as_str()), now_us).await?;
        let Some(announcement) = self.announced.take(name) else { return Ok(()) };
        let Some(Registered { robot_id, numbers }) = registered else {
            let problem = "the robot was decommissioned in this boot: it is registered anew when it starts anew";
            self.stepper.violation("old_boot", problem, name);
            return Ok(());
        };
        {
            let names = (self.stepper.fleet.clone(), name.clone());
            let mut known = KnownRobot::new(names, robot_id, announcement.robot, self.stepper.retention);
            let former = self.former.remove(name);
            known.robot.go_on_numbering(numbers, former.as_ref().map_or(0, |former| former.next_version));
            known.seqs = former.map_or(announcement.seqs, |former| former.seqs);
            let (at, birth) = &announcement.birth;
            self.stepper.keep_message(&mut known, RobotTopic::Connection, *at, birth);
            self.stepper.keep_message(&mut known, raw.kind, raw.received, &raw.payload);
            info!(robot = %known.full_name(), "new robot registered");
            self.robots.insert(name.clone(), known);
        }
        Ok(())
    }
}
