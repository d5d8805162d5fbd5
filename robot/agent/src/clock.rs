//! The clocks of this process.
//!
//! A robot's clock for messages begins as the system's clock and then runs evenly. Where the system's clock is set meanwhile,
//! the robot's follows slowly: a supervisor compares robot times with its own, and would refuse contacts and let setpoints
//! expire wrongly after a jump. Durations do not depend on either.

use std::sync::{Mutex, PoisonError};
use std::time::UNIX_EPOCH;

use rustix::time::{ClockId, clock_gettime};

use crate::contract::{Moment, Now};

/// Counts on while the machine sleeps, so that a supervisor's loss is noticed after it.
#[cfg(target_os = "linux")]
const MONOTONIC: ClockId = ClockId::Boottime;
#[cfg(not(target_os = "linux"))]
const MONOTONIC: ClockId = ClockId::Monotonic;
/// Moment at the system's start: not near [`Moment::BEFORE_ALL`], so that all pauses since then are over.
const STARTED_US: u64 = 3_600_000_000;
/// Part of the passed time by which the robot's clock runs faster or slower to follow the system's.
const FOLLOWED: i64 = 20;
/// Difference up to which both clocks are the same, in microseconds: they are read one after the other. Then the times that a
/// driver takes from the system's clock are in the messages as they are.
const SAME_US: i64 = 1_000;
/// A system's clock further ahead than this had not been set when the agent started, as without a battery. It is taken over at
/// once, in microseconds: a supervisor accepts such a jump, because it leads to the right time.
const UNSET_US: i64 = 2 * 3_600_000_000;
/// Difference between both clocks from which on it is logged, in microseconds: the contract asks for times that are correct to 2 s.
const TOLD_US: i64 = 2_000_000;

/// A robot's clock for messages.
#[derive(Debug, Clone, Copy)]
pub struct RobotClock {
    at: Moment,
    stamp_us: u64,
    is_reported: bool,
}

/// A difference between the clocks that a person should know of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Told {
    /// The system's clock is so many microseconds ahead, and is followed slowly.
    Following(i64),
    /// The system's clock was ahead by so many microseconds, and is taken over.
    TakenOver(i64),
}

fn signed(us: u64) -> i64 {
    i64::try_from(us).unwrap_or(i64::MAX)
}

impl RobotClock {
    /// It begins as the system's clock.
    #[must_use]
    pub fn new(at: Moment, system_us: u64) -> Self {
        Self { at, stamp_us: system_us, is_reported: false }
    }

    /// The present, at this moment and time of the system's clock.
    pub fn now(&mut self, at: Moment, system_us: u64) -> Now {
        self.go_on(at, system_us).0
    }

    /// Goes on to this moment.
    fn go_on(&mut self, at: Moment, system_us: u64) -> (Now, Option<Told>) {
        let passed_us = at.since(self.at);
        let even_us = self.stamp_us.saturating_add(passed_us);
        let ahead_us = signed(system_us) - signed(even_us);
        let most_us = signed(passed_us) / FOLLOWED;
        let is_unset = ahead_us > UNSET_US;
        self.at = self.at.max(at);
        let is_same = ahead_us.abs() <= SAME_US && system_us >= self.stamp_us;
        self.stamp_us = if is_unset || is_same {
            system_us
        } else {
            even_us.saturating_add_signed(ahead_us.clamp(-most_us, most_us))
        };
        let notice = if is_unset {
            Some(Told::TakenOver(ahead_us))
        } else {
            (ahead_us.abs() > TOLD_US && !self.is_reported).then_some(Told::Following(ahead_us))
        };
        self.is_reported = !is_unset && (self.is_reported || notice.is_some()) && ahead_us.abs() > TOLD_US / 2;
        (Now { at: self.at, stamp_us: self.stamp_us, system_us }, notice)
    }
}

fn system_us() -> u64 {
    let since = vibrissa_host::clock::system_time().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}

fn moment() -> Moment {
    let time = clock_gettime(MONOTONIC);
    let (seconds, nanoseconds) = (time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs());
    Moment::of_us(STARTED_US + seconds * 1_000_000 + nanoseconds / 1_000)
}

/// The present. All robots of a process have the same clocks.
#[must_use]
pub fn now() -> Now {
    static CLOCK: Mutex<Option<RobotClock>> = Mutex::new(None);
    let (now, notice) = {
        let mut clock = CLOCK.lock().unwrap_or_else(PoisonError::into_inner);
        // Read under the lock, so that no thread sees an earlier present than another one before it.
        let (at, system_us) = (moment(), system_us());
        clock.get_or_insert_with(|| RobotClock::new(at, system_us)).go_on(at, system_us)
    };
    match notice {
        Some(Told::Following(ahead_us)) => {
            let (by_s, side) = (ahead_us.abs() / 1_000_000, if ahead_us < 0 { "back" } else { "ahead" });
            tracing::warn!(
                "the system's clock was set {by_s} s {side}: the times in messages follow by 1 s in {FOLLOWED} s, and \
                 pressures and deadlines do not depend on it; start the agent again if the times must be right at once"
            );
        }
        Some(Told::TakenOver(ahead_us)) => {
            tracing::warn!(
                "the system's clock was set {} s ahead: the times in messages jump; start the agent after the clock is set, \
                 with After=time-sync.target",
                ahead_us / 1_000_000
            );
        }
        None => {}
    }
    now
}

/// The time for messages, in microseconds since 1970 UTC.
#[must_use]
pub fn now_us() -> u64 {
    now().stamp_us
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000;
    const NOW_US: u64 = 1_795_248_000 * S;

    /// Lets a clock run for some seconds after the system's clock was set by `step_s`; the stamps, and the warnings.
    fn stamps(step_s: i64, seconds: u64) -> (Vec<u64>, Vec<Told>) {
        let mut clock = RobotClock::new(Moment::of_us(STARTED_US), NOW_US);
        let after = (0..=seconds * 10).map(|tenth| {
            let passed_us = tenth * S / 10;
            let system_us = NOW_US.saturating_add_signed(step_s * S.cast_signed()) + passed_us;
            clock.go_on(Moment::of_us(STARTED_US + passed_us), system_us)
        });
        let (stamps, notices): (Vec<Now>, Vec<Option<Told>>) = after.unzip();
        (stamps.into_iter().map(|now| now.stamp_us).collect(), notices.into_iter().flatten().collect())
    }

    #[test]
    fn regress_no_step_of_the_systems_clock_makes_the_stamps_jump_or_go_back() {
        for step_s in [70, -70, -10, 10, 3_600, -3_600, -(NOW_US / S).cast_signed(), 0] {
            let (stamps, notices) = stamps(step_s, 60);
            for pair in stamps.windows(2) {
                let passed_us = pair[1] - pair[0];
                assert!(passed_us.abs_diff(S / 10) <= S / 200, "{step_s}: {passed_us} us in 100 ms");
            }
            assert_eq!(notices.len(), usize::from(step_s != 0), "{step_s}: {notices:?}");
        }
    }

    #[test]
    fn a_step_is_followed_until_the_stamps_are_right() {
        for step_s in [70, -70] {
            let (stamps, _) = stamps(step_s, 20 * 70 + 1);
            let right_us = NOW_US.saturating_add_signed(step_s * S.cast_signed()) + (20 * 70 + 1) * S;
            assert!(stamps.last().unwrap().abs_diff(right_us) < 1000, "{step_s}");
        }
    }

    #[test]
    fn a_clock_that_had_not_been_set_is_taken_over_at_once() {
        let (stamps, notices) = stamps(8 * 3_600, 1);
        assert_eq!(stamps[0], NOW_US + 8 * 3_600 * S);
        assert_eq!(notices, [Told::TakenOver(8 * 3_600_000_000)]);
    }

    #[test]
    fn regress_while_nobody_sets_the_systems_clock_the_stamps_are_its_times() {
        let mut clock = RobotClock::new(Moment::of_us(STARTED_US), NOW_US);
        let mut passed_us = 0;
        for step in 1..1000 {
            // The clocks are read one after the other, with pauses of any length between the calls.
            passed_us += if step % 5 == 0 { 40_000 } else { 1 + step % 7 };
            let (now, _) = clock.go_on(Moment::of_us(STARTED_US + passed_us - step % 3), NOW_US + passed_us);
            assert_eq!(now.stamp_us, NOW_US + passed_us, "step {step}");
        }
    }

    #[test]
    fn the_present_never_goes_back() {
        let first = now();
        let second = now();
        assert!(second.at >= first.at && second.stamp_us >= first.stamp_us);
        assert!(first.at > Moment::of_us(STARTED_US));
    }
}
