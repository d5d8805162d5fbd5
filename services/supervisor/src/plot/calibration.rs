//! Readings and fit of a calibration with the fit's 95 % confidence band.

use vibrissa_core::mechanics::{CalibrationRow, Fit};
use vibrissa_core::units::{Megapascal, OutOfUnitRange};

use super::lines::{Across, Lines, Mark, Point, Shape};

/// Segments of a curve.
const STEPS: u32 = 50;

/// Draws k2 over pressure, and below it the elongation if it was measured.
///
/// # Errors
/// A reading's pressure is beyond the range of [`Megapascal`].
pub fn svg(name: &str, rows: &[CalibrationRow], fit: &Fit) -> Result<String, OutOfUnitRange> {
    let highest_mpa = rows.iter().map(|row| row.pressure.mpa()).fold(Megapascal::EXAMINED_MAX.mpa(), f64::max);
    let mut charts = vec![stiffness(name, rows, fit, highest_mpa)?];
    charts.extend(elongation(name, rows, fit, highest_mpa)?);
    Ok(Lines::draw_stacked(&charts))
}

fn stiffness(name: &str, rows: &[CalibrationRow], fit: &Fit, highest_mpa: f64) -> Result<Lines, OutOfUnitRange> {
    let readings = rows.iter().zip(&fit.residuals);
    let readings = readings.filter_map(|(row, residual)| Some(Point::at(row.pressure.mpa(), residual.k2?))).collect();
    let curve = curve(highest_mpa, |pressure| {
        let k2 = fit.k2(pressure);
        [k2.low, k2.value, k2.high]
    })?;
    let title = format!("{name}: modulus of the chamber's wall, relative to the rubber's");
    Ok(chart(title, "k2", highest_mpa, readings, curve))
}

fn elongation(
    name: &str,
    rows: &[CalibrationRow],
    fit: &Fit,
    highest_mpa: f64,
) -> Result<Option<Lines>, OutOfUnitRange> {
    let Some(gain) = &fit.elongation_gain_mm else { return Ok(None) };
    let readings = rows.iter().filter_map(|row| Some(Point::at(row.pressure.mpa(), row.elongation?.mm()))).collect();
    let curve = curve(highest_mpa, |pressure| {
        let per_gain = pressure.mpa() / (fit.k2(pressure).value * fit.calibration.youngs_modulus_mpa);
        [gain.low, gain.value, gain.high].map(|gain_mm| gain_mm * per_gain)
    })?;
    Ok(Some(chart(format!("{name}: elongation of the chamber"), "elongation, mm", highest_mpa, readings, curve)))
}

/// A curve from pressure 0 to the highest, with its band: `of` gives the low, best and high value.
fn curve(highest_mpa: f64, of: impl Fn(Megapascal) -> [f64; 3]) -> Result<Vec<Point>, OutOfUnitRange> {
    (0..=STEPS)
        .map(|step| {
            let pressure_mpa = highest_mpa * f64::from(step) / f64::from(STEPS);
            let [low, best, high] = of(Megapascal::new(pressure_mpa)?);
            Ok(Point { x: pressure_mpa, y: best, bounds: Some((low, high)) })
        })
        .collect()
}

fn chart(title: String, quantity: &'static str, highest_mpa: f64, readings: Vec<Point>, curve: Vec<Point>) -> Lines {
    Lines {
        desc: format!("{title}. {} readings and the fitted curve.", readings.len()),
        title,
        across: Across::Number("pressure, MPa", 0.0, 1.02 * highest_mpa),
        up: quantity,
        up_at_least: (0.0, 0.0),
        marks: vec![
            Mark::Line { class: "p-a", dash: "", label: "fit, 95 % confidence band".to_owned(), points: curve },
            Mark::Points { class: "p-b", shape: Shape::Dot, label: "readings".to_owned(), points: readings },
        ],
    }
}
