//! The verdicts of a run: counts that must be 0, under the words of the invariants.

use std::fmt;

use vibrissa_edge::invariants::Invariant;

/// A count that must be 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verdict {
    /// The invariant that it would violate; `None` if it concerns the run itself.
    pub invariant: Option<Invariant>,
    /// What is counted.
    pub name: &'static str,
    /// The count.
    pub count: u64,
}

impl Verdict {
    /// A count of violations of an invariant.
    #[must_use]
    pub const fn of(invariant: Invariant, name: &'static str, count: u64) -> Self {
        Self { invariant: Some(invariant), name, count }
    }

    /// A count that concerns the run itself.
    #[must_use]
    pub const fn of_run(name: &'static str, count: u64) -> Self {
        Self { invariant: None, name, count }
    }
}

/// A violation in one line.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(invariant) = self.invariant {
            write!(f, "{}: ", invariant.word())?;
        }
        write!(f, "{}: {}", self.name, self.count)
    }
}

/// The verdicts above 0.
#[must_use]
pub fn violations(verdicts: &[Verdict]) -> Vec<String> {
    verdicts.iter().filter(|one| one.count > 0).map(ToString::to_string).collect()
}

/// Writes all verdicts as a table whose first column has this width.
///
/// # Errors
/// The output fails.
pub fn write_table(f: &mut fmt::Formatter<'_>, verdicts: &[Verdict], width: usize) -> fmt::Result {
    for Verdict { invariant, name, count } in verdicts {
        let word = invariant.map_or("", Invariant::word);
        let mark = if *count > 0 { "VIOLATION" } else { "" };
        writeln!(f, "{}", format!("{name:<width$}{count:>9}  {word:<24}{mark}").trim_end())?;
    }
    Ok(())
}
