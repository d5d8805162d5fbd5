//! Receives all messages of a robot, and checks the rules that apply to every message.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use bytes::Bytes;
use vibrissa_protocol::{
    BootId, ConnectionState, Contacts, Factsheet, Message, Name, PlaceKind, Refusal, RobotTopic, Rule, Status,
    SupervisorState, Topic, decode, envelope,
};

use super::ledger::Ledger;
use super::log::{Entry, facts, whiskers};
use super::report::Findings;
use vibrissa_edge::clock::wall_clock;
use vibrissa_supervisor::mqtt::ReceivedMessage;

/// Last message on a topic in a boot.
#[derive(Debug)]
struct Stream {
    seq: u64,
    payload: Bytes,
    time_us: Option<u64>,
}

/// Messages received so far.
#[derive(Debug)]
pub(super) struct Listener {
    pub(super) findings: Findings,
    /// All valid messages in the order of arrival.
    pub(super) log: Vec<Entry>,
    /// Contacts messages by boots: a robot may send those of earlier boots, too.
    ledgers: BTreeMap<BootId, Ledger>,
    none: Ledger,
    /// Number of contacts messages with quality of service 1: their sender relies on the broker.
    pub(super) at_least_once: u64,
    /// Newest boot of the robot.
    pub(super) boot: Option<BootId>,
    pub(super) factsheet: Option<Factsheet>,
    pub(super) connection: Option<ConnectionState>,
    pub(super) supervisor: Option<SupervisorState>,
    /// Whether the broker retains messages. Otherwise robots publish without the retain flag.
    pub(super) retains: bool,
    /// Whether arriving messages are current; at first they may be retained ones.
    pub(super) is_live: bool,
    /// A boot that began during the check: its numbers must begin at 0.
    born: Option<BootId>,
    /// First numbers of such boots. A robot introduces earlier boots, too, whose numbers go on: only its present boot has
    /// statuses, and its numbers are judged from the first one on.
    begun: Vec<(BootId, RobotTopic, u64)>,
    /// The boot of the newest status.
    reporting: Option<BootId>,
    /// Whiskers of which a contact ratio has arrived, by boots.
    with_ratio: BTreeSet<(BootId, Name, u16)>,
    /// Whether the check has told the robot lengths.
    sent_lengths: bool,
    streams: BTreeMap<(BootId, RobotTopic), Stream>,
    numbered: u64,
    clock: Duration,
    grace: Duration,
}

impl Listener {
    pub(super) fn new(clock: Duration, grace: Duration) -> Self {
        Self {
            findings: Findings::default(),
            log: Vec::new(),
            ledgers: BTreeMap::new(),
            none: Ledger::default(),
            at_least_once: 0,
            boot: None,
            factsheet: None,
            connection: None,
            supervisor: None,
            retains: true,
            is_live: false,
            born: None,
            begun: Vec::new(),
            reporting: None,
            with_ratio: BTreeSet::new(),
            sent_lengths: false,
            streams: BTreeMap::new(),
            numbered: 0,
            clock,
            grace,
        }
    }

    /// Whether this boot began during the check.
    pub(super) fn was_born(&self, boot: &BootId) -> bool {
        self.born.as_ref() == Some(boot)
    }

    /// The contacts messages of a boot.
    pub(super) fn ledger(&self, boot: &BootId) -> &Ledger {
        self.ledgers.get(boot).unwrap_or(&self.none)
    }

    /// The same to change; `None` for a boot without contacts.
    pub(super) fn ledger_mut(&mut self, boot: &BootId) -> Option<&mut Ledger> {
        self.ledgers.get_mut(boot)
    }

    /// The check has told the robot lengths.
    pub(super) fn note_sent_lengths(&mut self) {
        self.sent_lengths = true;
    }

    /// Processes a message.
    pub(super) fn take(&mut self, received: &ReceivedMessage) {
        let Ok(topic) = Topic::parse(&received.topic) else { return };
        let kind = match &topic {
            Topic::Robot { kind, .. } => *kind,
            Topic::SupervisorState { .. } => {
                if let Ok(Message::SupervisorState(state)) = decode(&topic, &received.payload) {
                    self.supervisor = Some(state);
                }
                return;
            }
            // Asked by this check, or by another one.
            Topic::SupervisorRequest { .. } => return,
        };
        self.judge_delivery(kind, received);
        let decoded = decode(&topic, &received.payload);
        if let Some(envelope) = envelope(&received.payload) {
            self.judge_number(kind, (&envelope.boot_id, envelope.seq), received, decoded.as_ref().ok());
        }
        match decoded {
            Ok(message) => {
                self.findings.pass(Rule::MessageForm, format!("{} messages were valid", self.log.len() + 1));
                self.judge_content(&message, received);
                self.log.push(Entry { at: received.at, message, retained: received.retained });
            }
            Err(refusal) => self.refuse(kind, &refusal),
        }
    }

    fn refuse(&mut self, kind: RobotTopic, refusal: &Refusal) {
        let is_range = kind == RobotTopic::Contacts && matches!(refusal, Refusal::OutOfRange { .. });
        let rule = if is_range { Rule::ContactsInRange } else { Rule::MessageForm };
        self.findings.fail(rule, format!("{kind}: {refusal}"));
    }

    fn judge_delivery(&mut self, kind: RobotTopic, received: &ReceivedMessage) {
        let (qos, retained) = (received.qos, received.retained);
        let is_right = match kind {
            RobotTopic::Connection | RobotTopic::Factsheet | RobotTopic::SetpointState | RobotTopic::TestState => {
                qos == 1
            }
            RobotTopic::Status => qos == 0,
            RobotTopic::Contacts => qos <= 1,
            RobotTopic::Receipt
            | RobotTopic::Setpoint
            | RobotTopic::Request
            | RobotTopic::Estimate
            | RobotTopic::Maintenance => true,
        };
        let seen = if is_right { "as the contract requires on every topic".into() } else { format!("{qos} on {kind}") };
        self.findings.judge(Rule::QualityOfService, is_right, seen);
        match kind {
            RobotTopic::Contacts | RobotTopic::Status | RobotTopic::SetpointState | RobotTopic::TestState => {
                let seen = if retained { format!("{kind} is retained") } else { "none is retained".to_owned() };
                self.findings.judge(Rule::NotRetained, !retained, seen);
            }
            RobotTopic::Factsheet if self.retains => {
                let seen = if retained { "retained" } else { "published without the retain flag" };
                self.findings.judge(Rule::FactsheetRetained, retained, seen);
            }
            RobotTopic::Factsheet
            | RobotTopic::Connection
            | RobotTopic::Receipt
            | RobotTopic::Setpoint
            | RobotTopic::Request
            | RobotTopic::Estimate
            | RobotTopic::Maintenance => {}
        }
        if kind == RobotTopic::Contacts && qos == 1 {
            self.at_least_once += 1;
        }
    }

    /// Checks a message's number and time against those of its boot and topic.
    fn judge_number(
        &mut self,
        kind: RobotTopic,
        (boot, seq): (&BootId, u64),
        received: &ReceivedMessage,
        message: Option<&Message>,
    ) {
        let key = (boot.clone(), kind);
        let last = self.streams.get(&key);
        let time_us = message.and_then(time_us);
        if message.is_some_and(|message| self.is_birth(message)) {
            self.born = Some(boot.clone());
        }
        if last.is_none() && self.born.as_ref() == Some(boot) {
            self.begun.push((boot.clone(), kind, seq));
        }
        if kind == RobotTopic::Status {
            self.reporting = Some(boot.clone());
        }
        let reporting = self.reporting.as_ref();
        for (_, kind, seq) in self.begun.extract_if(.., |(begun, ..)| reporting == Some(begun)) {
            self.findings.judge(Rule::SeqFromZero, seq == 0, format!("{kind} began at {seq} after the restart"));
        }
        if kind == RobotTopic::Contacts {
            let ledger = self.ledgers.entry(boot.clone()).or_default();
            ledger.arrive(seq, &received.payload, received.at, self.grace, &mut self.findings);
        }
        // Connection messages are ordered by arrival, and contacts are repeated: both have rules of their own.
        if let Some(last) = last.filter(|_| !matches!(kind, RobotTopic::Connection | RobotTopic::Contacts)) {
            let is_again = seq == last.seq && received.payload == last.payload;
            let holds = seq == last.seq + 1 || is_again;
            self.numbered += 1;
            let seen = if holds {
                format!("{} messages were numbered consecutively", self.numbered)
            } else {
                format!("{kind} {seq} came after {}", last.seq)
            };
            self.findings.judge(Rule::SeqWithoutGaps, holds, seen);
            if let (Some(before_us), Some(time_us)) = (last.time_us, time_us) {
                let back_s = before_us.saturating_sub(time_us) as f64 / 1e6;
                let seen = if back_s > 0.0 {
                    format!("{kind} {seq} is {back_s:.3} s older than the one before")
                } else {
                    "times rise".into()
                };
                self.findings.judge(Rule::TimeForward, back_s <= 0.0, seen);
            }
        }
        let time_us = time_us.or_else(|| self.streams.get(&key).and_then(|last| last.time_us));
        self.streams.insert(key, Stream { seq, payload: received.payload.clone(), time_us });
    }

    /// Whether the message begins a boot during the check: one of which nothing was heard before.
    fn is_birth(&self, message: &Message) -> bool {
        let Message::Connection(connection) = message else { return false };
        let is_known = self.streams.keys().any(|(known, _)| *known == connection.boot_id);
        self.is_live && connection.state == ConnectionState::Online && self.boot.is_some() && !is_known
    }

    fn judge_content(&mut self, message: &Message, received: &ReceivedMessage) {
        match message {
            Message::Connection(connection) => {
                if connection.state == ConnectionState::Online {
                    self.boot = Some(connection.boot_id.clone());
                    let seen = match (received.retained, self.retains) {
                        (true, _) => "ONLINE, retained",
                        (false, true) => "ONLINE, without the retain flag",
                        (false, false) => "ONLINE; the broker retains no messages",
                    };
                    self.findings.judge(Rule::Birth, received.retained || !self.retains, seen);
                }
                self.connection = Some(connection.state);
            }
            Message::Factsheet(factsheet) => {
                self.judge_clock("factsheet", factsheet.timestamp.0, received);
                self.boot.get_or_insert_with(|| factsheet.boot_id.clone());
                self.factsheet = Some(factsheet.clone());
            }
            Message::Status(status) => {
                self.judge_clock("status", status.t_us, received);
                self.boot.get_or_insert_with(|| status.boot_id.clone());
                self.judge_status(status);
            }
            Message::SetpointState(state) => self.judge_clock("setpoint_state", state.t_us, received),
            Message::TestState(state) => self.judge_clock("test_state", state.t_us, received),
            Message::Contacts(contacts) => self.judge_contacts(contacts, received),
            Message::Receipt(_)
            | Message::Setpoint(_)
            | Message::Request(_)
            | Message::Estimate(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => {}
        }
    }

    fn judge_clock(&mut self, what: &str, time_us: u64, received: &ReceivedMessage) {
        if !self.is_live {
            return;
        }
        let now_us = wall_clock().0.saturating_sub(received.at.elapsed().as_micros() as u64);
        let off_s = (time_us as f64 - now_us as f64) / 1e6;
        let holds = off_s.abs() <= self.clock.as_secs_f64();
        self.findings.judge(Rule::Clock, holds, format!("{what} is {off_s:+.3} s off this machine's clock"));
    }

    fn judge_status(&mut self, status: &Status) {
        let Some(factsheet) = &self.factsheet else { return };
        let mut named: Vec<(&Name, u16)> = status.whiskers.iter().map(|one| (&one.array, one.whisker)).collect();
        named.sort_unstable();
        let mut facts: Vec<(&Name, u16)> = whiskers(factsheet).collect();
        facts.sort_unstable();
        let seen = if named == facts {
            format!("{} whiskers, as on the factsheet", facts.len())
        } else {
            format!("the status has {}, the factsheet {}", listed(&named), listed(&facts))
        };
        self.findings.judge(Rule::StatusWhiskers, named == facts, seen);
    }

    fn judge_contacts(&mut self, message: &Contacts, received: &ReceivedMessage) {
        for contact in &message.contacts {
            let now_us = wall_clock().0.saturating_sub(received.at.elapsed().as_micros() as u64);
            // Contacts may be old, because a robot buffers them, but never in the future.
            let ahead_s = contact.t_us.saturating_sub(now_us) as f64 / 1e6;
            if ahead_s > self.clock.as_secs_f64() {
                self.findings
                    .fail(Rule::Clock, format!("a contact of contacts {} is {ahead_s:.3} s ahead", message.seq));
            }
            // Those of an earlier boot may come from whiskers that the robot no longer has.
            let factsheet = self.factsheet.as_ref().filter(|factsheet| factsheet.boot_id == message.boot_id);
            if let Some(factsheet) = factsheet {
                let (array, whisker) = (&contact.array, contact.whisker);
                let is_known = whiskers(factsheet).any(|known| known == (array, whisker));
                let seen =
                    if is_known { "all are on it".to_owned() } else { format!("{array}/{whisker} is not on it") };
                self.findings.judge(Rule::ContactsOnFactsheet, is_known, seen);
                let on_factsheet = facts(factsheet, (array, whisker));
                if let Some(strain_max) = on_factsheet.and_then(|one| one.strain_max) {
                    let seen = format!("{:.6} at {array}/{whisker}, whose strain_max is {strain_max}", contact.strain);
                    self.findings.judge(Rule::StrainWithinGauge, contact.strain.abs() <= strain_max, seen);
                }
                let stated = on_factsheet.map(|one| one.place.unwrap_or(PlaceKind::Ratio));
                let place = contact.place().word();
                let key = (message.boot_id.clone(), array.clone(), whisker);
                if contact.ratio.is_some() {
                    self.with_ratio.insert(key.clone());
                }
                // A robot that divides by a length sends distances before the first estimate, and beyond the length.
                let may_lack_length = contact.distance_mm.is_some() && !contact.tip && stated == Some(PlaceKind::Ratio);
                let lacks_length = may_lack_length && (self.sent_lengths || !self.with_ratio.contains(&key));
                if let Some(stated) = stated.filter(|_| contact.test_id.is_none() && !lacks_length) {
                    let seen = format!("{place} at {array}/{whisker}, for which the factsheet states {stated}");
                    self.findings.judge(Rule::PlaceAsStated, place == stated.as_str(), seen);
                }
            }
        }
        if !message.contacts.is_empty() {
            self.findings.pass(
                Rule::ContactsInRange,
                format!("in {} messages", self.ledgers.values().map(Ledger::len).sum::<usize>()),
            );
        }
    }
}

fn listed(whiskers: &[(&Name, u16)]) -> String {
    let listed: Vec<String> = whiskers.iter().take(8).map(|(array, whisker)| format!("{array}/{whisker}")).collect();
    let more = if whiskers.len() > 8 { ", .." } else { "" };
    if listed.is_empty() { "none".to_owned() } else { format!("{}{more}", listed.join(", ")) }
}

fn time_us(message: &Message) -> Option<u64> {
    match message {
        Message::Factsheet(factsheet) => Some(factsheet.timestamp.0),
        Message::Status(status) => Some(status.t_us),
        Message::SetpointState(state) => Some(state.t_us),
        Message::TestState(state) => Some(state.t_us),
        Message::Connection(_)
        | Message::Contacts(_)
        | Message::Receipt(_)
        | Message::Setpoint(_)
        | Message::Request(_)
        | Message::Estimate(_)
        | Message::Maintenance(_)
        | Message::SupervisorState(_)
        | Message::SupervisorRequest(_) => None,
    }
}

#[cfg(test)]
mod tests;
