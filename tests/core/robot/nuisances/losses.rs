//! A loss of sensitivity is no change of length, and forgets none.

use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{AlarmKind, Condition};

use super::rig::Rig;

const SEEDS: u64 = 6;

/// A loss of 3 % may pass for a wandering gain; one of 5 % does not.
#[test]
fn regress_a_loss_of_sensitivity_keeps_a_cut_and_its_compensation() {
    for (seed, gain, alarms) in (0..SEEDS).flat_map(|seed| [(seed, 0.97, 0..=1), (seed, 0.95, 1..=1)]) {
        let mut rig = Rig::new(seed, 1);
        rig.run(400);
        rig.whiskers[0].length_mm = 60.0;
        rig.run(1500);
        assert_eq!(rig.trims().len(), 1, "seed {seed}");
        let (before, pressure) = (rig.view(0).length, rig.whiskers[0].pressure);
        assert!(pressure.mpa() < 0.099, "seed {seed}: compensated");
        rig.whiskers[0].gain = gain;
        rig.run(1000);
        assert!(alarms.contains(&rig.alarms(AlarmKind::SensitivityLoss).len()), "seed {seed}, {gain}");
        let after = rig.view(0).length;
        assert!((after.length.mm() - before.length.mm()).abs() < 0.3, "seed {seed}: {before:?} {after:?}");
        assert!((after.length.mm() - 60.0).abs() < 1.0, "seed {seed}: {after:?}");
        assert_eq!(rig.core.compensations().len(), 1, "seed {seed}");
        assert!((rig.whiskers[0].pressure.mpa() - pressure.mpa()).abs() < 0.01, "seed {seed}");
        assert_eq!(rig.trims().len(), 1, "seed {seed}");
    }
}

/// The whisker became SUSPECTED, as a whole one whose loss ends.
#[test]
fn regress_the_end_of_a_loss_of_sensitivity_ends_no_earlier_cut() {
    for (seed, mode) in (0..SEEDS).flat_map(|seed| [(seed, Mode::Automatic), (seed, Mode::Advise)]) {
        let mut rig = Rig::new(5200 + seed, 1);
        rig.params.policy.mode = mode;
        rig.run(400);
        rig.whiskers[0].length_mm = 60.0;
        rig.run(1500);
        assert_eq!(rig.view(0).condition, Condition::Trimmed, "seed {seed}");
        rig.whiskers[0].gain = 0.8;
        rig.run(1000);
        assert_eq!(rig.view(0).condition, Condition::SensitivityLoss, "seed {seed}");
        rig.whiskers[0].gain = 1.0;
        rig.run(3000);
        let view = rig.view(0);
        assert_eq!((view.condition, rig.trims().len()), (Condition::Trimmed, 1), "seed {seed}, {mode:?}");
        let (off_mm, sd_mm) = (view.length.length.mm() - 60.0, view.length.sd_mm);
        assert!(off_mm.abs() < 1.96 * sd_mm, "seed {seed}, {mode:?}: {off_mm} mm, sd {sd_mm} mm");
    }
}

/// The contacts before the alarm moved the length, and the verdict takes that back.
#[test]
fn property_a_loss_of_sensitivity_is_no_length() {
    for seed in 0..SEEDS {
        for gain in [0.95, 0.8, 0.5] {
            let mut rig = Rig::new(100 + seed, 1);
            rig.run(1000);
            let before = rig.view(0).length;
            rig.whiskers[0].gain = gain;
            rig.run(300);
            assert_eq!(rig.view(0).condition, Condition::SensitivityLoss, "seed {seed}, {gain}");
            let after = rig.view(0).length;
            assert!((after.length.mm() - before.length.mm()).abs() < 0.05, "{seed}, {gain}: {before:?} {after:?}");
        }
    }
}

#[test]
fn property_a_cut_after_a_loss_is_compensated_to_the_response_before_the_loss() {
    for (seed, gain) in (0..SEEDS).flat_map(|seed| [(seed, 0.9), (seed, 0.8)]) {
        let mut rig = Rig::new(300 + seed, 1);
        rig.run(600);
        rig.whiskers[0].gain = gain;
        rig.run(600);
        assert_eq!(rig.view(0).condition, Condition::SensitivityLoss, "seed {seed}, {gain}");
        rig.whiskers[0].length_mm = 58.0;
        rig.run(1500);
        assert_eq!(rig.view(0).condition, Condition::Trimmed, "seed {seed}, {gain}");
        let off = rig.reading_error(0);
        assert!(off < 0.02, "seed {seed}, {gain}: {off}");
    }
}

/// The gauge reads less, and the compensated whisker shall still read as it did while whole.
#[test]
fn regress_the_gain_is_renewed_after_a_loss_of_sensitivity() {
    for (seed, gain) in (0..SEEDS).flat_map(|seed| [(seed, 0.97), (seed, 0.95)]) {
        let mut rig = Rig::new(200 + seed, 1);
        rig.run(600);
        rig.whiskers[0].length_mm = 60.0;
        rig.run(1500);
        let before = rig.reading_error(0);
        rig.whiskers[0].gain = gain;
        assert!(rig.reading_error(0) > 0.02, "seed {seed}, {gain}");
        rig.run(1000);
        let after = rig.reading_error(0);
        assert!(before < 0.02 && after < 0.02, "seed {seed}, {gain}: {before} {after}");
    }
}
