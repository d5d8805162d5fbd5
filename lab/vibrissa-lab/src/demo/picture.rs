//! Chart of the demo from its database: lengths, pressures and errors.

use std::path::Path;

use anyhow::Result;
use plotters::prelude::*;

use super::scenario::{CONTACTS_PER_SECOND, INCIDENTS};
use crate::figures::{Axes, COLOURS, Panel, chart, drawing, legend};
use vibrissa_edge::interval::Z95;
use vibrissa_store::Store;
use vibrissa_store::from_row::LengthPoint;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::compensations::{COMPENSATIONS, CompensationSummary, RATIO_ERRORS, RatioError};

/// Contacts per point of a curve.
const EVERY: i64 = 15;
/// The paper's measured mean error of case 1 and self-compensation.
const PAPER_ERROR_PERCENT: f64 = 20.385;

struct Curve {
    label: String,
    points: Vec<LengthPoint>,
}

/// Draws the chart.
///
/// # Errors
/// The database cannot be read, or the file cannot be written.
pub(super) async fn draw(store: &Store, path: &Path) -> Result<()> {
    let decisions: Vec<CompensationSummary> = store.all(&COMPENSATIONS, Vec::new()).await?;
    let mut curves = Vec::new();
    for incident in &INCIDENTS {
        let whisker = i64::from(incident.whisker);
        let points = store.lengths(incident.robot, incident.array, whisker, EVERY).await?;
        curves.push(Curve { label: format!("{}/{}/{}", incident.robot, incident.array, whisker), points });
        let of_it = decisions.iter().filter(|one| one.robot == incident.robot && one.target_whisker == whisker);
        for by in of_it.filter_map(|one| one.compensator_whisker).filter(|&by| by != whisker) {
            let points = store.lengths(incident.robot, incident.array, by, EVERY).await?;
            let label = format!("{}/{}/{by} (serves {whisker})", incident.robot, incident.array);
            curves.push(Curve { label, points });
        }
    }
    let mut errors = Vec::new();
    for one in &decisions {
        let of_it = Filter::Is("compensation_id", Value::Whole(one.compensation_id));
        let bins: Vec<RatioError> = store.all(&RATIO_ERRORS, vec![of_it]).await?;
        if !bins.is_empty() {
            errors.push((format!("{}/{}/{}", one.robot, one.array, one.target_whisker), bins));
        }
    }
    let start_us = curves.iter().filter_map(|curve| curve.points.first()).map(|point| point.t_us).min().unwrap_or(0);
    let root = SVGBackend::new(path, (1000, 1150)).into_drawing_area();
    root.fill(&WHITE).map_err(drawing)?;
    let panels = root.split_evenly((3, 1));
    let title = format!("Estimated length (95 % band); a time-lapse at {CONTACTS_PER_SECOND} contacts a second");
    lengths(&panels[0], &title, &curves, start_us)?;
    pressures(&panels[1], &curves, start_us)?;
    error_panel(&panels[2], &curves, &errors)?;
    root.present().map_err(drawing)?;
    Ok(())
}

fn seconds(point: &LengthPoint, start_us: i64) -> f64 {
    (point.t_us - start_us) as f64 / 1e6
}

fn end_s(curves: &[Curve], start_us: i64) -> f64 {
    curves.iter().filter_map(|curve| curve.points.last()).map(|point| seconds(point, start_us)).fold(1.0, f64::max)
}

fn lengths(panel: &Panel<'_>, title: &str, curves: &[Curve], start_us: i64) -> Result<()> {
    let axes = Axes { title, x: ("time (s)", 0.0..end_s(curves, start_us)), y: ("length (mm)", 42.0..75.0) };
    let mut chart = chart(panel, &axes, 0)?;
    for (curve, colour) in curves.iter().zip(COLOURS.into_iter().cycle()) {
        let at = |point: &LengthPoint, z: f64| (seconds(point, start_us), point.length_mm + z * point.length_sd_mm);
        let above = curve.points.iter().map(|point| at(point, Z95));
        let below = curve.points.iter().rev().map(|point| at(point, -Z95));
        let band = Polygon::new(above.chain(below).collect::<Vec<_>>(), colour.mix(0.25));
        chart.draw_series(std::iter::once(band)).map_err(drawing)?;
        let line = LineSeries::new(curve.points.iter().map(|point| at(point, 0.0)), colour.stroke_width(2));
        let named = chart.draw_series(line).map_err(drawing)?.label(&curve.label);
        named.legend(move |at| stroke(at, colour));
    }
    legend(&mut chart, SeriesLabelPosition::LowerLeft)
}

fn pressures(panel: &Panel<'_>, curves: &[Curve], start_us: i64) -> Result<()> {
    let axes = Axes {
        title: "Chamber pressure, as measured at contacts",
        x: ("time (s)", 0.0..end_s(curves, start_us)),
        y: ("pressure (MPa)", 0.0..0.15),
    };
    let mut chart = chart(panel, &axes, 0)?;
    for (curve, colour) in curves.iter().zip(COLOURS.into_iter().cycle()) {
        let line = curve.points.iter().map(|point| (seconds(point, start_us), point.pressure_mpa));
        chart.draw_series(LineSeries::new(line, colour.stroke_width(2))).map_err(drawing)?;
    }
    Ok(())
}

fn error_panel(panel: &Panel<'_>, curves: &[Curve], errors: &[(String, Vec<RatioError>)]) -> Result<()> {
    let axes = Axes {
        title: "Measured compensation error (Eq. 35) by contact ratio, with 95 % intervals",
        x: ("contact ratio", 0.42..1.03),
        y: ("error (%)", 0.0..80.0),
    };
    let mut chart = chart(panel, &axes, 0)?;
    let paper = LineSeries::new([(0.42, PAPER_ERROR_PERCENT), (1.03, PAPER_ERROR_PERCENT)], BLACK.stroke_width(1));
    let named = chart.draw_series(paper).map_err(drawing)?;
    named.label(format!("mean measured in the paper, {PAPER_ERROR_PERCENT} %")).legend(|at| stroke(at, BLACK));
    for (index, (label, bins)) in errors.iter().enumerate() {
        // A whisker has one colour in all panels.
        let curve = curves.iter().position(|curve| curve.label == *label).unwrap_or(index);
        let colour = COLOURS[curve % COLOURS.len()];
        // Side by side, so that bars do not hide one another.
        let x = |bin: &RatioError| bin.ratio + 0.006 * (index as f64 - 1.0);
        let line = LineSeries::new(bins.iter().map(|bin| (x(bin), 100.0 * bin.error)), colour.stroke_width(2));
        chart.draw_series(line).map_err(drawing)?.label(label).legend(move |at| stroke(at, colour));
        let bars = bins.iter().map(|bin| {
            let [low, mean, high] = [bin.error_low, bin.error, bin.error_high].map(|error| 100.0 * error);
            ErrorBar::new_vertical(x(bin), low, mean, high, colour.stroke_width(1), 6)
        });
        chart.draw_series(bars).map_err(drawing)?;
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)
}

/// A curve's colour in a legend.
fn stroke((x, y): (i32, i32), colour: RGBColor) -> PathElement<(i32, i32)> {
    PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(3))
}
