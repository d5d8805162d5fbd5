//! The network between one host and a server, with all connections of that host.

use std::fmt::Debug;
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::sleep;
use vibrissa_host::{process, task};

use super::lanes::Way;
use super::wire::{Wire, WireEnd};
use super::{ModelBroker, locked};

/// The other end of a route.
pub trait Server: Debug + Send + Sync {
    /// Whether it accepts connections.
    fn accepts(&self) -> bool;

    /// Serves a connection until one side ends it.
    fn attend(&self, end: WireEnd) -> Pin<Box<dyn Future<Output = io::Result<()>> + Send>>;
}

impl Server for ModelBroker {
    fn accepts(&self) -> bool {
        self.is_accepting()
    }

    fn attend(&self, end: WireEnd) -> Pin<Box<dyn Future<Output = io::Result<()>> + Send>> {
        let broker = self.clone();
        Box::pin(async move { broker.serve(end).await })
    }
}

/// Condition of a route, and its connections.
#[derive(Debug, Default)]
struct Condition {
    /// Latency to the server and to the client.
    latencies: [Duration; 2],
    /// Whether each direction is cut.
    cut: [bool; 2],
    wires: Vec<Wire>,
}

/// The network between one host and a server. Clones are the same route.
#[derive(Debug, Clone)]
pub struct Route {
    server: Arc<dyn Server>,
    condition: Arc<Mutex<Condition>>,
    changed: Arc<Notify>,
}

impl Route {
    /// A route with this latency in each direction.
    #[must_use]
    pub fn new(server: impl Server + 'static, latency: Duration) -> Self {
        let condition = Condition { latencies: [latency; 2], ..Condition::default() };
        Self { server: Arc::new(server), condition: Arc::new(Mutex::new(condition)), changed: Arc::default() }
    }

    /// Connects to the server, which serves the other end in a task. It takes two latencies, and waits as long as a
    /// direction is cut.
    ///
    /// # Errors
    /// The server accepts no connections.
    pub async fn connect(&self) -> io::Result<WireEnd> {
        loop {
            let changed = self.changed.notified();
            let Some(round_trip) = self.round_trip() else {
                changed.await;
                continue;
            };
            sleep(round_trip).await;
            if self.round_trip().is_some() {
                break;
            }
        }
        if !self.server.accepts() {
            return Err(io::ErrorKind::ConnectionRefused.into());
        }
        let mut condition = locked(&self.condition);
        let (near, far, wire) = Wire::pair(condition.latencies);
        condition.wires.retain(Wire::is_open);
        condition.wires.push(wire);
        let attending = self.server.attend(far);
        // The server is no part of the process that connects.
        process::enter(None, || task::spawn(attending));
        Ok(near)
    }

    /// Time of a round trip; `None` while a direction is cut.
    fn round_trip(&self) -> Option<Duration> {
        let condition = locked(&self.condition);
        (condition.cut == [false; 2]).then(|| condition.latencies.iter().sum())
    }

    /// Cuts or heals a direction of all connections, as [`Wire::set_cut`] does.
    pub fn set_cut(&self, way: Way, is_cut: bool) {
        let mut condition = locked(&self.condition);
        condition.cut[way as usize] = is_cut;
        for wire in &condition.wires {
            wire.set_cut(way, is_cut);
        }
        self.changed.notify_waiters();
    }

    /// Sets the latency of a direction.
    pub fn set_latency(&self, way: Way, latency: Duration) {
        let mut condition = locked(&self.condition);
        condition.latencies[way as usize] = latency;
        for wire in &condition.wires {
            wire.set_latency(way, latency);
        }
    }

    /// Resets all connections.
    pub fn reset(&self) {
        for wire in &locked(&self.condition).wires {
            wire.reset();
        }
    }
}
