//! TCP connection to the broker.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::net::{TcpStream, lookup_host};
use vibrissa_host::process::{self, Stream};
use vibrissa_protocol::plain;

use super::address::BrokerAddress;

/// Time limits of an attempt to connect to one node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// For TCP, TLS and MQTT together.
    pub(super) whole: Duration,
    /// For one address of the host, so that a dead one leaves time for the next.
    address: Duration,
}

impl Limits {
    /// Limits for a broker with one node, and for the nodes of a cluster. These are shorter, because the next node may
    /// be better; TCP repeats a lost packet after one second.
    pub(super) fn of(broker: &BrokerAddress) -> Self {
        if broker.others.is_empty() {
            Self { whole: Duration::from_secs(5), address: Duration::from_secs(2) }
        } else {
            Self { whole: Duration::from_secs(3), address: Duration::from_millis(1500) }
        }
    }
}

/// The host name cannot be resolved.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct LookupError(pub(super) String);

/// Connects by TCP to the first address of a host that answers.
///
/// `reached` is set once a TCP connection is up: later failures are not due to the network.
pub(super) async fn connect(
    host: String,
    port: u16,
    limits: Limits,
    reached: Arc<AtomicBool>,
) -> io::Result<Box<dyn Stream>> {
    reached.store(false, Ordering::Relaxed);
    if let Some(process) = process::simulated() {
        let connected = tokio::time::timeout(limits.address, process.connect(&host, port)).await;
        let stream = connected.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))?;
        reached.store(true, Ordering::Relaxed);
        return Ok(stream);
    }
    let unknown = |why: String| io::Error::other(LookupError(why));
    let addresses = lookup_host((host.as_str(), port)).await.map_err(|problem| unknown(plain::io(&problem)))?;
    let mut last = unknown("it has no address".to_owned());
    for address in addresses {
        match tokio::time::timeout(limits.address, TcpStream::connect(address)).await {
            Ok(Ok(stream)) => {
                // Setpoints and acknowledgements are small and urgent.
                stream.set_nodelay(true)?;
                reached.store(true, Ordering::Relaxed);
                return Ok(Box::new(stream));
            }
            Ok(Err(problem)) => last = problem,
            Err(_) => last = io::ErrorKind::TimedOut.into(),
        }
    }
    Err(last)
}
