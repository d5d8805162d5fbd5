//! HTTP connections: how many may be open, their time limits, and the shutdown.
//!
//! The router is built once and shared by all connections. `registry` limits how many are open, `connection` serves
//! one, `progress` holds its deadlines, and `descriptors` limits their number by the process's file descriptors.

mod connection;
pub(crate) mod descriptors;
mod progress;
mod registry;

use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::time::Duration;

use axum::Router;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::{JoinSet, yield_now};
use tokio::time::{Instant, sleep};
use tracing::{debug, warn};
use vibrissa_host::task;

use self::progress::Slow;
use self::registry::{Limit, Registry};
use crate::metrics::{ConnectionMetrics, Word};

pub use registry::Limits;

/// Pause after the system failed to accept a connection.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// Shortest interval between log messages about a reached limit.
const NOTICE_EVERY: Duration = Duration::from_secs(60);
/// The answer to a connection that exceeds the limits.
const NO_ROOM: &[u8] =
    b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 1\r\nContent-Length: 0\r\n\r\n";

/// A port on which HTTP is served.
pub(super) struct Server {
    /// Name of the listener in the log and in metrics.
    pub(super) name: Word,
    /// The socket that accepts connections.
    pub(super) listener: TcpListener,
    /// The routes served here.
    pub(super) router: Router,
    /// How many connections may be open.
    pub(super) limits: Limits,
    /// Counters of connections.
    pub(super) metrics: ConnectionMetrics,
    /// Becomes true when the service stops.
    pub(super) stop: watch::Receiver<bool>,
}

impl Server {
    /// Serves until `stop`, and then until the requests under way are answered.
    pub(super) async fn run(self) {
        let Self { name, listener, router, limits, metrics, mut stop } = self;
        let registry = Registry::new(limits, metrics.clone());
        let mut connections = JoinSet::new();
        let mut notices = Notices { name, limits, last: None, silent: 0 };
        loop {
            let accepted = tokio::select! {
                accepted = listener.accept() => accepted,
                Some(_) = connections.join_next() => continue,
                _ = stop.wait_for(|&stop| stop) => break,
            };
            match accepted {
                Ok((stream, peer)) => match registry.admit(peer.ip()) {
                    Ok(admitted) => {
                        let reached = admitted.reached;
                        if let Some(limit) = reached {
                            notices.limit(limit, peer, "closed the connection that has waited longest for a request");
                        }
                        let served = connection::serve(stream, peer, admitted, router.clone(), stop.clone());
                        let metrics = metrics.clone();
                        task::spawn_in(&mut connections, async move {
                            if let Some(slow) = served.await {
                                metrics.closed(word(slow));
                                debug!(%peer, reason = word(slow), "closed a connection");
                            }
                        });
                        if reached.is_some() {
                            // Lets connections that were just accepted read their requests before others displace them.
                            yield_now().await;
                        }
                    }
                    Err(limit) => {
                        metrics.refused(match limit {
                            Limit::Total => "TOTAL",
                            Limit::Address => "ADDRESS",
                        });
                        notices.limit(limit, peer, "refused a connection: all others have requests under way");
                        refuse(&stream);
                    }
                },
                // The client disconnected before it was accepted.
                Err(problem) if is_of_the_client(&problem) => {}
                Err(problem) => {
                    metrics.accept_errors.inc();
                    notices.accept_failed(&problem);
                    // Closing a waiting connection frees a file descriptor.
                    registry.displace();
                    sleep(ACCEPT_PAUSE).await;
                }
            }
        }
        drop(listener);
        while connections.join_next().await.is_some() {}
    }
}

fn word(slow: Slow) -> Word {
    match slow {
        Slow::Idle => "IDLE",
        Slow::Head => "SLOW_REQUEST",
        Slow::Answer => "SLOW_ANSWER",
    }
}

/// Sends 503, if the socket takes it at once.
fn refuse(stream: &TcpStream) {
    if let Err(problem) = stream.try_write(NO_ROOM) {
        debug!(%problem, "cannot send 503 to a refused connection");
    }
}

fn is_of_the_client(problem: &io::Error) -> bool {
    matches!(
        problem.kind(),
        ErrorKind::ConnectionRefused
            | ErrorKind::ConnectionAborted
            | ErrorKind::ConnectionReset
            | ErrorKind::Interrupted
    )
}

/// Log messages about limits. They are rate-limited, since clients that reach a limit do so often.
struct Notices {
    name: Word,
    limits: Limits,
    last: Option<Instant>,
    silent: u64,
}

impl Notices {
    fn limit(&mut self, limit: Limit, peer: SocketAddr, done: &str) {
        let Some(silent) = self.is_due() else { return };
        let (listener, connections_max) = (self.name, self.limits.connections_max);
        let connections_per_address_max = self.limits.connections_per_address_max;
        match limit {
            Limit::Total => warn!(listener, connections_max, %peer, silent, "too many HTTP connections: {done}"),
            Limit::Address => {
                warn!(
                    listener, connections_per_address_max, %peer, silent,
                    "too many HTTP connections from one address: {done}"
                );
            }
        }
    }

    fn accept_failed(&mut self, problem: &io::Error) {
        if let Some(silent) = self.is_due() {
            warn!(
                listener = self.name,
                %problem,
                silent,
                "cannot accept HTTP connections: if file descriptors have run out, raise the process's limit or lower \
                 http.connections_max"
            );
        }
    }

    /// Whether a message is due now; if so, the number of messages suppressed since the last one.
    fn is_due(&mut self) -> Option<u64> {
        let now = Instant::now();
        if self.last.is_some_and(|last| now - last < NOTICE_EVERY) {
            self.silent += 1;
            return None;
        }
        self.last = Some(now);
        Some(std::mem::take(&mut self.silent))
    }
}

/// The limits in effect: the configured ones, or lower ones if the process cannot have so many file descriptors.
pub(super) fn possible(limits: Limits, descriptors: Option<u64>) -> Limits {
    let connections_max = descriptors::connections_max(limits.connections_max, descriptors);
    if connections_max < limits.connections_max {
        warn!(
            connections_max,
            configured = limits.connections_max,
            descriptors,
            "fewer HTTP connections than http.connections_max: raise the process's limit of open files (LimitNOFILE, \
             ulimit -n)"
        );
    }
    let connections_per_address_max = limits.connections_per_address_max.min(connections_max);
    Limits { connections_max, connections_per_address_max }
}
