//! Open streams of events and of whole lists: their places, and how often each caller is identified again.

use tokio::time::Duration;

use super::places::{PlaceLimits, Places, TakenPlace};
use super::problem::Problem;

/// Limits of streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamOptions {
    /// Interval at which the caller of an open stream is identified again: a stream outlives its token by at most this.
    pub check_every: Duration,
    /// Maximum numbers of open streams.
    pub limits: PlaceLimits,
}

impl Default for StreamOptions {
    fn default() -> Self {
        let limits = PlaceLimits { total_max: 400, per_fleet_max: 100, per_caller_max: 10 };
        Self { check_every: Duration::from_secs(30), limits }
    }
}

/// Open streams with their limits.
#[derive(Debug, Clone)]
pub struct Streams {
    options: StreamOptions,
    places: Places,
}

impl Streams {
    /// No open streams.
    #[must_use]
    pub fn new(options: StreamOptions) -> Self {
        Self { options, places: Places::new("open streams", options.limits) }
    }

    /// The configured limits.
    #[must_use]
    pub fn options(&self) -> StreamOptions {
        self.options
    }

    /// Number of open streams.
    #[must_use]
    pub fn count(&self) -> usize {
        self.places.count()
    }

    /// Takes a place for one more stream of a caller, about a fleet or several.
    ///
    /// # Errors
    /// The caller, the fleet, or all together have reached the limit.
    pub fn open(&self, actor: &str, fleet: Option<&str>) -> Result<TakenPlace, Problem> {
        self.places.take(actor, fleet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_outlives_its_token_by_at_most_thirty_seconds() {
        assert_eq!(StreamOptions::default().check_every, Duration::from_secs(30));
    }
}
