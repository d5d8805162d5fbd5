//! The fit of a bench's readings: values, intervals, and the pairs of unknowns that the readings hardly tell apart.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::given::{Gauge, Given};
use super::least_squares::{Problem, Scattered, group_of};
use super::reading::{BenchReading, Kind};
use super::unknowns::{UNKNOWNS, Unknown, Values};
use super::{FitError, Parameter, checks};
use crate::mechanics::calibration::Calibration;
use crate::mechanics::model::Model;
use crate::units::Megapascal;

/// Least fall of k2, as a share of its limit.
const LEAST_FALL: f64 = 1e-3;
/// Share of the assumed standard deviation at which the assumption carries as much as the readings: 1 / sqrt 2.
const ASSUMED_SHARE_MAX: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Correlation from which two unknowns count as hardly distinct.
const HARDLY_DISTINCT: f64 = 0.98;

/// The scatter of one kind of reading about the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Kind of the readings.
    pub kind: Kind,
    /// Whether they have stated standard deviations.
    pub stated: bool,
    /// Number of readings.
    pub readings: usize,
    /// With stated standard deviations their factor, at least 1. Otherwise the standard deviation as a ratio, and of a
    /// gauge at zero pressure in m/m.
    pub sd: f64,
}

/// A calibration that was fitted to readings of a bench, with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchFit {
    /// The calibration for a model.
    pub calibration: Calibration,
    /// The gauge of the bench.
    pub gauge: Gauge,
    /// The fitted unknowns, in the order of [`UNKNOWNS`]. The others are given.
    pub fitted: Vec<(Unknown, Parameter)>,
    /// Scatter by kind of reading.
    pub scatters: Vec<Scatter>,
    /// Relative residual of each reading, `(measured - fitted) / fitted`; `None` for a reading that does not count, and
    /// where the fitted number is 0.
    pub residuals: Vec<Option<f64>>,
    pub(super) model: Model,
    pub(super) values: Values,
    pub(super) free: Vec<Unknown>,
    pub(super) groups: Vec<Scattered>,
    pub(super) assumed: DMatrix<f64>,
    /// Nearest and farthest contact of the readings, mm from the base.
    pub(super) contacts_mm: Option<[f64; 2]>,
    covariance: DMatrix<f64>,
}

impl BenchFit {
    /// A fitted unknown; `None` if it is given.
    #[must_use]
    pub fn parameter(&self, unknown: Unknown) -> Option<&Parameter> {
        self.fitted.iter().find(|(of, _)| *of == unknown).map(|(_, parameter)| parameter)
    }

    /// The model of the fitted whisker.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// k2 of the fit at a pressure with its 95 % confidence band.
    #[must_use]
    pub fn k2(&self, pressure: Megapascal) -> Parameter {
        let k2 = self.model.k2(pressure);
        let falling = k2 - self.calibration.c;
        let slope = |unknown: &Unknown| match unknown {
            Unknown::C => self.calibration.c / k2,
            Unknown::A => falling / k2,
            Unknown::B => -falling * self.calibration.b_per_mpa * pressure.mpa() / k2,
            Unknown::Modulus | Unknown::ElongationGain | Unknown::GaugeGain | Unknown::GaugeOffset => 0.0,
        };
        let gradient = DVector::from_iterator(self.free.len(), self.free.iter().map(slope));
        let (error, t) = spread(&self.covariance, &self.groups, &gradient);
        Parameter::from_log(k2.ln(), error, t)
    }

    /// Scatter of the readings of a kind that have no stated standard deviations.
    #[must_use]
    pub fn scatter(&self, kind: Kind) -> Option<f64> {
        self.scatters.iter().find(|one| one.kind == kind && !one.stated).map(|one| one.sd)
    }

    /// Pairs of unknowns that the readings hardly tell apart, with their correlation.
    #[must_use]
    pub fn hardly_distinct(&self) -> Vec<(Unknown, Unknown, f64)> {
        let correlations = self.correlations();
        let pairs = (0..self.free.len()).flat_map(|row| (0..row).map(move |column| (column, row)));
        pairs
            .map(|(one, other)| (self.free[one], self.free[other], correlations[(other, one)]))
            .filter(|(.., correlation)| correlation.abs() > HARDLY_DISTINCT)
            .collect()
    }

    /// Condition number of the unknowns' correlations: 1 if the readings tell all of them apart, without limit if a
    /// combination of them changes no reading.
    #[must_use]
    pub fn condition(&self) -> f64 {
        let values = self.correlations().symmetric_eigenvalues();
        values.max() / values.min().max(f64::MIN_POSITIVE)
    }

    fn correlations(&self) -> DMatrix<f64> {
        let sd = self.covariance.diagonal().map(f64::sqrt);
        DMatrix::from_fn(self.free.len(), self.free.len(), |row, column| {
            self.covariance[(row, column)] / (sd[row] * sd[column])
        })
    }
}

/// Fits a calibration to readings of a bench.
///
/// The unknowns are c, a and b of k2; E, if it is not given; G, if elongations were read (otherwise it is the geometry's,
/// by eq. 24); the gauge's gain on request; and its offset, if it was read at zero pressure at least twice, or with a
/// standard deviation.
///
/// # Errors
/// The readings do not determine the unknowns; the error names the failed condition. Rows count the readings from 1.
pub fn fit_bench(given: &Given, readings: &[BenchReading]) -> Result<BenchFit, FitError> {
    given.geometry.check()?;
    checks::readings(given, readings)?;
    let free = free_unknowns(given, readings);
    let mut values = Values::assumed(&given.geometry);
    if let Some(modulus_mpa) = given.youngs_modulus_mpa {
        values = values.with_modulus(modulus_mpa);
    }
    let base = Model::precompute(given.geometry, values.calibration(), given.formulation);
    let counted: Vec<BenchReading> = readings.iter().filter(|reading| counts(reading, &free)).copied().collect();
    let problem = Problem { base, readings: &counted, free, assumed: values };
    let starts = problem.starts(values).ok_or(FitError::NotDetermined { parameter: "a" })?;
    if counted.len() <= problem.free.len() {
        return Err(FitError::NoScatter { readings: counted.len(), unknowns: problem.free.len() });
    }
    let solved = problem.solve(&starts).ok_or(FitError::NotDetermined { parameter: "b" })?;
    let calibration = solved.values.calibration();
    let model = Model::new(given.geometry, calibration, given.formulation)?;
    checks::falls(&model, readings, LEAST_FALL)?;
    checks::places(&model, readings)?;
    let assumed = problem.assumed_information();
    let covariance = information(&solved.groups, &assumed)
        .try_inverse()
        .filter(|covariance| covariance.iter().all(|value| value.is_finite()))
        .ok_or(FitError::NotDetermined { parameter: "b" })?;
    let mut fitted = Vec::new();
    for (at, unknown) in problem.free.iter().enumerate() {
        if covariance[(at, at)].sqrt() > ASSUMED_SHARE_MAX * unknown.assumed_sd() {
            return Err(FitError::NotDetermined { parameter: unknown.name() });
        }
        let along = DVector::from_fn(problem.free.len(), |row, _| f64::from(u8::from(row == at)));
        let (error, t) = spread(&covariance, &solved.groups, &along);
        fitted.push((*unknown, Parameter::at(*unknown, solved.values.of(*unknown), error, t)));
    }
    let gauge = solved.values.gauge();
    let residual = |reading: &BenchReading| {
        let modelled = reading.modelled(&model, gauge);
        group_of(reading).filter(|_| modelled != 0.0).map(|_| reading.value / modelled - 1.0)
    };
    let scatter = |group: &Scattered| Scatter {
        kind: group.group.kind,
        stated: group.group.stated,
        readings: group.readings,
        sd: group.scatter,
    };
    let distance_mm =
        |reading: &BenchReading| Some(reading.contact()?.distance_mm(model.elongation(reading.pressure).mm()));
    let distances_mm = || readings.iter().filter_map(distance_mm);
    let contacts_mm = distances_mm().reduce(f64::min).zip(distances_mm().reduce(f64::max)).map(<[f64; 2]>::from);
    Ok(BenchFit {
        contacts_mm,
        calibration,
        gauge,
        fitted,
        scatters: solved.groups.iter().map(scatter).collect(),
        residuals: readings.iter().map(residual).collect(),
        values: solved.values,
        free: problem.free,
        groups: solved.groups,
        model,
        assumed,
        covariance,
    })
}

fn free_unknowns(given: &Given, readings: &[BenchReading]) -> Vec<Unknown> {
    let of_kind = |kind: Kind| readings.iter().filter(move |reading| reading.kind() == Some(kind));
    let zero_sd = of_kind(Kind::Zero).any(BenchReading::has_sd);
    let is_free = |unknown: &Unknown| match unknown {
        Unknown::C | Unknown::A | Unknown::B => true,
        Unknown::Modulus => given.youngs_modulus_mpa.is_none(),
        Unknown::ElongationGain => of_kind(Kind::Elongation).next().is_some(),
        Unknown::GaugeGain => given.fits_gauge_gain,
        Unknown::GaugeOffset => zero_sd || of_kind(Kind::Zero).count() > 1,
    };
    UNKNOWNS.into_iter().filter(is_free).collect()
}

/// A single reading at zero pressure shows neither an offset nor its error.
fn counts(reading: &BenchReading, free: &[Unknown]) -> bool {
    reading.kind().is_some_and(|kind| kind != Kind::Zero || free.contains(&Unknown::GaugeOffset))
}

/// Precision of the free unknowns by all readings and the assumptions.
pub(super) fn information(groups: &[Scattered], assumed: &DMatrix<f64>) -> DMatrix<f64> {
    groups.iter().fold(assumed.clone(), |sum, group| sum + &group.information)
}

/// Standard error of a combination of unknowns, and Student's t for 95 %.
///
/// The degrees of freedom are Satterthwaite's: those of the groups, by their shares of the variance.
pub(super) fn spread(covariance: &DMatrix<f64>, groups: &[Scattered], along: &DVector<f64>) -> (f64, f64) {
    let reach = covariance * along;
    let variance = along.dot(&reach);
    let uncertain: f64 =
        groups.iter().map(|group| (reach.dot(&(&group.information * &reach))).powi(2) / group.degrees).sum();
    let degrees = if uncertain > 0.0 { (variance.powi(2) / uncertain).max(1.0) } else { f64::INFINITY };
    (variance.max(0.0).sqrt(), student_t(degrees))
}

/// Two-sided 95 % point of Student's t, for degrees of freedom above 0.
#[must_use]
pub fn student_t(degrees: f64) -> f64 {
    // Above, the t distribution is the normal one to the third digit.
    StudentsT::new(0.0, 1.0, degrees.min(1e4)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}
