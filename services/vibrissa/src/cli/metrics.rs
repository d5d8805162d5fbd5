//! `vibrissa metrics`: the reference of all metrics, in Markdown.

use std::io::Write;

use vibrissa_supervisor::metrics;

/// Prints the text of docs/metrics.md.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(out: &mut impl Write) -> anyhow::Result<()> {
    write!(out, "{}", metrics::document()?)?;
    Ok(())
}
