//! State that few whiskers have, in a box: the others pay for a pointer only.

use std::ops::Deref;

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::{ErosionWatch, OwnCalibration, Reach};
use crate::mechanics::Offset;
use crate::robot::effect::Fault;
use crate::robot::health::flapping::{Flapping, Vent};
use crate::robot::setpoints::tries::Tries;
use crate::robot::state::first_contacts::FirstContacts;
use crate::robot::touch_tests::{DistanceZero, LengthTest};
use crate::units::Micros;

/// A cut that is confirmed.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct PendingTrim {
    pub length_before_mm: f64,
    pub contacts_since_change: u32,
    pub contacts_since_confirmed: u32,
}

/// An offset that follows a shift of the whole array.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Unsteady {
    /// The shift that was found, log sensitivity, without its sign.
    pub log_shift: f64,
    /// Contacts for which it goes on.
    pub contacts_left: u32,
}

impl Unsteady {
    pub(in crate::robot) fn after_contact(&self) -> Option<Self> {
        let contacts_left = self.contacts_left.checked_sub(1)?;
        Some(Self { contacts_left, ..*self })
    }
}

/// State of a whisker that was cut, erodes, serves, is sent setpoints, is in an array that shifts, is touched at known
/// distances, or whose fault changes.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::robot) struct RareState {
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
    /// Distances at which it is touched, once a contact told one.
    pub reach: Option<Box<Reach>>,
    /// Measurement of its length by touches, while it goes on.
    pub length_test: Option<Box<LengthTest>>,
    /// Tries of the present setpoint that have failed.
    pub tries: Tries,
    /// No new setpoint before this, by the supervisor's clock.
    pub not_before: Micros,
    /// When the robot sent its last report that it moves to a setpoint or holds it, by its own clock; 0 before the
    /// first.
    pub set_at: Micros,
    /// When that report was received, by the supervisor's clock.
    pub set_heard: Micros,
    /// Changes of its fault, until it is steady again.
    pub flapping: Option<Flapping<Fault>>,
    /// Vents by the robot without a setpoint, until they are long ago.
    pub vents: Option<Flapping<Vent>>,
    /// Largest usual deflection of its contacts, mm; 0 if the factsheet states no range of the gauge.
    pub largest_deflection_mm: f32,
    /// Time of the contact that showed the newest change, or of a replacement, by the robot's clock; 0 before the first.
    /// Contacts from before are no evidence any more.
    pub changed_at: Micros,
    /// The error that all distances of its robot share.
    pub zero: DistanceZero,
    /// Its first contacts, while it is learned.
    pub first: Option<Box<FirstContacts>>,
}

static NONE: RareState = RareState {
    pending_trim: None,
    whole_offset: None,
    own: None,
    erosion: None,
    unsteady: None,
    reach: None,
    length_test: None,
    tries: Tries::NONE,
    not_before: Micros(0),
    set_at: Micros(0),
    set_heard: Micros(0),
    flapping: None,
    vents: None,
    largest_deflection_mm: 0.0,
    changed_at: Micros(0),
    zero: DistanceZero::UNKNOWN,
    first: None,
};

/// The rare state of a whisker. It reads as [`NONE`] until something is put into it.
#[derive(Debug, Clone, Default)]
pub(in crate::robot) struct Rare(Option<Box<RareState>>);

impl Rare {
    /// The state, unless nothing was put into it yet.
    pub(in crate::robot) fn get_mut(&mut self) -> Option<&mut RareState> {
        self.0.as_deref_mut()
    }

    /// The state; the first call allocates it.
    pub(in crate::robot) fn get_or_insert(&mut self) -> &mut RareState {
        self.0.get_or_insert_with(|| Box::new(NONE.clone()))
    }

    /// A person acts on its vents: the next one is the first one.
    pub(in crate::robot) fn forget_vents(&mut self) {
        if let Some(rare) = self.get_mut() {
            rare.vents = None;
        }
    }

    /// It is learned: its first contacts count no more. Without them most whiskers have no rare state.
    pub(in crate::robot) fn forget_first(&mut self) {
        if let Some(rare) = self.get_mut() {
            rare.first = None;
            if *rare == NONE {
                self.0 = None;
            }
        }
    }

    /// The next setpoint is the first one.
    pub(in crate::robot) fn forget_tries(&mut self) {
        if let Some(rare) = self.get_mut() {
            rare.tries = Tries::NONE;
        }
    }
}

impl From<RareState> for Rare {
    fn from(rare: RareState) -> Self {
        Self((rare != NONE).then(|| Box::new(rare)))
    }
}

impl Deref for Rare {
    type Target = RareState;

    fn deref(&self) -> &RareState {
        self.0.as_deref().unwrap_or(&NONE)
    }
}

/// A box with nothing in it equals no box.
impl PartialEq for Rare {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}
