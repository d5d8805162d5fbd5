//! What the service counts, in base units; each declared once.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use prometheus::{
    Encoder, Histogram, HistogramOpts, IntCounter, IntCounterVec, IntGauge, IntGaugeVec, Opts, Registry, TextEncoder,
};

/// Every metric, and whether the database takes what is written.
#[derive(Debug, Clone)]
pub struct Metrics {
    registry: Registry,
    ready: Arc<AtomicBool>,
    /// Messages received, by topic.
    pub messages: IntCounterVec,
    /// Messages or contacts refused, by reason.
    pub refused: IntCounterVec,
    /// Contacts messages that had been seen before.
    pub duplicates: IntCounter,
    /// Contacts messages not taken in because the inbox was full; robots send them again.
    pub shed: IntCounter,
    /// Contacts messages that are not waited for any more: their robot does not send them again.
    pub given_up: IntCounter,
    /// Contacts taken, by what they were used for.
    pub contacts: IntCounterVec,
    /// Trims found.
    pub trims: IntCounter,
    /// Decisions, by case of the paper, `NONE` if no one could serve.
    pub decisions: IntCounterVec,
    /// Setpoints, by each state that they came into.
    pub setpoints: IntCounterVec,
    /// Alarms raised, by kind.
    pub alarms: IntCounterVec,
    /// Whiskers, by fault or else condition.
    whiskers: IntGaugeVec,
    /// Compensation errors as they were stated.
    pub compensation_error: Histogram,
    /// Time of a commit.
    pub commit_seconds: Histogram,
    /// Failed attempts at the database.
    pub database_errors: IntCounter,
    /// Receipts sent.
    pub receipts: IntCounter,
    /// Publications dropped because the broker was away; they are made again.
    pub unpublished: IntCounter,
    /// 1 while connected for receiving.
    pub broker_connected: IntGauge,
}

impl Metrics {
    /// Declares every metric.
    ///
    /// # Errors
    /// Two have the same name.
    pub fn new() -> prometheus::Result<Self> {
        let registry = Registry::new();
        let r = &registry;
        // 0.20385 and 0.3618 are what the paper measured for cases 1 and 2.
        let ratio_buckets = vec![0.02, 0.05, 0.1, 0.15, 0.20385, 0.25, 0.3, 0.3618, 0.5, 0.75, 1.0];
        let second_buckets = vec![0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 5.0];
        Ok(Self {
            ready: Arc::new(AtomicBool::new(true)),
            messages: counters(r, "vibrissa_messages_total", "Messages received.", "topic")?,
            refused: counters(r, "vibrissa_refused_total", "Messages or contacts refused.", "reason")?,
            duplicates: counter(r, "vibrissa_duplicates_total", "Contacts messages that had been seen before.")?,
            shed: counter(r, "vibrissa_shed_total", "Contacts messages not taken in because the inbox was full.")?,
            given_up: counter(r, "vibrissa_given_up_total", "Contacts messages not waited for any more.")?,
            contacts: counters(r, "vibrissa_contacts_total", "Contacts taken, by what they were used for.", "used")?,
            trims: counter(r, "vibrissa_trims_total", "Trims found.")?,
            decisions: counters_of(
                r,
                "vibrissa_compensations_total",
                "Decisions about trimmed whiskers.",
                "case",
                &["SELF_COMPENSATION", "SHORTER_FOR_LONGER", "LONGER_FOR_SHORTER", "NONE"],
            )?,
            setpoints: counters_of(
                r,
                "vibrissa_setpoints_total",
                "Setpoints, by each state they came into.",
                "state",
                &["PENDING", "APPLIED", "REJECTED", "FAILED", "SUPERSEDED", "EXPIRED", "ABANDONED"],
            )?,
            alarms: counters_of(
                r,
                "vibrissa_alarms_total",
                "Alarms raised.",
                "kind",
                &["UNCOMPENSATED", "SETPOINT_FAILED", "SENSITIVITY_LOSS", "ERODING"],
            )?,
            whiskers: gauges(r, "vibrissa_whiskers", "Whiskers, by fault or else condition.", "health")?,
            compensation_error: histogram(
                r,
                "vibrissa_compensation_error_ratio",
                "Measured compensation errors (Eq. 35) as they were stated.",
                ratio_buckets,
            )?,
            commit_seconds: histogram(r, "vibrissa_commit_seconds", "Time of a commit.", second_buckets)?,
            database_errors: counter(r, "vibrissa_database_errors_total", "Failed attempts at the database.")?,
            receipts: counter(r, "vibrissa_receipts_total", "Receipts sent.")?,
            unpublished: counter(r, "vibrissa_unpublished_total", "Publications dropped with the broker away.")?,
            broker_connected: gauge(r, "vibrissa_broker_connected", "1 while connected to the broker.")?,
            registry,
        })
    }

    /// Says how many whiskers are in each state of health.
    pub fn set_whiskers(&self, counts: &BTreeMap<&'static str, i64>) {
        self.whiskers.reset();
        for (health, count) in counts {
            self.whiskers.with_label_values(&[*health]).set(*count);
        }
    }

    /// Says whether the database takes what is written.
    pub fn ready(&self, ready: bool) {
        self.ready.store(ready, Ordering::Relaxed);
    }

    /// Whether the database takes what is written.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.ready.load(Ordering::Relaxed)
    }

    /// Prometheus' text format.
    ///
    /// # Errors
    /// A metric cannot be written down.
    pub fn text(&self) -> prometheus::Result<Vec<u8>> {
        let mut text = Vec::new();
        TextEncoder::new().encode(&self.registry.gather(), &mut text)?;
        Ok(text)
    }
}

fn counter(registry: &Registry, name: &str, help: &str) -> prometheus::Result<IntCounter> {
    let metric = IntCounter::new(name, help)?;
    registry.register(Box::new(metric.clone()))?;
    Ok(metric)
}

fn counters(registry: &Registry, name: &str, help: &str, label: &str) -> prometheus::Result<IntCounterVec> {
    let metric = IntCounterVec::new(Opts::new(name, help), &[label])?;
    registry.register(Box::new(metric.clone()))?;
    Ok(metric)
}

/// The same, with these series there from the start: a rate over a series that begins with its first event
/// misses that event.
fn counters_of(
    registry: &Registry,
    name: &str,
    help: &str,
    label: &str,
    values: &[&str],
) -> prometheus::Result<IntCounterVec> {
    let metric = counters(registry, name, help, label)?;
    for value in values {
        metric.with_label_values(&[*value]);
    }
    Ok(metric)
}

fn gauge(registry: &Registry, name: &str, help: &str) -> prometheus::Result<IntGauge> {
    let metric = IntGauge::new(name, help)?;
    registry.register(Box::new(metric.clone()))?;
    Ok(metric)
}

fn gauges(registry: &Registry, name: &str, help: &str, label: &str) -> prometheus::Result<IntGaugeVec> {
    let metric = IntGaugeVec::new(Opts::new(name, help), &[label])?;
    registry.register(Box::new(metric.clone()))?;
    Ok(metric)
}

fn histogram(registry: &Registry, name: &str, help: &str, buckets: Vec<f64>) -> prometheus::Result<Histogram> {
    let metric = Histogram::with_opts(HistogramOpts::new(name, help).buckets(buckets))?;
    registry.register(Box::new(metric.clone()))?;
    Ok(metric)
}
