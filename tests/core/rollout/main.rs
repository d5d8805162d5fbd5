//! Staged roll-outs: the rank test against brute force, its false alarms, its power, and the choice of robots.

use proptest::prelude::*;
use rand::seq::SliceRandom as _;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp1, StandardNormal};
use vibrissa_core::rollout::rank::{EXACT_MAX, greater};
use vibrissa_core::rollout::{LOOKS_PER_STAGE, Rules, Stage, TRIAL_STAGES, Verdict, limit, place, review};

/// Counts all assignments of the values to the first group one by one, with ranks as means over ties.
fn by_hand(first: &[f64], second: &[f64]) -> f64 {
    let values: Vec<f64> = first.iter().chain(second).copied().collect();
    let rank = |value: f64| {
        let below = values.iter().filter(|other| **other < value).count() as f64;
        let same = values.iter().filter(|other| **other == value).count() as f64;
        below + (same + 1.0) / 2.0
    };
    let ranks: Vec<f64> = values.iter().map(|&value| rank(value)).collect();
    let observed: f64 = ranks[..first.len()].iter().sum();
    let (mut all, mut extreme) = (0.0, 0.0);
    for choice in 0_u32..1 << values.len() {
        if choice.count_ones() as usize == first.len() {
            let sum: f64 = ranks.iter().enumerate().filter(|(at, _)| choice >> at & 1 == 1).map(|(_, rank)| rank).sum();
            all += 1.0;
            extreme += f64::from(u8::from(sum >= observed - 1e-9));
        }
    }
    extreme / all
}

proptest! {
    /// Values on a coarse grid, so that there are ties.
    #[test]
    fn brute_force_the_probability_is_the_share_of_assignments_that_are_as_extreme(
        first in prop::collection::vec(0_u8..6, 1..7),
        second in prop::collection::vec(0_u8..6, 1..7),
    ) {
        let [first, second] = [first, second].map(|group| group.into_iter().map(f64::from).collect::<Vec<_>>());
        prop_assert!((greater(&first, &second) - by_hand(&first, &second)).abs() < 1e-12);
    }

    /// Only the order of the values counts, and greater values of the first group never raise the probability.
    #[test]
    fn property_it_depends_on_ranks_alone_and_falls_with_greater_values(
        first in prop::collection::vec(-3.0_f64..3.0, 1..40),
        second in prop::collection::vec(-3.0_f64..3.0, 1..80),
    ) {
        let probability = greater(&first, &second);
        prop_assert!((0.0..=1.0).contains(&probability));
        let changed = |group: &[f64]| group.iter().map(|value| value.exp()).collect::<Vec<_>>();
        prop_assert!((greater(&changed(&first), &changed(&second)) - probability).abs() < 1e-9);
        let more: Vec<f64> = first.iter().map(|value| value + 0.5).collect();
        prop_assert!(greater(&more, &second) <= probability + 1e-12);
    }
}

/// Published critical values of Mann and Whitney's table for one-sided 5 %: with U = n1 n2 - limit the probability is at most
/// 0.05, and with one less it is above. Sizes and limits as in common tables (5 and 5: 4; 8 and 8: 15; 10 and 10: 27).
#[test]
fn golden_critical_values_of_published_tables() {
    for (size, limit) in [(5_usize, 4_usize), (8, 15), (10, 27)] {
        for (u, is_significant) in [(limit, true), (limit + 1, false)] {
            // The first group lies above the second, except for u pairs.
            let mut first: Vec<f64> = (0..size).map(|at| 1000.0 + at as f64).collect();
            let second: Vec<f64> = (0..size).map(|at| 10.0 * (at + 1) as f64).collect();
            let (whole, rest) = (u / size, u % size);
            for value in first.iter_mut().take(whole) {
                *value = 1.0;
            }
            if rest > 0 {
                // Below the greatest `rest` values of the second group.
                first[whole] = 10.0 * (size - rest) as f64 + 5.0;
            }
            let probability = greater(&first, &second);
            assert_eq!(probability <= 0.05, is_significant, "{size} and {size}, U = {u}: {probability}");
        }
    }
}

/// Truth: the share of random assignments that are as extreme.
#[test]
fn brute_force_the_approximation_agrees_with_random_assignments() {
    const DRAWS: u32 = 20_000;
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for (count, others, shift) in [(5, 60, 1.0), (12, 48, 0.5), (20, 60, 0.7), (20, 380, 0.6), (5, 95, 1.5)] {
        let first: Vec<f64> = (0..count).map(|_| random.sample::<f64, _>(StandardNormal) + shift).collect();
        let second: Vec<f64> = (0..others).map(|_| random.sample(StandardNormal)).collect();
        assert!(count + others > EXACT_MAX);
        let mut values: Vec<f64> = first.iter().chain(&second).copied().collect();
        values.sort_by(f64::total_cmp);
        let rank = |value: &f64| values.partition_point(|other| other < value) + 1;
        let observed: usize = first.iter().map(rank).sum();
        let mut ranks: Vec<usize> = (1..=values.len()).collect();
        let mut extreme = 0;
        for _ in 0..DRAWS {
            let (chosen, _) = ranks.partial_shuffle(&mut random, count);
            extreme += u32::from(chosen.iter().sum::<usize>() >= observed);
        }
        let (truth, ours) = (f64::from(extreme) / f64::from(DRAWS), greater(&first, &second));
        let noise = 4.0 * (truth.max(1e-3) / f64::from(DRAWS)).sqrt();
        assert!((truth - ours).abs() <= 0.002 + noise, "{count} of {others}: {ours}, by draws {truth}");
    }
}

/// Errors of robots whose spread is that of measured compensation errors: a skewed distribution.
fn errors(random: &mut ChaCha8Rng, robots: usize, factor: f64) -> Vec<f64> {
    let one = |random: &mut ChaCha8Rng| {
        let draw: f64 = Exp1.sample(random);
        factor * (0.02 + 0.08 * draw)
    };
    (0..robots).map(|_| one(random)).collect()
}

/// Plays a roll-out: robots are measured one after another, in the given share changed, and each look sees all so far.
/// Returns whether it was rolled back.
fn is_rolled_back(random: &mut ChaCha8Rng, rules: Rules, factor: f64) -> bool {
    for stage in [Stage::Few, Stage::Quarter] {
        let (mut looks, mut changed, mut unchanged) = (0, Vec::new(), Vec::new());
        loop {
            if random.random_bool(stage.share()) {
                changed.extend(errors(random, 1, factor));
            } else {
                unchanged.extend(errors(random, 1, 1.0));
            }
            match review(rules, looks, &changed, &unchanged) {
                Verdict::Wait => {}
                Verdict::Continue(look) => looks = look.looks,
                Verdict::Advance(_) => break,
                Verdict::RollBack(_) => return true,
            }
        }
    }
    false
}

fn share_rolled_back(rules: Rules, factor: f64, plays: u32) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let count = (0..plays).filter(|_| is_rolled_back(&mut random, rules, factor)).count();
    count as f64 / f64::from(plays)
}

/// The bound is the level; the binomial noise of 4000 plays is 0.0034 at 5 %.
#[test]
fn property_a_change_without_an_effect_is_rolled_back_at_most_at_the_level() {
    for (level, robots) in [(0.05, 20), (0.05, 8), (0.2, 20)] {
        let share = share_rolled_back(Rules { level, robots }, 1.0, 4000);
        println!("rolled back without an effect: {share} at level {level} with {robots} robots");
        assert!(share <= level + 3.0 * (level / 4000.0_f64).sqrt(), "{level} {robots}: {share}");
        assert!(share > 0.1 * level, "{level} {robots}: {share}: the test would never speak");
    }
}

#[test]
fn property_a_worse_change_is_rolled_back() {
    let rules = Rules { level: 0.05, robots: 20 };
    let (double, triple) = (share_rolled_back(rules, 2.0, 500), share_rolled_back(rules, 3.0, 500));
    println!("rolled back: {double} of changes that double the errors, {triple} of those that triple them");
    assert!(double > 0.8 && triple > 0.99, "{double} {triple}");
    // A better change is never held up by chance alone.
    assert!(share_rolled_back(rules, 0.7, 500) < 0.01);
}

#[test]
fn looks_are_at_fixed_numbers_of_robots_and_share_the_level() {
    let rules = Rules { level: 0.06, robots: 20 };
    assert!((rules.threshold() - 0.01).abs() < 1e-12);
    assert_eq!((0..LOOKS_PER_STAGE).map(|look| rules.due_at(look)).collect::<Vec<_>>(), [5, 10, 20]);
    assert_eq!(TRIAL_STAGES * LOOKS_PER_STAGE, 6);
    let same = |count: usize| (0..count).map(|at| at as f64).collect::<Vec<_>>();
    assert_eq!(review(rules, 0, &same(4), &same(100)), Verdict::Wait);
    assert_eq!(review(rules, 0, &same(100), &same(4)), Verdict::Wait, "there must be something to compare with");
    assert!(matches!(review(rules, 0, &same(5), &same(5)), Verdict::Continue(look) if look.looks == 1));
    assert_eq!(review(rules, 1, &same(9), &same(100)), Verdict::Wait);
    assert!(matches!(review(rules, 0, &same(12), &same(12)), Verdict::Continue(look) if look.looks == 2));
    assert!(matches!(review(rules, 0, &same(20), &same(20)), Verdict::Advance(look) if look.looks == 3));
    let high: Vec<f64> = (0..5).map(|at| 1000.0 + f64::from(at)).collect();
    assert!(matches!(review(rules, 0, &high, &same(20)), Verdict::RollBack(look) if look.probability < 0.001));
}

#[test]
fn the_choice_of_robots_is_stable_even_and_grows() {
    let names: Vec<String> = (0..1000).map(|number| format!("robot-{number:04}")).collect();
    let places = |seed: u64| names.iter().map(|name| place(seed, name)).collect::<Vec<_>>();
    let (one, other) = (places(1), places(2));
    assert_eq!(one, places(1));
    let few = limit(Stage::Few, &mut one.clone(), 0);
    let quarter = limit(Stage::Quarter, &mut one.clone(), few);
    let chosen = |places: &[u32], limit: u32| places.iter().filter(|&&place| place <= limit).count();
    assert_eq!((chosen(&one, few), chosen(&one, quarter), chosen(&one, u32::MAX)), (50, 250, 1000));
    // Every robot of the first stage is in the second.
    assert!(one.iter().all(|&place| place > few || place <= quarter));
    // Another roll-out chooses others: 2 or 3 of 50 in common by chance.
    let common = one
        .iter()
        .zip(&other)
        .filter(|(one, other)| **one <= few && **other <= limit(Stage::Few, &mut places(2), 0))
        .count();
    assert!(common < 12, "{common}");
    // Of few robots at least one is chosen, and none of a fleet without robots.
    assert_eq!(chosen(&one[..3], limit(Stage::Few, &mut one[..3].to_vec(), 0)), 1);
    assert!((f64::from(limit(Stage::Few, &mut [], 0)) / f64::from(u32::MAX) - 0.05).abs() < 1e-6);
    // Places are spread evenly: the fraction below each tenth.
    for tenth in 1..10_u32 {
        let below = chosen(&one, u32::MAX / 10 * tenth) as f64 / 1000.0;
        assert!((below - f64::from(tenth) / 10.0).abs() < 0.05, "{tenth}: {below}");
    }
}
