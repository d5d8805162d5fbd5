//! Readings and fit of a calibration with its confidence band.

use std::path::Path;

use anyhow::Result;
use plotters::prelude::*;
use vibrissa_core::mechanics::{CalibrationRow, Fit};
use vibrissa_core::units::Megapascal;

use super::{Axes, BLUE, Chart, Panel, VERMILION, chart, drawing, legend};

/// Segments of a curve; with many short ones the rounding to whole pixels would show.
const STEPS: u32 = 50;

/// Draws k2 over pressure, and below it the elongation if it was measured.
///
/// # Errors
/// The plot cannot be drawn, or the file cannot be written.
pub fn draw(path: &Path, name: &str, rows: &[CalibrationRow], fit: &Fit) -> Result<()> {
    Ok(std::fs::write(path, svg(name, rows, fit)?)?)
}

/// The plot as SVG text.
///
/// # Errors
/// The plot cannot be drawn.
pub fn svg(name: &str, rows: &[CalibrationRow], fit: &Fit) -> Result<String> {
    let mut text = String::new();
    onto(&mut text, name, rows, fit)?;
    Ok(text)
}

fn onto(text: &mut String, name: &str, rows: &[CalibrationRow], fit: &Fit) -> Result<()> {
    let height = if fit.elongation_gain_mm.is_some() { 940 } else { 500 };
    let root = SVGBackend::with_string(text, (860, height)).into_drawing_area();
    root.fill(&WHITE).map_err(drawing)?;
    let highest_mpa = rows.iter().map(|row| row.pressure.mpa()).fold(Megapascal::EXAMINED_MAX.mpa(), f64::max);
    if fit.elongation_gain_mm.is_some() {
        let panels = root.split_evenly((2, 1));
        stiffness(&panels[0], name, rows, fit, highest_mpa)?;
        elongation(&panels[1], name, rows, fit, highest_mpa)?;
    } else {
        stiffness(&root, name, rows, fit, highest_mpa)?;
    }
    root.present().map_err(drawing)
}

fn stiffness(panel: &Panel<'_>, name: &str, rows: &[CalibrationRow], fit: &Fit, highest_mpa: f64) -> Result<()> {
    let points = rows.iter().zip(&fit.residuals);
    let points: Vec<_> = points.filter_map(|(row, residual)| Some((row.pressure.mpa(), residual.k2?))).collect();
    let curve = curve(highest_mpa, |pressure| {
        let k2 = fit.k2(pressure);
        [k2.low, k2.value, k2.high]
    })?;
    let title = format!("{name}: modulus of the chamber's wall, relative to the rubber's");
    panel_with(panel, &title, "k2", highest_mpa, &points, &curve)
}

fn elongation(panel: &Panel<'_>, name: &str, rows: &[CalibrationRow], fit: &Fit, highest_mpa: f64) -> Result<()> {
    let Some(gain) = &fit.elongation_gain_mm else { return Ok(()) };
    let points: Vec<_> = rows.iter().filter_map(|row| Some((row.pressure.mpa(), row.elongation?.mm()))).collect();
    let curve = curve(highest_mpa, |pressure| {
        let per_gain = pressure.mpa() / (fit.k2(pressure).value * fit.calibration.youngs_modulus_mpa);
        [gain.low, gain.value, gain.high].map(|gain_mm| gain_mm * per_gain)
    })?;
    panel_with(panel, &format!("{name}: elongation of the chamber"), "elongation (mm)", highest_mpa, &points, &curve)
}

/// A curve with its confidence band: pressure, then low, best and high value.
type Curve = Vec<(f64, [f64; 3])>;

fn curve(highest_mpa: f64, of: impl Fn(Megapascal) -> [f64; 3]) -> Result<Curve> {
    (0..=STEPS)
        .map(|k| {
            let pressure_mpa = highest_mpa * f64::from(k) / f64::from(STEPS);
            Ok((pressure_mpa, of(Megapascal::new(pressure_mpa)?)))
        })
        .collect()
}

fn panel_with(
    panel: &Panel<'_>,
    title: &str,
    quantity: &str,
    highest_mpa: f64,
    points: &[(f64, f64)],
    curve: &Curve,
) -> Result<()> {
    // The band may be wide where there are no readings; it must not flatten the curve.
    let best = curve.iter().map(|(_, band)| band[1]);
    let top = points.iter().map(|point| point.1).chain(best).fold(0.0, f64::max);
    let axes = Axes { title, x: ("pressure (MPa)", 0.0..1.02 * highest_mpa), y: (quantity, 0.0..1.15 * top) };
    let mut chart = chart(panel, &axes, 0)?;
    band(&mut chart, curve)?;
    let line = LineSeries::new(curve.iter().map(|(x, band)| (*x, band[1])), BLUE.stroke_width(2));
    let drawn = chart.draw_series(line).map_err(drawing)?;
    drawn.label("fit").legend(|(x, y)| PathElement::new([(x, y), (x + 22, y)], BLUE.stroke_width(2)));
    let marks = points.iter().map(|&at| Circle::new(at, 4, VERMILION.stroke_width(2)));
    let drawn = chart.draw_series(marks).map_err(drawing)?;
    drawn.label("readings").legend(|(x, y)| Circle::new((x + 11, y), 4, VERMILION.stroke_width(2)));
    let rising = curve.last().map(|(_, band)| band[1]) > curve.first().map(|(_, band)| band[1]);
    let corner = if rising { SeriesLabelPosition::UpperLeft } else { SeriesLabelPosition::UpperRight };
    legend(&mut chart, corner)
}

fn band(chart: &mut Chart<'_>, curve: &Curve) -> Result<()> {
    let ceiling = chart.y_range().end;
    let outline: Vec<_> = curve
        .iter()
        .map(|(x, band)| (*x, band[0].min(ceiling)))
        .chain(curve.iter().rev().map(|(x, band)| (*x, band[2].min(ceiling))))
        .collect();
    let fill = BLUE.mix(0.2).filled();
    let drawn = chart.draw_series(std::iter::once(Polygon::new(outline, fill))).map_err(drawing)?;
    drawn
        .label("95 % confidence band of the fit")
        .legend(move |(x, y)| Rectangle::new([(x, y - 6), (x + 22, y + 6)], fill));
    Ok(())
}
