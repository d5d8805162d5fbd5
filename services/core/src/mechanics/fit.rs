//! A whisker's own calibration from readings under pressure alone: eq. 32 and 33, then least squares.
//!
//! Each axial strain gives one modulus by eq. 33, hence one k2 = E2 / E. Readings carry a roughly
//! constant *relative* error (of the gauge factor, of the amplifier), so the logarithms are fitted, all
//! with one weight: `ln k2 = ln(c + a exp(-b Q))`. In the plain numbers the soft, high-pressure end,
//! where setpoints are most delicate, would hardly count. The elongation gain is the mean logarithm of
//! `delta_l k2(Q) E / Q` over the rows that have an elongation, with the fitted k2.
//!
//! E must be given: an axial strain fixes only the product E k2. A wrong E scales `c` and `a` inversely,
//! which changes how the chamber compares with the cap and the body.
//!
//! The parameters are positive by meaning, and are found as logarithms: intervals are asymmetric.

mod curve;
mod readings;

use nalgebra::Matrix3;
use statrs::distribution::{ContinuousCDF, StudentsT};

use self::curve::{Curve, fit_curve};
use self::readings::{MeanLog, Point, log_elongation_gains, mean_log, measured_k2};
use super::calibration::Calibration;
use super::geometry::Geometry;
use super::model::{Formulation, Model, ModelError};
use crate::units::{Megapascal, Millimetre, Strain};

/// Rows with a strain above zero pressure that a fit needs: one more than parameters.
const STRAINS_MIN: usize = 4;
/// Distinct pressures that three parameters need.
const PRESSURES_MIN: usize = 3;
/// A parameter known to no better than this, in its logarithm, is not known: a factor of 150.
const LOG_ERROR_MAX: f64 = 5.0;

/// One reading of a whisker under pressure, without contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationRow {
    /// Q. Rows at zero pressure say nothing and are passed over.
    pub pressure: Megapascal,
    /// The gauge's strain due to the pressure; above 0.
    pub axial_strain: Option<Strain>,
    /// `delta_l(l)`, measured at the tip; above 0.
    pub elongation: Option<Millimetre>,
}

/// A fitted number with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Best estimate.
    pub value: f64,
    /// Standard error, to first order.
    pub standard_error: f64,
    /// Lower end of the 95 % confidence interval (Student's t, of the logarithm).
    pub low: f64,
    /// Upper end of the 95 % confidence interval.
    pub high: f64,
}

impl Parameter {
    fn from_mean(logs: MeanLog) -> Self {
        Self::from_log(logs.mean, logs.sd / logs.count.sqrt(), student_t(logs.count - 1.0))
    }

    fn from_log(log: f64, log_error: f64, t: f64) -> Self {
        let value = log.exp();
        Self {
            value,
            standard_error: value * log_error,
            low: (log - t * log_error).exp(),
            high: (log + t * log_error).exp(),
        }
    }
}

/// What one row says, and how far from the fit: differences of logarithms, 0.01 is 1 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowResidual {
    /// k2 of this row by eq. 33, if it has a strain.
    pub k2: Option<f64>,
    /// ln k2 measured - fitted.
    pub k2_residual: Option<f64>,
    /// ln `delta_l` measured - fitted.
    pub elongation_residual: Option<f64>,
}

/// A calibration with what is known about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Ready for a model. Without elongations in the rows its gain is the geometry's, by eq. 24.
    pub calibration: Calibration,
    /// k2 that high pressures tend to.
    pub c: Parameter,
    /// Excess of k2 at zero pressure.
    pub a: Parameter,
    /// Rate of softening per MPa.
    pub b_per_mpa: Parameter,
    /// Elongation gain in mm, if elongations were measured. The uncertainty of k2 is not in it.
    pub elongation_gain_mm: Option<Parameter>,
    /// One per row, in the rows' order.
    pub residuals: Vec<RowResidual>,
    /// Standard deviation of ln k2 about the fit: the relative error of one strain reading.
    pub residual_sd: f64,
    /// Standard deviation of ln `delta_l` about the fit.
    pub elongation_residual_sd: Option<f64>,
    /// Covariance of (ln c, ln a, ln b).
    covariance: Matrix3<f64>,
    /// Student's t for 95 %.
    t: f64,
}

impl Fit {
    /// k2 of the fit at a pressure with its 95 % confidence band, as in [`Parameter`].
    #[must_use]
    pub fn k2(&self, pressure: Megapascal) -> Parameter {
        let curve = Curve { c: self.c.value, a: self.a.value, b_per_mpa: self.b_per_mpa.value };
        let gradient = curve.log_gradient(pressure.mpa());
        let variance = (gradient.transpose() * self.covariance * gradient).x;
        Parameter::from_log(curve.k2(pressure.mpa()).ln(), variance.max(0.0).sqrt(), self.t)
    }
}

/// Why readings make no calibration.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Not one reading under pressure.
    #[error("no row has a pressure above zero")]
    NothingAboveZeroPressure,
    /// Too few strains.
    #[error("{given} rows with a strain above zero pressure: at least {STRAINS_MIN} are needed")]
    TooFewStrains {
        /// How many there are.
        given: usize,
    },
    /// Too few pressures.
    #[error("strains at {given} distinct pressures: at least {PRESSURES_MIN} are needed")]
    TooFewPressures {
        /// How many there are.
        given: usize,
    },
    /// One elongation has no spread.
    #[error("one elongation only: none or at least two are needed")]
    OneElongation,
    /// A chamber under pressure stretches.
    #[error("row {row}: under pressure the axial strain must be above 0, not {value}")]
    StrainNotPositive {
        /// Which row, counted from 1.
        row: usize,
        /// What it says.
        value: f64,
    },
    /// A chamber under pressure stretches.
    #[error("row {row}: under pressure the elongation must be above 0 mm, not {value_mm}")]
    ElongationNotPositive {
        /// Which row, counted from 1.
        row: usize,
        /// What it says, in mm.
        value_mm: f64,
    },
    /// The readings do not fall toward a limit.
    #[error("the strains do not determine {parameter}: k2 must be seen falling from low to high pressure, and bending")]
    NotDetermined {
        /// Which one.
        parameter: &'static str,
    },
    /// The shape, the modulus or the result makes no model.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Fits a calibration to readings under pressure, without contact.
///
/// `youngs_modulus_mpa` is E of the rubber; see the module's description for why it must be given.
///
/// # Errors
/// The readings do not determine a calibration: the failing condition by name.
pub fn fit_calibration(geometry: &Geometry, youngs_modulus_mpa: f64, rows: &[CalibrationRow]) -> Result<Fit, FitError> {
    geometry.check()?;
    if !(youngs_modulus_mpa.is_finite() && youngs_modulus_mpa > 0.0) {
        return Err(ModelError::NotPositive { name: "Young's modulus", value: youngs_modulus_mpa }.into());
    }
    let measured = measured_k2(geometry, youngs_modulus_mpa, rows)?;
    let fitted = FittedCurve::new(&measured.iter().flatten().copied().collect::<Vec<_>>())?;
    let curve = fitted.curve;
    let log_gains = log_elongation_gains(&curve, youngs_modulus_mpa, rows)?;
    let gain = mean_log(&log_gains)?;
    let calibration = Calibration {
        c: curve.c,
        a: curve.a,
        b_per_mpa: curve.b_per_mpa,
        youngs_modulus_mpa,
        elongation_gain_mm: gain.map_or_else(|| geometry.elongation_gain_mm(), |gain| gain.mean.exp()),
    };
    Model::new(*geometry, calibration, Formulation::default())?;
    let residuals = measured.iter().zip(&log_gains).map(|(point, log_gain)| RowResidual {
        k2: point.map(|point| point.log_k2.exp()),
        k2_residual: point.map(|point| curve.residual(&point)),
        elongation_residual: log_gain.zip(gain).map(|(log_gain, gain)| log_gain - gain.mean),
    });
    let [c, a, b_per_mpa] = fitted.parameters()?;
    Ok(Fit {
        calibration,
        c,
        a,
        b_per_mpa,
        elongation_gain_mm: gain.map(Parameter::from_mean),
        residuals: residuals.collect(),
        residual_sd: fitted.residual_sd,
        elongation_residual_sd: gain.map(|gain| gain.sd),
        covariance: fitted.covariance,
        t: fitted.t,
    })
}

/// The curve with its scatter and uncertainty.
struct FittedCurve {
    curve: Curve,
    covariance: Matrix3<f64>,
    residual_sd: f64,
    t: f64,
}

impl FittedCurve {
    fn new(points: &[Point]) -> Result<Self, FitError> {
        let (curve, unit_covariance) = fit_curve(points)?;
        let degrees = (points.len() - 3) as f64;
        let sum_of_squares: f64 = points.iter().map(|point| curve.residual(point).powi(2)).sum();
        let variance = sum_of_squares / degrees;
        Ok(Self { curve, covariance: unit_covariance * variance, residual_sd: variance.sqrt(), t: student_t(degrees) })
    }

    fn parameters(&self) -> Result<[Parameter; 3], FitError> {
        let curve = &self.curve;
        let named = [("c", curve.c), ("a", curve.a), ("b", curve.b_per_mpa)];
        for (k, (parameter, _)) in named.into_iter().enumerate() {
            if self.covariance[(k, k)].sqrt() > LOG_ERROR_MAX {
                return Err(FitError::NotDetermined { parameter });
            }
        }
        Ok(std::array::from_fn(|k| Parameter::from_log(named[k].1.ln(), self.covariance[(k, k)].sqrt(), self.t)))
    }
}

/// Two-sided 95 % point of Student's t; infinite without a degree of freedom.
fn student_t(degrees: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}
