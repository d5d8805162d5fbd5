//! Measures the mechanics: one sensitivity, one setpoint, one length.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use vibrissa_core::mechanics::{
    Calibration, CalibrationRow, Compensator, Formulation, Geometry, Model, Objective, Offset, Target, fit_calibration,
    solve_setpoint,
};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre, Strain};

fn sensitivity(c: &mut Criterion) {
    let model = Model::nguyen_2021(Formulation::Published);
    let (a, length, pressure) = (ContactRatio::known(0.7), Millimetre::known(68.0), Megapascal::known(0.08));
    let morphology = model.morphology(pressure);
    c.bench_function("sensitivity with morphology", |b| {
        b.iter(|| model.sensitivity_per_mm(black_box(a), black_box(length), &model.morphology(black_box(pressure))));
    });
    c.bench_function("sensitivity and slope, morphology known", |b| {
        b.iter(|| model.sensitivity_and_slope(black_box(a), black_box(length), &morphology));
    });
}

fn setpoint(c: &mut Criterion) {
    let model = Model::nguyen_2021(Formulation::Published);
    let target = Target { length: Millimetre::known(70.0), pressure: Megapascal::known(0.1) };
    let compensator = Compensator {
        length: Millimetre::known(65.0),
        pressure: Megapascal::known(0.1),
        pressure_min: Megapascal::ZERO,
        pressure_max: Megapascal::EXAMINED_MAX,
    };
    let offset = Offset { level: 0.02, slope: -0.01 };
    for (name, objective) in [("setpoint, tip", Objective::Tip), ("setpoint, least mean error", Objective::Mean)] {
        c.bench_function(name, |b| {
            b.iter(|| {
                let (target, compensator) = (black_box(target), black_box(compensator));
                solve_setpoint(&model, target, offset, &model, compensator, offset, objective)
            });
        });
    }
}

fn length(c: &mut Criterion) {
    let model = Model::nguyen_2021(Formulation::Published);
    let morphology = model.morphology(Megapascal::known(0.1));
    let a = ContactRatio::known(0.7);
    let measured = model.sensitivity_per_mm(a, Millimetre::known(68.0), &morphology).unwrap_or(f64::NAN);
    c.bench_function("length from sensitivity", |b| {
        b.iter(|| model.length_from_sensitivity(black_box(measured), black_box(a), &morphology));
    });
}

fn fit(c: &mut Criterion) {
    let geometry = Geometry::nguyen_2021();
    let model = Model::nguyen_2021(Formulation::Published);
    let rows: Vec<CalibrationRow> = (0..40)
        .map(|k| {
            let pressure = Megapascal::known(0.005 * f64::from(k + 1));
            let wobble = 1.0 + 0.01 * f64::from(k * 7 % 5 - 2);
            let strain = Strain::known(model.axial_strain(pressure).ratio() * wobble);
            CalibrationRow { pressure, axial_strain: Some(strain), elongation: Some(model.elongation(pressure)) }
        })
        .collect();
    let youngs_modulus_mpa = Calibration::nguyen_2021().youngs_modulus_mpa;
    c.bench_function("calibration from 40 readings", |b| {
        b.iter(|| fit_calibration(&geometry, youngs_modulus_mpa, black_box(&rows)));
    });
}

criterion_group!(benches, sensitivity, setpoint, length, fit);
criterion_main!(benches);
