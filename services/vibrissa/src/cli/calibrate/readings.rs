//! Readings from a CSV file; every error names the line and the column.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use csv::{ReaderBuilder, StringRecord, Trim};
use vibrissa_core::mechanics::CalibrationRow;
use vibrissa_core::units::{Megapascal, Millimetre, Strain};

/// A reading with its line in the file.
pub(super) struct Reading {
    pub(super) line: u64,
    pub(super) row: CalibrationRow,
}

const PRESSURE: &str = "pressure_mpa";
const ELONGATION: &str = "elongation_mm";
/// Strain columns: name, one unit in m/m, and whether the reading still contains the gauge factor.
const STRAINS: [(&str, f64, bool); 3] =
    [("strain", 1.0, false), ("strain_reading_um_per_m", 1e-6, true), ("strain_reading_mm_per_m", 1e-3, true)];

/// Indices of the columns.
struct Columns {
    pressure: usize,
    strain: usize,
    strain_name: &'static str,
    /// Factor from the number in the file to m/m.
    strain_factor: f64,
    elongation: Option<usize>,
}

/// Reads the file.
pub(super) fn read(path: &Path, gauge_factor: f64) -> Result<Vec<Reading>> {
    let name = path.display();
    let mut reader = ReaderBuilder::new()
        .trim(Trim::All)
        .comment(Some(b'#'))
        .from_path(path)
        .with_context(|| format!("reading {name}"))?;
    let header = reader.headers().with_context(|| format!("reading {name}"))?.clone();
    let columns = Columns::find(&header, gauge_factor).with_context(|| format!("{name}, header"))?;
    let mut readings = Vec::new();
    for record in reader.records() {
        // The csv crate's error names the line.
        let record = record.with_context(|| format!("reading {name}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        let row = columns.row(&record).with_context(|| format!("{name}, line {line}"))?;
        readings.push(Reading { line, row });
    }
    Ok(readings)
}

impl Columns {
    fn find(header: &StringRecord, gauge_factor: f64) -> Result<Self> {
        let position = |name: &str| header.iter().position(|column| column == name);
        for column in header {
            let known = column == PRESSURE || column == ELONGATION || STRAINS.iter().any(|(name, ..)| *name == column);
            ensure!(known, "unknown column {column:?}; known are {PRESSURE}, {}, {ELONGATION}", strain_names());
            ensure!(header.iter().filter(|other| *other == column).count() == 1, "column {column} appears twice");
        }
        let found: Vec<_> = STRAINS.iter().filter_map(|strain| Some((position(strain.0)?, strain))).collect();
        let [(strain, (strain_name, unit, with_gauge_factor))] = found[..] else {
            bail!("exactly one of the columns {} is required", strain_names());
        };
        Ok(Self {
            pressure: position(PRESSURE).with_context(|| format!("missing column {PRESSURE}"))?,
            strain,
            strain_name,
            strain_factor: if *with_gauge_factor { unit / gauge_factor } else { *unit },
            elongation: position(ELONGATION),
        })
    }

    fn row(&self, record: &StringRecord) -> Result<CalibrationRow> {
        let pressure = number(record, self.pressure, PRESSURE)?;
        let pressure = pressure.with_context(|| format!("column {PRESSURE}: empty cell"))?;
        let strain = number(record, self.strain, self.strain_name)?;
        let elongation = match self.elongation {
            Some(column) => number(record, column, ELONGATION)?,
            None => None,
        };
        Ok(CalibrationRow {
            pressure: Megapascal::new(pressure).with_context(|| format!("column {PRESSURE}"))?,
            axial_strain: strain
                .map(|strain| Strain::new(strain * self.strain_factor))
                .transpose()
                .with_context(|| format!("column {}", self.strain_name))?,
            elongation: elongation.map(Millimetre::new).transpose().with_context(|| format!("column {ELONGATION}"))?,
        })
    }
}

/// The number in a cell; `None` if the cell is empty.
fn number(record: &StringRecord, column: usize, name: &str) -> Result<Option<f64>> {
    let text = record.get(column).unwrap_or_default();
    if text.is_empty() {
        return Ok(None);
    }
    text.parse().map(Some).with_context(|| format!("column {name}: {text:?} is not a number"))
}

fn strain_names() -> String {
    STRAINS.map(|(name, ..)| name).join(", ")
}
