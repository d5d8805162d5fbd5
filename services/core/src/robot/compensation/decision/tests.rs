//! Whole decisions over arrays whose state is made by hand, against all that could have been decided.

use super::*;
use crate::estimation::LengthFilter;
use crate::estimation::filter::{LENGTH, STATES};
use crate::mechanics::{Formulation, Objective, UsualContacts};
use crate::policy::{Fitness, LongerForShorter, propose};
use crate::robot::Numbers;
use crate::robot::event::{ArrayKind, ArraySheet, Factsheet, RegulatorState, TouchTests, WhiskerSheet};
use crate::units::{Megapascal, Micros, Millimetre};

/// Numbers without a pattern, the same each time.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 ^ (self.0 >> 29)) >> 11
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() % 1_000_000) as f64 / 1e6
    }

    fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }
}

/// Lengths of whiskers side by side, each the neighbour of those beside it.
fn robot(params: &Params, kind: ArrayKind, lengths_mm: &[f64], neighbours: impl Fn(usize) -> Vec<u16>) -> Robot {
    let sheet = |(index, &length_mm): (usize, &f64)| WhiskerSheet {
        number: index as u16,
        x_mm: 25.0 * index as f64,
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length: Millimetre::known(length_mm),
        pressure: Megapascal::known(0.1),
        pressure_max: Megapascal::known(0.2),
        length_tolerance_mm: 0.5,
        strain_max: None,
        neighbours: neighbours(index),
    };
    let whiskers = lengths_mm.iter().enumerate().map(sheet).collect();
    let factsheet = Factsheet {
        arrays: vec![ArraySheet { name: "a".to_owned(), kind, task: Task::Ratio, whiskers }],
        touch_tests: TouchTests::default(),
        applies_gain: false,
        air_control: Default::default(),
    };
    let mut robot = Robot::new(1, Numbers::default());
    robot.lay_out(params, Micros::default(), &factsheet, &mut Vec::new());
    for whisker in robot.whiskers.without_mark() {
        whisker.condition = Condition::Healthy;
    }
    robot
}

fn in_a_row(count: usize) -> impl Fn(usize) -> Vec<u16> {
    move |index| {
        [index.checked_sub(1), Some(index + 1).filter(|&right| right < count)]
            .into_iter()
            .flatten()
            .map(|one| one as u16)
            .collect()
    }
}

fn set_length(params: &Params, whisker: &mut Whisker, length_mm: f64) {
    whisker.filter = LengthFilter::new(whisker.sheet.length, &params.filter);
    let mut by_length = [0.0; STATES];
    by_length[LENGTH] = 1.0;
    whisker.filter.jump((length_mm / whisker.sheet.length.mm()).ln(), 0.0, by_length);
}

fn cut(params: &Params, robot: &mut Robot, index: usize, length_mm: f64) {
    let whisker = &mut robot.whiskers[index];
    set_length(params, whisker, length_mm);
    whisker.condition = Condition::Trimmed;
    whisker.undecided = true;
}

fn decide(params: &Params, robot: &mut Robot) -> Vec<Effect> {
    let mut effects = Vec::new();
    robot.decide(params, &mut effects);
    robot.reconcile_all(params, Micros::default(), &mut effects);
    effects
}

/// (target, compensator) of everything in force.
fn pairs(robot: &Robot) -> Vec<(usize, usize)> {
    let mut pairs: Vec<_> = robot.head.compensations.iter().map(|one| (one.target(), one.compensator())).collect();
    pairs.sort_unstable();
    pairs
}

/// An array of up to seven whiskers of which some are broken in several ways, and some are served already.
fn any_robot(params: &Params, random: &mut Random) -> Robot {
    let count = 1 + random.below(7);
    let kind = if random.one_in(6) { ArrayKind::Type2 } else { ArrayKind::Type1 };
    let lengths_mm: Vec<f64> = (0..count).map(|_| random.between(58.0, 74.0)).collect();
    let beside: Vec<Vec<u16>> = (0..count)
        .map(|index| (0..count).filter(|&other| other != index && random.one_in(2)).map(|other| other as u16).collect())
        .collect();
    let mut robot = robot(params, kind, &lengths_mm, |index| beside[index].clone());
    for (index, whole_mm) in lengths_mm.into_iter().enumerate() {
        let whisker = &mut robot.whiskers[index];
        whisker.sheet.pressure = Megapascal::known(random.between(0.06, 0.14));
        whisker.sheet.pressure_max = Megapascal::known(random.between(0.14, 0.2));
        match random.below(12) {
            0..=4 => {
                let length_mm = whole_mm - random.between(1.0, 18.0);
                cut(params, &mut robot, index, length_mm);
            }
            5 => whisker.fault = Some(Fault::Leak),
            6 => whisker.condition = Condition::Suspected,
            7 => whisker.given_up = true,
            _ => {}
        }
    }
    robot
}

/// Cost of a pair by the policy, computed by the mechanics directly; none if the pair is impossible.
fn cost(params: &Params, robot: &Robot, target: usize, compensator: usize) -> Option<f64> {
    let (broken, one) = (&robot.whiskers[target], &robot.whiskers[compensator]);
    let is_self = target == compensator;
    if let Some(running) =
        robot.head.compensations.iter().find(|one| (one.target(), one.compensator()) == (target, compensator))
    {
        return Some(params.policy.cost(running.case, running.predicted_error, true));
    }
    let may_serve = is_self
        || (robot.head.arrays[0].kind == ArrayKind::Type1
            && one.condition == Condition::Healthy
            && broken.sheet.neighbours.contains(&one.sheet.number));
    if !may_serve || one.fault.is_some() || one.given_up {
        return None;
    }
    let model = params.model("nguyen-2021")?;
    let fitness = Fitness {
        model,
        length: one.filter.length().length,
        pressure: one.sheet.pressure,
        pressures: (Megapascal::ZERO, one.sheet.pressure_max),
        offset: one.filter.offset(),
        own: one.belief(model).predict,
        objective: Objective::Tip,
        usual: UsualContacts::UNKNOWN,
    };
    let proposal = propose(&params.policy, model, broken.target(), broken.filter.offset(), &fitness, is_self);
    Some(params.policy.cost(proposal.case, proposal.predicted_error()?, false))
}

/// Best (served, cost) over every way to serve the targets from the first one on by who is free, or not at all.
fn best(targets: &[usize], taken: u32, costs: &impl Fn(usize, usize) -> Option<f64>, count: usize) -> (usize, f64) {
    let Some((&target, rest)) = targets.split_first() else { return (0, 0.0) };
    let mut found = best(rest, taken, costs, count);
    for compensator in (0..count).filter(|compensator| taken & (1 << compensator) == 0) {
        let Some(cost) = costs(target, compensator) else { continue };
        let (served, others) = best(rest, taken | 1 << compensator, costs, count);
        let with = (served + 1, cost + others);
        if with.0 > found.0 || (with.0 == found.0 && with.1 < found.1) {
            found = with;
        }
    }
    found
}

/// Decides once and compares: as many served as can be, at the least cost.
fn check_against_all(params: &Params, robot: &mut Robot) -> usize {
    let count = robot.whiskers.len();
    let mut before = robot.clone();
    // Those that cannot go on are ended first.
    before.end_broken(params, &mut Vec::new());
    let targets: Vec<usize> =
        (0..count).filter(|&index| robot.whiskers[index].condition == Condition::Trimmed).collect();
    let table: Vec<Vec<Option<f64>>> =
        (0..count).map(|target| (0..count).map(|one| cost(params, &before, target, one)).collect()).collect();
    let costs = |target: usize, compensator: usize| table[target][compensator];
    let expected = best(&targets, 0, &costs, count);
    decide(params, robot);
    let pairs = pairs(robot);
    let found: f64 = pairs.iter().map(|&(target, one)| costs(target, one).expect("only what is offered")).sum();
    assert_eq!(pairs.len(), expected.0, "{pairs:?}: {table:?}");
    // Costs are compared in millionths.
    assert!((found - expected.1).abs() < 1e-5, "{found} against {}: {pairs:?}: {table:?}", expected.1);
    let mut servants: Vec<usize> = pairs.iter().map(|&(_, one)| one).collect();
    servants.sort_unstable();
    servants.dedup();
    assert_eq!(servants.len(), pairs.len(), "nobody serves twice");
    for one in &robot.head.compensations {
        let desired = robot.whiskers[one.compensator()].desired.as_ref().expect("told");
        assert_eq!((desired.compensation, desired.pressure), (Some(one.id), one.pressure), "told what was decided");
    }
    pairs.len()
}

#[test]
fn brute_force_of_10_000_arrays_the_most_are_served_at_the_least_cost() {
    let mut random = Random(2021);
    let mut served = [0; 8];
    let mut changes = 0;
    for at in 0..10_000 {
        let mut params = Params::nguyen_2021(Formulation::Published);
        params.policy.longer_for_shorter =
            [LongerForShorter::Never, LongerForShorter::LastResort, LongerForShorter::Allowed][at % 3];
        params.policy.change_margin = [0.0, 0.02, 0.1][at / 3 % 3];
        params.policy.own_role_cost = [0.0, 0.25][at / 9 % 2];
        let mut robot = any_robot(&params, &mut random);
        served[check_against_all(&params, &mut robot)] += 1;
        // A change, so that compensations in force are weighed against the alternatives.
        let before = pairs(&robot);
        for whisker in robot.whiskers.without_mark() {
            match random.below(8) {
                0 => whisker.fault = None,
                1 => whisker.fault = Some(Fault::SupplyLow),
                2 if whisker.condition == Condition::Suspected => whisker.condition = Condition::Healthy,
                _ => {}
            }
        }
        for one in &mut robot.head.compensations {
            one.predicted_error += random.between(0.0, 0.4);
        }
        check_against_all(&params, &mut robot);
        changes += usize::from(pairs(&robot) != before);
    }
    // The arrays are of the kind that has something to decide.
    assert!(served[2..].iter().sum::<usize>() > 2_000 && changes > 200, "{served:?}, {changes} changed");
}

/// Three in a row of which the one in the middle is broken, and served by the first; the third could serve it
/// with an error that is smaller by `gain`.
fn served_by_the_worse(margin: f64, gain: f64) -> (Params, Robot) {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.policy.change_margin = margin;
    let mut robot = robot(&params, ArrayKind::Type1, &[66.0, 70.0, 66.0], in_a_row(3));
    robot.whiskers[2].fault = Some(Fault::Stale);
    cut(&params, &mut robot, 1, 50.0);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(1, 0)]);
    // The two would do equally well; the one in force is worse than predicted.
    robot.head.compensations[0].predicted_error += gain;
    robot.whiskers[2].fault = None;
    (params, robot)
}

#[test]
fn an_assignment_in_force_is_kept_unless_another_gains_more_than_the_margin() {
    let (params, mut robot) = served_by_the_worse(0.1, 0.099);
    assert_eq!(decide(&params, &mut robot), []);
    assert_eq!(pairs(&robot), [(1, 0)]);

    let (params, mut robot) = served_by_the_worse(0.1, 0.101);
    let effects = decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(1, 2)]);
    assert!(matches!(effects[0], Effect::Ended { reason: EndReason::Reassigned, .. }), "{effects:?}");
    // Not back again: that would have to gain the margin once more.
    assert_eq!(decide(&params, &mut robot), []);
}

#[test]
fn what_runs_is_not_given_up_for_what_nobody_has_approved() {
    let (mut params, mut robot) = served_by_the_worse(0.1, 0.3);
    params.policy.mode = Mode::Advise;
    assert_eq!(decide(&params, &mut robot), []);
    assert_eq!(pairs(&robot), [(1, 0)]);
    // A proposal may be replaced: nothing was sent for it.
    robot.head.compensations[0].proposed = true;
    let effects = decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(1, 2)]);
    assert!(robot.head.compensations[0].is_proposed(), "{effects:?}");
    assert!(!effects.iter().any(|effect| matches!(effect, Effect::Command(_))), "{effects:?}");
}

/// Two neighbours that serve two broken ones crosswise: (target, compensator) (1, 0) and (3, 2), where 2 stands
/// between the two.
#[test]
fn what_one_lets_go_of_another_may_take_in_the_same_decision() {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.policy.change_margin = 0.01;
    // 1 and 3 are broken; 1 may be served by 0 and 2, 3 by 2 and 4.
    let mut robot = robot(&params, ArrayKind::Type1, &[66.0, 70.0, 66.0, 70.0, 66.0], in_a_row(5));
    for index in [0, 4] {
        robot.whiskers[index].fault = Some(Fault::Stale);
    }
    cut(&params, &mut robot, 3, 50.0);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(3, 2)]);
    robot.whiskers[4].fault = None;
    cut(&params, &mut robot, 1, 50.0);
    let effects = decide(&params, &mut robot);
    // 3 moves on to 4, so that 2 can serve 1: one more is served.
    assert_eq!(pairs(&robot), [(1, 2), (3, 4)]);
    let desired = robot.whiskers[2].desired.as_ref().expect("a pressure");
    assert!(desired.compensation.is_some() && desired.reason != Reason::Release, "not released: {desired:?}");
    let ended = effects.iter().position(|effect| matches!(effect, Effect::Ended { .. }));
    let decided = effects.iter().position(|effect| matches!(effect, Effect::Decided(_)));
    assert!(ended < decided, "{effects:?}");
}

#[test]
fn two_that_change_places_gain_the_margin_twice_or_stay() {
    for (gain_each, stays) in [(0.099, true), (0.101, false)] {
        let mut params = Params::nguyen_2021(Formulation::Published);
        params.policy.change_margin = 0.1;
        // 0 and 3 are broken, and 1 and 2 are neighbours of both.
        let beside = |index: usize| if index == 0 || index == 3 { vec![1, 2] } else { vec![0, 3] };
        let mut robot = robot(&params, ArrayKind::Type1, &[70.0, 66.0, 66.0, 70.0], beside);
        cut(&params, &mut robot, 0, 50.0);
        cut(&params, &mut robot, 3, 50.0);
        decide(&params, &mut robot);
        let before = pairs(&robot);
        assert_eq!(before.len(), 2);
        for one in &mut robot.head.compensations {
            one.predicted_error += gain_each;
        }
        decide(&params, &mut robot);
        assert_eq!(pairs(&robot) == before, stays, "{gain_each}");
        for one in &robot.head.compensations {
            let desired = robot.whiskers[one.compensator()].desired.as_ref().expect("a pressure");
            assert_eq!(desired.compensation, Some(one.id), "no release comes after the new setpoint");
        }
    }
}

#[test]
fn whoever_serves_one_that_is_not_called_trimmed_any_more_is_not_given_away() {
    let params = Params::nguyen_2021(Formulation::Published);
    let mut robot = robot(&params, ArrayKind::Type1, &[70.0, 66.0, 70.0], in_a_row(3));
    cut(&params, &mut robot, 0, 50.0);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(0, 1)]);
    robot.whiskers[0].condition = Condition::SensitivityLoss;
    cut(&params, &mut robot, 2, 50.0);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(0, 1)]);
}

#[test]
fn a_pressure_that_is_on_its_way_back_decides_nothing() {
    let params = Params::nguyen_2021(Formulation::Published);
    let mut robot = robot(&params, ArrayKind::Type2, &[70.0], |_| Vec::new());
    cut(&params, &mut robot, 0, 65.0);
    decide(&params, &mut robot);
    let first = robot.head.compensations[0].clone();
    robot.whiskers[0].pressure_set(first.pressure, &params);
    // A fault that comes and goes before the release is carried out; meanwhile the estimate has moved up.
    robot.whiskers[0].fault = Some(Fault::Leak);
    robot.whiskers[0].air.regulator = RegulatorState::Leak;
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), []);
    robot.whiskers[0].fault = None;
    robot.whiskers[0].air.regulator = RegulatorState::Ok;
    set_length(&params, &mut robot.whiskers[0], 65.2);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(0, 0)]);
    assert!(robot.head.compensations[0].pressure > first.pressure, "{:?}", robot.head.compensations[0]);
    assert_eq!(robot.head.compensations[0].pressure_before, robot.whiskers[0].sheet.pressure);
}

#[test]
fn a_leak_that_only_readings_show_ends_a_compensation_once_the_pressure_is_not_held() {
    let params = Params::nguyen_2021(Formulation::Published);
    let mut robot = robot(&params, ArrayKind::Type2, &[70.0], |_| Vec::new());
    cut(&params, &mut robot, 0, 65.0);
    decide(&params, &mut robot);
    let pressure = robot.head.compensations[0].pressure;
    robot.whiskers[0].pressure_set(pressure, &params);
    robot.whiskers[0].air.measure(pressure);
    robot.whiskers[0].fault = Some(Fault::Leak);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(0, 0)], "it may be no leak");
    robot.whiskers[0].air.measure(Megapascal::ZERO);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), []);
}

#[test]
fn every_change_of_condition_is_decided_on_at_once() {
    let params = Params::nguyen_2021(Formulation::Published);
    let mut robot = robot(&params, ArrayKind::Type1, &[66.0, 70.0], in_a_row(2));
    robot.whiskers[0].condition = Condition::Suspected;
    cut(&params, &mut robot, 1, 50.0);
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [], "one that is suspected is not asked");
    robot.set_condition(0, Condition::Healthy, &mut Vec::new());
    decide(&params, &mut robot);
    assert_eq!(pairs(&robot), [(1, 0)]);
    robot.set_condition(0, Condition::SensitivityLoss, &mut Vec::new());
    let effects = decide(&params, &mut robot);
    assert_eq!(pairs(&robot), []);
    assert!(
        effects.iter().any(|effect| matches!(effect, Effect::Ended { reason: EndReason::CompensatorBroken, .. })),
        "{effects:?}"
    );
}
