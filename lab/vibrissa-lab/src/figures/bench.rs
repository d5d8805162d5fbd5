//! Counterparts of Fig. 6 to 10 for a whisker of one's own: measured points and the model's lines.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::prelude::*;
use vibrissa_core::mechanics::{BenchReading, Gauge, Kind, Model};
use vibrissa_core::units::{Megapascal, Strain};

use super::{
    Axes, BLUE, COLOURS, Chart, INK, Panel, VERMILION, along_palette, chart, drawing, legend, name_at_right_ends,
};
use crate::cli::validate::{Compared, Comparison, Compensation, clusters, compensations, rounded};

/// Strains are drawn in mm/m.
const MM_PER_M: f64 = 1e3;
/// Segments of a curve over the pressure.
const STEPS: u32 = 50;
/// Size of a panel, pixels.
const PANEL: (u32, u32) = (700, 440);

/// A panel with measured points and computed lines.
struct Plot {
    title: String,
    x: &'static str,
    y: &'static str,
    series: Vec<Series>,
}

/// Measured points, and the model's line for them.
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
    line: Vec<(f64, f64)>,
}

/// Draws the figures that the readings allow into a folder; returns their paths.
///
/// # Errors
/// A file cannot be written.
pub(crate) fn draw(folder: &Path, name: &str, comparison: &Comparison, model: &Model) -> Result<Vec<PathBuf>> {
    let strains = comparison.of_kind(Kind::ContactStrain);
    let (at_rest, pressed): (Vec<_>, Vec<_>) =
        strains.iter().copied().partition(|one| one.reading.pressure == Megapascal::ZERO);
    let several = clusters(&strains, |one| one.length_mm).len() > 1;
    let of_lengths = if several { strains.as_slice() } else { &[] };
    let errors = compensations(comparison, model);
    let figures = [
        ("fig-6-pressure.svg", pressures(name, comparison, model)?),
        ("fig-7-normal-mode.svg", whole("strain at 0 MPa, by place", name, &at_rest, comparison, model)),
        ("fig-8-pressure.svg", by_place("strain under pressure", &pressed, comparison, model)),
        ("fig-9-lengths.svg", by_place("strain by length and pressure", of_lengths, comparison, model)),
        ("fig-10-compensation-error.svg", errors.iter().map(error_plot).collect()),
        ("force.svg", by_place("force", &comparison.of_kind(Kind::ContactForce), comparison, model)),
    ];
    let mut paths = Vec::new();
    for (file, plots) in figures {
        if plots.is_empty() {
            continue;
        }
        let path = folder.join(file);
        let columns = if plots.len() > 1 { 2 } else { 1 };
        let rows = plots.len().div_ceil(columns);
        let size = (PANEL.0 * columns as u32, PANEL.1 * rows as u32);
        let root = SVGBackend::new(&path, size).into_drawing_area();
        root.fill(&WHITE).map_err(drawing)?;
        for (panel, plot) in root.split_evenly((rows, columns)).iter().zip(&plots) {
            plot.draw(panel)?;
        }
        root.present().map_err(drawing)?;
        drop(root);
        paths.push(path);
    }
    Ok(paths)
}

/// Fig. 6: strain without contact, E2, k2 and elongation over the pressure.
fn pressures(name: &str, comparison: &Comparison, model: &Model) -> Result<Vec<Plot>> {
    let (strains, elongations) = (comparison.of_kind(Kind::Axial), comparison.of_kind(Kind::Elongation));
    let highest_mpa = comparison.all.iter().map(|one| one.reading.pressure.mpa()).fold(0.0, f64::max);
    let curve = |of: &dyn Fn(Megapascal) -> f64| {
        (0..=STEPS)
            .map(|step| {
                let pressure_mpa = highest_mpa * f64::from(step) / f64::from(STEPS);
                Ok((pressure_mpa, of(Megapascal::new(pressure_mpa)?)))
            })
            .collect::<Result<Vec<_>>>()
    };
    let modulus_mpa = model.calibration().youngs_modulus_mpa;
    let e2_mpa = |one: &Compared| {
        // The offset of the gauge is in the computed strain.
        let strain = model.axial_strain(one.reading.pressure).ratio() + one.reading.value - one.modelled;
        let e2_mpa =
            model.geometry().youngs_modulus_from_axial_strain(one.reading.pressure, Strain::new(strain).ok()?)?;
        Some((one.reading.pressure.mpa(), e2_mpa))
    };
    let points = |of: &[Compared], scale: f64| {
        of.iter().map(|one| (one.reading.pressure.mpa(), scale * one.reading.value)).collect::<Vec<_>>()
    };
    let moduli_mpa: Vec<(f64, f64)> = strains.iter().filter_map(e2_mpa).collect();
    let k2 = moduli_mpa.iter().map(|(pressure_mpa, e2_mpa)| (*pressure_mpa, e2_mpa / modulus_mpa)).collect();
    let plot = |title: &str, y, points: Vec<(f64, f64)>, line| Plot {
        title: format!("{name}: {title}"),
        x: "pressure (MPa)",
        y,
        series: vec![Series { name: String::new(), points, line }],
    };
    let mut plots = Vec::new();
    if !strains.is_empty() {
        let line = curve(&|pressure| MM_PER_M * model.axial_strain(pressure).ratio())?;
        plots.push(plot("strain without contact", "strain (mm/m)", points(&strains, MM_PER_M), line));
        let line = curve(&|pressure| model.k2(pressure) * modulus_mpa)?;
        plots.push(plot("modulus of the chamber's wall", "E2 (MPa)", moduli_mpa, line));
        plots.push(plot("the same, relative to E", "k2", k2, curve(&|pressure| model.k2(pressure))?));
    }
    if !elongations.is_empty() {
        let line = curve(&|pressure| model.elongation(pressure).mm())?;
        plots.push(plot("elongation of the chamber", "elongation (mm)", points(&elongations, 1.0), line));
    }
    Ok(plots)
}

/// One panel with a series for each place.
fn whole(title: &str, name: &str, readings: &[Compared], comparison: &Comparison, model: &Model) -> Vec<Plot> {
    let series: Vec<Series> = clusters(readings, |one| one.place)
        .into_iter()
        .filter_map(|(place, group)| series_of(comparison.place(place), &group, model))
        .collect();
    let plot = Plot { title: format!("{name}: {title}"), x: DEFLECTION, y: STRAIN, series };
    if plot.series.is_empty() { Vec::new() } else { vec![plot] }
}

const DEFLECTION: &str = "deflection at the contact (mm)";
const STRAIN: &str = "mean strain of the gauge (mm/m)";

/// A panel for each place, with a series for each length and pressure.
fn by_place(title: &str, readings: &[Compared], comparison: &Comparison, model: &Model) -> Vec<Plot> {
    let plot = |(place, group): (f64, Vec<Compared>)| {
        let is_force = group.iter().all(|one| one.reading.kind() == Some(Kind::ContactForce));
        let mut series = Vec::new();
        for (length_mm, of_length) in clusters(&group, |one| Some(one.length_mm.unwrap_or(0.0))) {
            for (pressure_mpa, of_pressure) in clusters(&of_length, |one| Some(one.reading.pressure.mpa())) {
                let of_length =
                    if length_mm > 0.0 { format!("{} mm, ", rounded(length_mm, 10.0)) } else { String::new() };
                let name = format!("{of_length}{} MPa", rounded(pressure_mpa, 1000.0));
                series.extend(series_of(name, &of_pressure, model));
            }
        }
        Plot {
            title: format!("{}: {title}", comparison.place(place)),
            x: DEFLECTION,
            y: if is_force { "force at the contact (N)" } else { STRAIN },
            series,
        }
    };
    clusters(readings, |one| one.place).into_iter().map(plot).filter(|plot| !plot.series.is_empty()).collect()
}

/// Readings at one place, and the model's line up to the largest deflection.
fn series_of(name: String, group: &[Compared], model: &Model) -> Option<Series> {
    let scale = |reading: &BenchReading| if reading.kind() == Some(Kind::ContactStrain) { MM_PER_M } else { 1.0 };
    let points: Vec<(f64, f64)> = group
        .iter()
        .filter_map(|one| Some((one.reading.contact()?.deflection_mm, scale(&one.reading) * one.reading.value)))
        .collect();
    let deepest = group.iter().max_by(|a, b| a.modelled.total_cmp(&b.modelled))?;
    let deflection_mm = deepest.reading.contact()?.deflection_mm;
    let end = scale(&deepest.reading) * deepest.reading.modelled(model, Gauge::TRUE);
    Some(Series { name, points, line: vec![(0.0, 0.0), (deflection_mm, end)] })
}

/// Fig. 10: eq. 35 over the contact ratio.
fn error_plot(one: &Compensation) -> Plot {
    Plot {
        title: format!("Compensation error: {}", one.name()),
        x: "contact ratio a",
        y: "error by eq. 35 (%)",
        series: vec![Series {
            name: String::new(),
            points: one.by_ratio.iter().map(|(ratio, measured, _)| (*ratio, 100.0 * measured)).collect(),
            line: one.by_ratio.iter().map(|(ratio, _, computed)| (*ratio, 100.0 * computed)).collect(),
        }],
    }
}

impl Plot {
    fn draw(&self, panel: &Panel<'_>) -> Result<()> {
        let all = || self.series.iter().flat_map(|series| series.points.iter().chain(&series.line));
        let greatest = |of: fn(&(f64, f64)) -> f64| all().map(of).fold(f64::MIN_POSITIVE, f64::max);
        let least_y = all().map(|(_, y)| *y).fold(0.0, f64::min);
        let axes = Axes {
            title: &self.title,
            x: (self.x, 0.0..1.03 * greatest(|(x, _)| *x)),
            y: (self.y, 1.1 * least_y..1.1 * greatest(|(_, y)| *y)),
        };
        let named = self.series.iter().any(|series| !series.name.is_empty());
        let mut chart = chart(panel, &axes, if named { 120 } else { 0 })?;
        let mut ends = Vec::new();
        for (at, series) in self.series.iter().enumerate() {
            let (of_line, of_points) = match self.series.len() {
                1 => (BLUE, VERMILION),
                count if count <= COLOURS.len() => (COLOURS[at], COLOURS[at]),
                count => (along_palette(at, count), along_palette(at, count)),
            };
            series.draw(&mut chart, of_line, of_points, at == 0)?;
            if let Some((_, y)) = series.line.last().filter(|_| !series.name.is_empty()) {
                ends.push((*y, series.name.clone(), of_line));
            }
        }
        name_at_right_ends(panel, &chart, &ends)?;
        let falls = |series: &Series| Some(series.line.first()?.1 > series.line.last()?.1);
        let is_falling = self.series.first().and_then(falls).unwrap_or(false);
        legend(&mut chart, if is_falling { SeriesLabelPosition::UpperRight } else { SeriesLabelPosition::UpperLeft })
    }
}

impl Series {
    fn draw(&self, chart: &mut Chart<'_>, line: RGBColor, points: RGBColor, in_legend: bool) -> Result<()> {
        let style = line.stroke_width(2);
        let computed = chart.draw_series(LineSeries::new(self.line.clone(), style)).map_err(drawing)?;
        if in_legend {
            computed.label("computed").legend(|(x, y)| PathElement::new([(x, y), (x + 16, y)], INK.stroke_width(2)));
        }
        let marks = self.points.iter().map(|at| Circle::new(*at, 3, points.filled()));
        let measured = chart.draw_series(marks).map_err(drawing)?;
        if in_legend {
            measured.label("measured").legend(|(x, y)| Circle::new((x + 8, y), 3, INK.filled()));
        }
        Ok(())
    }
}
