//! Effect of pressure on the chamber's rubber: the fits of Fig. 6C and 6D.

use super::geometry::Geometry;
use super::model_error::ModelError;

/// Stiffness and elongation of the chamber's wall as functions of the pressure.
///
/// `k2(Q) = c + a exp(-b Q)` is the modulus of region 2 relative to the rubber's, `E2 = k2 E` (Fig. 6C).
/// `delta_l(Q) = G Q / (k2(Q) E)` is the chamber's elongation (Fig. 6D).
///
/// A sensitivity depends on these two functions alone; `youngs_modulus_mpa` cancels out of it except in the
/// elongation. Checked by [`super::Model::new`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Limit of k2 at high pressure; above 0.
    pub c: f64,
    /// Excess of k2 at zero pressure over `c`; at least 0 (the rubber softens under pressure).
    pub a: f64,
    /// Rate of softening per MPa; above 0.
    pub b_per_mpa: f64,
    /// E: Young's modulus of the rubber in MPa; above 0.
    pub youngs_modulus_mpa: f64,
    /// G: elongation of the chamber in mm for Q = `E2`; at least 0. By eq. 24 it follows from the shape:
    /// [`Geometry::elongation_gain_mm`].
    pub elongation_gain_mm: f64,
}

impl Calibration {
    /// The calibration that reproduces the paper's two published setpoints exactly.
    ///
    /// The paper shows the fits only as curves. With these numbers, eq. 34 gives k2 = 1.5033 at 0.048 MPa and
    /// 0.7365 at 0.192 MPa, with the elongation of eq. 24; E then agrees with Gent's relation for a rubber of Shore
    /// 30A (1.14 MPa). A real whisker needs its own, measured calibration.
    #[must_use]
    pub fn nguyen_2021() -> Self {
        Self {
            c: 0.469_325_69,
            a: 1.623_359_72,
            b_per_mpa: 9.397_666_14,
            youngs_modulus_mpa: 1.113_447_7,
            elongation_gain_mm: Geometry::nguyen_2021().elongation_gain_mm(),
        }
    }

    pub(super) fn k2(&self, pressure_mpa: f64) -> f64 {
        self.c + self.a * (-self.b_per_mpa * pressure_mpa).exp()
    }

    pub(super) fn elongation_mm(&self, pressure_mpa: f64, k2: f64) -> f64 {
        self.elongation_gain_mm * pressure_mpa / (k2 * self.youngs_modulus_mpa)
    }

    pub(super) fn check(&self) -> Result<(), ModelError> {
        let positive = [
            ("calibration c", self.c),
            ("calibration b", self.b_per_mpa),
            ("Young's modulus", self.youngs_modulus_mpa),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(ModelError::NotPositive { name, value });
            }
        }
        for (name, value) in [("calibration a", self.a), ("elongation gain G", self.elongation_gain_mm)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(ModelError::Negative { name, value });
            }
        }
        Ok(())
    }
}
