//! Compensations of robots that multiply their readings: air for the shape, a gain for the level.

use rayon::prelude::*;
use vibrissa_core::mechanics::{CONTACT_RATIOS, Formulation};
use vibrissa_core::policy::LongerForShorter;
use vibrissa_core::robot::effect::{CandidateRecord, CompensationError, Effect};
use vibrissa_core::robot::{Event, OperatorAction, Params, Place};
use vibrissa_core::units::Micros;
use vibrissa_edge::interval::Z95;
use vibrissa_protocol::{AirControl, TouchTestKind};
use vibrissa_simulator::places::Places;
use vibrissa_simulator::scenario::{Behaviour, Change};

use super::noise_limit::noise_limit;
use super::{CONTACTS_AFTER, CONTACTS_PER_SECOND, Case, START_MPA, Trial, Truth, WHOLE_CONTACTS, plants, scenario};
use crate::World;

/// Contacts after the setpoint at which the error of the reading is looked at.
pub const LOOKS: [u32; 2] = [300, 800];
/// Remaining lengths of a whisker of 70 mm that serves itself and that air alone cannot serve, mm.
pub const SHORT_MM: [f64; 4] = [55.0, 50.0, 45.0, 40.0];

/// Remaining length of a target that a neighbour shall serve, mm.
const STUMP_MM: f64 = 40.0;

/// Time between two tests of a whisker whose contacts state no place, s: 24 before the cut, as in a day.
const TEST_EVERY_S: f64 = WHOLE_CONTACTS as f64 / CONTACTS_PER_SECOND / 24.0;

/// The robot's air, and its knowledge of the places of contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// Air both ways, and the contact ratio.
    Usual,
    /// No air: the gain alone.
    NoAir,
    /// The distance from the base, and touch tests against a wall.
    Distance,
    /// Each contact is at the tip.
    Tip,
    /// No place, and touch tests against a wall, on a schedule. An operator asks for one after the cut.
    Unknown,
}

impl Setting {
    /// All settings but the usual one.
    pub const OTHERS: [Self; 4] = [Self::NoAir, Self::Distance, Self::Tip, Self::Unknown];

    fn apply(self, behaviour: &mut Behaviour) {
        match self {
            Self::Usual => {}
            Self::NoAir => behaviour.air_control = Some(AirControl::None),
            Self::Distance => {
                behaviour.places = Places::Distance;
                behaviour.touch_tests = vec![TouchTestKind::Wall];
            }
            Self::Tip => behaviour.places = Places::Tip,
            Self::Unknown => {
                behaviour.places = Places::Unknown;
                behaviour.touch_tests = vec![TouchTestKind::Wall];
            }
        }
    }
}

/// True errors of the reading (eq. 35 on the plant), and the statements about them.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The trial with this result.
    pub trial: Trial,
    /// Setting of the robot.
    pub setting: Setting,
    /// Chosen candidate of the decision.
    pub chosen: CandidateRecord,
    /// Error with pressure and gain of the decision.
    pub open: f64,
    /// Error after each of [`LOOKS`].
    pub looks: [f64; LOOKS.len()],
    /// Error at the end.
    pub end: f64,
    /// Distance of the held pressure from the nominal one, MPa.
    pub moved_mpa: f64,
    /// Error of the held pressure with the best gain on this plant: no estimate of the gain can do better.
    pub best_gain: f64,
    /// Error that the noise of the contacts leaves after each of [`LOOKS`].
    pub noise_limits: [f64; LOOKS.len()],
    /// Last measured error.
    pub measured: Option<CompensationError>,
    /// Number of setpoints sent.
    pub setpoints: usize,
}

/// The trials: those of the paper's cases, short whiskers that serve themselves, and self-compensation in the other
/// settings.
#[must_use]
pub fn trials(seed: u64, count: usize) -> Vec<(Trial, Setting)> {
    let mut trials = super::trials(seed, count);
    for (plant, rubber) in plants(seed, count).iter().enumerate() {
        for length_mm in SHORT_MM {
            let number = trials.len() as u64;
            let seed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number);
            trials.push(Trial { case: Case::Itself, length_mm, plant, rubber: *rubber, seed });
        }
    }
    let own: Vec<Trial> = trials.iter().filter(|one| is_usual_length(Case::Itself, one)).copied().collect();
    let others = Setting::OTHERS.into_iter().flat_map(|setting| own.iter().map(move |one| (*one, setting)));
    trials.iter().map(|one| (*one, Setting::Usual)).chain(others).collect()
}

fn is_usual_length(case: Case, trial: &Trial) -> bool {
    trial.case == case && case.lengths_mm().contains(&trial.length_mm)
}

/// Runs the trials on all processors; none for a target that was not served.
pub fn evaluate(trials: &[(Trial, Setting)], done: &(dyn Fn() + Sync)) -> Vec<Option<Reading>> {
    trials
        .par_iter()
        .map(|(trial, setting)| {
            let reading = run(trial, *setting);
            done();
            reading
        })
        .collect()
}

/// Runs one trial.
#[must_use]
pub fn run(trial: &Trial, setting: Setting) -> Option<Reading> {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.policy.predicted_error_max = f64::INFINITY;
    let mut scenario = scenario(trial);
    setting.apply(&mut scenario.behaviour);
    scenario.robots[0].applies_gain = true;
    if trial.case != Case::Itself {
        // With a gain, even such a whisker serves itself, but a neighbour has a lower predicted error.
        params.policy.own_role_cost = 0.0;
        params.policy.longer_for_shorter = LongerForShorter::Allowed;
        for event in &mut scenario.robots[0].events {
            event.change = Change::Trim { length_mm: STUMP_MM };
        }
    }
    if setting == Setting::Unknown {
        // A day is compressed to half a minute: tests by the schedule of an hour.
        params.touch_tests.every_without_place = Micros::from_s(TEST_EVERY_S);
        params.touch_tests.per_hour = u16::MAX;
        // Its operator knows that its distances are right, so that the first test decides.
        params.touch_tests.zero_sd_mm = 0.0;
    }
    let mut world = World::new(&scenario, params);
    let truth = Truth::new(trial);
    let mut now_s = WHOLE_CONTACTS as f64 / CONTACTS_PER_SECOND;
    let end_s = now_s + CONTACTS_AFTER as f64 / CONTACTS_PER_SECOND;
    if setting == Setting::Unknown {
        // Its contacts show no cut. It lies within the first message after this one.
        now_s += 0.5;
        world.run_until_s(now_s);
        let whisker = Place { array: "a", whisker: 0 };
        world.step(&Event::Operator(&OperatorAction::TouchTest(whisker)));
    }
    let is_settled = |world: &World| world.core.compensations().first().is_some_and(|one| one.is_settled());
    while !is_settled(&world) && now_s < end_s {
        now_s += 0.05;
        world.run_until_s(now_s);
    }
    let index = world.core.compensations().first()?.compensator();
    let open = error(&world, &truth, None)?;
    let (mut looks, mut pressures) = ([open; LOOKS.len()], Vec::new());
    let used = |world: &World| world.core.whisker(index).map_or(0, |whisker| whisker.contacts);
    let mut counted = 0;
    for (look, contacts) in looks.iter_mut().zip(LOOKS) {
        // Contacts that the core counts: used ones, while no setpoint is on its way.
        while counted < u64::from(contacts) && world.seconds() < end_s {
            let (used_before, was_settled) = (used(&world), is_settled(&world));
            let next_s = world.seconds() + 0.1;
            hold(&mut world, index, next_s, &mut pressures);
            counted += if was_settled && is_settled(&world) { used(&world) - used_before } else { 0 };
        }
        // The message with the last of them may have others, too, and the gain for them is on its way.
        let next_s = world.seconds() + 0.5;
        hold(&mut world, index, next_s, &mut pressures);
        *look = error(&world, &truth, Some(&pressures))?;
    }
    hold(&mut world, index, end_s, &mut pressures);
    let chosen = world.picked(|effect| match effect {
        Effect::Decided(decision) => decision.chosen.map(|at| decision.candidates[at]),
        _ => None,
    });
    let measured = world.picked(|effect| match effect {
        Effect::Error(error) => Some(CompensationError::clone(error)),
        _ => None,
    });
    let sent = sent(&world);
    let (held_mpa, _) = *sent.last()?;
    Some(Reading {
        trial: *trial,
        setting,
        chosen: chosen.into_iter().next()?,
        open,
        looks,
        end: error(&world, &truth, Some(&pressures))?,
        moved_mpa: (held_mpa - START_MPA).abs(),
        best_gain: truth.best_gain_error(held_mpa),
        noise_limits: LOOKS
            .map(|contacts| noise_limit(&truth, trial.case, setting != Setting::NoAir, contacts, &scenario.noise)),
        measured: measured.into_iter().last(),
        setpoints: sent.len(),
    })
}

/// Pressures and gains sent so far.
fn sent(world: &World) -> Vec<(f64, Option<[f64; CONTACT_RATIOS.len()]>)> {
    world.picked(|effect| match effect {
        Effect::Command(command) => Some((command.pressure.mpa(), command.gain)),
        _ => None,
    })
}

/// Runs on, and notes the true pressure of the compensator. A regulator with a coarse sensor holds another pressure than it
/// reports.
fn hold(world: &mut World, index: usize, end_s: f64, pressures: &mut Vec<f64>) {
    let mut at_s = world.seconds();
    while at_s < end_s {
        at_s += 0.1;
        world.run_until_s(at_s);
        pressures.push(world.robot.whiskers()[index].regulator().pressure_mpa());
    }
}

/// True error of the reading with the last gain, at the mean of the true pressures since the setpoint, or at the setpoint.
fn error(world: &World, truth: &Truth, pressures: Option<&Vec<f64>>) -> Option<f64> {
    let (setpoint_mpa, gain) = *sent(world).last()?;
    let held_mpa = pressures.map_or(setpoint_mpa, |all| {
        let newest = &all[all.len().saturating_sub(30)..];
        newest.iter().sum::<f64>() / newest.len() as f64
    });
    Some(truth.error(held_mpa, gain.as_ref()).mean)
}

/// Means over some readings, as ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingSummary {
    /// Number of readings.
    pub served: usize,
    /// Error with pressure and gain of the decision.
    pub open: f64,
    /// Error after each of [`LOOKS`].
    pub looks: [f64; LOOKS.len()],
    /// Error at the end.
    pub end: f64,
    /// Least error that any gain has at the held pressure.
    pub best_gain: f64,
    /// Error that the noise of the contacts leaves after each of [`LOOKS`].
    pub noise_limits: [f64; LOOKS.len()],
    /// Distance of the held pressure from the nominal one, MPa.
    pub moved_mpa: f64,
    /// Share of the readings whose error with the decision's setpoint lies in the predicted 95 % interval.
    pub predicted_coverage: f64,
    /// Share of the readings with a measured error whose error at the end lies in its 95 % interval; none where no error is
    /// measured.
    pub measured_coverage: Option<f64>,
}

/// The means; `None` without any reading.
#[must_use]
pub fn summary<'r>(readings: impl Iterator<Item = &'r Reading>) -> Option<ReadingSummary> {
    let all: Vec<&Reading> = readings.collect();
    let mean = |of: &dyn Fn(&Reading) -> f64| all.iter().map(|one| of(one)).sum::<f64>() / all.len() as f64;
    let share = |of: &dyn Fn(&Reading) -> Option<bool>| mean(&|one| f64::from(u8::from(of(one).unwrap_or_default())));
    (!all.is_empty()).then(|| ReadingSummary {
        served: all.len(),
        open: mean(&|one| one.open),
        looks: std::array::from_fn(|look| mean(&|one| one.looks[look])),
        end: mean(&|one| one.end),
        best_gain: mean(&|one| one.best_gain),
        noise_limits: std::array::from_fn(|look| mean(&|one| one.noise_limits[look])),
        moved_mpa: mean(&|one| one.moved_mpa),
        predicted_coverage: share(&|one| {
            one.chosen.predicted_error_interval.map(|(low, high)| (low..=high).contains(&one.open))
        }),
        measured_coverage: {
            let holds =
                |one: &Reading, measured: &CompensationError| (measured.mean - one.end).abs() <= Z95 * measured.sd;
            let measured: Vec<bool> = all.iter().filter_map(|one| Some(holds(one, one.measured.as_ref()?))).collect();
            let held = measured.iter().filter(|&&one| one).count();
            (!measured.is_empty()).then(|| held as f64 / measured.len() as f64)
        },
    })
}

/// The readings of a case, apart from the short whiskers.
pub fn of(case: Case, readings: &[Option<Reading>]) -> impl Iterator<Item = &Reading> {
    of_setting(Setting::Usual, readings).filter(move |one| is_usual_length(case, &one.trial))
}

/// The readings of a setting.
pub fn of_setting(setting: Setting, readings: &[Option<Reading>]) -> impl Iterator<Item = &Reading> {
    readings.iter().flatten().filter(move |one| one.setting == setting)
}

/// The readings of one length that a whisker of 70 mm is trimmed to.
pub fn of_length(length_mm: f64, readings: &[Option<Reading>]) -> impl Iterator<Item = &Reading> {
    let is_it = move |one: &&Reading| one.trial.case == Case::Itself && one.trial.length_mm == length_mm;
    of_setting(Setting::Usual, readings).filter(is_it)
}

#[cfg(test)]
mod tests {
    use vibrissa_core::mechanics::Objective;

    use super::*;

    fn trial(case: Case, length_mm: f64) -> Trial {
        Trial { case, length_mm, plant: 0, rubber: plants(5, 1)[0], seed: 5 }
    }

    /// Setpoints of the first 800 contacts.
    fn setpoints(applies_gain: bool, objective: Objective) -> Vec<(f64, Option<[f64; CONTACT_RATIOS.len()]>)> {
        let mut scenario = scenario(&trial(Case::Itself, 65.0));
        scenario.robots[0].applies_gain = applies_gain;
        let mut params = Params::nguyen_2021(Formulation::Published);
        params.policy.objective = objective;
        let mut world = World::new(&scenario, params);
        world.run_until_s((WHOLE_CONTACTS as f64 + 800.0) / CONTACTS_PER_SECOND);
        sent(&world)
    }

    #[test]
    fn paper_a_robot_without_gains_gets_the_papers_pressures_and_gains() {
        let by_paper = setpoints(false, Objective::Tip);
        assert!(!by_paper.is_empty());
        assert_eq!(setpoints(false, Objective::Shape), by_paper);
        assert_eq!(setpoints(true, Objective::Tip), by_paper);
        let with_gain = setpoints(true, Objective::Shape);
        assert!(with_gain[0].0 > by_paper[0].0 + 0.02, "{with_gain:?} {by_paper:?}");
    }

    #[test]
    fn a_gain_brings_the_reading_to_the_target_and_serves_short_whiskers() {
        for (case, length_mm, open, after_800) in [
            (Case::Shorter, 65.0, 0.12, 0.04),
            (Case::Itself, 65.0, 0.15, 0.04),
            (Case::Longer, 70.0, 0.12, 0.05),
            (Case::Itself, 50.0, 0.05, 0.02),
            (Case::Itself, 40.0, 0.04, 0.03),
        ] {
            let reading = run(&trial(case, length_mm), Setting::Usual).expect("a compensation");
            assert!(reading.open < open && reading.looks[1] < after_800, "{case:?} {length_mm}: {reading:?}");
            assert!(reading.chosen.case == vibrissa_core::policy::Case::SelfCompensation || case != Case::Itself);
        }
    }

    /// Of touches near the tip, those with large errors made lengths 0.4 mm too long.
    #[test]
    fn regress_lengths_of_robots_that_measure_distances_are_not_too_long() {
        let own = trials(51, 3).into_iter().filter(|(_, setting)| *setting == Setting::Distance);
        let found: Vec<Reading> = own.filter_map(|(trial, setting)| run(&trial, setting)).collect();
        let off_mm = |one: &Reading| one.chosen.length.length.mm() - one.trial.length_mm;
        let mean_mm = found.iter().map(off_mm).sum::<f64>() / found.len() as f64;
        assert!(found.len() >= 10 && mean_mm.abs() < 0.25, "{mean_mm} of {}", found.len());
    }

    #[test]
    fn a_robot_without_air_is_served_by_the_gain_alone() {
        let reading = run(&trial(Case::Itself, 65.0), Setting::NoAir).expect("a compensation");
        assert!(reading.moved_mpa == 0.0 && reading.open < 0.12 && reading.end < 0.09, "{reading:?}");
    }

    /// Without places nothing but the tests tells the gain, and the error that it leaves.
    #[test]
    fn touch_tests_tell_the_gain_and_the_error_where_contacts_state_no_place() {
        let reading = run(&trial(Case::Itself, 65.0), Setting::Unknown).expect("a compensation");
        let measured = reading.measured.as_ref().expect("a measured error");
        assert!(reading.setpoints > 1 && reading.end < 0.08, "{reading:?}");
        assert!((measured.mean - reading.end).abs() <= Z95 * measured.sd && measured.sd < 0.08, "{reading:?}");
    }

    /// A regulator near 0 MPa holds the chamber 1 kPa above its setpoint, and its sensor shows that in steps of 1.2 kPa.
    #[test]
    fn regress_the_gain_serves_the_pressure_that_the_regulator_really_holds() {
        let own = plants(5, 4).into_iter().enumerate();
        let own = own.map(|(plant, rubber)| Trial { plant, rubber, ..trial(Case::Itself, 45.0) });
        let found: Vec<Reading> = own.filter_map(|trial| run(&trial, Setting::Usual)).collect();
        let left = found.iter().map(|one| one.end - one.best_gain).sum::<f64>() / found.len() as f64;
        assert!(found.len() == 4 && left < 0.0014, "{left} of {}", found.len());
    }

    #[test]
    fn a_robot_that_knows_no_ratio_keeps_the_gain_of_the_decision_or_better() {
        for setting in [Setting::Distance, Setting::Tip, Setting::Unknown] {
            let reading =
                run(&trial(Case::Itself, 65.0), setting).unwrap_or_else(|| panic!("{setting:?}: no compensation"));
            assert!(reading.open < 0.15 && reading.end < 0.15, "{setting:?}: {reading:?}");
        }
    }
}
