//! The model's curves of Fig. 7, 8 and 9, in the published formulation.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::prelude::*;
use vibrissa_core::mechanics::{
    CONTACT_RATIOS, Compensator, Formulation, Model, Objective, Offset, Target, solve_setpoint,
};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

use super::{Axes, BLUE, Chart, INK, Panel, VERMILION, along_palette, chart, drawing, legend, name_at_right_ends};

/// The paper's intact whisker.
const LENGTH_MM: f64 = 70.0;
/// The paper's greatest deflection.
const DEFLECTION_MM: f64 = 6.0;
const PRESSURES_MPA: [f64; 6] = [0.0, 0.002, 0.05, 0.1, 0.15, 0.2];
/// Strains are drawn in mm/m.
const MM_PER_M: f64 = 1e3;

/// Draws the three figures into a folder; their paths.
///
/// # Errors
/// A file cannot be written.
pub fn draw(folder: &Path) -> Result<Vec<PathBuf>> {
    let model = Model::nguyen_2021(Formulation::Published);
    let figures: [(&str, (u32, u32), Figure); 3] = [
        ("fig-7-normal-mode.svg", (880, 640), normal_mode),
        ("fig-8-pressure.svg", (1100, 900), pressures),
        ("fig-9-compensation.svg", (1300, 520), compensation),
    ];
    let mut paths = Vec::new();
    for (name, size, figure) in figures {
        let path = folder.join(name);
        let root = SVGBackend::new(&path, size).into_drawing_area();
        root.fill(&WHITE).map_err(drawing)?;
        figure(&root, &model)?;
        root.present().map_err(drawing)?;
        drop(root);
        paths.push(path);
    }
    Ok(paths)
}

type Figure = fn(&Panel<'_>, &Model) -> Result<()>;

/// Fig. 7: strain against deflection at zero pressure, one line for each contact ratio.
fn normal_mode(root: &Panel<'_>, model: &Model) -> Result<()> {
    let slope_at = |a: f64| -> Result<f64> {
        let contact = Millimetre::new(a * LENGTH_MM)?;
        Ok(MM_PER_M * model.normal_mode(contact).strain_per_mm)
    };
    let axes = Axes {
        title: "Normal mode: strain against deflection by contact ratio a (whisker of 70 mm, 0 MPa)",
        x: ("deflection at the contact (mm)", 0.0..DEFLECTION_MM),
        y: ("mean strain of the gauge (mm/m)", 0.0..1.08 * DEFLECTION_MM * slope_at(CONTACT_RATIOS[0])?),
    };
    let mut chart = chart(root, &axes, 70)?;
    let mut ends = Vec::new();
    for (k, a) in CONTACT_RATIOS.into_iter().enumerate() {
        let (slope, colour) = (slope_at(a)?, along_palette(k, CONTACT_RATIOS.len()));
        straight(&mut chart, slope, colour, 0)?;
        ends.push((slope * DEFLECTION_MM, format!("a = {a:.2}"), colour));
    }
    name_at_right_ends(root, &chart, &ends)
}

/// Fig. 8: strain against deflection under pressure, at four contact ratios.
fn pressures(root: &Panel<'_>, model: &Model) -> Result<()> {
    for (panel, a) in root.split_evenly((2, 2)).iter().zip([0.45, 0.65, 0.85, 1.0]) {
        let slopes = PRESSURES_MPA
            .iter()
            .map(|&pressure_mpa| Ok(MM_PER_M * sensitivity_per_mm(model, a, LENGTH_MM, pressure_mpa)?))
            .collect::<Result<Vec<f64>>>()?;
        let steepest = slopes.iter().copied().fold(0.0, f64::max);
        let axes = Axes {
            title: &format!("Strain under pressure at contact ratio {a} (whisker of 70 mm)"),
            x: ("deflection at the contact (mm)", 0.0..DEFLECTION_MM),
            y: ("mean strain of the gauge (mm/m)", 0.0..1.15 * DEFLECTION_MM * steepest),
        };
        let mut chart = chart(panel, &axes, 84)?;
        let mut ends = Vec::new();
        for (k, (slope, pressure_mpa)) in slopes.into_iter().zip(PRESSURES_MPA).enumerate() {
            let colour = along_palette(k, PRESSURES_MPA.len());
            // 0 and 0.002 MPa nearly coincide: the second is dashed, so that both are seen.
            straight(&mut chart, slope, colour, if k == 1 { 8 } else { 0 })?;
            ends.push((slope * DEFLECTION_MM, format!("{pressure_mpa} MPa"), colour));
        }
        name_at_right_ends(panel, &chart, &ends)?;
    }
    Ok(())
}

/// Fig. 9: before, target and after, by contact ratio, at the greatest deflection.
fn compensation(root: &Panel<'_>, model: &Model) -> Result<()> {
    let cases = [
        ("Case 1: 65 mm for a neighbour of 70 mm", 65.0, 70.0),
        ("Self: trimmed from 70 to 65 mm", 65.0, 70.0),
        ("Case 2: 70 mm for a neighbour of 65 mm", 70.0, 65.0),
    ];
    for (panel, (title, length_mm, target_mm)) in root.split_evenly((1, 3)).iter().zip(cases) {
        let start = Megapascal::new(0.1)?;
        let target = Target { length: Millimetre::new(target_mm)?, pressure: start };
        let compensator = Compensator {
            length: Millimetre::new(length_mm)?,
            pressure: start,
            pressure_min: Megapascal::ZERO,
            pressure_max: Megapascal::EXAMINED_MAX,
        };
        let none = Offset::NONE;
        let solution = solve_setpoint(model, target, none, model, compensator, none, Objective::Tip)?;
        let setpoint_mpa = solution.setpoint().pressure.mpa();
        let curves = [
            (format!("before: {length_mm} mm at 0.1 MPa"), length_mm, 0.1, BLUE, Mark::Circle),
            (format!("target: {target_mm} mm at 0.1 MPa"), target_mm, 0.1, VERMILION, Mark::Square),
            (format!("after: {length_mm} mm at {setpoint_mpa:.3} MPa"), length_mm, setpoint_mpa, INK, Mark::Cross),
        ];
        let axes = Axes {
            title,
            x: ("contact ratio a", 0.42..1.03),
            y: ("strain at a deflection of 6 mm (mm/m)", 0.0..155.0),
        };
        let mut chart = chart(panel, &axes, 0)?;
        for (name, length_mm, pressure_mpa, colour, mark) in curves {
            let points = CONTACT_RATIOS
                .into_iter()
                .map(|a| {
                    let per_mm = sensitivity_per_mm(model, a, length_mm, pressure_mpa)?;
                    Ok((a, MM_PER_M * DEFLECTION_MM * per_mm))
                })
                .collect::<Result<Vec<_>>>()?;
            marked(&mut chart, points, name, colour, mark)?;
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    }
    Ok(())
}

fn sensitivity_per_mm(model: &Model, a: f64, length_mm: f64, pressure_mpa: f64) -> Result<f64> {
    let morphology = model.morphology(Megapascal::new(pressure_mpa)?);
    Ok(model.sensitivity_per_mm(ContactRatio::new(a)?, Millimetre::new(length_mm)?, &morphology)?)
}

/// A line through the origin up to the greatest deflection; `dash_px` above 0 dashes it.
fn straight(chart: &mut Chart<'_>, slope: f64, colour: RGBColor, dash_px: i32) -> Result<()> {
    let points = [(0.0, 0.0), (DEFLECTION_MM, slope * DEFLECTION_MM)];
    let style = colour.stroke_width(2);
    if dash_px > 0 {
        chart.draw_series(DashedLineSeries::new(points, dash_px, dash_px, style)).map_err(drawing)?;
    } else {
        chart.draw_series(LineSeries::new(points, style)).map_err(drawing)?;
    }
    Ok(())
}

/// The paper's marks.
#[derive(Clone, Copy)]
enum Mark {
    Circle,
    Square,
    Cross,
}

fn marked(chart: &mut Chart<'_>, points: Vec<(f64, f64)>, name: String, colour: RGBColor, mark: Mark) -> Result<()> {
    let line = colour.stroke_width(2);
    chart.draw_series(LineSeries::new(points.clone(), line)).map_err(drawing)?;
    let stroke = move |x: i32, y: i32| EmptyElement::at((x + 11, y)) + PathElement::new([(-11, 0), (11, 0)], line);
    let square = move || Rectangle::new([(-4, -4), (4, 4)], colour.filled());
    match mark {
        Mark::Circle => chart
            .draw_series(points.into_iter().map(|at| Circle::new(at, 5, line)))
            .map_err(drawing)?
            .label(name)
            .legend(move |(x, y)| stroke(x, y) + Circle::new((0, 0), 5, line)),
        Mark::Square => chart
            .draw_series(points.into_iter().map(|at| EmptyElement::at(at) + square()))
            .map_err(drawing)?
            .label(name)
            .legend(move |(x, y)| stroke(x, y) + square()),
        Mark::Cross => chart
            .draw_series(points.into_iter().map(|at| Cross::new(at, 5, line)))
            .map_err(drawing)?
            .label(name)
            .legend(move |(x, y)| stroke(x, y) + Cross::new((0, 0), 5, line)),
    };
    Ok(())
}
