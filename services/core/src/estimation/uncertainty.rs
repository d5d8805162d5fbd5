//! Uncertainty of Eq. 35, from the uncertainty of its responses.
//!
//! Eq. 35 divides small differences and takes absolute values, so derivatives do not give its spread: near a
//! perfect match the error can only be larger than it seems. Instead a fixed, evenly spread set of equally likely
//! cases is evaluated: no randomness, and the same answer every time.

use super::cubature::{self, CASES};
use super::exponential::exp;
use crate::mechanics::{CONTACT_RATIOS, ErrorProfile, RatioWeights};

/// A value at each of [`CONTACT_RATIOS`].
pub type Curve = [f64; CONTACT_RATIOS.len()];

/// Curve without any effect.
const STILL: Curve = [0.0; CONTACT_RATIOS.len()];

/// `N` responses as ln s by contact ratio. Each is the sum of a mean and of the effects of independent standard
/// normal variables (causes). One cause may affect several responses.
#[derive(Debug, Clone)]
pub struct Uncertain<const N: usize> {
    /// Mean responses.
    pub mean: [Curve; N],
    /// Effects of one standard deviation of each cause on the responses.
    pub causes: Vec<[Curve; N]>,
}

impl<const N: usize> Uncertain<N> {
    /// Adds causes that have the same effect on all responses in `to`.
    pub fn moves(&mut self, curves: &[Curve], to: &[usize]) {
        for curve in curves {
            let mut cause = [STILL; N];
            for &response in to {
                cause[response] = *curve;
            }
            self.causes.push(cause);
        }
    }

    /// Evaluates `of` on each of the equally likely cases.
    pub fn cases<T>(&self, of: impl FnMut(&[Curve; N]) -> T) -> Vec<T> {
        self.some_cases(CASES, of)
    }

    /// Evaluates `of` on the first `count` cases. With fewer than about forty, [`interval95`] spans the extremes.
    pub fn some_cases<T>(&self, count: u32, mut of: impl FnMut(&[Curve; N]) -> T) -> Vec<T> {
        let causes = self.causes.len();
        let amounts = cubature::amounts(causes, count);
        let moving: [Vec<(usize, Curve)>; N] = std::array::from_fn(|response| {
            let curves = self.causes.iter().map(|cause| cause[response]).enumerate();
            curves.filter(|(_, curve)| *curve != STILL).collect()
        });
        let one = |case: usize| {
            let amounts = &amounts[causes * case..causes * (case + 1)];
            let mut responses = self.mean;
            for (response, moving) in responses.iter_mut().zip(&moving) {
                // Summed in a local, so that the compiler need not write memory in the loop.
                let mut sum = *response;
                for (cause, curve) in moving {
                    let amount = amounts[*cause];
                    sum.iter_mut().zip(curve).for_each(|(value, added)| *value += amount * added);
                }
                *response = sum;
            }
            of(&responses)
        };
        (0..count as usize).map(one).collect()
    }
}

/// Mean of Eq. 35 from ln s after and before, and of the target, over the contact ratios by their weights.
#[must_use]
pub fn mean_error(after: &Curve, before: &Curve, target: &Curve, weights: &RatioWeights) -> f64 {
    let against_target = |logs: &Curve| exp(&std::array::from_fn(|k| logs[k] - target[k]));
    ErrorProfile::mean_against_target(&against_target(after), &against_target(before), weights)
}

/// Mean and standard deviation of the values.
#[must_use]
pub fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// Central 95 % of the values.
#[must_use]
pub fn interval95(mut values: Vec<f64>) -> (f64, f64) {
    let last = values.len() - 1;
    let mut at = |share: f64| *values.select_nth_unstable_by((last as f64 * share).round() as usize, f64::total_cmp).1;
    (at(0.025), at(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::EVEN_WEIGHTS;

    #[test]
    fn cases_have_the_stated_moments_and_correlations() {
        let flat = |value: f64| [value; CONTACT_RATIOS.len()];
        let mut one = Uncertain { mean: [flat(1.0), flat(2.0)], causes: Vec::new() };
        one.moves(&[flat(0.3)], &[0, 1]);
        one.moves(&[flat(0.4), flat(0.0)], &[1]);
        let cases = one.cases(|[a, b]| (a[3], b[7]));
        let (mean_a, sd_a) = moments(&cases.iter().map(|case| case.0).collect::<Vec<_>>());
        let (mean_b, sd_b) = moments(&cases.iter().map(|case| case.1).collect::<Vec<_>>());
        let together = cases.iter().map(|case| (case.0 - mean_a) * (case.1 - mean_b)).sum::<f64>() / cases.len() as f64;
        assert!((mean_a - 1.0).abs() < 0.01 && (sd_a - 0.3).abs() < 0.01, "{mean_a} {sd_a}");
        assert!((mean_b - 2.0).abs() < 0.02 && (sd_b - 0.5).abs() < 0.02, "{mean_b} {sd_b}");
        assert!((together - 0.09).abs() < 0.01, "{together}");
        let (low, high) = interval95(cases.iter().map(|case| case.0).collect());
        assert!((low - 1.0 + 1.96 * 0.3).abs() < 0.03 && (high - 1.0 - 1.96 * 0.3).abs() < 0.03, "{low} {high}");
    }

    #[test]
    fn a_perfect_match_that_is_uncertain_has_an_error() {
        let flat = |value: f64| [value; CONTACT_RATIOS.len()];
        let mut one = Uncertain { mean: [flat(0.0), flat(0.2), flat(0.0)], causes: Vec::new() };
        assert_eq!(mean_error(&one.mean[0], &one.mean[1], &one.mean[2], &EVEN_WEIGHTS), 0.0);
        one.moves(&[flat(0.02)], &[0]);
        let cases = one.cases(|[after, before, target]| mean_error(after, before, target, &EVEN_WEIGHTS));
        let (mean, _) = moments(&cases);
        assert!((mean - 0.8 * 0.02 / (0.2_f64.exp() - 1.0)).abs() < 0.01, "{mean}");
    }
}
