//! Is each fault classified correctly, and is nothing else called a trim? Simulated arrays with at most one fault
//! each.
//!
//! Each case is one array of 3 to 12 whiskers. Its robot detects no faults: it reports regulators and gauges as OK,
//! whatever happens to them. The verdict is the core's first definite statement about the affected whisker (or the
//! array); a statement about any other whisker makes the case wrong.

mod cases;
mod report;
#[expect(clippy::wildcard_enum_match_arm, reason = "only a few of many effects matter")]
mod verdict;

use rayon::prelude::*;

pub use report::{ClassReport, Report};
pub use verdict::{Called, Outcome};

/// True class of a simulated case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Nothing happens.
    Healthy,
    /// A whisker loses 1 to 30 mm at once.
    Trim,
    /// A whisker loses 0.001 to 0.008 mm with each contact.
    Erosion,
    /// All sensitivities of the array change by 3 to 10 % at most: temperature, or wrongly reported deflections.
    ArrayShift,
    /// A gauge's zero drifts by 40 to 160 times the noise floor, in either direction.
    BaselineDrift,
    /// A chamber loses 0.5 to 10 kPa per second, and its regulator refills it.
    Leak,
    /// A gauge's circuit is broken.
    GaugeOpen,
    /// A gauge's circuit is shorted.
    GaugeShort,
    /// A gauge saturates at a strain that 5 to 70 % of the contacts reach.
    GaugeSaturated,
    /// The robot sends nothing about a whisker, but is online.
    Silent,
}

impl Class {
    /// All classes, in the order of the matrix.
    pub const ALL: [Self; 10] = [
        Self::Healthy,
        Self::Trim,
        Self::Erosion,
        Self::ArrayShift,
        Self::BaselineDrift,
        Self::Leak,
        Self::GaugeOpen,
        Self::GaugeShort,
        Self::GaugeSaturated,
        Self::Silent,
    ];

    /// Word of the class in tables and JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Healthy => "HEALTHY",
            Self::Trim => "TRIM",
            Self::Erosion => "EROSION",
            Self::ArrayShift => "ARRAY_SHIFT",
            Self::BaselineDrift => "BASELINE_DRIFT",
            Self::Leak => "LEAK",
            Self::GaugeOpen => "GAUGE_OPEN",
            Self::GaugeShort => "GAUGE_SHORT",
            Self::GaugeSaturated => "GAUGE_SATURATED",
            Self::Silent => "SILENT",
        }
    }
}

/// Parameters of the evaluation.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Seed: the same seed gives the same cases, whatever the number of threads.
    pub seed: u64,
    /// Number of cases of each class.
    pub cases: u32,
    /// The evaluated classes.
    pub classes: Vec<Class>,
}

impl Plan {
    /// Number of cases of all classes.
    #[must_use]
    pub fn total(&self) -> u64 {
        u64::from(self.cases) * self.classes.len() as u64
    }
}

/// Runs the plan on all processors; `done` is called after each case.
pub fn evaluate(plan: &Plan, done: impl Fn() + Sync) -> Report {
    let cases: Vec<(Class, u32)> =
        plan.classes.iter().flat_map(|&class| (0..plan.cases).map(move |case| (class, case))).collect();
    let outcomes = cases
        .into_par_iter()
        .map(|(class, case)| {
            let outcome = verdict::judge(&cases::case(plan.seed, class, case));
            done();
            outcome
        })
        .collect();
    Report::new(plan, outcomes)
}
