//! TCP connection to the broker.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::net::{TcpStream, lookup_host};

/// Time limit for TCP, TLS and MQTT together.
pub(super) const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// Time limit for one of several addresses of a host, so that a dead one leaves time for the next.
const ADDRESS_TIMEOUT: Duration = Duration::from_secs(2);

/// The host name cannot be resolved.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct LookupError(pub(super) String);

/// Connects by TCP to the first address of a host that answers.
///
/// `reached` is set once a TCP connection is up: later failures are not due to the network.
pub(super) async fn connect(host: String, port: u16, reached: Arc<AtomicBool>) -> io::Result<TcpStream> {
    reached.store(false, Ordering::Relaxed);
    let unknown = |why: String| io::Error::other(LookupError(why));
    let addresses = lookup_host((host.as_str(), port)).await.map_err(|problem| unknown(problem.to_string()))?;
    let mut last = unknown("it has no address".to_owned());
    for address in addresses {
        match tokio::time::timeout(ADDRESS_TIMEOUT, TcpStream::connect(address)).await {
            Ok(Ok(stream)) => {
                // Setpoints and acknowledgements are small and urgent.
                stream.set_nodelay(true)?;
                reached.store(true, Ordering::Relaxed);
                return Ok(stream);
            }
            Ok(Err(problem)) => last = problem,
            Err(_) => last = io::ErrorKind::TimedOut.into(),
        }
    }
    Err(last)
}
