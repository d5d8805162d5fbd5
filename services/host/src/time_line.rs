//! The time line of a process.

use std::sync::atomic::{AtomicI64, Ordering};

use tokio::time::Instant;

/// A time line that runs evenly.
#[derive(Debug)]
pub struct TimeLine {
    began: Instant,
    /// Time in µs since 1970 UTC at which it began.
    at_us: AtomicI64,
}

impl TimeLine {
    /// A line that begins now, at this time in µs since 1970 UTC.
    #[must_use]
    pub fn from(at_us: i64) -> Self {
        Self { began: Instant::now(), at_us: AtomicI64::new(at_us) }
    }

    pub(crate) fn now_us(&self) -> i64 {
        let since_us = i64::try_from(self.began.elapsed().as_micros()).unwrap_or(i64::MAX);
        self.at_us.load(Ordering::Relaxed).saturating_add(since_us)
    }

    pub(crate) fn step(&self, by_us: i64) {
        self.at_us.fetch_add(by_us, Ordering::Relaxed);
    }
}
