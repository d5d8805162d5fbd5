//! The supervisor's wall clock.

use std::time::SystemTime;

use vibrissa_core::units::Micros;

/// The time now in microseconds since 1970 UTC, by the supervisor's clock. It may be set back.
#[must_use]
pub fn wall_clock() -> Micros {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    Micros(u64::try_from(since.as_micros()).unwrap_or(u64::MAX))
}
