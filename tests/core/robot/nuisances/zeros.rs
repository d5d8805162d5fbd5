//! Robots whose millimetres are off: their touch tests call no whole whisker cut, and find cuts all the same.

use super::rig::{ARRAY, Rig, Tests};
use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{Condition, Effect, TestReason, TouchTest};
use vibrissa_core::robot::{Event, OperatorAction, Outcome, Place};

/// Contacts in which a whisker is learned, and the tests of its zero are done.
const LEARNED_CONTACTS: u64 = 600;
const TESTS: [Tests; 2] = [Tests::Does, Tests::Sweeps];

/// A learned whisker of a robot whose distances are short by this, mm.
fn learned(seed: u64, off_mm: f64, tests: Tests, states_distance: bool) -> Rig {
    let mut rig = Rig::with_tests(seed, 1, tests);
    rig.off_mm = off_mm;
    rig.states_distance = states_distance;
    rig.run(LEARNED_CONTACTS);
    rig
}

/// An operator's test, and as many contacts after it.
fn test(rig: &mut Rig, contacts: u64) {
    let asked = OperatorAction::TouchTest(Place { array: ARRAY, whisker: 0 });
    assert_eq!(rig.tested(&Event::Operator(&asked)), Outcome::Taken);
    rig.run(contacts);
}

/// Touches of the tests of the length from this round to the first trim.
fn touches_since(rig: &Rig, since: u64) -> usize {
    let contacts = |test: &TouchTest| (test.reason != TestReason::Setpoint).then(|| usize::from(test.contacts));
    let tests = rig.picked(|effect| if let Effect::Test(test) = effect { contacts(test) } else { None });
    let until = rig.trims().first().map_or(u64::MAX, |(round, _)| *round);
    tests.into_iter().filter(|(round, _)| (since..=until).contains(round)).map(|(_, contacts)| contacts).sum()
}

#[test]
fn property_distances_that_are_off_make_no_whole_whisker_look_cut() {
    for off_mm in [-3.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 3.0] {
        for tests in TESTS {
            let mut called = 0;
            for seed in 0..6 {
                let mut rig = learned(9000 + seed, off_mm, tests, seed % 2 == 0);
                for _ in 0..3 {
                    test(&mut rig, 150);
                }
                called += rig.trims().len();
                assert!((rig.view(0).length.length.mm() - 70.0).abs() < 0.5, "{off_mm}, {tests:?}, seed {seed}");
                let condition = rig.view(0).condition;
                assert_eq!(condition, Condition::Healthy, "{off_mm}, {tests:?}, seed {seed}");
            }
            assert_eq!(called, 0, "{off_mm}, {tests:?}");
        }
    }
}

/// Nearly all are called within 30 touches. A wall tells small cuts later.
#[test]
fn property_a_cut_is_measured_with_distances_that_are_off() {
    for (off_mm, tests) in [-3.0, -1.0, 2.0, 3.0].into_iter().flat_map(|off_mm| TESTS.map(|tests| (off_mm, tests))) {
        let mut within = 0;
        for (seed, length_mm) in [67.0, 65.0, 62.0].into_iter().flat_map(|mm| [(1, mm), (2, mm), (3, mm)]) {
            let mut rig = learned(9100 + seed, off_mm, tests, true);
            rig.whiskers[0].length_mm = length_mm;
            let since = rig.rounds;
            test(&mut rig, 500);
            let trims = rig.trims();
            let [(_, trim)] = trims[..] else {
                panic!("{off_mm}, {tests:?}, {length_mm}, seed {seed}: {:?} {:?}", rig.view(0), rig.conditions())
            };
            let (error_mm, sd_mm) = (trim.length_after.length.mm() - length_mm, trim.length_after.sd_mm);
            assert!(error_mm.abs() < 3.0 * sd_mm && sd_mm < 0.7, "{off_mm}, {tests:?}, {length_mm}: {trim:?}");
            within += usize::from(touches_since(&rig, since) <= 30);
        }
        assert!(within >= 7, "{off_mm}, {tests:?}: {within} of 9");
    }
}

/// A test of a whisker that is cut before the error of the distances is known tells nothing of a few millimetres.
#[test]
fn property_without_a_zero_a_test_calls_no_cut_that_the_distances_may_explain() {
    for tests in TESTS {
        for seed in 0..4 {
            let mut rig = Rig::with_tests(9200 + seed, 1, tests);
            rig.params.policy.mode = Mode::Advise;
            (rig.off_mm, rig.states_distance) = (3.0, true);
            rig.run(LEARNED_CONTACTS);
            assert_eq!(touches_since(&rig, 0), 0, "nobody asked");
            test(&mut rig, 300);
            assert_eq!(rig.trims().len(), 0, "{tests:?}, seed {seed}");
        }
    }
}

fn figures(off_mm: f64, tests: Tests, whiskers: u64, zero_sd_mm: f64) -> (usize, usize, usize) {
    let (mut called, mut found, mut cuts) = (0, 0, 0);
    for seed in 0..whiskers {
        let mut rig = Rig::with_tests(19_000 + seed, 1, tests);
        rig.params.touch_tests.zero_sd_mm = zero_sd_mm;
        (rig.off_mm, rig.states_distance) = (off_mm, seed % 2 == 0);
        rig.run(LEARNED_CONTACTS);
        (0..3).for_each(|_| test(&mut rig, 150));
        called += rig.trims().len().min(1);
        if seed % 2 == 0 && rig.trims().is_empty() {
            cuts += 1;
            rig.whiskers[0].length_mm = [68.0, 65.0, 62.0][seed as usize / 2 % 3];
            let since = rig.rounds;
            test(&mut rig, 500);
            found += usize::from(!rig.trims().is_empty() && touches_since(&rig, since) <= 30);
        }
    }
    (called, found, cuts)
}

/// Prints the table of the errors that distances share, where the core trusts the distances and where it does not.
#[test]
#[ignore = "a measurement"]
fn measure_zeros() {
    for off_mm in [-3.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 3.0] {
        for tests in TESTS {
            for zero_sd_mm in [0.0, 1.5] {
                let (called, found, cuts) = figures(off_mm, tests, 48, zero_sd_mm);
                println!("{off_mm:5} mm, {tests:?}, {zero_sd_mm}: {called} of 48 called, {found} of {cuts} cuts found");
            }
        }
    }
}

/// A robot whose millimetres are right measures the length itself, and the error of the factory length counts no more. If its
/// millimetres are as doubtful as usual, it stays in the interval.
#[test]
fn property_a_measured_length_owes_nothing_to_the_factory_length() {
    let (mut held, mut all) = (0, 0);
    for (seed, tests) in (0..12).flat_map(|seed| TESTS.map(|tests| (seed, tests))) {
        for zero_sd_mm in [0.0, 1.5] {
            let mut rig = Rig::with_tests(9300 + seed, 1, tests);
            rig.params.touch_tests.zero_sd_mm = zero_sd_mm;
            rig.states_distance = true;
            let whole_mm = if seed % 2 == 0 { 70.5 } else { 69.5 };
            rig.whiskers[0].length_mm = whole_mm;
            rig.run(LEARNED_CONTACTS);
            let (length, relative) = (rig.view(0).length, rig.view(0).relative_length);
            let factory_variance = length.sd_mm.powi(2) - relative.sd_mm.powi(2);
            assert!(factory_variance > 0.04, "seed {seed}: {length:?} {relative:?}");
            rig.whiskers[0].length_mm = whole_mm - 6.0;
            test(&mut rig, 500);
            assert_eq!(rig.trims().len(), 1, "seed {seed}, {tests:?}");
            let (length, relative) = (rig.view(0).length, rig.view(0).relative_length);
            let is_free = length == relative;
            assert_eq!(is_free, zero_sd_mm == 0.0, "seed {seed}, {tests:?}: {length:?} {relative:?}");
            if is_free {
                all += 1;
                held += usize::from((length.length.mm() - (whole_mm - 6.0)).abs() < 1.96 * length.sd_mm);
            }
        }
    }
    assert!(10 * held >= 9 * all, "{held} of {all}");
}

/// A gauge that is not plugged in yet: five empty tests ended the measurement of the zero, and no test told anything from then on.
#[test]
fn regress_tests_without_touches_leave_the_zero_to_be_measured() {
    let mut rig = Rig::with_tests(9700, 1, Tests::Empty);
    rig.run(2 * LEARNED_CONTACTS);
    assert_eq!(rig.view(0).zero, None, "nothing was measured");
    rig.tests = Tests::Sweeps;
    for _ in 0..3 {
        test(&mut rig, 50);
    }
    assert!(rig.view(0).zero.is_some_and(|(_, sd_mm)| sd_mm < 0.5), "{:?}", rig.view(0).zero);
}

/// Only a whole whisker tells the zero of the robot's distances. A cut one lost it with its readings, and its tests told nothing
/// any more.
#[test]
fn regress_readings_that_are_learned_anew_keep_the_zero_of_the_distances() {
    let mut rig = learned(9800, 2.0, Tests::Sweeps, true);
    test(&mut rig, 150);
    rig.whiskers[0].length_mm -= 5.0;
    rig.run(300);
    let before = rig.view(0).zero;
    assert!(before.is_some() && rig.view(0).condition == Condition::Trimmed, "{before:?}");
    let asked = OperatorAction::Rebaseline(Place { array: ARRAY, whisker: 0 });
    assert_eq!(rig.tested(&Event::Operator(&asked)), Outcome::Taken);
    assert_eq!(rig.view(0).zero, before);
}
