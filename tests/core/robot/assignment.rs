//! The assignment against all assignments.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::policy::{Offer, assign};

/// Best (served, cost) over every way to give the targets from `target` on a free compensator or none.
fn best(target: usize, targets: usize, taken: u32, offers: &[Offer]) -> (usize, f64) {
    if target == targets {
        return (0, 0.0);
    }
    let mut found = best(target + 1, targets, taken, offers);
    for offer in offers.iter().filter(|offer| offer.target == target && taken & (1 << offer.compensator) == 0) {
        let (served, cost) = best(target + 1, targets, taken | 1 << offer.compensator, offers);
        let with = (served + 1, cost + offer.cost);
        if with.0 > found.0 || (with.0 == found.0 && with.1 < found.1) {
            found = with;
        }
    }
    found
}

#[test]
fn brute_force_the_assignment_serves_the_most_at_the_least_cost() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..3000 {
        let (targets, compensators) = (random.random_range(1..=4), random.random_range(1..=6));
        let mut offers = Vec::new();
        for target in 0..targets {
            for compensator in 0..compensators {
                if random.random_bool(0.5) {
                    offers.push(Offer { target, compensator, cost: random.random_range(0.0..12.0) });
                }
            }
        }
        let chosen = assign(targets, compensators, &offers);
        let mut served = 0;
        let mut cost = 0.0;
        let mut taken = 0_u32;
        for (target, compensator) in chosen.iter().enumerate().filter_map(|(target, one)| Some((target, (*one)?))) {
            let offer = offers.iter().find(|one| (one.target, one.compensator) == (target, compensator));
            cost += offer.expect("only what was offered is chosen").cost;
            assert_eq!(taken & (1 << compensator), 0, "nobody serves twice");
            taken |= 1 << compensator;
            served += 1;
        }
        let (most, least) = best(0, targets, 0, &offers);
        assert_eq!(served, most, "{offers:?} -> {chosen:?}");
        // Costs are compared in millionths.
        assert!((cost - least).abs() < 1e-5, "{cost} against {least}: {offers:?} -> {chosen:?}");
    }
}

#[test]
fn without_targets_there_is_nothing_to_assign() {
    assert_eq!(assign(0, 3, &[]), []);
    assert_eq!(assign(2, 0, &[]), [None, None]);
}
