//! Spans of time over which contacts are added up.

use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_core::units::Micros;

/// How long the spans of time are that contacts are added up over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, BorshSerialize, BorshDeserialize)]
pub enum Resolution {
    /// Of the supervisor's clock.
    Minute,
    /// Of the supervisor's clock.
    Hour,
}

impl Resolution {
    /// Every resolution, the shortest spans first.
    pub const ALL: [Self; 2] = [Self::Minute, Self::Hour];

    /// Length of the spans.
    #[must_use]
    pub const fn us(self) -> u64 {
        match self {
            Self::Minute => 60_000_000,
            Self::Hour => 3_600_000_000,
        }
    }

    /// The span that a moment lies in, counted from 1970.
    #[must_use]
    pub fn span_of(self, at: Micros) -> u32 {
        u32::try_from(at.0 / self.us()).unwrap_or(u32::MAX)
    }
}
