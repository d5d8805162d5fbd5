//! The present length from touches at known distances: those that came, those that did not, and those at the tip.
//!
//! A touch at distance d shows that the whisker is at least that long, a missed one that it is shorter, within the error
//! of the distance. The posterior is a list of likelihoods of lengths on a grid: none of them is normal.

use borsh::{BorshDeserialize, BorshSerialize};
use statrs::function::erf::erfc;

/// Number of lengths on the grid.
const LENGTHS: usize = 100;
/// Step of the grid as a part of the length before: 0.5 mm of 70 mm. The grid reaches down to 0.29 of the length.
const STEP: f64 = 1.0 / 140.0;
/// Probability that a robot reports a touch where it could not come, or another distance than the true one.
const WRONG_TOUCH: f64 = 0.02;
/// Probability that a robot expects a touch where nothing was to be touched.
const WRONG_MISS: f64 = 0.05;
/// Least standard deviation of a distance, mm: errors of distances are alike from contact to contact.
const LEAST_SD_MM: f64 = 0.3;

/// Log likelihoods of the lengths, the first for the length before.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct LengthEvidence {
    length_mm: f64,
    log: Vec<f32>,
}

/// The posterior of a length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthPosterior {
    /// Probability that the whisker is as long as before.
    pub unchanged: f64,
    /// Mean of the length if it has changed, mm.
    pub mean_mm: f64,
    /// Its standard deviation, mm.
    pub sd_mm: f64,
}

impl LengthEvidence {
    /// A whisker of this length, mm, is cut with a probability of a half, to any length.
    #[must_use]
    pub fn new(length_mm: f64) -> Self {
        let mut log = vec![(0.5 / (LENGTHS - 1) as f32).ln(); LENGTHS];
        log[0] = 0.5_f32.ln();
        Self { length_mm, log }
    }

    /// Length before, mm.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        self.length_mm
    }

    /// A touch came at this distance from the base.
    pub fn touched(&mut self, distance_mm: f64, sd_mm: f64) {
        self.add(sd_mm, |sd_mm, length_mm| {
            WRONG_TOUCH + (1.0 - WRONG_TOUCH) * normal_below((length_mm - distance_mm) / sd_mm)
        });
    }

    /// A touch was expected at this distance and did not come.
    pub fn missed(&mut self, distance_mm: f64, sd_mm: f64) {
        self.add(sd_mm, |sd_mm, length_mm| {
            WRONG_MISS + (1.0 - WRONG_MISS) * normal_below((distance_mm - length_mm) / sd_mm)
        });
    }

    /// The tip was touched at this distance.
    pub fn tip(&mut self, distance_mm: f64, sd_mm: f64) {
        let anywhere = 1.0 / self.length_mm;
        self.add(sd_mm, |sd_mm, length_mm| {
            let off = (length_mm - distance_mm) / sd_mm;
            let density = (-0.5 * off * off).exp() / (sd_mm * std::f64::consts::TAU.sqrt());
            WRONG_TOUCH * anywhere + (1.0 - WRONG_TOUCH) * density
        });
    }

    /// Lengths below this, mm, are unlikely: contacts came beyond them lately.
    pub fn hardly_below(&mut self, shortest_mm: f64) {
        self.add(LEAST_SD_MM, |sd_mm, length_mm| {
            WRONG_MISS + (1.0 - WRONG_MISS) * normal_below((length_mm - shortest_mm) / sd_mm)
        });
    }

    fn add(&mut self, sd_mm: f64, likelihood: impl Fn(f64, f64) -> f64) {
        let (sd_mm, length_mm) = (sd_mm.max(LEAST_SD_MM), self.length_mm);
        for (index, log) in self.log.iter_mut().enumerate() {
            *log += likelihood(sd_mm, at(length_mm, index)).ln() as f32;
        }
        // Only differences count. With the largest at 0 the sums stay small.
        let most = self.log.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        self.log.iter_mut().for_each(|log| *log -= most);
    }

    fn weights(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.log.iter().enumerate().map(|(index, log)| (at(self.length_mm, index), f64::from(*log).exp()))
    }

    /// The posterior of the length, from all evidence so far.
    #[must_use]
    pub fn posterior(&self) -> LengthPosterior {
        let unchanged = self.weights().next().map_or(0.0, |(_, weight)| weight);
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        for (length_mm, weight) in self.weights().skip(1) {
            sum += weight;
            first += weight * length_mm;
            second += weight * length_mm * length_mm;
        }
        // The weights of changed lengths can be too small for a sum while nothing has changed.
        let sum = sum.max(f64::MIN_POSITIVE);
        let mean_mm = first / sum;
        let within_step = (STEP * self.length_mm).powi(2) / 12.0;
        let sd_mm = ((second / sum - mean_mm * mean_mm).max(0.0) + within_step).sqrt();
        LengthPosterior { unchanged: unchanged / (unchanged + sum), mean_mm, sd_mm }
    }

    /// Distances at which further touches tell most about the length, mm, in rising order: evenly by probability,
    /// because a touch at the median of the possible lengths is as likely to come as not. `sd_mm` is the standard deviation
    /// of the robot's distances: a touch so close to the tip of an uncut whisker that it may be missed tells little.
    #[must_use]
    pub fn informative_mm(&self, count: usize, sd_mm: f64) -> Vec<f64> {
        let most_mm = self.length_mm - 2.0 * sd_mm.max(LEAST_SD_MM);
        let all: f64 = self.weights().map(|(_, weight)| weight).sum();
        let mut sum = 0.0;
        let mut lengths: Vec<(f64, f64)> = self
            .weights()
            .map(|(length_mm, weight)| {
                sum += weight / all;
                (sum, length_mm)
            })
            .collect();
        lengths.dedup_by(|later, before| later.0 <= before.0);
        let at_share = |share: f64| {
            let index = lengths.partition_point(|&(below, _)| below < share);
            lengths.get(index).or(lengths.last()).map_or(most_mm, |&(_, length_mm)| length_mm.min(most_mm))
        };
        (0..count).rev().map(|index| at_share((index as f64 + 0.5) / count as f64)).collect()
    }
}

fn at(length_mm: f64, index: usize) -> f64 {
    length_mm * (1.0 - STEP * index as f64)
}

/// The normal distribution function.
fn normal_below(deviations: f64) -> f64 {
    0.5 * erfc(-deviations / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touches_below_and_misses_above_enclose_the_length() {
        let mut evidence = LengthEvidence::new(70.0);
        for distance_mm in [50.0, 56.0, 60.0, 62.0, 63.5] {
            evidence.touched(distance_mm, 0.5);
        }
        let before = evidence.posterior();
        assert!(before.unchanged > 0.4, "{before:?}");
        for distance_mm in [64.5, 65.0, 66.0, 67.0, 68.0, 69.0] {
            evidence.missed(distance_mm, 0.5);
        }
        let after = evidence.posterior();
        assert!(after.unchanged < 1e-5 && (after.mean_mm - 64.0).abs() < 0.7 && after.sd_mm < 0.7, "{after:?}");
    }

    #[test]
    fn a_single_wrong_report_proves_nothing() {
        let mut evidence = LengthEvidence::new(70.0);
        evidence.missed(55.0, 0.5);
        (0..3).for_each(|_| evidence.touched(69.0, 0.5));
        assert!(evidence.posterior().unchanged > 0.9, "{:?}", evidence.posterior());
    }

    #[test]
    fn contacts_at_the_tip_measure_the_length() {
        let mut evidence = LengthEvidence::new(70.0);
        for off_mm in [-1.0, 0.4, 0.8, -0.3] {
            evidence.tip(65.0 + off_mm, 1.0);
        }
        let posterior = evidence.posterior();
        assert!(posterior.unchanged < 1e-4 && (posterior.mean_mm - 65.0).abs() < 0.3, "{posterior:?}");
        assert!((posterior.sd_mm - 0.5).abs() < 0.1, "{posterior:?}");
    }

    #[test]
    fn informative_distances_lie_where_the_tip_may_be() {
        let mut evidence = LengthEvidence::new(70.0);
        let first = evidence.informative_mm(10, 0.5);
        assert!(first.is_sorted() && first[0] < 40.0 && first[9] == 69.0, "{first:?}");
        (0..3).for_each(|_| evidence.touched(62.0, 0.5));
        (0..5).for_each(|_| evidence.missed(66.0, 0.5));
        let next = evidence.informative_mm(10, 0.5);
        assert!(next.iter().all(|mm| (61.0..=67.0).contains(mm)), "{next:?}");
    }
}
