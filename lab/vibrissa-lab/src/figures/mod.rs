//! SVG figures of the paper's curves, of evaluations and of the demo, on a light ground, in the palette of Okabe and Ito.

pub(crate) mod bench;
pub mod calibration;
pub mod detection;
pub mod evaluation;
pub mod health;
pub mod paper;
pub mod reality;

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Blue and vermilion of Okabe and Ito's palette: told apart with any colour vision.
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const VERMILION: RGBColor = RGBColor(213, 94, 0);
/// The palette's others, for more than two.
const GREEN: RGBColor = RGBColor(0, 158, 115);
const PURPLE: RGBColor = RGBColor(204, 121, 167);
const SKY: RGBColor = RGBColor(86, 180, 233);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const INK: RGBColor = RGBColor(34, 34, 34);
const GRID: RGBColor = RGBColor(225, 225, 225);
const FONT: &str = "sans-serif";

pub(crate) type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Colours for curves without an order.
pub(crate) const COLOURS: [RGBColor; 7] = [BLUE, VERMILION, GREEN, PURPLE, SKY, ORANGE, INK];

/// Title, axes and their ranges.
pub(crate) struct Axes<'t> {
    pub(crate) title: &'t str,
    pub(crate) x: (&'t str, std::ops::Range<f64>),
    pub(crate) y: (&'t str, std::ops::Range<f64>),
}

/// The plasma map without its light end: ordered, and told apart with any colour vision and in grey.
const ORDERED: [RGBColor; 6] = [
    RGBColor(13, 8, 135),
    RGBColor(84, 2, 163),
    RGBColor(139, 10, 165),
    RGBColor(185, 50, 137),
    RGBColor(219, 92, 104),
    RGBColor(240, 140, 60),
];

/// The colour of the `index`-th of `count` ordered curves.
fn along_palette(index: usize, count: usize) -> RGBColor {
    let at = index as f64 / (count.max(2) - 1) as f64 * (ORDERED.len() - 1) as f64;
    let low = (at as usize).min(ORDERED.len() - 2);
    let (from, to, share) = (ORDERED[low], ORDERED[low + 1], at - low as f64);
    let mix = |from: u8, to: u8| (f64::from(from) + share * (f64::from(to) - f64::from(from))).round() as u8;
    RGBColor(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}

pub(crate) type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A chart with grid, axis names and room at the right for names of curves.
pub(crate) fn chart<'a>(panel: &Panel<'a>, axes: &Axes<'_>, room_right: u32) -> Result<Chart<'a>> {
    let mut chart = ChartBuilder::on(panel)
        .caption(axes.title, (FONT, 17).into_font().color(&INK))
        .margin(14)
        .margin_right(14 + room_right)
        .x_label_area_size(44)
        .y_label_area_size(62)
        .build_cartesian_2d(axes.x.1.clone(), axes.y.1.clone())
        .map_err(drawing)?;
    chart
        .configure_mesh()
        .x_desc(axes.x.0)
        .y_desc(axes.y.0)
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .axis_desc_style((FONT, 14).into_font().color(&INK))
        .label_style((FONT, 13).into_font().color(&INK))
        .axis_style(INK)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .max_light_lines(0)
        .draw()
        .map_err(drawing)?;
    Ok(chart)
}

/// 0.05 as 0.05, 20 as 20.
fn tick(value: &f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}

/// Names of curves beside their right ends, moved apart where they would overlap.
///
/// `ends` holds height in data units, name and colour; the axes are linear.
fn name_at_right_ends(panel: &Panel<'_>, chart: &Chart<'_>, ends: &[(f64, String, RGBColor)]) -> Result<()> {
    const LINE_PX: i32 = 15;
    let area = chart.plotting_area();
    let right = chart.x_range().end;
    let mut labels: Vec<(i32, &str, RGBColor)> =
        ends.iter().map(|(y, name, colour)| (area.map_coordinate(&(right, *y)).1, name.as_str(), *colour)).collect();
    labels.sort_by_key(|label| std::cmp::Reverse(label.0));
    let x = area.map_coordinate(&(right, 0.0)).0 + 6;
    let (left_px, top_px) = panel.get_base_pixel();
    let mut free_px = i32::MAX;
    for (at_px, name, colour) in labels {
        let at_px = at_px.min(free_px);
        free_px = at_px - LINE_PX;
        let position = (x - left_px, at_px - top_px - LINE_PX / 2);
        let style = (FONT, 13).into_font().color(&colour);
        panel.draw(&Text::new(name.to_owned(), position, style)).map_err(drawing)?;
    }
    Ok(())
}

/// The legend, in the corner where it hides least.
pub(crate) fn legend(chart: &mut Chart<'_>, position: SeriesLabelPosition) -> Result<()> {
    chart
        .configure_series_labels()
        .position(position)
        .background_style(WHITE.mix(0.85))
        .border_style(GRID)
        .label_font((FONT, 13).into_font().color(&INK))
        .margin(8)
        .draw()
        .map_err(drawing)
}

/// plotters' errors borrow from the drawing; only their text outlives it.
pub(crate) fn drawing<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> anyhow::Error {
    anyhow!("drawing: {error}")
}
