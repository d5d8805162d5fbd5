//! Metrics by node of the broker. Nodes are addresses in the configuration, so the number of series is limited.

use std::sync::Arc;

use prometheus::core::Collector as _;
use prometheus::proto::LabelPair;
use prometheus::{IntCounterVec, IntGaugeVec, Opts, Result};

use super::kinds::{FLEET, OfFleet, Word};

/// Label of a fleet's connection.
const CONNECTION: &str = "connection";
/// Label of a node's address.
const NODE: &str = "node";

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

    /// Removes the nodes of a connection that is down.
    pub fn forget(&self, connection: Word) {
        for family in self.family.collect() {
            for series in family.get_metric() {
                let value =
                    |label: &str| series.get_label().iter().find(|pair| pair.name() == label).map(LabelPair::value);
                if let (Some(fleet), Some(of), Some(node)) = (value(FLEET), value(CONNECTION), value(NODE))
                    && (fleet, of) == (&*self.fleet, connection)
                {
                    // Another thread may have removed it meanwhile.
                    let _ = self.family.remove_label_values(&[fleet, of, node]);
                }
            }
        }
    }
}

impl OfFleet for NodeInUse {
    type Family = IntGaugeVec;
    type Shape = ();

    fn declare(opts: Opts, (): ()) -> Result<IntGaugeVec> {
        IntGaugeVec::new(opts, &[FLEET, CONNECTION, NODE])
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
        IntCounterVec::new(opts, &[FLEET, NODE])
    }

    fn of(family: &IntCounterVec, fleet: &str, (): ()) -> Self {
        Self { family: family.clone(), fleet: fleet.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The series of a former node stayed at 1: a series cannot be removed by some of its labels.
    #[test]
    fn regress_only_the_node_in_use_has_a_series() {
        let family = NodeInUse::declare(Opts::new("node_in_use", "help"), ()).unwrap();
        let (hall, yard) = (NodeInUse::of(&family, "hall", ()), NodeInUse::of(&family, "yard", ()));
        let series = || {
            let all = family.collect().remove(0);
            let words = |labels: &[LabelPair]| labels.iter().map(|pair| pair.value().to_owned()).collect::<Vec<_>>();
            let mut series: Vec<_> = all.get_metric().iter().map(|one| words(one.get_label()).join(" ")).collect();
            series.sort();
            series
        };
        hall.set("receiving", "a:1883");
        hall.set("publishing", "a:1883");
        yard.set("receiving", "a:1883");
        hall.set("receiving", "b:1883");
        // Labels are in the order of their names: connection, fleet, node.
        assert_eq!(series(), ["publishing hall a:1883", "receiving hall b:1883", "receiving yard a:1883"]);
        hall.forget("receiving");
        assert_eq!(series(), ["publishing hall a:1883", "receiving yard a:1883"]);
    }
}
