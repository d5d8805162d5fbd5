//! What few whiskers have: those that have it give it room.

use std::ops::{Deref, DerefMut};

use crate::estimation::{ErosionWatch, OwnCalibration};
use crate::mechanics::Offset;
use crate::robot::state::whisker::{PendingTrim, Unsteady};
use crate::units::Micros;

/// What is known of a whisker that was cut, erodes, serves, is sent setpoints, or is in an array that shifts.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::robot) struct Rare {
    /// A confirmed cut whose length is not certain enough yet to act on.
    pub pending_trim: Option<PendingTrim>,
    /// Its offset while whole at nominal pressure, once it is not any more.
    pub whole_offset: Option<Offset>,
    /// Its responses at the pressures where it served.
    pub own: Option<Box<OwnCalibration>>,
    /// From the verdict that it erodes on.
    pub erosion: Option<Box<ErosionWatch>>,
    /// The whole array has shifted, and may go on doing so.
    pub unsteady: Option<Unsteady>,
    /// Setpoints that it was sent for the same pressure.
    pub attempts: u8,
    /// No new setpoint before this, by the supervisor's clock.
    pub not_before: Micros,
}

static NONE: Rare = Rare {
    pending_trim: None,
    whole_offset: None,
    own: None,
    erosion: None,
    unsteady: None,
    attempts: 0,
    not_before: Micros(0),
};

/// Room for it, once there is something.
#[derive(Debug, Clone, Default)]
pub(in crate::robot) struct Rares(Option<Box<Rare>>);

impl Rares {
    /// What there is, to be changed; looking for what is not there makes no room.
    pub(in crate::robot) fn there(&mut self) -> Option<&mut Rare> {
        self.0.as_deref_mut()
    }

    /// The next setpoint is the first one.
    pub(in crate::robot) fn forget_attempts(&mut self) {
        if let Some(rare) = self.there() {
            rare.attempts = 0;
        }
    }

    /// The last setpoint does not count as an attempt.
    pub(in crate::robot) fn forget_attempt(&mut self) {
        if let Some(rare) = self.there() {
            rare.attempts = rare.attempts.saturating_sub(1);
        }
    }
}

impl From<Rare> for Rares {
    fn from(rare: Rare) -> Self {
        Self((rare != NONE).then(|| Box::new(rare)))
    }
}

impl Deref for Rares {
    type Target = Rare;

    fn deref(&self) -> &Rare {
        self.0.as_deref().unwrap_or(&NONE)
    }
}

/// Makes room.
impl DerefMut for Rares {
    fn deref_mut(&mut self) -> &mut Rare {
        self.0.get_or_insert_with(|| Box::new(NONE.clone()))
    }
}

/// Room without anything in it is none.
impl PartialEq for Rares {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}
