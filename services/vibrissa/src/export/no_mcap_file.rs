//! The program without MCAP.

use std::io::BufRead;
use std::path::Path;

use anyhow::bail;

/// What was written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Report {
    /// Messages in the file.
    pub messages: u64,
    /// Lines without a JSON object, which the file does not contain.
    pub left_out: u64,
}

/// Always fails.
///
/// # Errors
/// This program cannot write MCAP files.
pub fn write(
    _: impl BufRead,
    _: &Path,
    _: fn(&str) -> Option<&'static str>,
    _: impl FnMut(u64) -> anyhow::Result<()>,
) -> anyhow::Result<Report> {
    bail!("this program was built without MCAP: build it with --features export");
}
