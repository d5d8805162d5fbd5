//! The order in which a connection tries the nodes of the broker, and its pauses.
//!
//! The connections of a fleet share their experience: a node that has failed is tried later than the others, and one that
//! has not even answered is tried last. So a dead node costs its time limit once, and not at each reconnection. A
//! connection pauses only after a round in which every node has failed.

use std::time::Duration;

use super::Connection;
use super::address::Node;
use super::link::{Backoff, BrokerLink};
use super::problem::Problem;

/// Longest pause between two rounds of several nodes, which share the attempts. A cluster that elects a leader refuses
/// clients for some seconds.
const ROUND_PAUSE_MAX: Duration = Duration::from_secs(2);

/// The attempts of one connection.
#[derive(Debug)]
pub(super) struct Attempts {
    backoff: Backoff,
    /// Nodes that have failed since the last success or pause.
    failed: Vec<Node>,
}

impl Attempts {
    pub(super) fn new() -> Self {
        Self { backoff: Backoff::new(), failed: Vec::new() }
    }

    /// The connection to the node that is to be tried first, with fresh secrets.
    pub(super) fn first(connection: &Connection) -> Connection {
        let renewed = connection.with_secrets_read_again();
        let node = next(&renewed, &[]);
        renewed.at(&node)
    }

    /// Starts a new round with the shortest pause, after a success.
    pub(super) fn reset(&mut self) {
        self.backoff.reset();
        self.failed.clear();
    }

    /// Notes that the connection has failed with this problem. Returns the connection to the next node, with fresh secrets; after the last
    /// node of a round only after a pause.
    pub(super) async fn next(&mut self, connection: &Connection, problem: &Problem) -> Connection {
        let node = connection.broker.node();
        connection.link.node_failed(node.clone(), problem.is_slow());
        if self.is_round_over(node, connection.broker.others.len() + 1) {
            let pause = self.backoff.pause();
            let is_cluster = !connection.broker.others.is_empty();
            tokio::time::sleep(if is_cluster { pause.min(ROUND_PAUSE_MAX) } else { pause }).await;
        }
        let renewed = connection.with_secrets_read_again();
        let node = next(&renewed, &self.failed);
        renewed.at(&node)
    }

    /// Notes a failed node; true if every node has failed now, which begins a new round.
    fn is_round_over(&mut self, node: Node, nodes: usize) -> bool {
        if !self.failed.contains(&node) {
            self.failed.push(node);
        }
        let is_over = self.failed.len() >= nodes;
        if is_over {
            self.failed.clear();
        }
        is_over
    }
}

fn next(connection: &Connection, failed: &[Node]) -> Node {
    let left = connection.broker.nodes().into_iter().filter(|node| !failed.contains(node)).collect();
    best(&connection.link, left).unwrap_or_else(|| connection.broker.node())
}

/// The best of these nodes: one that has not failed since it last worked, otherwise one that failed quickly, and of these
/// the one with the oldest failure; of equal ones the first.
fn best(link: &BrokerLink, nodes: Vec<Node>) -> Option<Node> {
    // The order puts `None` before each time.
    nodes.into_iter().min_by_key(|node| link.failure_of(node))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mqtt::link::Side;

    fn nodes() -> Vec<Node> {
        ["a", "b", "c"].map(|host| Node { host: host.to_owned(), port: 1883 }).to_vec()
    }

    #[test]
    fn a_node_that_failed_is_tried_later_and_one_that_did_not_answer_last() {
        let (link, nodes) = (BrokerLink::default(), nodes());
        let first = |link: &BrokerLink| best(link, nodes.clone()).unwrap().host;
        let fails = |at: usize, is_slow| {
            link.node_failed(nodes[at].clone(), is_slow);
            vibrissa_host::task::block_for(std::time::Duration::from_millis(2));
        };
        assert_eq!(first(&link), "a");
        fails(0, true);
        assert_eq!(first(&link), "b");
        fails(1, false);
        assert_eq!(first(&link), "c");
        fails(2, false);
        assert_eq!(first(&link), "b", "its failure is the oldest quick one");
        fails(1, false);
        assert_eq!(first(&link), "c");
        link.connected(Side::Receiving, &nodes[0]);
        assert_eq!(first(&link), "a", "it works again");
    }

    #[test]
    fn a_round_is_over_when_each_node_has_failed_once() {
        let mut attempts = Attempts::new();
        let rounds = nodes().into_iter().cycle().take(7).map(|node| attempts.is_round_over(node, 3));
        assert_eq!(rounds.collect::<Vec<_>>(), [false, false, true, false, false, true, false]);
        attempts.reset();
        let same = |attempts: &mut Attempts| attempts.is_round_over(nodes().remove(0), 3);
        assert!(!same(&mut attempts) && !same(&mut attempts), "a node counts once");
        assert!(attempts.is_round_over(nodes().remove(0), 1), "a single node is a whole round");
    }
}
