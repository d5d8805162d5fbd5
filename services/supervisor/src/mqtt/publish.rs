//! The publishing connection: setpoints, receipts, requests, estimates, and the presence of the supervisor.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::Duration;

use rumqttc::{AsyncClient, Event, LastWill, Outgoing, Packet, PublishOptions, QoS};
use tokio::sync::{mpsc, watch};
use tokio::task::{JoinHandle, JoinSet};
use tokio::time::Instant;
use tokio::time::{MissedTickBehavior, interval_at, timeout};
use tracing::warn;
use vibrissa_edge::invariants::{Invariant, is_epoch_once};
use vibrissa_host::task;
use vibrissa_protocol::{
    BootId, Message, Name, QualityOfService, SupervisorPresence, SupervisorState, Topic, decode, encode,
};

use super::Connection;
use super::encoded::Encoded;
use super::identity::client_id;
use super::link::Side;
use super::nodes::Attempts;
use super::poll::{Failure, Poller};
use super::proofs::Proofs;
use crate::metrics::{FleetMetrics, PUBLISHING};
use crate::outbox::{Losses, Publication};

/// Capacity of the client's queue of publications: as many as one write takes. The client sends a queued publication
/// without regard to its age.
const WAITING: usize = super::WRITE_BATCH;
/// How often a wait for the connection checks whether the outbox is closed.
const LOOK: Duration = Duration::from_millis(100);
/// How often the supervisor states again that it is online, for clients of a broker that has forgotten it.
const PRESENCE_INTERVAL: Duration = Duration::from_secs(5);
/// Time limit for the farewell.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(2);

const ROLE: &str = "out";

/// Publishes messages from `outbox` until it is closed, then announces that the supervisor is offline. Expired messages
/// are counted and dropped. `losses` notes messages that may not have reached the broker.
pub fn publish(
    connection: &Connection,
    metrics: FleetMetrics,
    mut outbox: mpsc::Receiver<Publication>,
    losses: Losses,
) -> JoinHandle<()> {
    let connection = &Attempts::first(connection);
    let (expired, dropped) = (metrics.setpoints_expired_unsent.clone(), metrics.publications_dropped.clone());
    let (promises, fleet) = (metrics.promises.clone(), connection.fleet.clone());
    let mut proofs = Proofs::new(connection);
    let (topic, offline) = presence(connection, SupervisorPresence::Offline, 1);
    let (mut options, reached) = connection.options(ROLE);
    options.set_last_will(LastWill::new(topic.clone(), offline.clone(), QoS::AtLeastOnce, true, None));
    let (_, online) = presence(connection, SupervisorPresence::Online, 0);
    let (client, events) = AsyncClient::builder(options).capacity(WAITING).build();
    let poller = Poller::new(events, connection, reached);
    let (connected, mut is_connected) = watch::channel(false);
    let signals = Signals { connected, losses: losses.clone(), flags: Arc::default() };
    let flags = signals.flags.clone();
    let keeping_up = keep_up(connection.clone(), metrics.clone(), client.clone(), poller, signals);
    // Ends with the publisher, also with one that is aborted: its connection would go on, and state that this supervisor is online.
    let mut polling = JoinSet::new();
    task::spawn_in(&mut polling, keeping_up);
    task::spawn(async move {
        let mut repeats = interval_at(tokio::time::Instant::now() + PRESENCE_INTERVAL, PRESENCE_INTERVAL);
        repeats.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let publication = tokio::select! {
                publication = outbox.recv() => publication,
                _ = repeats.tick() => {
                    let is_due = *is_connected.borrow() && !flags.outranked.load(Ordering::Relaxed);
                    if is_due {
                        let options = presence_options(flags.retains());
                        let sent = client.publish_tracked(topic.clone(), online.clone(), options).await;
                        let Ok(notice) = sent else { break };
                        proofs.judge(topic.clone(), notice);
                    }
                    continue;
                }
            };
            let Some(publication) = publication else { break };
            if !connection_stands(&mut is_connected, &outbox).await {
                break;
            }
            if publication.is_withdrawn() {
                continue;
            }
            let receipts = u64::from(publication.states_a_commit());
            let encoded = proofs.ask(Encoded::of(publication, &fleet), Instant::now());
            let Some(options) = encoded.options(Instant::now(), flags.retains()) else {
                if encoded.is_retained {
                    dropped.inc();
                    losses.note();
                } else {
                    expired.inc();
                }
                promises.receipted(receipts);
                continue;
            };
            let Encoded { topic, payload, stopwatch, qos, .. } = encoded;
            if !proofs.fits(&topic, payload.len(), flags.packet_bytes_max.load(Ordering::Relaxed)) {
                dropped.inc();
                promises.receipted(receipts);
                continue;
            }
            if qos == QualityOfService::AtMostOnce {
                if client.publish(topic, payload, options).await.is_err() {
                    break;
                }
            } else {
                let Ok(notice) = client.publish_tracked(topic.clone(), payload, options).await else { break };
                proofs.judge(topic, notice);
            }
            promises.receipted(receipts);
            if let Some(stopwatch) = stopwatch {
                stopwatch.stop();
            }
        }
        flags.leaving.store(true, Ordering::Relaxed);
        let farewell = async {
            client.publish(topic, offline, presence_options(flags.retains())).await?;
            client.disconnect().await?;
            // Ends when the disconnect is sent.
            polling.join_next().await;
            Ok::<(), rumqttc::ClientError>(())
        };
        // If this fails, the broker publishes the last will, with the same content.
        let _ = tokio::time::timeout(FAREWELL_TIMEOUT, farewell).await;
        polling.abort_all();
        metrics.mqtt_node.forget(PUBLISHING);
    })
}

/// Waits for the connection. Returns false if the outbox is closed before the connection is up.
///
/// Until then the client gets no publications, because it would queue them and send them too late.
async fn connection_stands(is_connected: &mut watch::Receiver<bool>, outbox: &mpsc::Receiver<Publication>) -> bool {
    if *is_connected.borrow() {
        return true;
    }
    loop {
        match timeout(LOOK, is_connected.wait_for(|&is_connected| is_connected)).await {
            Ok(stands) => return stands.is_ok(),
            Err(_) if outbox.is_closed() => return false,
            Err(_) => {}
        }
    }
}

/// What the polling task tells the others, and hears from them.
struct Signals {
    /// Whether the connection is up.
    connected: watch::Sender<bool>,
    losses: Losses,
    flags: Arc<Flags>,
}

/// State that both tasks share.
#[derive(Debug, Default)]
struct Flags {
    /// The supervisor leaves.
    leaving: AtomicBool,
    /// A supervisor with a higher epoch has spoken: it owns the fleet.
    outranked: AtomicBool,
    /// The broker retains no messages.
    forgets: AtomicBool,
    /// Size of the largest packet that the broker accepts.
    packet_bytes_max: AtomicU32,
}

impl Flags {
    /// Whether the broker retains messages.
    fn retains(&self) -> bool {
        !self.forgets.load(Ordering::Relaxed)
    }
}

/// Polls the client, reconnects it, and announces after each connection that the supervisor is online.
///
/// The client keeps its id when it reconnects, so that the broker ends the old connection before it accepts the new
/// one. Otherwise the last will of the old connection could come later, and say that the supervisor has gone. The id
/// changes only if another client knows it, or may know it; then the broker has already ended the old connection.
async fn keep_up(
    mut connection: Connection,
    metrics: FleetMetrics,
    client: AsyncClient,
    mut poller: Poller,
    Signals { connected, losses, flags }: Signals,
) {
    let (topic, online) = presence(&connection, SupervisorPresence::Online, 0);
    let mut attempts = Attempts::new();
    let proofs = Proofs::new(&connection);
    let mut was_broken = false;
    loop {
        match poller.next().await {
            Ok(Event::Incoming(Packet::ConnAck(ack))) => {
                // With the retain flag, a broker that retains nothing would end the connection (MQTT 5, 3.2.2.3.5).
                let properties = ack.properties.as_ref();
                let is_retaining = properties.and_then(|properties| properties.retain_available) != Some(0);
                let packet_bytes_max = properties.and_then(|properties| properties.max_packet_size);
                flags.packet_bytes_max.store(packet_bytes_max.unwrap_or(u32::MAX), Ordering::Relaxed);
                flags.forgets.store(!is_retaining, Ordering::Relaxed);
                poller.set_will_retained(is_retaining);
                if std::mem::take(&mut was_broken) {
                    losses.note();
                }
                // Not awaited: the polling task must not wait for the queue that polling empties.
                if let Err(problem) = client.try_subscribe(topic.as_str(), QoS::AtLeastOnce) {
                    warn!(%problem, "cannot subscribe to the supervisor's own state");
                }
                say_online(&client, &topic, &online, is_retaining, &proofs);
                connected.send_replace(true);
            }
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                let Some(state) = supervisor_state(&connection, &publish.payload) else { continue };
                note_twin(&connection.fleet, (connection.epoch, &connection.boot_id), &state, &metrics);
                match claim(connection.epoch, &state) {
                    Claim::Outdated if !flags.leaving.load(Ordering::Relaxed) => {
                        say_online(&client, &topic, &online, flags.retains(), &proofs);
                    }
                    Claim::Higher => flags.outranked.store(true, Ordering::Relaxed),
                    Claim::Outdated | Claim::Own => {}
                }
            }
            // Whether the broker accepts publications is noted by topic: see `proofs`.
            Ok(Event::Incoming(Packet::PubAck(_))) => {
                attempts.reset();
                note_connected(&connection, &metrics);
            }
            // The client also disconnects when it refuses the broker's packets. That end is an error of the next poll.
            Ok(Event::Outgoing(Outgoing::Disconnect)) if flags.leaving.load(Ordering::Relaxed) => return,
            Err(Failure::Finished) => return,
            Ok(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) => {}
            Err(Failure::Broken(problem)) => {
                connected.send_replace(false);
                was_broken = true;
                metrics.mqtt_node.forget(PUBLISHING);
                metrics.mqtt_node_failures.count(&problem.node().to_string());
                connection.link.broken(Side::Publishing, &problem);
                if problem.is_takeover() {
                    metrics.mqtt_session_takeovers.inc();
                }
                if problem.is_retain_refused() {
                    poller.set_will_retained(false);
                }
                connection = attempts.next(&connection, &problem).await;
                let is_known = problem.is_takeover() || problem.is_unexplained_end();
                let client_id = is_known.then(|| client_id(&connection.fleet, ROLE));
                poller.renew(&connection, client_id);
            }
        }
    }
}

/// Notes that the connection works.
fn note_connected(connection: &Connection, metrics: &FleetMetrics) {
    let node = connection.broker.node();
    metrics.mqtt_node.set(PUBLISHING, &node.to_string());
    if connection.link.connected(Side::Publishing, &node) {
        metrics.mqtt_connections_closed.inc();
    }
}

fn say_online(client: &AsyncClient, topic: &str, online: &[u8], retains: bool, proofs: &Proofs) {
    match client.try_publish_tracked(topic, online.to_vec(), presence_options(retains)) {
        Ok(notice) => proofs.judge(topic.to_owned(), notice),
        Err(problem) => warn!(%problem, "cannot announce that the supervisor is online"),
    }
}

/// Meaning of a message on the topic of the supervisor's own state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Claim {
    /// This supervisor is online.
    Own,
    /// An earlier owner has spoken late, or the last will of an earlier connection of this supervisor came late. The
    /// message has replaced the retained one.
    Outdated,
    /// A later owner has spoken.
    Higher,
}

/// The state that an owner of the fleet has published; `None` if it cannot be read.
fn supervisor_state(connection: &Connection, payload: &[u8]) -> Option<SupervisorState> {
    let topic = Topic::SupervisorState { fleet: connection.fleet.clone() };
    match decode(&topic, payload) {
        Ok(Message::SupervisorState(state)) => Some(state),
        Ok(_) | Err(_) => None,
    }
}

/// Counts another owner that has our epoch, as a violation.
fn note_twin(fleet: &Name, (epoch, ours): (u64, &BootId), state: &SupervisorState, metrics: &FleetMetrics) {
    let other = &state.boot_id;
    if !is_epoch_once((epoch, ours.as_str()), (state.epoch, other.as_str())) {
        let what = format!("epoch {epoch} is that of boot {ours} here, and of boot {other}");
        metrics.violations.count(Invariant::EpochOnce, fleet, &what);
    }
}

fn claim(epoch: u64, state: &SupervisorState) -> Claim {
    match state.epoch.cmp(&epoch) {
        std::cmp::Ordering::Less => Claim::Outdated,
        std::cmp::Ordering::Equal if state.state == SupervisorPresence::Offline => Claim::Outdated,
        std::cmp::Ordering::Equal => Claim::Own,
        std::cmp::Ordering::Greater => Claim::Higher,
    }
}

fn presence(connection: &Connection, state: SupervisorPresence, seq: u64) -> (String, Vec<u8>) {
    let topic = Topic::SupervisorState { fleet: connection.fleet.clone() };
    let message = SupervisorState { boot_id: connection.boot_id.clone(), seq, state, epoch: connection.epoch };
    (topic.to_string(), encode(&message))
}

/// Retained, if the broker retains messages.
fn presence_options(retains: bool) -> PublishOptions {
    PublishOptions::at_least_once().retain(retains)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metrics;
    use crate::mqtt::{BrokerAddress, Prepared};

    /// A supervisor whose fleet had moved stayed connected, and stated at each reconnection that it was online.
    #[tokio::test]
    async fn regress_nothing_of_a_publisher_that_is_aborted_goes_on() {
        let fleet = Name::new("f").unwrap();
        let metrics = Metrics::new(false).unwrap().of_fleet(&fleet);
        let (broker, boot_id) = (BrokerAddress::new("127.0.0.1", 1), BootId::new("b").unwrap());
        let connection = Connection::new(broker, Prepared::default(), fleet, boot_id);
        let (_outbox, publications) = mpsc::channel(1);
        let losses = Losses::default();
        let publisher = publish(&connection, metrics, publications, losses.clone());
        tokio::task::yield_now().await;
        assert!(losses.holders() > 1, "the tasks have begun");
        publisher.abort();
        assert!(publisher.await.is_err_and(|ended| ended.is_cancelled()));
        // In a runtime of one thread the aborted task is dropped in a turn of its own.
        for _ in 0..100 {
            tokio::task::yield_now().await;
        }
        assert_eq!(losses.holders(), 1, "no task goes on");
    }

    #[test]
    fn an_owner_with_our_epoch_and_another_boot_is_counted_and_no_other() {
        let fleet = Name::new("f").unwrap();
        let metrics = Metrics::new(false).unwrap().of_fleet(&fleet);
        let boot_id = |name: &str| BootId::new(name).unwrap();
        let ours = boot_id("one-7");
        let hears = |epoch, name: &str, presence| {
            let state = SupervisorState { boot_id: boot_id(name), seq: 0, state: presence, epoch };
            note_twin(&fleet, (7, &ours), &state, &metrics);
            (claim(7, &state), metrics.violations.of(Invariant::EpochOnce))
        };
        let (online, offline) = (SupervisorPresence::Online, SupervisorPresence::Offline);
        assert_eq!(hears(7, "one-7", online), (Claim::Own, 0));
        assert_eq!(hears(7, "one-7", offline), (Claim::Outdated, 0), "a last will that came late");
        assert_eq!(hears(6, "two-6", online), (Claim::Outdated, 0));
        assert_eq!(hears(8, "two-8", online), (Claim::Higher, 0));
        assert_eq!(hears(7, "two-7", online), (Claim::Own, 1));
        assert_eq!(hears(7, "two-7", offline), (Claim::Outdated, 2));
    }
}
