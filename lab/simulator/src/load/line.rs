//! One connection to the broker, with its share of the robots.

mod hear;

use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until};
use vibrissa_core::mechanics::ModelError;
use vibrissa_host::task;
use vibrissa_protocol::{BootId, ConnectionState, QualityOfService, RobotTopic, Topic, decode_contacts, encode_cbor};

use super::packet::{self, Inbound, Manner};
use super::plan::{LoadPlan, Quality};
use super::robots::Robot;
use super::texts::Texts;
use crate::clock::now_us;

/// Size of the output buffer up to which messages are added, in bytes.
const OUT_BYTES: usize = 64 * 1024;
/// Period of the checks for messages to send again and for due statuses.
const ROUND_US: u64 = 20_000;
/// Pause between two reads in a burst.
const PAUSE: Duration = Duration::from_micros(500);

/// Data that all connections share.
#[derive(Debug, Clone)]
pub(super) struct Common {
    pub(super) plan: Arc<LoadPlan>,
    pub(super) texts: Arc<Texts>,
    pub(super) boot_id: BootId,
    pub(super) address: String,
}

/// New messages to send, with their schedule.
#[derive(Debug, Clone)]
pub(super) struct Task {
    /// Number of messages of this connection's robots together.
    pub(super) messages: u64,
    /// Number of contacts in each message.
    pub(super) contacts: usize,
    /// Start time in microseconds, and messages per second of this connection; `None` for as fast as possible.
    pub(super) schedule: Option<(f64, f64)>,
    /// Whether whiskers are cut.
    pub(super) cuts: bool,
}

/// Counters since the last [`Line::take_counts`].
#[derive(Debug, Clone, Default)]
pub(super) struct Counts {
    pub(super) sent: u64,
    pub(super) sent_again: u64,
    pub(super) receipted: u64,
    pub(super) first_sent_us: u64,
    pub(super) last_receipt_us: u64,
    pub(super) setpoints: u64,
    pub(super) latencies_us: Vec<u64>,
}

pub(super) struct Line {
    common: Common,
    index: usize,
    stream: TcpStream,
    inbound: Inbound,
    out: Vec<u8>,
    written: usize,
    payload: Vec<u8>,
    topic: Vec<u8>,
    robots: Vec<Robot>,
    turn: usize,
    packet_id: u16,
    in_flight: usize,
    /// The window was full. Sending resumes once a quarter of it is free, or else each acknowledgement would lead
    /// to a write.
    is_full: bool,
    uncovered: usize,
    /// Number of other acknowledgements that are still to come.
    waited_for: usize,
    round_at_us: u64,
    heard: Instant,
    counts: Counts,
}

impl Line {
    /// Connects, and subscribes to the topics of its robots.
    pub(super) async fn connect(common: Common, index: usize) -> io::Result<Self> {
        let stream = TcpStream::connect(&common.address).await?;
        stream.set_nodelay(true)?;
        let plan = &common.plan;
        let numbers = (index..plan.robots).step_by(plan.connections);
        let robots: Vec<Robot> = numbers.map(|number| Robot::new(plan, number, &common.boot_id)).collect();
        let mut line = Self {
            index,
            stream,
            inbound: Inbound::default(),
            out: Vec::with_capacity(2 * OUT_BYTES),
            written: 0,
            payload: Vec::new(),
            topic: Vec::new(),
            robots,
            turn: 0,
            packet_id: 0,
            in_flight: 0,
            is_full: false,
            uncovered: 0,
            waited_for: 1,
            round_at_us: 0,
            heard: Instant::now(),
            counts: Counts::default(),
            common,
        };
        packet::connect(&mut line.out, &format!("{}-{index}", line.common.boot_id));
        line.settle().await?;
        if !line.common.plan.no_receipts {
            let heard = [RobotTopic::Receipt, RobotTopic::Setpoint, RobotTopic::Request, RobotTopic::Estimate];
            let of = |robot: &Robot| heard.map(|kind| format!("{}{kind}", robot.level));
            let to_all = Topic::SupervisorRequest { fleet: line.common.plan.fleet.clone() }.to_string();
            let filters: Vec<String> = line.robots.iter().flat_map(of).chain([to_all]).collect();
            line.waited_for = packet::subscribe(&mut line.out, &filters);
            line.settle().await?;
        }
        Ok(line)
    }

    /// Number of robots of this connection.
    pub(super) fn robots(&self) -> usize {
        self.robots.len()
    }

    /// Counters since the last call.
    pub(super) fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.counts)
    }

    /// Number of cut whiskers that got no setpoint.
    pub(super) fn missed(&self) -> u64 {
        self.robots.iter().map(|robot| robot.cuts.missed).sum()
    }

    /// Publishes births, factsheets and statuses of all robots.
    pub(super) async fn introduce(&mut self) -> io::Result<()> {
        for at in 0..self.robots.len() {
            let now_us = now_us();
            self.publish_birth(at, now_us);
            self.publish_status(at, now_us);
            if self.out.len() > OUT_BYTES {
                self.settle().await?;
            }
        }
        self.settle().await
    }

    /// Publishes the farewells of all robots, and disconnects.
    pub(super) async fn end(&mut self) -> io::Result<()> {
        for at in 0..self.robots.len() {
            let farewell = self.robots[at].connection(now_us(), ConnectionState::Offline);
            self.publish(at, RobotTopic::Connection, &farewell);
        }
        self.settle().await?;
        self.out.extend_from_slice(&packet::DISCONNECT);
        while self.flush()? {
            self.stream.writable().await?;
        }
        Ok(())
    }

    /// Sends new messages, and unreceipted ones again, until all are receipted.
    pub(super) async fn work(&mut self, mut task: Task) -> io::Result<()> {
        loop {
            let now_us = now_us();
            if now_us >= self.round_at_us {
                self.go_round(now_us, task.contacts);
            }
            self.send_new(&mut task, now_us)?;
            let is_unwritten = self.flush()?;
            let is_covered = if self.common.plan.no_receipts { self.in_flight == 0 } else { self.uncovered == 0 };
            if task.messages == 0 && is_covered && !is_unwritten {
                break;
            }
            if task.schedule.is_none() && task.messages > 0 && !is_unwritten && self.may_send(&task, now_us) {
                // The buffer was the limit: let the other connections run, then continue.
                tokio::task::yield_now().await;
                self.read()?;
                continue;
            }
            if task.schedule.is_none() {
                // A blocking sleep: an await would wake up for each acknowledgement and interrupt a broker on the
                // same core.
                task::block_for(PAUSE);
            }
            let next_us = task.due_at_us().map_or(self.round_at_us, |at_us| at_us.min(self.round_at_us));
            self.wait(Duration::from_micros(next_us.saturating_sub(now_us)), is_unwritten).await?;
        }
        // The broker answers the ping after it has received all QoS 0 messages.
        self.out.extend_from_slice(&packet::PING);
        self.waited_for += 1;
        self.settle().await
    }

    /// Writes and reads until all acknowledgements have arrived.
    async fn settle(&mut self) -> io::Result<()> {
        loop {
            let is_unwritten = self.flush()?;
            if !is_unwritten && self.waited_for == 0 && self.in_flight == 0 {
                return Ok(());
            }
            self.wait(Duration::from_millis(20), is_unwritten).await?;
        }
    }

    /// Adds new messages as far as windows, schedule and buffer allow.
    fn send_new(&mut self, task: &mut Task, now_us: u64) -> io::Result<()> {
        let window = self.common.plan.window;
        self.is_full &= self.in_flight > window - window / 4;
        while task.messages > 0 && self.out.len() < OUT_BYTES && self.may_send(task, now_us) {
            let at = self.turn;
            self.turn = (self.turn + 1) % self.robots.len();
            self.send_next(at, task, now_us).map_err(io::Error::other)?;
            task.messages -= 1;
            if let Some((at_us, rate)) = &mut task.schedule {
                *at_us += 1e6 / *rate;
            }
        }
        self.is_full |= self.in_flight >= window;
        Ok(())
    }

    fn may_send(&self, task: &Task, now_us: u64) -> bool {
        let plan = &self.common.plan;
        match task.schedule {
            Some((at_us, _)) => at_us <= now_us as f64,
            None => {
                let has_window = plan.qos == Quality::AtMostOnce || (!self.is_full && self.in_flight < plan.window);
                has_window && (plan.no_receipts || self.uncovered < plan.unreceipted().div_ceil(plan.connections))
            }
        }
    }

    /// Adds the next contacts message of a robot.
    fn send_next(&mut self, at: usize, task: &Task, now_us: u64) -> Result<(), ModelError> {
        let seq = self.robots[at].outbox.next_seq();
        let cut = if task.cuts { self.cut_reading(at, seq, now_us)? } else { None };
        self.payload.clear();
        let texts = self.common.texts.clone();
        match &cut {
            Some((whisker, reading)) => texts.single(&mut self.payload, seq, *whisker, now_us, reading),
            None => texts.ordinary(&mut self.payload, (self.robots[at].number, seq), now_us, task.contacts),
        }
        let kept = cut.map(|_| self.payload.clone().into_boxed_slice());
        self.robots[at].outbox.keep(now_us, kept);
        if self.common.plan.no_receipts {
            // Without receipts the message counts as covered, so that nothing is stored.
            self.robots[at].outbox.receipt(now_us, seq + 1, &[]);
        } else {
            self.uncovered += 1;
        }
        self.publish_payload(at);
        self.counts.sent += 1;
        if self.counts.first_sent_us == 0 {
            self.counts.first_sent_us = now_us;
        }
        Ok(())
    }

    /// Whisker and reading, if the message is one of a cut whisker.
    fn cut_reading(&mut self, at: usize, seq: u64, now_us: u64) -> Result<Option<(usize, Vec<u8>)>, ModelError> {
        let plan = &self.common.plan;
        let robot = &mut self.robots[at];
        let is_its_turn = plan.trim_every.is_some_and(|every| seq.is_multiple_of(every));
        let active = if is_its_turn { robot.cuts.active(robot.number, plan.whiskers, now_us)? } else { None };
        let whisker = active.unwrap_or((seq % plan.whiskers as u64) as usize);
        Ok(robot.cuts.touch(whisker, now_us).map(|reading| (whisker, reading)))
    }

    /// Sends due messages again, and due statuses.
    fn go_round(&mut self, now_us: u64, contacts: usize) {
        self.round_at_us = now_us + ROUND_US;
        let texts = self.common.texts.clone();
        for at in 0..self.robots.len() {
            for seq in self.robots[at].outbox.resend(now_us) {
                let robot = &self.robots[at];
                let Some(kept) = robot.outbox.get(seq) else { continue };
                self.payload.clear();
                match &kept.payload {
                    Some(payload) => self.payload.extend_from_slice(payload),
                    None => texts.ordinary(&mut self.payload, (robot.number, seq), kept.felt_us, contacts),
                }
                self.publish_payload(at);
                self.counts.sent_again += 1;
            }
            if now_us >= self.robots[at].status_at_us {
                self.publish_status(at, now_us);
            }
            if self.robots[at].takes_birth(now_us) {
                self.publish_birth(at, now_us);
            }
        }
    }

    /// Publishes birth and factsheet of a robot.
    fn publish_birth(&mut self, at: usize, now_us: u64) {
        let birth = self.robots[at].connection(now_us, ConnectionState::Online);
        self.publish(at, RobotTopic::Connection, &birth);
        let factsheet = self.robots[at].factsheet(now_us);
        self.publish(at, RobotTopic::Factsheet, &factsheet);
    }

    fn publish_status(&mut self, at: usize, now_us: u64) {
        let status = self.robots[at].status(now_us);
        self.publish(at, RobotTopic::Status, &status);
        let every_us = (self.common.plan.status_every_s * 1e6) as u64;
        // The first statuses are spread over the period, so that the robots do not send at the same time.
        let first = self.robots[at].status_at_us == 0;
        let pause_us = if first { every_us * (at as u64 + 1) / self.robots.len() as u64 } else { every_us };
        self.robots[at].status_at_us = now_us + pause_us;
    }

    /// Publishes `payload` as contacts of a robot.
    fn publish_payload(&mut self, at: usize) {
        let payload = std::mem::take(&mut self.payload);
        // The texts are made of prepared pieces of JSON.
        let cbor = self.common.plan.cbor.then(|| decode_contacts(&payload, Vec::new()).ok()).flatten();
        match cbor {
            Some(message) => self.publish(at, RobotTopic::Contacts, &encode_cbor(&message)),
            None => self.publish(at, RobotTopic::Contacts, &payload),
        }
        self.payload = payload;
    }

    fn publish(&mut self, at: usize, kind: RobotTopic, payload: &[u8]) {
        let is_acknowledged = if kind == RobotTopic::Contacts {
            self.common.plan.qos == Quality::AtLeastOnce
        } else {
            kind.quality_of_service() == QualityOfService::AtLeastOnce
        };
        let id = is_acknowledged.then(|| {
            self.in_flight += 1;
            self.packet_id = self.packet_id.checked_add(1).unwrap_or(1);
            self.packet_id
        });
        self.topic.clear();
        self.topic.extend_from_slice(self.robots[at].level.as_bytes());
        self.topic.extend_from_slice(kind.as_str().as_bytes());
        packet::publish(
            &mut self.out,
            &self.topic,
            Manner { id, retain: kind.is_retained() && !self.common.plan.no_retained },
            payload,
        );
    }

    /// Writes as much as possible; returns whether data is left.
    fn flush(&mut self) -> io::Result<bool> {
        while self.written < self.out.len() {
            match self.stream.try_write(&self.out[self.written..]) {
                Ok(count) => self.written += count,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(true),
                Err(error) => return Err(error),
            }
        }
        self.out.clear();
        self.written = 0;
        Ok(false)
    }

    /// Waits until data arrives, data can be written again, or the pause is over.
    async fn wait(&mut self, pause: Duration, is_unwritten: bool) -> io::Result<()> {
        if self.heard.elapsed().as_secs_f64() > self.common.plan.patience_s {
            return Err(io::Error::new(io::ErrorKind::TimedOut, "no answer from the broker or the supervisor"));
        }
        tokio::select! {
            readable = self.stream.readable() => {
                readable?;
                self.read()
            }
            writable = self.stream.writable(), if is_unwritten => writable,
            () = sleep_until(Instant::now() + pause) => Ok(()),
        }
    }
}

impl Task {
    /// Time of the next message by the schedule.
    fn due_at_us(&self) -> Option<u64> {
        self.schedule.filter(|_| self.messages > 0).map(|(at_us, _)| at_us as u64)
    }
}
