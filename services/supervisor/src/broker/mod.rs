//! The embedded MQTT broker, on loopback and in memory only. Besides it, only the relay for
//! tests of robots uses the library behind it, to decode packets.
//!
//! The library limits numbers of messages, and not their bytes. So [`front`] accepts the connections itself and stands
//! between each client and the library: what waits there, and what the library keeps for the client ([`in_flight`]), is on
//! [`ledger`], which closes a connection with too much of it.
//! [`gate`] checks passwords, and limits retained messages and the rate of publications.

mod framing;
mod front;
mod gate;
mod in_flight;
mod ledger;

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use mqtt5::broker::config::BrokerConfig;
use mqtt5::broker::router::MessageRouter;
use mqtt5::broker::storage::QueueLimits;
use mqtt5::broker::sys_topics::BrokerStats;
use mqtt5::broker::{ResourceLimits, ResourceMonitor};
use tokio::net::TcpListener;
use tokio::sync::{broadcast, watch};
use tokio::task::JoinHandle;
use vibrissa_host::task;
use vibrissa_protocol::plain;

use crate::mqtt::Credentials;
use front::Front;
use gate::Gate;
use ledger::Ledger;

/// Largest packet in bytes: large enough that oversized messages reach the supervisor and are counted there.
const PACKET_MAX: usize = 2 * 1024 * 1024;
/// Messages that wait within the library for one client. They wait there for moments: the front takes them at once.
const WAITING_MAX: usize = 2_000;
/// Messages of a client with quality of service 2 that wait for its release.
const UNRELEASED_MAX: u16 = 32;
/// Messages to a client that wait for its acknowledgement; the next ones wait in the library's queue.
const UNACKNOWLEDGED_MAX: u16 = 32;
/// Subscriptions of a client: a supervisor has six for each fleet, and other programs may name their robots one by one.
const SUBSCRIPTIONS_MAX: usize = 150_000;
/// Bytes that wait within the library for one client while it takes no more.
const WAITING_BYTES_MAX: usize = 1024 * 1024;

/// A running broker.
pub struct Broker {
    address: SocketAddr,
    stop: watch::Sender<bool>,
    task: JoinHandle<()>,
}

/// The clients that the embedded broker admits.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum MqttAccess {
    /// Everyone on this machine.
    #[default]
    Open,
    /// Clients with these credentials. Without credentials everyone on this machine, unless HTTP requires a token: then the
    /// broker does not start, because what HTTP refuses would be possible by MQTT.
    AsHttp(Option<Credentials>),
}

impl MqttAccess {
    /// The credentials that clients need, if any.
    ///
    /// # Errors
    /// HTTP requires a token, and MQTT would not.
    pub fn credentials(&self, is_http_open: bool) -> Result<Option<&Credentials>, BrokerError> {
        match self {
            Self::AsHttp(None) if !is_http_open => Err(BrokerError::Unguarded),
            Self::AsHttp(credentials) => Ok(credentials.as_ref()),
            Self::Open => Ok(None),
        }
    }
}

/// Why the embedded broker does not start.
#[derive(Debug, thiserror::Error)]
pub enum BrokerError {
    /// Another program listens on the port.
    #[error(
        "port {port} on 127.0.0.1 is taken: stop the MQTT broker that listens there, use it with \
         --mqtt-url mqtt://127.0.0.1:{port}, or take any free port with --mqtt-port 0"
    )]
    PortTaken {
        /// The port on 127.0.0.1.
        port: u16,
    },
    /// HTTP requires a token, and MQTT would require no password.
    #[error(
        "HTTP requires a token, but everyone on this machine could send setpoints by MQTT: give the embedded broker a password \
         with mqtt.username and mqtt.password_file, which robots then need too, or use a broker of your own with mqtt.url"
    )]
    Unguarded,
    /// Any other problem.
    #[error("the embedded MQTT broker cannot start: {0}")]
    Start(String),
}

impl Broker {
    /// Starts the broker on a port of 127.0.0.1, for everyone on this machine; 0 takes any free port. On return it accepts
    /// connections.
    ///
    /// # Errors
    /// The port is taken, or the broker cannot start.
    pub async fn start(port: u16) -> Result<Self, BrokerError> {
        Self::guarded(port, None).await
    }

    /// Starts the broker for clients with these credentials, if there are any.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub async fn guarded(port: u16, credentials: Option<&Credentials>) -> Result<Self, BrokerError> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await.map_err(|problem| {
            if problem.kind() == std::io::ErrorKind::AddrInUse {
                BrokerError::PortTaken { port }
            } else {
                BrokerError::Start(format!("127.0.0.1:{port}: {}", plain::io(&problem)))
            }
        })?;
        let address = listener.local_addr().map_err(|problem| BrokerError::Start(problem.to_string()))?;
        let (stop, stopped) = watch::channel(false);
        let task = task::spawn(front(credentials).run(listener, stopped));
        Ok(Self { address, stop, task })
    }

    /// Address and port on which the broker listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Stops the broker and waits for its end.
    pub async fn stop(self) {
        // The receiver lives as long as the task.
        let _ = self.stop.send(true);
        if self.task.await.is_err() {
            tracing::warn!("the embedded MQTT broker did not stop cleanly");
        }
    }
}

/// The parts of the library, and the front before them.
fn front(credentials: Option<&Credentials>) -> Front {
    let ledger = Arc::new(Ledger::default());
    let gate = Arc::new(Gate::new(credentials, ledger.clone()));
    let mut config = BrokerConfig::default()
        .with_max_packet_size(PACKET_MAX)
        .with_client_channel_capacity(WAITING_MAX)
        .with_server_receive_maximum(UNRELEASED_MAX)
        .with_max_outbound_inflight(UNACKNOWLEDGED_MAX)
        .with_max_subscriptions_per_client(SUBSCRIPTIONS_MAX)
        .with_sys_topics_enabled(false);
    // An alias keeps a topic of up to 64 KiB for each of 65,535 numbers.
    config.topic_alias_maximum = 0;
    // A session ends with its connection: messages for clients that are away would wait without a limit.
    config.session_expiry_interval = Duration::ZERO;
    config.event_handler = Some(gate.clone());
    let limits = QueueLimits { max_messages: WAITING_MAX, max_bytes: WAITING_BYTES_MAX };
    let router = MessageRouter::new().with_fallback_queue_limits(limits).with_event_handler(gate.clone());
    // Connections are limited by the front, and rates by the gate.
    let resources = ResourceLimits {
        max_connections: usize::MAX,
        max_connections_per_ip: usize::MAX,
        max_message_rate_per_client: 0,
        max_bandwidth_per_client: 0,
        max_connection_rate: u32::MAX,
        rate_limit_window: Duration::from_secs(1),
    };
    let (shutdown, _) = broadcast::channel(1);
    Front {
        config: Arc::new(config),
        router: Arc::new(router),
        gate,
        stats: Arc::new(BrokerStats::new()),
        resources: Arc::new(ResourceMonitor::new(resources)),
        shutdown,
        ledger,
    }
}

#[cfg(test)]
mod tests;
