//! Messages in: decoded, held against what is known, and given to the core as events.

use std::collections::BTreeMap;

use tracing::{debug, warn};
use vibrissa_core::robot::{Admission, Event, Numbers, Outcome, Robot, Sequence};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Message, Name, RobotTopic, Topic};

use super::history::History;
use super::{Engine, Incoming, Known, publication, survey};
use crate::store::StoreError;
use crate::store::batch::LayoutRow;
use vibrissa_edge as edge;

/// Robots of one fleet at the most: names come from topics, and whoever may publish can make them up.
const ROBOTS_MAX: usize = 10_000;

impl Engine {
    pub(super) async fn handle(&mut self, incoming: &Incoming) -> Result<(), StoreError> {
        let Ok(text) = std::str::from_utf8(&incoming.topic) else {
            self.refuse("unknown_topic", "a topic that is not UTF-8", "");
            return Ok(());
        };
        let topic = match Topic::parse(text) {
            Ok(topic) => topic,
            Err(refusal) => {
                self.refuse(refusal.label(), &refusal, text);
                return Ok(());
            }
        };
        let Topic::Robot { fleet, robot, kind } = &topic else { return Ok(()) };
        if *fleet != self.fleet || !kind.is_from_robot() {
            return Ok(());
        }
        self.metrics.messages_received.count([kind.as_str()]);
        match protocol::decode(&topic, &incoming.payload) {
            Ok(message) => self.take(robot, &message, incoming.received).await,
            Err(refusal) => {
                self.refuse(refusal.label(), &refusal, text);
                if *kind == RobotTopic::Contacts {
                    self.account_for_refused(robot, &incoming.payload, incoming.received).await?;
                }
                Ok(())
            }
        }
    }

    /// A refused `contacts` message whose number can be read is receipted: sent again it would be refused
    /// again, for ever, before everything that comes after it.
    async fn account_for_refused(&mut self, robot: &Name, payload: &[u8], now: Micros) -> Result<(), StoreError> {
        let Some(envelope) = protocol::envelope(payload) else { return Ok(()) };
        let contacts = protocol::Contacts { boot_id: envelope.boot_id, seq: envelope.seq, contacts: Vec::new() };
        self.take(robot, &Message::Contacts(contacts), now).await
    }

    pub(super) fn refuse(&self, reason: &'static str, problem: impl std::fmt::Display, topic: &str) {
        self.metrics.messages_refused.count([reason]);
        debug!(reason, %problem, topic, "refused");
    }

    async fn take(&mut self, name: &Name, message: &Message, now: Micros) -> Result<(), StoreError> {
        if !self.robots.contains_key(name) && !self.make_known(name, message).await? {
            return Ok(());
        }
        match message {
            Message::Connection(told) => {
                let event = Event::Connection { boot_id: told.boot_id.as_str(), link: edge::link(told.state) };
                self.step(name, now, &event, None);
                if told.state == protocol::ConnectionState::Online {
                    self.ask_after_setpoints(name);
                }
            }
            Message::Factsheet(told) => self.take_factsheet(name, told, now).await?,
            Message::Contacts(told) => self.take_contacts(name, told, now),
            Message::Status(told) => {
                let whiskers: Result<Vec<_>, _> = told.whiskers.iter().map(edge::status).collect();
                match whiskers {
                    Ok(whiskers) => {
                        let robot_time = Micros(told.t_us);
                        let event = Event::Status { boot_id: told.boot_id.as_str(), robot_time, whiskers: &whiskers };
                        self.step(name, now, &event, None);
                    }
                    Err(problem) => self.refuse(problem.label(), problem, "status"),
                }
            }
            Message::SetpointState(told) => self.take_setpoint_state(name, told, now),
            // Not from robots: other supervisors' messages, which the subscriptions leave out.
            Message::Receipt(_) | Message::Setpoint(_) | Message::Request(_) | Message::SupervisorState(_) => {}
        }
        Ok(())
    }

    /// A robot becomes known by its birth or factsheet, which the broker retains: what comes before is not
    /// taken, and sent again. False if it is not taken.
    async fn make_known(&mut self, name: &Name, message: &Message) -> Result<bool, StoreError> {
        if !matches!(message, Message::Connection(_) | Message::Factsheet(_)) {
            self.refuse("unknown_robot", "neither birth nor factsheet was received of this robot", name.as_str());
            return Ok(false);
        }
        if self.robots.len() >= ROBOTS_MAX {
            self.refuse("too_many_robots", format!("the fleet has {ROBOTS_MAX} robots already"), name.as_str());
            return Ok(false);
        }
        let known = Known {
            robot_id: self.writer.robot_id(&self.lease, name.as_str()).await?,
            robot: Robot::new(self.lease.epoch(), Numbers::default()),
            whisker_ids: Vec::new(),
            boots: BTreeMap::new(),
            seqs: publication::Seqs::default(),
            stated: survey::Stated::default(),
            history: History::new(self.keep),
        };
        self.robots.insert(name.clone(), known);
        Ok(true)
    }

    async fn take_factsheet(&mut self, name: &Name, told: &protocol::Factsheet, now: Micros) -> Result<(), StoreError> {
        let models: Vec<&str> = self.params.models.iter().map(|(name, _)| name.as_str()).collect();
        let factsheet = match edge::factsheet(told, &models) {
            Ok(factsheet) => factsheet,
            Err(problem) => {
                warn!(robot = %name, %problem, "factsheet refused");
                self.refuse(problem.label(), problem, "factsheet");
                return Ok(());
            }
        };
        let Some(known) = self.robots.get_mut(name) else { return Ok(()) };
        let boot_id = told.boot_id.as_str();
        if !known.boots.contains_key(boot_id) {
            let boot = self.writer.boot(&self.lease, known.robot_id, boot_id, now.0 as i64).await?;
            known.boots.insert(boot_id.to_owned(), boot);
        }
        // The layout is numbered from a copy first, so that a database that is away changes nothing.
        let mut laid_out = known.robot.clone();
        laid_out.step(&self.params, now, &Event::Factsheet { boot_id, factsheet: &factsheet }, &mut Vec::new());
        let whiskers = self.writer.whisker_ids(&self.lease, known.robot_id, &laid_out).await?;
        let ids: Vec<i64> = whiskers.iter().map(|(whisker_id, _)| *whisker_id).collect();
        if ids != known.whisker_ids {
            let gone = known.history.laid_out(&known.whisker_ids, &whiskers, now, &mut self.batch);
            known.whisker_ids = ids;
            self.batch.layouts.push(LayoutRow { robot_id: known.robot_id, model: told.model.clone(), gone });
        }
        self.step(name, now, &Event::Factsheet { boot_id, factsheet: &factsheet }, None);
        Ok(())
    }

    fn take_contacts(&mut self, name: &Name, told: &protocol::Contacts, now: Micros) {
        let mut contacts = Vec::with_capacity(told.contacts.len());
        for contact in &told.contacts {
            match edge::contact(contact) {
                Ok(contact) => contacts.push(contact),
                Err(problem) => self.refuse(problem.label(), problem, "contacts"),
            }
        }
        let boot_id = told.boot_id.as_str();
        let event = Event::Contacts { boot_id, seq: told.seq, contacts: &contacts };
        let (given_up_before, end) = (self.given_up(name, boot_id), self.end(name, boot_id));
        match self.step(name, now, &event, Some(told)) {
            Some(Outcome::NotYet(admission)) => {
                let reason = match admission {
                    Admission::TooManyGaps => "too_many_gaps",
                    Admission::UnknownBoot | Admission::New | Admission::Duplicate => "unknown_boot",
                };
                self.refuse(reason, "contacts that cannot be taken yet", name.as_str());
                return;
            }
            Some(Outcome::Duplicate) => self.metrics.messages_duplicate.inc(),
            Some(Outcome::Taken) => {
                if told.seq < end {
                    self.metrics.messages_resent.inc();
                }
                self.taken
                    .push(survey::Taken { felt: told.contacts.last().map(|last| Micros(last.t_us)), received: now });
            }
            Some(Outcome::OldBoot | Outcome::Refused(_)) | None => {}
        }
        let given_up = self.given_up(name, boot_id) - given_up_before;
        if given_up > 0 {
            warn!(robot = %name, messages = given_up, "lost: the robot has not sent them again");
            self.metrics.messages_given_up.inc_by(given_up);
        }
        self.receipts_due.insert((name.clone(), boot_id.to_owned()));
    }

    /// Contacts messages of a boot that are not waited for any more.
    fn given_up(&self, name: &Name, boot_id: &str) -> u64 {
        let sequence = self.robots.get(name).and_then(|known| known.robot.sequence(boot_id));
        sequence.map_or(0, Sequence::given_up)
    }

    /// The first number of a boot's contacts messages that lies beyond all that were received.
    fn end(&self, name: &Name, boot_id: &str) -> u64 {
        let sequence = self.robots.get(name).and_then(|known| known.robot.sequence(boot_id));
        sequence.map_or(0, Sequence::end)
    }

    fn take_setpoint_state(&mut self, name: &Name, told: &protocol::SetpointState, now: Micros) {
        let Some(known) = self.robots.get(name) else { return };
        let found = known
            .robot
            .commands_under_way()
            .find(|command| publication::command_id(&self.fleet, name, command.key) == told.command_id)
            .map(|command| (survey::Answering::to(command), command.pressure));
        let Some((answering, pressure)) = found else {
            debug!(robot = %name, command_id = told.command_id, "a state of a setpoint that is not under way");
            return;
        };
        match edge::setpoint_report(told, pressure) {
            Ok(report) => {
                let robot_time = Micros(told.t_us);
                let event =
                    Event::Setpoint { boot_id: told.boot_id.as_str(), command: answering.command, report, robot_time };
                self.answering = Some(answering);
                self.step(name, now, &event, None);
                self.answering = None;
            }
            Err(problem) => self.refuse(problem.label(), problem, "setpoint_state"),
        }
    }
}
