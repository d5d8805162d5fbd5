//! The density that a standardised innovation is taken to have: normal of learned size, with outliers.
//!
//! Two things are not known of it. Its scale was learned from a finite number of contacts, so the exact
//! density of the next one is Student's t with that many degrees of freedom (this is what self-starting charts
//! rest on: Hawkins, J. Quality Technology 19 (1987) 7); a detector that took a learned scale for a true one
//! would see its error as a change. And one contact in two hundred may be an outlier of ten times the noise; so
//! a likelihood ratio stays below some thousand whatever a single contact says, and an outlier says next to
//! nothing about the length.

/// Share of contacts that are taken for outliers; it bounds what one contact can say.
const OUTLIERS: f64 = 0.005;
/// Their standard deviation in units of the noise.
const OUTLIER_SD: f64 = 10.0;
/// E[u(w) w^2] of a standard normal w, with u its probability of being no outlier.
pub const MEAN_SQUARE_SEEN: f64 = 0.992_2;

/// The density of a standardised innovation, up to a constant factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnovationDensity {
    /// Contacts that the noise's scale was learned from.
    degrees_of_freedom: f64,
}

/// A density at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// The density, times sqrt(2 pi).
    pub density: f64,
    /// Probability that it is no outlier, 0 to 1.
    pub sound: f64,
}

impl InnovationDensity {
    /// `contacts` is what the noise's scale rests on.
    #[must_use]
    pub fn learned_from(contacts: f64) -> Self {
        Self { degrees_of_freedom: contacts.max(3.0) }
    }

    /// The density at a standardised deviation.
    #[must_use]
    pub fn at(&self, standardised: f64) -> Seen {
        let square = standardised * standardised;
        let freedom = self.degrees_of_freedom;
        let core = (1.0 - OUTLIERS) * (-0.5 * (freedom + 1.0) * ln_one_plus(square / freedom)).exp();
        let wide = OUTLIERS / OUTLIER_SD * (-0.5 * square / (OUTLIER_SD * OUTLIER_SD)).exp();
        let density = core + wide;
        // Far out both are tiny: never a division of zero by zero.
        if density > 1e-300 { Seen { density, sound: core / density } } else { Seen { density: 1e-300, sound: 0.0 } }
    }
}

/// ln(1 + y), by its series where that is exact enough: it is asked for at every contact for every hypothesis.
fn ln_one_plus(y: f64) -> f64 {
    if y < 0.05 { y * (1.0 - y * (0.5 - y * (1.0 / 3.0 - y * (0.25 - 0.2 * y)))) } else { y.ln_1p() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrals by Simpson's rule over +-12.
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
        let density = InnovationDensity::learned_from(1e9);
        let seen = integral(|w| normal(w) * density.at(w).sound * w * w);
        assert!((seen - MEAN_SQUARE_SEEN).abs() < 2e-4, "{seen}");
    }

    /// The likelihood ratio of any shift has a mean of at most one while nothing changes, up to the outliers
    /// that are allowed for and do not come: that is what keeps the stated mean between false alarms.
    #[test]
    fn property_a_likelihood_ratio_has_a_mean_of_one() {
        let density = InnovationDensity::learned_from(1e9);
        for shift in [0.1, 0.3, 1.0, 2.0, 4.0, 8.0] {
            let mean = integral(|w| normal(w) * density.at(w - shift).density / density.at(w).density);
            assert!(mean < 1.005, "{shift}: {mean}");
            // What the outliers take away is little where contacts are to tell.
            assert!(shift > 2.0 || mean > 0.95, "{shift}: {mean}");
        }
    }

    #[test]
    fn property_no_single_contact_decides() {
        let density = InnovationDensity::learned_from(1e4);
        for tenths in -300..300 {
            let w = f64::from(tenths) / 10.0;
            let ratio = density.at(0.0).density / density.at(w).density;
            assert!(ratio.is_finite() && ratio < 1e6, "{w}: {ratio}");
        }
    }
}
