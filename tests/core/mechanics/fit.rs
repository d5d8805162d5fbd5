//! Fits of readings that were generated from known calibrations.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use vibrissa_core::mechanics::{
    Calibration, CalibrationRow, Fit, FitError, Formulation, Geometry, Model, ModelError, fit_calibration,
};
use vibrissa_core::units::{Megapascal, Strain};

use super::{assert_close, mm, mpa};

const PRESSURES_MPA: [f64; 8] = [0.002, 0.005, 0.02, 0.05, 0.08, 0.1, 0.15, 0.2];

fn truth() -> Calibration {
    Calibration { c: 0.55, a: 1.3, b_per_mpa: 12.0, youngs_modulus_mpa: 1.2, elongation_gain_mm: 9.5 }
}

/// Five readings per pressure, as in the paper, with a relative error.
fn readings(relative_sd: f64, seed: u64) -> Vec<CalibrationRow> {
    let model = Model::new(Geometry::nguyen_2021(), truth(), Formulation::Published).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, relative_sd).unwrap();
    let mut with_noise = |value: f64| value * f64::exp(noise.sample(&mut rng));
    let mut rows = vec![CalibrationRow { pressure: Megapascal::ZERO, axial_strain: None, elongation: None }];
    for pressure in PRESSURES_MPA.map(mpa) {
        for _ in 0..5 {
            rows.push(CalibrationRow {
                pressure,
                axial_strain: Some(Strain::new(with_noise(model.axial_strain(pressure).ratio())).unwrap()),
                elongation: Some(mm(with_noise(model.elongation(pressure).mm()))),
            });
        }
    }
    rows
}

fn fitted(rows: &[CalibrationRow]) -> Fit {
    fit_calibration(&Geometry::nguyen_2021(), truth().youngs_modulus_mpa, rows).unwrap()
}

#[test]
fn property_exact_readings_give_the_parameters_back() {
    let fit = fitted(&readings(0.0, 1));
    assert_close("c", fit.c.value, truth().c, 1e-6);
    assert_close("a", fit.a.value, truth().a, 1e-6);
    assert_close("b", fit.b_per_mpa.value, truth().b_per_mpa, 1e-6);
    assert_close("G", fit.elongation_gain_mm.unwrap().value, truth().elongation_gain_mm, 1e-6);
    assert!(fit.residual_sd < 1e-8);
    assert_eq!(fit.residuals.len(), 41);
    assert_eq!(fit.residuals[0].k2, None);
}

/// 95 % intervals must contain the true value in about 95 % of 300 repetitions, within 3.5 standard deviations.
#[test]
fn property_intervals_hold_the_truth_as_often_as_they_say() {
    let repetitions = 300;
    let mut held = [0; 4];
    for seed in 0..repetitions {
        let fit = fitted(&readings(0.02, seed));
        let gain = fit.elongation_gain_mm.unwrap();
        let pairs = [
            (fit.c, truth().c),
            (fit.a, truth().a),
            (fit.b_per_mpa, truth().b_per_mpa),
            (gain, truth().elongation_gain_mm),
        ];
        for (held, (parameter, truth)) in held.iter_mut().zip(pairs) {
            *held += i32::from((parameter.low..=parameter.high).contains(&truth));
        }
        assert!((0.012..0.028).contains(&fit.residual_sd), "residual sd {}", fit.residual_sd);
    }
    for (name, held) in ["c", "a", "b", "G"].iter().zip(held) {
        let share = f64::from(held) / repetitions as f64;
        assert!((0.905..=0.995).contains(&share), "{name}: {share}");
    }
}

#[test]
fn property_without_elongations_the_gain_is_the_geometrys() {
    let rows: Vec<CalibrationRow> =
        readings(0.01, 7).into_iter().map(|row| CalibrationRow { elongation: None, ..row }).collect();
    let fit = fitted(&rows);
    assert_eq!(fit.elongation_gain_mm, None);
    assert_eq!(fit.calibration.elongation_gain_mm, Geometry::nguyen_2021().elongation_gain_mm());
    assert!(Model::new(Geometry::nguyen_2021(), fit.calibration, Formulation::Published).is_ok());
}

/// A strain only determines the product E k2: twice the modulus E gives half the k2 and otherwise the same curve.
#[test]
fn property_only_the_product_of_modulus_and_k2_is_measured() {
    let rows = readings(0.01, 3);
    let (once, twice) = (fitted(&rows), fit_calibration(&Geometry::nguyen_2021(), 2.4, &rows).unwrap());
    assert_close("c", 2.0 * twice.c.value, once.c.value, 1e-6);
    assert_close("a", 2.0 * twice.a.value, once.a.value, 1e-6);
    assert_close("b", twice.b_per_mpa.value, once.b_per_mpa.value, 1e-6);
    assert_close("G", twice.calibration.elongation_gain_mm, once.calibration.elongation_gain_mm, 1e-6);
}

#[test]
fn property_readings_that_determine_nothing_are_refused_by_name() {
    let g = Geometry::nguyen_2021();
    let refusal = |rows: &[CalibrationRow]| fit_calibration(&g, 1.2, rows).unwrap_err();
    let all = readings(0.01, 5);
    assert_eq!(refusal(&[]), FitError::NothingAboveZeroPressure);
    assert_eq!(refusal(&all[..1]), FitError::NothingAboveZeroPressure);
    assert_eq!(refusal(&all[..4]), FitError::TooFewStrains { given: 3 });
    assert_eq!(refusal(&all[..11]), FitError::TooFewPressures { given: 2 });
    let strain = |value: f64| Some(Strain::new(value).unwrap());
    let mut rows = all.clone();
    rows[3].axial_strain = strain(-0.001);
    assert_eq!(refusal(&rows), FitError::StrainNotPositive { row: 4, value: -0.001 });
    let mut rows = all.clone();
    rows[5].elongation = Some(mm(0.0));
    assert_eq!(refusal(&rows), FitError::ElongationNotPositive { row: 6, value_mm: 0.0 });
    let mut rows = all.clone();
    rows.iter_mut().skip(2).for_each(|row| row.elongation = None);
    assert_eq!(refusal(&rows), FitError::OneElongation);
    // Strains of a constant modulus, and of one that rises with pressure.
    for power in [1.0, 0.5] {
        let rows: Vec<CalibrationRow> = PRESSURES_MPA
            .iter()
            .map(|&q| CalibrationRow {
                pressure: mpa(q),
                axial_strain: strain(f64::powf(q, power) / 2.0),
                elongation: None,
            })
            .collect();
        assert!(matches!(refusal(&rows), FitError::NotDetermined { .. }), "{power}");
    }
    assert!(matches!(
        fit_calibration(&g, 0.0, &all),
        Err(FitError::Model(ModelError::NotPositive { name: "Young's modulus", .. }))
    ));
}
