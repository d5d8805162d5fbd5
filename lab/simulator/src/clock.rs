//! The clock of simulated robots, boards and loads. It runs evenly: also when the system's clock is set.

use std::sync::OnceLock;

use vibrissa_robot::clock;
use vibrissa_robot::contract::Now;

/// The time of simulated robots, boards and loads, in microseconds since 1970 UTC: the system's clock at the first call,
/// continued by the monotonic clock. So differences of two times are durations, whoever sets the system's clock meanwhile.
#[must_use]
pub fn now_us() -> u64 {
    at_us(clock::now())
}

/// The time of simulated robots at a moment.
pub(crate) fn at_us(now: Now) -> u64 {
    static BEGUN: OnceLock<Now> = OnceLock::new();
    let begun = BEGUN.get_or_init(|| now);
    begun.stamp_us + now.at.since(begun.at)
}
