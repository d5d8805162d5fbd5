//! A turn of the contacts to the plane of the gauge changes all readings by one factor, and a cut by nearly one.

use vibrissa_core::mechanics::{Calibration, Formulation, Geometry, Model};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

const WHOLE_MM: f64 = 70.0;
/// Contact ratios in hundredths.
const RATIOS: std::ops::RangeInclusive<u8> = 45..=100;

/// Mean and standard deviation over the contact ratio of the change of log sensitivity by a cut.
fn change(model: &Model, pressure_mpa: f64, cut_mm: f64) -> (f64, f64) {
    let morphology = model.morphology(Megapascal::known(pressure_mpa));
    let log_per_mm = |ratio: f64, length_mm: f64| {
        let (ratio, length) = (ContactRatio::known(ratio), Millimetre::known(length_mm));
        model.sensitivity_per_mm(ratio, length, &morphology).unwrap().ln()
    };
    let ratios = RATIOS.map(|hundredths| f64::from(hundredths) / 100.0);
    let changes: Vec<f64> =
        ratios.map(|ratio| log_per_mm(ratio, WHOLE_MM - cut_mm) - log_per_mm(ratio, WHOLE_MM)).collect();
    let mean = changes.iter().sum::<f64>() / changes.len() as f64;
    let square = changes.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / changes.len() as f64;
    (mean, square.sqrt())
}

/// So hundreds of contacts all over the whisker are needed to tell a turn from a small cut (docs/certainty.md).
#[test]
fn property_a_cut_changes_readings_all_over_a_whisker_by_nearly_one_factor() {
    for formulation in [Formulation::Published, Formulation::Consistent] {
        let model = Model::new(Geometry::nguyen_2021(), Calibration::nguyen_2021(), formulation).unwrap();
        for pressure_mpa in [0.0, 0.1, 0.2] {
            for cut_mm in [2.0, 5.0, 8.0] {
                let (mean, sd) = change(&model, pressure_mpa, cut_mm);
                let share = sd / mean;
                assert!((0.05..0.08).contains(&share), "{formulation:?}, {pressure_mpa} MPa, {cut_mm} mm: {share}");
            }
        }
    }
}

/// Standard deviation over the contact ratio of the difference between two changes that have the same mean of 5 %.
fn apart(one: &[f64], other: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let scaled = |values: &[f64]| values.iter().map(|value| 0.05 * value / mean(values)).collect::<Vec<f64>>();
    let off: Vec<f64> = scaled(one).iter().zip(scaled(other)).map(|(one, other)| one - other).collect();
    mean(&off.iter().map(|one| (one - mean(&off)).powi(2)).collect::<Vec<f64>>()).sqrt()
}

/// So the alarm MODEL_MISFIT names no probabilities (docs/runbooks/VibrissaModelMisfit.md).
#[test]
fn property_changes_of_one_whisker_with_the_same_mean_differ_little_in_shape() {
    let logs = |calibration: Calibration, length_mm: f64, pressure_mpa: f64, off: f64| {
        let model = Model::new(Geometry::nguyen_2021(), calibration, Formulation::Published).unwrap();
        let morphology = model.morphology(Megapascal::known(pressure_mpa));
        let per_mm = |hundredths: u8| {
            let (ratio, length) =
                (ContactRatio::known((f64::from(hundredths) / 100.0 + off).min(1.0)), Millimetre::known(length_mm));
            model.sensitivity_per_mm(ratio, length, &morphology).unwrap().ln()
        };
        // A place that is off must not end at the tip.
        (45..=98).map(per_mm).collect::<Vec<f64>>()
    };
    let own = Calibration::nguyen_2021();
    let less = |factor: f64| Calibration { c: own.c / factor, a: own.a / factor, ..own };
    let rubber = Calibration { youngs_modulus_mpa: 1.1 * own.youngs_modulus_mpa, ..less(1.1) };
    let before = logs(own, WHOLE_MM, 0.1, 0.0);
    let change =
        |after: Vec<f64>| after.iter().zip(&before).map(|(after, before)| after - before).collect::<Vec<f64>>();
    let gain = vec![1.0; before.len()];
    let cut = change(logs(own, WHOLE_MM - 1.6, 0.1, 0.0));
    let place = change(logs(own, WHOLE_MM, 0.1, 0.016));
    let (modulus, softening) = (change(logs(rubber, WHOLE_MM, 0.1, 0.0)), change(logs(less(1.1), WHOLE_MM, 0.1, 0.0)));
    for (pair, sd, expected) in [
        ("gain and cut", apart(&gain, &cut), 0.004),
        ("gain and place", apart(&gain, &place), 0.008),
        ("gain and modulus", apart(&gain, &modulus), 0.011),
        ("modulus and k2", apart(&modulus, &softening), 0.001),
    ] {
        assert!((sd - expected).abs() < 0.001, "{pair}: {sd}");
    }
}
