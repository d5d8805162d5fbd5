//! The strain of real rubber falls behind the deflection: its response bends.

use super::rig::Rig;

const BEND_PER_MM: f64 = -0.015;
const WHISKERS: u64 = 40;

#[test]
fn property_other_deflections_are_no_change_of_a_whisker_whose_response_bends() {
    let (all, small, large) = ((0.5, 6.0), (0.5, 2.0), (3.5, 6.0));
    let mut wrong = Vec::new();
    for (first, then) in [(all, small), (all, large), (small, large), (large, small)] {
        for seed in 0..WHISKERS {
            let mut rig = Rig::new(6000 + seed, 1);
            rig.noise.bend_per_mm = BEND_PER_MM;
            rig.noise.deflections_mm = first;
            rig.run(1500);
            rig.noise.deflections_mm = then;
            rig.run(1500);
            if !rig.verdicts().is_empty() {
                wrong.push((seed, first, then, rig.verdicts()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn property_a_cut_is_found_among_small_deflections() {
    for seed in 0..20 {
        let mut rig = Rig::new(6100 + seed, 1);
        rig.noise.bend_per_mm = BEND_PER_MM;
        rig.run(1500);
        rig.noise.deflections_mm = (0.5, 2.0);
        rig.run(100);
        rig.whiskers[0].length_mm = 66.0;
        rig.run(100);
        let trims = rig.trims();
        assert_eq!(trims.len(), 1, "seed {seed}");
        let length = trims[0].1.length_after;
        assert!((length.length.mm() - 66.0).abs() <= 4.0 * length.sd_mm, "seed {seed}: {length:?}");
    }
}
