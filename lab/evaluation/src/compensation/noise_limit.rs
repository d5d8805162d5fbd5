//! The error that the noise of contacts leaves: a limit for everything that learns the gain from them.

use statrs::distribution::{ContinuousCDF, Normal};
use vibrissa_core::mechanics::{ByRatio, CONTACT_RATIOS};
use vibrissa_simulator::scenario::Noise;

use super::{Case, START_MPA, Truth, WHOLE_CONTACTS};

/// Steps in the search for the best pressure: 1 kPa each over 0.2 MPa.
const STEPS: u32 = 200;
/// Equally likely values of the noise in a mean.
const QUANTILES: u32 = 41;

/// Mean of eq. 35 on a plant that is known but for its level: with the pressure whose shape is best (or the nominal one,
/// without air), and with one gain from the plain mean of `contacts` contacts against the target's mean of all contacts while
/// it was whole. The contacts lie evenly over the ratios.
#[must_use]
pub(super) fn noise_limit(truth: &Truth, case: Case, has_air: bool, contacts: u32, noise: &Noise) -> f64 {
    let held_mpa = if has_air { best_mpa(truth, case) } else { START_MPA };
    let after = truth.after(held_mpa, None);
    let (_, target) = truth.before_and_target();
    let variance = variance(&after, noise) / f64::from(contacts) + variance(&target, noise) / WHOLE_CONTACTS as f64;
    let gain = best_gain(truth, held_mpa);
    let standard = Normal::standard();
    let errors = (0..QUANTILES).map(|k| {
        let off = standard.inverse_cdf((f64::from(k) + 0.5) / f64::from(QUANTILES)) * variance.sqrt();
        truth.error(held_mpa, Some(&[gain * off.exp(); CONTACT_RATIOS.len()])).mean
    });
    errors.sum::<f64>() / f64::from(QUANTILES)
}

/// Pressure at which one gain leaves the least error, MPa.
fn best_mpa(truth: &Truth, case: Case) -> f64 {
    let pressures = (0..=STEPS).map(|step| case.highest_mpa() * f64::from(step) / f64::from(STEPS));
    let errors = pressures.map(|mpa| (mpa, truth.best_gain_error(mpa)));
    errors.min_by(|one, other| one.1.total_cmp(&other.1)).map_or(START_MPA, |best| best.0)
}

/// The gain of [`Truth::best_gain_error`].
fn best_gain(truth: &Truth, held_mpa: f64) -> f64 {
    let (after, (_, target)) = (truth.after(held_mpa, None), truth.before_and_target());
    let gains = (0..CONTACT_RATIOS.len()).filter_map(|k| Some(target[k]? / after[k]?));
    let error = |gain: f64| truth.error(held_mpa, Some(&[gain; CONTACT_RATIOS.len()])).mean;
    gains.min_by(|one, other| error(*one).total_cmp(&error(*other))).unwrap_or(1.0)
}

/// Mean variance of the log sensitivity that one contact tells. An error in the contact ratio counts by the response's slope.
fn variance(response: &ByRatio, noise: &Noise) -> f64 {
    let slopes = (1..CONTACT_RATIOS.len())
        .filter_map(|k| Some((response[k]? / response[k - 1]?).ln() / (CONTACT_RATIOS[k] - CONTACT_RATIOS[k - 1])));
    let squares: Vec<f64> = slopes.map(|slope| slope.powi(2)).collect();
    let by_ratio = noise.ratio.powi(2) * squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    noise.strain_relative.powi(2) + noise.deflection_relative.powi(2) + by_ratio
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::trials;

    /// Without noise the best gain remains, and more contacts bring the error closer to it.
    #[test]
    fn property_noise_leaves_more_than_the_best_gain_and_less_with_more_contacts() {
        let trial = trials(3, 1).into_iter().find(|one| one.case == Case::Itself).expect("one");
        let truth = Truth::new(&trial);
        let silent = Noise { strain_relative: 0.0, strain_floor: 0.0, deflection_relative: 0.0, ratio: 0.0 };
        let limit = |contacts, noise: &Noise| noise_limit(&truth, trial.case, true, contacts, noise);
        let least = truth.best_gain_error(best_mpa(&truth, trial.case));
        assert!((limit(300, &silent) - least).abs() < 1e-9);
        let (few, many) = (limit(300, &Noise::default()), limit(3000, &Noise::default()));
        assert!(few > many && many > least, "{few} {many} {least}");
    }

    /// The known slope of a power law.
    #[test]
    fn golden_the_variance_of_a_contact_on_a_power_law() {
        let response = CONTACT_RATIOS.map(|a| Some((-2.0 * a).exp()));
        let found = variance(&response, &Noise::default());
        assert!((found - (0.02_f64.powi(2) + 0.01_f64.powi(2) + (2.0 * 0.01_f64).powi(2))).abs() < 1e-12);
    }
}
