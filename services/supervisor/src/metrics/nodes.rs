//! Metrics by node of the broker. Nodes are addresses in the configuration, so the number of series is limited.

use std::collections::HashMap;
use std::sync::Arc;

use prometheus::{IntCounterVec, IntGaugeVec, Opts, Result};

use super::kinds::{FLEET, OfFleet, Word};

/// The nodes that a fleet's connections use: 1 for the node in use, and no series for a connection that is down.
#[derive(Debug, Clone)]
pub struct NodeInUse {
    family: IntGaugeVec,
    fleet: Arc<str>,
}

impl NodeInUse {
    /// Sets the node of a connection.
    pub fn set(&self, connection: Word, node: &str) {
        self.forget(connection);
        self.family.with_label_values(&[&self.fleet, connection, node]).set(1);
    }

    /// Removes the node of a connection that is down.
    pub fn forget(&self, connection: Word) {
        let labels = HashMap::from([(FLEET, &*self.fleet), ("connection", connection)]);
        // There may be none.
        let _ = self.family.remove(&labels);
    }
}

impl OfFleet for NodeInUse {
    type Family = IntGaugeVec;
    type Shape = ();

    fn declare(opts: Opts, (): ()) -> Result<IntGaugeVec> {
        IntGaugeVec::new(opts, &[FLEET, "connection", "node"])
    }

    fn of(family: &IntGaugeVec, fleet: &str, (): ()) -> Self {
        Self { family: family.clone(), fleet: fleet.into() }
    }
}

/// Broken connections, and failed attempts to connect, of a fleet by node.
#[derive(Debug, Clone)]
pub struct NodeFailures {
    family: IntCounterVec,
    fleet: Arc<str>,
}

impl NodeFailures {
    /// Creates the series of a node, so that it is 0 before the first failure.
    pub fn know(&self, node: &str) {
        let _ = self.family.with_label_values(&[&self.fleet, node]);
    }

    /// Number of failures of a node.
    #[must_use]
    pub fn of(&self, node: &str) -> u64 {
        self.family.with_label_values(&[&self.fleet, node]).get()
    }

    /// Counts a failure of a node.
    pub fn count(&self, node: &str) {
        self.family.with_label_values(&[&self.fleet, node]).inc();
    }
}

impl OfFleet for NodeFailures {
    type Family = IntCounterVec;
    type Shape = ();

    fn declare(opts: Opts, (): ()) -> Result<IntCounterVec> {
        IntCounterVec::new(opts, &[FLEET, "node"])
    }

    fn of(family: &IntCounterVec, fleet: &str, (): ()) -> Self {
        Self { family: family.clone(), fleet: fleet.into() }
    }
}
