//! Exports: tables of the database as CSV or Parquet files, and recordings as MCAP files.

pub mod csv_file;
#[cfg(feature = "export")]
pub mod mcap_file;
#[cfg(not(feature = "export"))]
#[path = "no_mcap_file.rs"]
pub mod mcap_file;
pub mod new_file;
#[cfg(feature = "export")]
pub mod parquet_file;
#[cfg(not(feature = "export"))]
#[path = "no_parquet_file.rs"]
pub mod parquet_file;

use vibrissa_store::export::Cell;

/// A file of rows that is being written.
pub trait RowFile {
    /// Writes a row.
    ///
    /// # Errors
    /// The file cannot be written.
    fn row(&mut self, cells: Vec<Cell>) -> anyhow::Result<()>;

    /// Completes the file. Before, it does not exist under its name.
    ///
    /// # Errors
    /// The file cannot be written.
    fn finish(self: Box<Self>) -> anyhow::Result<()>;
}

/// Numbers of messages in a written MCAP file, and of lines left out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct McapReport {
    /// Messages in the file.
    pub messages: u64,
    /// Lines without a JSON object, which the file does not contain.
    pub left_out: u64,
}
