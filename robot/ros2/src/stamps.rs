//! Times of ROS messages: `header.stamp` counts if it can be a time of this machine's clock.

use ros2_client::builtin_interfaces::Time;

/// Greatest age of a stamp, microseconds. A simulated clock and the clock of a board without network time are outside.
pub(crate) const AGE_MAX_US: i64 = 10_000_000;
/// Greatest time ahead of this machine's clock, microseconds: the agent refuses one second.
pub(crate) const AHEAD_MAX_US: i64 = 500_000;

/// The verdict on a stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stamp {
    /// It counts: microseconds since 1970 UTC.
    Good(u64),
    /// It is not set.
    Unset,
    /// It is outside the window.
    Implausible,
}

/// Judges a stamp. `extra_us` is added to the greatest age: the length of what the message tells.
pub(crate) fn judge(stamp: Time, now: Time, extra_us: i64) -> Stamp {
    if stamp == Time::ZERO {
        return Stamp::Unset;
    }
    let (stamp_us, now_us) = (stamp.to_nanos() / 1000, now.to_nanos() / 1000);
    let age_us = now_us.saturating_sub(stamp_us);
    match u64::try_from(stamp_us) {
        Ok(stamp_us) if (-AHEAD_MAX_US..=AGE_MAX_US.saturating_add(extra_us)).contains(&age_us) => {
            Stamp::Good(stamp_us)
        }
        _ => Stamp::Implausible,
    }
}
