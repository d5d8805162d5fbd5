//! Sensitivity of a whisker's response to its calibration. A whisker's own calibration is learned with it, and the
//! interval of a prediction follows from it.
//!
//! Within the ten per cent by which rubbers differ, ln s is nearly linear in the parameters: the linear model
//! predicts the change with pressure of any such whisker to about 1 % of the sensitivity. A response measured at
//! one pressure fixes the level.

use super::calibration::Calibration;
use super::model::{Formulation, Model};
use super::profile::{CONTACT_RATIOS, Offset};
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Number of parameters that may differ: k2's c, a and b, the elongation gain G, the formulation, and the rubber's modulus.
pub const FAMILY: usize = 6;
/// Index of the formulation parameter: 0 is the model's own formulation, 1 the other one.
pub const OTHER_FORMULATION: usize = 4;
/// Index of the natural logarithm of the rubber's modulus E over the model's. E2 stays as it is at each pressure.
pub const LOG_MODULUS: usize = 5;
/// Largest of these logarithms: silicones have 0.4 to 2.7 times the modulus of the paper's.
const LOG_MODULUS_MAX: f64 = 1.2;
/// Least step in this logarithm, from which on the quotient is exact enough.
const LOG_MODULUS_STEP: f64 = 0.02;
/// Relative size of one step of a calibration parameter: the standard deviation of an error that is uniform within
/// 10 %.
pub const FAMILY_STEP: f64 = 0.057_735;

/// Variants of a model, each one step away in one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Family {
    relatives: [Model; FAMILY],
    /// Change of the logarithm of the modulus to its variant.
    log_modulus: f64,
}

/// Changes of ln s: one row for each of [`CONTACT_RATIOS`], one column for each variant.
///
/// 0 where the contact would lie on the chamber, where the model is invalid.
pub type LogChanges = [[f64; FAMILY]; CONTACT_RATIOS.len()];

impl Model {
    /// The variants of this model. That of the rubber has this logarithm of its modulus over the model's, because the
    /// response is linear over 10 % and rubbers differ by a factor of two.
    #[must_use]
    pub fn family(&self, log_modulus: f64) -> Family {
        let log_modulus = if log_modulus.abs() < LOG_MODULUS_STEP { LOG_MODULUS_STEP } else { log_modulus };
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
                self.with_modulus(log_modulus),
            ],
            log_modulus,
        }
    }

    /// The same chamber with a cap and a body of another modulus, whose ratio has this natural logarithm.
    fn with_modulus(&self, log_modulus: f64) -> Self {
        let (own, factor) = (*self.calibration(), log_modulus.exp());
        let youngs_modulus_mpa = own.youngs_modulus_mpa * factor;
        self.relative(
            Calibration { c: own.c / factor, a: own.a / factor, youngs_modulus_mpa, ..own },
            self.formulation(),
        )
    }

    /// The modulus whose whisker differs from the model by this slope over the contact ratio, as the natural logarithm of
    /// its ratio to the model's, and the change of the slope with it. Nothing else is known that makes such slopes.
    #[must_use]
    pub fn log_modulus(&self, slope: f64, length: Millimetre, pressure: Megapascal) -> (f64, f64) {
        let own = self.log_sensitivities(length, pressure);
        let slope_of = |log_modulus: f64| {
            let other = self.with_modulus(log_modulus).log_sensitivities(length, pressure);
            let known =
                || (0..own.len()).filter_map(|k| Some((CONTACT_RATIOS[k] - Offset::CENTRE, other[k]? - own[k]?)));
            let (sum, squares) =
                known().fold((0.0, 0.0), |(sum, squares), (off, by)| (sum + off * by, squares + off * off));
            if squares > 0.0 { sum / squares } else { 0.0 }
        };
        let per_log = slope_of(LOG_MODULUS_MAX / 4.0) / (LOG_MODULUS_MAX / 4.0);
        if per_log == 0.0 {
            return (0.0, 0.0);
        }
        let bound = |log: f64| log.clamp(-LOG_MODULUS_MAX, LOG_MODULUS_MAX);
        let first = bound(slope / per_log);
        (bound(first + (slope - slope_of(first)) / per_log), per_log)
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
                (Some(other), Some(own)) => (other - own) / self.step(i),
                (_, _) => 0.0,
            })
        })
    }

    /// Size of the step to a variant, in the unit of its parameter's weight.
    fn step(&self, index: usize) -> f64 {
        if index == LOG_MODULUS { self.log_modulus } else { 1.0 }
    }

    /// [`Self::log_changes`] at the tip only, for a whisker that is not cut into its chamber.
    #[must_use]
    pub fn log_changes_at_tip(&self, model: &Model, length: Millimetre, pressure: Megapascal) -> [f64; FAMILY] {
        let log = |one: &Model| {
            let per_mm = one.sensitivity_per_mm(ContactRatio::TIP, length, &one.morphology(pressure));
            per_mm.ok().map(f64::ln)
        };
        let own = log(model);
        std::array::from_fn(|i| match (log(&self.relatives[i]), own) {
            (Some(other), Some(own)) => (other - own) / self.step(i),
            (_, _) => 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Geometry;
    use super::*;

    #[test]
    fn property_the_slope_of_an_offset_tells_the_modulus_of_the_rubber() {
        let model = Model::nguyen_2021(Formulation::Published);
        let (length, pressure) = (Millimetre::known(70.0), Megapascal::known(0.1));
        let logs = |one: &Model| one.log_sensitivities(length, pressure).map(Option::unwrap);
        for log_modulus in [-0.8, -0.3, 0.0, 0.3, 0.8] {
            let own = logs(&model);
            let others = logs(&model.with_modulus(log_modulus));
            let off = CONTACT_RATIOS.map(|a| a - Offset::CENTRE);
            let sum: f64 = (0..own.len()).map(|k| off[k] * (others[k] - own[k])).sum();
            let (told, _) = model.log_modulus(sum / off.iter().map(|off| off * off).sum::<f64>(), length, pressure);
            assert!((told - log_modulus).abs() < 0.05, "{log_modulus}: {told}");
        }
    }

    /// For a plant with errors in all parameters, the change with pressure is predicted to 1.5 % of the
    /// sensitivity.
    #[test]
    fn property_the_change_with_the_pressure_is_nearly_linear_over_ten_per_cent() {
        let model = Model::nguyen_2021(Formulation::Published);
        let (family, built_in, length) = (model.family(0.0), Calibration::nguyen_2021(), Millimetre::known(67.0));
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
                let weights = [steps[0], steps[1], steps[2], steps[3], other, 0.0];
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
