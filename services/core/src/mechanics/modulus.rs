//! Young's modulus of the chamber's wall from the gauge's strain under pressure, without contact: eq. 32 and 33.

use super::geometry::Geometry;
use super::model::Model;
use crate::units::{Megapascal, Strain};

impl Geometry {
    /// `E2^q` in MPa from an axial strain under a pressure, without contact (eq. 33).
    ///
    /// `None` if the strain is not positive, because a chamber under pressure stretches, and at zero pressure,
    /// where the strain carries no information.
    #[must_use]
    pub fn youngs_modulus_from_axial_strain(&self, pressure: Megapascal, axial_strain: Strain) -> Option<f64> {
        let e2_mpa = self.axial_gain() * pressure.mpa() / axial_strain.ratio();
        (axial_strain.ratio() > 0.0 && e2_mpa > 0.0).then_some(e2_mpa)
    }
}

impl Model {
    /// Strain of the gauge under a pressure, without contact (eq. 32): the inverse of eq. 33.
    ///
    /// At most 1, the limit of the unit.
    #[must_use]
    pub fn axial_strain(&self, pressure: Megapascal) -> Strain {
        let e2_mpa = self.k2(pressure) * self.calibration().youngs_modulus_mpa;
        Strain::known((self.axial_gain * pressure.mpa() / e2_mpa).min(1.0))
    }
}
