//! Messages on their way from the engine to the broker.

use std::time::Instant;

use prometheus::Histogram;
use vibrissa_core::units::Micros;
use vibrissa_protocol::QualityOfService;

use crate::clock::wall_clock;

/// A message to publish.
#[derive(Debug, Clone)]
pub struct Publication {
    /// Topic.
    pub topic: String,
    /// JSON.
    pub payload: Vec<u8>,
    /// Quality of service.
    pub qos: QualityOfService,
    /// Deadline for sending, for setpoints. The remaining time becomes the MQTT message expiry.
    pub until: Option<Instant>,
    /// What is stopped when it is on its way, for setpoints that were not sent before.
    pub stopwatch: Option<Stopwatch>,
}

/// The time from what led to a setpoint, into a metric.
#[derive(Debug, Clone)]
pub struct Stopwatch {
    pub(crate) since: Micros,
    pub(crate) seconds: Histogram,
}

impl Stopwatch {
    /// Writes down the time that it took.
    pub fn stop(&self) {
        self.seconds.observe(wall_clock().since(self.since).as_s());
    }
}
