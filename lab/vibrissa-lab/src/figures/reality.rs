//! Delays, false reports and errors of `vibrissa-lab evaluate reality`, one line for each row.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use vibrissa_evaluation::reality::Figures;

use super::{BLUE, FONT, GRID, INK, Panel, VERMILION, drawing};

const LEFT: i32 = 130;
const TOP: i32 = 70;
const LINE: i32 = 22;
const BARS: i32 = 190;
const GAP: i32 = 60;

/// One column of bars.
struct Column {
    title: &'static str,
    /// Value at the full width.
    full: f64,
    of: fn(&Figures) -> Option<f64>,
    good: bool,
}

const COLUMNS: [Column; 5] = [
    Column {
        title: "cuts of 2 mm or more found, %",
        full: 100.0,
        of: |one| one.found_from_2_mm().ratio().map(|share| 100.0 * share),
        good: true,
    },
    Column {
        title: "contacts to the report, median",
        full: 100.0,
        of: |one| one.call().map(|call| call.median),
        good: false,
    },
    Column {
        title: "false trims per million",
        full: 20.0,
        of: |one| Some(one.healthy.per_million(one.healthy.trims)),
        good: false,
    },
    Column {
        title: "lengths in their interval, %",
        full: 100.0,
        of: |one| one.length_covered().ratio().map(|share| 100.0 * share),
        good: true,
    },
    Column {
        title: "error of a reading with gain, %",
        full: 20.0,
        of: |one| one.reading_error().map(|error| 100.0 * error),
        good: false,
    },
];

/// Draws the rows into a folder; returns the path of the file.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn draw(found: &[Figures], folder: &Path) -> Result<PathBuf> {
    let path = folder.join("reality.svg");
    let size = (LEFT + (BARS + GAP) * COLUMNS.len() as i32, TOP + LINE * found.len() as i32 + 20);
    let root = SVGBackend::new(&path, (size.0 as u32, size.1 as u32)).into_drawing_area();
    root.fill(&WHITE).map_err(drawing)?;
    let title = "Whiskers as they really are: one nuisance in each row, at multiples of its real strength";
    root.draw(&Text::new(title, (14, 12), (FONT, 17).into_font().color(&INK))).map_err(drawing)?;
    for (at, column) in (0..).zip(&COLUMNS) {
        let style = (FONT, 13).into_font().color(&INK);
        root.draw(&Text::new(column.title, (LEFT + (BARS + GAP) * at, TOP - 22), style)).map_err(drawing)?;
    }
    for (line, figures) in (0..).zip(found) {
        let middle = TOP + LINE * line + LINE / 2;
        let style = (FONT, 13).into_font().color(&INK).pos(Pos::new(HPos::Right, VPos::Center));
        let name = format!("{} {}", figures.row.nuisance.word(), figures.row.strength);
        root.draw(&Text::new(name, (LEFT - 8, middle), style)).map_err(drawing)?;
        for (at, column) in (0..).zip(&COLUMNS) {
            bar(&root, (LEFT + (BARS + GAP) * at, middle), column, figures)?;
        }
    }
    root.present().map_err(drawing)?;
    drop(root);
    Ok(path)
}

/// Blue where more is better, and vermilion where less is; a longer value than the full width is cut off.
fn bar(root: &Panel<'_>, (left, middle): (i32, i32), column: &Column, figures: &Figures) -> Result<()> {
    let style = (FONT, 12).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    let value = (column.of)(figures);
    let share = (value.unwrap_or(0.0) / column.full).clamp(0.0, 1.0);
    let right = left + (share * f64::from(BARS)).round() as i32;
    let corners = |right: i32| [(left, middle - LINE / 2 + 3), (right, middle + LINE / 2 - 3)];
    root.draw(&Rectangle::new(corners(left + BARS), GRID.mix(0.4).filled())).map_err(drawing)?;
    let colour = if column.good { BLUE } else { VERMILION };
    root.draw(&Rectangle::new(corners(right), colour.filled())).map_err(drawing)?;
    let text = value.map_or("-".to_owned(), |value| format!("{value:.1}"));
    root.draw(&Text::new(text, (left + BARS + 4, middle), style)).map_err(drawing)?;
    Ok(())
}
