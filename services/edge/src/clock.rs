//! The process's time, and the host's.
//!
//! The process has one time line: the host's wall clock when the line began, and from there on the monotonic clock. So a
//! step of the host's clock does not reach anything that uses [`wall_clock`]. Whoever finds that the host is right, or has
//! nobody to ask, moves the line with [`step`].

use std::sync::OnceLock;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Instant, SystemTime};

use vibrissa_core::units::Micros;

struct Line {
    began: Instant,
    /// Time in µs since 1970 UTC at which it began.
    at_us: AtomicI64,
}

fn line() -> &'static Line {
    static LINE: OnceLock<Line> = OnceLock::new();
    LINE.get_or_init(|| Line { began: Instant::now(), at_us: AtomicI64::new(host_clock_us()) })
}

/// The time now in microseconds since 1970 UTC, by the process's time line. It goes back only by [`step`].
#[must_use]
pub fn wall_clock() -> Micros {
    let line = line();
    let since_us = i64::try_from(line.began.elapsed().as_micros()).unwrap_or(i64::MAX);
    Micros(u64::try_from(line.at_us.load(Ordering::Relaxed).saturating_add(since_us)).unwrap_or_default())
}

/// How far the host's clock is ahead of the process's time line, in microseconds.
#[must_use]
pub fn host_ahead_us() -> i64 {
    let now_us = wall_clock().0 as i64;
    host_clock_us().saturating_sub(now_us)
}

/// Moves the process's time line, by `by_us` microseconds ahead.
pub fn step(by_us: i64) {
    line().at_us.fetch_add(by_us, Ordering::Relaxed);
}

/// The host's wall clock in microseconds since 1970 UTC. It may be stepped at any time.
fn host_clock_us() -> i64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_micros()).unwrap_or(i64::MAX).saturating_add(planted_us()).max(0)
}

/// A fault that tests plant: the file in `VIBRISSA_TEST_CLOCK_FILE` tells how far the host's clock is ahead of the true
/// time, in microseconds. It is read each time, so that the clock can be stepped.
#[cfg(feature = "test-faults")]
fn planted_us() -> i64 {
    static FILE: OnceLock<Option<std::ffi::OsString>> = OnceLock::new();
    let file = FILE.get_or_init(|| std::env::var_os("VIBRISSA_TEST_CLOCK_FILE")).as_ref();
    file.and_then(|file| std::fs::read_to_string(file).ok()?.trim().parse().ok()).unwrap_or_default()
}

#[cfg(not(feature = "test-faults"))]
const fn planted_us() -> i64 {
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_line_follows_the_host_until_it_is_stepped() {
        const HOUR_US: i64 = 3_600_000_000;
        assert!(host_ahead_us().abs() < 1_000_000);
        let before = wall_clock();
        step(-HOUR_US);
        assert!(wall_clock() < before);
        assert!((host_ahead_us() - HOUR_US).abs() < 1_000_000);
        step(HOUR_US);
        assert!(wall_clock() >= before);
    }
}
