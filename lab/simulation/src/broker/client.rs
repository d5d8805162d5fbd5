//! Clients in this process: simulated robots, and the world that looks at the broker.

use bytes::Bytes;
use rumqttc::{
    Connect, ConnectAuth, ConnectProperties, Disconnect, DisconnectReasonCode, LastWill, Packet, PubAck, PubAckReason,
    Publish, PublishProperties, QoS, Subscribe, SubscribeFilter, Unsubscribe,
};

use super::ModelBroker;
use super::port::ClientPort;

/// How a client connects.
#[derive(Debug, Clone)]
pub struct ClientOptions {
    /// Client id; a later connection with the same one ends this one.
    pub id: String,
    /// Message that the broker publishes if the connection ends without a farewell.
    pub will: Option<LastWill>,
    /// Whether an earlier session with this id is forgotten.
    pub is_clean_start: bool,
    /// How long the session outlives the connection, s.
    pub session_s: u32,
    /// Keep-alive, s; 0 for none. The client need not ping: it counts as silent only while its way to the broker is held.
    pub keep_alive_s: u16,
    /// Most messages with QoS 1 that are sent to this client before it takes one.
    pub in_flight_max: u16,
}

impl ClientOptions {
    /// A clean start without session and will, with a keep-alive of 6 s.
    #[must_use]
    pub fn new(id: impl Into<String>) -> Self {
        Self { id: id.into(), will: None, is_clean_start: true, session_s: 0, keep_alive_s: 6, in_flight_max: u16::MAX }
    }
}

/// The broker does not accept the connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotAccepting;

/// A connected client. Dropping it breaks the connection, so that the broker publishes its will.
#[derive(Debug)]
pub struct Client {
    port: ClientPort,
    last_id: u16,
    is_session_present: bool,
}

impl Client {
    /// Connects, and waits for the answer as long as it takes.
    ///
    /// # Errors
    /// The broker accepts no connection, or ends it before it answers.
    pub async fn connect(broker: &ModelBroker, options: ClientOptions) -> Result<Self, NotAccepting> {
        let ClientOptions { id, will, is_clean_start, session_s, keep_alive_s, in_flight_max } = options;
        let port = ClientPort::open(broker, Some(&id)).ok_or(NotAccepting)?;
        let properties = ConnectProperties {
            session_expiry_interval: Some(session_s),
            receive_maximum: Some(in_flight_max),
            ..ConnectProperties::new()
        };
        let (clean_start, properties) = (is_clean_start, Some(properties));
        let connect = Connect { keep_alive: keep_alive_s, client_id: id, clean_start, properties };
        port.send(Packet::Connect(connect, will, ConnectAuth::None));
        match port.next().await {
            Some(Packet::ConnAck(ack)) => Ok(Self { port, last_id: 0, is_session_present: ack.session_present }),
            _ => Err(NotAccepting),
        }
    }

    /// Whether the broker has kept the session of an earlier connection.
    #[must_use]
    pub fn is_session_present(&self) -> bool {
        self.is_session_present
    }

    fn next_id(&mut self) -> u16 {
        self.last_id = self.last_id.checked_add(1).unwrap_or(1);
        self.last_id
    }

    /// Subscribes to filters with QoS 1. Returns the packet identifier, which the [`Packet::SubAck`] has.
    pub fn subscribe<'a>(&mut self, filters: impl IntoIterator<Item = &'a str>) -> u16 {
        self.subscribe_as(filters.into_iter().map(|filter| SubscribeFilter::new(filter, QoS::AtLeastOnce)))
    }

    /// Subscribes with options, at least one filter. Returns the packet identifier.
    pub fn subscribe_as(&mut self, filters: impl IntoIterator<Item = SubscribeFilter>) -> u16 {
        let pkid = self.next_id();
        self.port.send(Packet::Subscribe(Subscribe { pkid, ..Subscribe::new_many(filters, None) }));
        pkid
    }

    /// Ends a subscription. Returns the packet identifier, which the [`Packet::UnsubAck`] has.
    pub fn unsubscribe(&mut self, filter: &str) -> u16 {
        let pkid = self.next_id();
        self.port.send(Packet::Unsubscribe(Unsubscribe { pkid, ..Unsubscribe::new(filter, None) }));
        pkid
    }

    /// Publishes. Returns the packet identifier, which the [`Packet::PubAck`] has; 0 for QoS 0.
    pub fn publish(&mut self, topic: &str, payload: impl Into<Bytes>, qos: QoS, is_retained: bool) -> u16 {
        self.publish_as(Publish { retain: is_retained, ..Publish::new(topic, qos, payload, None) })
    }

    /// Publishes with an expiry, s, from the time at which it arrives at the broker. Returns the packet identifier.
    pub fn publish_expiring(&mut self, topic: &str, payload: impl Into<Bytes>, qos: QoS, expiry_s: u32) -> u16 {
        let properties = PublishProperties { message_expiry_interval: Some(expiry_s), ..PublishProperties::default() };
        self.publish_as(Publish::new(topic, qos, payload, Some(properties)))
    }

    /// Publishes a packet, also a repetition; its packet identifier is set. Returns that identifier; 0 for QoS 0.
    pub fn publish_as(&mut self, publish: Publish) -> u16 {
        let pkid = if publish.qos == QoS::AtMostOnce { 0 } else { self.next_id() };
        self.port.send(Packet::Publish(Publish { pkid, ..publish }));
        pkid
    }

    /// Asks for a [`Packet::PingResp`].
    pub fn ping(&self) {
        self.port.send(Packet::PingReq);
    }

    /// Waits for the next packet from the broker; `None` at the end of the connection. Messages with QoS 1 are
    /// acknowledged by it. Cancel safe.
    pub async fn recv(&mut self) -> Option<Packet> {
        let packet = self.port.next().await?;
        Some(self.taken(packet))
    }

    /// The next packet that has arrived, as [`Self::recv`] returns it; `None` also if there is none yet.
    pub fn try_recv(&mut self) -> Option<Packet> {
        let packet = self.port.try_next()??;
        Some(self.taken(packet))
    }

    fn taken(&self, packet: Packet) -> Packet {
        if let Packet::Publish(publish) = &packet
            && publish.qos == QoS::AtLeastOnce
        {
            let ack = PubAck { pkid: publish.pkid, reason: PubAckReason::Success, properties: None };
            self.port.send(Packet::PubAck(ack));
        }
        packet
    }

    /// Waits for the next message; other packets are dropped. `None` at the end of the connection. Cancel safe.
    pub async fn message(&mut self) -> Option<Publish> {
        loop {
            if let Packet::Publish(publish) = self.recv().await? {
                return Some(publish);
            }
        }
    }

    /// Says farewell, so that the broker publishes no will.
    pub fn disconnect(self) {
        self.port.send(Packet::Disconnect(Disconnect::new(DisconnectReasonCode::NormalDisconnection)));
    }

    /// Ends the connection without a farewell, so that the broker publishes the will.
    pub fn die(self) {
        drop(self);
    }
}
