//! Touch tests confirm small cuts and cuts under noise that lasts from contact to contact, where the robot offers them.

use super::rig::{Rig, Tests};
use vibrissa_core::robot::effect::{Condition, Effect, TestReason};

/// Correlation from contact to contact, and size, relative.
const LASTING: (f64, f64) = (0.8, 0.05);
const LEARNED_CONTACTS: u64 = 1500;

/// A whisker after it has been learned. `None` if it is not healthy then.
fn learned(seed: u64, correlated: (f64, f64), tests: Tests) -> Option<Rig> {
    let mut rig = Rig::with_tests(seed, 1, tests);
    if tests != Tests::Does {
        // Its distances are known to be right: otherwise a test could not confirm a cut.
        rig.params.touch_tests.zero_sd_mm = 0.0;
    }
    rig.noise.correlated = correlated;
    rig.run(LEARNED_CONTACTS);
    (rig.view(0).condition == Condition::Healthy).then_some(rig)
}

fn tests_of_a_change(rig: &Rig) -> usize {
    rig.picked(|effect| matches!(effect, Effect::Test(test) if test.reason == TestReason::Change).then_some(())).len()
}

#[test]
fn property_a_touch_test_confirms_a_cut_under_noise_that_lasts() {
    let (mut found, mut asked) = (0, 0);
    for seed in 0..12 {
        let Some(mut rig) = learned(8300 + seed, LASTING, Tests::Does) else { continue };
        rig.whiskers[0].length_mm = 64.0;
        rig.run(800);
        let trims = rig.trims();
        let [(_, trim), ..] = trims[..] else { panic!("seed {seed}: {:?}", rig.conditions()) };
        let off_mm = (trim.length_after.length.mm() - 64.0).abs();
        assert!(off_mm < 3.0 * trim.length_after.sd_mm && off_mm < 1.5, "seed {seed}: {trim:?}");
        asked += usize::from(tests_of_a_change(&rig) >= 1);
        found += 1;
    }
    // A whisker may be suspected all the time, so that the error of its distances is not measured.
    assert!(found >= 10 && asked >= 9, "{found}, {asked}");
}

/// Trims and tests of 20 whiskers whose gain rises at once, which looks like a cut.
fn after_a_rise(gain: f64, correlated: (f64, f64), tests: Tests) -> (usize, usize) {
    let (mut trims, mut asked) = (0, 0);
    for seed in 0..20 {
        let Some(mut rig) = learned(8400 + seed, correlated, tests) else { continue };
        rig.whiskers[0].gain = gain;
        rig.run(3000);
        trims += rig.trims().len();
        asked += tests_of_a_change(&rig);
    }
    (trims, asked)
}

/// A tenth looks like a cut of 3 mm. Most robots without tests take it for a wandering gain, too.
#[test]
fn property_a_touch_test_refutes_a_cut_that_is_a_gain_under_noise_that_lasts() {
    let (without, _) = after_a_rise(1.10, LASTING, Tests::NotOffered);
    let (with, asked) = after_a_rise(1.10, LASTING, Tests::Does);
    assert!(without >= 3 && with == 0 && asked >= 12, "{without} trims without tests, {with} with {asked}");
}

/// 6 % look like a cut of 2 mm.
#[test]
fn property_a_touch_test_refutes_a_small_cut_of_a_steady_whisker_that_is_a_gain() {
    let (without, _) = after_a_rise(1.06, (0.0, 0.0), Tests::NotOffered);
    let (with, asked) = after_a_rise(1.06, (0.0, 0.0), Tests::Does);
    assert!(without >= 18 && with == 0 && asked >= 18, "{without} trims without tests, {with} with {asked}");
}

#[test]
fn property_a_robot_that_does_not_do_its_test_delays_no_report_for_long() {
    for tests in [Tests::Rejects, Tests::Ignores] {
        for seed in 0..6 {
            let Some(mut rig) = learned(8500 + seed, LASTING, tests) else { continue };
            rig.whiskers[0].length_mm = 60.0;
            rig.run(800);
            assert!(
                tests_of_a_change(&rig) >= 1 && !rig.trims().is_empty(),
                "{tests:?}, seed {seed}: {:?}",
                rig.conditions()
            );
        }
    }
}
