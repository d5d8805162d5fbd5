//! The polling half of an MQTT client: returns one event after the other, and each failure with its cause.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rumqttc::{ConnAck, ConnectionError, Event, EventLoop, LastWill, Packet};
use tokio::time::sleep_until;

use super::Connection;
use super::address::BrokerAddress;
use super::hearing::Hearing;
use super::problem::{Cause, Problem};

/// Keep-alive interval, s. A dead connection is noticed after two of them.
pub(super) const KEEP_ALIVE_S: u16 = 6;
/// Time limit for a broker that disables the keep-alive, s.
const DAY_S: u64 = 24 * 3600;

/// Why polling ends.
pub(super) enum Failure {
    /// The connection broke for this reason.
    Broken(Problem),
    /// The client has disconnected on request.
    Finished,
}

/// Event loop of an MQTT client.
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

    /// The next event of the last read, if there are more. The client holds all events of one read; a pass through its
    /// whole loop for each costs more than the message itself.
    pub(super) fn ready(&mut self) -> Option<Event> {
        let event = self.events.state.events.pop_front()?;
        self.note(&event);
        Some(event)
    }

    /// Waits for the next event. After a failure the next call reconnects at once, so the caller must pause first.
    pub(super) async fn next(&mut self) -> Result<Event, Failure> {
        // The client itself does not notice a connection into which nothing can be written any more.
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

    /// Waits for the next event, and calls `judge` whenever `hearing` is due.
    ///
    /// # Errors
    /// The first error of `judge`.
    pub(super) async fn next_while<E>(
        &mut self,
        hearing: &mut Hearing,
        mut judge: impl FnMut(&mut Hearing) -> Result<(), E>,
    ) -> Result<Result<Event, Failure>, E> {
        // The future is polled again after each judgement, so that no operation of the client is cancelled.
        let mut next = pin!(self.next());
        loop {
            tokio::select! {
                biased;
                event = &mut next => return Ok(event),
                () = sleep_until(hearing.due()) => judge(hearing)?,
            }
        }
    }

    /// Uses this connection's node and credentials from the next attempt on, and a new client id if there is one.
    pub(super) fn renew(&mut self, connection: &Connection, client_id: Option<String>) {
        let before = &self.events.options;
        let (mut options, reached) = connection.options_as(client_id.unwrap_or_else(|| before.client_id()));
        if let Some(will) = before.last_will() {
            options.set_last_will(will);
        }
        self.events.options = options;
        (self.broker, self.reached) = (connection.broker.clone(), reached);
    }

    /// Sets whether the broker shall retain the last will of the next connection.
    pub(super) fn set_will_retained(&mut self, is_retained: bool) {
        if let Some(will) = self.events.options.last_will() {
            self.events.options.set_last_will(LastWill { retain: is_retained, ..will });
        }
    }

    fn note(&mut self, event: &Event) {
        if let Event::Incoming(Packet::ConnAck(ack)) = event {
            self.connected = true;
            self.patience = patience(keep_alive_s(ack));
        }
    }
}

/// Keep-alive interval, s: the broker's value takes precedence.
fn keep_alive_s(ack: &ConnAck) -> u16 {
    ack.properties.as_ref().and_then(|properties| properties.server_keep_alive).unwrap_or(KEEP_ALIVE_S)
}

fn patience(keep_alive_s: u16) -> Duration {
    Duration::from_secs(if keep_alive_s == 0 { DAY_S } else { 2 * u64::from(keep_alive_s) })
}
