//! The present length from touches at known distances: those that came, those that did not, and those at the tip.
//!
//! A touch at distance d shows that the whisker is at least that long, a missed one that it is shorter, within the
//! error of the distance. The likelihoods of lengths are on a grid: none of them is normal. All distances of a robot
//! may be off by the same amount, so the grid reaches beyond the length before, and an evaluation takes the doubt of
//! that amount into account.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use statrs::function::erf::erfc;

use crate::encoding;

/// Lengths on the grid above the length before: up to 7 mm of 70 mm.
const ABOVE: usize = 28;
/// Lengths on the fine part of the grid: down to 17 mm below the length before, of 70 mm.
const FINE: usize = ABOVE + 69;
/// All lengths. The grid reaches down to 0.29 of the length before.
const LENGTHS: usize = FINE + 44;
/// Fine step of the grid as a part of the length before: 0.25 mm of 70 mm.
const STEP: f64 = 1.0 / 280.0;
/// Coarse step of the grid, in fine ones: 0.75 mm of 70 mm.
const COARSE: usize = 3;
/// Lengths before version 16 of the stored whisker, in steps of two fine ones from the length before on. Their priors
/// were in the sums.
const LENGTHS_BEFORE_16: usize = 100;
/// Probability of a cut, to any length, before any touch.
const CUT: f64 = 0.5;
/// Probability that a robot reports a touch where it could not come, or another distance than the true one.
const WRONG_TOUCH: f64 = 0.02;
/// Probability that a robot expects a touch where nothing was to be touched.
const WRONG_MISS: f64 = 0.05;
/// Least standard deviation of a distance, mm: errors of distances are alike from contact to contact.
const LEAST_SD_MM: f64 = 0.3;
/// Least standard deviation of the error that all distances share, mm: about half a step.
const LEAST_ZERO_SD_MM: f64 = 0.1;

/// Log likelihoods of the lengths on the grid, the largest first.
#[derive(Debug, Clone, PartialEq)]
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
    /// Its standard deviation without the error that all distances share, mm.
    pub sd_mm: f64,
}

/// The length that the distances of a robot give to a whole whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ApparentLength {
    /// Mean of the length, mm.
    pub mean_mm: f64,
    /// Standard deviation, mm.
    pub sd_mm: f64,
}

/// Sums for a mean and its standard deviation.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    all: f64,
    first: f64,
    second: f64,
}

impl Moments {
    fn add(mut self, (length_mm, weight): (f64, f64)) -> Self {
        self.all += weight;
        self.first += weight * length_mm;
        self.second += weight * length_mm * length_mm;
        self
    }

    /// Mean and standard deviation on a grid with this step.
    fn spread(&self, step_mm: f64) -> (f64, f64) {
        let mean = self.first / self.all;
        (mean, ((self.second / self.all - mean * mean).max(0.0) + step_mm.powi(2) / 12.0).sqrt())
    }
}

impl LengthEvidence {
    /// A whisker of this length, mm, that may be cut.
    #[must_use]
    pub fn new(length_mm: f64) -> Self {
        Self { length_mm, log: vec![0.0; LENGTHS] }
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

    /// Each length with its likelihood and the part of the grid that it stands for.
    fn likelihoods(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let one = |(index, log): (usize, &f32)| (at(self.length_mm, index), f64::from(*log).exp(), width(index));
        self.log.iter().enumerate().map(one)
    }

    /// Each length with its weight if the whisker is whole and its distances are off by a common error of this standard
    /// deviation. The weights of the prior sum to one.
    fn whole(&self, zero_sd_mm: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let sd_mm = zero_sd_mm.max(LEAST_ZERO_SD_MM);
        let prior =
            move |length_mm: f64, width: f64| width * (-0.5 * ((length_mm - self.length_mm) / sd_mm).powi(2)).exp();
        let all: f64 = self.likelihoods().map(|(length_mm, _, width)| prior(length_mm, width)).sum();
        self.likelihoods()
            .map(move |(length_mm, likelihood, width)| (length_mm, likelihood * prior(length_mm, width) / all))
    }

    /// The same if the whisker is cut, to any length.
    fn cut(&self, zero_sd_mm: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let sd_mm = zero_sd_mm.max(LEAST_ZERO_SD_MM);
        let prior = move |length_mm: f64, width: f64| width * normal_below((self.length_mm - length_mm) / sd_mm);
        let all: f64 = self.likelihoods().map(|(length_mm, _, width)| prior(length_mm, width)).sum();
        self.likelihoods()
            .map(move |(length_mm, likelihood, width)| (length_mm, likelihood * prior(length_mm, width) / all))
    }

    /// The posterior of the length, from all evidence so far, where all distances are off by a common error of this
    /// standard deviation, mm.
    #[must_use]
    pub fn posterior(&self, zero_sd_mm: f64) -> LengthPosterior {
        let whole: f64 = self.whole(zero_sd_mm).map(|(_, weight)| (1.0 - CUT) * weight).sum();
        let cut = self.cut(zero_sd_mm).fold(Moments::default(), Moments::add);
        let (mean_mm, sd_mm) = cut.spread(STEP * self.length_mm);
        LengthPosterior { unchanged: whole / (whole + CUT * cut.all), mean_mm, sd_mm }
    }

    /// The length that the distances give to this whisker, which is whole. Its difference from the length before is the
    /// shared error. Before, only the standard deviation of that error was known, mm.
    #[must_use]
    pub fn apparent(&self, zero_sd_mm: f64) -> ApparentLength {
        let whole = self.whole(zero_sd_mm).fold(Moments::default(), Moments::add);
        let (mean_mm, sd_mm) = whole.spread(STEP * self.length_mm);
        ApparentLength { mean_mm, sd_mm }
    }

    /// Distances at which further touches tell most about the length, mm, in rising order: evenly by probability,
    /// because a touch at the median of the possible lengths is as likely to come as not. `sd_mm` is the standard
    /// deviation of the robot's distances: a touch so close to the tip of an uncut whisker that it may be missed tells
    /// little.
    #[must_use]
    pub fn informative_mm(&self, count: usize, sd_mm: f64, zero_sd_mm: f64) -> Vec<f64> {
        let most_mm = self.length_mm - 2.0 * sd_mm.max(LEAST_SD_MM);
        let both = self.whole(zero_sd_mm).zip(self.cut(zero_sd_mm));
        let both = both.map(|((length_mm, whole), (_, cut))| (length_mm, (1.0 - CUT) * whole + CUT * cut));
        let mut found = quantiles(both, count);
        found.iter_mut().for_each(|one_mm| *one_mm = one_mm.min(most_mm));
        found
    }

    /// The same for the error that the distances share, on a whole whisker.
    #[must_use]
    pub fn informative_of_zero_mm(&self, count: usize, zero_sd_mm: f64) -> Vec<f64> {
        quantiles(self.whole(zero_sd_mm), count)
    }
}

/// Lengths that divide the weights evenly, in rising order.
fn quantiles(weights: impl Iterator<Item = (f64, f64)>, count: usize) -> Vec<f64> {
    let mut sum = 0.0;
    let add = |(length_mm, weight): (f64, f64)| {
        sum += weight;
        (sum, length_mm)
    };
    let lengths: Vec<(f64, f64)> = weights.map(add).collect();
    let at_share = |share: f64| {
        let index = lengths.partition_point(|&(below, _)| below < share * sum);
        lengths.get(index).or(lengths.last()).map_or(0.0, |&(_, length_mm)| length_mm)
    };
    (0..count).rev().map(|index| at_share((index as f64 + 0.5) / count as f64)).collect()
}

/// Fine steps from the length before down to a length on the grid; below 0 for the lengths above.
fn steps_below(index: usize) -> f64 {
    let steps = if index < FINE { index } else { FINE + COARSE * (index - FINE) };
    steps as f64 - ABOVE as f64
}

fn at(length_mm: f64, index: usize) -> f64 {
    length_mm * (1.0 - STEP * steps_below(index))
}

/// Part of the grid that a length stands for, in fine steps.
fn width(index: usize) -> f64 {
    if index < FINE { 1.0 } else { COARSE as f64 }
}

/// The normal distribution function.
fn normal_below(deviations: f64) -> f64 {
    0.5 * erfc(-deviations / std::f64::consts::SQRT_2)
}

impl BorshSerialize for LengthEvidence {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        (self.length_mm, &self.log).serialize(writer)
    }
}

impl BorshDeserialize for LengthEvidence {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (length_mm, log) = <(f64, Vec<f32>)>::deserialize_reader(reader)?;
        match log.len() {
            LENGTHS => Ok(Self { length_mm, log }),
            LENGTHS_BEFORE_16 => Ok(Self { length_mm, log: of_version_15(&log) }),
            _ => Err(encoding::invalid("evidence of a length on another grid")),
        }
    }
}

/// Likelihoods of a version before 16 on the present grid. It had no lengths above the one before: they get the
/// likelihood of the largest.
fn of_version_15(log: &[f32]) -> Vec<f32> {
    let cut = (CUT / (LENGTHS_BEFORE_16 - 1) as f64).ln() as f32;
    let likelihood = |index: usize| log[index] - if index == 0 { (1.0 - CUT).ln() as f32 } else { cut };
    let of = |index: usize| {
        let step = (steps_below(index).max(0.0) / 2.0).round() as usize;
        likelihood(step.min(LENGTHS_BEFORE_16 - 1))
    };
    (0..LENGTHS).map(of).collect()
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
        let before = evidence.posterior(0.0);
        assert!(before.unchanged > 0.4, "{before:?}");
        for distance_mm in [64.5, 65.0, 66.0, 67.0, 68.0, 69.0] {
            evidence.missed(distance_mm, 0.5);
        }
        let after = evidence.posterior(0.0);
        assert!(after.unchanged < 1e-5 && (after.mean_mm - 64.0).abs() < 0.7 && after.sd_mm < 0.7, "{after:?}");
    }

    #[test]
    fn a_single_wrong_report_proves_nothing() {
        let mut evidence = LengthEvidence::new(70.0);
        evidence.missed(55.0, 0.5);
        (0..3).for_each(|_| evidence.touched(69.0, 0.5));
        assert!(evidence.posterior(0.0).unchanged > 0.9, "{:?}", evidence.posterior(0.0));
    }

    #[test]
    fn contacts_at_the_tip_measure_the_length() {
        let mut evidence = LengthEvidence::new(70.0);
        for off_mm in [-1.0, 0.4, 0.8, -0.3] {
            evidence.tip(65.0 + off_mm, 1.0);
        }
        let posterior = evidence.posterior(0.0);
        assert!(posterior.unchanged < 1e-4 && (posterior.mean_mm - 65.0).abs() < 0.3, "{posterior:?}");
        assert!((posterior.sd_mm - 0.5).abs() < 0.1, "{posterior:?}");
    }

    #[test]
    fn informative_distances_lie_where_the_tip_may_be() {
        let mut evidence = LengthEvidence::new(70.0);
        let first = evidence.informative_mm(10, 0.5, 0.0);
        assert!(first.is_sorted() && first[0] < 40.0 && first[9] == 69.0, "{first:?}");
        (0..3).for_each(|_| evidence.touched(62.0, 0.5));
        (0..5).for_each(|_| evidence.missed(66.0, 0.5));
        let next = evidence.informative_mm(10, 0.5, 0.0);
        assert!(next.iter().all(|mm| (61.0..=67.0).contains(mm)), "{next:?}");
    }

    /// Distances that are all 3 mm short look like a cut by 3 mm, unless the robot's error is known better.
    #[test]
    fn an_error_that_all_distances_share_explains_a_small_cut_and_is_learned() {
        let mut evidence = LengthEvidence::new(70.0);
        for turn in 0..10 {
            evidence.tip(67.0 + 0.1 * f64::from(turn % 3), 0.5);
        }
        assert!(evidence.posterior(1.5).unchanged > 0.3 && evidence.posterior(0.3).unchanged < 1e-6);
        let apparent = evidence.apparent(1.5);
        assert!((apparent.mean_mm - 67.1).abs() < 0.1 && apparent.sd_mm < 0.2, "{apparent:?}");
    }

    #[test]
    fn distances_that_tell_of_the_error_lie_around_the_tip() {
        let evidence = LengthEvidence::new(70.0);
        let first = evidence.informative_of_zero_mm(10, 1.5);
        assert!(first.is_sorted() && first[0] < 68.0 && first[9] > 72.0, "{first:?}");
    }

    #[test]
    fn evidence_of_an_older_grid_means_the_same() {
        let mut log = vec![(0.5_f32 / 99.0).ln(); LENGTHS_BEFORE_16];
        log[0] = 0.5_f32.ln();
        log[1..=9].iter_mut().for_each(|one| *one -= 20.0);
        log[11..].iter_mut().for_each(|one| *one -= 20.0);
        log[0] -= 20.0;
        let bytes = borsh::to_vec(&(70.0_f64, log)).unwrap();
        let posterior = LengthEvidence::try_from_slice(&bytes).unwrap().posterior(0.0);
        assert!(posterior.unchanged < 1e-5 && (posterior.mean_mm - 65.0).abs() < 0.2, "{posterior:?}");
    }
}
