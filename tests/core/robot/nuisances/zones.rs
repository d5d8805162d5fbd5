//! Contacts move to another zone of the whisker: nothing about the whisker has changed.

use super::rig::Rig;

const NEAR_AND_FAR: [((f64, f64), (f64, f64)); 2] = [((0.8, 0.9), (0.5, 0.6)), ((0.5, 0.6), (0.8, 0.9))];
const WHISKERS: u64 = 60;

/// A whisker that learns in one zone and then is touched in the other.
fn moved(seed: u64, (first, then): ((f64, f64), (f64, f64))) -> Rig {
    let mut rig = Rig::new(seed, 1);
    rig.noise.ratios = first;
    rig.run(2000);
    rig.noise.ratios = then;
    rig
}

/// The error of a contact ratio, 1 % as assumed, flattens the slope of the strain over the ratio within a zone.
#[test]
fn property_contacts_that_move_to_another_zone_are_no_change_of_the_whisker() {
    for zones in NEAR_AND_FAR {
        let wrong: Vec<u64> = (0..WHISKERS)
            .filter(|&seed| {
                let mut rig = moved(3000 + seed, zones);
                rig.run(2000);
                !rig.verdicts().is_empty()
            })
            .collect();
        assert!(wrong.len() <= 1, "{zones:?}: {wrong:?} of {WHISKERS}");
    }
}

#[test]
fn property_a_cut_after_the_move_is_found_with_its_length() {
    for zones in NEAR_AND_FAR {
        let mut covered = 0;
        for seed in 0..20 {
            let mut rig = moved(4000 + seed, zones);
            rig.run(100);
            rig.whiskers[0].length_mm = 65.0;
            rig.run(60);
            let trims = rig.trims();
            assert_eq!(trims.len(), 1, "seed {seed}, {zones:?}");
            let length = trims[0].1.length_after;
            covered += u32::from((length.length.mm() - 65.0).abs() <= 1.96 * length.sd_mm);
        }
        assert!(covered >= 17, "{zones:?}: {covered} of 20");
    }
}
