//! Rows as a Parquet file.

use std::path::Path;

use vibrissa_store::export::{Cell, ExportTable};
use vibrissa_supervisor::parquet_rows::ParquetRows;

use super::RowFile;
use super::new_file::NewFile;

/// A Parquet file that is being written.
pub struct ParquetFile(ParquetRows<NewFile>);

impl ParquetFile {
    /// Creates the file.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn create(path: &Path, table: &ExportTable) -> anyhow::Result<Self> {
        ParquetRows::begin(NewFile::create(path)?, table.name, table.columns).map(Self)
    }
}

impl RowFile for ParquetFile {
    fn row(&mut self, cells: Vec<Cell>) -> anyhow::Result<()> {
        self.0.push(cells)
    }

    fn finish(self: Box<Self>) -> anyhow::Result<()> {
        self.0.finish()?.complete()
    }
}
