//! The embedded MQTT broker, on loopback and in memory only. Besides it, only the relay for
//! tests of robots uses the library behind it, to decode packets.

use std::net::{Ipv4Addr, SocketAddr};

use mqtt5::broker::config::{BrokerConfig, StorageBackend, StorageConfig};
use mqtt5::broker::{BrokerShutdownHandle, MqttBroker};
use tokio::task::JoinHandle;

/// Largest packet in bytes: large enough that oversized messages reach the supervisor and are counted there.
const PACKET_MAX: usize = 2 * 1024 * 1024;

/// A running broker.
pub struct Broker {
    address: SocketAddr,
    stop: BrokerShutdownHandle,
    task: JoinHandle<()>,
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
    /// Any other problem.
    #[error("the embedded MQTT broker cannot start: {0}")]
    Start(String),
}

impl Broker {
    /// Starts the broker on a port of 127.0.0.1; 0 takes any free one. On return it accepts connections.
    ///
    /// # Errors
    /// The port is taken, or the broker cannot start.
    pub async fn start(port: u16) -> Result<Self, BrokerError> {
        if port != 0 {
            // The broker's own error does not distinguish a taken port from other problems.
            std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|problem| {
                if problem.kind() == std::io::ErrorKind::AddrInUse {
                    BrokerError::PortTaken { port }
                } else {
                    BrokerError::Start(format!("127.0.0.1:{port}: {problem}"))
                }
            })?;
        }
        let storage = StorageConfig::new().with_backend(StorageBackend::Memory).with_persistence(false);
        let config = BrokerConfig::default()
            .with_bind_address((Ipv4Addr::LOCALHOST, port))
            .with_max_packet_size(PACKET_MAX)
            .with_client_channel_capacity(20_000)
            .with_max_retained_messages(100_000)
            .with_sys_topics_enabled(false)
            .with_storage(storage);
        let start_error = |problem: mqtt5::MqttError| BrokerError::Start(problem.to_string());
        let mut broker = MqttBroker::with_config(config).await.map_err(start_error)?;
        let address = broker.local_addr().ok_or_else(|| BrokerError::Start("it has no address".to_owned()))?;
        let stop = broker.shutdown_handle();
        let mut ready = broker.ready_receiver();
        let task = tokio::spawn(async move {
            if let Err(problem) = broker.run().await {
                tracing::error!(%problem, "the embedded MQTT broker has stopped");
            }
        });
        ready.wait_for(|&ready| ready).await.map_err(|_| BrokerError::Start("it stopped at once".to_owned()))?;
        Ok(Self { address, stop, task })
    }

    /// Address and port on which the broker listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Stops the broker and waits for its end.
    pub async fn stop(self) {
        self.stop.shutdown();
        if self.task.await.is_err() {
            tracing::warn!("the embedded MQTT broker did not stop cleanly");
        }
    }
}
