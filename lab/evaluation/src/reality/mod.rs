//! How well does the core do on whiskers as they really are? One nuisance at a time, and all together.
//!
//! A robot of six whiskers makes contacts in bouts, with pauses between them. Its rubber creeps, ages and warms up,
//! its valves dither, its habits change ([`Nuisance`]). The core gets events with nothing but what the robot can
//! know, and the robot obeys its setpoints. On healthy robots every report is false ([`Healthy`]). On the others
//! something is cut or wears off ([`Found`]).
//!
//! - `row`, `nuisances`: rows of the table, and sizes of the nuisances.
//! - `whisker`, `rubber`, `air`, `course`: the plant, with a random stream for each purpose.
//! - `mechanics`, `elastica`: the plant's strain, by the core's mechanics or by others that share nothing with them.
//! - `robot`: the plant connected to the core.
//! - `healthy`, `incident`, `truth`, `figures`: trials, true errors of compensations, and results.

mod air;
mod course;
mod elastica;
mod figures;
#[expect(clippy::wildcard_enum_match_arm, reason = "only a few of many effects matter")]
mod healthy;
#[expect(clippy::wildcard_enum_match_arm, reason = "only a few of many effects matter")]
mod incident;
mod mechanics;
mod nuisances;
#[expect(clippy::wildcard_enum_match_arm, reason = "only a few of many effects matter")]
mod robot;
#[expect(clippy::wildcard_enum_match_arm, reason = "most nuisances have the same strengths and incident")]
mod row;
mod rubber;
mod truth;
mod whisker;

use rayon::prelude::*;

pub use course::Course;
pub use figures::{Figures, Share, Spread};
pub use healthy::{Healthy, Leaks};
pub use incident::{Compensated, Found, SIZES_MM};
pub use nuisances::Nuisances;
pub use row::{Incident, Nuisance, Row};
pub use whisker::{Circumstances, Habit, Touch, Whisker};

/// Kind of place that a robot states with its contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StatedPlace {
    /// The contact ratio to the present length.
    #[default]
    Ratio,
    /// The same, from a robot that does touch tests at given distances on request.
    RatioTests,
    /// Each contact is at the tip.
    Tip,
    /// The distance from the base.
    Distance,
    /// The distance from the base, from a robot that does touch tests at given distances.
    DistanceTests,
    /// No place at all.
    Unknown,
}

impl StatedPlace {
    /// All kinds of places.
    pub const ALL: [Self; 6] =
        [Self::Ratio, Self::RatioTests, Self::Tip, Self::Distance, Self::DistanceTests, Self::Unknown];

    /// Name in tables, JSON and on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Ratio => "RATIO",
            Self::RatioTests => "RATIO_TESTS",
            Self::Tip => "TIP",
            Self::Distance => "DISTANCE",
            Self::DistanceTests => "DISTANCE_TESTS",
            Self::Unknown => "UNKNOWN",
        }
    }

    /// Whether the robot does touch tests.
    pub(crate) fn has_tests(self) -> bool {
        match self {
            Self::RatioTests | Self::DistanceTests => true,
            Self::Ratio | Self::Tip | Self::Distance | Self::Unknown => false,
        }
    }

    /// Whether objects stand at distances from the base, whatever the whisker's length, and the task is to read there.
    pub(crate) fn is_distance(self) -> bool {
        match self {
            Self::Distance | Self::DistanceTests => true,
            Self::Ratio | Self::RatioTests | Self::Tip | Self::Unknown => false,
        }
    }
}

/// Parameters of the evaluation.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Seed of all randomness.
    pub seed: u64,
    /// Rows to evaluate.
    pub rows: Vec<Row>,
    /// Kind of place that the robots state with their contacts.
    pub place: StatedPlace,
    /// Whether the robots multiply their readings.
    pub applies_gain: bool,
    /// Number of contacts of healthy whiskers in each row.
    pub contacts: u64,
    /// Number of robots in each row on which something is cut or wears off.
    pub incidents: u32,
}

/// One trial: a healthy robot for a number of rounds, or an incident.
#[derive(Debug, Clone, Copy)]
enum Trial {
    Healthy { number: u64, rounds: u64 },
    Incident { number: u64 },
}

/// The kind of all robots of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct RobotKind {
    place: StatedPlace,
    applies_gain: bool,
}

impl Plan {
    fn kind(&self) -> RobotKind {
        RobotKind { place: self.place, applies_gain: self.applies_gain }
    }

    fn trials_of(&self, row: Row) -> Vec<Trial> {
        let (robots, rounds) = healthy::robots(row, self.contacts);
        let healthy = (0..robots).map(|number| Trial::Healthy { number, rounds });
        healthy.chain((0..self.incidents).map(|number| Trial::Incident { number: number.into() })).collect()
    }

    /// Number of trials of all rows.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.rows.iter().map(|&row| self.trials_of(row).len() as u64).sum()
    }
}

/// Runs a plan on all processors; the same plan gives the same figures. `done` is called after each trial.
#[must_use]
pub fn evaluate(plan: &Plan, done: &(dyn Fn() + Sync)) -> Vec<Figures> {
    let trials: Vec<(usize, Row, Trial)> = (0..)
        .zip(&plan.rows)
        .flat_map(|(at, &row)| plan.trials_of(row).into_iter().map(move |trial| (at, row, trial)))
        .collect();
    let results: Vec<(usize, Vec<Found>, Healthy)> = trials
        .par_iter()
        .map(|&(at, row, trial)| {
            let (found, healthy) = match trial {
                Trial::Healthy { number, rounds } => {
                    (Vec::new(), healthy::run(row, plan.kind(), plan.seed, number, rounds))
                }
                Trial::Incident { number } => incident::run(row, plan.kind(), plan.seed, number),
            };
            done();
            (at, found, healthy)
        })
        .collect();
    let figures = |(at, &row): (usize, &Row)| {
        let own = || results.iter().filter(move |(of, _, _)| *of == at);
        Figures {
            row,
            place: plan.place,
            healthy: own().fold(Healthy::default(), |sum, (_, _, healthy)| sum.plus(healthy)),
            found: own().flat_map(|(_, found, _)| found.iter().copied()).collect(),
        }
    };
    (0..).zip(&plan.rows).map(figures).collect()
}

/// Runs one row: `contacts` of healthy whiskers, and cuts of each size ten times.
#[must_use]
pub fn run(row: Row, place: StatedPlace, seed: u64, contacts: u64) -> Figures {
    let incidents = 10 * SIZES_MM.len() as u32;
    let plan = Plan { seed, rows: vec![row], place, applies_gain: false, contacts, incidents };
    let mut figures = evaluate(&plan, &|| ());
    figures.remove(0)
}

/// A separate seed for each purpose and robot. Rows share them, so that they differ by their nuisance alone.
fn seed(plan_seed: u64, purpose: u64, number: u64) -> u64 {
    let mut seed = plan_seed;
    for part in [purpose, number] {
        seed = (seed ^ part).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }
    seed
}
