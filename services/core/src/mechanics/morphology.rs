//! Table 2: dimensions of the whisker under pressure.

use super::model::{Formulation, Model};
use super::taper::{self, Quadratic};
use crate::units::{Megapascal, Millimetre};

/// The chamber of one model at one pressure (Table 2, eq. 18-25), lengths in mm.
///
/// Valid only with the model that computed it. Regions 1 and 3 keep their shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Morphology {
    /// Q: the gauge pressure.
    pub pressure: Megapascal,
    /// k2(Q): modulus of the chamber's wall relative to the rubber's.
    pub k2: f64,
    /// `delta_l(l)`: elongation of the chamber, and thereby of the whisker.
    pub elongation_mm: f64,
    /// `t^q`: thickness of the wall (eq. 18-20).
    pub wall_mm: f64,
    /// Mid-wall diameter at x = c: inner diameter there + `t^q`. The inner diameter is that at zero pressure,
    /// mid-wall diameter minus t. Table 2's `Dm` (12 mm) belongs to x = 0 and would not reproduce Table 1 at zero
    /// pressure.
    pub d2_mid_large_mm: f64,
    /// Mid-wall diameter at the chamber's end: `dm + t^q`.
    pub d2_mid_small_mm: f64,
    /// Length of the mid-wall cone from x = c to its point.
    pub l2_mid_mm: f64,
    /// `l^q`: end of the chamber; a contact must lie beyond it.
    pub chamber_end_mm: f64,
    /// `x_ss^q`: start of the gauge's grid.
    pub gauge_start_mm: f64,
    /// Eq. 27 as a function of the contact distance, factor included.
    pub(super) chamber: Quadratic,
    /// Eq. 30 as a function of the contact distance.
    pub(super) gauge: Quadratic,
    /// The factor before kappa in eq. 31, per mm.
    pub(super) gauge_factor: f64,
}

impl Model {
    /// Dimensions of the chamber under a pressure (Table 2).
    ///
    /// The paper examined up to 0.2 MPa, where [`Model::new`] checks that a wall remains. Beyond that the numbers
    /// are extrapolated, and the wall keeps at least a hundredth of its thickness, so that all results stay finite.
    #[must_use]
    pub fn morphology(&self, pressure: Megapascal) -> Morphology {
        let k2 = self.k2(pressure);
        let elongation_mm = self.calibration().elongation_mm(pressure.mpa(), k2);
        self.stretched(pressure, k2, elongation_mm)
    }

    /// Dimensions of Table 1 with one modulus for the whole whisker, as eq. 10-17 assume.
    pub(super) fn unpressurized(&self) -> Morphology {
        self.stretched(Megapascal::ZERO, 1.0, 0.0)
    }

    fn stretched(&self, pressure: Megapascal, k2: f64, elongation_mm: f64) -> Morphology {
        let g = self.geometry();
        let wall_mm = (g.t_mm - self.thinning * elongation_mm).max(self.least_wall_mm());
        let chamber_end_mm = g.l_mm + elongation_mm;
        let gauge_start_mm = g.xss_mm + self.share_before_gauge * elongation_mm;
        let d2_mid_large_mm = g.d2_mid_large_mm - g.t_mm + wall_mm;
        let d2_mid_small_mm = g.dm_small_mm + wall_mm;
        let l2_mid_mm = d2_mid_large_mm * (chamber_end_mm - g.c_mm) / (d2_mid_large_mm - d2_mid_small_mm);
        let cubed_mm = match self.formulation() {
            Formulation::Published => g.l2_mid_mm,
            Formulation::Consistent => l2_mid_mm,
        };
        let gauge_factor = 4.0 * (cubed_mm / d2_mid_large_mm).powi(3) / (k2 * wall_mm);
        Morphology {
            pressure,
            k2,
            elongation_mm,
            wall_mm,
            d2_mid_large_mm,
            d2_mid_small_mm,
            l2_mid_mm,
            chamber_end_mm,
            gauge_start_mm,
            chamber: scaled(taper::chamber_delta2(l2_mid_mm, g.c_mm, chamber_end_mm), 2.0 * gauge_factor),
            gauge: taper::gauge_kappa((d2_mid_large_mm, l2_mid_mm), wall_mm, g.c_mm, gauge_start_mm, g.e_mm),
            gauge_factor,
        }
    }

    pub(super) fn least_wall_mm(&self) -> f64 {
        0.01 * self.geometry().t_mm
    }

    /// `l^q`: end of the chamber under pressure; a contact must lie beyond it.
    ///
    /// At most 1000 mm, the limit of the unit.
    #[must_use]
    pub fn chamber_end(&self, morphology: &Morphology) -> Millimetre {
        Millimetre::known(morphology.chamber_end_mm.min(1000.0))
    }
}

/// The factor of eq. 27 is twice that of eq. 31.
fn scaled(q: Quadratic, factor: f64) -> Quadratic {
    Quadratic { pole_mm: q.pole_mm, s0: factor * q.s0, s1: factor * q.s1, s2: factor * q.s2 }
}
