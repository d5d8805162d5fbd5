//! The broker's report about itself: counts, and each message that passes.

use bytes::Bytes;
use rumqttc::QoS;
use tokio::time::Instant;

/// Numbers of events since the broker was made; a restart does not reset them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Connections accepted.
    pub connections: u64,
    /// Connections refused because the broker accepted none.
    pub refused_connections: u64,
    /// Connections ended by a takeover of the client id.
    pub takeovers: u64,
    /// Connections ended because the client was silent for 1.5 times its keep-alive.
    pub keep_alive_timeouts: u64,
    /// Connections ended by a fault; the client was told.
    pub ended: u64,
    /// Connections ended by a fault; the client was not told.
    pub ended_silently: u64,
    /// Restarts.
    pub restarts: u64,
    /// Publications accepted, wills included.
    pub published: u64,
    /// Wills published.
    pub wills: u64,
    /// Messages sent to clients, repetitions included.
    pub delivered: u64,
    /// Publications refused by a fault.
    pub refused_publications: u64,
    /// Deliveries repeated by a fault.
    pub repeated: u64,
    /// Deliveries with QoS 0 lost by a fault.
    pub lost: u64,
    /// Deliveries dropped because a queue was full.
    pub dropped_for_room: u64,
    /// Deliveries dropped because the client accepts no packet of that size.
    pub too_large: u64,
    /// Deliveries and retained messages dropped because their expiry had passed.
    pub expired: u64,
    /// Subscriptions lost by a fault.
    pub forgotten_subscriptions: u64,
    /// Retained messages lost by a fault.
    pub forgotten_retained: u64,
    /// Times that the broker was frozen.
    pub freezes: u64,
    /// Times that a direction of a client in this process was held.
    pub holds: u64,
    /// Packets delayed, in both directions.
    pub delayed: u64,
}

/// A message that the broker has accepted, or sends to a client.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// When.
    pub at: Instant,
    /// Client id of the publisher, also of a will.
    pub from: &'a str,
    /// Topic of the message.
    pub topic: &'a str,
    /// Payload of the message.
    pub payload: &'a Bytes,
    /// Quality of service of the publication, or of the delivery.
    pub qos: QoS,
    /// Retain flag of the publication, or of the delivery.
    pub is_retained: bool,
    /// Client id of the receiver; `None` when the broker accepts the publication.
    pub to: Option<&'a str>,
}

/// Called for each acceptance and each delivery. The broker waits meanwhile, so the observer must not call it.
pub type Observer = Box<dyn FnMut(&Observed<'_>) + Send>;
