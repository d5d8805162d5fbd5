//! How uncertain the log sensitivity of one contact is.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::units::ContactRatio;

/// The stated noise of a robot's readings, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// Of strain, relative to the reading.
    pub strain_relative: f64,
    /// Of strain, absolute, m/m.
    pub strain_floor: f64,
    /// Of deflection, relative to the reading.
    pub deflection_relative: f64,
    /// Of the contact ratio, absolute.
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
    /// `expected_strain` is the model's (the reading itself would give small readings large weight);
    /// `log_slope` is d ln s / d ln a at the contact.
    #[must_use]
    pub fn log_variance(&self, expected_strain: f64, ratio: ContactRatio, log_slope: f64) -> f64 {
        let floor = self.strain_floor / expected_strain;
        let ratio = log_slope * self.ratio / ratio.a();
        self.strain_relative.powi(2) + floor.powi(2) + self.deflection_relative.powi(2) + ratio.powi(2)
    }

    /// The least strain whose logarithm is still nearly Gaussian: ten times the floor.
    #[must_use]
    pub fn least_strain(&self) -> f64 {
        10.0 * self.strain_floor
    }
}

/// The learned factor between a whisker's true noise variance and the stated one.
///
/// Squared standardised innovations are averaged, each cut at 9 so that one outlier in a hundred cannot
/// inflate it; the prior counts as [`NoiseScale::PRIOR_CONTACTS`] contacts, the past as at most
/// [`NoiseScale::MEMORY_CONTACTS`].
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct NoiseScale {
    variance: f64,
    contacts: f64,
}

impl Default for NoiseScale {
    fn default() -> Self {
        Self { variance: 1.0, contacts: Self::PRIOR_CONTACTS }
    }
}

impl NoiseScale {
    /// Weight of the stated noise at the start.
    pub const PRIOR_CONTACTS: f64 = 30.0;
    /// Contacts that are remembered.
    pub const MEMORY_CONTACTS: f64 = 2000.0;
    /// E[min(w^2, 9)] of a standard normal w: what the cut takes away.
    const MEAN_OF_CUT: f64 = 0.995;

    /// Factor on the stated variance, dimensionless, between 1/16 and 16.
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// Takes one standardised innovation in; call it only while nothing is suspected.
    pub fn learn(&mut self, standardised: f64) {
        let square = standardised.powi(2).min(9.0) / Self::MEAN_OF_CUT;
        self.contacts = (self.contacts + 1.0).min(Self::MEMORY_CONTACTS);
        self.variance = (self.variance * (1.0 + (square - 1.0) / self.contacts)).clamp(0.0625, 16.0);
    }
}
