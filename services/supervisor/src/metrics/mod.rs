//! What the service counts, in base units; each metric is declared once: those of the program here, those of fleets in
//! [`fleet`], those of single whiskers, which are off unless asked for, in [`whiskers`].
//!
//! Labels have values of the program or of its configuration alone. Robots' names come from topics, and whoever may
//! publish can make them up.

mod document;
mod fleet;
mod http;
mod kinds;
mod labels;
mod whiskers;

use std::sync::Arc;

use prometheus::{Encoder, Gauge, IntCounter, IntGauge, IntGaugeVec, Opts, Registry, Result, TextEncoder};
use vibrissa_protocol::Name;

pub use document::document;
pub use fleet::FleetMetrics;
pub use http::{ConnectionMetrics, HttpMetrics};
pub use kinds::{Counters, Gauges, Histograms, Quantities, Word};
pub use labels::{APPROVED, INBOX, LOST, NO_CASE, OUTBOX, PROPOSED, STARTED, TAKEN, UNSERVED};
pub use whiskers::{RobotSample, WhiskerMetrics, WhiskerSample};

/// Every metric.
#[derive(Debug, Clone)]
pub struct Metrics {
    registry: Registry,
    families: Arc<fleet::Families>,
    build: IntGaugeVec,
    /// Failed attempts at the database.
    pub database_errors: IntCounter,
    /// Whether the last attempt at the database succeeded.
    pub database_up: IntGauge,
    /// Spans of traces that no collector has taken.
    pub trace_spans_dropped: IntCounter,
    /// When the tables were last found, or put, in order.
    pub upkeep_timestamp_seconds: Gauge,
    /// Failed attempts at that.
    pub upkeep_errors: IntCounter,
    /// Partitions that were dropped because all of them was too old.
    pub partitions_dropped: IntCounter,
    /// Rows that were removed one by one because they were too old.
    pub old_rows_removed: IntCounter,
    /// Requests over HTTP.
    pub http: HttpMetrics,
    /// Single robots and whiskers, if they are wanted.
    pub whiskers: Option<WhiskerMetrics>,
}

impl Metrics {
    /// Declares every metric; those of single robots and whiskers only if they are wanted.
    ///
    /// # Errors
    /// Two have the same name.
    pub fn new(per_whisker: bool) -> Result<Self> {
        let registry = Registry::new();
        #[cfg(target_os = "linux")]
        registry.register(Box::new(prometheus::process_collector::ProcessCollector::for_self()))?;
        let build = IntGaugeVec::new(
            Opts::new("vibrissa_build_info", "1, with what this program is and works with."),
            &["version", "database", "broker", "supervisor"],
        )?;
        let database_errors = IntCounter::new("vibrissa_database_errors_total", "Failed attempts at the database.")?;
        let trace_spans_dropped =
            IntCounter::new("vibrissa_trace_spans_dropped_total", "Spans of traces that no collector has taken.")?;
        let database_up = IntGauge::new("vibrissa_database_up", "1 while the last attempt at the database succeeded.")?;
        let upkeep_timestamp_seconds = Gauge::new(
            "vibrissa_upkeep_timestamp_seconds",
            "When partitions were last all there and nothing too old was left, since 1970 UTC; 0 before.",
        )?;
        let upkeep_errors = IntCounter::new(
            "vibrissa_upkeep_errors_total",
            "Failed attempts to make partitions or to remove what is too old.",
        )?;
        let partitions_dropped = IntCounter::new(
            "vibrissa_partitions_dropped_total",
            "Partitions dropped because all of them was too old.",
        )?;
        let old_rows_removed =
            IntCounter::new("vibrissa_old_rows_removed_total", "Rows removed one by one because they were too old.")?;
        registry.register(Box::new(upkeep_timestamp_seconds.clone()))?;
        for counter in [&upkeep_errors, &partitions_dropped, &old_rows_removed] {
            registry.register(Box::new(counter.clone()))?;
        }
        registry.register(Box::new(build.clone()))?;
        registry.register(Box::new(database_errors.clone()))?;
        registry.register(Box::new(database_up.clone()))?;
        registry.register(Box::new(trace_spans_dropped.clone()))?;
        let whiskers = per_whisker.then(WhiskerMetrics::declare).transpose()?;
        if let Some(whiskers) = &whiskers {
            registry.register(Box::new(whiskers.clone()))?;
        }
        Ok(Self {
            families: Arc::new(fleet::Families::declare(&registry)?),
            http: HttpMetrics::declare(&registry)?,
            build,
            database_errors,
            database_up,
            trace_spans_dropped,
            upkeep_timestamp_seconds,
            upkeep_errors,
            partitions_dropped,
            old_rows_removed,
            whiskers,
            registry,
        })
    }

    /// Says what this program is and works with.
    pub fn is(&self, supervisor: &str, database: Word, broker: Word) {
        self.build.with_label_values(&[env!("CARGO_PKG_VERSION"), database, broker, supervisor]).set(1);
    }

    /// The metrics of one fleet of the configuration. Asking for them makes them be shown.
    #[must_use]
    pub fn of_fleet(&self, fleet: &Name) -> FleetMetrics {
        self.families.of(fleet.as_str())
    }

    /// Counts an attempt at the database that failed.
    pub fn database_failed(&self) {
        self.database_errors.inc();
        self.database_up.set(0);
    }

    /// Prometheus' text format.
    ///
    /// # Errors
    /// A metric cannot be written down.
    pub fn text(&self) -> Result<Vec<u8>> {
        let mut text = Vec::new();
        TextEncoder::new().encode(&self.registry.gather(), &mut text)?;
        Ok(text)
    }
}

#[cfg(test)]
mod tests;
