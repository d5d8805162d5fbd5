//! Detection delay over the size of the cut, beside the oracle's.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::prelude::*;
use vibrissa_evaluation::detection::{Delay, Evaluation};

use super::{Axes, BLUE, Chart, INK, Panel, VERMILION, chart, drawing, legend};

/// Draws the delays into a folder; returns the path of the file.
///
/// # Errors
/// The file cannot be written.
pub fn draw(found: &Evaluation, folder: &Path) -> Result<PathBuf> {
    let path = folder.join("detection-delay.svg");
    let mut moments: Vec<u32> = found.delays.iter().map(|delay| delay.change_at).collect();
    moments.dedup();
    let root = SVGBackend::new(&path, (700 * moments.len() as u32, 560)).into_drawing_area();
    root.fill(&WHITE).map_err(drawing)?;
    for (panel, &at) in root.split_evenly((1, moments.len())).iter().zip(&moments) {
        let delays: Vec<&Delay> = found.delays.iter().filter(|delay| delay.change_at == at).collect();
        one(panel, at, &delays)?;
    }
    root.present().map_err(drawing)?;
    drop(root);
    Ok(path)
}

/// Both axes are logarithmic, because delays range from one contact to thousands.
fn one(panel: &Panel<'_>, at: u32, delays: &[&Delay]) -> Result<()> {
    let most = delays.iter().map(|delay| delay.alarm.max(delay.lorden)).fold(10.0, f64::max);
    let (least_mm, most_mm) =
        delays.iter().fold((f64::MAX, 0.0_f64), |(least, most), one| (least.min(one.size_mm), most.max(one.size_mm)));
    let axes = Axes {
        title: &format!("Cut at contact {at}: contacts to the alarm"),
        x: ("log10 of the cut (mm)", least_mm.log10() - 0.1..most_mm.log10() + 0.1),
        y: ("log10 of the mean number of contacts", -0.3..most.log10() + 0.2),
    };
    let mut chart = chart(panel, &axes, 0)?;
    let of = |value: fn(&Delay) -> f64| -> Vec<(f64, f64)> {
        delays.iter().map(|delay| (delay.size_mm.log10(), value(delay).max(0.5).log10())).collect()
    };
    curve(&mut chart, "this detector", of(|delay| delay.alarm), BLUE)?;
    curve(&mut chart, "oracle: knows the size", of(|delay| delay.oracle), VERMILION)?;
    curve(&mut chart, "Lorden: log(ARL0) / KL", of(|delay| delay.lorden), INK)?;
    legend(&mut chart, SeriesLabelPosition::UpperRight)
}

fn curve(chart: &mut Chart<'_>, name: &str, points: Vec<(f64, f64)>, colour: RGBColor) -> Result<()> {
    let line = LineSeries::new(points, colour.stroke_width(2)).point_size(3);
    chart
        .draw_series(line)
        .map_err(drawing)?
        .label(name)
        .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(2)));
    Ok(())
}
