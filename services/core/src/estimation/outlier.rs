//! Density of a standardised innovation: normal with a learned scale, plus outliers.
//!
//! The scale was learned from a finite number of contacts, so the exact density of the next one is Student's t with
//! that many degrees of freedom (the basis of self-starting charts: Hawkins, J. Quality Technology 19 (1987) 7). A
//! detector that took a learned scale for the true one would mistake its error for a change. Also, at least one contact
//! in two hundred may be an outlier of ten times the noise. So a likelihood ratio stays below some thousand whatever a
//! single contact shows, and an outlier hardly affects the length. The share of outliers is learned, because the mean of
//! a likelihood ratio is one only with the true share: with four times as many outliers as assumed, it is 1.27 for a
//! shift of 2.4 standard deviations, and false alarms are more frequent than stated.

use super::fast_math;

/// Standard deviation of outliers in units of the noise.
const OUTLIER_SD: f64 = 10.0;

/// Density of a standardised innovation, up to a constant factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnovationDensity {
    /// Number of contacts from which the noise scale was learned.
    degrees_of_freedom: f64,
    /// Share of outliers.
    outliers: f64,
}

/// The density at one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// The density, times sqrt(2 pi).
    pub density: f64,
    /// Probability that the value is not an outlier, 0 to 1.
    pub sound: f64,
}

/// Number of densities evaluated at once: one for each hypothesis of [`crate::detection`], and a few more.
pub const LANES: usize = 20;

/// Densities at several values, and the probability of each value not to be an outlier.
#[derive(Debug, Clone)]
pub struct Densities {
    /// Densities, times sqrt(2 pi).
    pub density: [f32; LANES],
    /// Probabilities that the values are not outliers, 0 to 1.
    pub sound: [f32; LANES],
}

impl InnovationDensity {
    /// Least share of outliers that is assumed; it bounds the effect of one contact.
    pub const OUTLIERS_MIN: f64 = 0.005;

    /// `contacts` is the number of contacts from which the noise scale was learned, at least 3; `outliers` is the share of
    /// outliers.
    #[must_use]
    pub fn learned_from(contacts: f64, outliers: f64) -> Self {
        Self { degrees_of_freedom: contacts.max(3.0), outliers }
    }

    /// E[u(w) w^2], with u the probability that w is not an outlier: of a standard normal w at the least share, which is
    /// assumed also without outliers, and of w with this share of outliers above it.
    #[must_use]
    pub fn mean_square_seen(outliers: f64) -> f64 {
        0.997_2 - outliers
    }

    /// Density at a standardised deviation.
    #[must_use]
    pub fn at(&self, standardised: f64) -> Seen {
        let square = standardised * standardised;
        let freedom = self.degrees_of_freedom;
        let core = (1.0 - self.outliers) * (-0.5 * (freedom + 1.0) * ln_one_plus(square / freedom)).exp();
        let wide = self.outliers / OUTLIER_SD * (-0.5 * square / (OUTLIER_SD * OUTLIER_SD)).exp();
        let density = core + wide;
        // Far out both terms underflow; this avoids 0 / 0.
        if density > 1e-300 { Seen { density, sound: core / density } } else { Seen { density: 1e-300, sound: 0.0 } }
    }

    /// Densities at several values, to seven digits, for the detector's hot path. Beyond some hundred standard
    /// deviations the density no longer falls: there a contact carries no information.
    #[must_use]
    pub fn at_each(&self, standardised: &[f32; LANES]) -> Densities {
        let per_freedom = (1.0 / self.degrees_of_freedom) as f32;
        let power = (-0.5 * (self.degrees_of_freedom + 1.0)) as f32;
        let (sound_share, wide_share) = ((1.0 - self.outliers) as f32, (self.outliers / OUTLIER_SD) as f32);
        let mut one = Densities { density: [0.0; LANES], sound: [0.0; LANES] };
        for (index, &standardised) in standardised.iter().enumerate() {
            let square = least(standardised * standardised, SQUARE_MAX);
            let core = sound_share * fast_math::exp(power * fast_math::ln_one_plus(square * per_freedom));
            let wide = fast_math::exp(largest((-0.5 / (OUTLIER_SD * OUTLIER_SD)) as f32 * square, LEAST_LOG_WIDE));
            let density = core + wide_share * wide;
            one.density[index] = density;
            one.sound[index] = core / density;
        }
        one
    }
}

/// Least exponent of the outliers' term: it keeps that term far above the least value of the core.
const LEAST_LOG_WIDE: f32 = -60.0;

/// Squared innovations are limited to this value.
const SQUARE_MAX: f32 = 1e12;

fn largest(one: f32, other: f32) -> f32 {
    if one > other { one } else { other }
}

fn least(one: f32, other: f32) -> f32 {
    if one < other { one } else { other }
}

/// ln(1 + y), by its series where that is accurate enough; it is evaluated for each contact.
fn ln_one_plus(y: f64) -> f64 {
    if y < 0.05 { y * (1.0 - y * (0.5 - y * (1.0 / 3.0 - y * (0.25 - 0.2 * y)))) } else { y.ln_1p() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral by Simpson's rule from -12 to 12.
    fn integral(of: impl Fn(f64) -> f64) -> f64 {
        const CELLS: i32 = 20_000;
        let step = 24.0 / f64::from(CELLS);
        let weight = |k: i32| if k == 0 || k == CELLS { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        (0..=CELLS).map(|k| weight(k) * of(-12.0 + step * f64::from(k))).sum::<f64>() * step / 3.0
    }

    fn normal(w: f64) -> f64 {
        (-0.5 * w * w).exp() / (2.0 * std::f64::consts::PI).sqrt()
    }

    #[test]
    fn property_what_a_normal_contact_shows_of_its_variance() {
        for (outliers, tolerance) in [(InnovationDensity::OUTLIERS_MIN, 2e-4), (0.02, 3e-3), (0.05, 5e-3)] {
            let density = InnovationDensity::learned_from(1e9, outliers);
            let seen = integral(|w| normal(w) * density.at(w).sound * w * w);
            let stated = InnovationDensity::mean_square_seen(outliers);
            assert!((seen - stated).abs() < tolerance, "{outliers}: {seen} {stated}");
        }
    }

    #[test]
    fn property_all_at_once_are_the_same_to_six_digits() {
        for freedom in [3.0, 6.0, 60.0, 150.0, 4000.0, 1e6] {
            let density = InnovationDensity::learned_from(freedom, 0.02);
            for step in 0..2000_u16 {
                let at: [f32; LANES] = std::array::from_fn(|lane| 0.005 * f32::from(step) * (lane as f32 - 7.0) / 7.0);
                let all = density.at_each(&at);
                for (lane, at) in at.into_iter().enumerate() {
                    let one = density.at(f64::from(at));
                    let off = f64::from(all.density[lane]) / one.density - 1.0;
                    assert!(off.abs() < 4e-6, "{freedom} {at}: {off}");
                    assert!((f64::from(all.sound[lane]) - one.sound).abs() < 4e-6, "{freedom} {at}");
                }
            }
        }
    }

    #[test]
    fn property_far_out_a_contact_tells_nothing() {
        let density = InnovationDensity::learned_from(4000.0, InnovationDensity::OUTLIERS_MIN);
        for at in [200.0, 1e3, 1e6, 1e15] {
            let all = density.at_each(&std::array::from_fn(|lane| if lane == 0 { at } else { -0.9 * at }));
            assert_eq!(all.density[0], all.density[1], "{at}");
            assert!(all.density[0] > 0.0 && all.sound[0] < 1e-6, "{at}: {all:?}");
        }
    }

    /// The likelihood ratio of any shift has a mean of at most one while nothing changes, up to the assumed
    /// outliers that do not occur. This guarantees the mean number of contacts between false alarms.
    #[test]
    fn property_a_likelihood_ratio_has_a_mean_of_one() {
        let density = InnovationDensity::learned_from(1e9, InnovationDensity::OUTLIERS_MIN);
        for shift in [0.1, 0.3, 1.0, 2.0, 4.0, 8.0] {
            let mean = integral(|w| normal(w) * density.at(w - shift).density / density.at(w).density);
            assert!(mean < 1.005, "{shift}: {mean}");
            // The outlier term costs little in the range in which contacts decide.
            assert!(shift > 2.0 || mean > 0.95, "{shift}: {mean}");
        }
    }

    #[test]
    fn property_no_single_contact_decides() {
        let density = InnovationDensity::learned_from(1e4, InnovationDensity::OUTLIERS_MIN);
        for tenths in -300..300 {
            let w = f64::from(tenths) / 10.0;
            let ratio = density.at(0.0).density / density.at(w).density;
            assert!(ratio.is_finite() && ratio < 1e6, "{w}: {ratio}");
        }
    }
}
