//! Spans of time over which contacts are aggregated.

use vibrissa_core::units::Micros;

/// Length of the spans of time over which contacts are aggregated, by the supervisor's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Resolution {
    /// Spans of one minute.
    Minute,
    /// Spans of one hour.
    Hour,
}

impl Resolution {
    /// All resolutions, the shortest first.
    pub const ALL: [Self; 2] = [Self::Minute, Self::Hour];

    /// Length of a span, µs.
    #[must_use]
    pub const fn us(self) -> u64 {
        match self {
            Self::Minute => 60_000_000,
            Self::Hour => 3_600_000_000,
        }
    }

    /// Number of the span that contains a time, counted from 1970 UTC.
    #[must_use]
    pub fn span_of(self, at: Micros) -> u32 {
        u32::try_from(at.0 / self.us()).unwrap_or(u32::MAX)
    }
}
