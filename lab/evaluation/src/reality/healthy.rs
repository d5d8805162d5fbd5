//! Robots on which nothing is cut: everything that the core reports is false.

use vibrissa_core::robot::effect::{AlarmKind, Condition, Effect, Fault};

use super::nuisances::Nuisances;
use super::robot::{Layout, Robot, WHISKERS};
use super::{RobotKind, Row, seed};

/// Rounds of contacts of one robot: a little more than a day.
const ROUNDS_MAX: u64 = 30_000;
/// Rounds of a robot with a leak: many leaks tell more than long ones.
const LEAK_ROUNDS_MAX: u64 = 1500;
/// Round at which a leak starts.
const LEAK_ROUND: u64 = 300;
/// Time in which a leak is to be reported, s.
const LEAK_IN_TIME_S: f64 = 60.0;
/// The whisker with the leak.
const LEAKING: usize = 0;

/// Reports about healthy whiskers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Healthy {
    /// Contacts of healthy whiskers.
    pub contacts: u64,
    /// Changes to SUSPECTED.
    pub suspicions: u64,
    /// Reports of a trim.
    pub trims: u64,
    /// Changes to ERODING.
    pub eroding: u64,
    /// Changes to `SENSITIVITY_LOSS`.
    pub losses: u64,
    /// Alarms of a fault: of a gauge, or LEAK of a tight chamber.
    pub faults: u64,
    /// Alarms `BASELINE_DRIFT`. They can be right: creep leaves a strain without contact.
    pub drifts: u64,
    /// Alarms `ARRAY_SHIFT`. They can be right where all whiskers of a robot change.
    pub shifts: u64,
    /// Reports about chambers that leak.
    pub leaks: Leaks,
}

/// Reports about leaking chambers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Leaks {
    /// Chambers that leak.
    pub chambers: u64,
    /// Those of them for which an alarm was raised.
    pub found: u64,
    /// Those of them for which it was raised within 60 s.
    pub in_time: u64,
    /// Alarms for them; each leak needs one.
    pub raised: u64,
}

impl Healthy {
    /// False conditions: ERODING, `SENSITIVITY_LOSS` and faults. Alarms `ARRAY_SHIFT` and `BASELINE_DRIFT` are none.
    #[must_use]
    pub fn conditions(&self) -> u64 {
        self.eroding + self.losses + self.faults
    }

    /// A count per million contacts; 0 without contacts.
    #[must_use]
    pub fn per_million(&self, count: u64) -> f64 {
        1e6 * count as f64 / self.contacts.max(1) as f64
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            contacts: self.contacts + other.contacts,
            suspicions: self.suspicions + other.suspicions,
            trims: self.trims + other.trims,
            eroding: self.eroding + other.eroding,
            losses: self.losses + other.losses,
            faults: self.faults + other.faults,
            drifts: self.drifts + other.drifts,
            shifts: self.shifts + other.shifts,
            leaks: Leaks {
                chambers: self.leaks.chambers + other.leaks.chambers,
                found: self.leaks.found + other.leaks.found,
                in_time: self.leaks.in_time + other.leaks.in_time,
                raised: self.leaks.raised + other.leaks.raised,
            },
        }
    }

    /// Counts a report about a whisker with nothing wrong; returns the whisker if the report changes its condition.
    pub(super) fn count(&mut self, effect: &Effect) -> Option<usize> {
        let (counter, whisker) = match effect {
            Effect::Condition { to: Condition::Suspected, .. } => (&mut self.suspicions, None),
            Effect::Condition { to: Condition::Eroding, whisker, .. } => (&mut self.eroding, Some(*whisker)),
            Effect::Condition { to: Condition::SensitivityLoss, whisker, .. } => (&mut self.losses, Some(*whisker)),
            Effect::Trim(trim) => (&mut self.trims, Some(trim.whisker)),
            Effect::Alarm { kind: AlarmKind::Fault(_), .. } => (&mut self.faults, None),
            Effect::Alarm { kind: AlarmKind::BaselineDrift, .. } => (&mut self.drifts, None),
            Effect::Alarm { kind: AlarmKind::ArrayShift, .. } => (&mut self.shifts, None),
            _ => return None,
        };
        *counter += 1;
        whisker
    }
}

/// Number of robots and rounds of each for a number of healthy contacts.
#[must_use]
pub(super) fn robots(row: Row, contacts: u64) -> (u64, u64) {
    let rounds = contacts.div_ceil(WHISKERS as u64);
    let rounds_max = if Nuisances::of(row).leak > 0.0 { LEAK_ROUNDS_MAX } else { ROUNDS_MAX };
    // As many robots of each layout.
    let robots = rounds.div_ceil(rounds_max).next_multiple_of(Layout::ALL.len() as u64);
    (robots, rounds.div_ceil(robots))
}

/// Runs one robot. After each false report that changes a condition, an operator has the whisker learned anew.
#[must_use]
pub(super) fn run(row: Row, kind: RobotKind, plan_seed: u64, number: u64, rounds: u64) -> Healthy {
    let layout = Layout::ALL[number as usize % Layout::ALL.len()];
    let nuisances = Nuisances::of(row);
    let mut robot = Robot::new(nuisances, kind, layout, seed(plan_seed, 0, number));
    let mut healthy = Healthy::default();
    let has_leak = nuisances.leak > 0.0;
    let is_leak = |effect: &Effect| {
        let leaking = AlarmKind::Fault(Fault::Leak);
        has_leak && matches!(effect, Effect::Alarm { whisker: LEAKING, kind } if *kind == leaking)
    };
    let mut leaks_since_s = 0.0;
    for round in 0..rounds {
        if has_leak && round == LEAK_ROUND {
            robot.air[LEAKING].start_leak();
            leaks_since_s = robot.course.now_s;
            healthy.leaks.chambers = 1;
        }
        robot.round();
        for (at_s, effect) in std::mem::take(&mut robot.kept_effects) {
            if is_leak(&effect) {
                healthy.leaks.raised += 1;
                healthy.leaks.found = 1;
                let is_first = healthy.leaks.raised == 1;
                let in_time = is_first && at_s - leaks_since_s <= LEAK_IN_TIME_S;
                healthy.leaks.in_time += u64::from(in_time);
            } else if let Some(whisker) = healthy.count(&effect) {
                robot.replaced(whisker);
            }
        }
    }
    healthy.contacts = rounds * WHISKERS as u64;
    healthy
}
