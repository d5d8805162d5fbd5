//! How far the findings of a segmenter can be relied on.

use crate::Contact;

/// State of a segmenter, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// It cannot report contacts yet, as something is missing. Contacts are held back.
    Learning(Missing),
    /// Rest was known and is in doubt: after a gap, a step of air, or in a contact longer than `longest_s` without
    /// a deflection. Contacts are held back.
    Lost,
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
            Condition::Clipped => "CLIPPED",
            Condition::Noisy => "NOISY",
            Condition::Ready => "READY",
        }
    }
}

/// Part of the samples that are many glitches.
const MANY: f64 = 0.02;

/// What the last contacts tell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    clipped: bool,
}

impl Watch {
    pub(crate) fn contact(&mut self, contact: &Contact) {
        self.clipped = contact.saturated;
    }

    pub(crate) fn condition(self, shakes: bool, glitches: f64) -> Condition {
        if self.clipped {
            Condition::Clipped
        } else if shakes || glitches > MANY {
            Condition::Noisy
        } else {
            Condition::Ready
        }
    }
}
