//! The model's curves of Fig. 7, 8 and 9, in the published formulation.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::prelude::*;
use vibrissa_core::mechanics::{
    CONTACT_RATIOS, Compensator, Formulation, Model, Objective, Offset, Target, solve_setpoint,
};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

use super::{
    Axes, BLUE, Chart, GREEN, INK, PURPLE, Panel, VERMILION, along_palette, chart, drawing, legend, name_at_right_ends,
};

/// The paper's intact whisker.
const LENGTH_MM: f64 = 70.0;
/// Largest deflection in the paper.
const DEFLECTION_MM: f64 = 6.0;
const PRESSURES_MPA: [f64; 6] = [0.0, 0.002, 0.05, 0.1, 0.15, 0.2];
/// Strains are drawn in mm/m.
const MM_PER_M: f64 = 1e3;

/// Draws the figures into a folder; returns their paths.
///
/// # Errors
/// A file cannot be written.
pub fn draw(folder: &Path) -> Result<Vec<PathBuf>> {
    let model = Model::nguyen_2021(Formulation::Published);
    let figures: [(&str, (u32, u32), Figure); 7] = [
        ("fig-7-normal-mode.svg", (880, 640), normal_mode),
        ("fig-8-pressure.svg", (1400, 1600), pressures),
        ("fig-9-compensation.svg", (1300, 520), compensation),
        ("beyond-the-paper.svg", (880, 480), beyond),
        ("fig-9a-case-1.svg", (1400, 1600), |root, model| by_deflection(root, model, &CASES[0])),
        ("fig-9b-self.svg", (1400, 1600), |root, model| by_deflection(root, model, &CASES[1])),
        ("fig-9c-case-2.svg", (1400, 1600), |root, model| by_deflection(root, model, &CASES[2])),
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

/// Fig. 8: strain against deflection under pressure, a panel for each contact ratio.
fn pressures(root: &Panel<'_>, model: &Model) -> Result<()> {
    for (panel, a) in root.split_evenly((4, 3)).iter().zip(CONTACT_RATIOS) {
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
            // 0 and 0.002 MPa nearly coincide: the second is dashed, so that both are visible.
            straight(&mut chart, slope, colour, if k == 1 { 8 } else { 0 })?;
            ends.push((slope * DEFLECTION_MM, format!("{pressure_mpa} MPa"), colour));
        }
        name_at_right_ends(panel, &chart, &ends)?;
    }
    Ok(())
}

/// One of the paper's compensation experiments.
struct Case {
    title: &'static str,
    length_mm: f64,
    target_mm: f64,
}

const CASES: [Case; 3] = [
    Case { title: "Case 1: 65 mm for a neighbour of 70 mm", length_mm: 65.0, target_mm: 70.0 },
    Case { title: "Self: trimmed from 70 to 65 mm", length_mm: 65.0, target_mm: 70.0 },
    Case { title: "Case 2: 70 mm for a neighbour of 65 mm", length_mm: 70.0, target_mm: 65.0 },
];
/// Lengths of the compensator in the figure beyond the paper, and their steps, mm.
const BEYOND_MM: (f64, f64) = (38.0, 70.0);
const BEYOND_STEP_MM: f64 = 0.5;
/// Initial pressure of both whiskers.
const START_MPA: f64 = 0.1;

/// A response that is compared in a case.
struct Compared {
    name: String,
    length_mm: f64,
    pressure_mpa: f64,
    colour: RGBColor,
    mark: Mark,
}

impl Case {
    /// Before, target and after, with the model's setpoint.
    fn compared(&self, model: &Model) -> Result<[Compared; 3]> {
        let start = Megapascal::new(START_MPA)?;
        let target = Target { length: Millimetre::new(self.target_mm)?, pressure: start };
        let compensator = Compensator {
            length: Millimetre::new(self.length_mm)?,
            pressure: start,
            pressure_min: Megapascal::ZERO,
            pressure_max: Megapascal::EXAMINED_MAX,
        };
        let none = Offset::NONE;
        let solution = solve_setpoint(model, target, none, model, compensator, none, Objective::Tip)?;
        let setpoint_mpa = solution.setpoint().pressure.mpa();
        let whiskers = [
            ("before", self.length_mm, START_MPA, BLUE, Mark::Circle),
            ("target", self.target_mm, START_MPA, VERMILION, Mark::Square),
            ("after", self.length_mm, setpoint_mpa, INK, Mark::Cross),
        ];
        Ok(whiskers.map(|(name, length_mm, pressure_mpa, colour, mark)| {
            let pressure = format!("{pressure_mpa:.3}");
            let name = format!("{name}: {length_mm} mm at {} MPa", pressure.trim_end_matches('0'));
            Compared { name, length_mm, pressure_mpa, colour, mark }
        }))
    }
}

/// Fig. 9 in summary: before, target and after, by contact ratio, at the largest deflection.
fn compensation(root: &Panel<'_>, model: &Model) -> Result<()> {
    for (panel, case) in root.split_evenly((1, 3)).iter().zip(&CASES) {
        let axes = Axes {
            title: case.title,
            x: ("contact ratio a", 0.42..1.03),
            y: ("strain at a deflection of 6 mm (mm/m)", 0.0..155.0),
        };
        let mut chart = chart(panel, &axes, 0)?;
        for one in case.compared(model)? {
            let points = CONTACT_RATIOS
                .into_iter()
                .map(|a| {
                    let per_mm = sensitivity_per_mm(model, a, one.length_mm, one.pressure_mpa)?;
                    Ok((a, MM_PER_M * DEFLECTION_MM * per_mm))
                })
                .collect::<Result<Vec<_>>>()?;
            marked(&mut chart, points, one.name, one.colour, one.mark)?;
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    }
    Ok(())
}

/// Predicted mean error over the compensator's length, for a target of 70 mm: air alone, gain alone, and both.
fn beyond(root: &Panel<'_>, model: &Model) -> Result<()> {
    let axes = Axes {
        title: "Compensation error of a shorter whisker for one of 70 mm (Eq. 35, mean over the contact ratios)",
        x: ("length of the compensator (mm)", BEYOND_MM.0..BEYOND_MM.1),
        y: ("predicted mean error (%)", 0.0..80.0),
    };
    let mut chart = chart(root, &axes, 0)?;
    let whole = Megapascal::EXAMINED_MAX.mpa();
    // Objective, range of the pressure in MPa, name.
    let ways = [
        (Objective::Tip, (0.0, whole), "the paper's pressure: equal at the tip", VERMILION),
        (Objective::Mean, (0.0, whole), "best single pressure, air alone", GREEN),
        (Objective::Shape, (START_MPA, START_MPA), "one gain, no air", PURPLE),
        (Objective::Shape, (0.0, whole), "air for the shape, one gain", BLUE),
    ];
    for (objective, range_mpa, name, colour) in ways {
        let steps = ((BEYOND_MM.1 - BEYOND_MM.0) / BEYOND_STEP_MM) as u32;
        let points = (0..steps)
            .map(|step| BEYOND_MM.0 + BEYOND_STEP_MM * f64::from(step))
            .map(|length_mm| Ok((length_mm, 100.0 * predicted_error(model, length_mm, objective, range_mpa)?)))
            .collect::<Result<Vec<_>>>()?;
        let line = colour.stroke_width(2);
        let series = chart.draw_series(LineSeries::new(points, line)).map_err(drawing)?;
        series.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], line));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)
}

/// Predicted mean error as a ratio, for a target of [`LENGTH_MM`].
fn predicted_error(model: &Model, length_mm: f64, objective: Objective, (low, high): (f64, f64)) -> Result<f64> {
    let start = Megapascal::new(START_MPA)?;
    let target = Target { length: Millimetre::new(LENGTH_MM)?, pressure: start };
    let compensator = Compensator {
        length: Millimetre::new(length_mm)?,
        pressure: start,
        pressure_min: Megapascal::new(low)?,
        pressure_max: Megapascal::new(high)?,
    };
    let none = Offset::NONE;
    Ok(solve_setpoint(model, target, none, model, compensator, none, objective)?.setpoint().error.mean)
}

/// Fig. 9A to C: before, target and after against deflection, a panel for each contact ratio.
fn by_deflection(root: &Panel<'_>, model: &Model, case: &Case) -> Result<()> {
    for (panel, a) in root.split_evenly((4, 3)).iter().zip(CONTACT_RATIOS) {
        let compared = case.compared(model)?;
        let mut slopes = Vec::new();
        for one in &compared {
            slopes.push(MM_PER_M * sensitivity_per_mm(model, a, one.length_mm, one.pressure_mpa)?);
        }
        let steepest = slopes.iter().copied().fold(0.0, f64::max);
        let axes = Axes {
            title: &format!("{}, contact ratio {a}", case.title),
            x: ("deflection at the contact (mm)", 0.0..DEFLECTION_MM),
            y: ("mean strain of the gauge (mm/m)", 0.0..1.1 * DEFLECTION_MM * steepest),
        };
        let mut chart = chart(panel, &axes, 0)?;
        for (one, slope) in compared.into_iter().zip(slopes) {
            let points = (0..=12).map(|half| 0.5 * f64::from(half)).map(|mm| (mm, slope * mm)).collect();
            marked(&mut chart, points, one.name, one.colour, one.mark)?;
        }
        legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
    }
    Ok(())
}

fn sensitivity_per_mm(model: &Model, a: f64, length_mm: f64, pressure_mpa: f64) -> Result<f64> {
    let morphology = model.morphology(Megapascal::new(pressure_mpa)?);
    Ok(model.sensitivity_per_mm(ContactRatio::new(a)?, Millimetre::new(length_mm)?, &morphology)?)
}

/// A line through the origin up to the largest deflection; `dash_px` above 0 dashes it.
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

/// Markers as in the paper.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    Circle,
    Square,
    Cross,
}

pub(super) fn marked(
    chart: &mut Chart<'_>,
    points: Vec<(f64, f64)>,
    name: String,
    colour: RGBColor,
    mark: Mark,
) -> Result<()> {
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
