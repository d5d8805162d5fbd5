//! Messages on their way from the engine to the broker.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use prometheus::Histogram;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{Name, QualityOfService, RobotTopic};

use vibrissa_edge::clock::wall_clock;

/// A message to publish.
#[derive(Debug, Clone)]
pub struct Publication {
    /// The MQTT topic.
    pub topic: String,
    /// The robot, and its topic; `None` for a message to nobody in particular.
    pub robot: Option<(Name, RobotTopic)>,
    /// The message as JSON.
    pub payload: Vec<u8>,
    /// Quality of service.
    pub qos: QualityOfService,
    /// Whether the broker retains the message.
    pub is_retained: bool,
    /// Deadline for sending. The remaining time becomes the MQTT message expiry, unless the message is retained.
    pub until: Option<Instant>,
    /// Measures the time until the setpoint is published; `None` for other messages, and for setpoints that are sent
    /// again.
    pub stopwatch: Option<Stopwatch>,
}

impl Publication {
    /// Whether it only states what a transaction has recorded. Such a message stays true after the lease has expired.
    #[must_use]
    pub fn states_a_commit(&self) -> bool {
        matches!(self.robot, Some((_, RobotTopic::Receipt)))
    }
}

/// Measures the time from the event that led to a setpoint, as a metric.
#[derive(Debug, Clone)]
pub struct Stopwatch {
    pub(crate) since: Micros,
    pub(crate) seconds: Histogram,
}

impl Stopwatch {
    /// Records the elapsed time.
    pub fn stop(&self) {
        self.seconds.observe(wall_clock().since(self.since).as_s());
    }
}

/// Whether publications may have been lost, because the connection has broken. Messages of which nobody expects an answer
/// must then be published again.
#[derive(Debug, Clone, Default)]
pub struct Losses(Arc<AtomicBool>);

impl Losses {
    /// Records that publications may have been lost.
    pub fn note(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether publications may have been lost since the last call.
    pub(crate) fn take(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}
