//! Uncertainty of the log sensitivity of one contact.

use borsh::{BorshDeserialize, BorshSerialize};

use super::outlier::{InnovationDensity, MEAN_SQUARE_SEEN};
/// Configured noise of a robot's readings, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// Strain noise, relative to the reading.
    pub strain_relative: f64,
    /// Strain noise floor, absolute, m/m.
    pub strain_floor: f64,
    /// Deflection noise, relative to the reading.
    pub deflection_relative: f64,
    /// Contact ratio noise, absolute.
    pub ratio: f64,
}

impl Default for SensorNoise {
    fn default() -> Self {
        Self { strain_relative: 0.02, strain_floor: 5e-6, deflection_relative: 0.01, ratio: 0.01 }
    }
}

impl SensorNoise {
    /// Variance of ln(strain / deflection) minus its prediction, to first order.
    ///
    /// `expected_strain` is the model's, because with the measured strain small readings would get a large weight. The
    /// error of the contact's place is not part of it.
    #[must_use]
    pub fn log_variance(&self, expected_strain: f64) -> f64 {
        let floor = self.strain_floor / expected_strain;
        self.strain_relative.powi(2) + floor.powi(2) + self.deflection_relative.powi(2)
    }

    /// Least strain whose logarithm is still nearly Gaussian: ten times the floor.
    #[must_use]
    pub fn least_strain(&self) -> f64 {
        10.0 * self.strain_floor
    }
}

/// Learned ratio between a whisker's true noise variance and the configured one.
///
/// Averages squared standardised innovations, each weighted by its probability of not being an outlier. The
/// configured noise counts as [`NoiseScale::PRIOR_CONTACTS`] contacts, the past as at most
/// [`NoiseScale::MEMORY_CONTACTS`].
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct NoiseScale {
    variance: f32,
    contacts: f32,
}

impl Default for NoiseScale {
    fn default() -> Self {
        Self { variance: 1.0, contacts: Self::PRIOR_CONTACTS as f32 }
    }
}

impl NoiseScale {
    /// Weight of the configured noise at the start, in contacts.
    pub const PRIOR_CONTACTS: f64 = 6.0;
    /// Largest weight of the past, in contacts.
    pub const MEMORY_CONTACTS: f64 = 4000.0;

    /// Factor on the configured variance, dimensionless, between 1/16 and 16.
    #[must_use]
    pub fn variance(&self) -> f64 {
        f64::from(self.variance)
    }

    /// Density of an innovation standardised with this scale.
    #[must_use]
    pub fn density(&self) -> InnovationDensity {
        InnovationDensity::learned_from(f64::from(self.contacts))
    }

    /// Learns from one standardised innovation; call it only while no change is suspected. `sound` is the
    /// probability by [`Self::density`] that the contact is not an outlier. `share` is the share of noise in the
    /// innovation's variance, 0 to 1: uncertainty of the state carries no information about the noise.
    ///
    /// Returns the factor by which the scale's variance has changed.
    pub fn learn(&mut self, standardised: f64, sound: f64, share: f64) -> f64 {
        let before = self.variance();
        let square = sound * standardised.powi(2) / MEAN_SQUARE_SEEN;
        self.contacts = (f64::from(self.contacts) + share).min(Self::MEMORY_CONTACTS) as f32;
        let after = before * (1.0 + share * (square - 1.0) / f64::from(self.contacts));
        self.variance = after.clamp(0.0625, 16.0) as f32;
        self.variance() / before
    }
}
