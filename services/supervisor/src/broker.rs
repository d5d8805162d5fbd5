//! The embedded MQTT broker: on loopback, nothing on disk. The only module that knows which one it is.

use std::net::{Ipv4Addr, SocketAddr};

use mqtt5::broker::config::{BrokerConfig, StorageBackend, StorageConfig};
use mqtt5::broker::{BrokerShutdownHandle, MqttBroker};
use tokio::task::JoinHandle;

/// The largest packet that it takes: so large that junk reaches the supervisor and is counted there.
const PACKET_MAX: usize = 2 * 1024 * 1024;

/// A running broker.
pub struct Broker {
    address: SocketAddr,
    stop: BrokerShutdownHandle,
    task: JoinHandle<()>,
}

/// Why it does not run.
#[derive(Debug, thiserror::Error)]
pub enum BrokerError {
    /// Another program listens there.
    #[error(
        "port {port} on 127.0.0.1 is taken: stop the MQTT broker that listens there, use it with \
         --mqtt-url mqtt://127.0.0.1:{port}, or take any free port with --mqtt-port 0"
    )]
    PortTaken {
        /// Which.
        port: u16,
    },
    /// Anything else.
    #[error("the embedded MQTT broker does not start: {0}")]
    Start(String),
}

impl Broker {
    /// Starts it on a port of 127.0.0.1; 0 takes any free one. It takes connections when this returns.
    ///
    /// # Errors
    /// The port is taken, or the broker does not start.
    pub async fn start(port: u16) -> Result<Self, BrokerError> {
        if port != 0 {
            // The broker's own error does not tell a taken port from the rest.
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

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Stops it and waits until it has.
    pub async fn stop(self) {
        self.stop.shutdown();
        if self.task.await.is_err() {
            tracing::warn!("the embedded MQTT broker did not stop cleanly");
        }
    }
}
