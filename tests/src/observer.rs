//! A plain MQTT client for tests: it hears what a fleet and its supervisor say, and can say anything.

use std::time::Duration;

use rumqttc::{AsyncClient, Event, EventLoop, MqttOptions, Packet, PublishOptions, QoS};
use serde::Serialize;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use vibrissa_protocol::{Message, RobotTopic, Topic, decode, encode};

use crate::wait::PATIENCE;

/// Larger than anything that a test sends.
const PACKET_MAX: u32 = 8 << 20;

/// A message as it came.
#[derive(Debug, Clone)]
pub struct Heard {
    /// What it says.
    pub message: Message,
    /// Its bytes.
    pub payload: Vec<u8>,
    /// Whether it was retained before.
    pub retained: bool,
    /// The quality of service it came with: the lower of the sender's and ours, which is 1.
    pub qos: QoS,
    /// What is left of its time in the broker.
    pub expiry_s: Option<u32>,
}

/// A client that is subscribed to messages of the contract.
pub struct Observer {
    client: AsyncClient,
    heard: mpsc::UnboundedReceiver<Heard>,
    poller: JoinHandle<()>,
}

impl Observer {
    /// Connects and subscribes to everything of the fleet `f`; what is retained comes first.
    pub async fn connect(port: u16, name: &str) -> Self {
        Self::subscribed(port, name, &["whisker/v1/f/#"]).await
    }

    /// Connects and subscribes.
    ///
    /// # Panics
    /// There is no broker.
    pub async fn subscribed(port: u16, name: &str, filters: &[&str]) -> Self {
        let mut options = MqttOptions::new(name, ("127.0.0.1", port));
        // The client keeps a table of this size; its default is the protocol's 65,535.
        options.set_max_packet_size(Some(PACKET_MAX)).set_outgoing_inflight_upper_limit(256);
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
                    // A broker that was started again may not listen yet.
                    Err(_) => tokio::time::sleep(Duration::from_millis(50)).await,
                }
            }
        };
        tokio::time::timeout(PATIENCE, subscribed).await.expect("no subscription");
        let (sender, heard) = mpsc::unbounded_channel();
        let poller = tokio::spawn(poll(event_loop, sender));
        Self { client, heard, poller }
    }

    /// The next message; none if there is none for `patience`.
    ///
    /// # Panics
    /// The connection broke.
    pub async fn next(&mut self, patience: Duration) -> Option<Heard> {
        let heard = tokio::time::timeout(patience, self.heard.recv()).await.ok()?;
        Some(heard.expect("the observer's connection broke"))
    }

    /// The next message that `choose` takes; others are passed over.
    ///
    /// # Panics
    /// None comes.
    pub async fn expect<T>(&mut self, what: &str, mut choose: impl FnMut(Heard) -> Option<T>) -> T {
        let found = async {
            loop {
                let heard = self.heard.recv().await.expect("the observer's connection broke");
                if let Some(found) = choose(heard) {
                    return found;
                }
            }
        };
        tokio::time::timeout(PATIENCE, found).await.unwrap_or_else(|_| panic!("did not hear: {what}"))
    }

    /// Speaks as the supervisor to robot `r`.
    pub async fn send(&self, topic: RobotTopic, message: &impl Serialize) {
        self.publish(&format!("whisker/v1/f/r/{topic}"), encode(message), false).await;
    }

    /// Says anything, with QoS 1; returns when the broker has it.
    ///
    /// # Panics
    /// The broker does not take it.
    pub async fn publish(&self, topic: &str, payload: Vec<u8>, retain: bool) {
        let options = PublishOptions::new(QoS::AtLeastOnce).retain(retain);
        let taken = async {
            let notice = self.client.publish_tracked(topic, payload, options).await.expect("a connected client");
            // A topic that nobody listens to is a failure here, but none for a test.
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
        if RobotTopic::probed_on(topic).is_some() {
            continue;
        }
        let topic = Topic::parse(topic).expect("a topic of the contract");
        let heard = Heard {
            message: decode(&topic, &publish.payload).expect("a message that keeps the contract"),
            payload: publish.payload.to_vec(),
            retained: publish.retain,
            qos: publish.qos,
            expiry_s: publish.properties.and_then(|properties| properties.message_expiry_interval),
        };
        if sender.send(heard).is_err() {
            return;
        }
    }
}
