//! Proof that the broker accepts publications, by topic: a refusal is remembered until a publication on the same topic
//! is accepted.
//!
//! The broker answers only publications with QoS 1. Receipts have QoS 0, so one of them gets QoS 1 every 5 s.

use std::time::Duration;

use rumqttc::{PubAck, PubAckReason, PublishNotice, PublishResult};
use tokio::time::Instant;
use vibrissa_host::task;
use vibrissa_protocol::{QualityOfService, plain};

use super::Connection;
use super::address::BrokerAddress;
use super::encoded::Encoded;
use super::link::BrokerLink;
use super::problem::{Cause, Problem};

/// Interval between two receipts whose acceptance the broker must confirm.
const RECEIPT_INTERVAL: Duration = Duration::from_secs(5);
/// Upper limit for the bytes of a packet beside topic and payload: header, properties, and their lengths. About 15 are
/// used.
const PACKET_OVERHEAD: usize = 32;

/// Follows the publications of a connection.
#[derive(Debug)]
pub(super) struct Proofs {
    link: BrokerLink,
    broker: BrokerAddress,
    /// When the next receipt must be confirmed.
    receipt_due: Instant,
}

impl Proofs {
    pub(super) fn new(connection: &Connection) -> Self {
        let (link, broker) = (connection.link.clone(), connection.broker.clone());
        Self { link, broker, receipt_due: Instant::now() }
    }

    /// Raises the quality of service of a receipt if its acceptance must be confirmed now: regularly, and as long as the
    /// broker has refused the last one on this topic.
    pub(super) fn ask(&mut self, encoded: Encoded, now: Instant) -> Encoded {
        let is_due = encoded.is_receipt && (now >= self.receipt_due || self.link.has_refused(&encoded.topic));
        if !is_due {
            return encoded;
        }
        self.receipt_due = now + RECEIPT_INTERVAL;
        Encoded { qos: QualityOfService::AtLeastOnce, ..encoded }
    }

    /// Whether the broker accepts a packet of this size; a larger one would end the connection. `bytes_max` is the
    /// broker's limit; 0 if it has none.
    pub(super) fn fits(&self, topic: &str, payload_bytes: usize, bytes_max: u32) -> bool {
        let bytes = topic.len() + payload_bytes + PACKET_OVERHEAD;
        let fits = bytes_max == 0 || bytes <= bytes_max as usize;
        if !fits {
            self.refused(
                topic,
                format!(
                    "because it has {bytes} bytes: raise the broker's max_packet_size from {bytes_max} to at least that"
                ),
            );
        }
        fits
    }

    /// Follows a publication until the broker has answered it.
    pub(super) fn judge(&self, topic: String, notice: PublishNotice) {
        let proofs = Self { link: self.link.clone(), broker: self.broker.clone(), receipt_due: self.receipt_due };
        task::spawn(async move {
            // Without an answer the connection has broken.
            let Ok(PublishResult::Qos1(ack)) = notice.wait_async().await else { return };
            if is_failure(&ack) {
                proofs.refused(&topic, plain::reason_code(&format!("{:?}", ack.reason)));
            } else {
                proofs.link.accepted(&topic);
            }
        });
    }

    fn refused(&self, topic: &str, why: String) {
        let problem = Problem::new(&self.broker, Cause::Publication { topic: topic.to_owned(), why });
        self.link.refused(topic, &problem);
    }
}

/// Whether the broker has rejected a publication.
pub(super) fn is_failure(ack: &PubAck) -> bool {
    !matches!(ack.reason, PubAckReason::Success | PubAckReason::NoMatchingSubscribers)
}
