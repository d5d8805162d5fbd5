//! What the service counts, in base units; each declared once.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use prometheus::{
    Encoder, Histogram, HistogramOpts, IntCounter, IntCounterVec, IntGauge, IntGaugeVec, Opts, Registry, TextEncoder,
};
use vibrissa_protocol::Name;

/// Every metric.
#[derive(Debug, Clone)]
pub struct Metrics {
    registry: Registry,
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
    /// What operators asked, by kind and by what became of it.
    pub actions: IntCounterVec,
    /// Whiskers, by fault or else condition.
    whiskers: IntGaugeVec,
    /// 1 for each fleet that is supervised here.
    lease_held: IntGaugeVec,
    /// The epoch that it was last supervised in here.
    lease_epoch: IntGaugeVec,
    /// 1 for each fleet while its messages are received.
    connected: IntGaugeVec,
    /// The fleet that [`Metrics::of_fleet`] was asked for, and the words that its whiskers had.
    fleet: Arc<str>,
    words: Arc<Mutex<BTreeSet<&'static str>>>,
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
    /// 1 while the fleet's messages are received; of no fleet in what [`Metrics::new`] gives.
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
                &[
                    "UNCOMPENSATED",
                    "SETPOINT_FAILED",
                    "SENSITIVITY_LOSS",
                    "ERODING",
                    "ARRAY_SHIFT",
                    "BASELINE_DRIFT",
                    "PROPOSED",
                ],
            )?,
            actions: counters_by(r, "vibrissa_actions_total", "What operators asked, answered.", &["kind", "state"])?,
            whiskers: gauges(r, "vibrissa_whiskers", "Whiskers, by fault or else condition.", &["fleet", "health"])?,
            lease_held: gauges(r, "vibrissa_lease_held", "1 for each fleet that is supervised here.", &["fleet"])?,
            lease_epoch: gauges(
                r,
                "vibrissa_lease_epoch",
                "The epoch in which a fleet was last supervised here.",
                &["fleet"],
            )?,
            connected: gauges(
                r,
                "vibrissa_broker_connected",
                "1 for each fleet while connected to the broker.",
                &["fleet"],
            )?,
            fleet: Arc::from(""),
            words: Arc::default(),
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
            broker_connected: IntGauge::new("vibrissa_broker_connected", "of no fleet")?,
            registry,
        })
    }

    /// The same metrics, where those that have a fleet are that fleet's.
    #[must_use]
    pub fn of_fleet(&self, fleet: &Name) -> Self {
        Self {
            broker_connected: self.connected.with_label_values(&[fleet.as_str()]),
            fleet: Arc::from(fleet.as_str()),
            words: Arc::default(),
            ..self.clone()
        }
    }

    /// Says how many whiskers of the fleet are in each state of health.
    pub fn set_whiskers(&self, counts: &BTreeMap<&'static str, i64>) {
        let mut words = self.words.lock().unwrap_or_else(PoisonError::into_inner);
        words.extend(counts.keys());
        for health in words.iter() {
            let count = counts.get(health).copied().unwrap_or_default();
            self.whiskers.with_label_values(&[&*self.fleet, *health]).set(count);
        }
    }

    /// Says that nothing is known of the fleet here any more.
    pub fn forget_fleet(&self) {
        self.set_whiskers(&BTreeMap::new());
        self.broker_connected.set(0);
    }

    /// Says whether a fleet is supervised here, and in which epoch.
    pub fn lease(&self, fleet: &Name, epoch: Option<u64>) {
        self.lease_held.with_label_values(&[fleet.as_str()]).set(i64::from(epoch.is_some()));
        if let Some(epoch) = epoch {
            self.lease_epoch.with_label_values(&[fleet.as_str()]).set(epoch as i64);
        }
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
    counters_by(registry, name, help, &[label])
}

fn counters_by(registry: &Registry, name: &str, help: &str, labels: &[&str]) -> prometheus::Result<IntCounterVec> {
    let metric = IntCounterVec::new(Opts::new(name, help), labels)?;
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

fn gauges(registry: &Registry, name: &str, help: &str, labels: &[&str]) -> prometheus::Result<IntGaugeVec> {
    let metric = IntGaugeVec::new(Opts::new(name, help), labels)?;
    registry.register(Box::new(metric.clone()))?;
    Ok(metric)
}

fn histogram(registry: &Registry, name: &str, help: &str, buckets: Vec<f64>) -> prometheus::Result<Histogram> {
    let metric = Histogram::with_opts(HistogramOpts::new(name, help).buckets(buckets))?;
    registry.register(Box::new(metric.clone()))?;
    Ok(metric)
}
