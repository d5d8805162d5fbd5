//! Messages on their way from the engine to the broker.

use std::time::Instant;

use prometheus::Histogram;
use vibrissa_core::units::Micros;
use vibrissa_protocol::QualityOfService;

use vibrissa_edge::clock::wall_clock;

/// A message to publish.
#[derive(Debug, Clone)]
pub struct Publication {
    /// The MQTT topic.
    pub topic: String,
    /// The message as JSON.
    pub payload: Vec<u8>,
    /// Quality of service.
    pub qos: QualityOfService,
    /// Deadline for sending, for setpoints. The remaining time becomes the MQTT message expiry.
    pub until: Option<Instant>,
    /// Measures the time until the setpoint is published; `None` for other messages, and for setpoints that are sent
    /// again.
    pub stopwatch: Option<Stopwatch>,
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
