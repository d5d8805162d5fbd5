//! Readings from a CSV file; every error names the line and the column.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
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
    check_separator(&header).with_context(|| format!("{name}, header"))?;
    let columns = Columns::find(&header, gauge_factor).with_context(|| format!("{name}, header"))?;
    let mut readings = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|problem| plain(&problem)).with_context(|| name.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let row = columns.row(&record).with_context(|| format!("{name}, line {line}"))?;
        readings.push(Reading { line, row });
    }
    ensure!(!readings.is_empty(), "{name}: the table has no rows below its header: {FORMAT}");
    Ok(readings)
}

/// Format of the table, for error messages.
const FORMAT: &str =
    "write a header such as pressure_mpa,strain and below it one line for each reading, such as 0.05,0.0146";

/// Spreadsheets with a decimal comma separate columns by other characters.
fn check_separator(header: &StringRecord) -> Result<()> {
    let text = header.iter().collect::<Vec<_>>().join(",");
    for (separator, name) in [(';', "semicolons"), ('\t', "tabs")] {
        ensure!(
            !text.contains(separator),
            "its columns are separated by {name}: separate them by commas, and write numbers with a decimal point, such as 0.05"
        );
    }
    Ok(())
}

/// The cause of a line that is not readable as CSV.
fn plain(problem: &csv::Error) -> anyhow::Error {
    let line = problem.position().map_or(0, csv::Position::line);
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's kinds: the text of the others is sufficient")]
    match problem.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => anyhow!(
            "line {line}: {len} cells, but the header has {expected_len} columns: write a number in each column, leave cells \
             without a reading empty, and write numbers with a decimal point"
        ),
        csv::ErrorKind::Utf8 { .. } => anyhow!("line {line}: the file is not UTF-8 text: save it as CSV in UTF-8"),
        _ => anyhow!("line {line}: {problem}"),
    }
}

impl Columns {
    fn find(header: &StringRecord, gauge_factor: f64) -> Result<Self> {
        let position = |name: &str| header.iter().position(|column| column == name);
        for column in header {
            let known = column == PRESSURE || column == ELONGATION || STRAINS.iter().any(|(name, ..)| *name == column);
            let hint = if column.to_ascii_lowercase().contains("kpa") {
                format!("; write pressures in MPa into {PRESSURE}: 100 kPa are 0.1 MPa")
            } else {
                String::new()
            };
            ensure!(known, "unknown column {column:?}; known are {PRESSURE}, {}, {ELONGATION}{hint}", strain_names());
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
            pressure: megapascal(pressure).with_context(|| format!("column {PRESSURE}"))?,
            axial_strain: strain
                .map(|strain| Strain::new(strain * self.strain_factor))
                .transpose()
                .with_context(|| format!("column {}", self.strain_name))?,
            elongation: elongation.map(Millimetre::new).transpose().with_context(|| format!("column {ELONGATION}"))?,
        })
    }
}

/// A pressure. Numbers of the size of kilopascals get a hint.
fn megapascal(value: f64) -> Result<Megapascal> {
    Megapascal::new(value).map_err(|problem| {
        let is_kpa = (1.0..=1000.0).contains(&value);
        let hint = if is_kpa { format!("; if it is in kPa, write {} MPa", value / 1000.0) } else { String::new() };
        anyhow!("{problem}{hint}")
    })
}

/// The number in a cell; `None` if the cell is empty.
fn number(record: &StringRecord, column: usize, name: &str) -> Result<Option<f64>> {
    let text = record.get(column).unwrap_or_default();
    if text.is_empty() {
        return Ok(None);
    }
    let number: f64 = text.parse().map_err(|_| {
        let hint = if text.contains(',') { ": write it with a decimal point, such as 0.05" } else { "" };
        anyhow!("column {name}: {text:?} is not a number{hint}")
    })?;
    Ok(Some(number))
}

fn strain_names() -> String {
    STRAINS.map(|(name, ..)| name).join(", ")
}
