//! Metrics of the service, in base units. Each metric is defined once: those of the program here, those of fleets in
//! [`fleet`], and those of single robots and whiskers, which are off by default, in [`whiskers`].
//!
//! All other labels have values of the program or of its configuration only: names of robots come from topics, and
//! any client that may publish can make them up.

mod clocks;
mod document;
mod fleet;
mod http;
mod invariants;
mod kinds;
mod labels;
mod nodes;
#[cfg(target_os = "linux")]
mod process;
mod promises;
mod subjects;
mod webhooks;
mod whiskers;

use std::sync::Arc;

use prometheus::{Encoder, Gauge, IntCounter, IntGauge, IntGaugeVec, Opts, Registry, Result, TextEncoder};
use vibrissa_protocol::Name;

pub use clocks::ClockMetrics;
pub use document::document;
pub use fleet::FleetMetrics;
pub use http::{ConnectionMetrics, HttpMetrics};
pub use invariants::Violations;
pub use kinds::{Counters, Gauges, Histograms, Quantities, Word};
pub use labels::{APPROVED, INBOX, LOST, NO_CASE, OUTBOX, PROPOSED, PUBLISHING, RECEIVING, STARTED, TAKEN, UNSERVED};
pub use nodes::{NodeFailures, NodeInUse};
pub use webhooks::WebhookMetrics;
pub use whiskers::{RobotSample, WhiskerMetrics, WhiskerSample};

/// All metrics of the program.
#[derive(Debug, Clone)]
pub struct Metrics {
    registry: Registry,
    families: Arc<fleet::Families>,
    build: IntGaugeVec,
    /// Failed attempts to use the database.
    pub database_errors: IntCounter,
    /// 1 while the last attempt to use the database succeeded, else 0.
    pub database_up: IntGauge,
    /// Whether a failover of the database may lose commits.
    pub database_asynchronous: IntGauge,
    /// Acknowledged transactions that the database has lost.
    pub database_commits_lost: IntCounter,
    /// Trace spans that no collector accepted.
    pub trace_spans_dropped: IntCounter,
    /// Time of the last successful upkeep of the tables, s since 1970 UTC; 0 before.
    pub upkeep_timestamp_seconds: Gauge,
    /// Failed rounds of upkeep.
    pub upkeep_errors: IntCounter,
    /// Partitions that were dropped because all their rows were too old.
    pub partitions_dropped: IntCounter,
    /// Rows that were deleted because they were too old, outside of dropped partitions.
    pub old_rows_removed: IntCounter,
    /// Stored rows that cannot be read.
    rows_set_aside: IntCounter,
    /// Other clocks, compared with this supervisor's.
    pub clocks: ClockMetrics,
    /// Metrics of the HTTP servers.
    pub http: HttpMetrics,
    /// Metrics of webhooks.
    pub webhooks: WebhookMetrics,
    /// Metrics of single robots and whiskers, if they are enabled.
    pub whiskers: Option<WhiskerMetrics>,
}

impl Metrics {
    /// Registers all metrics; those of single robots and whiskers only if `per_whisker` is set.
    ///
    /// # Errors
    /// Two metrics have the same name.
    pub fn new(per_whisker: bool) -> Result<Self> {
        let registry = Registry::new();
        #[cfg(target_os = "linux")]
        registry.register(Box::new(process::ProcessMetrics::new()?))?;
        let build = IntGaugeVec::new(
            Opts::new(
                "vibrissa_build_info",
                "Always 1; its labels state the program's version, database, broker and supervisor.",
            ),
            &["version", "database", "broker", "supervisor"],
        )?;
        let database_errors =
            IntCounter::new("vibrissa_database_errors_total", "Failed attempts to use the database.")?;
        let trace_spans_dropped =
            IntCounter::new("vibrissa_trace_spans_dropped_total", "Trace spans that no collector accepted.")?;
        let database_up =
            IntGauge::new("vibrissa_database_up", "1 while the last attempt to use the database succeeded.")?;
        let database_asynchronous = IntGauge::new(
            "vibrissa_database_asynchronous",
            "1 if database.url names several servers and commits wait for no standby: a failover may lose them.",
        )?;
        let database_commits_lost = IntCounter::new(
            "vibrissa_database_commits_lost_total",
            "Acknowledged transactions that did not exist any more after a failover or a restore.",
        )?;
        let upkeep_timestamp_seconds = Gauge::new(
            "vibrissa_upkeep_timestamp_seconds",
            "Time at which all partitions existed and no row was too old, since 1970 UTC; 0 before the first.",
        )?;
        let upkeep_errors = IntCounter::new(
            "vibrissa_upkeep_errors_total",
            "Failed attempts to create partitions or to delete old rows.",
        )?;
        let partitions_dropped = IntCounter::new(
            "vibrissa_partitions_dropped_total",
            "Partitions dropped because all their rows were too old.",
        )?;
        let old_rows_removed = IntCounter::new(
            "vibrissa_old_rows_removed_total",
            "Rows deleted because they were too old, outside of dropped partitions.",
        )?;
        let rows_set_aside = IntCounter::new(
            "vibrissa_rows_set_aside_total",
            "Stored rows that could not be read and were set aside, each counted once.",
        )?;
        registry.register(Box::new(upkeep_timestamp_seconds.clone()))?;
        for counter in [&upkeep_errors, &partitions_dropped, &old_rows_removed, &rows_set_aside] {
            registry.register(Box::new(counter.clone()))?;
        }
        registry.register(Box::new(build.clone()))?;
        registry.register(Box::new(database_errors.clone()))?;
        registry.register(Box::new(database_up.clone()))?;
        registry.register(Box::new(database_asynchronous.clone()))?;
        registry.register(Box::new(database_commits_lost.clone()))?;
        registry.register(Box::new(trace_spans_dropped.clone()))?;
        let whiskers = per_whisker.then(WhiskerMetrics::declare).transpose()?;
        if let Some(whiskers) = &whiskers {
            registry.register(Box::new(whiskers.clone()))?;
        }
        Ok(Self {
            families: Arc::new(fleet::Families::declare(&registry)?),
            clocks: ClockMetrics::declare(&registry)?,
            http: HttpMetrics::declare(&registry)?,
            webhooks: WebhookMetrics::declare(&registry)?,
            build,
            database_errors,
            database_up,
            database_asynchronous,
            database_commits_lost,
            trace_spans_dropped,
            upkeep_timestamp_seconds,
            upkeep_errors,
            partitions_dropped,
            old_rows_removed,
            rows_set_aside,
            whiskers,
            registry,
        })
    }

    /// Sets the labels of `vibrissa_build_info`.
    pub fn is(&self, supervisor: &str, database: Word, broker: Word) {
        self.build.with_label_values(&[env!("CARGO_PKG_VERSION"), database, broker, supervisor]).set(1);
    }

    /// Metrics of a fleet of the configuration. The call creates their series, with the value 0.
    #[must_use]
    pub fn of_fleet(&self, fleet: &Name) -> FleetMetrics {
        self.families.of(fleet.as_str())
    }

    /// Sets the number of stored rows that could not be read so far.
    pub fn rows_set_aside(&self, rows: usize) {
        self.rows_set_aside.inc_by((rows as u64).saturating_sub(self.rows_set_aside.get()));
    }

    /// Counts a failed attempt to use the database.
    pub fn database_failed(&self) {
        self.database_errors.inc();
        self.database_up.set(0);
    }

    /// All metrics in Prometheus' text format.
    ///
    /// # Errors
    /// A metric cannot be encoded.
    pub fn text(&self) -> Result<Vec<u8>> {
        let mut text = Vec::new();
        TextEncoder::new().encode(&self.registry.gather(), &mut text)?;
        Ok(text)
    }
}

#[cfg(test)]
mod tests;
