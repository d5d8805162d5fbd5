//! The time by which old rows are deleted. Nothing brings them back, so it is that of the clock that is furthest behind.
//!
//! A host may start with a clock that is months ahead. By it all rows are old, and nobody has contradicted it yet. So
//! nothing is deleted until the other clocks had time to be heard.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use super::judge::{NEAR_US, Readings, Source};

/// Time for which the other clocks are heard before anything is deleted, from the start of the time line or its last step on.
const HEARING: Duration = Duration::from_secs(600);
/// The same if no other clock confirms this supervisor's, or its robots are behind: time for NTP, or for people.
const ALONE: Duration = Duration::from_secs(4 * 3600);

/// How far the deletion of old rows is held back. Clones share their content.
#[derive(Debug, Clone, Default)]
pub(crate) struct HoldBack(Arc<Mutex<Held>>);

#[derive(Debug)]
struct Held {
    since: Instant,
    behind_us: i64,
    is_confirmed: bool,
}

impl Default for Held {
    fn default() -> Self {
        Self { since: Instant::now(), behind_us: 0, is_confirmed: false }
    }
}

impl Held {
    fn old_by_us(&self, at: Instant, now_us: i64) -> i64 {
        let hearing = if self.is_confirmed { HEARING } else { ALONE };
        let is_over = at.saturating_duration_since(self.since) >= hearing;
        if is_over { now_us.saturating_sub(self.behind_us) } else { 0 }
    }
}

impl HoldBack {
    fn held(&self) -> MutexGuard<'_, Held> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The time by which rows are old if this supervisor's time is `now_us`. At 1970 nothing is.
    pub(crate) fn old_by_us(&self, now_us: i64) -> i64 {
        self.held().old_by_us(Instant::now(), now_us)
    }

    /// Takes the readings of all clocks in, and how far the robots are ahead, however few they are.
    pub(super) fn set(&self, readings: &Readings, robots_us: Option<i64>) {
        let others = [Source::Database, Source::Robots, Source::Supervisors].map(|source| readings.of(source));
        let all = || others.into_iter().flatten();
        let mut held = self.held();
        held.behind_us = all().chain([readings.host]).min().unwrap_or_default().min(0).saturating_neg();
        held.is_confirmed = all().chain(robots_us).any(|ahead_us| ahead_us.abs() <= NEAR_US)
            && robots_us.is_none_or(|ahead_us| ahead_us >= -NEAR_US);
    }

    /// The time line was stepped: the other clocks are heard again.
    pub(super) fn begin_again(&self) {
        *self.held() = Held::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR_US: i64 = 3_600_000_000;
    const NOW_US: i64 = 1_795_248_000_000_000;
    const SECOND: Duration = Duration::from_secs(1);

    /// The time by which rows are old, so long after the begin.
    fn old_after(hold_back: &HoldBack, time: Duration) -> i64 {
        let held = hold_back.held();
        held.old_by_us(held.since + time, NOW_US)
    }

    #[test]
    fn old_rows_are_deleted_by_the_clock_that_is_furthest_behind() {
        let hold_back = HoldBack::default();
        assert_eq!(old_after(&hold_back, ALONE), NOW_US);
        let readings = Readings { database: Some(-5), robots: Some(7), host: -HOUR_US, ..Readings::default() };
        hold_back.set(&readings, None);
        assert_eq!(old_after(&hold_back, ALONE), NOW_US - HOUR_US);
        hold_back.set(&Readings { database: Some(5), ..Readings::default() }, None);
        assert_eq!(old_after(&hold_back, ALONE), NOW_US);
    }

    #[test]
    fn regress_nothing_is_deleted_by_a_clock_before_the_others_are_heard() {
        let alone = Readings::default();
        let shared = Readings { database: Some(3), ..Readings::default() };
        let year_us = 365 * 24 * HOUR_US;
        for (readings, robots_us, hearing) in [
            (&alone, None, ALONE),
            (&alone, Some(-1_000), HEARING),
            (&shared, None, HEARING),
            // The database has the clock of the same host, and the only robot contradicts both.
            (&shared, Some(-year_us), ALONE),
            // A robot that is ahead makes no row old too early.
            (&shared, Some(year_us), HEARING),
            (&alone, Some(year_us), ALONE),
        ] {
            let hold_back = HoldBack::default();
            assert_eq!(hold_back.old_by_us(NOW_US), 0, "nothing is read yet");
            hold_back.set(readings, robots_us);
            assert_eq!(old_after(&hold_back, hearing - SECOND), 0, "{readings:?} {robots_us:?}");
            assert_eq!(old_after(&hold_back, hearing), NOW_US, "{readings:?} {robots_us:?}");
            hold_back.begin_again();
            assert_eq!(old_after(&hold_back, ALONE - SECOND), 0, "after a step they are read again");
        }
    }
}
