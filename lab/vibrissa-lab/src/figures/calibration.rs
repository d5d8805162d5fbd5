//! Readings and fit of a calibration, with the fit's 95 % confidence band.

use std::path::Path;

use anyhow::Result;
use plotters::prelude::*;
use vibrissa_core::mechanics::{BenchFit, BenchReading, Kind, Unknown};
use vibrissa_core::units::Megapascal;

use super::{Axes, BLUE, Panel, VERMILION, chart, drawing, legend};

/// Segments of a curve.
const STEPS: u32 = 50;

/// A value with its band.
struct Band {
    low: f64,
    value: f64,
    high: f64,
}

/// Draws k2 over the pressure, and below it the elongation if it was measured.
///
/// # Errors
/// The file cannot be written, or a reading's pressure is beyond the range of [`Megapascal`].
pub fn draw(path: &Path, name: &str, readings: &[BenchReading], fit: &BenchFit) -> Result<()> {
    let panels = if fit.parameter(Unknown::ElongationGain).is_some() { 2 } else { 1 };
    let root = SVGBackend::new(path, (880, 480 * panels)).into_drawing_area();
    root.fill(&WHITE).map_err(drawing)?;
    let panels = root.split_evenly((panels as usize, 1));
    // A strain's residual is that of 1 / k2.
    let of_strain = |(reading, residual): (&BenchReading, &Option<f64>)| {
        let k2 = fit.model().k2(reading.pressure) / (1.0 + (*residual)?);
        (reading.kind() == Some(Kind::Axial)).then_some((reading.pressure.mpa(), k2))
    };
    let strains: Vec<(f64, f64)> = readings.iter().zip(&fit.residuals).filter_map(of_strain).collect();
    let k2 = |pressure| {
        let k2 = fit.k2(pressure);
        Band { low: k2.low, value: k2.value, high: k2.high }
    };
    let title = format!("{name}: modulus of the chamber's wall, relative to the rubber's");
    panel(&panels[0], &title, "k2", &strains, k2)?;
    if let (Some(below), Some(gain)) = (panels.get(1), fit.parameter(Unknown::ElongationGain)) {
        let of_kind = readings.iter().filter(|reading| reading.kind() == Some(Kind::Elongation));
        let elongations: Vec<(f64, f64)> = of_kind.map(|reading| (reading.pressure.mpa(), reading.value)).collect();
        let elongation = |pressure: Megapascal| {
            let per_gain = pressure.mpa() / (fit.k2(pressure).value * fit.calibration.youngs_modulus_mpa);
            Band { low: gain.low * per_gain, value: gain.value * per_gain, high: gain.high * per_gain }
        };
        panel(below, &format!("{name}: elongation of the chamber"), "elongation (mm)", &elongations, elongation)?;
    }
    root.present().map_err(drawing)
}

/// One quantity from pressure 0 to the highest reading.
fn panel(
    panel: &Panel<'_>,
    title: &str,
    quantity: &str,
    readings: &[(f64, f64)],
    of: impl Fn(Megapascal) -> Band,
) -> Result<()> {
    let highest_mpa =
        readings.iter().map(|(pressure_mpa, _)| *pressure_mpa).fold(Megapascal::EXAMINED_MAX.mpa(), f64::max);
    let mut curve = Vec::new();
    for step in 0..=STEPS {
        let pressure_mpa = highest_mpa * f64::from(step) / f64::from(STEPS);
        curve.push((pressure_mpa, of(Megapascal::new(pressure_mpa)?)));
    }
    let values = readings.iter().map(|(_, value)| *value).chain(curve.iter().map(|(_, band)| band.high));
    let axes = Axes {
        title,
        x: ("pressure (MPa)", 0.0..1.02 * highest_mpa),
        y: (quantity, 0.0..1.08 * values.fold(0.0, f64::max)),
    };
    let mut chart = chart(panel, &axes, 0)?;
    let upper = curve.iter().map(|(pressure_mpa, band)| (*pressure_mpa, band.high));
    let lower = curve.iter().rev().map(|(pressure_mpa, band)| (*pressure_mpa, band.low));
    let band = Polygon::new(upper.chain(lower).collect::<Vec<_>>(), BLUE.mix(0.2));
    chart.draw_series([band]).map_err(drawing)?;
    let line = curve.iter().map(|(pressure_mpa, band)| (*pressure_mpa, band.value));
    chart
        .draw_series(LineSeries::new(line, BLUE.stroke_width(2)))
        .map_err(drawing)?
        .label("fit, 95 % confidence band")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 16, y)], BLUE.stroke_width(2)));
    chart
        .draw_series(readings.iter().map(|at| Circle::new(*at, 4, VERMILION.filled())))
        .map_err(drawing)?
        .label("readings")
        .legend(|(x, y)| Circle::new((x + 8, y), 4, VERMILION.filled()));
    legend(&mut chart, SeriesLabelPosition::UpperRight)
}
