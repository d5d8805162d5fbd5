//! Assignment of compensators to broken whiskers with the least total cost.

use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

/// A compensator that could serve a target, and its cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offer {
    /// Row: index of the target.
    pub target: usize,
    /// Column: index of the compensator.
    pub compensator: usize,
    /// Cost, 0 to 1000: predicted error plus the policy's surcharges.
    pub cost: f64,
}

/// Costs are compared in units of 1e-6.
const PER_COST: f64 = 1e6;
/// Cost of an unserved target: more than any set of served targets can save.
const UNSERVED: i64 = 1_000_000_000_000;
/// Cost of a pair without an offer: never chosen while a target may stay unserved.
const IMPOSSIBLE: i64 = 1_000_000_000_000_000;

/// The compensator of each target, if any: as many targets served as possible, then the least total cost
/// (Kuhn-Munkres). A compensator serves at most one target.
#[must_use]
pub fn assign(targets: usize, compensators: usize, offers: &[Offer]) -> Vec<Option<usize>> {
    if targets == 0 {
        return Vec::new();
    }
    // One more column for each target: it stays unserved.
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
