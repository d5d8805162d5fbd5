//! The agent: the contract's rules between a driver and the broker, without sockets and clock.
//!
//! [`Agent::step`] takes one input and returns what to do. Call it with [`Input::Tick`] at [`Agent::next_deadline`],
//! too. Deadlines are [`Moment`]s, which no correction of a clock moves.

mod boots;
mod chamber;
mod contacts;
mod doubt;
mod drivers;
mod gauge_watch;
mod lines;
mod locate;
mod messages;
mod motion;
mod motion_lines;
mod orders;
mod partial;
pub mod snapshot;
mod spool;
mod strain;
mod times;
mod unit;

use std::collections::{BTreeMap, VecDeque};

use vibrissa_protocol::{BootId, Contact, Message, MissedTouch, Name, RequestKind, RobotTopic, SupervisorRequestKind};
use vibrissa_protocol::{Topic, decode};

use crate::config::{Config, Limits};
use crate::contract::births::DELAY_MAX_US;
use crate::contract::{Births, Commands, EstimateOrder, Facts, Moment, Now, Outbox, Supervision, TouchTests, Voice};
use crate::driver::ToDriver;
use crate::store::spool::Position;
use crate::store::{Record, Stored};

use boots::Earlier;
use chamber::Chamber;
use drivers::Driver;
use orders::UnderWay;
use spool::Spooling;

/// An input of the agent.
#[derive(Debug, Clone, Copy)]
pub enum Input<'a> {
    /// The connection to the broker is established with its subscriptions.
    Connected,
    /// The connection is lost.
    Disconnected,
    /// A message has arrived on one of the robot's topics.
    Message(RobotTopic, &'a [u8]),
    /// A message to all robots of the fleet has arrived. The number is random, for the delay of an answer.
    RequestToAll(&'a [u8], u64),
    /// The driver of this index in the configuration can be heard, from now on or anew.
    DriverStarted(usize),
    /// The driver has gone.
    DriverEnded(usize),
    /// A line of the driver; `None` in place of one that was too long.
    Line(usize, Option<&'a [u8]>),
    /// Contacts that have come back from the disk, with the position after them; `None` if nothing waits there any
    /// more.
    CameBack(Option<(&'a [u8], Position)>),
    /// So many messages were lost on the disk.
    LostOnDisk(u64),
    /// Time has passed.
    Tick,
}

/// Something to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// Publish a message.
    Publish(RobotTopic, Vec<u8>),
    /// Send a line to the driver of this index.
    Tell(usize, ToDriver),
    /// Tell a person, once for each cause: a sentence for the log.
    Warn(String),
    /// Write contacts to the disk, after those that wait there.
    Spool(Vec<u8>),
    /// Give the oldest message on the disk back by [`Input::CameBack`].
    TakeBack,
    /// Store a record, before the messages that follow it are published.
    Store(Record),
    /// The driver has been silent for too long: start it again, or wait for it anew. The text says what it does
    /// instead.
    RestartDriver(usize, String),
    /// Cut the connection without a farewell and connect again: another boot has begun.
    Reconnect,
}

/// Time without a reading, since the start or the last reading of a driver that has gone, after which the driver counts
/// as absent. Until then nothing is known of the chambers, which is no fault. A driver that is there and silent is one
/// earlier. The contract asks for a status at least every 10 s.
const ABSENT_AFTER_US: u64 = 9_000_000;

/// Counts since the start.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    /// Lines of the driver.
    pub lines: u64,
    /// Lines of the agent that came back.
    pub lines_echoed: u64,
    /// Lines that were refused.
    pub lines_refused: u64,
    /// Contacts and missed touches taken.
    pub contacts: u64,
    /// Contacts that were found and could not be sent, for instance without a deflection.
    pub contacts_unusable: u64,
    /// Messages from the network that were refused.
    pub messages_refused: u64,
    /// Times that the driver was found silent.
    pub driver_silences: u64,
}

/// One robot's agent.
#[derive(Debug)]
pub struct Agent {
    fleet: Name,
    robot: Name,
    facts: Facts,
    limits: Limits,
    voice: Voice,
    connected: bool,
    chambers: Vec<Chamber>,
    places: BTreeMap<(Name, u16), usize>,
    commands: Commands,
    births: Births,
    estimates: EstimateOrder,
    touch_tests: TouchTests,
    under_way: VecDeque<UnderWay>,
    supervision: Supervision,
    outbox: Outbox,
    earlier: Vec<Earlier>,
    /// Moment of the first connection of this boot, before which earlier boots were introduced.
    introduced: Option<Moment>,
    first_boot_id: BootId,
    /// Boots since the start, besides the first one.
    reboots: u64,
    /// Contacts on the disk, if there is an outbox there.
    spooling: Option<Spooling>,
    /// Messages of earlier boots that had no room, and those lost on the disk.
    dropped_earlier: u64,
    /// Contacts of the incomplete message, and the moment at which it is sent.
    batch: Vec<Contact>,
    missed: Vec<MissedTouch>,
    batch_until: Option<Moment>,
    status_at: Moment,
    status_sent: Moment,
    /// Until then the agent says nothing of its chambers, unless it knows all pressures before: a driver has just
    /// started.
    unknown_until: Option<Moment>,
    drivers: Vec<Driver>,
    counts: Counts,
}

impl Agent {
    /// An agent that starts now, in a new boot, with what earlier boots have stored. Also returns the records of its
    /// state, with which the store begins anew.
    #[must_use]
    pub fn new(config: &Config, boot_id: BootId, stored: Stored, now: Now) -> (Self, Vec<Record>) {
        let mut chambers = Vec::new();
        for array in &config.facts.arrays {
            for whisker in &array.whiskers {
                let seen = stored.seen.get(&(array.array.clone(), whisker.whisker)).copied();
                let place = (array.array.clone(), whisker.whisker);
                // The configuration has a driver for each whisker.
                let Some(first) = config.drivers.iter().find(|driver| driver.whiskers.contains(&place)) else {
                    continue;
                };
                let more = config.whiskers.get(&place).copied().unwrap_or_default();
                chambers.push(Chamber::new(array.array.clone(), whisker, more, seen, first.limits));
            }
        }
        let places = chambers.iter().enumerate().map(|(at, one)| ((one.array.clone(), one.number), at)).collect();
        let limits = config.limits.clone();
        let drivers = config.drivers.iter().map(|driver| Driver::new(driver, &chambers, &limits, now)).collect();
        let mut agent = Self {
            fleet: config.fleet.clone(),
            robot: config.robot.clone(),
            facts: config.facts.clone(),
            first_boot_id: boot_id.clone(),
            introduced: None,
            reboots: 0,
            voice: Voice::new(boot_id),
            connected: false,
            chambers,
            places,
            commands: Commands::default(),
            births: Births::default(),
            estimates: EstimateOrder::default(),
            touch_tests: TouchTests::default(),
            under_way: VecDeque::new(),
            supervision: Supervision::new(limits.supervisor_lost_after_us),
            outbox: Outbox::new(limits.outbox_messages),
            earlier: Vec::new(),
            spooling: config.spool().map(|_| Spooling::new(stored.is_spooled, stored.spooled)),
            dropped_earlier: 0,
            batch: Vec::new(),
            missed: Vec::new(),
            batch_until: None,
            status_at: now.at,
            status_sent: now.at,
            unknown_until: Some(now.at + ABSENT_AFTER_US),
            drivers,
            counts: Counts::default(),
            limits,
        };
        agent.take_up(stored.boots);
        let records = agent.records();
        (agent, records)
    }

    /// Handles an input.
    pub fn step(&mut self, now: Now, input: Input<'_>) -> Vec<Output> {
        let mut out = Vec::new();
        match input {
            Input::Connected => {
                self.connected = true;
                self.outbox.reconnected();
                self.earlier.iter_mut().for_each(|boot| boot.outbox.reconnected());
                if self.introduced.is_none() {
                    self.introduced = Some(now.at);
                    self.announce_earlier(now, &mut out);
                }
                self.announce(now, &mut out);
                self.status(now, &mut out);
            }
            Input::Disconnected => {
                self.connected = false;
                self.supervision.waits(false, now.at);
            }
            Input::Message(topic, payload) => self.receive(topic, payload, now, &mut out),
            Input::RequestToAll(payload, random) => self.requested_of_all(payload, random, now),
            Input::DriverStarted(from) => self.driver_started(from, now, &mut out),
            Input::DriverEnded(from) => self.driver_ended(from, now, &mut out),
            Input::Line(from, line) => self.line(from, line, now, &mut out),
            Input::CameBack(back) => self.came_back(back, now, &mut out),
            Input::LostOnDisk(messages) => self.lost_on_disk(messages),
            Input::Tick => {}
        }
        self.tick(now, &mut out);
        out
    }

    /// Does what is due.
    fn tick(&mut self, now: Now, out: &mut Vec<Output>) {
        if self.batch_until.is_some_and(|due| due <= now.at) {
            self.flush(now, out);
        }
        self.miss_drivers(now, out);
        self.miss_readings(now, out);
        self.miss_values(now, out);
        self.follow_setpoints(now, out);
        self.follow_tests(now, out);
        self.miss_supervisor(now, out);
        self.repeat_pressures(now, out);
        if !self.connected {
            return;
        }
        if self.births.due().is_some_and(|due| due <= now.at) {
            self.announce(now, out);
        }
        self.resend(now, out);
        if self.supervision.waits(self.messages_kept() > 0, now.at) {
            out.push(Output::Warn(self.unanswered()));
        }
        self.ask_back(out);
        self.know_chambers(now);
        self.report_change(now);
        if self.status_at <= now.at {
            self.status(now, out);
        }
    }

    /// Latest moment of the next step.
    #[must_use]
    pub fn next_deadline(&self) -> Moment {
        let connected = |at: Option<Moment>| at.filter(|_| self.connected);
        let chambers = self.chambers.iter();
        [
            self.batch_until,
            self.supervision.lost_at(),
            self.drivers.iter().filter_map(Driver::silent_at).min(),
            self.repeat_at(),
            self.blind_at(),
            chambers.clone().filter_map(Chamber::fails_at).min(),
            // Only a status says it.
            connected(chambers.clone().filter_map(Chamber::silent_at).min()),
            chambers.filter_map(Chamber::values_until).min(),
            self.under_way.iter().map(|one| one.until).min(),
            connected(self.births.due()),
            connected(self.supervision.unanswered_at()),
            connected(Some(self.unknown_until.unwrap_or(self.status_at))),
            connected(self.outbox.resend_at()),
            connected(self.earlier.iter().filter_map(|boot| boot.outbox.resend_at()).min()),
        ]
        .into_iter()
        .flatten()
        .min()
        .unwrap_or(Moment::NEVER)
    }

    fn receive(&mut self, topic: RobotTopic, payload: &[u8], now: Now, out: &mut Vec<Output>) {
        let Ok(message) = decode(&topic.of(&self.fleet, &self.robot), payload) else {
            self.counts.messages_refused += 1;
            return;
        };
        match message {
            Message::Receipt(receipt) => self.receipt(&receipt, now, out),
            Message::Setpoint(setpoint) => self.setpoint(&setpoint, now, out),
            // The broker keeps the last one: at each connection it comes again, even if its supervisor is gone.
            Message::Estimate(estimate) if !self.estimates.takes(&estimate) => return,
            Message::Estimate(estimate) => self.estimate(&estimate, out),
            Message::Request(request) => match (request.request, request.touch_test) {
                (_, Some(test)) => self.touch_test(test, now, out),
                (RequestKind::Factsheet, None) => self.factsheet_asked(now, out),
                (RequestKind::Status, None) => self.status(now, out),
                // A request for a test without the test is refused when it is decoded.
                (RequestKind::TouchTest, None) => {}
            },
            // A robot does not subscribe to robots' topics, nor to those of tools.
            Message::Connection(_)
            | Message::Factsheet(_)
            | Message::Contacts(_)
            | Message::Status(_)
            | Message::SetpointState(_)
            | Message::TestState(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => {
                self.counts.messages_refused += 1;
                return;
            }
        }
        if self.supervision.is_unanswered() {
            out.push(Output::Warn("a supervisor answers".to_owned()));
        }
        self.supervision.heard(now.at);
    }

    /// It is no sign of the fleet's owner: a supervisor whose lease has just ended may have sent it.
    fn requested_of_all(&mut self, payload: &[u8], random: u64, now: Now) {
        let topic = Topic::SupervisorRequest { fleet: self.fleet.clone() };
        let Ok(Message::SupervisorRequest(request)) = decode(&topic, payload) else {
            self.counts.messages_refused += 1;
            return;
        };
        match request.request {
            SupervisorRequestKind::Birth => self.births.requested(now.at, random % (DELAY_MAX_US * 9 / 10)),
        }
    }

    /// Last will for the next connection.
    #[must_use]
    pub fn will(&self, now: Now) -> Vec<u8> {
        vibrissa_protocol::encode(&self.voice.will(now.stamp_us))
    }

    /// Last message before a clean disconnect.
    #[must_use]
    pub fn farewell(&self, now: Now) -> Option<Vec<u8>> {
        self.connected.then(|| vibrissa_protocol::encode(&self.voice.farewell(now.stamp_us)))
    }

    /// Sends what waits for more contacts, for instance before the end.
    pub fn finish(&mut self, now: Now) -> Vec<Output> {
        let mut out = Vec::new();
        self.flush(now, &mut out);
        out
    }

    /// Fleet of the robot.
    #[must_use]
    pub fn fleet(&self) -> &Name {
        &self.fleet
    }

    /// Name of the robot.
    #[must_use]
    pub fn robot(&self) -> &Name {
        &self.robot
    }

    /// Id of this boot.
    #[must_use]
    pub fn boot_id(&self) -> &BootId {
        self.voice.boot_id()
    }

    /// Counts since the start.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Number of contacts messages without a receipt, those of earlier boots included.
    #[must_use]
    pub fn messages_kept(&self) -> usize {
        self.outbox.len() + self.earlier.iter().map(|boot| boot.outbox.len()).sum::<usize>()
    }

    /// Number of contacts messages dropped because the outbox was full.
    #[must_use]
    pub fn messages_dropped(&self) -> u64 {
        self.outbox.dropped() + self.dropped_earlier
    }
}

#[cfg(test)]
mod tests;
