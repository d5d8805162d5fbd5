//! The oracle: a CUSUM that knows the size of the cut, the whisker's true curve and its noise. The core, which knows
//! none of them, is compared with it.

use nalgebra::{DMatrix, DVector};
use statrs::function::erf::erfc;

/// Number of states of the Markov chain that approximates the CUSUM's continuous value.
const STATES: usize = 120;

/// Threshold of the CUSUM of log likelihood ratios for a mean number of contacts between false alarms.
///
/// The shifts are those of equally likely contact ratios, in standard deviations, and none is 0. The CUSUM's value is
/// divided into states (Brook and Evans, Biometrika 59 (1972) 539) and the linear system is solved for the mean run
/// length; the threshold is found by bisection.
#[must_use]
pub fn threshold(shifts: &[f64], contacts_between_false_alarms: f64) -> f64 {
    // The mean run length is at least exp(threshold), so the threshold is at most the logarithm. 2 is a reserve for the
    // error of the approximation.
    let (mut low, mut high) = (0.0, contacts_between_false_alarms.ln() + 2.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if mean_run_length(shifts, middle) < contacts_between_false_alarms {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Mean number of contacts from zero to an alarm while nothing changes.
#[must_use]
pub fn mean_run_length(shifts: &[f64], threshold: f64) -> f64 {
    // State 0 is exactly zero; the others are cells of equal width.
    let width = threshold / (STATES as f64 - 0.5);
    // Probability that a contact raises the value by at most `limit`.
    let below = |limit: f64| {
        let one = |&shift: &f64| normal_cdf((limit + 0.5 * shift * shift) / shift.abs());
        shifts.iter().map(one).sum::<f64>() / shifts.len() as f64
    };
    // Differences between states are multiples of the width, so each probability is computed once.
    let cdf: Vec<f64> = (0..2 * STATES).map(|k| below((k as f64 - STATES as f64 + 0.5) * width)).collect();
    let at = |to: usize, from: usize| cdf[to + STATES - from];
    let stay = DMatrix::from_fn(STATES, STATES, |from, to| {
        let upto = at(to, from);
        if to == 0 { upto } else { upto - cdf[to + STATES - from - 1] }
    });
    let system = DMatrix::identity(STATES, STATES) - stay;
    system.lu().solve(&DVector::from_element(STATES, 1.0)).map_or(f64::INFINITY, |lengths| lengths[0])
}

fn normal_cdf(value: f64) -> f64 {
    0.5 * erfc(-value / std::f64::consts::SQRT_2)
}

/// State of the CUSUM.
#[derive(Debug, Clone, Copy, Default)]
pub struct Oracle {
    value: f64,
}

impl Oracle {
    /// Updates with one contact: its deviation from the whole whisker's truth, and the shift, both in standard
    /// deviations. Returns true at the alarm.
    pub fn update(&mut self, deviation: f64, shift: f64, threshold: f64) -> bool {
        self.value = (self.value + shift * deviation - 0.5 * shift * shift).max(0.0);
        self.value >= threshold
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Siegmund's approximation, (exp(b) - b - 1) / (shift^2 / 2) with b = threshold + 1.166 shift.
    #[test]
    fn property_the_run_length_agrees_with_siegmund() {
        for shift in [0.3, 0.6, 1.2] {
            let threshold = threshold(&[shift], 1e5);
            let b = threshold + 1.166 * shift;
            let siegmund = (b.exp() - b - 1.0) / (0.5 * shift * shift);
            assert!((siegmund / 1e5 - 1.0).abs() < 0.05, "{shift}: {threshold} {siegmund}");
        }
    }
}
