//! A time that may not have been yet, in the room of a time.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::units::Micros;

/// A time, or none.
#[derive(Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Moment(Micros);

impl Moment {
    /// None: no clock comes so far.
    pub(in crate::robot) const NONE: Self = Self(Micros(u64::MAX));

    pub(in crate::robot) fn at(time: Micros) -> Self {
        Self(time)
    }

    pub(in crate::robot) fn get(self) -> Option<Micros> {
        (self != Self::NONE).then_some(self.0)
    }

    /// The time is this one if there was none.
    pub(in crate::robot) fn get_or_insert(&mut self, time: Micros) {
        if *self == Self::NONE {
            *self = Self(time);
        }
    }
}

impl std::fmt::Debug for Moment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.get().fmt(f)
    }
}
