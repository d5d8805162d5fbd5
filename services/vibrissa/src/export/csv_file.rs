//! Rows as a CSV file (RFC 4180). Times are RFC 3339 in UTC, with microseconds.

use std::path::Path;

use anyhow::Context;
use vibrissa_core::units::Micros;
use vibrissa_store::export::{Cell, ExportTable};
use vibrissa_supervisor::http::csv_rows::harmless;

use super::RowFile;
use super::new_file::NewFile;

/// A CSV file that is being written.
#[derive(Debug)]
pub struct CsvFile(csv::Writer<NewFile>);

impl CsvFile {
    /// Creates the file with its header row.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn create(path: &Path, table: &ExportTable) -> anyhow::Result<Self> {
        let mut writer =
            csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(NewFile::create(path)?);
        writer.write_record(table.columns.iter().map(|column| column.name))?;
        Ok(Self(writer))
    }
}

impl RowFile for CsvFile {
    fn row(&mut self, cells: Vec<Cell>) -> anyhow::Result<()> {
        self.0.write_record(cells.into_iter().map(text)).context("cannot write the rows")
    }

    fn finish(self: Box<Self>) -> anyhow::Result<()> {
        let file = self.0.into_inner().map_err(|problem| anyhow::Error::msg(problem.to_string()))?;
        file.complete()
    }
}

fn text(cell: Cell) -> String {
    match cell {
        Cell::Null => String::new(),
        Cell::Text(text) => harmless(&text),
        Cell::Whole(number) => number.to_string(),
        // The shortest text that reads as the same number.
        Cell::Real(number) => number.to_string(),
        Cell::Time(us) => time(us),
    }
}

/// RFC 3339 with microseconds, which the contract's timestamps do not have.
fn time(us: i64) -> String {
    let us = Micros(u64::try_from(us).unwrap_or_default());
    let at = std::time::UNIX_EPOCH + std::time::Duration::from_micros(us.0);
    humantime::format_rfc3339_micros(at).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_texts_that_read_as_the_same_values() {
        for (cell, expected) in [
            (Cell::Null, ""),
            (Cell::Text("=1".to_owned()), "'=1"),
            (Cell::Text("left".to_owned()), "left"),
            (Cell::Whole(-7), "-7"),
            (Cell::Real(0.1), "0.1"),
            (Cell::Real(-1e-9), "-0.000000001"),
            // `date -u -d @1795248000`
            (Cell::Time(1_795_248_000_000_001), "2026-11-21T08:00:00.000001Z"),
        ] {
            assert_eq!(text(cell), expected);
        }
    }
}
