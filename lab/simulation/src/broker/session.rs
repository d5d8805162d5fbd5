//! The session of a client: what waits for it, and what it has not acknowledged.

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use rumqttc::{ConnectProperties, Publish, QoS};
use tokio::time::Instant;

use super::message::{ClientId, Delivery};
use super::report::Counts;
use super::{Limits, LinkId};

/// Largest packet of the protocol, in bytes.
const PROTOCOL_PACKET_MAX: usize = 268_435_460;
/// A session expiry of this many seconds means never.
const NEVER_S: u32 = u32::MAX;

/// Session of a client, connected or away.
#[derive(Debug, Default)]
pub(super) struct Session {
    /// Its present connection.
    pub(super) link: Option<LinkId>,
    /// How long it outlives a connection; `None` for ever.
    lifetime: Option<Duration>,
    /// When it ends while its client is away.
    ends: Option<Instant>,
    /// Deliveries that are not sent, in their order.
    queue: VecDeque<Delivery>,
    /// Deliveries that are sent and not acknowledged, in their order.
    in_flight: VecDeque<Delivery>,
    /// Packet identifiers of the deliveries that were sent and are not acknowledged, in this connection or an earlier one.
    ids: BTreeSet<u16>,
    last_id: u16,
    /// Limit of `in_flight`: the client's receive maximum, and the broker's limit.
    window: usize,
    /// Largest packet that the client accepts, in bytes.
    packet_max: usize,
}

impl Session {
    /// The client has connected. Deliveries of the last connection without an acknowledgement are repeated first.
    pub(super) fn begin(&mut self, link: LinkId, properties: &ConnectProperties, limits: &Limits) {
        self.link = Some(link);
        self.ends = None;
        self.live_for(properties.session_expiry_interval.unwrap_or(0));
        self.window = properties.receive_maximum.unwrap_or(u16::MAX).min(limits.in_flight_max).into();
        self.packet_max = properties.max_packet_size.map_or(PROTOCOL_PACKET_MAX, |bytes| bytes as usize);
        for mut delivery in std::mem::take(&mut self.in_flight).into_iter().rev() {
            delivery.dup = true;
            self.queue.push_front(delivery);
        }
    }

    /// Sets how long the session outlives its connection, s.
    pub(super) fn live_for(&mut self, seconds: u32) {
        self.lifetime = (seconds != NEVER_S).then(|| Duration::from_secs(seconds.into()));
    }

    /// The connection has ended.
    pub(super) fn leave(&mut self, now: Instant) {
        self.link = None;
        self.ends = self.lifetime.map(|lifetime| now + lifetime);
    }

    pub(super) fn has_ended(&self, now: Instant) -> bool {
        self.ends.is_some_and(|at| at <= now)
    }

    /// Queues a delivery. If the queue is full, the oldest with QoS 0 makes room; without one the new delivery is dropped.
    pub(super) fn push(&mut self, delivery: Delivery, limits: &Limits, counts: &mut Counts) {
        if self.queue.len() >= limits.queued_max {
            counts.dropped_for_room += 1;
            let Some(at) = self.queue.iter().position(|waiting| waiting.qos == QoS::AtMostOnce) else { return };
            self.queue.remove(at);
        }
        self.queue.push_back(delivery);
    }

    /// Takes the next packet to send, with its publisher. Messages that have expired or are too large are dropped.
    pub(super) fn next(&mut self, now: Instant, counts: &mut Counts) -> Option<(Publish, ClientId)> {
        loop {
            let is_acknowledged = self.queue.front()?.qos != QoS::AtMostOnce;
            if is_acknowledged && self.in_flight.len() >= self.window {
                return None;
            }
            let mut delivery = self.queue.pop_front()?;
            let has_expired = delivery.message.has_expired(now);
            let id = if is_acknowledged { delivery.id.unwrap_or_else(|| self.fresh_id()) } else { 0 };
            let packet = delivery.packet(now, id);
            if has_expired || packet.size() > self.packet_max {
                counts.expired += u64::from(has_expired);
                counts.too_large += u64::from(!has_expired);
                self.ids.remove(&id);
                continue;
            }
            let from = delivery.message.from.clone();
            if is_acknowledged {
                delivery.id = Some(id);
                self.in_flight.push_back(delivery);
            }
            return Some((packet, from));
        }
    }

    /// A packet identifier that no delivery has. The window is smaller than their number.
    fn fresh_id(&mut self) -> u16 {
        loop {
            self.last_id = self.last_id.checked_add(1).unwrap_or(1);
            if self.ids.insert(self.last_id) {
                return self.last_id;
            }
        }
    }

    /// The client has acknowledged a delivery.
    pub(super) fn acknowledged(&mut self, id: u16) {
        if let Some(at) = self.in_flight.iter().position(|delivery| delivery.id == Some(id)) {
            self.in_flight.remove(at);
            self.ids.remove(&id);
        }
    }
}
