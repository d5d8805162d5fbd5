//! Robots on which something is cut or wears off: how soon and how well the core deals with it.

mod compensated;

use rand::Rng;
use vibrissa_core::mechanics::{ByRatio, CONTACT_RATIOS};
use vibrissa_core::robot::effect::{AlarmKind, Condition, Effect, EndReason, Reason};
use vibrissa_core::robot::one_number;
use vibrissa_edge::interval::Z95;

pub use self::compensated::Compensated;
use self::compensated::{Prediction, SOON_ROUNDS};
use super::healthy::Healthy;
use super::nuisances::Nuisances;
use super::robot::{Layout, Robot, WHISKERS};
use super::row::Incident;
use super::truth::{Reference, rise_by_cut, whole};
use super::whisker::stream;
use super::{RobotKind, Row, seed};

/// Sizes of the cuts, mm: each trial takes the next.
pub const SIZES_MM: [f64; 7] = [1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 16.0];
/// Round of the incident, unless the row states it.
const AT_ROUND: (u64, u64) = (600, 3000);
/// Rounds after it.
const ROUNDS_AFTER: u64 = 2400;
/// Rounds from a cut to a drop of the gain.
const UNTIL_DROP: u64 = 800;
/// Length that wears off, mm.
const WORN_MM: f64 = 10.0;
/// Size of the second cut of [`Incident::SecondCut`], mm.
const SECOND_CUT_MM: f64 = 8.0;
/// Rounds in which the first cut may become suspected.
const UNTIL_SUSPECTED_MAX: u64 = 1500;
/// Rounds after a change, or after its end, at which the length is compared.
const LENGTH_ROUNDS: [u64; 2] = [300, 2000];
/// Rounds between two looks at the readings of a whisker that wears.
const LOOK_ROUNDS: u64 = 50;

/// Result of one whisker that was cut or worn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Length that was lost in the last change, mm.
    pub size_mm: f64,
    /// Contacts from the change to the suspicion; 0 if it was suspected already.
    pub alarm: Option<u64>,
    /// Contacts from the change to the report of a trim, or of erosion.
    pub call: Option<u64>,
    /// Contacts from the change to the first setpoint of a compensation.
    pub setpoint: Option<u64>,
    /// Error of the length at the report, and its standard deviation as stated, mm.
    pub length: Option<(f64, f64)>,
    /// The same 300 and 2,000 contacts after the change, or after its end.
    pub length_after: [Option<(f64, f64)>; 2],
    /// The same at the end.
    pub length_end: (f64, f64),
    /// Its compensation 300 contacts after the first setpoint, if one is in force then.
    pub soon: Option<Compensated>,
    /// Compensation in force at the end.
    pub compensated: Option<Compensated>,
    /// Compensations that ended without cause.
    pub lost: u64,
    /// Reports of something else: erosion or loss of sensitivity of a cut whisker, or the same cut once more.
    pub wrong: u64,
    /// Mean error of the readings while the whisker wore, as a ratio, with the gain in force.
    pub worn_reading: Option<f64>,
}

/// A whisker that was cut or worn, on its way.
struct Case {
    whisker: usize,
    size_mm: f64,
    changed: u64,
    /// Round in which the change has ended.
    ended: Option<u64>,
    length_after: [Option<(f64, f64)>; 2],
    /// Its response while whole, at the time of the change.
    whole: ByRatio,
    alarm: Option<u64>,
    call: Option<u64>,
    setpoint: Option<u64>,
    length: Option<(f64, f64)>,
    predicted: Option<Prediction>,
    soon: Option<Compensated>,
    gain: Option<[f64; CONTACT_RATIOS.len()]>,
    compensations: Vec<u32>,
    lost: u64,
    wrong: u64,
}

/// Runs one trial: the whiskers that were cut or worn, and reports about the others.
#[must_use]
pub(super) fn run(row: Row, kind: RobotKind, plan_seed: u64, number: u64) -> (Vec<Found>, Healthy) {
    let incident = row.incident();
    let own_seed = seed(plan_seed, 1, number);
    let mut random = stream(own_seed, u64::MAX - 1);
    let at = random.random_range(AT_ROUND.0..=AT_ROUND.1);
    let first = random.random_range(0..WHISKERS);
    let soon = random.random_range(0..=60);
    let layouts: &[Layout] = match incident {
        // A scrape that looks like a shift of the array.
        Incident::Scrape(_) => &[Layout::Neighbours, Layout::Together],
        // Whiskers of two lengths: others of one batch read alike.
        Incident::Exchange => &[Layout::Neighbours],
        // A whisker that compensates for itself is the one whose gain drops.
        Incident::GainDrop(_) => &[Layout::Together, Layout::Single],
        Incident::Cut
        | Incident::Learning(_)
        | Incident::SecondCut(_)
        | Incident::Erosion(_)
        | Incident::LossCut(_)
        | Incident::Factory(_) => &Layout::ALL,
    };
    let layout = layouts[number as usize % layouts.len()];
    let size_mm = SIZES_MM[number as usize % SIZES_MM.len()];
    let mut trial = Trial {
        robot: Robot::new(Nuisances::of(row), kind, layout, own_seed),
        incident,
        round: 0,
        cases: Vec::new(),
        others: Healthy::default(),
        worn_readings: Vec::new(),
    };
    if let Incident::Factory(off_mm) = incident {
        trial.change(first, off_mm);
        let off_mm = if number.is_multiple_of(2) { -off_mm } else { off_mm };
        let whisker = &mut trial.robot.whiskers[first];
        whisker.whole_mm += off_mm;
        whisker.length_mm += off_mm;
        trial.end();
    }
    let at = if let Incident::Learning(contact) = incident { u64::from(contact) } else { at };
    trial.rounds(at);
    match incident {
        Incident::Cut | Incident::Learning(_) => trial.cut(first, size_mm),
        Incident::Scrape(count) => (0..count).for_each(|next| trial.cut((first + next) % WHISKERS, size_mm)),
        Incident::SecondCut(small_mm) => {
            trial.cut(first, small_mm);
            for _ in 0..UNTIL_SUSPECTED_MAX {
                if trial.is_suspected(first) {
                    break;
                }
                trial.rounds(1);
            }
            trial.rounds(soon);
            trial.cases.clear();
            trial.cut(first, SECOND_CUT_MM);
        }
        Incident::Erosion(per_contact_mm) => {
            trial.change(first, WORN_MM);
            for _ in 0..(WORN_MM / per_contact_mm) as u64 {
                trial.robot.whiskers[first].length_mm -= per_contact_mm;
                trial.rounds(1);
                if trial.round.is_multiple_of(LOOK_ROUNDS) {
                    let error = trial.present_reading_error(0);
                    trial.worn_readings.push(error);
                }
            }
        }
        Incident::GainDrop(log) => {
            trial.cut(first, size_mm);
            trial.rounds(UNTIL_DROP);
            trial.robot.whiskers[first].drop_gain(log);
        }
        Incident::LossCut(share) => {
            trial.change(first, size_mm);
            let rise = rise_by_cut(&trial.robot.whiskers[first], size_mm);
            trial.robot.whiskers[first].drop_gain(share * rise);
            trial.rounds(UNTIL_DROP);
            trial.cases.clear();
            trial.cut(first, size_mm);
        }
        Incident::Exchange => {
            let other = (first + 1) % WHISKERS;
            trial.change(first, 0.0);
            trial.change(other, 0.0);
            trial.robot.exchanged = Some((first, other));
        }
        Incident::Factory(_) => {}
    }
    trial.end();
    trial.rounds(ROUNDS_AFTER);
    let found = (0..trial.cases.len()).map(|at| trial.found(at)).collect();
    (found, trial.others)
}

struct Trial {
    robot: Robot,
    incident: Incident,
    round: u64,
    cases: Vec<Case>,
    others: Healthy,
    /// Mean error of the readings of a whisker while it wears, as ratios.
    worn_readings: Vec<f64>,
}

impl Trial {
    fn rounds(&mut self, rounds: u64) {
        for _ in 0..rounds {
            self.round += 1;
            self.robot.round();
            self.others.contacts += (WHISKERS - self.cases.len()) as u64;
            for (_, effect) in std::mem::take(&mut self.robot.kept_effects) {
                self.hear(&effect);
            }
            for at in 0..self.cases.len() {
                let case = &self.cases[at];
                if case.setpoint.is_some_and(|since| case.changed + since + SOON_ROUNDS == self.round) {
                    self.cases[at].soon = self.compensated(case);
                }
                for (moment, rounds) in LENGTH_ROUNDS.into_iter().enumerate() {
                    if self.cases[at].ended.is_some_and(|ended| ended + rounds == self.round) {
                        self.cases[at].length_after[moment] = Some(estimate(&self.robot, self.cases[at].whisker));
                    }
                }
            }
        }
    }

    /// A whisker loses some length at once.
    fn cut(&mut self, whisker: usize, size_mm: f64) {
        self.change(whisker, size_mm);
        self.robot.whiskers[whisker].length_mm -= size_mm;
    }

    fn change(&mut self, whisker: usize, size_mm: f64) {
        let is_suspected = self.is_suspected(whisker);
        self.cases.push(Case {
            whisker,
            size_mm,
            changed: self.round,
            ended: None,
            length_after: [None; 2],
            whole: whole(&self.robot.whiskers[whisker]),
            alarm: is_suspected.then_some(0),
            call: None,
            setpoint: None,
            length: None,
            predicted: None,
            soon: None,
            gain: None,
            compensations: Vec::new(),
            lost: 0,
            wrong: 0,
        });
    }

    /// The changes that go on end now.
    fn end(&mut self) {
        for case in &mut self.cases {
            case.ended = case.ended.or(Some(self.round));
        }
    }

    fn is_suspected(&self, whisker: usize) -> bool {
        self.robot.core.whisker(whisker).is_some_and(|view| view.condition == Condition::Suspected)
    }

    fn hear(&mut self, effect: &Effect) {
        let whisker = match effect {
            Effect::Condition { whisker, .. } | Effect::Alarm { whisker, .. } => Some(*whisker),
            Effect::Trim(trim) => Some(trim.whisker),
            Effect::Decided(decision) => Some(decision.target),
            _ => None,
        };
        let is_erosion = matches!(self.incident, Incident::Erosion(_));
        let is_drop = matches!(self.incident, Incident::GainDrop(_));
        let is_exchange = matches!(self.incident, Incident::Exchange);
        let is_second = matches!(self.incident, Incident::SecondCut(_));
        let (robot, round) = (&self.robot, self.round);
        let case = self.cases.iter_mut().find(|case| Some(case.whisker) == whisker);
        match (effect, case) {
            (Effect::Condition { to, .. }, Some(case)) => {
                let since = round - case.changed;
                match to {
                    Condition::Suspected => case.alarm = case.alarm.or(Some(since)),
                    Condition::Eroding if is_erosion => case.called(since, estimate(robot, case.whisker)),
                    Condition::Eroding => case.wrong += 1,
                    Condition::SensitivityLoss if !is_drop => case.wrong += 1,
                    Condition::SensitivityLoss | Condition::Learning | Condition::Healthy | Condition::Trimmed => {}
                }
            }
            (Effect::Alarm { kind: AlarmKind::CablesExchanged, .. }, Some(case)) if is_exchange => {
                case.called(round - case.changed, estimate(robot, case.whisker));
            }
            (Effect::Trim(_), Some(case)) if is_exchange => case.wrong += 1,
            (Effect::Trim(trim), Some(case)) => {
                let after_mm = trim.length_after.length.mm();
                let true_mm = robot.whiskers[case.whisker].length_mm;
                // A report of the smaller cut before does not find this one.
                let is_this = !is_second || after_mm < true_mm + 0.5 * case.size_mm;
                if is_this && case.call.is_some() && !is_erosion {
                    case.wrong += 1;
                } else if is_this {
                    case.called(round - case.changed, (after_mm - true_mm, trim.length_after.sd_mm));
                }
            }
            (Effect::Decided(decision), Some(case)) => {
                case.compensations.push(decision.compensation);
                let chosen = decision.chosen.map(|at| &decision.candidates[at]);
                if let Some(chosen) = chosen
                    && let (Some(pressure), Some(error), Some(interval)) =
                        (chosen.pressure, chosen.predicted_error, chosen.predicted_error_interval)
                {
                    let compensator = &robot.whiskers[chosen.whisker];
                    let reference = Reference::new(case.whole, compensator);
                    let truth = reference.error(compensator, pressure.mpa(), 1.0);
                    let compensator = chosen.whisker;
                    case.predicted = Some(Prediction { compensator, error, interval, truth, reference });
                }
            }
            (Effect::Command(command), _) => {
                let of = |case: &&mut Case| command.compensation.is_some_and(|id| case.compensations.contains(&id));
                if let Some(case) = self.cases.iter_mut().find(of) {
                    case.gain = command.gain.or(case.gain);
                    if matches!(command.reason, Reason::Compensation(_)) {
                        if let Some((decided, gain)) =
                            case.predicted.as_mut().zip(command.gain.as_ref().and_then(one_number))
                        {
                            let compensator = &robot.whiskers[decided.compensator];
                            decided.truth = decided.reference.error(compensator, command.pressure.mpa(), gain);
                        }
                        case.setpoint = case.setpoint.or(Some(round - case.changed));
                    }
                }
            }
            (Effect::Ended { compensation, reason, .. }, _) if !is_erosion => {
                if *reason != EndReason::Reassigned
                    && let Some(case) = self.cases.iter_mut().find(|case| case.compensations.contains(compensation))
                {
                    case.lost += 1;
                }
            }
            (_, Some(_)) => {}
            (effect, None) => {
                self.others.count(effect);
            }
        }
    }

    fn found(&self, at: usize) -> Found {
        let (case, worn) = (&self.cases[at], &self.worn_readings);
        Found {
            size_mm: case.size_mm,
            alarm: case.alarm,
            call: case.call,
            setpoint: case.setpoint,
            length: case.length,
            length_after: case.length_after,
            length_end: estimate(&self.robot, case.whisker),
            soon: case.soon,
            compensated: self.compensated(case),
            lost: case.lost,
            wrong: case.wrong,
            worn_reading: (!worn.is_empty()).then(|| worn.iter().sum::<f64>() / worn.len() as f64),
        }
    }
}

/// Error of the present estimate of a length, and its standard deviation as stated, mm.
fn estimate(robot: &Robot, whisker: usize) -> (f64, f64) {
    let view = robot.core.whisker(whisker);
    view.map_or((f64::NAN, f64::NAN), |view| {
        (view.length.length.mm() - robot.whiskers[whisker].length_mm, view.length.sd_mm)
    })
}

impl Case {
    /// The change is reported for the first time, with this error of the length.
    fn called(&mut self, since: u64, length: (f64, f64)) {
        if self.call.is_none() {
            self.call = Some(since);
            self.alarm = self.alarm.or(Some(since));
            self.length = Some(length);
        }
    }
}

impl Found {
    /// Whether an interval of 1.96 standard deviations contains the truth.
    #[must_use]
    pub fn is_covered((error, sd): (f64, f64)) -> bool {
        error.abs() <= Z95 * sd
    }
}
