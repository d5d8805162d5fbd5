//! Two connections to the broker: one receives, one publishes, so that setpoints never wait behind a burst.
//!
//! Nothing rests on the broker's sessions: each connection starts clean under a name of its own, and
//! subscribes anew, so that retained births and factsheets come again.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use rumqttc::{AsyncClient, Event, EventLoop, LastWill, MqttOptions, Packet, PublishOptions, PublishProperties, QoS};
use tokio::sync::{mpsc, watch};
use tracing::{info, warn};
use vibrissa_protocol::{
    BootId, Name, QualityOfService, RobotTopic, SupervisorPresence, SupervisorState, Topic, encode,
};

use crate::engine::{Incoming, Publication, wall_clock};
use crate::metrics::Metrics;
use crate::secret::Secret;

/// Messages that wait to be handled; beyond it contacts are shed.
const INBOX_MESSAGES: usize = 20_000;
/// Places of the inbox that contacts leave free for everything else.
const INBOX_RESERVE: usize = 2_000;
/// Bytes that wait to be handled; beyond it contacts are shed.
const INBOX_BYTES: usize = 64 * 1024 * 1024;
/// The largest packet that is taken. Larger ones the broker must not send; without this limit, one would
/// end every connection.
const PACKET_MAX: u32 = 2 * 1024 * 1024;

/// Where the broker is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BrokerAddress {
    /// Host name or address.
    pub host: String,
    /// Port.
    pub port: u16,
    /// As whom to connect; none for a broker that asks nobody.
    pub credentials: Option<Credentials>,
    /// How to know the broker, and to be known; none speaks in plain text.
    pub tls: Option<TlsOptions>,
}

/// A user of the broker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Credentials {
    /// Name.
    pub username: String,
    /// Password.
    pub password: Secret,
}

/// Files in PEM.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TlsOptions {
    /// Certificates of the authorities that the broker's may come from; none takes the system's.
    pub ca_file: Option<PathBuf>,
    /// This supervisor's own certificate, with those between it and its authority, and its private key.
    pub client: Option<ClientCertificate>,
}

/// What a supervisor shows of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientCertificate {
    /// The certificate, and those between it and its authority.
    pub certificate_file: PathBuf,
    /// Its private key.
    pub key_file: PathBuf,
}

impl BrokerAddress {
    /// A broker that is spoken to in plain text and asks for no password.
    #[must_use]
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        Self { host: host.into(), port, credentials: None, tls: None }
    }
}

/// The text is no address of a broker.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no broker's URL: it must look like mqtt://host:1883")]
pub struct BadBrokerUrl(String);

impl std::str::FromStr for BrokerAddress {
    type Err = BadBrokerUrl;

    fn from_str(text: &str) -> Result<Self, BadBrokerUrl> {
        let bad = || BadBrokerUrl(text.to_owned());
        let rest = text.strip_prefix("mqtt://").ok_or_else(bad)?.trim_end_matches('/');
        let (host, port) = match rest.rsplit_once(':') {
            Some((host, port)) => (host, port.parse().map_err(|_| bad())?),
            None => (rest, 1883),
        };
        let plain = !host.is_empty() && !host.contains(['/', '@', ' ']);
        plain.then(|| Self::new(host.trim_matches(['[', ']']), port)).ok_or_else(bad)
    }
}

/// What both connections need to know.
#[derive(Debug, Clone)]
pub struct Connection {
    /// Where.
    pub broker: BrokerAddress,
    /// Which fleet.
    pub fleet: Name,
    /// Which boot of the supervisor.
    pub boot_id: BootId,
    /// Its epoch.
    pub epoch: u64,
}

impl Connection {
    fn options(&self, role: &str) -> MqttOptions {
        let id = format!("vibrissa-{}-{}-{role}", self.fleet, self.boot_id);
        let mut options = MqttOptions::new(id, (self.broker.host.clone(), self.broker.port));
        options
            .set_clean_start(true)
            .set_keep_alive(10)
            .set_max_packet_size(Some(PACKET_MAX))
            // The client keeps a table of this size; its default is the protocol's 65,535.
            .set_outgoing_inflight_upper_limit(512)
            .set_connect_timeout(Duration::from_secs(5));
        options
    }

    fn presence(&self, state: SupervisorPresence, seq: u64) -> (String, Vec<u8>) {
        let topic = Topic::SupervisorState { fleet: self.fleet.clone() };
        let message = SupervisorState { boot_id: self.boot_id.clone(), seq, state, epoch: self.epoch };
        (topic.to_string(), encode(&message))
    }
}

/// Receives until `stop`: everything that robots say goes into the inbox.
pub fn receive(
    connection: &Connection,
    metrics: Metrics,
    mut stop: watch::Receiver<bool>,
) -> (Inbox, tokio::task::JoinHandle<()>) {
    let (sender, messages) = mpsc::channel(INBOX_MESSAGES);
    let bytes = Arc::new(AtomicUsize::new(0));
    let (client, mut events) = AsyncClient::builder(connection.options("in")).capacity(64).build();
    let filters: Vec<(String, QoS)> = RobotTopic::ALL
        .into_iter()
        .filter(|kind| kind.is_from_robot())
        .map(|kind| (kind.fleet_filter(&connection.fleet), QoS::AtLeastOnce))
        .collect();
    let counted = bytes.clone();
    let task = tokio::spawn(async move {
        let mut unsubscribed = filters.len();
        loop {
            let event = tokio::select! {
                event = poll(&mut events) => event,
                () = stopped(&mut stop) => break,
            };
            match event {
                Some(Event::Incoming(Packet::ConnAck(_))) => {
                    unsubscribed = filters.len();
                    for (filter, qos) in &filters {
                        // Fits the client's queue: it was emptied with the last connection.
                        if let Err(problem) = client.try_subscribe(filter.as_str(), *qos) {
                            warn!(%problem, filter, "cannot subscribe");
                        }
                    }
                }
                Some(Event::Incoming(Packet::SubAck(ack))) => {
                    if is_refused(&ack) {
                        warn!(answer = ?ack.return_codes, "the broker refuses a subscription: robots are not heard");
                        continue;
                    }
                    unsubscribed = unsubscribed.saturating_sub(1);
                    // Connected means: robots are heard.
                    if unsubscribed == 0 {
                        info!("connected to the broker");
                        metrics.broker_connected.set(1);
                    }
                }
                Some(Event::Incoming(Packet::Publish(publish))) => {
                    let incoming = Incoming { topic: publish.topic, payload: publish.payload, received: wall_clock() };
                    take_in(&sender, &counted, &metrics, incoming);
                }
                Some(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) => {}
                None => metrics.broker_connected.set(0),
            }
        }
        metrics.broker_connected.set(0);
    });
    (Inbox { messages, bytes }, task)
}

/// What was received and is not handled yet, bounded in messages and bytes.
#[derive(Debug)]
pub struct Inbox {
    messages: mpsc::Receiver<Incoming>,
    bytes: Arc<AtomicUsize>,
}

impl Inbox {
    /// The next message; none when no more can come.
    pub async fn recv(&mut self) -> Option<Incoming> {
        let incoming = self.messages.recv().await?;
        self.bytes.fetch_sub(incoming.payload.len(), Ordering::Relaxed);
        Some(incoming)
    }
}

impl Inbox {
    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }
}

/// Contacts are shed over the bound: robots send them again. Everything else is small and rare.
fn take_in(sender: &mpsc::Sender<Incoming>, bytes: &AtomicUsize, metrics: &Metrics, incoming: Incoming) {
    let length = incoming.payload.len();
    let is_contacts = incoming.topic.ends_with(b"/contacts");
    let full = sender.capacity() <= INBOX_RESERVE || bytes.load(Ordering::Relaxed) + length > INBOX_BYTES;
    if is_contacts && full {
        metrics.shed.inc();
        return;
    }
    bytes.fetch_add(length, Ordering::Relaxed);
    if sender.try_send(incoming).is_err() {
        bytes.fetch_sub(length, Ordering::Relaxed);
        metrics.shed.inc();
    }
}

/// Publishes what comes out of `outbox` until it is closed, then says good-bye.
pub fn publish(connection: &Connection, mut outbox: mpsc::Receiver<Publication>) -> tokio::task::JoinHandle<()> {
    let mut options = connection.options("out");
    let (topic, offline) = connection.presence(SupervisorPresence::Offline, 1);
    options.set_last_will(LastWill::new(topic.clone(), offline.clone(), QoS::AtLeastOnce, true, None));
    let (client, mut events) = AsyncClient::builder(options).capacity(1000).build();
    let (_, online) = connection.presence(SupervisorPresence::Online, 0);
    let polled = client.clone();
    let poller = tokio::spawn(async move {
        let retained = || PublishOptions::at_least_once().retained();
        loop {
            match poll(&mut events).await {
                Some(Event::Incoming(Packet::ConnAck(_))) => {
                    if let Err(problem) = polled.try_publish(topic.as_str(), online.clone(), retained()) {
                        warn!(%problem, "cannot say that the supervisor is online");
                    }
                }
                Some(Event::Incoming(Packet::PubAck(ack))) if is_failure(&ack) => {
                    warn!(reason = ?ack.reason, "the broker did not take a publication");
                }
                Some(Event::Outgoing(rumqttc::Outgoing::Disconnect)) => break,
                Some(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) | None => {}
            }
        }
    });
    let (state_topic, _) = connection.presence(SupervisorPresence::Offline, 1);
    tokio::spawn(async move {
        while let Some(publication) = outbox.recv().await {
            let mut options = PublishOptions::new(match publication.qos {
                QualityOfService::AtMostOnce => QoS::AtMostOnce,
                QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
            });
            if let Some(expiry_s) = publication.expiry_s {
                let properties = PublishProperties { message_expiry_interval: Some(expiry_s), ..Default::default() };
                options = options.properties(properties);
            }
            if client.publish(publication.topic, publication.payload, options).await.is_err() {
                break;
            }
        }
        let last = PublishOptions::at_least_once().retained();
        if client.try_publish(state_topic, offline, last).is_ok() && client.disconnect().await.is_ok() {
            let _ = tokio::time::timeout(Duration::from_secs(2), poller).await;
        } else {
            poller.abort();
        }
    })
}

/// Returns when it is time to stop, or when no one is left to say so.
pub async fn stopped(stop: &mut watch::Receiver<bool>) {
    let _ = stop.wait_for(|&stop| stop).await;
}

fn is_refused(ack: &rumqttc::SubAck) -> bool {
    !ack.return_codes.iter().all(|code| matches!(code, rumqttc::SubscribeReasonCode::Success(_)))
}

fn is_failure(ack: &rumqttc::PubAck) -> bool {
    !matches!(ack.reason, rumqttc::PubAckReason::Success | rumqttc::PubAckReason::NoMatchingSubscribers)
}

/// One event; none after an error, which has been waited out: the client would try again at once.
async fn poll(events: &mut EventLoop) -> Option<Event> {
    match events.poll().await {
        Ok(event) => Some(event),
        Err(problem) => {
            warn!(%problem, "no connection to the broker; trying again");
            tokio::time::sleep(Duration::from_millis(500)).await;
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_brokers_url_has_a_host_and_perhaps_a_port() {
        let address = |text: &str| text.parse::<BrokerAddress>();
        assert_eq!(address("mqtt://h:1884"), Ok(BrokerAddress::new("h", 1884)));
        assert_eq!(address("mqtt://h"), Ok(BrokerAddress::new("h", 1883)));
        assert_eq!(address("mqtt://[::1]:1885/"), Ok(BrokerAddress::new("::1", 1885)));
        for bad in ["h:1883", "mqtt://", "mqtt://h:x", "http://h", "mqtt://u@h"] {
            assert!(address(bad).is_err(), "{bad}");
        }
    }
}
