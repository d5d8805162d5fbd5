//! A picture of the demo from its database: what became of the lengths, the pressures and the errors.

use std::path::Path;

use anyhow::Result;
use plotters::prelude::*;

use super::scenario::{CONTACTS_PER_SECOND, INCIDENTS, What};
use crate::store::Store;
use crate::store::read::{ErrorBinReading, LengthPoint};

/// A palette that colour-blind people can tell apart (Okabe and Ito 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];
/// Every so many contacts one point of a curve.
const EVERY: i64 = 15;

struct Curve {
    label: String,
    points: Vec<LengthPoint>,
}

/// Draws it.
///
/// # Errors
/// The database cannot be read, or the file cannot be written.
pub(super) async fn draw(store: &Store, path: &Path) -> Result<()> {
    let mut curves = Vec::new();
    for incident in &INCIDENTS {
        let whisker = i64::from(incident.whisker);
        let points = store.lengths(incident.robot, incident.array, whisker, EVERY).await?;
        curves.push(Curve { label: format!("{}/{}/{}", incident.robot, incident.array, whisker), points });
        if let What::Trim { by, .. } = incident.what
            && by != incident.whisker
        {
            let points = store.lengths(incident.robot, incident.array, i64::from(by), EVERY).await?;
            curves.push(Curve {
                label: format!("{}/{}/{by} (serves {whisker})", incident.robot, incident.array),
                points,
            });
        }
    }
    let mut errors = Vec::new();
    for one in store.compensations().await?.into_iter().map(|one| one.decision) {
        let bins = store.error_bins(one.compensation_id).await?;
        if !bins.is_empty() {
            errors.push((format!("{}/{}/{}", one.robot, one.array, one.target_whisker), bins));
        }
    }
    let start_us = curves.iter().filter_map(|curve| curve.points.first()).map(|point| point.t_us).min().unwrap_or(0);
    let root = SVGBackend::new(path, (1000, 1150)).into_drawing_area();
    root.fill(&WHITE)?;
    let panels = root.split_evenly((3, 1));
    let title = format!("Estimated length (95 % band); a time-lapse at {CONTACTS_PER_SECOND} contacts a second");
    lengths(&panels[0], &title, &curves, start_us)?;
    pressures(&panels[1], &curves, start_us)?;
    error_panel(&panels[2], &errors)?;
    root.present()?;
    Ok(())
}

type Panel<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn seconds(point: &LengthPoint, start_us: i64) -> f64 {
    (point.t_us - start_us) as f64 / 1e6
}

fn end_s(curves: &[Curve], start_us: i64) -> f64 {
    curves.iter().filter_map(|curve| curve.points.last()).map(|point| seconds(point, start_us)).fold(1.0, f64::max)
}

fn lengths(panel: &Panel<'_>, title: &str, curves: &[Curve], start_us: i64) -> Result<()> {
    let mut chart = ChartBuilder::on(panel)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..end_s(curves, start_us), 45.0..75.0)?;
    chart.configure_mesh().x_desc("time (s)").y_desc("length (mm)").light_line_style(WHITE).draw()?;
    for (curve, colour) in curves.iter().zip(COLOURS.iter().cycle()) {
        let at = |point: &LengthPoint, z: f64| (seconds(point, start_us), point.length_mm + z * point.length_sd_mm);
        let band = curve
            .points
            .iter()
            .map(|point| at(point, 1.96))
            .chain(curve.points.iter().rev().map(|point| at(point, -1.96)));
        chart.draw_series(std::iter::once(Polygon::new(band.collect::<Vec<_>>(), colour.mix(0.25))))?;
        let line = LineSeries::new(curve.points.iter().map(|point| at(point, 0.0)), colour.stroke_width(2));
        chart
            .draw_series(line)?
            .label(&curve.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(3)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK)
        .draw()?;
    Ok(())
}

fn pressures(panel: &Panel<'_>, curves: &[Curve], start_us: i64) -> Result<()> {
    let mut chart = ChartBuilder::on(panel)
        .caption("Chamber pressure, as measured at each contact", ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..end_s(curves, start_us), 0.0..0.15)?;
    chart.configure_mesh().x_desc("time (s)").y_desc("pressure (MPa)").light_line_style(WHITE).draw()?;
    for (curve, colour) in curves.iter().zip(COLOURS.iter().cycle()) {
        let line = curve.points.iter().map(|point| (seconds(point, start_us), point.pressure_mpa));
        chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
    }
    Ok(())
}

fn error_panel(panel: &Panel<'_>, errors: &[(String, Vec<ErrorBinReading>)]) -> Result<()> {
    let mut chart = ChartBuilder::on(panel)
        .caption("Measured compensation error (Eq. 35) by contact ratio, with 95 % intervals", ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(0.42..1.03, 0.0..80.0)?;
    chart.configure_mesh().x_desc("contact ratio").y_desc("error (%)").light_line_style(WHITE).draw()?;
    let paper = LineSeries::new([(0.42, 20.385), (1.03, 20.385)], BLACK.stroke_width(1));
    chart
        .draw_series(paper)?
        .label("mean that the paper measured, 20.385 %")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK));
    for (index, (label, bins)) in errors.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        // Side by side, so that bars do not hide one another.
        let x = |bin: &ErrorBinReading| bin.ratio + 0.006 * (index as f64 - 1.0);
        chart
            .draw_series(LineSeries::new(bins.iter().map(|bin| (x(bin), 100.0 * bin.error)), colour.stroke_width(2)))?
            .label(label)
            .legend(move |(px, py)| PathElement::new([(px, py), (px + 18, py)], colour.stroke_width(3)));
        let bars = bins.iter().map(|bin| {
            ErrorBar::new_vertical(
                x(bin),
                100.0 * bin.error_low,
                100.0 * bin.error,
                100.0 * bin.error_high,
                colour.stroke_width(1),
                6,
            )
        });
        chart.draw_series(bars)?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK)
        .draw()?;
    Ok(())
}
