//! The broker as a pure state machine: packets and ends of connections in, and out.

mod connections;
mod messages;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rumqttc::{DisconnectReasonCode, Packet, Publish};
use tokio::time::Instant;

use super::message::{ClientId, Message};
use super::report::{Counts, Observed, Observer};
use super::session::Session;
use super::subscriptions::Subscriptions;
use super::{Limits, LinkId};

/// A packet to send on a connection; `None` ends it.
#[derive(Debug)]
pub(super) struct Effect {
    pub(super) link: LinkId,
    pub(super) packet: Option<Packet>,
}

/// A connection whose CONNECT was accepted.
#[derive(Debug)]
struct Link {
    client: ClientId,
    will: Option<Publish>,
    /// The client may be silent for this long; `None` for ever.
    patience: Option<Duration>,
    /// When the client sent its last packet.
    heard: Instant,
}

/// Faults of single messages.
#[derive(Debug, Default)]
pub(super) struct MessageFaults {
    /// Filters of topics on which publications are refused.
    pub(super) refused: BTreeSet<String>,
    /// Probability that a delivery with QoS 1 is repeated.
    pub(super) repetition: f64,
    /// Probability that a delivery with QoS 0 is lost.
    pub(super) loss: f64,
}

/// State of the broker.
pub(super) struct Machine {
    limits: Limits,
    links: BTreeMap<LinkId, Link>,
    sessions: BTreeMap<ClientId, Session>,
    subscriptions: Subscriptions,
    /// Retained messages by topic.
    retained: BTreeMap<String, Message>,
    /// When to look whether a client is silent, one entry for each connection with a keep-alive.
    timers: BTreeSet<(Instant, LinkId)>,
    random: ChaCha8Rng,
    effects: Vec<Effect>,
    /// Number of client ids made up for clients without one.
    nameless: u64,
    pub(super) faults: MessageFaults,
    pub(super) counts: Counts,
    pub(super) observer: Option<Observer>,
}

impl Machine {
    pub(super) fn new(limits: Limits, random: ChaCha8Rng) -> Self {
        Self {
            limits,
            links: BTreeMap::new(),
            sessions: BTreeMap::new(),
            subscriptions: Subscriptions::default(),
            retained: BTreeMap::new(),
            timers: BTreeSet::new(),
            random,
            effects: Vec::new(),
            nameless: 0,
            faults: MessageFaults::default(),
            counts: Counts::default(),
            observer: None,
        }
    }

    /// Takes a packet of a connection; `None` if the connection has ended at the client's side.
    pub(super) fn step(&mut self, now: Instant, link: LinkId, packet: Option<Packet>) -> Vec<Effect> {
        match packet {
            Some(packet) => self.take(now, link, packet),
            None => self.leave(now, link, true),
        }
        std::mem::take(&mut self.effects)
    }

    fn take(&mut self, now: Instant, link: LinkId, packet: Packet) {
        let Some(client) = self.links.get_mut(&link).map(|known| {
            known.heard = now;
            known.client.clone()
        }) else {
            if let Packet::Connect(connect, will, _) = packet {
                self.connect(now, link, connect, will);
            } else {
                self.end(link);
            }
            return;
        };
        match packet {
            Packet::Publish(publish) => self.publish(now, link, &client, publish),
            Packet::PubAck(ack) => {
                if let Some(session) = self.sessions.get_mut(&client) {
                    session.acknowledged(ack.pkid);
                }
                self.flush(now, &client);
            }
            Packet::Subscribe(subscribe) => self.subscribe(now, link, &client, subscribe),
            Packet::Unsubscribe(unsubscribe) => self.unsubscribe(link, &client, unsubscribe),
            Packet::PingReq => self.send(link, Packet::PingResp),
            Packet::Disconnect(disconnect) => self.farewell(now, link, &client, &disconnect),
            Packet::Auth(_)
            | Packet::Connect(..)
            | Packet::ConnAck(_)
            | Packet::PingResp
            | Packet::PubRec(_)
            | Packet::PubRel(_)
            | Packet::PubComp(_)
            | Packet::SubAck(_)
            | Packet::UnsubAck(_) => self.dismiss(now, link, DisconnectReasonCode::ProtocolError),
        }
    }

    /// When to call [`Self::overdue`] next.
    pub(super) fn due(&self) -> Option<Instant> {
        self.timers.first().map(|(at, _)| *at)
    }

    /// Connections whose clients were silent for too long. Each must be heard or dismissed now.
    pub(super) fn overdue(&mut self, now: Instant) -> Vec<LinkId> {
        let mut overdue = Vec::new();
        while let Some((_, link)) = self.timers.first().copied().filter(|(at, _)| *at <= now) {
            self.timers.pop_first();
            let Some(known) = self.links.get(&link) else { continue };
            match known.patience.map(|patience| known.heard + patience) {
                Some(at) if at > now => {
                    self.timers.insert((at, link));
                }
                _ => overdue.push(link),
            }
        }
        overdue
    }

    /// The silence of this client begins now. After [`Self::overdue`] the next timer is needed, too.
    pub(super) fn heard(&mut self, now: Instant, link: LinkId) {
        if let Some(known) = self.links.get_mut(&link) {
            known.heard = now;
            self.timers.extend(known.patience.map(|patience| (now + patience, link)));
        }
    }

    /// Ends the connection of a silent client.
    pub(super) fn silent(&mut self, now: Instant, link: LinkId) -> Vec<Effect> {
        self.counts.keep_alive_timeouts += 1;
        self.dismiss(now, link, DisconnectReasonCode::KeepAliveTimeout);
        std::mem::take(&mut self.effects)
    }

    fn send(&mut self, link: LinkId, packet: Packet) {
        self.effects.push(Effect { link, packet: Some(packet) });
    }

    fn end(&mut self, link: LinkId) {
        self.effects.push(Effect { link, packet: None });
    }

    /// Draws an event of this probability.
    fn draw(&mut self, probability: f64) -> bool {
        probability > 0.0 && self.random.random_bool(probability.min(1.0))
    }

    fn observe(&mut self, at: Instant, from: &str, publish: &Publish, to: Option<&str>) {
        if let Some(observer) = &mut self.observer {
            let topic = std::str::from_utf8(&publish.topic).unwrap_or_default();
            let (payload, qos, is_retained) = (&publish.payload, publish.qos, publish.retain);
            observer(&Observed { at, from, topic, payload, qos, is_retained, to });
        }
    }
}
