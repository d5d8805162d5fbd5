//! Fuzz tests of all external inputs: no input may crash or delay the program.
//!
//! The inputs are the same in each run. `PROPTEST_CASES=100000 cargo test -p vibrissa-tests --test fuzz` tries that
//! many cases.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod episode;
mod json;
mod mutation;
mod subject;

mod configuration;
mod messages;
mod robots;
mod topics;

use std::fmt;
use std::hash::{DefaultHasher, Hasher};
use std::time::{Duration, Instant};

use proptest::test_runner::{Config, RngSeed};

/// Largest input: four times the size limit of a message.
pub(crate) const INPUT_MAX_BYTES: usize = 1 << 20;
/// Processor time for one input that is always allowed, in the build profile of the tests.
const ALLOWED: Duration = Duration::from_millis(50);
/// Largest processor time for one input on a machine that is slow at the moment, as a multiple of that for 64 hashes of the
/// largest input. A work that grows with the square of its input takes far more.
const HASHES_MAX: u32 = 4;

/// Configuration with this number of cases, unless the environment sets another number.
pub(crate) fn cases(cases: u32) -> Config {
    if std::env::var_os("PROPTEST_CASES").is_some() {
        return Config { failure_persistence: None, ..Config::default() };
    }
    Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(2021), ..Config::default() }
}

/// An input that is printed as text and abbreviated.
#[derive(Clone, PartialEq)]
pub(crate) struct Input(pub(crate) Vec<u8>);

impl fmt::Debug for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (start, more) = (&self.0[..self.0.len().min(1500)], self.0.len().saturating_sub(1500));
        write!(f, "b\"{}\"", start.escape_ascii())?;
        if more > 0 { write!(f, " and {more} bytes more") } else { Ok(()) }
    }
}

/// Result of the closure, which must not take much more processor time than hashes of the largest input; it is tried up to
/// five times.
pub(crate) fn in_time<T>(mut work: impl FnMut() -> T) -> T {
    let mut took = Vec::new();
    for _ in 0..5 {
        let (result, spent) = timed(&mut work);
        if spent <= ALLOWED {
            return result;
        }
        let (_, hashes) = timed(hashes_of_the_largest);
        if spent <= HASHES_MAX * hashes {
            return result;
        }
        took.push((spent, hashes));
    }
    panic!("took this long, and hashes of the largest input that long: {took:?}");
}

fn hashes_of_the_largest() -> u64 {
    let (mut hasher, largest) = (DefaultHasher::new(), vec![7; INPUT_MAX_BYTES]);
    (0..64).for_each(|_| hasher.write(&largest));
    hasher.finish()
}

/// Result of the closure, and its time. Time in which the processor ran other threads is not counted.
fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let (start, before) = (Instant::now(), processor_time());
    let result = work();
    let took = start.elapsed();
    (result, before.zip(processor_time()).map_or(took, |(before, after)| took.min(after.saturating_sub(before))))
}

/// Processor time of this thread. None if the system does not report it.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().map(Duration::from_nanos).ok()
}
