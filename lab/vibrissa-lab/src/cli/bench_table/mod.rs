//! Readings of a bench from a CSV file; every error names the line and the column.

mod columns;

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use csv::{ReaderBuilder, StringRecord, Trim};
use vibrissa_core::mechanics::BenchReading;
use vibrissa_core::units::Millimetre;
use vibrissa_protocol::text_file::read_text;

use self::columns::Columns;

pub(crate) use self::columns::HELP;

/// A reading with its line in the file.
pub(crate) struct Reading {
    pub(crate) line: u64,
    pub(crate) reading: BenchReading,
    /// Length of the whisker, if it is known.
    pub(crate) length: Option<Millimetre>,
}

/// Properties of the bench that give the numbers of a file their meaning.
pub(crate) struct Bench {
    /// Factor of readings that were taken with a gauge factor of 1.
    pub(crate) gauge_factor: f64,
    /// Length of the whisker where the column `length_mm` is missing or empty.
    pub(crate) length: Option<Millimetre>,
    /// End of the chamber, mm: a shorter whisker has no air.
    pub(crate) chamber_end_mm: f64,
}

/// Reads the file.
///
/// # Errors
/// The file cannot be read, or a number is missing or wrong: the error names line and column.
pub(crate) fn read(path: &Path, bench: &Bench) -> Result<Vec<Reading>> {
    let name = path.display();
    let text = read_text(path, FILE_BYTES_MAX).with_context(|| format!("reading {name}"))?;
    read_lines(&text, bench).with_context(|| name.to_string())
}

fn read_lines(text: &str, bench: &Bench) -> Result<Vec<Reading>> {
    // The library counts some line ends twice.
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut lines = (1..).zip(text.lines()).map(|(line, text)| (line, cells(text))).filter(|(_, cells)| {
        let is_separator = cells.get(0).is_some_and(|first| first.eq_ignore_ascii_case("sep="));
        !is_separator && cells.iter().any(|cell| !cell.is_empty())
    });
    let Some((_, header)) = lines.next() else { bail!("the table has no header: {FORMAT}") };
    check_separator(&header).context("header")?;
    let columns = Columns::find(&header, bench.gauge_factor).context("header")?;
    let mut readings = Vec::new();
    for (line, cells) in lines {
        let row = check_width(&cells, &header).and_then(|()| columns.row(&cells, bench));
        let (length, row) = row.with_context(|| format!("line {line}"))?;
        readings.extend(row.into_iter().map(|reading| Reading { line, reading, length }));
    }
    ensure!(!readings.is_empty(), "the table has no readings below its header: {FORMAT}");
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

#[cfg(test)]
mod tests {
    use super::*;

    fn lines_of(text: &str) -> Result<Vec<u64>, String> {
        let read = read_lines(text, &Bench { gauge_factor: 2.0, length: None, chamber_end_mm: 15.0 });
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
    fn regress_what_a_spreadsheet_writes_instead_of_a_number_has_a_hint() {
        for (cell, shown) in [
            ("6\u{a0}765", "\"6 765\" is not a number: write it without spaces, such as 6765"),
            ("6\u{202f}765", "\"6 765\" is not a number: write it without spaces, such as 6765"),
            ("\"0,05\"", "\"0,05\" is not a number: write it with a decimal point, such as 0.05"),
            ("#DIV/0!", "\"#DIV/0!\" is not a number, but an error of the spreadsheet: leave the cell empty"),
        ] {
            let problem = lines_of(&format!("pressure_mpa,strain\n0.05,{cell}\n")).unwrap_err();
            assert_eq!(problem, format!("line 2: column strain: {shown}"));
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
        assert!(lines_of("pressure_mpa,strain\n,,\n").unwrap_err().contains("no readings"));
    }

    #[test]
    fn regress_rows_of_contacts_name_the_missing_column() {
        let header = "pressure_mpa,strain,contact_ratio,deflection_mm,force_n,length_mm,strain_sd\n";
        for (row, problem) in [
            ("0.1,0.01,0.7,2,0.3,70,0.001", ""),
            ("0.1,0.01,0.7,,0.3,70,", "line 2: column deflection_mm: empty cell, but the row has a contact"),
            ("0.1,0.01,,2,,70,", "line 2: column deflection_mm: a contact needs its place"),
            ("0.1,0.01,,,0.3,70,", "line 2: column force_n: a contact needs its place"),
            ("0.1,0.01,0.7,2,0.3,,", "line 2: column contact_ratio: a ratio needs the whisker's length"),
            ("0.1,0.01,1.2,2,0.3,70,", "line 2: column contact_ratio: contact ratio is 1.2"),
            ("0.1,,0.7,2,,70,", "line 2: a contact without a reading"),
            ("0.1,0.01,0.7,2,-0.3,70,", "line 2: column force_n: must not be below 0 N, not -0.3"),
            ("0.1,0.01,0.7,2,0.3,12,", "line 2: column length_mm: a whisker of 12 mm is cut into its chamber"),
            ("0.1,0.01,0.7,2,0.3,70,0", "line 2: column strain_sd: a standard deviation must be above 0, not 0"),
            ("0.1,0.01,0.7,inf,0.3,70,", "line 2: column deflection_mm: \"inf\" is not a number"),
        ] {
            let read = lines_of(&format!("{header}{row}\n"));
            match read {
                Ok(lines) => assert!(problem.is_empty() && lines == [2, 2], "{row}: {lines:?}"),
                Err(found) => assert!(!problem.is_empty() && found.starts_with(problem), "{row}: {found}"),
            }
        }
        let beyond = lines_of("pressure_mpa,force_n,contact_mm,deflection_mm,length_mm\n0,1,71,2,70\n").unwrap_err();
        assert_eq!(beyond, "line 2: column contact_mm: 71 mm is beyond the tip of a whisker of 70 mm");
        let both = lines_of("pressure_mpa,force_n,contact_mm,contact_ratio\n").unwrap_err();
        assert_eq!(both, "header: the columns contact_mm and contact_ratio exclude each other");
        assert!(
            lines_of("pressure_mpa,strain,force_sd_n\n").unwrap_err().contains("force_sd_n needs the column force_n")
        );
    }
}
