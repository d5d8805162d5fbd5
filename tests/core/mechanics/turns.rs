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
