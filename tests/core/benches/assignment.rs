//! Measures one complete decision: 100 broken whiskers in an array of 1,000, nine candidates each, with the predictions
//! of the mechanics, the assignment and the setpoints. It must stay below 50 ms.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use vibrissa_core::policy::{Offer, assign};
use vibrissa_core::robot::effect::Effect;
use vibrissa_core_tests::large_array::LargeArray;

const LIMIT: Duration = Duration::from_millis(50);

fn decision(c: &mut Criterion) {
    let array = LargeArray::new(1_000, 100);
    let again = || array.clone();
    let best = (0..10).map(|_| {
        let mut array = again();
        let begun = Instant::now();
        let effects = array.decide();
        let took = begun.elapsed();
        let commands = effects.iter().filter(|effect| matches!(effect, Effect::Command(_))).count();
        assert_eq!(commands, 100, "every broken whisker must be compensated");
        took
    });
    let best = best.min().unwrap_or_default();
    assert!(best < LIMIT, "a decision took {best:?}");
    c.bench_function("decision over 100 broken of 1,000 whiskers", |b| {
        b.iter_batched(again, |mut array| black_box(array.decide()), BatchSize::LargeInput);
    });
}

fn assignment_alone(c: &mut Criterion) {
    // Each target has nine candidates, some of which are candidates of other targets, too.
    let offers: Vec<Offer> = (0..100)
        .flat_map(|target| (0..9).map(move |k| (target, (target * 8 + k * 3) % 800)))
        .enumerate()
        .map(|(at, (target, compensator))| Offer { target, compensator, cost: (at * 7919 % 1000) as f64 / 1e3 })
        .collect();
    c.bench_function("assignment of 100 targets to 800 compensators", |b| {
        b.iter(|| assign(100, 800, black_box(&offers)));
    });
}

criterion_group!(benches, decision, assignment_alone);
criterion_main!(benches);
