//! An eroding whisker reads correctly while it erodes, and is a cut one afterwards.

use vibrissa_core::robot::effect::{Condition, Effect};

use super::rig::Rig;

const SEEDS: u64 = 4;

fn setpoints(rig: &Rig) -> usize {
    rig.picked(|effect| matches!(effect, Effect::Command(_)).then_some(())).len()
}

#[test]
fn property_an_eroding_whisker_reads_correctly_with_its_gain() {
    for rate_mm in [0.002, 0.004, 0.006] {
        for seed in 0..SEEDS {
            let case = format!("{rate_mm} mm, seed {seed}");
            let mut rig = Rig::new(4000 + seed, 3);
            rig.run(600);
            let contacts = (10.0 / rate_mm) as u64;
            let mut errors = Vec::new();
            rig.run_with(contacts, |rig| {
                rig.whiskers[0].length_mm -= rate_mm;
                if rig.rounds.is_multiple_of(20) {
                    errors.push(rig.reading_error(0));
                }
            });
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            assert!(mean <= 0.03, "{case}: {mean}");
            assert!(setpoints(&rig) <= 35, "{case}: {}", setpoints(&rig));
            assert_eq!(rig.trims().len(), 0, "{case}");
            let since = rig.rounds;
            rig.run(600);
            let stopped = rig.picked(|effect| {
                matches!(effect, Effect::Condition { whisker: 0, to: Condition::Trimmed, .. }).then_some(())
            });
            let after = stopped.last().map(|(round, ())| *round as i64 - since as i64);
            assert!(after.is_some_and(|after| (0..600).contains(&after)), "{case}: {after:?}");
            assert_eq!(rig.view(0).condition, Condition::Trimmed, "{case}");
            // The model's error by pressure counts as length.
            assert!((rig.view(0).length.length.mm() - 60.0).abs() < 2.5, "{case}: {:?}", rig.view(0).length);
            rig.run(1000);
            assert!(rig.reading_error(0) <= 0.03, "{case}: {}", rig.reading_error(0));
        }
    }
}
