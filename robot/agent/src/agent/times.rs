//! Times of a driver's lines, and limits on rates.

use crate::contract::{Moment, Now};

/// Longest time ahead of the system's clock, in microseconds.
const AHEAD_MAX_US: u64 = 1_000_000;
/// Age of the smallest delay after which it is measured anew: a board's clock runs slower or faster.
const WINDOW_US: u64 = 30_000_000;
/// A board whose clock goes back by more has restarted.
const BACK_MAX_MS: u64 = 1_000;

/// Maps the clock of a board to the robot's by the smallest delay seen.
#[derive(Debug, Default)]
pub(super) struct Times {
    newest_ms: u64,
    /// Smallest offset of this window and of the one before, in microseconds: agent's moment minus board's time.
    offsets_us: [Option<i64>; 2],
    window: Moment,
}

impl Times {
    /// Time of a line by the robot's clock; the error is a text.
    pub(super) fn of(&mut self, t_us: Option<u64>, t_ms: Option<u64>, now: Now) -> Result<u64, String> {
        match (t_us, t_ms) {
            (Some(_), Some(_)) => Err("t_us and t_ms exclude each other".to_owned()),
            (Some(t_us), None) if t_us > now.system_us.saturating_add(AHEAD_MAX_US) => {
                Err(format!("t_us is {} s ahead of the system's clock", (t_us - now.system_us) / 1_000_000))
            }
            // A driver knows the system's clock, which may differ from the robot's: the age of the line counts.
            (Some(t_us), None) => Ok(now.stamp_of(t_us)),
            (None, Some(t_ms)) => self.mapped(t_ms, now).ok_or_else(|| "t_ms is too large".to_owned()),
            (None, None) => Ok(now.stamp_us),
        }
    }

    fn mapped(&mut self, t_ms: u64, now: Now) -> Option<u64> {
        let board_us = i64::try_from(t_ms.checked_mul(1000)?).ok()?;
        let at_us = i64::try_from(now.at.as_us()).ok()?;
        if t_ms + BACK_MAX_MS < self.newest_ms {
            *self = Self::default();
        }
        self.newest_ms = self.newest_ms.max(t_ms);
        if now.at >= self.window + WINDOW_US {
            self.offsets_us = [None, self.offsets_us[0]];
            self.window = now.at;
        }
        let offset_us = at_us - board_us;
        let smallest_us = self.offsets_us[0].map_or(offset_us, |least_us| least_us.min(offset_us));
        self.offsets_us[0] = Some(smallest_us);
        let least_us = self.offsets_us[1].map_or(smallest_us, |before_us| before_us.min(smallest_us));
        let age_us = (offset_us - least_us).unsigned_abs();
        Some(now.stamp_us.saturating_sub(age_us))
    }
}

/// A limit on a rate, which allows one second's worth at once.
#[derive(Debug)]
pub(super) struct Rate {
    per_s: f64,
    free: f64,
    at: Moment,
}

impl Rate {
    pub(super) fn new(per_s: f64, now: Moment) -> Self {
        Self { per_s, free: per_s, at: now }
    }

    /// Whether one more is allowed now.
    pub(super) fn takes(&mut self, now: Moment) -> bool {
        let passed_s = now.since(self.at) as f64 / 1e6;
        self.at = now;
        self.free = (self.free + passed_s * self.per_s).min(self.per_s.max(1.0));
        let is_allowed = self.free >= 1.0;
        if is_allowed {
            self.free -= 1.0;
        }
        is_allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(us: u64) -> Now {
        Now::of_us(us)
    }

    const NOW_US: u64 = 1_795_248_000_000_000;

    #[test]
    fn a_boards_clock_is_mapped_by_the_smallest_delay() {
        let mut times = Times::default();
        // The first line is 30 ms late, the second one 5 ms, the third one 50 ms.
        assert_eq!(times.of(None, Some(1_000), at(NOW_US + 1_030_000)), Ok(NOW_US + 1_030_000));
        assert_eq!(times.of(None, Some(2_000), at(NOW_US + 2_005_000)), Ok(NOW_US + 2_005_000));
        assert_eq!(times.of(None, Some(3_000), at(NOW_US + 3_050_000)), Ok(NOW_US + 3_005_000));
        // After a restart of the board its clock begins anew.
        assert_eq!(times.of(None, Some(10), at(NOW_US + 9_000_000)), Ok(NOW_US + 9_000_000));
    }

    #[test]
    fn a_slow_clock_is_followed() {
        let mut times = Times::default();
        let mut mapped = 0;
        for second in 0..600_u64 {
            // 1 ms a second too slow.
            mapped = times.of(None, Some(second * 999), at(NOW_US + second * 1_000_000)).unwrap();
        }
        assert!((NOW_US + 599_000_000).abs_diff(mapped) < 70_000, "{mapped}");
    }

    #[test]
    fn impossible_times_are_refused() {
        let mut times = Times::default();
        assert!(times.of(Some(NOW_US + 1_000_001), None, at(NOW_US)).is_err());
        assert!(times.of(Some(1), Some(1), at(NOW_US)).is_err());
        assert!(times.of(None, Some(u64::MAX), at(NOW_US)).is_err());
        assert_eq!(times.of(None, None, at(NOW_US)), Ok(NOW_US));
    }

    #[test]
    fn a_rate_allows_a_seconds_worth_at_once() {
        let mut rate = Rate::new(10.0, at(NOW_US).at);
        assert_eq!((0..100).filter(|_| rate.takes(at(NOW_US).at)).count(), 10);
        assert!(rate.takes(at(NOW_US + 100_000).at));
        assert!(!rate.takes(at(NOW_US + 100_000).at));
    }
}
