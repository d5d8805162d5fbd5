//! The confusion matrix of `vibrissa-lab evaluate health` as a heat map.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use vibrissa_evaluation::health::{ClassReport, Report};

use super::{BLUE, FONT, INK, Panel, VERMILION, drawing};

const CELL: (i32, i32) = (78, 40);
const LEFT: i32 = 170;
const TOP: i32 = 150;

/// Draws the matrix into a folder; returns the path of the file.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn draw(report: &Report, folder: &Path) -> Result<PathBuf> {
    let path = folder.join("health.svg");
    let columns = Report::columns();
    let size = (LEFT + CELL.0 * columns.len() as i32 + 30, TOP + CELL.1 * report.classes.len() as i32 + 30);
    let root = SVGBackend::new(&path, (size.0 as u32, size.1 as u32)).into_drawing_area();
    root.fill(&WHITE).map_err(drawing)?;
    let title = format!(
        "True class (rows) and first reported class (columns), in % of the cases: {:.1} % right",
        100.0 * report.right()
    );
    root.draw(&Text::new(title, (14, 12), (FONT, 17).into_font().color(&INK))).map_err(drawing)?;
    for (column, name) in (0..).zip(&columns) {
        let at = (LEFT + CELL.0 * column + CELL.0 / 2, TOP - 10);
        // Rotated, so that long names fit; anchored at their ends.
        let style = (FONT, 13).into_font().transform(FontTransform::Rotate270).color(&INK);
        let style = style.pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(*name, at, style)).map_err(drawing)?;
    }
    for (row, class) in (0..).zip(&report.classes) {
        let style = (FONT, 13).into_font().color(&INK).pos(Pos::new(HPos::Right, VPos::Center));
        let at = (LEFT - 8, TOP + CELL.1 * row + CELL.1 / 2);
        root.draw(&Text::new(class.truth.word(), at, style)).map_err(drawing)?;
        draw_row(&root, row, class)?;
    }
    root.present().map_err(drawing)?;
    drop(root);
    Ok(path)
}

/// Correct reports in blue, wrong ones in vermilion, darker for more cases.
fn draw_row(root: &Panel<'_>, row: i32, class: &ClassReport) -> Result<()> {
    for (column, &count) in (0..).zip(&class.called) {
        let part = f64::from(count) / f64::from(class.cases.max(1));
        let colour = if column == class.truth as i32 { BLUE } else { VERMILION };
        let (left, top) = (LEFT + CELL.0 * column, TOP + CELL.1 * row);
        let corners = [(left, top), (left + CELL.0 - 2, top + CELL.1 - 2)];
        // A single wrong case must be visible.
        let shade = if count == 0 { 0.03 } else { 0.15 + 0.85 * part };
        root.draw(&Rectangle::new(corners, colour.mix(shade).filled())).map_err(drawing)?;
        if count > 0 {
            let ink = if shade > 0.6 { WHITE } else { INK };
            let style = (FONT, 14).into_font().color(&ink).pos(Pos::new(HPos::Center, VPos::Center));
            let at = (left + CELL.0 / 2, top + CELL.1 / 2);
            root.draw(&Text::new(format!("{:.1}", 100.0 * part), at, style)).map_err(drawing)?;
        }
    }
    Ok(())
}
