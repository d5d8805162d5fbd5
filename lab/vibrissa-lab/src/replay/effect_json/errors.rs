//! Measured compensation errors, and looks at them, as lines of JSON.

use serde::Serialize;
use vibrissa_core::robot::effect::{CompensationError, ErrorBin, Refinement};
use vibrissa_core::units::Megapascal;
use vibrissa_edge::interval::Z95;
use vibrissa_edge::words::Word;

#[derive(Serialize)]
pub(super) struct ErrorLine {
    compensation: u32,
    contacts: u32,
    error: f64,
    error_low: f64,
    error_high: f64,
    error_with_gain: Option<f64>,
    error_with_gain_low: Option<f64>,
    error_with_gain_high: Option<f64>,
    air_error: Option<f64>,
    air_error_low: Option<f64>,
    air_error_high: Option<f64>,
    pressure_mpa: f64,
    bins: Vec<BinLine>,
}

#[derive(Serialize)]
pub(super) struct RefinementLine {
    compensation: u32,
    contacts: u32,
    outcome: &'static str,
    pressure_from_mpa: f64,
    pressure_best_mpa: Option<f64>,
    error: f64,
    error_best: Option<f64>,
    error_with_gain: f64,
    error_with_own_gain: f64,
    gain_published: bool,
}

#[derive(Serialize)]
struct BinLine {
    ratio: f64,
    contacts: u32,
    after_per_mm: f64,
    before_per_mm: f64,
    before_origin: &'static str,
    target_per_mm: f64,
    target_origin: &'static str,
    error: f64,
    error_low: f64,
    error_high: f64,
}

pub(super) fn error_line(error: &CompensationError) -> ErrorLine {
    let (error_low, error_high) = interval(error.mean, error.sd);
    let with_gain = error.with_gain.map(|(mean, sd)| interval(mean, sd));
    let air_alone = error.air_alone.map(|(mean, sd)| interval(mean, sd));
    let bins = error.bins.iter().map(bin_line).collect();
    ErrorLine {
        compensation: error.compensation,
        contacts: error.contacts,
        error: error.mean,
        error_low,
        error_high,
        error_with_gain: error.with_gain.map(|(mean, _)| mean),
        error_with_gain_low: with_gain.map(|(low, _)| low),
        error_with_gain_high: with_gain.map(|(_, high)| high),
        air_error: error.air_alone.map(|(mean, _)| mean),
        air_error_low: air_alone.map(|(low, _)| low),
        air_error_high: air_alone.map(|(_, high)| high),
        pressure_mpa: error.pressure.mpa(),
        bins,
    }
}

pub(super) fn refinement_line(look: &Refinement) -> RefinementLine {
    RefinementLine {
        compensation: look.compensation,
        contacts: look.contacts,
        outcome: look.outcome.word(),
        pressure_from_mpa: look.pressure_from.mpa(),
        pressure_best_mpa: look.pressure_best.map(Megapascal::mpa),
        error: look.error,
        error_best: look.error_best.map(|(mean, _)| mean),
        error_with_gain: look.error_with_gain,
        error_with_own_gain: look.error_with_own_gain,
        gain_published: look.gain_published,
    }
}

fn bin_line(bin: &ErrorBin) -> BinLine {
    let (error_low, error_high) = interval(bin.error, bin.sd);
    BinLine {
        ratio: bin.ratio,
        contacts: bin.contacts,
        after_per_mm: bin.after_per_mm,
        before_per_mm: bin.before_per_mm,
        before_origin: bin.before_origin.word(),
        target_per_mm: bin.target_per_mm,
        target_origin: bin.target_origin.word(),
        error: bin.error,
        error_low,
        error_high,
    }
}

/// The 95 % interval, as in the database.
fn interval(mean: f64, sd: f64) -> (f64, f64) {
    ((mean - Z95 * sd).max(0.0), mean + Z95 * sd)
}
