//! One connection that hears some topics exactly as they are published, and can say anything: to test a robot with.
//!
//! It is not made anew when it breaks: whoever tests must know that something was not heard.

use std::time::{Duration, Instant};

use bytes::Bytes;
use rumqttc::{
    AsyncClient, Event, Packet, PublishOptions, PublishProperties, QoS, SubscribeFilterInput, SubscribeReasonCode,
};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use vibrissa_protocol::QualityOfService;

use super::Connection;
use super::address::BrokerAddress;
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem};
use super::publish::is_failure;

/// How long the good-bye may take.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(2);

/// A message as its sender published it.
#[derive(Debug, Clone)]
pub struct Said {
    /// Its topic.
    pub topic: String,
    /// Its bytes.
    pub payload: Bytes,
    /// The quality of service it was published with: 0, 1 or 2.
    pub qos: u8,
    /// Whether it was published to be retained.
    pub retained: bool,
    /// When it came.
    pub at: Instant,
}

/// Why there is no conversation, in a sentence for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Silence(String);

/// A connection. Dropped, it breaks.
#[derive(Debug)]
pub struct Talk {
    client: AsyncClient,
    heard: mpsc::UnboundedReceiver<Result<Said, Silence>>,
    polling: JoinHandle<()>,
}

impl Talk {
    /// Connects and subscribes; what is retained there comes first.
    ///
    /// # Errors
    /// There is no connection, or the broker does not let us read.
    pub async fn open(connection: &Connection, topics: &[String]) -> Result<Self, Silence> {
        let (options, reached) = connection.options("check");
        let (client, events) = AsyncClient::builder(options).capacity(256).build();
        let mut poller = Poller::new(events, connection, reached);
        let problem = |cause| Silence(Problem::new(&connection.broker, cause).to_string());
        // QoS 2 and the publisher's own flag: nothing is made less than it was.
        let filters =
            topics.iter().map(|topic| SubscribeFilterInput::new(topic, QoS::ExactlyOnce).preserve_retain(true));
        let mut filters = Some(filters.collect::<Vec<_>>());
        loop {
            match poller.next().await.map_err(silence)? {
                Event::Incoming(Packet::ConnAck(_)) => {
                    let asked = client.try_subscribe_many(filters.take().unwrap_or_default());
                    asked.map_err(|error| problem(Cause::Lost(error.to_string())))?;
                }
                Event::Incoming(Packet::SubAck(ack)) => {
                    let is_refused = |code: &&SubscribeReasonCode| !matches!(code, SubscribeReasonCode::Success(_));
                    if let Some(code) = ack.return_codes.iter().find(is_refused) {
                        return Err(problem(Cause::Subscription(format!("{} ({code:?})", topics.join(", ")))));
                    }
                    break;
                }
                Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_) => {}
            }
        }
        // Unbounded: a robot says little, and whoever tests it keeps it all.
        let (sender, heard) = mpsc::unbounded_channel();
        Ok(Self { client, heard, polling: tokio::spawn(poll(connection.broker.clone(), poller, sender)) })
    }

    /// Publishes, not retained; `expiry_s` is how long the broker may keep it.
    ///
    /// # Errors
    /// The connection has ended.
    pub async fn say(
        &self,
        topic: String,
        payload: Vec<u8>,
        quality: QualityOfService,
        expiry_s: Option<u32>,
    ) -> Result<(), Silence> {
        let options = PublishOptions::new(match quality {
            QualityOfService::AtMostOnce => QoS::AtMostOnce,
            QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
        });
        let properties = PublishProperties { message_expiry_interval: expiry_s, ..PublishProperties::default() };
        let said = self.client.publish(topic, payload, options.properties(properties)).await;
        said.map_err(|error| Silence(error.to_string()))
    }

    /// The next message. Nothing is lost if it is not waited for to the end.
    ///
    /// # Errors
    /// The connection has ended, for that reason.
    pub async fn next(&mut self) -> Result<Said, Silence> {
        let ended = || Err(Silence("the connection has ended".to_owned()));
        self.heard.recv().await.unwrap_or_else(ended)
    }

    /// Ends it in good order: what was said is out.
    pub async fn close(mut self) {
        if self.client.disconnect().await.is_ok() {
            // Ends by itself when the disconnect is out; if not, dropping it does.
            let _ = tokio::time::timeout(FAREWELL_TIMEOUT, &mut self.polling).await;
        }
    }
}

impl Drop for Talk {
    fn drop(&mut self) {
        self.polling.abort();
    }
}

fn silence(failure: Failure) -> Silence {
    match failure {
        Failure::Broken(problem) => Silence(problem.to_string()),
        Failure::Finished => Silence("the connection was ended".to_owned()),
    }
}

async fn poll(broker: BrokerAddress, mut poller: Poller, heard: mpsc::UnboundedSender<Result<Said, Silence>>) {
    loop {
        let said = match poller.next().await {
            Ok(Event::Incoming(Packet::PubAck(ack))) if is_failure(&ack) => {
                let cause = Cause::Publication(format!("{:?}", ack.reason));
                Err(Silence(Problem::new(&broker, cause).to_string()))
            }
            Ok(Event::Incoming(Packet::Publish(publish))) => Ok(Said {
                topic: String::from_utf8_lossy(&publish.topic).into_owned(),
                payload: publish.payload,
                qos: publish.qos as u8,
                retained: publish.retain,
                at: Instant::now(),
            }),
            Ok(_) => continue,
            Err(failure) => Err(silence(failure)),
        };
        let is_end = said.is_err();
        // Nobody listens any more.
        if heard.send(said).is_err() || is_end {
            return;
        }
    }
}
