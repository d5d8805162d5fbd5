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

impl HoldBack {
    fn held(&self) -> MutexGuard<'_, Held> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The time by which rows are old if this supervisor's time is `now_us`. At 1970 nothing is.
    pub(crate) fn old_by_us(&self, now_us: i64) -> i64 {
        let held = self.held();
        let hearing = if held.is_confirmed { HEARING } else { ALONE };
        if held.since.elapsed() < hearing { 0 } else { now_us.saturating_sub(held.behind_us) }
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
    use tokio::time::advance;

    use super::*;

    const HOUR_US: i64 = 3_600_000_000;
    const NOW_US: i64 = 1_795_248_000_000_000;

    #[tokio::test(start_paused = true)]
    async fn old_rows_are_deleted_by_the_clock_that_is_furthest_behind() {
        let hold_back = HoldBack::default();
        advance(ALONE).await;
        assert_eq!(hold_back.old_by_us(NOW_US), NOW_US);
        let readings = Readings { database: Some(-5), robots: Some(7), host: -HOUR_US, ..Readings::default() };
        hold_back.set(&readings, None);
        assert_eq!(hold_back.old_by_us(NOW_US), NOW_US - HOUR_US);
        hold_back.set(&Readings { database: Some(5), ..Readings::default() }, None);
        assert_eq!(hold_back.old_by_us(NOW_US), NOW_US);
    }

    #[tokio::test(start_paused = true)]
    async fn regress_nothing_is_deleted_by_a_clock_before_the_others_are_heard() {
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
            for _ in 0..2 {
                hold_back.set(readings, robots_us);
                advance(hearing - Duration::from_secs(1)).await;
                assert_eq!(hold_back.old_by_us(NOW_US), 0, "{readings:?} {robots_us:?}");
                advance(Duration::from_secs(1)).await;
                assert_eq!(hold_back.old_by_us(NOW_US), NOW_US, "{readings:?} {robots_us:?}");
                hold_back.begin_again();
            }
        }
    }
}
