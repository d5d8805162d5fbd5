//! Times of a robot. Durations are measured by [`Moment`]s, which no correction of the system's clock moves.

use std::ops::Add;

/// A moment of a clock that never goes back and never jumps. It has an arbitrary beginning, so it says nothing to others.
///
/// All waiting times, deadlines and rates rest on moments. Times in messages are plain numbers, so that the compiler refuses
/// to mix the two.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment(u64);

impl Moment {
    /// Before all others.
    pub const BEFORE_ALL: Self = Self(0);
    /// After all others.
    pub const NEVER: Self = Self(u64::MAX);

    /// So many microseconds after the beginning.
    #[must_use]
    pub const fn of_us(us: u64) -> Self {
        Self(us)
    }

    /// Microseconds since the beginning.
    #[must_use]
    pub const fn as_us(self) -> u64 {
        self.0
    }

    /// Microseconds since an earlier moment; 0 if it is not earlier.
    #[must_use]
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}

/// Some microseconds later.
impl Add<u64> for Moment {
    type Output = Self;

    fn add(self, us: u64) -> Self {
        Self(self.0.saturating_add(us))
    }
}

/// The present, by the clocks that a robot has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Now {
    /// For all durations.
    pub at: Moment,
    /// For times in messages, and for the expiry of what the supervisor sends: microseconds since 1970 UTC. It never goes back.
    pub stamp_us: u64,
    /// The system's clock, only to interpret the times of others who use it: microseconds since 1970 UTC. It may jump.
    pub system_us: u64,
}

impl Now {
    /// A present at which all clocks agree, as in a simulation.
    #[must_use]
    pub const fn of_us(us: u64) -> Self {
        Self { at: Moment(us), stamp_us: us, system_us: us }
    }

    /// The robot's time of something that happened at this time by the system's clock.
    #[must_use]
    pub const fn stamp_of(&self, system_us: u64) -> u64 {
        self.stamp_us.saturating_add(system_us).saturating_sub(self.system_us)
    }
}
