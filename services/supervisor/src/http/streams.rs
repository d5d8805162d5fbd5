//! Open streams of events and of whole lists: limits in total and per caller, and how often each caller is identified again.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::time::Duration;

use super::problem::{Kind, Problem};

/// Limits of streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamOptions {
    /// Interval at which the caller of an open stream is identified again: a stream outlives its token by at most this.
    pub check_every: Duration,
    /// Maximum number of open streams.
    pub total_max: usize,
    /// Maximum number of open streams per caller.
    pub per_caller_max: usize,
}

impl Default for StreamOptions {
    fn default() -> Self {
        Self { check_every: Duration::from_secs(30), total_max: 100, per_caller_max: 10 }
    }
}

/// Open streams, counted per caller.
#[derive(Debug, Clone)]
pub struct Streams {
    options: StreamOptions,
    open: Arc<Mutex<BTreeMap<String, usize>>>,
}

/// Place of an open stream; dropping it frees the place.
#[derive(Debug)]
pub struct Place {
    actor: String,
    open: Arc<Mutex<BTreeMap<String, usize>>>,
}

impl Streams {
    /// A counter without open streams.
    #[must_use]
    pub fn new(options: StreamOptions) -> Self {
        Self { options, open: Arc::default() }
    }

    /// The configured limits.
    #[must_use]
    pub fn options(&self) -> StreamOptions {
        self.options
    }

    /// Number of open streams.
    #[must_use]
    pub fn count(&self) -> usize {
        lock(&self.open).values().sum()
    }

    /// Reserves a place for one more stream of a caller.
    ///
    /// # Errors
    /// The caller, or all callers together, have reached the limit.
    pub fn open(&self, actor: &str) -> Result<Place, Problem> {
        let StreamOptions { total_max, per_caller_max, .. } = self.options;
        let mut open = lock(&self.open);
        let refused = |what: String| Err(Problem::new(Kind::TooManyRequests, what));
        if open.get(actor).is_some_and(|&count| count >= per_caller_max) {
            return refused(format!(
                "{actor} has {per_caller_max} open streams, the limit per caller: close one, or read pages"
            ));
        }
        if open.values().sum::<usize>() >= total_max {
            return refused(format!(
                "{total_max} streams are open, the limit of this service: try again later, or read pages"
            ));
        }
        *open.entry(actor.to_owned()).or_default() += 1;
        Ok(Place { actor: actor.to_owned(), open: self.open.clone() })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut open = lock(&self.open);
        if let Some(count) = open.get_mut(&self.actor) {
            *count -= 1;
            if *count == 0 {
                open.remove(&self.actor);
            }
        }
    }
}

/// The counts are consistent even if a holder of the lock panicked.
fn lock(open: &Mutex<BTreeMap<String, usize>>) -> MutexGuard<'_, BTreeMap<String, usize>> {
    open.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_caller_has_its_share_and_all_together_the_total() {
        let streams = Streams::new(StreamOptions { total_max: 3, per_caller_max: 2, ..StreamOptions::default() });
        let first = streams.open("a").unwrap();
        let _second = streams.open("a").unwrap();
        let third = streams.open("a").unwrap_err();
        assert!(third.kind == Kind::TooManyRequests && third.detail.contains("a has 2"), "{third:?}");
        let others = streams.open("b").unwrap();
        assert!(streams.open("c").unwrap_err().detail.contains("3 streams"));
        assert_eq!(streams.count(), 3);
        drop(others);
        drop(first);
        let _again = streams.open("a").unwrap();
        assert_eq!(streams.count(), 2);
    }

    #[test]
    fn a_stream_outlives_its_token_by_at_most_thirty_seconds() {
        assert_eq!(StreamOptions::default().check_every, Duration::from_secs(30));
    }
}
