//! A robot's message between the inbox and its worker.

use bytes::Bytes;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{Name, RobotTopic, Topic};

/// A message of a robot of the fleet, not decoded yet.
#[derive(Debug, Clone)]
pub(crate) struct RawMessage {
    pub(crate) topic: Topic,
    pub(crate) robot: Name,
    pub(crate) kind: RobotTopic,
    pub(crate) payload: Bytes,
    pub(crate) received: Micros,
}

impl RawMessage {
    /// Whether it clears a retained message: people and the supervisor do so for robots that have left.
    pub(crate) fn is_clearing(&self) -> bool {
        self.payload.is_empty() && self.kind.is_retained()
    }
}

/// Times of a `contacts` message.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MessageTimes {
    /// Time of the newest contact by the robot's clock; `None` if the message has no contacts.
    pub(crate) newest_contact: Option<Micros>,
    /// Time of receipt.
    pub(crate) received: Micros,
}
