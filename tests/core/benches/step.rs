//! Measures steps of the core. A contact of a healthy whisker with a learned baseline must stay below a microsecond.
//! The step that decides on a setpoint must stay below 0.2 ms, because it delays the setpoint.

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use vibrissa_core_tests::large_array::LargeArray;
use vibrissa_evaluation::crowd::{Buffers, Crowd};

const WHISKERS: u16 = 24;
/// Number of contacts in which a whisker's offset and noise are learned.
const CONTACTS: u32 = 300;

/// One robot, whose state stays in the processor's caches, and a thousand robots in turn, whose states do not.
fn step(c: &mut Criterion) {
    for robots in [1, 1000] {
        let mut crowd = Crowd::new(robots, WHISKERS);
        crowd.learn(CONTACTS, &|| ());
        let mut buffers = Buffers::default();
        let mut turn = (0..robots).cycle();
        let mut robot = move || turn.next().unwrap_or_default();
        let mut group = c.benchmark_group("step");
        for contacts in [1, 20] {
            let name = format!("{contacts} contacts a message, robots");
            group.bench_function(BenchmarkId::new(name, robots), |b| {
                b.iter(|| crowd.contacts(robot(), contacts, &mut buffers));
            });
        }
        group.bench_function(BenchmarkId::new("status of 24 whiskers, robots", robots), |b| {
            b.iter(|| crowd.status(robot(), &mut buffers));
        });
        group.bench_function(BenchmarkId::new("tick of 24 whiskers, robots", robots), |b| {
            b.iter(|| crowd.tick(robot(), &mut buffers));
        });
        group.finish();
    }
}

/// One broken whisker in a row of four; the candidates are the whisker itself and its neighbour.
fn decision(c: &mut Criterion) {
    let array = LargeArray::new(4, 1);
    c.bench_function("a step that decides", |b| {
        b.iter_batched_ref(|| array.clone(), LargeArray::decide, BatchSize::SmallInput);
    });
}

criterion_group!(benches, step, decision);
criterion_main!(benches);
