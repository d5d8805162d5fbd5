//! The first contacts of a whisker, as they were felt before anything was learned.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::mechanics::Offset;
use crate::units::ContactRatio;

/// Number of first contacts that count.
pub(in crate::robot) const EARLY_CONTACTS: u8 = 10;

/// Mean response of a whisker's first contacts, against the model at its whole length.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct FirstContacts {
    contacts: u8,
    /// Sums of contact ratios, of deviations from the model, and of their squares.
    ratio: f32,
    deviation: f32,
    square: f32,
}

impl FirstContacts {
    /// Whether its numbers are finite.
    pub(in crate::robot) fn is_sound(&self) -> bool {
        [self.ratio, self.deviation, self.square].iter().all(|one| one.is_finite())
    }

    /// Takes in a contact with its deviation from the model, log sensitivity.
    pub(in crate::robot) fn add(&mut self, ratio: ContactRatio, deviation: f64) {
        self.contacts = self.contacts.saturating_add(1);
        self.deviation += deviation as f32;
        self.ratio += ratio.a() as f32;
        self.square += deviation.powi(2) as f32;
    }

    /// Rise of the log sensitivity to the level of this offset, and the variance of the first contacts around their mean.
    pub(in crate::robot) fn rise_to(&self, offset: Offset) -> Option<(f64, f64)> {
        let contacts = f64::from(self.contacts);
        let mean = f64::from(self.deviation) / contacts;
        let variance = (f64::from(self.square) / contacts - mean * mean).max(0.0);
        let at =
            ContactRatio::new(f64::from(self.ratio) / contacts).ok().filter(|_| self.contacts == EARLY_CONTACTS)?;
        Some((offset.at(at) - mean, variance))
    }
}
