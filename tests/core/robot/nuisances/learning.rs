//! A cut while the whisker is still learned.

use super::rig::Rig;

const CUT_MM: f64 = 5.0;

#[test]
fn property_a_cut_while_learning_is_called_with_its_length() {
    for at in [60, 100] {
        let mut covered = 0;
        for seed in 0..20 {
            let mut rig = Rig::new(7000 + seed, 1);
            rig.run(at);
            rig.whiskers[0].length_mm -= CUT_MM;
            rig.run(600);
            let trims = rig.trims();
            assert_eq!(trims.len(), 1, "seed {seed}, at {at}: {:?}", rig.verdicts());
            let length = trims[0].1.length_after;
            assert!(length.sd_mm < 1.0, "seed {seed}, at {at}: an interval that tells something: {length:?}");
            covered += u32::from((length.length.mm() - rig.whiskers[0].length_mm).abs() <= 1.96 * length.sd_mm);
        }
        assert!(covered >= 18, "at {at}: {covered} of 20");
    }
}
