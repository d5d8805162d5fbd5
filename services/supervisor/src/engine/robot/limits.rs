//! Rate limits that keep a robot, or a client that invents names, from filling the database.

use std::time::Duration;

use tokio::time::Instant;

/// Number of new boots, and of new layouts, that a robot may have at once.
pub(crate) const BOOTS_AT_ONCE: u32 = 10;
/// Rate of new boots, and of new layouts, of a robot after that, per minute.
pub(crate) const BOOTS_PER_MINUTE: u32 = 1;

/// Limits on the robots that the supervisor stores, and on the messages about them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Largest number of robots in a fleet.
    pub robots_per_fleet: u32,
    /// Largest number of new robots of a fleet per minute; also the number accepted at once after a minute without any.
    pub new_robots_per_minute: u32,
    /// Shortest time between two messages with facts for the maintenance of a robot; `None` for no such messages.
    pub maintenance_every: Option<Duration>,
}

impl Default for Limits {
    fn default() -> Self {
        Self { robots_per_fleet: 10_000, new_robots_per_minute: 3_000, maintenance_every: None }
    }
}

/// A token bucket: a number of tokens at once, then a rate per minute.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bucket {
    at_once: u32,
    per_minute: u32,
    /// Tokens left, as the time that it takes to refill them. `None` before the first use, when the bucket is full.
    left: Option<(Duration, Instant)>,
}

impl Bucket {
    pub(crate) const fn new(at_once: u32, per_minute: u32) -> Self {
        Self { at_once, per_minute, left: None }
    }

    /// Takes a token; false if there is none.
    pub(crate) fn take(&mut self, now: Instant) -> bool {
        let each = Duration::from_secs(60) / self.per_minute.max(1);
        let full = each * self.at_once;
        let left = match self.left {
            None => full,
            Some((left, since)) => (left + now.saturating_duration_since(since)).min(full),
        };
        let rest = left.checked_sub(each);
        self.left = Some((rest.unwrap_or(left), now));
        rest.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    #[test]
    fn a_bucket_gives_some_at_once_and_then_one_after_the_other() {
        let begin = Instant::now();
        let mut bucket = Bucket::new(10, 1);
        let taken = |bucket: &mut Bucket, at: Duration| (0..100).filter(|_| bucket.take(begin + at)).count();
        assert_eq!(taken(&mut bucket, Duration::ZERO), 10);
        assert_eq!(taken(&mut bucket, 59 * S), 0);
        assert_eq!(taken(&mut bucket, 60 * S), 1);
        assert_eq!(taken(&mut bucket, 240 * S), 3);
        assert_eq!(taken(&mut bucket, 86_400 * S), 10, "a full bucket holds no more");
    }

    #[test]
    fn property_a_bucket_never_gives_more_than_its_rate() {
        let begin = Instant::now();
        for (at_once, per_minute) in [(1, 1), (10, 1), (3_000, 3_000), (5, 60_000)] {
            let mut bucket = Bucket::new(at_once, per_minute);
            let mut given = 0;
            for ms in (0..300_000).step_by(7) {
                given += u64::from(bucket.take(begin + Duration::from_millis(ms)));
                assert!(given <= u64::from(at_once) + 1 + ms * u64::from(per_minute) / 60_000, "{given} in {ms} ms");
            }
        }
    }
}
