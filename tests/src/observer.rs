//! A plain MQTT client for tests: it receives the messages of a fleet and its supervisor, and can publish anything.

use std::time::Duration;

use rumqttc::{AsyncClient, Event, EventLoop, MqttOptions, Packet, PublishOptions, QoS};
use serde::Serialize;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use vibrissa_protocol::{Message, RobotTopic, Topic, decode, encode};

use crate::mqtt_311::OldClient;
use crate::wait::PATIENCE;

/// Largest packet size in bytes; no test sends more.
const PACKET_MAX: u32 = 8 << 20;

/// A message as it was received.
#[derive(Debug, Clone)]
pub struct Heard {
    /// Decoded content of the message.
    pub message: Message,
    /// Payload as received.
    pub payload: Vec<u8>,
    /// Whether the broker had retained the message.
    pub retained: bool,
    /// Quality of service of the delivery: the lower of the sender's and the subscription's, which is 1.
    pub qos: QoS,
    /// Remaining message expiry interval, seconds.
    pub expiry_s: Option<u32>,
}

/// A client with subscriptions to messages of the contract.
pub struct Observer {
    client: Client,
    heard: mpsc::UnboundedReceiver<Heard>,
    poller: JoinHandle<()>,
}

/// The client by the version of MQTT.
enum Client {
    Five(AsyncClient),
    Old(OldClient),
}

impl Observer {
    /// Connects and subscribes to everything of fleet `f`; retained messages come first.
    pub async fn connect(port: u16, name: &str) -> Self {
        Self::subscribed(port, name, &["whisker/v1/f/#"]).await
    }

    /// Connects and subscribes to the given topic filters.
    ///
    /// # Panics
    /// No broker answers in time.
    pub async fn subscribed(port: u16, name: &str, filters: &[&str]) -> Self {
        Self::subscribed_as(port, name, None, filters).await
    }

    /// The same with a user and a password.
    ///
    /// # Panics
    /// No broker answers in time.
    pub async fn subscribed_as(port: u16, name: &str, user: Option<(&str, &str)>, filters: &[&str]) -> Self {
        let mut options = MqttOptions::new(name, ("127.0.0.1", port));
        // The client allocates a table of this size; the default is the protocol's limit of 65,535.
        options.set_max_packet_size(Some(PACKET_MAX)).set_outgoing_inflight_upper_limit(256);
        if let Some((user, password)) = user {
            options.set_credentials(user, password.to_owned());
        }
        let (client, mut event_loop) = AsyncClient::builder(options).capacity(100).build();
        for filter in filters {
            client.subscribe(*filter, QoS::AtLeastOnce).await.expect("a client that has just begun");
        }
        let subscribed = async {
            let mut missing = filters.len();
            while missing > 0 {
                match event_loop.poll().await {
                    Ok(Event::Incoming(Packet::SubAck(_))) => missing -= 1,
                    Ok(_) => {}
                    // A broker that was restarted may not listen yet.
                    Err(_) => tokio::time::sleep(Duration::from_millis(50)).await,
                }
            }
        };
        tokio::time::timeout(PATIENCE, subscribed).await.expect("no subscription");
        let (sender, heard) = mpsc::unbounded_channel();
        let poller = tokio::spawn(poll(event_loop, sender));
        Self { client: Client::Five(client), heard, poller }
    }

    /// Connects by MQTT 3.1.1 and subscribes to the given topic filters.
    ///
    /// # Panics
    /// No broker accepts it in time.
    pub async fn subscribed_311(port: u16, name: &str, user: Option<(&str, &str)>, filters: &[&str]) -> Self {
        let (client, mut messages) = OldClient::connect(port, name, user).await.expect("a connection by MQTT 3.1.1");
        for filter in filters {
            assert!(client.subscribe(filter).await.expect("an answer"), "{filter} is refused");
        }
        let (sender, heard) = mpsc::unbounded_channel();
        let poller = tokio::spawn(async move {
            while let Some(message) = messages.recv().await {
                let qos = if message.qos == 0 { QoS::AtMostOnce } else { QoS::AtLeastOnce };
                if let Some(heard) = decoded(&message.topic, message.payload, message.retained, qos, None)
                    && sender.send(heard).is_err()
                {
                    return;
                }
            }
        });
        Self { client: Client::Old(client), heard, poller }
    }

    /// The next message. None if no message arrives within `patience`.
    ///
    /// # Panics
    /// The connection broke.
    pub async fn next(&mut self, patience: Duration) -> Option<Heard> {
        let heard = tokio::time::timeout(patience, self.heard.recv()).await.ok()?;
        Some(heard.expect("the observer's connection broke"))
    }

    /// The next message for which `choose` returns a value; other messages are discarded.
    ///
    /// # Panics
    /// No such message arrives in time.
    pub async fn expect<T>(&mut self, what: &str, mut choose: impl FnMut(Heard) -> Option<T>) -> T {
        let found = async {
            loop {
                let heard = self.heard.recv().await.expect("the observer's connection broke");
                if let Some(found) = choose(heard) {
                    return found;
                }
            }
        };
        tokio::time::timeout(PATIENCE, found).await.unwrap_or_else(|_| panic!("not received in time: {what}"))
    }

    /// Publishes a message to robot `r` as the supervisor would.
    pub async fn send(&self, topic: RobotTopic, message: &impl Serialize) {
        self.publish(&format!("whisker/v1/f/r/{topic}"), encode(message), false).await;
    }

    /// Publishes any payload with QoS 1 and returns when the broker has acknowledged it.
    ///
    /// # Panics
    /// The broker does not acknowledge it in time.
    pub async fn publish(&self, topic: &str, payload: Vec<u8>, retain: bool) {
        let client = match &self.client {
            Client::Five(client) => client,
            Client::Old(client) => return client.publish(topic, &payload, retain).await.expect("an acknowledgement"),
        };
        let options = PublishOptions::new(QoS::AtLeastOnce).retain(retain);
        let taken = async {
            let notice = client.publish_tracked(topic, payload, options).await.expect("a connected client");
            // The client reports a topic without subscribers as a failure; tests accept it.
            let _ = notice.wait_async().await;
        };
        tokio::time::timeout(PATIENCE, taken).await.unwrap_or_else(|_| panic!("cannot publish on {topic}"));
    }
}

impl Drop for Observer {
    fn drop(&mut self) {
        self.poller.abort();
    }
}

async fn poll(mut event_loop: EventLoop, sender: mpsc::UnboundedSender<Heard>) {
    while let Ok(event) = event_loop.poll().await {
        let Event::Incoming(Packet::Publish(publish)) = event else {
            continue;
        };
        let topic = std::str::from_utf8(&publish.topic).expect("text");
        let expiry_s = publish.properties.and_then(|properties| properties.message_expiry_interval);
        let Some(heard) = decoded(topic, publish.payload.to_vec(), publish.retain, publish.qos, expiry_s) else {
            continue;
        };
        if sender.send(heard).is_err() {
            return;
        }
    }
}

/// A message of the contract; `None` for a probe of a supervisor, and for an empty one, which clears a retained message.
fn decoded(topic: &str, payload: Vec<u8>, retained: bool, qos: QoS, expiry_s: Option<u32>) -> Option<Heard> {
    if payload.is_empty() || RobotTopic::probed_on(topic).is_some() {
        return None;
    }
    let topic = Topic::parse(topic).expect("a topic of the contract");
    let message = decode(&topic, &payload).expect("a message that keeps the contract");
    Some(Heard { message, payload, retained, qos, expiry_s })
}
