//! The machine with the connections to its clients, and the delays in between.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rumqttc::{Packet, QoS};
use tokio::sync::Notify;
use tokio::time::Instant;

use super::lanes::{Delay, Lane, Way};
use super::machine::{Effect, Machine};
use super::message::ClientId;
use super::{Limits, LinkId};

/// The broker's end of a connection.
struct Port {
    /// A client in this process; it needs no pings while its lane is open.
    direct: Option<ClientId>,
    /// Packets of the client; `None` is the end of the connection, here and below.
    inbound: Lane<Option<Packet>>,
    outbound: Lane<Option<Packet>>,
    /// Arrivals at the client's side.
    outbox: VecDeque<Packet>,
    /// Nothing follows after the outbox.
    is_ended: bool,
    /// The broker has ended the connection without telling the client.
    is_silent: bool,
    wake: Arc<Notify>,
}

/// State of the broker and its connections.
pub(super) struct Hub {
    pub(super) machine: Machine,
    ports: BTreeMap<LinkId, Port>,
    last_link: u64,
    /// When to look at lanes that wait.
    timers: BTreeSet<(Instant, LinkId, Way)>,
    pub(super) delays: BTreeMap<Way, Delay>,
    /// Messages to clients keep their order within a topic only, as in a cluster of brokers.
    pub(super) topics_overtake: bool,
    /// Clients in this process whose lanes are held, in their next connections, too.
    held: BTreeSet<(ClientId, Way)>,
    random: ChaCha8Rng,
    limits: Limits,
    pub(super) is_accepting: bool,
    is_frozen: bool,
    clock: Arc<Notify>,
    /// Until when the clock sleeps; `None` for ever.
    sleeps_until: Option<Instant>,
}

impl Hub {
    pub(super) fn new(seed: u64, limits: Limits, clock: Arc<Notify>) -> Self {
        let of_machine = ChaCha8Rng::seed_from_u64(seed);
        let mut random = of_machine.clone();
        random.set_stream(1);
        Self {
            machine: Machine::new(limits, of_machine),
            ports: BTreeMap::new(),
            last_link: 0,
            timers: BTreeSet::new(),
            delays: BTreeMap::new(),
            topics_overtake: false,
            held: BTreeSet::new(),
            random,
            limits,
            is_accepting: true,
            is_frozen: false,
            clock,
            sleeps_until: None,
        }
    }

    /// A new connection; `None` if the broker accepts none.
    pub(super) fn open(&mut self, direct: Option<&str>) -> Option<(LinkId, Arc<Notify>)> {
        if !self.is_accepting {
            self.machine.counts.refused_connections += 1;
            return None;
        }
        self.last_link += 1;
        let (link, wake) = (LinkId(self.last_link), Arc::new(Notify::new()));
        let direct = direct.map(ClientId::from);
        let is_held = |way| direct.as_ref().is_some_and(|client| self.held.contains(&(client.clone(), way)));
        let port = Port {
            inbound: Lane::new(is_held(Way::ToBroker)),
            outbound: Lane::new(is_held(Way::ToClient)),
            direct,
            outbox: VecDeque::new(),
            is_ended: false,
            is_silent: false,
            wake: wake.clone(),
        };
        self.ports.insert(link, port);
        Some((link, wake))
    }

    /// The client's side sends a packet, or is gone (`None`).
    pub(super) fn submit(&mut self, now: Instant, link: LinkId, packet: Option<Packet>) {
        let due = now + self.delay(Way::ToBroker);
        let Some(port) = self.ports.get_mut(&link) else { return };
        if packet.is_none() && port.inbound.is_held && !self.machine.knows(link) {
            // No connection comes about through a cut network, and nothing remains of the attempt.
            self.ports.remove(&link);
            return;
        }
        port.inbound.push(due, packet);
        self.pump_in(now, link);
        self.wake_clock();
    }

    /// The next packet at the client's side; `Some(None)` at the end of the connection.
    pub(super) fn received(&mut self, link: LinkId) -> Option<Option<Packet>> {
        let Some(port) = self.ports.get_mut(&link) else { return Some(None) };
        match port.outbox.pop_front() {
            Some(packet) => Some(Some(packet)),
            None => port.is_ended.then_some(None),
        }
    }

    /// Does the due work, and returns when to call this again.
    pub(super) fn advance(&mut self, now: Instant) -> Option<Instant> {
        while let Some((_, link, way)) = self.timers.first().copied().filter(|(at, ..)| *at <= now && !self.is_frozen) {
            self.timers.pop_first();
            match way {
                Way::ToBroker => self.pump_in(now, link),
                Way::ToClient => self.pump_out(now, link),
            }
        }
        if !self.is_frozen {
            for link in self.machine.overdue(now) {
                let port = self.ports.get(&link);
                if port.is_some_and(|port| port.direct.is_some() && !port.inbound.is_held) {
                    self.machine.heard(now, link);
                } else {
                    let effects = self.machine.silent(now, link);
                    self.dispatch(now, effects);
                }
            }
        }
        self.sleeps_until = self.due();
        self.sleeps_until
    }

    fn due(&self) -> Option<Instant> {
        let of_lanes = self.timers.first().map(|(at, ..)| *at);
        of_lanes.into_iter().chain(self.machine.due()).min().filter(|_| !self.is_frozen)
    }

    /// Wakes the clock if something is due earlier than it wakes.
    pub(super) fn wake_clock(&mut self) {
        let due = self.due();
        if due.is_some_and(|due| self.sleeps_until.is_none_or(|until| due < until)) {
            self.sleeps_until = due;
            self.clock.notify_one();
        }
    }

    /// Draws the delay of a packet.
    fn delay(&mut self, way: Way) -> Duration {
        let delay = self.delays.get(&way).copied().unwrap_or_default().draw(&mut self.random);
        self.machine.counts.delayed += u64::from(!delay.is_zero());
        delay
    }

    fn pump_in(&mut self, now: Instant, link: LinkId) {
        while !self.is_frozen
            && let Some(port) = self.ports.get_mut(&link)
        {
            let Some(packet) = port.inbound.take(now) else {
                self.timers.extend(port.inbound.due().map(|due| (due, link, Way::ToBroker)));
                return;
            };
            let is_gone = packet.is_none();
            let effects = if port.is_silent { Vec::new() } else { self.machine.step(now, link, packet) };
            if is_gone {
                self.ports.remove(&link);
            }
            self.dispatch(now, effects);
        }
    }

    fn pump_out(&mut self, now: Instant, link: LinkId) {
        let Some(port) = self.ports.get_mut(&link).filter(|_| !self.is_frozen) else { return };
        while let Some(item) = port.outbound.take(now) {
            match item {
                Some(packet) => port.outbox.push_back(packet),
                None => port.is_ended = true,
            }
            port.wake.notify_one();
        }
        self.timers.extend(port.outbound.due().map(|due| (due, link, Way::ToClient)));
    }

    fn dispatch(&mut self, now: Instant, effects: Vec<Effect>) {
        for Effect { link, packet } in effects {
            let due = now + self.delay(Way::ToClient);
            let Some(port) = self.ports.get_mut(&link) else { continue };
            let is_droppable = matches!(&packet, Some(Packet::Publish(publish)) if publish.qos == QoS::AtMostOnce);
            if is_droppable && port.outbound.len() + port.outbox.len() >= self.limits.queued_max {
                self.machine.counts.dropped_for_room += 1;
                continue;
            }
            match self.topics_overtake {
                true => port.outbound.overtake(due, packet, follows),
                false => port.outbound.push(due, packet),
            }
            self.pump_out(now, link);
        }
    }

    /// Looks at all lanes again.
    fn pump_all(&mut self, now: Instant) {
        for link in self.ports.keys().copied().collect::<Vec<_>>() {
            self.pump_in(now, link);
            self.pump_out(now, link);
        }
        self.wake_clock();
    }

    /// Ends the connections of a client, or all, with their wills.
    pub(super) fn end(&mut self, now: Instant, client: Option<&str>, is_silent: bool) {
        for link in self.machine.links_of(client) {
            let effects = self.machine.step(now, link, None);
            if let Some(port) = self.ports.get_mut(&link).filter(|_| is_silent) {
                port.is_silent = true;
                self.machine.counts.ended_silently += 1;
            } else {
                self.cut_off(now, link);
                self.machine.counts.ended += 1;
            }
            self.dispatch(now, effects);
        }
        self.wake_clock();
    }

    /// Ends all connections without wills; what is on its way is lost. The new process is not frozen.
    pub(super) fn restart(&mut self, now: Instant, forgets_everything: bool) {
        self.is_frozen = false;
        self.machine.restart(now, forgets_everything);
        for link in self.ports.keys().copied().collect::<Vec<_>>() {
            self.cut_off(now, link);
        }
    }

    /// Ends a connection with all that is on its way. A client behind a cut learns of it after the healing.
    fn cut_off(&mut self, now: Instant, link: LinkId) {
        let Some(port) = self.ports.get_mut(&link) else { return };
        port.is_silent = true;
        port.inbound.clear();
        port.outbound.clear();
        port.outbound.push(now, None);
        self.pump_out(now, link);
    }

    /// Holds or releases a direction of a client in this process.
    pub(super) fn hold(&mut self, now: Instant, client: &str, way: Way, is_held: bool) {
        let client = ClientId::from(client);
        for port in self.ports.values_mut().filter(|port| port.direct.as_ref() == Some(&client)) {
            match way {
                Way::ToBroker => port.inbound.is_held = is_held,
                Way::ToClient => port.outbound.is_held = is_held,
            }
        }
        if is_held {
            self.machine.counts.holds += u64::from(self.held.insert((client, way)));
        } else {
            self.held.remove(&(client, way));
            self.pump_all(now);
        }
    }

    /// Stops all work, or goes on. The time in between counts for no keep-alive.
    pub(super) fn freeze(&mut self, now: Instant, is_frozen: bool) {
        let was_frozen = std::mem::replace(&mut self.is_frozen, is_frozen);
        if was_frozen && !is_frozen {
            for link in self.machine.links_of(None) {
                self.machine.heard(now, link);
            }
            self.pump_all(now);
        }
        self.machine.counts.freezes += u64::from(is_frozen && !was_frozen);
    }
}

/// Whether a packet must not overtake another one in a cluster of brokers: only messages of different topics overtake each
/// other.
fn follows(packet: &Option<Packet>, other: &Option<Packet>) -> bool {
    match (packet, other) {
        (Some(Packet::Publish(one)), Some(Packet::Publish(other))) => one.topic == other.topic,
        _ => true,
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        // Ends the clock.
        self.clock.notify_one();
    }
}
