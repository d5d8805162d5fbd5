//! The assignment of compensators to broken whiskers with the least total cost.

use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

/// A compensator that could serve a target, and what that costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offer {
    /// Row: which of the targets.
    pub target: usize,
    /// Column: which of the compensators.
    pub compensator: usize,
    /// Cost, 0 to 1000; predicted error plus what the policy adds.
    pub cost: f64,
}

/// Costs are compared in millionths.
const PER_COST: f64 = 1e6;
/// A target that nobody serves costs more than any set of served ones saves.
const UNSERVED: i64 = 1_000_000_000_000;
/// No offer at all: never chosen while a target may stay unserved.
const IMPOSSIBLE: i64 = 1_000_000_000_000_000;

/// For each target the compensator that serves it, if any: as many served as possible, then the least total
/// cost (Kuhn-Munkres). Every compensator serves at most one target.
#[must_use]
pub fn assign(targets: usize, compensators: usize, offers: &[Offer]) -> Vec<Option<usize>> {
    if targets == 0 {
        return Vec::new();
    }
    // One column more for each target: staying unserved.
    let mut costs = Matrix::new(targets, compensators + targets, IMPOSSIBLE);
    for target in 0..targets {
        costs[(target, compensators + target)] = UNSERVED;
    }
    for offer in offers {
        costs[(offer.target, offer.compensator)] = (offer.cost.clamp(0.0, 1000.0) * PER_COST) as i64;
    }
    let (_, columns) = kuhn_munkres_min(&costs);
    columns.into_iter().map(|column| (column < compensators).then_some(column)).collect()
}
