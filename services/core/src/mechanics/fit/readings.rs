//! Converts the rows of a calibration: one k2 for each strain (eq. 33), one gain for each elongation (eq. 24).

use super::curve::{Curve, Point};
use super::{CalibrationRow, FitError, PRESSURES_MIN, STRAINS_MIN};
use crate::mechanics::geometry::Geometry;
use crate::units::Megapascal;

/// ln k2 by eq. 33 for each row that has a strain above zero pressure.
pub(super) fn measured_k2(
    geometry: &Geometry,
    youngs_modulus_mpa: f64,
    rows: &[CalibrationRow],
) -> Result<Vec<Option<Point>>, FitError> {
    let mut points = Vec::with_capacity(rows.len());
    for (index, row) in rows.iter().enumerate() {
        let strain = row.axial_strain.filter(|_| row.pressure > Megapascal::ZERO);
        if let Some(strain) = strain.filter(|strain| strain.ratio() <= 0.0) {
            return Err(FitError::StrainNotPositive { row: index + 1, value: strain.ratio() });
        }
        points.push(strain.map(|strain| {
            let pressure_mpa = row.pressure.mpa();
            let e2_mpa = geometry.axial_gain() * pressure_mpa / strain.ratio();
            Point { pressure_mpa, log_k2: (e2_mpa / youngs_modulus_mpa).ln() }
        }));
    }
    if rows.iter().all(|row| row.pressure <= Megapascal::ZERO) {
        return Err(FitError::NothingAboveZeroPressure);
    }
    let mut pressures: Vec<f64> = points.iter().flatten().map(|point| point.pressure_mpa).collect();
    if pressures.len() < STRAINS_MIN {
        return Err(FitError::TooFewStrains { given: pressures.len() });
    }
    pressures.sort_by(f64::total_cmp);
    pressures.dedup();
    if pressures.len() < PRESSURES_MIN {
        return Err(FitError::TooFewPressures { given: pressures.len() });
    }
    Ok(points)
}

/// ln G for each row that has an elongation above zero pressure.
pub(super) fn log_elongation_gains(
    curve: &Curve,
    youngs_modulus_mpa: f64,
    rows: &[CalibrationRow],
) -> Result<Vec<Option<f64>>, FitError> {
    rows.iter()
        .enumerate()
        .map(|(index, row)| {
            let Some(elongation) = row.elongation.filter(|_| row.pressure > Megapascal::ZERO) else {
                return Ok(None);
            };
            if elongation.mm() <= 0.0 {
                return Err(FitError::ElongationNotPositive { row: index + 1, value_mm: elongation.mm() });
            }
            let pressure_mpa = row.pressure.mpa();
            Ok(Some((elongation.mm() * curve.k2(pressure_mpa) * youngs_modulus_mpa / pressure_mpa).ln()))
        })
        .collect()
}

/// Mean and spread of logarithms.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeanLog {
    pub(super) mean: f64,
    pub(super) sd: f64,
    pub(super) count: f64,
}

/// `None` without any value; a single value has no scatter and is an error.
pub(super) fn mean_log(logs: &[Option<f64>]) -> Result<Option<MeanLog>, FitError> {
    let known: Vec<f64> = logs.iter().flatten().copied().collect();
    match known.len() {
        0 => Ok(None),
        1 => Err(FitError::OneElongation),
        n => {
            let count = n as f64;
            let mean = known.iter().sum::<f64>() / count;
            let sum_of_squares: f64 = known.iter().map(|log| (log - mean).powi(2)).sum();
            Ok(Some(MeanLog { mean, sd: (sum_of_squares / (count - 1.0)).sqrt(), count }))
        }
    }
}
