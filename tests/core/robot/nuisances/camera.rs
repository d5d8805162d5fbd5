//! A camera that has moved: all contact ratios of a robot are off by the same.

use vibrissa_core::robot::effect::{AlarmKind, Condition};

use super::rig::Rig;

const WHISKERS: usize = 6;
const LEARNED: u64 = 800;
const AFTER: u64 = 3000;
/// Rounds in which the ratios come to be off.
const SUDDEN_AND_SLOW: [u64; 2] = [1, 2000];
const CUT_MM: f64 = 5.0;

/// A robot whose camera moves after its whiskers were learned. `cut` is the number of rounds after that at which the first
/// whisker is cut.
fn moved(seed: u64, off: f64, over: u64, cut: Option<u64>) -> Rig {
    let mut rig = Rig::new(seed, WHISKERS);
    rig.run(LEARNED);
    rig.run_with(AFTER, |rig| {
        let since = rig.rounds - LEARNED;
        rig.noise.ratio_off = off * ((since + 1) as f64 / over as f64).min(1.0);
        if cut == Some(since) {
            rig.whiskers[0].length_mm -= CUT_MM;
        }
    });
    rig
}

/// Whiskers that were called trimmed, or said to have lost sensitivity, after the camera had moved.
fn called(rig: &Rig) -> Vec<usize> {
    let is_call = |to| matches!(to, Condition::Trimmed | Condition::SensitivityLoss);
    let since = |round: &u64| *round >= LEARNED;
    rig.verdicts()
        .into_iter()
        .filter(|(round, (_, to))| since(round) && is_call(*to))
        .map(|(_, (whisker, _))| whisker)
        .collect()
}

fn holds(rig: &Rig, whisker: usize) -> bool {
    let length = rig.view(whisker).length;
    (length.length.mm() - rig.whiskers[whisker].length_mm).abs() <= 1.96 * length.sd_mm
}

#[test]
fn property_ratios_that_are_off_on_all_whiskers_are_no_cut_and_no_loss() {
    for (off, over) in [0.02, -0.02].into_iter().flat_map(|off| SUDDEN_AND_SLOW.map(|over| (off, over))) {
        let mut outside = 0;
        for seed in 0..8 {
            let rig = moved(9100 + seed, off, over, None);
            let case = format!("{off} over {over}, seed {seed}: {:?}", rig.verdicts());
            assert!(called(&rig).is_empty(), "{case}");
            assert!(!rig.alarms(AlarmKind::ArrayShift).is_empty(), "nobody asks about the camera: {case}");
            outside += (0..WHISKERS).filter(|&whisker| !holds(&rig, whisker)).count();
        }
        assert!(outside <= 3, "{off} over {over}: {outside} of 48 lengths outside their intervals");
    }
}

#[test]
fn property_a_cut_beside_ratios_that_are_off_is_called() {
    for (off, over) in [0.02, -0.02].into_iter().flat_map(|off| SUDDEN_AND_SLOW.map(|over| (off, over))) {
        for (cut, seed) in [300, 2500].into_iter().flat_map(|cut| (0..8).map(move |seed| (cut, seed))) {
            let rig = moved(9100 + seed, off, over, Some(cut));
            assert_eq!(called(&rig), [0], "{off} over {over}, cut after {cut}, seed {seed}: {:?}", rig.verdicts());
        }
    }
}
