//! A whisker's shape and calibration, checked once, with what can be computed once.

use super::calibration::Calibration;
use super::geometry::Geometry;
use super::taper::{self, Quadratic};
use crate::units::{Megapascal, Millimetre};

/// How to read a factor of eq. 27, 29 and 31 that is printed without its superscript q.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Formulation {
    /// The cube of the mid-wall cone's length as printed: at zero pressure. Gives both published
    /// setpoints exactly.
    #[default]
    Published,
    /// Under pressure, which is what putting Table 2 into eq. 11 and 15 gives.
    Consistent,
}

/// The model of one whisker: shape, calibration and formulation.
///
/// Two whiskers with the same three share a model; length and pressure are arguments.
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

/// Why a shape and a calibration make no model; the message names the condition that fails.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A size or parameter must be above zero and finite.
    #[error("{name} must be a number above 0, not {value}")]
    NotPositive {
        /// Its name in the paper.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter must not be below zero, and finite.
    #[error("{name} must be a number not below 0, not {value}")]
    Negative {
        /// Its name in the paper.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// Two sizes contradict each other.
    #[error("{0}")]
    Geometry(&'static str),
    /// At the highest examined pressure, 0.2 MPa, next to nothing would be left of the wall (Table 2's `t^q`).
    #[error(
        "at 0.2 MPa the chamber would stretch by {elongation_mm} mm and lose its wall: the elongation gain G is too large"
    )]
    WallVanishes {
        /// The elongation there, in mm.
        elongation_mm: f64,
    },
}

/// Eq. 20 takes the wall's thickness as the mean of that at x = 2.5 mm and at x = l. For other
/// whiskers, 0.5 mm beyond the cap.
const NEAR_CAP_MM: f64 = 0.5;

impl Model {
    /// Checks a shape and a calibration, once.
    ///
    /// # Errors
    /// The first condition that fails, by name.
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

    /// The same shape with another calibration near its own: what was computed once follows from the shape.
    pub(super) fn relative(&self, calibration: Calibration, formulation: Formulation) -> Self {
        Self { calibration, formulation, ..self.clone() }
    }

    fn precompute(g: Geometry, calibration: Calibration, formulation: Formulation) -> Self {
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

    /// The whisker's shape.
    #[must_use]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The whisker's calibration.
    #[must_use]
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// How the misprinted factor is read.
    #[must_use]
    pub fn formulation(&self) -> Formulation {
        self.formulation
    }

    /// k2(Q): modulus of the chamber's wall relative to the rubber's (Fig. 6C).
    #[must_use]
    pub fn k2(&self, pressure: Megapascal) -> f64 {
        self.calibration.k2(pressure.mpa())
    }

    /// `delta_l(l)`: by how much the chamber, and with it the whisker, is longer under pressure
    /// (eq. 24 at x = l; Fig. 6D). At most 1000 mm, the limit of the unit.
    #[must_use]
    pub fn elongation(&self, pressure: Megapascal) -> Millimetre {
        let elongation_mm = self.calibration.elongation_mm(pressure.mpa(), self.k2(pressure));
        Millimetre::known(elongation_mm.min(1000.0))
    }
}
