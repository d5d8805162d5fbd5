//! Compares the mechanics with independent numbers, the paper and brute force, and checks general properties.

mod bench;
mod brute_force;
mod fit;
mod golden;
mod paper;
mod properties;
mod shape;
mod turns;

use vibrissa_core::mechanics::{Compensator, Target};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

fn mm(value: f64) -> Millimetre {
    Millimetre::new(value).unwrap()
}

fn mpa(value: f64) -> Megapascal {
    Megapascal::new(value).unwrap()
}

fn ratio(value: f64) -> ContactRatio {
    ContactRatio::new(value).unwrap()
}

fn target(length_mm: f64, pressure_mpa: f64) -> Target {
    Target { length: mm(length_mm), pressure: mpa(pressure_mpa) }
}

/// A compensator that may use all pressures examined in the paper.
fn compensator(length_mm: f64, pressure_mpa: f64) -> Compensator {
    Compensator {
        length: mm(length_mm),
        pressure: mpa(pressure_mpa),
        pressure_min: Megapascal::ZERO,
        pressure_max: Megapascal::EXAMINED_MAX,
    }
}

/// Panics unless the values agree within a relative difference; an expected zero uses the same value as absolute limit.
#[track_caller]
fn assert_close(what: &str, ours: f64, expected: f64, relative: f64) {
    let allowed = relative * if expected == 0.0 { 1.0 } else { expected.abs() };
    assert!((ours - expected).abs() <= allowed, "{what}: {ours} instead of {expected}");
}
