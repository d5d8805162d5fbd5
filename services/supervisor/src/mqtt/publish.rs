//! The publishing connection: setpoints, receipts, requests, estimates, and the presence of the supervisor.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rumqttc::{
    AsyncClient, Event, LastWill, Outgoing, Packet, PubAck, PubAckReason, PublishOptions, PublishProperties, QoS,
};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tracing::warn;
use vibrissa_protocol::{Message, QualityOfService, SupervisorPresence, SupervisorState, Topic, decode, encode};

use super::Connection;
use super::identity::client_id;
use super::link::{Backoff, Side};
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem};
use crate::metrics::FleetMetrics;
use crate::outbox::{Losses, Publication};

/// Capacity of the client's queue of publications: as many as one write takes. The client sends a queued publication
/// without regard to its age.
const WAITING: usize = super::WRITE_BATCH;
/// How often a wait for the connection checks whether the outbox is closed.
const LOOK: Duration = Duration::from_millis(100);
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
    let connection = &connection.with_secrets_read_again();
    let (expired, dropped) = (metrics.setpoints_expired_unsent.clone(), metrics.publications_dropped.clone());
    let (topic, offline) = presence(connection, SupervisorPresence::Offline, 1);
    let (mut options, reached) = connection.options(ROLE);
    options.set_last_will(LastWill::new(topic.clone(), offline.clone(), QoS::AtLeastOnce, true, None));
    let (client, events) = AsyncClient::builder(options).capacity(WAITING).build();
    let poller = Poller::new(events, connection, reached);
    let (connected, mut is_connected) = watch::channel(false);
    let leaving = Arc::new(AtomicBool::new(false));
    let signals = Signals { connected, leaving: leaving.clone(), losses: losses.clone() };
    let keeping_up = keep_up(connection.clone(), metrics, client.clone(), poller, signals);
    let mut polling = tokio::spawn(keeping_up);
    tokio::spawn(async move {
        while let Some(publication) = outbox.recv().await {
            if !connection_stands(&mut is_connected, &outbox).await {
                break;
            }
            let Some(options) = options_of(&publication, Instant::now()) else {
                if publication.is_retained {
                    dropped.inc();
                    losses.note();
                } else {
                    expired.inc();
                }
                continue;
            };
            let Publication { topic, payload, stopwatch, .. } = publication;
            if client.publish(topic, payload, options).await.is_err() {
                break;
            }
            if let Some(stopwatch) = stopwatch {
                stopwatch.stop();
            }
        }
        leaving.store(true, Ordering::Relaxed);
        let farewell = async {
            client.publish(topic, offline, retained()).await?;
            client.disconnect().await?;
            // Ends when the disconnect is sent.
            let _ = (&mut polling).await;
            Ok::<(), rumqttc::ClientError>(())
        };
        // If this fails, the broker publishes the last will, with the same content.
        let _ = tokio::time::timeout(FAREWELL_TIMEOUT, farewell).await;
        polling.abort();
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
    /// Whether the supervisor leaves.
    leaving: Arc<AtomicBool>,
    losses: Losses,
}

/// Polls the client, reconnects it, and announces after each connection that the supervisor is online.
///
/// The client keeps its id when it reconnects, so that the broker ends the old connection before it accepts the new
/// one. Otherwise the last will of the old connection could come later, and say that the supervisor has gone. The id
/// changes only if another client knows it, or may know it; then the broker has already ended the old connection.
async fn keep_up(
    connection: Connection,
    metrics: FleetMetrics,
    client: AsyncClient,
    mut poller: Poller,
    Signals { connected, leaving, losses }: Signals,
) {
    let (topic, online) = presence(&connection, SupervisorPresence::Online, 0);
    let mut backoff = Backoff::new();
    let mut was_broken = false;
    loop {
        match poller.next().await {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                if std::mem::take(&mut was_broken) {
                    losses.note();
                }
                // Not awaited: the polling task must not wait for the queue that polling empties.
                if let Err(problem) = client.try_subscribe(topic.as_str(), QoS::AtLeastOnce) {
                    warn!(%problem, "cannot subscribe to the supervisor's own state");
                }
                say_online(&client, &topic, &online);
                connected.send_replace(true);
            }
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                if !leaving.load(Ordering::Relaxed) && is_outdated(&connection, &publish.payload) {
                    say_online(&client, &topic, &online);
                }
            }
            Ok(Event::Incoming(Packet::PubAck(ack))) if is_failure(&ack) => {
                let problem = Problem::new(&connection.broker, Cause::Publication(format!("{:?}", ack.reason)));
                connection.link.broken(Side::Publishing, &problem);
            }
            Ok(Event::Incoming(Packet::PubAck(_))) => {
                backoff.reset();
                if connection.link.connected(Side::Publishing) {
                    metrics.mqtt_connections_closed.inc();
                }
            }
            Ok(Event::Outgoing(Outgoing::Disconnect)) | Err(Failure::Finished) => return,
            Ok(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) => {}
            Err(Failure::Broken(problem)) => {
                connected.send_replace(false);
                was_broken = true;
                connection.link.broken(Side::Publishing, &problem);
                if problem.is_takeover() {
                    metrics.mqtt_session_takeovers.inc();
                }
                tokio::time::sleep(backoff.pause()).await;
                let is_known = problem.is_takeover() || problem.is_unexplained_end();
                let client_id = is_known.then(|| client_id(&connection.fleet, ROLE));
                poller.renew(&connection.with_secrets_read_again(), client_id);
            }
        }
    }
}

fn say_online(client: &AsyncClient, topic: &str, online: &[u8]) {
    if let Err(problem) = client.try_publish(topic, online.to_vec(), retained()) {
        warn!(%problem, "cannot announce that the supervisor is online");
    }
}

/// Whether a message says wrongly that this supervisor is offline: the late last will of an earlier owner of the fleet,
/// or of an earlier connection of this supervisor, which has replaced the retained message.
fn is_outdated(connection: &Connection, payload: &[u8]) -> bool {
    let topic = Topic::SupervisorState { fleet: connection.fleet.clone() };
    match decode(&topic, payload) {
        Ok(Message::SupervisorState(state)) => {
            state.epoch <= connection.epoch && state.state == SupervisorPresence::Offline
        }
        Ok(_) | Err(_) => false,
    }
}

fn presence(connection: &Connection, state: SupervisorPresence, seq: u64) -> (String, Vec<u8>) {
    let topic = Topic::SupervisorState { fleet: connection.fleet.clone() };
    let message = SupervisorState { boot_id: connection.boot_id.clone(), seq, state, epoch: connection.epoch };
    (topic.to_string(), encode(&message))
}

fn retained() -> PublishOptions {
    PublishOptions::at_least_once().retained()
}

/// MQTT options for a publication at `now`; `None` if it has expired. The remaining time becomes the MQTT message
/// expiry, except for a retained message: robots that connect later need it.
fn options_of(publication: &Publication, now: Instant) -> Option<PublishOptions> {
    let options = PublishOptions::new(match publication.qos {
        QualityOfService::AtMostOnce => QoS::AtMostOnce,
        QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
    });
    let options = if publication.is_retained { options.retained() } else { options };
    let Some(until) = publication.until else { return Some(options) };
    let left = until.checked_duration_since(now).filter(|left| !left.is_zero())?;
    if publication.is_retained {
        return Some(options);
    }
    // The expiry is in whole seconds. It is rounded up, because a broker may take 0 for no expiry.
    let left_s = left.as_secs_f64().ceil() as u32;
    let properties = PublishProperties { message_expiry_interval: Some(left_s), ..PublishProperties::default() };
    Some(options.properties(properties))
}

/// Whether the broker has rejected a publication.
pub(super) fn is_failure(ack: &PubAck) -> bool {
    !matches!(ack.reason, PubAckReason::Success | PubAckReason::NoMatchingSubscribers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_publication_keeps_what_is_left_of_its_time_and_does_not_go_out_after_it() {
        let now = Instant::now();
        let publication = |until| Publication {
            topic: "whisker/v1/f/r/setpoint".to_owned(),
            payload: Vec::new(),
            qos: QualityOfService::AtLeastOnce,
            is_retained: false,
            until,
            stopwatch: None,
        };
        let goes_out = |left_ms: u64| {
            let until = now + Duration::from_millis(left_ms);
            options_of(&publication(Some(until)), now).map(|options| format!("{options:?}"))
        };
        for (left_ms, expiry_s) in [(1, 1), (999, 1), (1001, 2), (9_500, 10)] {
            let options = goes_out(left_ms).expect("not expired yet");
            assert!(options.contains(&format!("message_expiry_interval: Some({expiry_s})")), "{left_ms}: {options}");
        }
        assert_eq!(goes_out(0), None);
        let late = publication(Some(now));
        assert!(options_of(&late, now + Duration::from_secs(1)).is_none());
        assert!(options_of(&publication(None), now).is_some());
    }

    #[test]
    fn a_retained_publication_goes_out_only_before_its_deadline_and_does_not_expire_in_the_broker() {
        let now = Instant::now();
        let publication = Publication {
            topic: "whisker/v1/f/r/estimate".to_owned(),
            payload: Vec::new(),
            qos: QualityOfService::AtLeastOnce,
            is_retained: true,
            until: Some(now + Duration::from_secs(5)),
            stopwatch: None,
        };
        let options = format!("{:?}", options_of(&publication, now).expect("not too late yet"));
        assert!(options.contains("retain: true"), "{options}");
        assert!(!options.contains("Some(5)"), "{options}");
        assert!(options_of(&publication, now + Duration::from_secs(6)).is_none());
    }
}
