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

/// Prints what share of the intervals of 95 % holds the length while it wears, and 300 and 2,000 contacts after the end.
#[test]
fn property_intervals_of_length_hold_the_truth_while_a_whisker_wears_and_afterwards() {
    let mut all = [(0, 0); 3];
    for (rate_mm, seeds) in [(0.001, 0..12), (0.002, 12..24), (0.005, 24..36), (0.01, 36..48), (0.02, 48..60)] {
        let mut held = [(0, 0); 3];
        let mut errors = Vec::new();
        for seed in seeds {
            let mut rig = Rig::new(4500 + seed, 3);
            rig.run(600);
            let note = |rig: &Rig, held: &mut (u32, u32)| {
                // The whiskers are as long as their factsheets say.
                let length = rig.view(0).relative_length;
                held.0 += u32::from((length.length.mm() - rig.whiskers[0].length_mm).abs() <= 1.96 * length.sd_mm);
                held.1 += 1;
            };
            let contacts = (8.0 / rate_mm) as u64;
            for part in 0..8 {
                rig.run_with(contacts / 8, |rig| rig.whiskers[0].length_mm -= rate_mm);
                if part >= 2 {
                    note(&rig, &mut held[0]);
                }
            }
            rig.run(300);
            note(&rig, &mut held[1]);
            rig.run(1700);
            note(&rig, &mut held[2]);
            let length = rig.view(0).relative_length;
            errors.push((length.length.mm() - rig.whiskers[0].length_mm, length.sd_mm));
        }
        println!("{rate_mm} mm: {held:?}, errors and standard deviations {errors:.2?}");
        all.iter_mut().zip(held).for_each(|(all, one)| *all = (all.0 + one.0, all.1 + one.1));
    }
    println!("while it wears, 300 and 2,000 contacts afterwards: {all:?}");
    assert!(all.iter().all(|&(held, count)| 100 * held >= 88 * count), "{all:?}");
}
