//! The process's time, in the core's units.

use vibrissa_core::units::Micros;
use vibrissa_host::clock;

/// The time now in microseconds since 1970 UTC, by the process's time line ([`clock`]).
#[must_use]
pub fn wall_clock() -> Micros {
    Micros(u64::try_from(clock::now_us()).unwrap_or_default())
}
