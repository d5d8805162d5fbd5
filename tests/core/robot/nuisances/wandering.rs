//! A gain that wanders slowly is followed; a cut is called beside it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::rig::Rig;

/// Random walk of the gain per square root of a contact, log sensitivity: 3 % in 5,000 contacts.
const WALK: f64 = 0.03 / 70.7;
const SEEDS: u64 = 12;

fn run(rig: &mut Rig, random: &mut ChaCha8Rng, contacts: u64) {
    rig.run_with(contacts, |rig| {
        let step: f64 = StandardNormal.sample(random);
        rig.whiskers[0].gain *= (WALK * step).exp();
    });
}

/// Without the walks of the gain, three trims come in these 120,000 contacts.
#[test]
fn property_a_wandering_gain_is_no_trim_and_hides_no_cut() {
    let mut false_trims = 0;
    for seed in 0..SEEDS {
        let mut random = ChaCha8Rng::seed_from_u64(9500 + seed);
        let mut rig = Rig::new(9600 + seed, 1);
        run(&mut rig, &mut random, 10_000);
        false_trims += rig.trims().len();
        let (before, since) = (rig.trims().len(), rig.rounds);
        rig.whiskers[0].length_mm -= 6.0;
        run(&mut rig, &mut random, 60);
        let trims = rig.trims();
        assert_eq!(trims.len(), before + 1, "seed {seed}: {trims:?}");
        assert!(trims[before].0 - since <= 60, "seed {seed}");
    }
    assert!(false_trims <= 1, "{false_trims}");
}
