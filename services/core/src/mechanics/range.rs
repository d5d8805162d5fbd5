//! Reach of a compensation: effective pressures, and the lengths that they cover.

use super::model::Model;
use super::root;
use super::setpoint::Target;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Shortest and longest compensator of a model that can serve a target between two pressures.
///
/// At `pressure_min` the shortest has the target's sensitivity at the tip. The longest has it at `pressure_max`, or
/// at the pressure of its peak sensitivity below that. If the model has no such length, the nearest valid one is
/// returned (just beyond the chamber, or [`Model::longest`]).
#[must_use]
pub fn compensable_range(
    model: &Model,
    target: Target,
    pressure_min: Megapascal,
    pressure_max: Megapascal,
) -> (Millimetre, Millimetre) {
    if model.check_length(target.length).is_err() {
        // No other length can match a target that is cut into its chamber.
        return (target.length, target.length);
    }
    let wanted_per_mm = model.tip_sensitivity_per_mm(target.length, &model.morphology(target.pressure));
    let length_at = |pressure_mpa: f64| {
        let morphology = model.morphology(Megapascal::known(pressure_mpa));
        let found = model.length_from_sensitivity(wanted_per_mm, ContactRatio::TIP, &morphology);
        found.unwrap_or_else(|error| error.nearest().unwrap_or(target.length))
    };
    let (low_mpa, high_mpa) = (pressure_min.mpa(), pressure_max.mpa().max(pressure_min.mpa()));
    let peak_mpa = root::peak_mpa(low_mpa, high_mpa, |pressure_mpa| length_at(pressure_mpa).mm());
    (length_at(low_mpa), length_at(peak_mpa))
}
