//! A read-only connection that receives all messages of a fleet: for recordings.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rumqttc::{AsyncClient, Event, Packet, QoS, SubscribeFilterInput, SubscribeReasonCode};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use vibrissa_host::task;

use super::Connection;
use super::hearing::is_probe_on;
use super::link::Side;
use super::nodes::Attempts;
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem, STOPPED};
use super::subscriptions::refused_filter;
use crate::inbox::Incoming;
use vibrissa_edge::clock::wall_clock;

/// Progress of a recording connection.
#[derive(Debug, Default)]
pub struct RecorderState {
    attempts: AtomicU64,
    subscriptions: AtomicU64,
    breaks: AtomicU64,
}

impl RecorderState {
    /// Number of attempts to connect.
    #[must_use]
    pub fn attempts(&self) -> u64 {
        self.attempts.load(Ordering::Relaxed)
    }

    /// Whether the broker has accepted the subscription at least once.
    #[must_use]
    pub fn has_subscribed(&self) -> bool {
        self.subscriptions.load(Ordering::Relaxed) > 0
    }

    /// Number of subscribed connections that broke.
    #[must_use]
    pub fn breaks(&self) -> u64 {
        self.breaks.load(Ordering::Relaxed)
    }
}

/// Receives all messages of the connection's fleet until the task is aborted, and reconnects after failures. `state`
/// follows the connection. A slow receiver makes the broker wait.
pub fn record(connection: Connection, sender: mpsc::Sender<Incoming>, state: Arc<RecorderState>) -> JoinHandle<()> {
    task::spawn(async move {
        let (mut connection, mut attempts) = (Attempts::first(&connection), Attempts::new());
        loop {
            state.attempts.fetch_add(1, Ordering::Relaxed);
            let (problem, was_subscribed) = listen(&connection, &sender, &state).await;
            if sender.is_closed() {
                return;
            }
            if was_subscribed {
                state.breaks.fetch_add(1, Ordering::Relaxed);
                attempts.reset();
            }
            connection.link.broken(Side::Receiving, &problem);
            connection = attempts.next(&connection, &problem).await;
        }
    })
}

/// One connection, from the attempt to its end: the reason of the end, and whether the subscription was accepted.
async fn listen(connection: &Connection, sender: &mpsc::Sender<Incoming>, state: &RecorderState) -> (Problem, bool) {
    let filter = format!("whisker/v1/{}/#", connection.fleet);
    let problem = |cause| Problem::new(&connection.broker, cause);
    let (options, reached) = connection.options("record");
    let (client, events) = AsyncClient::builder(options).capacity(64).build();
    let mut poller = Poller::new(events, connection, reached);
    let mut was_subscribed = false;
    loop {
        match poller.next().await {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                let filter_input = SubscribeFilterInput::new(filter.clone(), QoS::AtLeastOnce);
                if let Err(error) = client.try_subscribe_many([filter_input]) {
                    return (Problem::of_client(&connection.broker, &error), was_subscribed);
                }
            }
            Ok(Event::Incoming(Packet::SubAck(ack))) => {
                let refused = ack.return_codes.iter().find(|code| !matches!(code, SubscribeReasonCode::Success(_)));
                if let Some(code) = refused {
                    return (problem(Cause::Subscription(refused_filter(&filter, *code))), was_subscribed);
                }
                was_subscribed = true;
                state.subscriptions.fetch_add(1, Ordering::Relaxed);
                connection.link.connected(Side::Receiving, &connection.broker.node());
            }
            // Probes of supervisors.
            Ok(Event::Incoming(Packet::Publish(publish))) if is_probe_on(&publish.topic, &publish.payload) => {}
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                let incoming = Incoming { topic: publish.topic, payload: publish.payload, received: wall_clock() };
                if sender.send(incoming).await.is_err() {
                    return (problem(Cause::Lost("the recording has ended".to_owned())), was_subscribed);
                }
            }
            Ok(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) => {}
            Err(Failure::Broken(broken)) => return (broken, was_subscribed),
            Err(Failure::Finished) => return (problem(Cause::Lost(STOPPED.to_owned())), was_subscribed),
        }
    }
}
