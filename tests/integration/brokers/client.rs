//! An MQTT client that publishes and receives anything under any name.

use std::time::Duration;

use rumqttc::{AsyncClient, Event, LastWill, MqttOptions, Packet, PubAckReason, PublishOptions, QoS};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use vibrissa_tests::wait::PATIENCE;

/// A connected client; its connection breaks on drop.
pub(crate) struct Client {
    client: AsyncClient,
    events: mpsc::UnboundedReceiver<Event>,
    poller: JoinHandle<()>,
    heard: Vec<String>,
}

/// Identity of a client.
#[derive(Debug, Clone, Default)]
pub(crate) struct Who<'a> {
    pub(crate) id: &'a str,
    pub(crate) user: Option<(&'a str, &'a str)>,
    pub(crate) will: Option<&'a str>,
}

impl Client {
    /// Connects. None if the broker refuses the client.
    pub(crate) async fn connect(port: u16, who: &Who<'_>) -> Option<Self> {
        let mut options = MqttOptions::new(who.id, ("127.0.0.1", port));
        options.set_outgoing_inflight_upper_limit(16);
        if let Some((user, password)) = who.user {
            options.set_credentials(user, password.to_owned());
        }
        if let Some(topic) = who.will {
            options.set_last_will(LastWill::new(topic, "will", QoS::AtLeastOnce, true, None));
        }
        let (client, mut event_loop) = AsyncClient::builder(options).capacity(64).build();
        let connected = tokio::time::timeout(PATIENCE, event_loop.poll()).await.expect("an answer");
        if !matches!(connected, Ok(Event::Incoming(Packet::ConnAck(_)))) {
            return None;
        }
        let (sender, events) = mpsc::unbounded_channel();
        let poller = tokio::spawn(async move {
            while let Ok(event) = event_loop.poll().await {
                if sender.send(event).is_err() {
                    return;
                }
            }
        });
        Some(Self { client, events, poller, heard: Vec::new() })
    }

    /// Subscribes and waits for the broker's answer.
    pub(crate) async fn subscribe(&mut self, filter: &str) {
        self.client.subscribe(filter, QoS::AtLeastOnce).await.unwrap();
        self.next(|event| matches!(event, Event::Incoming(Packet::SubAck(_))).then_some(())).await;
    }

    /// Publishes a message and returns whether the broker accepted it.
    pub(crate) async fn publish(&mut self, topic: &str, retain: bool) -> bool {
        let options = PublishOptions::new(QoS::AtLeastOnce).retain(retain);
        self.client.publish(topic, "x", options).await.unwrap();
        self.next(|event| match event {
            Event::Incoming(Packet::PubAck(ack)) => {
                Some(matches!(ack.reason, PubAckReason::Success | PubAckReason::NoMatchingSubscribers))
            }
            _ => None,
        })
        .await
    }

    /// Waits until the broker has closed the connection.
    pub(crate) async fn ended(&mut self) {
        let all = async { while self.events.recv().await.is_some() {} };
        tokio::time::timeout(PATIENCE, all).await.expect("the connection is still open");
    }

    /// All topics received until `last` arrives, and shortly afterwards.
    pub(crate) async fn heard_until(mut self, last: &str) -> Vec<String> {
        while !self.heard.iter().any(|topic| topic == last) {
            self.next(|event| matches!(event, Event::Incoming(Packet::Publish(_))).then_some(())).await;
        }
        // Overlapping subscriptions may deliver the same message again.
        while let Ok(Some(event)) = tokio::time::timeout(Duration::from_millis(100), self.events.recv()).await {
            self.note(&event);
        }
        std::mem::take(&mut self.heard)
    }

    /// All topics received until the broker has answered a message to nobody.
    pub(crate) async fn heard_for_a_moment(mut self) -> Vec<String> {
        // The broker answers in order, so earlier messages arrive before the answer.
        self.publish("nobody", false).await;
        std::mem::take(&mut self.heard)
    }

    async fn next<T>(&mut self, choose: impl Fn(&Event) -> Option<T>) -> T {
        let found = async {
            loop {
                let event = self.events.recv().await.expect("the connection broke");
                self.note(&event);
                if let Some(found) = choose(&event) {
                    return found;
                }
            }
        };
        tokio::time::timeout(PATIENCE, found).await.expect("no answer from the broker")
    }

    fn note(&mut self, event: &Event) {
        if let Event::Incoming(Packet::Publish(publish)) = event {
            self.heard.push(String::from_utf8(publish.topic.to_vec()).unwrap());
        }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.poller.abort();
    }
}
