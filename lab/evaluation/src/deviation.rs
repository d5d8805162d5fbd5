//! True whiskers that deviate from the model that the core assumes.

use vibrissa_core::mechanics::{Calibration, Formulation, Model};

/// The calibration with each of its four uncertain parameters as `deviate` changes it.
pub(crate) fn deviating(calibration: &Calibration, mut deviate: impl FnMut(f64) -> f64) -> Calibration {
    Calibration {
        c: deviate(calibration.c),
        a: deviate(calibration.a),
        b_per_mpa: deviate(calibration.b_per_mpa),
        elongation_gain_mm: deviate(calibration.elongation_gain_mm),
        ..*calibration
    }
}

/// A whisker with the dimensions of another one, and its own calibration; the other one if that is invalid.
pub(crate) fn with_calibration(designed: &Model, calibration: Calibration, formulation: Formulation) -> Model {
    Model::new(*designed.geometry(), calibration, formulation).unwrap_or_else(|_| designed.clone())
}
