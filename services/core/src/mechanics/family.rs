//! Sensitivity of a whisker's response to its calibration. A whisker's own calibration is learned with it, and the
//! interval of a prediction follows from it.
//!
//! Within the ten per cent by which rubbers differ, ln s is nearly linear in the parameters: the linear model
//! predicts the change with pressure of any such whisker to about 1 % of the sensitivity. A response measured at
//! one pressure fixes the level.

use super::calibration::Calibration;
use super::model::{Formulation, Model};
use super::profile::CONTACT_RATIOS;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Number of parameters that may differ: k2's c, a and b, the elongation gain G, and the formulation.
pub const FAMILY: usize = 5;
/// Index of the formulation parameter: 0 is the model's own formulation, 1 the other one.
pub const OTHER_FORMULATION: usize = 4;
/// Relative size of one step of a calibration parameter: the standard deviation of an error that is uniform within
/// 10 %.
pub const FAMILY_STEP: f64 = 0.057_735;

/// Variants of a model, each one step away in one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Family {
    relatives: [Model; FAMILY],
}

/// Changes of ln s: one row for each of [`CONTACT_RATIOS`], one column for each variant.
///
/// 0 where the contact would lie on the chamber, where the model is invalid.
pub type LogChanges = [[f64; FAMILY]; CONTACT_RATIOS.len()];

impl Model {
    /// The variants of this model.
    #[must_use]
    pub fn family(&self) -> Family {
        let own = *self.calibration();
        let more = 1.0 + FAMILY_STEP;
        let other = match self.formulation() {
            Formulation::Published => Formulation::Consistent,
            Formulation::Consistent => Formulation::Published,
        };
        let calibrated = |calibration: Calibration| self.relative(calibration, self.formulation());
        Family {
            relatives: [
                calibrated(Calibration { c: own.c * more, ..own }),
                calibrated(Calibration { a: own.a * more, ..own }),
                calibrated(Calibration { b_per_mpa: own.b_per_mpa * more, ..own }),
                calibrated(Calibration { elongation_gain_mm: own.elongation_gain_mm * more, ..own }),
                self.relative(own, other),
            ],
        }
    }

    /// ln s at [`CONTACT_RATIOS`]; `None` where the contact would lie on the chamber.
    #[must_use]
    pub fn log_sensitivities(&self, length: Millimetre, pressure: Megapascal) -> [Option<f64>; CONTACT_RATIOS.len()] {
        let morphology = self.morphology(pressure);
        CONTACT_RATIOS.map(|a| self.sensitivity_per_mm(ContactRatio::known(a), length, &morphology).ok().map(f64::ln))
    }
}

impl Family {
    /// Differences between ln s of each variant and of `model`.
    #[must_use]
    pub fn log_changes(&self, model: &Model, length: Millimetre, pressure: Megapascal) -> LogChanges {
        let own = model.log_sensitivities(length, pressure);
        let others = self.relatives.each_ref().map(|relative| relative.log_sensitivities(length, pressure));
        std::array::from_fn(|k| {
            std::array::from_fn(|i| match (others[i][k], own[k]) {
                (Some(other), Some(own)) => other - own,
                (_, _) => 0.0,
            })
        })
    }

    /// [`Self::log_changes`] at the tip only, for a whisker that is not cut into its chamber.
    #[must_use]
    pub fn log_changes_at_tip(&self, model: &Model, length: Millimetre, pressure: Megapascal) -> [f64; FAMILY] {
        let log = |one: &Model| {
            let per_mm = one.sensitivity_per_mm(ContactRatio::TIP, length, &one.morphology(pressure));
            per_mm.ok().map(f64::ln)
        };
        let own = log(model);
        self.relatives.each_ref().map(|relative| match (log(relative), own) {
            (Some(other), Some(own)) => other - own,
            (_, _) => 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Geometry;
    use super::*;

    /// For a plant with errors in all parameters, the change with pressure is predicted to 1.5 % of the
    /// sensitivity.
    #[test]
    fn property_the_change_with_the_pressure_is_nearly_linear_over_ten_per_cent() {
        let model = Model::nguyen_2021(Formulation::Published);
        let (family, built_in, length) = (model.family(), Calibration::nguyen_2021(), Millimetre::known(67.0));
        for (c, a, b, g) in [(1.1, 0.9, 1.1, 1.1), (0.9, 0.9, 1.1, 1.1), (1.1, 1.1, 0.9, 0.9), (0.9, 1.1, 0.9, 1.1)] {
            for formulation in [Formulation::Published, Formulation::Consistent] {
                let calibration = Calibration {
                    c: c * built_in.c,
                    a: a * built_in.a,
                    b_per_mpa: b * built_in.b_per_mpa,
                    elongation_gain_mm: g * built_in.elongation_gain_mm,
                    ..built_in
                };
                let plant = Model::new(Geometry::nguyen_2021(), calibration, formulation).unwrap();
                let steps = [c, a, b, g].map(|factor: f64| (factor - 1.0) / FAMILY_STEP);
                let other = f64::from(u8::from(formulation == Formulation::Consistent));
                let weights = [steps[0], steps[1], steps[2], steps[3], other];
                let deviation = |pressure: f64, k: usize| {
                    let at = |model: &Model| model.log_sensitivities(length, Megapascal::known(pressure))[k].unwrap();
                    at(&plant) - at(&model)
                };
                let linear = |pressure: f64, k: usize| -> f64 {
                    let changes = family.log_changes(&model, length, Megapascal::known(pressure))[k];
                    changes.iter().zip(weights).map(|(change, weight)| change * weight).sum()
                };
                for pressure in [0.02, 0.05, 0.15, 0.2] {
                    for k in [0, 5, 11] {
                        let estimate = linear(pressure, k) - linear(0.1, k);
                        let true_change = deviation(pressure, k) - deviation(0.1, k);
                        assert!(
                            (estimate - true_change).abs() < 0.015,
                            "{weights:?} {pressure} {k}: {estimate} {true_change}"
                        );
                    }
                }
            }
        }
    }
}
