//! The program without MCAP.

use std::io::BufRead;
use std::path::Path;

use anyhow::bail;

use super::McapReport;

/// Always fails.
///
/// # Errors
/// This program cannot write MCAP files.
pub fn write(
    _: impl BufRead,
    _: &Path,
    _: fn(&str) -> Option<&'static str>,
    _: impl FnMut(u64) -> anyhow::Result<()>,
) -> anyhow::Result<McapReport> {
    bail!("this program was built without MCAP: build it with --features export");
}
