//! The one-sided rank-sum test (Mann and Whitney 1947): are the values of one group greater than those of another?
//!
//! The groups are robots that a hash has assigned, so without an effect each assignment is equally likely, and the ranks
//! alone give an exact level: no distribution of the errors is assumed, and one absurd error counts as one rank. Ties get
//! the mean of their ranks. Up to [`EXACT_MAX`] values the probability is exact; above, the normal approximation with the
//! correction for ties applies.

use statrs::function::erf::erfc;

/// Most values of both groups together for which all assignments are counted.
pub const EXACT_MAX: usize = 50;

/// Probability that chance alone gives `first` ranks at least as high as the observed ones; 1 without values in a group.
/// Values that are not finite count as the greatest.
#[must_use]
pub fn greater(first: &[f64], second: &[f64]) -> f64 {
    if first.is_empty() || second.is_empty() {
        return 1.0;
    }
    let (doubled, ties) = doubled_ranks(first, second);
    let sum: u64 = doubled[..first.len()].iter().sum();
    if doubled.len() <= EXACT_MAX {
        exact(&doubled, first.len(), sum)
    } else {
        approximate(doubled.len() as f64, first.len() as f64, sum as f64 / 2.0, ties)
    }
}

/// Twice the rank of each value, those of `first` before those of `second`, and the sum of t^3 - t over the sizes t of ties.
fn doubled_ranks(first: &[f64], second: &[f64]) -> (Vec<u64>, f64) {
    let finite = |value: &f64| if value.is_finite() { *value } else { f64::INFINITY };
    let values: Vec<f64> = first.iter().chain(second).map(finite).collect();
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&one, &other| values[one].total_cmp(&values[other]));
    let mut doubled = vec![0; values.len()];
    let mut ties = 0.0;
    let mut begin = 0;
    while begin < order.len() {
        let same = order[begin..].iter().take_while(|&&at| values[at].total_cmp(&values[order[begin]]).is_eq()).count();
        let end = begin + same;
        for &at in &order[begin..end] {
            // Twice the mean of the ranks begin + 1 to end.
            doubled[at] = (begin + 1 + end) as u64;
        }
        ties += (same * same * same - same) as f64;
        begin = end;
    }
    (doubled, ties)
}

/// Counts the assignments of `count` of the values whose ranks have at least this sum. The counts are below 2^53, so they
/// are exact.
fn exact(doubled: &[u64], count: usize, sum: u64) -> f64 {
    let total: u64 = doubled.iter().sum();
    let width = total as usize + 1;
    // ways[k][s]: number of choices of k values with sum s.
    let mut ways = vec![vec![0.0_f64; width]; count + 1];
    ways[0][0] = 1.0;
    for &rank in doubled {
        let rank = rank as usize;
        for k in (1..=count).rev() {
            let (before, after) = ways.split_at_mut(k);
            for (to, from) in after[0][rank..].iter_mut().zip(&before[k - 1]) {
                *to += from;
            }
        }
    }
    let all: f64 = ways[count].iter().sum();
    let extreme: f64 = ways[count][sum as usize..].iter().sum();
    extreme / all
}

/// Normal approximation with corrections for continuity and for ties.
fn approximate(all: f64, count: f64, sum: f64, ties: f64) -> f64 {
    let mean = count * (all + 1.0) / 2.0;
    let variance = count * (all - count) / 12.0 * (all + 1.0 - ties / (all * (all - 1.0)));
    if variance <= 0.0 {
        return 1.0;
    }
    0.5 * erfc((sum - 0.5 - mean) / variance.sqrt() / std::f64::consts::SQRT_2)
}
