//! Times of a driver's lines, and limits on rates.

/// Longest time ahead of the agent's clock, in microseconds.
const AHEAD_MAX_US: u64 = 1_000_000;
/// Age of the smallest delay after which it is measured anew: a board's clock runs slower or faster.
const WINDOW_US: u64 = 30_000_000;
/// A board whose clock goes back by more has restarted.
const BACK_MAX_MS: u64 = 1_000;

/// Maps the clock of a board to the agent's by the smallest delay seen.
#[derive(Debug, Default)]
pub(super) struct Times {
    newest_ms: u64,
    /// Smallest offset of this window and of the one before, in microseconds: agent's time minus board's time.
    offsets_us: [Option<u64>; 2],
    window_us: u64,
}

impl Times {
    /// Time of a line; the error is a text.
    pub(super) fn of(&mut self, t_us: Option<u64>, t_ms: Option<u64>, now_us: u64) -> Result<u64, String> {
        match (t_us, t_ms) {
            (Some(_), Some(_)) => Err("t_us and t_ms exclude each other".to_owned()),
            (Some(t_us), None) if t_us > now_us + AHEAD_MAX_US => {
                Err(format!("t_us is {} s ahead of the agent's clock", (t_us - now_us) / 1_000_000))
            }
            (Some(t_us), None) => Ok(t_us),
            (None, Some(t_ms)) => self.mapped(t_ms, now_us).ok_or_else(|| "t_ms is too large".to_owned()),
            (None, None) => Ok(now_us),
        }
    }

    fn mapped(&mut self, t_ms: u64, now_us: u64) -> Option<u64> {
        let board_us = t_ms.checked_mul(1000).filter(|&board_us| board_us <= now_us)?;
        if t_ms + BACK_MAX_MS < self.newest_ms {
            *self = Self::default();
        }
        self.newest_ms = self.newest_ms.max(t_ms);
        if now_us >= self.window_us + WINDOW_US {
            self.offsets_us = [None, self.offsets_us[0]];
            self.window_us = now_us;
        }
        let offset_us = now_us - board_us;
        let smallest_us = self.offsets_us[0].map_or(offset_us, |least_us| least_us.min(offset_us));
        self.offsets_us[0] = Some(smallest_us);
        let offset_us = self.offsets_us[1].map_or(smallest_us, |before_us| before_us.min(smallest_us));
        Some(board_us + offset_us)
    }
}

/// A limit on a rate, which allows one second's worth at once.
#[derive(Debug)]
pub(super) struct Rate {
    per_s: f64,
    free: f64,
    at_us: u64,
}

impl Rate {
    pub(super) fn new(per_s: f64, now_us: u64) -> Self {
        Self { per_s, free: per_s, at_us: now_us }
    }

    /// Whether one more is allowed now.
    pub(super) fn takes(&mut self, now_us: u64) -> bool {
        let passed_s = now_us.saturating_sub(self.at_us) as f64 / 1e6;
        self.at_us = now_us;
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

    const NOW: u64 = 1_795_248_000_000_000;

    #[test]
    fn a_boards_clock_is_mapped_by_the_smallest_delay() {
        let mut times = Times::default();
        // The first line is 30 ms late, the second one 5 ms, the third one 50 ms.
        assert_eq!(times.of(None, Some(1_000), NOW + 1_030_000), Ok(NOW + 1_030_000));
        assert_eq!(times.of(None, Some(2_000), NOW + 2_005_000), Ok(NOW + 2_005_000));
        assert_eq!(times.of(None, Some(3_000), NOW + 3_050_000), Ok(NOW + 3_005_000));
        // After a restart of the board its clock begins anew.
        assert_eq!(times.of(None, Some(10), NOW + 9_000_000), Ok(NOW + 9_000_000));
    }

    #[test]
    fn a_slow_clock_is_followed() {
        let mut times = Times::default();
        let mut mapped = 0;
        for second in 0..600_u64 {
            // 1 ms a second too slow.
            mapped = times.of(None, Some(second * 999), NOW + second * 1_000_000).unwrap();
        }
        assert!((NOW + 599_000_000).abs_diff(mapped) < 70_000, "{mapped}");
    }

    #[test]
    fn impossible_times_are_refused() {
        let mut times = Times::default();
        assert!(times.of(Some(NOW + 1_000_001), None, NOW).is_err());
        assert!(times.of(Some(1), Some(1), NOW).is_err());
        assert!(times.of(None, Some(u64::MAX), NOW).is_err());
        assert_eq!(times.of(None, None, NOW), Ok(NOW));
    }

    #[test]
    fn a_rate_allows_a_seconds_worth_at_once() {
        let mut rate = Rate::new(10.0, NOW);
        assert_eq!((0..100).filter(|_| rate.takes(NOW)).count(), 10);
        assert!(rate.takes(NOW + 100_000));
        assert!(!rate.takes(NOW + 100_000));
    }
}
