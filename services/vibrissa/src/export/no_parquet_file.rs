//! The program without Parquet.

use std::path::Path;

use anyhow::bail;
use vibrissa_store::export::{Cell, ExportTable};

use super::RowFile;

/// Stands for the Parquet writer: this build never creates one.
#[derive(Debug)]
pub enum ParquetFile {}

impl ParquetFile {
    /// Always fails.
    ///
    /// # Errors
    /// This program cannot write Parquet files.
    pub fn create(_: &Path, _: &ExportTable) -> anyhow::Result<Self> {
        bail!("this program was built without Parquet: build it with --features export, or use --csv");
    }
}

impl RowFile for ParquetFile {
    fn row(&mut self, _: Vec<Cell>) -> anyhow::Result<()> {
        match *self {}
    }

    fn finish(self: Box<Self>) -> anyhow::Result<()> {
        match *self {}
    }
}
