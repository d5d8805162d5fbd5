//! Violated invariants, as far as the running supervisor observes them.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use prometheus::core::{Collector, Desc};
use prometheus::proto::MetricFamily;
use prometheus::{IntCounterVec, Opts, Result};
use tokio::time::Instant;
use tracing::error;
use vibrissa_edge::invariants::{Checker, Invariant};

use super::kinds::OfFleet;

/// Shortest interval between two log lines of the same invariant.
const LOG_INTERVAL: Duration = Duration::from_secs(60);

/// Counts of violated invariants. All fleets share the series: each violation is a defect of the program or of its
/// surroundings, and the log names its place.
#[derive(Debug, Clone)]
pub struct Violations {
    family: IntCounterVec,
    /// Time of the last log line of each invariant.
    logged: Arc<Mutex<BTreeMap<Invariant, Instant>>>,
}

impl Violations {
    /// Counts a violation at a fleet, robot or whisker, and logs at most one a minute of each invariant.
    pub fn count(&self, invariant: Invariant, at: &dyn Display, what: &dyn Display) {
        self.family.with_label_values(&[invariant.word()]).inc();
        let now = Instant::now();
        let mut logged = self.logged.lock().unwrap_or_else(PoisonError::into_inner);
        if logged.get(&invariant).is_none_or(|&before| now.duration_since(before) >= LOG_INTERVAL) {
            logged.insert(invariant, now);
            error!(
                %at, invariant = invariant.word(),
                "invariant violated: {invariant}: {what} (further ones are only counted for a minute)"
            );
        }
    }

    /// Number of violations of an invariant.
    #[must_use]
    pub fn of(&self, invariant: Invariant) -> u64 {
        self.family.with_label_values(&[invariant.word()]).get()
    }
}

impl Collector for Violations {
    fn desc(&self) -> Vec<&Desc> {
        self.family.desc()
    }

    fn collect(&self) -> Vec<MetricFamily> {
        self.family.collect()
    }
}

impl OfFleet for Violations {
    type Family = Self;
    type Shape = ();

    /// Creates the series of all invariants that the supervisor checks.
    fn declare(opts: Opts, (): ()) -> Result<Self> {
        let family = IntCounterVec::new(opts, &["invariant"])?;
        for invariant in Invariant::ALL.iter().filter(|one| one.is_checked_by(Checker::Production)) {
            let _ = family.with_label_values(&[invariant.word()]);
        }
        Ok(Self { family, logged: Arc::default() })
    }

    fn of(family: &Self, _: &str, (): ()) -> Self {
        family.clone()
    }
}
