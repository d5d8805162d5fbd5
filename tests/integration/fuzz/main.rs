//! What comes from outside, bent in every way: no input may stop the program, or hold it up.
//!
//! The inputs are always the same ones. `PROPTEST_CASES=100000 cargo test -p vibrissa-tests --test fuzz` tries as many
//! new ones.

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

/// The largest input: four times what a message may have.
pub(crate) const INPUT_MAX_BYTES: usize = 1 << 20;
/// The longest that any input may take, in the profile of the tests.
const PATIENCE: Duration = Duration::from_millis(50);

/// So many cases, unless the environment asks for others.
pub(crate) fn cases(cases: u32) -> Config {
    if std::env::var_os("PROPTEST_CASES").is_some() {
        return Config { failure_persistence: None, ..Config::default() };
    }
    Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(2021), ..Config::default() }
}

/// An input that is shown as text and not at length.
#[derive(Clone, PartialEq)]
pub(crate) struct Input(pub(crate) Vec<u8>);

impl fmt::Debug for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (start, more) = (&self.0[..self.0.len().min(1500)], self.0.len().saturating_sub(1500));
        write!(f, "b\"{}\"", start.escape_ascii())?;
        if more > 0 { write!(f, " and {more} bytes more") } else { Ok(()) }
    }
}

/// What the work gives. It must be done in time; a busy machine gets more tries.
pub(crate) fn in_time<T>(mut work: impl FnMut() -> T) -> T {
    let mut least = Duration::MAX;
    for _ in 0..5 {
        let (start, before) = (Instant::now(), processor_time());
        let result = work();
        let took = start.elapsed();
        // What others took from us does not count.
        least = least.min(before.zip(processor_time()).map_or(took, |(before, after)| took.min(after - before)));
        if least <= PATIENCE {
            return result;
        }
    }
    panic!("took {least:?} at best");
}

/// How long this thread has run; none where the system does not tell.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().map(Duration::from_nanos).ok()
}
