//! A message as the broker keeps it.

use std::sync::Arc;
use std::time::Duration;

use rumqttc::{LastWill, LastWillProperties, Publish, PublishProperties, QoS};
use tokio::time::Instant;

/// Identifier of a client, as its CONNECT states it.
pub(super) type ClientId = Arc<str>;

/// A published message, or a will.
#[derive(Debug, Clone)]
pub(super) struct Message {
    /// As published, without packet identifier and repetition flag.
    pub(super) publish: Publish,
    pub(super) from: ClientId,
    /// When it expires; `None` for never.
    expires: Option<Instant>,
}

impl Message {
    pub(super) fn new(now: Instant, from: ClientId, publish: Publish) -> Self {
        let seconds = publish.properties.as_ref().and_then(|properties| properties.message_expiry_interval);
        let expires = seconds.map(|seconds| now + Duration::from_secs(seconds.into()));
        Self { publish: Publish { dup: false, pkid: 0, ..publish }, from, expires }
    }

    pub(super) fn has_expired(&self, now: Instant) -> bool {
        self.expires.is_some_and(|at| at <= now)
    }

    /// Topic; empty if it is no text, which the codec refuses.
    pub(super) fn topic(&self) -> &str {
        std::str::from_utf8(&self.publish.topic).unwrap_or_default()
    }
}

/// A will as the publication that it becomes.
pub(super) fn will_as_publish(will: LastWill) -> Publish {
    let LastWill { topic, message, qos, retain, properties } = will;
    let properties = properties.map(|of_will: LastWillProperties| PublishProperties {
        payload_format_indicator: of_will.payload_format_indicator,
        message_expiry_interval: of_will.message_expiry_interval,
        response_topic: of_will.response_topic,
        correlation_data: of_will.correlation_data,
        user_properties: of_will.user_properties,
        content_type: of_will.content_type,
        ..PublishProperties::default()
    });
    Publish { dup: false, qos, retain, topic, pkid: 0, payload: message, properties }
}

/// A message on its way to one client.
#[derive(Debug, Clone)]
pub(super) struct Delivery {
    pub(super) message: Message,
    pub(super) qos: QoS,
    /// Retain flag of the delivery.
    pub(super) retain: bool,
    /// It may have been delivered before.
    pub(super) dup: bool,
    /// Packet identifier, once it was sent.
    pub(super) id: Option<u16>,
}

impl Delivery {
    /// The packet to send now, with the expiry that is left, in whole seconds.
    pub(super) fn packet(&self, now: Instant, id: u16) -> Publish {
        let (qos, retain, dup) = (self.qos, self.retain, self.dup && self.qos != QoS::AtMostOnce);
        let mut packet = Publish { dup, qos, retain, pkid: id, ..self.message.publish.clone() };
        if let (Some(at), Some(properties)) = (self.message.expires, &mut packet.properties) {
            let left_s = at.duration_since(now).as_millis().div_ceil(1000);
            properties.message_expiry_interval = Some(u32::try_from(left_s).unwrap_or(u32::MAX));
        }
        packet
    }
}
