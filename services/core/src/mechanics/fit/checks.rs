//! Conditions on readings and on the fitted curve.

use super::given::Given;
use super::reading::{BenchReading, Kind, Quantity};
use super::{FitError, PRESSURES_MIN, STRAINS_MIN};
use crate::mechanics::model::Model;
use crate::mechanics::model_error::ModelError;
use crate::units::Megapascal;

/// Conditions that need no fit.
pub(super) fn readings(given: &Given, readings: &[BenchReading]) -> Result<(), FitError> {
    if let Some(value) = given.youngs_modulus_mpa.filter(|value| !(value.is_finite() && *value > 0.0)) {
        return Err(ModelError::NotPositive { name: "Young's modulus", value }.into());
    }
    for (at, reading) in readings.iter().enumerate() {
        let (row, value) = (at + 1, reading.value);
        match reading.kind() {
            Some(Kind::Axial) if value <= 0.0 => return Err(FitError::StrainNotPositive { row, value }),
            Some(Kind::Elongation) if value <= 0.0 => {
                return Err(FitError::ElongationNotPositive { row, value_mm: value });
            }
            Some(Kind::ContactForce) if value < 0.0 => return Err(FitError::ForceBelowZero { row, value_n: value }),
            Some(Kind::Zero | Kind::Axial | Kind::Elongation | Kind::ContactStrain | Kind::ContactForce) | None => {}
        }
    }
    let of_kind = |kind: Kind| readings.iter().filter(move |reading| reading.kind() == Some(kind));
    if of_kind(Kind::ContactStrain).map(|reading| reading.value).sum::<f64>() < 0.0 {
        return Err(FitError::GaugeReversed);
    }
    if of_kind(Kind::Elongation).filter(|reading| !reading.has_sd()).count() == 1 {
        return Err(FitError::OneElongation);
    }
    let has_contacts = readings.iter().any(|reading| reading.contact().is_some());
    if !has_contacts {
        if given.youngs_modulus_mpa.is_none() {
            return Err(FitError::ModulusWithoutContacts);
        }
        if readings.iter().all(|reading| reading.pressure <= Megapascal::ZERO) {
            return Err(FitError::NothingAboveZeroPressure);
        }
        let strains = of_kind(Kind::Axial).count();
        if strains < STRAINS_MIN {
            return Err(FitError::TooFewStrains { given: strains });
        }
    }
    let shows_k2 = |reading: &&BenchReading| match reading.quantity {
        Quantity::AxialStrain => reading.kind() == Some(Kind::Axial),
        Quantity::Elongation => has_contacts && reading.kind().is_some(),
        Quantity::ContactStrain(_) | Quantity::ContactForce(_) => true,
    };
    let mut pressures: Vec<f64> = readings.iter().filter(shows_k2).map(|reading| reading.pressure.mpa()).collect();
    pressures.sort_by(f64::total_cmp);
    pressures.dedup();
    if pressures.len() < PRESSURES_MIN {
        return Err(FitError::TooFewPressures { given: pressures.len() });
    }
    Ok(())
}

/// The curve k2(Q) must fall from the lowest pressure on.
pub(super) fn falls(model: &Model, readings: &[BenchReading], least_share: f64) -> Result<(), FitError> {
    let lowest_mpa = readings
        .iter()
        .filter(|reading| reading.kind().is_some_and(|kind| kind != Kind::Zero))
        .map(|reading| reading.pressure.mpa())
        .fold(f64::INFINITY, f64::min);
    let calibration = model.calibration();
    if calibration.k2(lowest_mpa) < (1.0 + least_share) * calibration.c {
        Err(FitError::NotDetermined { parameter: "a" })
    } else {
        Ok(())
    }
}

/// All contacts must lie beyond the chamber.
pub(super) fn places(model: &Model, readings: &[BenchReading]) -> Result<(), FitError> {
    for (at, reading) in readings.iter().enumerate() {
        if let Some(contact) = reading.contact() {
            let on_chamber = |problem| FitError::OnChamber { row: at + 1, problem };
            contact.check(model, reading.pressure).map_err(on_chamber)?;
        }
    }
    Ok(())
}
