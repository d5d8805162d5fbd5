//! Fits a whisker's own calibration to readings of a bench, by weighted least squares.
//!
//! Each strain without contact gives one modulus by eq. 32 and 33, hence the product E k2 of its pressure, and each
//! elongation gives G / (E k2). Neither tells E from k2. A contact does. Its strain per deflection depends on k2 alone
//! (eq. 31: level, slope over the place, and change with the pressure), and its force per deflection on both (eq. 9).
//! Without readings of contacts, E is given. A wrong E scales `c` and `a` inversely, which changes the stiffness of the
//! chamber relative to the cap and the body.
//!
//! The parameters are positive and are fitted as logarithms, so their intervals are asymmetric. Each has a wide
//! assumption before the readings ([`Unknown`]). If a parameter's interval stays as wide as that, it is not determined.

mod advice;
mod bench;
mod checks;
mod given;
mod least_squares;
mod reading;
mod start;
mod unknowns;

pub use advice::Advice;
pub use bench::{BenchFit, Scatter, fit_bench, student_t};
pub use given::{Gauge, Given};
pub use reading::{BenchContact, BenchReading, Kind, Place, Quantity};
pub use unknowns::{UNKNOWNS, Unknown};

use self::unknowns::Values;
use super::calibration::Calibration;
use super::geometry::Geometry;
use super::model::Formulation;
use super::model_error::ModelError;
use super::sensitivity::ContactOnChamber;
use crate::units::{Megapascal, Millimetre, Strain};

/// Least number of strains above zero pressure without contacts: one more than parameters.
const STRAINS_MIN: usize = 4;
/// Least number of distinct pressures for three parameters.
const PRESSURES_MIN: usize = 3;

/// One reading of a whisker under pressure, without contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationRow {
    /// Q: gauge pressure. At zero pressure, a strain shows the gauge's offset.
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
    fn from_log(log: f64, log_error: f64, t: f64) -> Self {
        let value = log.exp();
        Self {
            value,
            standard_error: value * log_error,
            low: (log - t * log_error).exp(),
            high: (log + t * log_error).exp(),
        }
    }

    fn at(unknown: Unknown, coordinate: f64, error: f64, t: f64) -> Self {
        let number = |coordinate| Values::in_unit(unknown, coordinate);
        let value = number(coordinate);
        let standard_error = match unknown {
            Unknown::GaugeOffset => number(error),
            Unknown::C | Unknown::A | Unknown::B | Unknown::Modulus | Unknown::ElongationGain | Unknown::GaugeGain => {
                value * error
            }
        };
        Self { value, standard_error, low: number(coordinate - t * error), high: number(coordinate + t * error) }
    }

    /// Upper over lower end of the interval, for a parameter above 0.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.high / self.low
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

/// A calibration that was fitted to readings without contact, with its uncertainty.
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
    /// Elongation gain in mm, if elongations were measured.
    pub elongation_gain_mm: Option<Parameter>,
    /// One residual for each row, in the order of the rows.
    pub residuals: Vec<RowResidual>,
    /// Standard deviation of ln k2 about the fit: the relative error of a strain reading.
    pub residual_sd: f64,
    /// Standard deviation of ln `delta_l` about the fit.
    pub elongation_residual_sd: Option<f64>,
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
    /// A force is below zero; the deflection of a contact is in its direction.
    #[error("row {row}: the force of a contact must not be below 0 N, not {value_n}")]
    ForceBelowZero {
        /// Number of the row, counted from 1.
        row: usize,
        /// The force in that row, N.
        value_n: f64,
    },
    /// The strains of the contacts are mostly below zero.
    #[error("the strains of the contacts are below 0: the gauge is reversed, or reads at the side of the contact")]
    GaugeReversed,
    /// A contact lies on the chamber, where the model is invalid.
    #[error("row {row}: {problem}")]
    OnChamber {
        /// Number of the row, counted from 1.
        row: usize,
        /// Place of the contact, and end of the chamber.
        problem: ContactOnChamber,
    },
    /// E is to be fitted without a reading of a contact.
    #[error("E must be given: strains and elongations without contact determine only its product with k2")]
    ModulusWithoutContacts,
    /// As many unknowns as readings.
    #[error("{readings} readings show no scatter about {unknowns} unknowns: repeat readings")]
    NoScatter {
        /// Number of readings that count.
        readings: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The readings do not show k2 falling toward a limit, or leave a parameter as wide as it was assumed.
    #[error("the readings do not determine {parameter}: add readings at more pressures from low to high")]
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
    let given = Given {
        geometry: *geometry,
        formulation: Formulation::default(),
        youngs_modulus_mpa: Some(youngs_modulus_mpa),
        fits_gauge_gain: false,
    };
    let (mut readings, mut row_of) = (Vec::new(), Vec::new());
    for (at, row) in rows.iter().enumerate() {
        let strain = row.axial_strain.map(|strain| (Quantity::AxialStrain, strain.ratio()));
        let elongation = row.elongation.map(|elongation| (Quantity::Elongation, elongation.mm()));
        for (quantity, value) in strain.into_iter().chain(elongation) {
            readings.push(BenchReading { pressure: row.pressure, pressure_sd_mpa: 0.0, quantity, value, sd: None });
            row_of.push(at + 1);
        }
    }
    let fit = fit_bench(&given, &readings).map_err(|error| error.of_rows(&row_of))?;
    let parameter = |unknown: Unknown| fit.parameter(unknown).copied();
    let [Some(c), Some(a), Some(b_per_mpa)] = [Unknown::C, Unknown::A, Unknown::B].map(parameter) else {
        return Err(FitError::NotDetermined { parameter: "k2" });
    };
    let mut residuals = vec![RowResidual { k2: None, k2_residual: None, elongation_residual: None }; rows.len()];
    for ((reading, residual), row) in readings.iter().zip(&fit.residuals).zip(row_of) {
        let (of, log) = (&mut residuals[row - 1], residual.map(f64::ln_1p));
        match reading.kind() {
            Some(Kind::Axial) => {
                of.k2_residual = log.map(|log| -log);
                of.k2 = log.map(|log| fit.model().k2(reading.pressure) * (-log).exp());
            }
            Some(Kind::Elongation) => of.elongation_residual = log,
            Some(Kind::Zero | Kind::ContactStrain | Kind::ContactForce) | None => {}
        }
    }
    Ok(Fit {
        calibration: fit.calibration,
        c,
        a,
        b_per_mpa,
        elongation_gain_mm: parameter(Unknown::ElongationGain),
        residuals,
        residual_sd: fit.scatter(Kind::Axial).unwrap_or(0.0),
        elongation_residual_sd: fit.scatter(Kind::Elongation),
    })
}

impl FitError {
    /// With the numbers of the rows that the readings came from.
    #[must_use]
    pub fn of_rows(self, row_of: &[usize]) -> Self {
        let of = |row: usize| row_of.get(row - 1).copied().unwrap_or(row);
        match self {
            Self::StrainNotPositive { row, value } => Self::StrainNotPositive { row: of(row), value },
            Self::ElongationNotPositive { row, value_mm } => Self::ElongationNotPositive { row: of(row), value_mm },
            Self::ForceBelowZero { row, value_n } => Self::ForceBelowZero { row: of(row), value_n },
            Self::OnChamber { row, problem } => Self::OnChamber { row: of(row), problem },
            Self::NothingAboveZeroPressure
            | Self::TooFewStrains { .. }
            | Self::TooFewPressures { .. }
            | Self::OneElongation
            | Self::GaugeReversed
            | Self::ModulusWithoutContacts
            | Self::NoScatter { .. }
            | Self::NotDetermined { .. }
            | Self::Model(_) => self,
        }
    }
}
