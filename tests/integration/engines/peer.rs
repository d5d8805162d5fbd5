//! An MQTT 5 client that reports what the broker answers.

use std::collections::VecDeque;
use std::time::Duration;

use rumqttc::{
    AsyncClient, BrokerSessionResumePolicy, ConnAck, Event, LastWill, MqttOptions, Packet, PubAckReason, Publish,
    PublishOptions, PublishProperties, QoS, SubscribeFilterInput, SubscribeReasonCode,
};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use crate::engine::{ALL, PASSWORD};

/// Time limit for an answer of the broker.
pub(crate) const ANSWER: Duration = Duration::from_secs(8);
/// Packet size that the supervisor announces, in bytes.
pub(crate) const PACKET_MAX: u32 = 2 * 1024 * 1024;

/// Options of a connection.
#[derive(Debug, Clone)]
pub(crate) struct Who {
    pub(crate) id: String,
    pub(crate) user: &'static str,
    pub(crate) password: &'static str,
    pub(crate) will: Option<(String, bool)>,
    pub(crate) clean: bool,
    /// Lifetime of the session after the connection, s.
    pub(crate) session_s: Option<u32>,
    pub(crate) packet_max: u32,
}

impl Who {
    pub(crate) fn new(id: impl Into<String>) -> Self {
        let id = id.into();
        Self { id, user: ALL, password: PASSWORD, will: None, clean: true, session_s: None, packet_max: PACKET_MAX }
    }
}

/// A connected client; its connection breaks on drop, without a farewell.
pub(crate) struct Peer {
    pub(crate) ack: ConnAck,
    client: AsyncClient,
    events: mpsc::UnboundedReceiver<Result<Event, String>>,
    poller: JoinHandle<()>,
    heard: VecDeque<Publish>,
}

impl Peer {
    /// Connects; the error is the broker's reason.
    pub(crate) async fn connect(port: u16, who: &Who) -> Result<Self, String> {
        let mut options = MqttOptions::new(&who.id, ("127.0.0.1", port));
        options
            .set_clean_start(who.clean)
            .set_keep_alive(6)
            .set_max_packet_size(Some(who.packet_max))
            .set_outgoing_inflight_upper_limit(64)
            .set_session_expiry_interval(who.session_s)
            .set_credentials(who.user, who.password.to_owned());
        options.set_broker_session_resume_policy(BrokerSessionResumePolicy::AllowBrokerOnly);
        if let Some((topic, is_retained)) = &who.will {
            options.set_last_will(LastWill::new(topic, "will", QoS::AtLeastOnce, *is_retained, None));
        }
        let (client, mut event_loop) = AsyncClient::builder(options).capacity(2048).build();
        let ack = match timeout(ANSWER, event_loop.poll()).await {
            Ok(Ok(Event::Incoming(Packet::ConnAck(ack)))) => ack,
            Ok(Ok(other)) => return Err(format!("{other:?} instead of CONNACK")),
            Ok(Err(refused)) => return Err(refused.to_string()),
            Err(_) => return Err("no CONNACK".to_owned()),
        };
        let (sender, events) = mpsc::unbounded_channel();
        let poller = tokio::spawn(async move {
            loop {
                let event = event_loop.poll().await.map_err(|ended| ended.to_string());
                let is_end = event.is_err();
                if sender.send(event).is_err() || is_end {
                    return;
                }
            }
        });
        Ok(Self { ack, client, events, poller, heard: VecDeque::new() })
    }

    /// Subscribes at a quality of service; the error is the broker's reason.
    pub(crate) async fn subscribe(&mut self, filter: &str, qos: QoS) -> Result<(), String> {
        self.subscribe_as(SubscribeFilterInput::new(filter, qos)).await
    }

    pub(crate) async fn subscribe_as(&mut self, filter: SubscribeFilterInput) -> Result<(), String> {
        self.client.try_subscribe_many([filter]).map_err(|error| error.to_string())?;
        self.answer("SUBACK", |event| match event {
            Event::Incoming(Packet::SubAck(ack)) => Some(match ack.return_codes.first() {
                Some(SubscribeReasonCode::Success(_)) => Ok(()),
                other => Err(format!("{other:?}")),
            }),
            _ => None,
        })
        .await?
    }

    /// Publishes at QoS 1, and waits for the acknowledgement; the error is the broker's reason.
    pub(crate) async fn publish(&mut self, topic: &str, payload: impl Into<Vec<u8>>) -> Result<(), String> {
        self.publish_as(topic, payload.into(), false, None).await
    }

    pub(crate) async fn publish_as(
        &mut self,
        topic: &str,
        payload: Vec<u8>,
        is_retained: bool,
        expiry_s: Option<u32>,
    ) -> Result<(), String> {
        self.send(topic, payload, is_retained, expiry_s)?;
        self.acknowledged().await
    }

    /// Publishes at QoS 1 without waiting.
    pub(crate) fn send(
        &self,
        topic: &str,
        payload: Vec<u8>,
        is_retained: bool,
        expiry_s: Option<u32>,
    ) -> Result<(), String> {
        let properties = PublishProperties { message_expiry_interval: expiry_s, ..PublishProperties::default() };
        let options = PublishOptions::new(QoS::AtLeastOnce).retain(is_retained).properties(properties);
        self.client.try_publish(topic, payload, options).map_err(|error| error.to_string())
    }

    /// Waits for the next acknowledgement of a publication.
    pub(crate) async fn acknowledged(&mut self) -> Result<(), String> {
        self.answer("PUBACK", |event| match event {
            Event::Incoming(Packet::PubAck(ack)) => Some(match ack.reason {
                PubAckReason::Success | PubAckReason::NoMatchingSubscribers => Ok(()),
                other => Err(format!("{other:?}")),
            }),
            _ => None,
        })
        .await?
    }

    /// The next message; `None` if none comes within `patience`, or the connection ends.
    pub(crate) async fn hear(&mut self, patience: Duration) -> Option<Publish> {
        if let Some(heard) = self.heard.pop_front() {
            return Some(heard);
        }
        let next = self.within(patience, |event| match event {
            Event::Incoming(Packet::Publish(publish)) => Some(publish.clone()),
            _ => None,
        });
        let publish = next.await.ok()?;
        self.heard.pop_front();
        Some(publish)
    }

    /// The next message with this payload; others are dropped.
    pub(crate) async fn hear_payload(&mut self, payload: &[u8]) -> Result<Publish, String> {
        loop {
            match self.hear(ANSWER).await {
                Some(publish) if publish.payload == payload => return Ok(publish),
                Some(_) => {}
                None => return Err(format!("{:?} did not arrive", String::from_utf8_lossy(payload))),
            }
        }
    }

    /// Waits for the end of the connection, and returns its reason.
    pub(crate) async fn ended(&mut self) -> Result<String, String> {
        match self.within(ANSWER, |_| None::<()>).await {
            Ok(()) => unreachable!("no event is chosen"),
            Err(None) => Err("the connection stays open".to_owned()),
            Err(Some(reason)) => Ok(reason),
        }
    }

    /// Says farewell, so that the broker publishes no last will.
    pub(crate) async fn leave(mut self) {
        if self.client.try_disconnect().is_ok() {
            let _ = timeout(ANSWER, &mut self.poller).await;
        }
    }

    async fn answer<T>(&mut self, what: &str, choose: impl Fn(&Event) -> Option<T>) -> Result<T, String> {
        let found = self.within(ANSWER, choose).await;
        found.map_err(|ended| ended.unwrap_or_else(|| format!("no {what}")))
    }

    /// The first event that `choose` accepts. [`Peer::hear`] returns the messages of the meantime.
    ///
    /// # Errors
    /// The reason of the connection's end, or `None` after `patience`.
    async fn within<T>(
        &mut self,
        patience: Duration,
        choose: impl Fn(&Event) -> Option<T>,
    ) -> Result<T, Option<String>> {
        let found = async {
            loop {
                let event = self.events.recv().await.unwrap_or_else(|| Err("the connection has ended".to_owned()));
                let event = event.map_err(Some)?;
                if let Event::Incoming(Packet::Publish(publish)) = &event {
                    self.heard.push_back(publish.clone());
                }
                if let Some(found) = choose(&event) {
                    return Ok(found);
                }
            }
        };
        timeout(patience, found).await.unwrap_or(Err(None))
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.poller.abort();
    }
}
