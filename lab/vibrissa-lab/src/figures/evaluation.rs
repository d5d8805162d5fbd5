//! The evaluation of compensations, in figures like the paper's Fig. 9 and 10.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::prelude::*;
use vibrissa_core::mechanics::{ByRatio, CONTACT_RATIOS, ErrorProfile};
use vibrissa_evaluation::compensation::{CASES, Case, Outcome, Served, Truth, example, served_in};

use super::paper::{Mark, marked};
use super::{Axes, BLUE, GREEN, INK, PURPLE, Panel, VERMILION, chart, drawing, legend};

/// Largest deflection in the paper.
const DEFLECTION_MM: f64 = 6.0;
/// Strains are drawn in mm/m.
const MM_PER_M: f64 = 1e3;

/// Draws Fig. 9 for each case, on the first plant, and Fig. 10 over all plants; returns their paths.
///
/// # Errors
/// A file cannot be written.
pub fn draw(folder: &Path, outcomes: &[Outcome]) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for (case, file) in CASES.into_iter().zip(["fig-9-case-1.svg", "fig-9-self.svg", "fig-9-case-2.svg"]) {
        let Some(served) = example(case, outcomes) else { continue };
        paths.push(figure(folder, file, (1400, 1600), |root| responses(root, served))?);
    }
    paths.push(figure(folder, "fig-10.svg", (1500, 560), |root| errors(root, outcomes))?);
    Ok(paths)
}

fn figure(folder: &Path, file: &str, size: (u32, u32), draw: impl FnOnce(&Panel<'_>) -> Result<()>) -> Result<PathBuf> {
    let path = folder.join(file);
    let root = SVGBackend::new(&path, size).into_drawing_area();
    root.fill(&WHITE).map_err(drawing)?;
    draw(&root)?;
    root.present().map_err(drawing)?;
    drop(root);
    Ok(path)
}

/// Fig. 9: strain against deflection, a panel for each contact ratio.
fn responses(root: &Panel<'_>, served: &Served) -> Result<()> {
    let truth = Truth::new(&served.trial);
    let (before, target) = truth.before_and_target();
    let closed_mpa = served.closed.0;
    let compared: [(String, ByRatio, RGBColor, Mark); 5] = [
        ("before".to_owned(), before, BLUE, Mark::Circle),
        ("target".to_owned(), target, VERMILION, Mark::Square),
        (format!("after, open loop: {:.3} MPa", served.tip.0), truth.after(served.tip.0, None), PURPLE, Mark::Circle),
        (format!("after: {closed_mpa:.3} MPa"), truth.after(closed_mpa, None), INK, Mark::Cross),
        ("after with gain".to_owned(), truth.after(closed_mpa, Some(&served.gain)), GREEN, Mark::Cross),
    ];
    for (k, (panel, a)) in root.split_evenly((4, 3)).iter().zip(CONTACT_RATIOS).enumerate() {
        let slope = |per_mm: &ByRatio| MM_PER_M * per_mm[k].unwrap_or(0.0);
        let steepest = compared.iter().map(|one| slope(&one.1)).fold(0.0, f64::max);
        let title = format!("{}, contact ratio {a}", title(served));
        let axes = Axes {
            title: &title,
            x: ("deflection at the contact (mm)", 0.0..DEFLECTION_MM),
            y: ("mean strain of the gauge (mm/m)", 0.0..1.1 * DEFLECTION_MM * steepest),
        };
        let mut chart = chart(panel, &axes, 0)?;
        for (name, per_mm, colour, mark) in &compared {
            let points = (0..=12).map(|half| 0.5 * f64::from(half)).map(|mm| (mm, slope(per_mm) * mm)).collect();
            marked(&mut chart, points, name.clone(), *colour, *mark)?;
        }
        legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
    }
    Ok(())
}

fn title(served: &Served) -> String {
    let (length_mm, target_mm) = (served.trial.length_mm, served.trial.case.target_mm());
    match served.trial.case {
        Case::Shorter | Case::Longer => format!("{length_mm} mm for {target_mm} mm"),
        Case::Itself => format!("Trimmed from {target_mm} to {length_mm} mm"),
    }
}

/// Fig. 10: the error by contact ratio, mean over compensators and plants.
fn errors(root: &Panel<'_>, outcomes: &[Outcome]) -> Result<()> {
    type Pick = fn(&Served) -> &ErrorProfile;
    let kinds: [(&str, Pick, RGBColor, Mark); 4] = [
        ("open loop, tip", |one| &one.tip.1, PURPLE, Mark::Circle),
        ("closed loop", |one| &one.closed.1, INK, Mark::Cross),
        ("best single pressure", |one| &one.best.1, VERMILION, Mark::Square),
        ("closed loop with gain", |one| &one.with_gain, GREEN, Mark::Cross),
    ];
    let names = ["Case 1: 65-69 mm for 70 mm", "Self: 70 mm trimmed to 65-69 mm", "Case 2: 66-70 mm for 65 mm"];
    for ((panel, case), name) in root.split_evenly((1, 3)).iter().zip(CASES).zip(names) {
        let axes = Axes { title: name, x: ("contact ratio a", 0.42..1.03), y: ("mean error, eq. 35 (%)", 0.0..80.0) };
        let mut chart = chart(panel, &axes, 0)?;
        let count = served_in(case, outcomes).count().max(1) as f64;
        for (name, pick, colour, mark) in kinds {
            let points = CONTACT_RATIOS.into_iter().enumerate().map(|(k, a)| {
                let total: f64 = served_in(case, outcomes).map(|one| pick(one).by_ratio[k]).sum();
                (a, 100.0 * total / count)
            });
            marked(&mut chart, points.collect(), name.to_owned(), colour, mark)?;
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    }
    Ok(())
}
