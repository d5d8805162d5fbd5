//! What many runs have covered.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use crate::plan::{Kind, Plan};
use crate::world::Outcome;

/// Sums over runs.
#[derive(Debug, Default, Clone)]
pub struct Statistics {
    /// Number of runs.
    pub runs: u64,
    /// Simulated time.
    pub simulated: Duration,
    /// Faults that began, by kind.
    pub faults: BTreeMap<Kind, u64>,
    /// Contacts that robots made, setpoints that were decided, trims that were found.
    pub counts: [u64; 3],
    /// Events that receivers of webhooks have taken.
    pub delivered: u64,
    /// Raised alarms by kind.
    pub alarms: BTreeMap<String, u64>,
    /// Longest time from the end of a run's faults until all was settled.
    pub settled_after: Duration,
    /// Pairs of faults of which the second began during the first.
    pub pairs: BTreeSet<(Kind, Kind)>,
    /// Sets of faults that were under way at the same time.
    pub sets: BTreeSet<BTreeSet<Kind>>,
    /// Messages and faults in the histories.
    pub steps: u64,
}

impl Statistics {
    /// Adds a run.
    pub fn add(&mut self, plan: &Plan, outcome: &Outcome) {
        self.runs += 1;
        self.simulated += outcome.simulated;
        self.steps += outcome.steps_in_all;
        for (sum, count) in self.counts.iter_mut().zip(outcome.counts) {
            *sum += count;
        }
        self.delivered += outcome.delivered;
        self.settled_after = self.settled_after.max(outcome.settled_after);
        for (kind, count) in &outcome.alarms {
            *self.alarms.entry(kind.clone()).or_default() += count;
        }
        let mut under_way: Vec<(Duration, Kind)> = Vec::new();
        for strike in plan.strikes.iter().filter(|strike| strike.at <= outcome.simulated) {
            under_way.retain(|(end, _)| *end > strike.at);
            *self.faults.entry(strike.kind).or_default() += 1;
            self.pairs.extend(under_way.iter().map(|(_, first)| (*first, strike.kind)));
            under_way.push((strike.at + strike.lasts, strike.kind));
            self.sets.insert(under_way.iter().map(|(_, kind)| *kind).collect());
        }
    }

    /// Number of faults.
    #[must_use]
    pub fn faults_in_all(&self) -> u64 {
        self.faults.values().sum()
    }
}
