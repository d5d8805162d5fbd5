//! Counts of the hostile robots' messages.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::behaviour::Behaviour;

/// Counts of messages and connections by behaviour.
#[derive(Debug)]
pub struct Tally {
    counts: Vec<(Behaviour, AtomicU64)>,
    setpoints: AtomicU64,
}

impl Tally {
    /// Starts with all counts at zero.
    pub fn new(behaviours: &[Behaviour]) -> Self {
        Self { counts: behaviours.iter().map(|&one| (one, AtomicU64::new(0))).collect(), setpoints: AtomicU64::new(0) }
    }

    /// Counts a setpoint that the supervisor sent to a hostile robot.
    pub fn count_setpoint(&self) {
        self.setpoints.fetch_add(1, Ordering::Relaxed);
    }

    /// Number of setpoints that hostile robots received, repetitions included.
    pub fn setpoints(&self) -> u64 {
        self.setpoints.load(Ordering::Relaxed)
    }

    /// Counts one message or connection.
    pub fn count(&self, behaviour: Behaviour) {
        if let Some((_, count)) = self.counts.iter().find(|(one, _)| *one == behaviour) {
            count.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Messages and connections so far, by name of the behaviour.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        self.counts.iter().map(|(one, count)| (one.name(), count.load(Ordering::Relaxed))).collect()
    }
}
