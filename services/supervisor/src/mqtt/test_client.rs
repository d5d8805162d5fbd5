//! A connection to test a robot: receives some topics unchanged, and publishes arbitrary messages.
//!
//! It is not reconnected after a failure, because the test must know that messages were missed.

use std::time::Duration;

use bytes::Bytes;
use rumqttc::{
    AsyncClient, Event, Packet, PublishOptions, PublishProperties, QoS, SubscribeFilterInput, SubscribeReasonCode,
};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::Instant;
use vibrissa_host::task;
use vibrissa_protocol::{QualityOfService, plain};

use super::address::BrokerAddress;
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem, STOPPED};
use super::proofs::is_failure;
use super::subscriptions::refused_filter;
use super::{Connection, limits};

/// Time limit for the disconnect.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(2);

/// A message as its sender published it.
#[derive(Debug, Clone)]
pub struct ReceivedMessage {
    /// Topic of the message.
    pub topic: String,
    /// Payload of the message.
    pub payload: Bytes,
    /// Quality of service of the publication: 0, 1 or 2.
    pub qos: u8,
    /// Whether the message was published with the retain flag.
    pub retained: bool,
    /// Time of receipt, by the monotonic clock.
    pub at: Instant,
}

/// Why the connection failed, as a sentence.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ConnectionEnded(String);

/// A test connection. Dropping it closes the connection.
#[derive(Debug)]
pub struct TestClient {
    client: AsyncClient,
    received: mpsc::UnboundedReceiver<Result<ReceivedMessage, ConnectionEnded>>,
    polling: JoinHandle<()>,
    retains: bool,
}

impl TestClient {
    /// Connects to the first node that can be used, and subscribes; the retained messages of the topics come first.
    ///
    /// # Errors
    /// The connection fails at each node, or the broker rejects the subscription.
    pub async fn open(connection: &Connection, topics: &[String]) -> Result<Self, ConnectionEnded> {
        let mut problems = Vec::new();
        for node in connection.broker.nodes() {
            match Self::open_at(&connection.at(&node), topics).await {
                Ok(client) => return Ok(client),
                Err(ConnectionEnded(problem)) => problems.push(problem),
            }
        }
        Err(ConnectionEnded(problems.join("; ")))
    }

    async fn open_at(connection: &Connection, topics: &[String]) -> Result<Self, ConnectionEnded> {
        let (options, reached) = connection.options("check");
        let (client, events) = AsyncClient::builder(options).capacity(256).build();
        let mut poller = Poller::new(events, connection, reached);
        let problem = |cause| ConnectionEnded(Problem::new(&connection.broker, cause).to_string());
        // QoS 2 and the publisher's retain flag, so that messages arrive as they were published.
        let filters =
            topics.iter().map(|topic| SubscribeFilterInput::new(topic, QoS::ExactlyOnce).preserve_retain(true));
        let mut filters = Some(filters.collect::<Vec<_>>());
        let mut retains = true;
        loop {
            match poller.next().await.map_err(ended)? {
                Event::Incoming(Packet::ConnAck(ack)) => {
                    if let Some(what) = limits::unusable(&ack) {
                        return Err(problem(Cause::Lacks(what)));
                    }
                    retains = ack.properties.and_then(|properties| properties.retain_available) != Some(0);
                    let subscribed = client.try_subscribe_many(filters.take().unwrap_or_default());
                    subscribed
                        .map_err(|error| ConnectionEnded(Problem::of_client(&connection.broker, &error).to_string()))?;
                }
                Event::Incoming(Packet::SubAck(ack)) => {
                    let is_refused = |code: &&SubscribeReasonCode| !matches!(code, SubscribeReasonCode::Success(_));
                    if let Some(code) = ack.return_codes.iter().find(is_refused) {
                        return Err(problem(Cause::Subscription(refused_filter(&topics.join(", "), *code))));
                    }
                    break;
                }
                Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_) => {}
            }
        }
        // Unbounded: a robot sends little, and the test keeps all of it anyway.
        let (sender, received) = mpsc::unbounded_channel();
        Ok(Self { client, received, polling: task::spawn(poll(connection.broker.clone(), poller, sender)), retains })
    }

    /// Whether the broker retains messages.
    #[must_use]
    pub fn retains(&self) -> bool {
        self.retains
    }

    /// Publishes a message that is not retained; `expiry_s` is its MQTT message expiry, s.
    ///
    /// # Errors
    /// The connection has ended.
    pub async fn publish(
        &self,
        topic: String,
        payload: Vec<u8>,
        quality: QualityOfService,
        expiry_s: Option<u32>,
    ) -> Result<(), ConnectionEnded> {
        let options = PublishOptions::new(match quality {
            QualityOfService::AtMostOnce => QoS::AtMostOnce,
            QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
        });
        let properties = PublishProperties { message_expiry_interval: expiry_s, ..PublishProperties::default() };
        let published = self.client.publish(topic, payload, options.properties(properties)).await;
        published.map_err(|error| ConnectionEnded(error.to_string()))
    }

    /// Waits for the next message. Cancel safe.
    ///
    /// # Errors
    /// The connection has ended; the error gives the reason.
    pub async fn next(&mut self) -> Result<ReceivedMessage, ConnectionEnded> {
        let ended = || Err(ConnectionEnded("the connection has ended".to_owned()));
        self.received.recv().await.unwrap_or_else(ended)
    }

    /// Disconnects after everything is sent.
    pub async fn close(mut self) {
        if self.client.disconnect().await.is_ok() {
            // The task ends when the disconnect is sent, or is aborted when `self` is dropped.
            let _ = tokio::time::timeout(FAREWELL_TIMEOUT, &mut self.polling).await;
        }
    }
}

impl Drop for TestClient {
    fn drop(&mut self) {
        self.polling.abort();
    }
}

fn ended(failure: Failure) -> ConnectionEnded {
    match failure {
        Failure::Broken(problem) => ConnectionEnded(problem.to_string()),
        Failure::Finished => ConnectionEnded(STOPPED.to_owned()),
    }
}

async fn poll(
    broker: BrokerAddress,
    mut poller: Poller,
    sender: mpsc::UnboundedSender<Result<ReceivedMessage, ConnectionEnded>>,
) {
    loop {
        let received = match poller.next().await {
            Ok(Event::Incoming(Packet::PubAck(ack))) if is_failure(&ack) => {
                let (topic, why) =
                    ("a topic of the robot".to_owned(), plain::reason_code(&format!("{:?}", ack.reason)));
                let cause = Cause::Publication { topic, why };
                Err(ConnectionEnded(Problem::new(&broker, cause).to_string()))
            }
            Ok(Event::Incoming(Packet::Publish(publish))) => Ok(ReceivedMessage {
                topic: String::from_utf8_lossy(&publish.topic).into_owned(),
                payload: publish.payload,
                qos: publish.qos as u8,
                retained: publish.retain,
                at: Instant::now(),
            }),
            Ok(_) => continue,
            Err(failure) => Err(ended(failure)),
        };
        let is_end = received.is_err();
        // The receiver was dropped.
        if sender.send(received).is_err() || is_end {
            return;
        }
    }
}
