//! The rubber's stiffness follows the temperature, which the robot measures.

use std::f64::consts::TAU;

use super::rig::Rig;

/// Contacts of a whisker in a day.
const DAY: u64 = 3000;
const PER_K: f64 = 0.005;
/// Half of the daily swing, K.
const SWING_K: f64 = 5.0;

/// Lives through days in which the temperature swings around that of the installation.
fn live(rig: &mut Rig, days: u64, phase: f64) {
    let (middle_c, start) = (rig.temperature_c, rig.rounds);
    rig.run_with(days * DAY, |rig| {
        let day = (rig.rounds - start) as f64 / DAY as f64;
        rig.temperature_c = middle_c + SWING_K * ((TAU * day + phase).sin() - phase.sin());
    });
}

#[test]
fn property_a_daily_swing_is_no_change_and_ends_no_compensation() {
    for seed in 0..42 {
        let mut rig = Rig::new(5000 + seed, 1);
        rig.whiskers[0].per_k = if seed % 2 == 0 { PER_K } else { -PER_K };
        let cut = seed < 17;
        rig.run(500);
        if cut {
            rig.whiskers[0].length_mm = 62.0;
            rig.run(300);
        }
        live(&mut rig, 2, 0.3 * seed as f64);
        assert_eq!(rig.verdicts().len(), usize::from(cut), "seed {seed}: {:?}", rig.verdicts());
        assert_eq!(rig.core.compensations().len(), usize::from(cut), "seed {seed}");
        let length = rig.view(0).length;
        let true_mm = rig.whiskers[0].length_mm;
        assert!((length.length.mm() - true_mm).abs() <= 4.0 * length.sd_mm.max(0.05), "seed {seed}: {length:?}");
    }
}

#[test]
fn property_a_cut_while_the_temperature_swings_is_found() {
    for seed in 0..20 {
        let mut rig = Rig::new(5100 + seed, 1);
        rig.whiskers[0].per_k = if seed % 2 == 0 { 2.0 * PER_K } else { -2.0 * PER_K };
        rig.run(300);
        live(&mut rig, 1, 0.3 * seed as f64);
        let (at, whole_c) = (rig.rounds, rig.temperature_c);
        rig.whiskers[0].length_mm = 67.0;
        rig.run_with(100, |rig| rig.temperature_c = whole_c + 0.01 * (rig.rounds - at) as f64);
        let trims = rig.trims();
        assert_eq!(trims.len(), 1, "seed {seed}");
        assert!(trims[0].0 >= at, "seed {seed}");
        let length = trims[0].1.length_after;
        assert!((length.length.mm() - 67.0).abs() <= 4.0 * length.sd_mm, "seed {seed}: {length:?}");
    }
}
