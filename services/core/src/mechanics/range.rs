//! How far a compensation reaches: which pressures count, and which lengths they cover.

use super::model::Model;
use super::root;
use super::setpoint::Target;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Grid of a search over the pressure: 5 kPa over the examined range.
pub(super) const CELLS: u32 = 40;
/// To what the pressure of a greatest or least value is found, in MPa.
pub(super) const TOLERANCE_MPA: f64 = 1e-9;
/// A step by which a curve shows whether it still rises, in MPa.
const STEP_MPA: f64 = 1e-6;

/// Where `f` is greatest between two pressures, if it rises to one peak: mostly at the upper end, where
/// two values decide.
///
/// A tip's sensitivity rises with the pressure because the wall softens. It also falls, because the
/// chamber's growing compliance takes up more of the deflection; for short whiskers (nguyen-2021: below
/// 52 mm) this wins before 0.2 MPa is reached. Beyond the peak, more pressure is of no use.
pub(super) fn peak_mpa(low_mpa: f64, high_mpa: f64, f: impl Fn(f64) -> f64) -> f64 {
    let near_high_mpa = high_mpa - STEP_MPA;
    if near_high_mpa <= low_mpa || f(high_mpa) >= f(near_high_mpa) {
        high_mpa
    } else {
        root::least(low_mpa, high_mpa, CELLS, TOLERANCE_MPA, |pressure_mpa| -f(pressure_mpa))
    }
}

/// Shortest and longest compensator of a model that can stand in for a target between two pressures.
///
/// At `pressure_min` the shortest is as sensitive at the tip as the target; the longest is so at
/// `pressure_max`, or where it is most sensitive below that. Where the model has no such length, the
/// nearest it has (just beyond the chamber, or [`Model::longest`]).
#[must_use]
pub fn compensable_range(
    model: &Model,
    target: Target,
    pressure_min: Megapascal,
    pressure_max: Megapascal,
) -> (Millimetre, Millimetre) {
    if model.check_length(target.length).is_err() {
        // A target cut into its chamber: nothing but itself is like it.
        return (target.length, target.length);
    }
    let wanted_per_mm = model.tip_sensitivity_per_mm(target.length, &model.morphology(target.pressure));
    let length_at = |pressure_mpa: f64| {
        let morphology = model.morphology(Megapascal::known(pressure_mpa));
        let found = model.length_from_sensitivity(wanted_per_mm, ContactRatio::TIP, &morphology);
        found.unwrap_or_else(|error| error.nearest().unwrap_or(target.length))
    };
    let (low_mpa, high_mpa) = (pressure_min.mpa(), pressure_max.mpa().max(pressure_min.mpa()));
    let peak_mpa = peak_mpa(low_mpa, high_mpa, |pressure_mpa| length_at(pressure_mpa).mm());
    (length_at(low_mpa), length_at(peak_mpa))
}
