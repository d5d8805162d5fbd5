//! The polling half of a client: one event after the other, and every failure under its cause.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rumqttc::{ConnAck, ConnectionError, Event, EventLoop, Packet};
use tokio::time::sleep_until;

use super::Connection;
use super::address::BrokerAddress;
use super::hearing::Hearing;
use super::problem::{Cause, Problem};

/// Both sides say something at least this often, so that a dead one is noticed after two of them.
pub(super) const KEEP_ALIVE_S: u16 = 6;
/// For a broker that wants no keep-alive.
const DAY_S: u64 = 24 * 3600;

/// What a poll ends with.
pub(super) enum Failure {
    /// For this reason.
    Broken(Problem),
    /// The client has disconnected, as it was told.
    Finished,
}

/// A client's event loop.
pub(super) struct Poller {
    events: EventLoop,
    broker: BrokerAddress,
    reached: Arc<AtomicBool>,
    connected: bool,
    patience: Duration,
}

impl Poller {
    pub(super) fn new(events: EventLoop, connection: &Connection, reached: Arc<AtomicBool>) -> Self {
        let broker = connection.broker.clone();
        Self { events, broker, reached, connected: false, patience: patience(KEEP_ALIVE_S) }
    }

    /// The next event of those that came together with the last one. Everything that one look at the network brings
    /// waits in the client; going through its whole loop for each costs more than the message itself.
    pub(super) fn ready(&mut self) -> Option<Event> {
        let event = self.events.state.events.pop_front()?;
        self.note(&event);
        Some(event)
    }

    /// The next event. After a failure the next call connects anew, at once: wait before it.
    pub(super) async fn next(&mut self) -> Result<Event, Failure> {
        // A connection into which nothing can be written any more is not noticed by the client itself.
        let Ok(event) = tokio::time::timeout(self.patience, self.events.poll()).await else {
            self.events.clean();
            self.connected = false;
            return Err(Failure::Broken(Problem::new(&self.broker, Cause::Silent)));
        };
        match event {
            Ok(event) => {
                self.note(&event);
                Ok(event)
            }
            Err(ConnectionError::RequestsDone) => Err(Failure::Finished),
            Err(error) => {
                let reached = self.reached.load(Ordering::Relaxed);
                let connected = std::mem::take(&mut self.connected);
                Err(Failure::Broken(Problem::of(&self.broker, &error, reached, connected)))
            }
        }
    }

    /// The next event. Meanwhile `judge` is called whenever something is due of `hearing`.
    ///
    /// # Errors
    /// Those of `judge`, at once.
    pub(super) async fn next_while<E>(
        &mut self,
        hearing: &mut Hearing,
        mut judge: impl FnMut(&mut Hearing) -> Result<(), E>,
    ) -> Result<Result<Event, Failure>, E> {
        // Polled on after each judgement: nothing that the client has begun is cut off.
        let mut next = pin!(self.next());
        loop {
            tokio::select! {
                biased;
                event = &mut next => return Ok(event),
                () = sleep_until(hearing.due().into()) => judge(hearing)?,
            }
        }
    }

    /// Takes other credentials, and another client id if it is given, for the next connection.
    pub(super) fn renew(&mut self, connection: &Connection, client_id: Option<String>) {
        let options = &mut self.events.options;
        connection.show_secrets(options);
        if let Some(client_id) = client_id {
            options.set_client_id(client_id);
        }
    }

    fn note(&mut self, event: &Event) {
        if let Event::Incoming(Packet::ConnAck(ack)) = event {
            self.connected = true;
            self.patience = patience(keep_alive_s(ack));
        }
    }
}

/// The broker's word counts.
fn keep_alive_s(ack: &ConnAck) -> u16 {
    ack.properties.as_ref().and_then(|properties| properties.server_keep_alive).unwrap_or(KEEP_ALIVE_S)
}

fn patience(keep_alive_s: u16) -> Duration {
    Duration::from_secs(if keep_alive_s == 0 { DAY_S } else { 2 * u64::from(keep_alive_s) })
}
