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
use std::time::{Duration, Instant};

use proptest::test_runner::{Config, RngSeed};

/// Largest input: four times the size limit of a message.
pub(crate) const INPUT_MAX_BYTES: usize = 1 << 20;
/// Longest time for one input, in the build profile of the tests.
const PATIENCE: Duration = Duration::from_millis(50);

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

/// Result of the closure, which must finish within [`PATIENCE`]; on a busy machine it is tried up to five times.
pub(crate) fn in_time<T>(mut work: impl FnMut() -> T) -> T {
    let mut least = Duration::MAX;
    for _ in 0..5 {
        let (start, before) = (Instant::now(), processor_time());
        let result = work();
        let took = start.elapsed();
        // Time in which the processor ran other threads is not counted.
        least = least.min(before.zip(processor_time()).map_or(took, |(before, after)| took.min(after - before)));
        if least <= PATIENCE {
            return result;
        }
    }
    panic!("took {least:?} at best");
}

/// Processor time of this thread. None if the system does not report it.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().map(Duration::from_nanos).ok()
}
