//! Fits a whisker's own calibration to readings under pressure without contact: eq. 32 and 33, then least squares.
//!
//! Each axial strain gives one modulus by eq. 33, hence one k2 = E2 / E. Readings have a roughly constant
//! *relative* error (of the gauge factor and the amplifier), so the logarithms are fitted with equal weights:
//! `ln k2 = ln(c + a exp(-b Q))`. On a linear scale the soft, high-pressure end, where setpoints are most sensitive to
//! errors, would hardly count. The elongation gain is the mean logarithm of `delta_l k2(Q) E / Q` over the rows
//! that have an elongation, with the fitted k2.
//!
//! E must be given: an axial strain determines only the product E k2. A wrong E scales `c` and `a` inversely, which
//! changes the stiffness of the chamber relative to the cap and the body.
//!
//! The parameters are positive and are fitted as logarithms, so their intervals are asymmetric.

mod curve;
mod readings;

use nalgebra::Matrix3;
use statrs::distribution::{ContinuousCDF, StudentsT};

use self::curve::{Curve, Point, fit_curve};
use self::readings::{MeanLog, log_elongation_gains, mean_log, measured_k2};
use super::calibration::Calibration;
use super::geometry::Geometry;
use super::model::{Formulation, Model};
use super::model_error::ModelError;
use crate::units::{Megapascal, Millimetre, Strain};

/// Least number of strains above zero pressure: one more than parameters.
const STRAINS_MIN: usize = 4;
/// Least number of distinct pressures for three parameters.
const PRESSURES_MIN: usize = 3;
/// Largest standard error of a parameter's logarithm that still counts as determined: a factor of 150.
const LOG_ERROR_MAX: f64 = 5.0;

/// One reading of a whisker under pressure, without contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationRow {
    /// Q: gauge pressure. Rows at zero pressure carry no information and are skipped.
    pub pressure: Megapascal,
    /// Strain of the gauge due to the pressure; above 0.
    pub axial_strain: Option<Strain>,
    /// `delta_l(l)`: elongation measured at the tip; above 0.
    pub elongation: Option<Millimetre>,
}

/// A fitted number with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Least-squares estimate.
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

/// Result of one row and its residuals: differences of logarithms, 0.01 is 1 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowResidual {
    /// k2 of this row by eq. 33, if it has a strain.
    pub k2: Option<f64>,
    /// ln k2 measured - fitted.
    pub k2_residual: Option<f64>,
    /// ln `delta_l` measured - fitted.
    pub elongation_residual: Option<f64>,
}

/// A fitted calibration with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The calibration for a model. Without elongations in the rows, its elongation gain is the geometry's, by eq.
    /// 24.
    pub calibration: Calibration,
    /// Limit of k2 at high pressure.
    pub c: Parameter,
    /// Excess of k2 at zero pressure.
    pub a: Parameter,
    /// Rate of softening per MPa.
    pub b_per_mpa: Parameter,
    /// Elongation gain in mm, if elongations were measured. Its interval excludes the uncertainty of k2.
    pub elongation_gain_mm: Option<Parameter>,
    /// One residual for each row, in the order of the rows.
    pub residuals: Vec<RowResidual>,
    /// Standard deviation of ln k2 about the fit: the relative error of a strain reading.
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

/// Why readings do not determine a calibration.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FitError {
    /// No row has a pressure above zero.
    #[error("no row has a pressure above zero")]
    NothingAboveZeroPressure,
    /// Too few strains above zero pressure.
    #[error("{given} rows with a strain above zero pressure: at least {STRAINS_MIN} are needed")]
    TooFewStrains {
        /// Number of such strains.
        given: usize,
    },
    /// Strains at too few distinct pressures.
    #[error("strains at {given} distinct pressures: at least {PRESSURES_MIN} are needed")]
    TooFewPressures {
        /// Number of distinct pressures.
        given: usize,
    },
    /// A single elongation, which gives no estimate of its scatter.
    #[error("one elongation only: none or at least two are needed")]
    OneElongation,
    /// A strain under pressure is not positive; a chamber under pressure stretches.
    #[error("row {row}: under pressure the axial strain must be above 0, not {value}")]
    StrainNotPositive {
        /// Number of the row, counted from 1.
        row: usize,
        /// The strain in that row, m/m.
        value: f64,
    },
    /// An elongation under pressure is not positive; a chamber under pressure stretches.
    #[error("row {row}: under pressure the elongation must be above 0 mm, not {value_mm}")]
    ElongationNotPositive {
        /// Number of the row, counted from 1.
        row: usize,
        /// The elongation in that row, mm.
        value_mm: f64,
    },
    /// The strains do not show k2 falling toward a limit.
    #[error("the strains do not determine {parameter}: add readings at more pressures from low to high")]
    NotDetermined {
        /// Name of the parameter that is not determined.
        parameter: &'static str,
    },
    /// The geometry, the modulus or the result is invalid for a model.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Fits a calibration to readings under pressure, without contact.
///
/// `youngs_modulus_mpa` is E of the rubber; the module's documentation explains why it must be given.
///
/// # Errors
/// The readings do not determine a calibration; the error names the failed condition.
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

/// The fitted curve with its scatter and uncertainty.
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
