//! The wall clock of a process, and that of its host. Durations are measured with tokio's `Instant`, the monotonic clock.
//!
//! The process has one time line: the host's wall clock when the line began, and from there on the monotonic clock. So a
//! step of the host's clock does not reach anything that uses [`now_us`]. Whoever finds that the host is right, or has
//! nobody to ask, moves the line with [`step`].

use std::sync::OnceLock;
use std::time::SystemTime;

use crate::process;
use crate::time_line::TimeLine;

/// Gives `work` the time line of the present process.
fn with_line<T>(work: impl FnOnce(&TimeLine) -> T) -> T {
    static REAL: OnceLock<TimeLine> = OnceLock::new();
    match process::simulated() {
        Some(process) => work(process.time_line()),
        None => work(REAL.get_or_init(|| TimeLine::from(host_clock_us()))),
    }
}

/// The time now in microseconds since 1970 UTC, by the process's time line. It goes back only by [`step`].
#[must_use]
pub fn now_us() -> i64 {
    with_line(TimeLine::now_us)
}

/// How far the host's clock is ahead of the process's time line, in microseconds.
#[must_use]
pub fn host_ahead_us() -> i64 {
    let now_us = now_us();
    host_clock_us().saturating_sub(now_us)
}

/// Moves the process's time line, by `by_us` microseconds ahead.
pub fn step(by_us: i64) {
    with_line(|line| line.step(by_us));
}

/// The host's wall clock in microseconds since 1970 UTC. It may be stepped at any time.
#[must_use]
pub fn host_clock_us() -> i64 {
    if let Some(process) = process::simulated() {
        return process.host_clock_us();
    }
    let since = system_time().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_micros()).unwrap_or(i64::MAX).saturating_add(planted_us()).max(0)
}

/// The host's wall clock, for libraries that ask for it.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "the one place that reads the host's clock")]
pub fn system_time() -> SystemTime {
    SystemTime::now()
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
        let before = now_us();
        step(-HOUR_US);
        assert!(now_us() < before);
        assert!((host_ahead_us() - HOUR_US).abs() < 1_000_000);
        step(HOUR_US);
        assert!(now_us() >= before);
    }
}
