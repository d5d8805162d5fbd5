//! A model MQTT 5 broker for simulated time, with faults that are switched on and off from outside.
//!
//! [`ModelBroker`] serves byte streams ([`ModelBroker::serve`], as [`Route::connect`] makes them) by the codec of the
//! supervisor's own client, and clients in this process ([`Client`]) without an encoding. `machine` has the rules of the
//! protocol, without any I/O; `hub` the delays between clients and machine. Time is that of tokio, so it may be paused.
//! With one seed, the same calls in the same order have the same results.
//!
//! The supervisor's client connects with `set_socket_connector(move |_, _| { let route = route.clone(); async move {
//! route.connect().await } })`.
//!
//! It knows QoS 0 and 1, sessions, wills without a delay, retained messages and expiry. It lowers subscriptions with QoS 2
//! to 1, and refuses publications with QoS 2, shared subscriptions and topic aliases. It knows no users.

mod faults;
mod hub;
mod lanes;
mod machine;
mod message;
mod report;
mod session;
mod subscriptions;

mod client;
mod port;
mod route;
mod stream;
mod wire;

#[cfg(test)]
mod tests;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

use hub::Hub;

pub use client::{Client, ClientOptions, NotAccepting};
pub use faults::{Ending, Memory};
pub use lanes::{Delay, Way};
pub use report::{Counts, Observed, Observer};
pub use route::{Route, Server};
pub use wire::{Wire, WireEnd};

/// Limits of the broker, which it states when it accepts a connection.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Most messages with QoS 1 without an acknowledgement, for each client and direction. At least 1.
    pub in_flight_max: u16,
    /// Largest packet that the broker accepts, in bytes.
    pub packet_bytes_max: u32,
    /// Most messages that wait for one client, beside those in flight. When it is full, the oldest with QoS 0 is dropped,
    /// and without one the new message.
    pub queued_max: usize,
}

impl Default for Limits {
    /// The values of `deploy/mosquitto/mosquitto.conf`.
    fn default() -> Self {
        Self { in_flight_max: 65_535, packet_bytes_max: 270_336, queued_max: 100_000 }
    }
}

/// A connection; each has a new number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct LinkId(u64);

/// The broker. Clones are the same broker.
#[derive(Clone)]
pub struct ModelBroker {
    hub: Arc<Mutex<Hub>>,
}

impl std::fmt::Debug for ModelBroker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ModelBroker").finish_non_exhaustive()
    }
}

impl ModelBroker {
    /// A broker with these limits. Delays and faults of single messages are drawn from `seed`.
    ///
    /// # Panics
    /// Outside of a tokio runtime, in which the broker's clock runs.
    #[must_use]
    pub fn new(seed: u64, limits: Limits) -> Self {
        let clock = Arc::new(Notify::new());
        let hub = Arc::new(Mutex::new(Hub::new(seed, limits, clock.clone())));
        vibrissa_host::task::spawn(run_clock(Arc::downgrade(&hub), clock));
        Self { hub }
    }

    fn hub(&self) -> MutexGuard<'_, Hub> {
        locked(&self.hub)
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does what is due, until the broker is dropped.
async fn run_clock(hub: std::sync::Weak<Mutex<Hub>>, clock: Arc<Notify>) {
    loop {
        let Some(broker) = hub.upgrade() else { return };
        let due = locked(&broker).advance(Instant::now());
        drop(broker);
        match due {
            None => clock.notified().await,
            Some(due) => tokio::select! {
                biased;
                () = clock.notified() => {}
                () = sleep_until(due) => {}
            },
        }
    }
}
