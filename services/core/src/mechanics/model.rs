//! Model of a whisker: its shape and calibration, checked once, with precomputed constants.

use super::calibration::Calibration;
use super::geometry::Geometry;
use super::model_error::ModelError;
use super::taper::{self, Quadratic};
use crate::units::{Megapascal, Millimetre};

/// Reading of a factor of eq. 27, 29 and 31 that is printed without its superscript q.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Formulation {
    /// The cube of the mid-wall cone's length at zero pressure, as printed. Reproduces both published setpoints
    /// exactly.
    #[default]
    Published,
    /// The cube under pressure, which follows from inserting Table 2 into eq. 11 and 15.
    Consistent,
}

/// The model of one whisker: shape, calibration and formulation.
///
/// Whiskers with the same three share a model; length and pressure are arguments.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    geometry: Geometry,
    calibration: Calibration,
    formulation: Formulation,
    /// Wall thinning in mm per mm of elongation (eq. 18-20).
    pub(super) thinning: f64,
    /// Share of the chamber's elongation that lies before the gauge (eq. 25).
    pub(super) share_before_gauge: f64,
    /// Axial strain of the gauge's grid for Q = E2 (eq. 32).
    pub(super) axial_gain: f64,
    /// Eq. 10 and 26: pressure leaves the cap as it is.
    pub(super) cap: Quadratic,
}

/// Eq. 20 takes the wall's thickness as the mean of those at x = 2.5 mm and at x = l. For whiskers of other
/// dimensions, the first position is this far beyond the cap, in mm.
const NEAR_CAP_MM: f64 = 0.5;

impl Model {
    /// Checks a shape and a calibration.
    ///
    /// # Errors
    /// The first failed condition, by name.
    pub fn new(geometry: Geometry, calibration: Calibration, formulation: Formulation) -> Result<Self, ModelError> {
        geometry.check()?;
        calibration.check()?;
        let model = Self::precompute(geometry, calibration, formulation);
        let stretched = model.morphology(Megapascal::EXAMINED_MAX);
        if stretched.wall_mm > model.least_wall_mm() {
            Ok(model)
        } else {
            Err(ModelError::WallVanishes { elongation_mm: stretched.elongation_mm })
        }
    }

    /// The paper's whisker: [`Geometry::nguyen_2021`] with [`Calibration::nguyen_2021`].
    #[must_use]
    pub fn nguyen_2021(formulation: Formulation) -> Self {
        Self::precompute(Geometry::nguyen_2021(), Calibration::nguyen_2021(), formulation)
    }

    /// The same shape with a similar calibration: the precomputed constants depend on the shape only.
    pub(super) fn relative(&self, calibration: Calibration, formulation: Formulation) -> Self {
        Self { calibration, formulation, ..self.clone() }
    }

    /// The same whisker with a wall that keeps its volume under pressure. By eq. 18 to 20 the wall gets thinner by Poisson's ratio
    /// times the radius for each share of elongation, and 1.7 times as much as by its volume: the inner diameter stays.
    #[must_use]
    pub fn with_wall_by_volume(&self) -> Self {
        let g = &self.geometry;
        let mid_mm = 0.5 * (g.d2_mid_large_mm + g.d2_mid_small_mm);
        let thinning = 2.0 * g.poisson_ratio * g.t_mm * mid_mm / ((mid_mm + g.t_mm) * g.chamber_mm());
        Self { thinning, ..self.clone() }
    }

    /// The model without a check, for steps of a fit: its results are finite for any positive calibration.
    pub(super) fn precompute(g: Geometry, calibration: Calibration, formulation: Formulation) -> Self {
        let outer_radius_mm = |x_mm: f64| 0.5 * g.d2_large_mm * (1.0 - (x_mm - g.c_mm) / g.l2_mm);
        let mean_radius_mm = 0.5 * (outer_radius_mm(g.c_mm + NEAR_CAP_MM) + outer_radius_mm(g.l_mm));
        Self {
            thinning: g.poisson_ratio * mean_radius_mm / g.chamber_mm(),
            share_before_gauge: g.elongation_gain_between_mm(g.c_mm, g.xss_mm) / g.elongation_gain_mm(),
            axial_gain: g.axial_gain(),
            cap: taper::cap_delta1(&g),
            geometry: g,
            calibration,
            formulation,
        }
    }

    /// Shape of the whisker.
    #[must_use]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Calibration of the whisker.
    #[must_use]
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Reading of the misprinted factor.
    #[must_use]
    pub fn formulation(&self) -> Formulation {
        self.formulation
    }

    /// k2(Q): modulus of the chamber's wall relative to the rubber's (Fig. 6C).
    #[must_use]
    pub fn k2(&self, pressure: Megapascal) -> f64 {
        self.calibration.k2(pressure.mpa())
    }

    /// `delta_l(l)`: elongation of the chamber, and thereby of the whisker, under pressure (eq. 24 at x = l; Fig.
    /// 6D). At most 1000 mm, the limit of the unit.
    #[must_use]
    pub fn elongation(&self, pressure: Megapascal) -> Millimetre {
        let elongation_mm = self.calibration.elongation_mm(pressure.mpa(), self.k2(pressure));
        Millimetre::known(elongation_mm.min(1000.0))
    }
}
