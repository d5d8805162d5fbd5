//! `vibrissa metrics`: what `/metrics` has, for people.

use std::io::Write;

use vibrissa_supervisor::metrics;

/// Prints docs/metrics.md.
///
/// # Errors
/// It cannot be written.
pub fn run(out: &mut impl Write) -> anyhow::Result<()> {
    write!(out, "{}", metrics::document()?)?;
    Ok(())
}
