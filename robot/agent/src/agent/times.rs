//! Times of a driver's lines, and limits on rates.

use super::unit::Pace;
use crate::contract::{Moment, Now};
use crate::driver::words::Origin;

/// Longest time ahead of the system's clock, in microseconds.
const AHEAD_MAX_US: u64 = 1_000_000;
/// Longest time behind it: what a driver sends later than this is of another clock, in microseconds.
const BEHIND_MAX_US: u64 = 86_400_000_000;
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
    pace: Pace,
}

impl Times {
    /// Time of a line by the robot's clock; the error is a text.
    pub(super) fn of(&mut self, origin: &Origin, now: Now) -> Result<u64, String> {
        match (origin.t_us, origin.t_ms) {
            (Some(_), Some(_)) => Err("t_us and t_ms exclude each other".to_owned()),
            (Some(t_us), None) => self.stamped(t_us, now),
            (None, Some(t_ms)) => {
                let problem = self.pace.problem("t_ms", "milliseconds", 1_000, t_ms, now.at);
                problem.map_or(Ok(()), Err)?;
                self.mapped(t_ms, origin.span_us, now).ok_or_else(|| "t_ms is too large".to_owned())
            }
            (None, None) => Ok(now.stamp_us),
        }
    }

    /// A driver knows the system's clock, which may differ from the robot's: the age of the line counts.
    fn stamped(&mut self, t_us: u64, now: Now) -> Result<u64, String> {
        let latest_us = now.system_us.saturating_add(AHEAD_MAX_US);
        let is_near = |t_us: u64| t_us <= latest_us && t_us.saturating_add(BEHIND_MAX_US) >= now.system_us;
        if is_near(t_us) {
            return Ok(now.stamp_of(t_us));
        }
        // The same time in seconds, milliseconds or nanoseconds.
        if [1_000_000, 1_000].iter().any(|&unit| is_near(t_us.saturating_mul(unit))) || is_near(t_us / 1_000) {
            return Err(format!("t_us is {t_us}: is t_us in microseconds?"));
        }
        if let Some(problem) = self.pace.problem("t_us", "microseconds", 1, t_us, now.at) {
            return Err(problem);
        }
        if t_us > latest_us {
            return Err(format!("t_us is {} s ahead of the system's clock", (t_us - now.system_us) / 1_000_000));
        }
        let hours = (now.system_us - t_us) / 3_600_000_000;
        Err(format!("t_us is {hours} hours behind the system's clock: is it the time since the board's start?"))
    }

    fn mapped(&mut self, t_ms: u64, span_us: u64, now: Now) -> Option<u64> {
        let board_us = i64::try_from(t_ms.checked_mul(1000)?.checked_add(span_us)?).ok()?;
        let at_us = i64::try_from(now.at.as_us()).ok()?;
        if t_ms + BACK_MAX_MS < self.newest_ms {
            (self.newest_ms, self.offsets_us) = (0, [None; 2]);
        }
        self.newest_ms = self.newest_ms.max(t_ms);
        if now.at >= self.window + WINDOW_US {
            self.offsets_us = [None, self.offsets_us[0]];
            self.window = now.at;
        }
        let offset_us = at_us.checked_sub(board_us)?;
        let smallest_us = self.offsets_us[0].map_or(offset_us, |least_us| least_us.min(offset_us));
        self.offsets_us[0] = Some(smallest_us);
        let least_us = self.offsets_us[1].map_or(smallest_us, |before_us| before_us.min(smallest_us));
        let age_us = (offset_us - least_us).unsigned_abs();
        Some(now.stamp_us.saturating_sub(age_us).saturating_sub(span_us))
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

    fn origin(t_us: Option<u64>, t_ms: Option<u64>) -> Origin {
        Origin { array: None, whisker: 0, t_us, t_ms, span_us: 0 }
    }

    impl Times {
        fn by_board(&mut self, t_ms: u64, now: Now) -> Result<u64, String> {
            self.of(&origin(None, Some(t_ms)), now)
        }
    }

    const NOW_US: u64 = 1_795_248_000_000_000;

    #[test]
    fn a_boards_clock_is_mapped_by_the_smallest_delay() {
        let mut times = Times::default();
        // The first line is 30 ms late, the second one 5 ms, the third one 50 ms.
        assert_eq!(times.by_board(1_000, at(NOW_US + 1_030_000)), Ok(NOW_US + 1_030_000));
        assert_eq!(times.by_board(2_000, at(NOW_US + 2_005_000)), Ok(NOW_US + 2_005_000));
        assert_eq!(times.by_board(3_000, at(NOW_US + 3_050_000)), Ok(NOW_US + 3_005_000));
        // After a restart of the board its clock begins anew.
        assert_eq!(times.by_board(10, at(NOW_US + 9_000_000)), Ok(NOW_US + 9_000_000));
    }

    #[test]
    fn a_slow_clock_is_followed() {
        let mut times = Times::default();
        let mut mapped = 0;
        for second in 0..600_u64 {
            // 1 ms a second too slow.
            mapped = times.by_board(second * 999, at(NOW_US + second * 1_000_000)).unwrap();
        }
        assert!((NOW_US + 599_000_000).abs_diff(mapped) < 70_000, "{mapped}");
    }

    #[test]
    fn impossible_times_are_refused() {
        let mut times = Times::default();
        assert!(times.of(&origin(Some(NOW_US + 1_000_001), None), at(NOW_US)).is_err());
        assert!(times.of(&origin(Some(1), Some(1)), at(NOW_US)).is_err());
        assert!(times.by_board(u64::MAX, at(NOW_US)).is_err());
        assert_eq!(times.of(&origin(None, None), at(NOW_US)), Ok(NOW_US));
    }

    #[test]
    fn regress_a_time_of_another_unit_or_another_clock_is_refused_with_a_question() {
        for (t_us, question) in [
            (NOW_US / 1_000_000, "is t_us in microseconds?"),
            (NOW_US / 1_000, "is t_us in microseconds?"),
            (NOW_US * 1_000, "is t_us in microseconds?"),
            (5_000_000, "is it the time since the board's start?"),
        ] {
            let problem = Times::default().of(&origin(Some(t_us), None), at(NOW_US)).unwrap_err();
            assert!(problem.contains(question), "{t_us}: {problem}");
        }
        let old_us = NOW_US - BEHIND_MAX_US;
        assert_eq!(Times::default().of(&origin(Some(old_us), None), at(NOW_US)), Ok(old_us), "a day is buffered");
    }

    #[test]
    fn regress_a_line_with_many_values_is_as_late_as_one_with_a_single_value() {
        let mut times = Times::default();
        // Both lines are sent at once; one has samples of the 90 ms before.
        assert_eq!(times.by_board(1_090, at(NOW_US)), Ok(NOW_US));
        let samples = Origin { span_us: 90_000, ..origin(None, Some(1_000)) };
        assert_eq!(times.of(&samples, at(NOW_US)), Ok(NOW_US - 90_000));
    }

    #[test]
    fn a_rate_allows_a_seconds_worth_at_once() {
        let mut rate = Rate::new(10.0, at(NOW_US).at);
        assert_eq!((0..100).filter(|_| rate.takes(at(NOW_US).at)).count(), 10);
        assert!(rate.takes(at(NOW_US + 100_000).at));
        assert!(!rate.takes(at(NOW_US + 100_000).at));
    }
}
