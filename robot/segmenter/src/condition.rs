//! How far the findings of a segmenter can be relied on.

use crate::{Contact, Params};

/// State of a segmenter, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// It cannot report contacts yet, as something is missing. Contacts are held back.
    Learning(Missing),
    /// Rest was known and is in doubt: after a gap, a step of air, or in a contact longer than `longest_s` without
    /// a deflection. Contacts are held back.
    Lost,
    /// The last contacts went against the sign that is stated: the gauge is wired the other way round.
    Inverted,
    /// The last contact was beyond the gauge's limit: its strain is a lower bound.
    Clipped,
    /// The whisker shakes, or the converter has many glitches: only strong touches are found.
    Noisy,
    /// Contacts are reported as they end.
    Ready,
}

/// What a segmenter needs to report contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// A higher rate of samples.
    Rate,
    /// A moment in which the strain is still.
    Stillness,
    /// Evidence which level is rest: motion, a touch, or its sign.
    Rest,
}

impl Condition {
    /// Its word in logs and messages.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Condition::Learning(_) => "LEARNING",
            Condition::Lost => "LOST",
            Condition::Inverted => "INVERTED",
            Condition::Clipped => "CLIPPED",
            Condition::Noisy => "NOISY",
            Condition::Ready => "READY",
        }
    }
}

/// Contacts in a row against the stated sign that show a gauge to be inverted.
const AGAINST: u32 = 3;
/// Part of the samples that are many glitches.
const MANY: f64 = 0.02;

/// What the last contacts tell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    against: u32,
    clipped: bool,
}

impl Watch {
    pub(crate) fn contact(&mut self, params: &Params, contact: &Contact) {
        self.against = if contact.strain * params.sign < 0.0 { self.against.saturating_add(1) } else { 0 };
        self.clipped = contact.saturated;
    }

    pub(crate) fn condition(self, params: &Params, shakes: bool, glitches: f64) -> Condition {
        if params.sign != 0.0 && self.against >= AGAINST {
            Condition::Inverted
        } else if self.clipped {
            Condition::Clipped
        } else if shakes || glitches > MANY {
            Condition::Noisy
        } else {
            Condition::Ready
        }
    }
}
