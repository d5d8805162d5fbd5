//! Errors of maintenance: cables of two whiskers exchanged, a gauge reversed, a whisker replaced without a word. They are named
//! within 200 contacts, and no setpoint goes out for them.

use vibrissa_core::robot::effect::{AlarmKind, Condition, Effect};
use vibrissa_core::robot::{Event, OperatorAction, Place};

use super::rig::{ARRAY, Rig};

const SEEDS: u64 = 6;
const LEARNED: u64 = 800;
const NAMED_WITHIN: u64 = 200;

fn commands(rig: &Rig, since: u64) -> usize {
    let sent = rig.picked(|effect| matches!(effect, Effect::Command(_)).then_some(()));
    sent.iter().filter(|(round, ())| *round >= since).count()
}

/// The gauges of the first two whiskers are connected to each other's amplifier: a touch of one is told of the other.
fn exchange(rig: &mut Rig) {
    rig.whiskers.swap(0, 1);
}

/// Whiskers of which the first is as sensitive as `gain`, after they were learned.
fn learned(seed: u64, gain: f64) -> Rig {
    let mut rig = Rig::new(seed, 4);
    rig.whiskers[0].gain = gain;
    rig.run(LEARNED);
    rig
}

#[test]
fn property_exchanged_cables_are_named_and_no_setpoint_is_sent() {
    for gain in [0.8, 1.25] {
        for seed in 0..SEEDS {
            let case = format!("gain {gain}, seed {seed}");
            let mut rig = learned(7000 + seed, gain);
            let since = rig.rounds;
            exchange(&mut rig);
            rig.run(NAMED_WITHIN);
            let mut named: Vec<usize> =
                rig.alarms(AlarmKind::CablesExchanged).into_iter().map(|(_, whisker)| whisker).collect();
            named.sort_unstable();
            assert_eq!(named, [0, 1], "{case}: {:?}", rig.verdicts());
            assert_eq!((rig.trims().len(), commands(&rig, since)), (0, 0), "{case}: {:?}", rig.verdicts());
            rig.run(1500);
            assert_eq!((rig.trims().len(), commands(&rig, since)), (0, 0), "{case}: {:?}", rig.verdicts());
            exchange(&mut rig);
            rig.run(NAMED_WITHIN);
            let cleared = rig.picked(|effect| match effect {
                Effect::AlarmCleared { whisker, kind: AlarmKind::CablesExchanged } => Some(*whisker),
                _ => None,
            });
            assert_eq!(cleared.len(), 2, "{case}: put right, {:?}", rig.conditions());
            rig.run(1000);
            assert_eq!((rig.trims().len(), commands(&rig, since)), (0, 0), "{case}: {:?}", rig.verdicts());
        }
    }
}

#[test]
fn property_a_cut_beside_a_loss_of_sensitivity_of_another_size_is_called() {
    for seed in 0..SEEDS {
        let mut rig = Rig::new(7100 + seed, 4);
        rig.run(LEARNED);
        rig.whiskers[0].length_mm = 62.0;
        rig.whiskers[1].gain = 0.9;
        rig.run(400);
        let trimmed: Vec<usize> = rig.trims().iter().map(|(_, trim)| trim.whisker).collect();
        assert_eq!(trimmed, [0], "seed {seed}: {:?}", rig.verdicts());
        assert_eq!(rig.alarms(AlarmKind::CablesExchanged), [], "seed {seed}");
    }
}

#[test]
fn property_a_reversed_gauge_is_named_and_ends_when_it_is_put_right() {
    for seed in 0..SEEDS {
        let mut rig = learned(7200 + seed, 1.0);
        rig.whiskers[0].gain = -1.0;
        let since = rig.rounds;
        rig.run(NAMED_WITHIN);
        assert_eq!(rig.alarms(AlarmKind::GaugeReversed).len(), 1, "seed {seed}");
        assert_eq!(rig.view(0).fault, None, "seed {seed}");
        rig.whiskers[0].gain = 1.0;
        rig.run(NAMED_WITHIN);
        let stands = rig.view(0).standing.kinds().any(|kind| kind == AlarmKind::GaugeReversed);
        assert!(!stands && commands(&rig, since) == 0, "seed {seed}");
        assert_eq!(rig.view(0).condition, Condition::Healthy, "seed {seed}");
    }
}

#[test]
fn property_a_new_whisker_for_a_cut_one_is_named_until_somebody_says_so() {
    for seed in 0..SEEDS {
        let mut rig = learned(7300 + seed, 1.0);
        rig.whiskers[0].length_mm = 64.0;
        rig.run(1200);
        assert_eq!(rig.view(0).condition, Condition::Trimmed, "seed {seed}");
        let since = rig.rounds;
        rig.whiskers[0].length_mm = 70.0;
        rig.run(NAMED_WITHIN);
        assert_eq!(rig.alarms(AlarmKind::WhiskerReplaced).len(), 1, "seed {seed}: {:?}", rig.verdicts());
        rig.run(500);
        assert_eq!(commands(&rig, since), 0, "seed {seed}");
        rig.step(&Event::Operator(&OperatorAction::Replaced(Place { array: ARRAY, whisker: 0 })));
        rig.run(1000);
        assert_eq!(
            (rig.view(0).standing.kinds().count(), rig.view(0).condition),
            (0, Condition::Healthy),
            "seed {seed}"
        );
    }
}

/// Each second reading is far too large. An outlier is no change, but so many are no outliers.
#[test]
fn regress_readings_that_stay_off_are_named_although_nothing_is_suspected() {
    for seed in 0..SEEDS {
        let mut rig = learned(7400 + seed, 1.0);
        rig.run(400);
        assert_eq!(rig.alarms(AlarmKind::ModelMisfit), [], "seed {seed}");
        rig.run_with(100, |rig| rig.whiskers[0].gain = if rig.rounds.is_multiple_of(2) { 1.9 } else { 1.0 });
        let alarms = rig.alarms(AlarmKind::ModelMisfit);
        assert!(alarms.len() == 1 || rig.view(0).condition == Condition::Suspected, "seed {seed}: {alarms:?}");
        rig.whiskers[0].gain = 1.0;
        rig.run(150);
        assert!(rig.view(0).standing.kinds().all(|kind| kind != AlarmKind::ModelMisfit), "seed {seed}");
    }
}
