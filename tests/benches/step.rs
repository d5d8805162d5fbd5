//! How fast the core takes events in: a contact of a learned, healthy whisker must stay under a microsecond.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use vibrissa_evaluation::crowd::{Buffers, Crowd};

const WHISKERS: u16 = 24;
/// In which offset and noise are learned.
const CONTACTS: u32 = 300;

/// One robot, whose state stays in the processor's caches; and a thousand in turn, whose states do not.
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

criterion_group!(benches, step);
criterion_main!(benches);
