//! Readings from a CSV file; every error names the line and the column.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use csv::{ReaderBuilder, StringRecord, Trim};
use vibrissa_core::mechanics::CalibrationRow;
use vibrissa_core::units::{Megapascal, Millimetre, Strain};
use vibrissa_protocol::text_file::read_text;

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
    let text = read_text(path, FILE_BYTES_MAX).with_context(|| format!("reading {name}"))?;
    read_lines(&text, gauge_factor).with_context(|| name.to_string())
}

fn read_lines(text: &str, gauge_factor: f64) -> Result<Vec<Reading>> {
    // The library counts some line ends twice.
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut lines = (1..).zip(text.lines()).map(|(line, text)| (line, cells(text))).filter(|(_, cells)| {
        let is_separator = cells.get(0).is_some_and(|first| first.eq_ignore_ascii_case("sep="));
        !is_separator && cells.iter().any(|cell| !cell.is_empty())
    });
    let Some((_, header)) = lines.next() else { bail!("the table has no header: {FORMAT}") };
    check_separator(&header).context("header")?;
    let columns = Columns::find(&header, gauge_factor).context("header")?;
    let mut readings = Vec::new();
    for (line, cells) in lines {
        let row = check_width(&cells, &header).and_then(|()| columns.row(&cells));
        readings.push(Reading { line, row: row.with_context(|| format!("line {line}"))? });
    }
    ensure!(!readings.is_empty(), "the table has no rows below its header: {FORMAT}");
    Ok(readings)
}

/// The cells of a line; none for a comment.
fn cells(line: &str) -> StringRecord {
    let mut reader =
        ReaderBuilder::new().has_headers(false).trim(Trim::All).comment(Some(b'#')).from_reader(line.as_bytes());
    // A line that is text has cells.
    reader.records().next().and_then(Result::ok).unwrap_or_default()
}

/// Spreadsheets write empty cells behind the last column, and in columns without a name.
fn check_width(cells: &StringRecord, header: &StringRecord) -> Result<()> {
    let named = (0..header.len()).rfind(|&index| !header[index].is_empty()).map_or(0, |last| last + 1);
    let is_nameless = |index: usize| header.get(index).is_none_or(str::is_empty);
    let extra = cells.iter().enumerate().any(|(index, cell)| is_nameless(index) && !cell.is_empty());
    ensure!(
        !extra && cells.len() >= named,
        "{} cells, but the header has {named} columns: write a number in each column, leave cells without a reading empty, \
         and write numbers with a decimal point",
        cells.len()
    );
    Ok(())
}

/// Size limit of a file, bytes.
const FILE_BYTES_MAX: u64 = 16 * 1024 * 1024;
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

impl Columns {
    fn find(header: &StringRecord, gauge_factor: f64) -> Result<Self> {
        let position = |name: &str| header.iter().position(|column| column == name);
        for column in header.iter().filter(|column| !column.is_empty()) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn lines_of(text: &str) -> Result<Vec<u64>, String> {
        let read = read_lines(text, 2.0);
        read.map(|rows| rows.iter().map(|row| row.line).collect()).map_err(|problem| format!("{problem:#}"))
    }

    #[test]
    fn regress_lines_are_counted_whatever_ends_them() {
        let text = "# a comment\n\npressure_mpa,strain\n0.05,0.01\n\n# another\n0.10,0.02\n0.15,oops\n";
        for end in ["\n", "\r\n", "\r"] {
            let problem = lines_of(&text.replace('\n', end)).unwrap_err();
            assert_eq!(problem, "line 8: column strain: \"oops\" is not a number", "{end:?}");
            assert_eq!(lines_of(&text.replace("oops", "0.03").replace('\n', end)), Ok(vec![4, 7, 8]), "{end:?}");
        }
    }

    #[test]
    fn regress_a_spreadsheets_empty_cells_and_rows_are_left_out() {
        let table = "sep=,\npressure_mpa,,strain,,\n0.05,,0.01,,\n,,,,\n0.10,,0.02\n,,\n\n";
        assert_eq!(lines_of(table), Ok(vec![3, 5]));
        assert_eq!(lines_of("\"pressure_mpa\",\"strain\"\n\"0.05\",\"0.01\"\n"), Ok(vec![2]));
        let problem = lines_of("pressure_mpa,strain,\n0.05,0.01,7\n").unwrap_err();
        assert!(problem.starts_with("line 2: 3 cells, but the header has 2 columns"), "{problem}");
        assert!(lines_of("pressure_mpa,strain\n0.05\n").unwrap_err().starts_with("line 2: 1 cells"));
        assert!(lines_of("# only a comment\n").unwrap_err().contains("no header"));
        assert!(lines_of("pressure_mpa,strain\n,,\n").unwrap_err().contains("no rows"));
    }
}
