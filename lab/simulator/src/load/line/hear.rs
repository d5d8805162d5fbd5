//! Incoming packets: acknowledgements, receipts, setpoints, requests.

use std::io;

use tokio::time::Instant;
use vibrissa_protocol::{
    Name, Receipt, Request, RequestKind, RobotTopic, Setpoint, SupervisorRequest, SupervisorRequestKind,
};

use super::Line;
use crate::clock::now_us;
use crate::load::packet::{self, Inbound, Incoming};

impl Line {
    /// Reads and handles the available packets.
    pub(super) fn read(&mut self) -> io::Result<()> {
        match self.stream.try_read(self.inbound.space()) {
            Ok(0) => return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the broker closed the connection")),
            Ok(count) => self.inbound.filled(count),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(()),
            Err(error) => return Err(error),
        }
        let mut inbound = std::mem::replace(&mut self.inbound, Inbound::none());
        let mut taken = Ok(());
        while let (Ok(()), Some(packet)) = (&taken, inbound.next_packet()?) {
            taken = self.take(packet);
        }
        self.inbound = inbound;
        taken
    }

    fn take(&mut self, packet: Incoming<'_>) -> io::Result<()> {
        match packet {
            Incoming::ConnAck(0) | Incoming::SubAck | Incoming::PingResponse => {
                self.waited_for = self.waited_for.saturating_sub(1);
                self.heard = Instant::now();
            }
            Incoming::ConnAck(code) => {
                return Err(io::Error::other(format!("the broker refused the connection (code {code})")));
            }
            Incoming::PubAck => {
                self.in_flight = self.in_flight.saturating_sub(1);
                self.heard = Instant::now();
            }
            Incoming::Publish { topic, id, payload } => {
                if let Some(id) = id {
                    packet::acknowledge(&mut self.out, id);
                }
                self.hear(topic, payload);
            }
        }
        Ok(())
    }

    /// Handles a message of the supervisor to one of the robots; ignores all others.
    fn hear(&mut self, topic: &[u8], payload: &[u8]) {
        let now_us = now_us();
        let mut levels = topic.rsplit(|&byte| byte == b'/');
        let (kind, robot) = (levels.next().unwrap_or_default(), levels.next().unwrap_or_default());
        if robot == Name::RESERVED.as_bytes() {
            return self.hear_request_to_all(payload, now_us);
        }
        let number =
            robot.strip_prefix(b"r").and_then(|digits| std::str::from_utf8(digits).ok()?.parse::<usize>().ok());
        let at = number
            .and_then(|number| number.checked_sub(self.index))
            .map(|number| number / self.common.plan.connections);
        let Some(at) = at.filter(|&at| at < self.robots.len()) else { return };
        if kind == RobotTopic::Receipt.as_str().as_bytes() {
            self.hear_receipt(at, payload, now_us);
        } else if kind == RobotTopic::Setpoint.as_str().as_bytes() {
            self.hear_setpoint(at, payload, now_us);
        } else if kind == RobotTopic::Estimate.as_str().as_bytes() {
            // Its contacts have the ratio to the true length: it needs no estimate.
        } else if let Ok(request) = serde_json::from_slice::<Request>(payload) {
            match request.request {
                RequestKind::Factsheet => {
                    let factsheet = self.robots[at].factsheet(now_us);
                    self.publish(at, RobotTopic::Factsheet, &factsheet);
                }
                RequestKind::Status => self.publish_status(at, now_us),
                // Its factsheet names no touch test.
                RequestKind::TouchTest => {}
            }
        }
    }

    /// Handles a request to all robots: each answers at a time of its own.
    fn hear_request_to_all(&mut self, payload: &[u8], now_us: u64) {
        let Ok(request) = serde_json::from_slice::<SupervisorRequest>(payload) else { return };
        match request.request {
            SupervisorRequestKind::Birth => self.robots.iter_mut().for_each(|robot| robot.birth_requested(now_us)),
        }
    }

    fn hear_receipt(&mut self, at: usize, payload: &[u8], now_us: u64) {
        let Ok(receipt) = serde_json::from_slice::<Receipt>(payload) else { return };
        if receipt.robot_boot_id != self.common.boot_id {
            return;
        }
        let covered = self.robots[at].outbox.receipt(now_us, receipt.next, &receipt.held);
        if covered > 0 {
            self.uncovered -= covered;
            self.counts.receipted += covered as u64;
            self.counts.last_receipt_us = now_us;
            self.heard = Instant::now();
        }
    }

    fn hear_setpoint(&mut self, at: usize, payload: &[u8], now_us: u64) {
        let Ok(setpoint) = serde_json::from_slice::<Setpoint>(payload) else { return };
        let Some((whisker, answers)) = self.robots[at].apply(&setpoint, now_us) else { return };
        self.counts.setpoints += 1;
        self.counts.latencies_us.extend(self.robots[at].cuts.take(whisker, &setpoint, now_us));
        for answer in answers {
            self.publish(at, RobotTopic::SetpointState, &answer);
        }
    }
}
