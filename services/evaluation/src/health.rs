//! Is everything called by its name, and nothing else a trim? Simulated arrays in which one thing is wrong at most.
//!
//! Each case is one array of 3 to 12 whiskers. Its robot notices nothing by itself: it says that regulators and
//! gauges are in order, whatever happens to them. The verdict is the first definite statement of the core about the
//! whisker (or the array) that has the case; a statement about any other whisker makes the case wrong.

mod cases;
mod report;
#[expect(clippy::wildcard_enum_match_arm, reason = "of many effects it looks at a few")]
mod verdict;

use rayon::prelude::*;

pub use report::{ClassReport, Report};
pub use verdict::{Called, Outcome};

/// What a simulated case is, in truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Nothing happens.
    Healthy,
    /// A whisker loses 1 to 30 mm at once.
    Trim,
    /// A whisker loses 0.001 to 0.008 mm with each contact.
    Erosion,
    /// All sensitivities of the array change by 3 to 15 %: temperature, or deflections told wrongly.
    ArrayShift,
    /// A gauge's zero wanders by 40 to 160 times the noise floor, either way.
    BaselineDrift,
    /// A chamber loses 0.5 to 10 kPa per second, and its regulator makes it good.
    Leak,
    /// A gauge's circuit is broken.
    GaugeOpen,
    /// A gauge's circuit is shorted.
    GaugeShort,
    /// A gauge has a ceiling that 5 to 70 % of the contacts reach.
    GaugeSaturated,
    /// Nothing is told of a whisker any more, while its robot is online.
    Silent,
}

impl Class {
    /// All of them, in the order of the matrix.
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

    /// Its word in tables and JSON.
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

/// What is evaluated.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The same seed gives the same cases, whatever the number of threads.
    pub seed: u64,
    /// Cases of each class.
    pub cases: u32,
    /// The classes.
    pub classes: Vec<Class>,
}

impl Plan {
    /// Cases in all.
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
