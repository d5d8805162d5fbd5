//! Writes each measurement as a line of JSON, and finally a table of targets and results.

use std::fmt::{self, Write as _};
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

use anyhow::Context;
use serde_json::{Value, json};

/// Collects measurements and results.
pub struct Report {
    file: File,
    path: PathBuf,
    rows: Vec<Row>,
}

/// A row of the final table.
struct Row {
    part: &'static str,
    what: String,
    target: String,
    measured: String,
    beside: String,
    is_met: Option<bool>,
}

/// Target of a figure.
#[derive(Debug, Clone, Copy)]
pub enum Target {
    /// The figure must be at least this.
    AtLeast(f64),
    /// The figure must be at most this.
    AtMost(f64),
    /// The figure has no target.
    None,
}

/// A value and its unit, as the table shows them.
#[derive(Debug, Clone, Copy)]
pub struct Figure(pub f64, pub &'static str);

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value, unit) = *self;
        match value.abs() {
            1e4.. => write!(f, "{:.0}k", value / 1e3)?,
            1e3.. => write!(f, "{:.1}k", value / 1e3)?,
            100.0.. => write!(f, "{value:.0}")?,
            10.0.. => write!(f, "{value:.1}")?,
            _ => write!(f, "{value:.2}")?,
        }
        if unit.is_empty() { Ok(()) } else { write!(f, " {unit}") }
    }
}

impl Report {
    /// Creates or replaces the file of measurements.
    pub fn new(path: PathBuf) -> anyhow::Result<Self> {
        let file = File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { file, path, rows: Vec::new() })
    }

    /// Path of the file of measurements.
    pub fn path(&self) -> &std::path::Path {
        &self.path
    }

    /// Writes one measurement.
    pub fn line(&mut self, part: &str, round: usize, measured: Value) -> anyhow::Result<()> {
        let mut line = json!({ "part": part, "round": round });
        if let (Some(line), Value::Object(measured)) = (line.as_object_mut(), measured) {
            line.extend(measured);
        }
        writeln!(self.file, "{line}").context("writing the measurements")
    }

    /// Adds a row with a target and its result. NaN means that it was not measured.
    pub fn row(
        &mut self,
        part: &'static str,
        what: &str,
        target: Target,
        measured: Figure,
        beside: String,
    ) -> anyhow::Result<()> {
        let Figure(value, unit) = measured;
        let (target, is_met) = match target {
            Target::AtLeast(least) => (format!(">= {}", Figure(least, unit)), Some(value >= least)),
            Target::AtMost(most) => (format!("<= {}", Figure(most, unit)), Some(value <= most)),
            Target::None => (String::new(), None),
        };
        let is_met = if value.is_nan() { None } else { is_met };
        let met = is_met.map(|is_met| if is_met { "met" } else { "missed" });
        writeln!(
            self.file,
            "{}",
            json!({ "part": part, "target": target, "what": what, "measured": value, "unit": unit, "beside": beside, "result": met })
        )?;
        self.rows.push(Row { part, what: what.to_owned(), target, measured: measured.to_string(), beside, is_met });
        Ok(())
    }

    /// The table in Markdown.
    pub fn table(&self) -> String {
        let mut lines = vec![["part", "figure", "target", "measured", "comparison", ""].map(str::to_owned)];
        lines.extend(self.rows.iter().map(|row| {
            let met = row.is_met.map_or("", |is_met| if is_met { "met" } else { "MISSED" });
            [row.part, &row.what, &row.target, &row.measured, &row.beside, met].map(str::to_owned)
        }));
        let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let widths: [usize; 6] = std::array::from_fn(width);
        let mut text = String::new();
        for (at, line) in lines.iter().enumerate() {
            for (cell, width) in line.iter().zip(widths) {
                let _ = write!(text, "| {cell:width$} ");
            }
            text.push_str("|\n");
            if at == 0 {
                widths.iter().for_each(|width| text.push_str(&format!("|-{}-", "-".repeat(*width))));
                text.push_str("|\n");
            }
        }
        text
    }
}

/// Median; the upper one of an even number of values, NaN if there are no values.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Quantile of ascending values: microseconds in, milliseconds out.
pub fn quantile_ms(ascending_us: &[u64], share: f64) -> f64 {
    let at = (ascending_us.len().saturating_sub(1) as f64 * share).round() as usize;
    ascending_us.get(at).map_or(f64::NAN, |&us| us as f64 / 1e3)
}
