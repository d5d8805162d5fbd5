//! What is looked for: changes of a whisker's state, of every kind and size that matters.

use crate::estimation::filter::{BASELINE, LENGTH};

/// What kind of change a hypothesis supposes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The length falls at once: a cut. Also the sensitivity of the whole array, which is told apart later.
    Shorter,
    /// The sensitivity falls at once, which no trim explains: a gauge that comes loose, or a whisker that was
    /// exchanged for a longer one.
    LessSensitive,
    /// The length falls contact by contact: erosion.
    Eroding,
    /// The gauge's baseline drifts.
    Drifting,
}

impl Kind {
    /// The state that changes.
    #[must_use]
    pub fn state(self) -> usize {
        match self {
            Self::Shorter | Self::LessSensitive | Self::Eroding => LENGTH,
            Self::Drifting => BASELINE,
        }
    }

    /// Likelihood ratio at which a supposed start is given up for a later one.
    ///
    /// A step shows from its first contact on. A gradual change hardly shows at first: were its start given up at
    /// the first doubt, it would be placed long after it was, where it looks like a step.
    #[must_use]
    pub const fn restarts_at(self) -> f64 {
        if self.is_gradual() { 0.05 } else { 1.0 }
    }

    /// Whether the change adds up contact by contact.
    #[must_use]
    pub const fn is_gradual(self) -> bool {
        match self {
            Self::Shorter | Self::LessSensitive => false,
            Self::Eroding | Self::Drifting => true,
        }
    }
}

/// One supposed change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// Kind.
    pub kind: Kind,
    /// Size: of ln length, ln length per contact, or strain per contact.
    pub size: f64,
    /// Standard deviation of the size: contacts after the change's start tell it. 0 where neighbouring
    /// hypotheses do that better.
    pub spread: f64,
    /// Its weight in the mixture.
    pub weight: f64,
}

const fn hypothesis(kind: Kind, size: f64, weight: f64) -> Hypothesis {
    Hypothesis { kind, size, spread: 0.0, weight }
}

const fn of_any_size(kind: Kind, size: f64, spread: f64, weight: f64) -> Hypothesis {
    Hypothesis { kind, size, spread, weight }
}

/// Number of hypotheses.
pub const COUNT: usize = 17;

/// Number of supposed cuts; they come first.
pub const CUTS: usize = 7;

/// Those before it are steps, and those from it on are gradual.
pub const GRADUAL_FROM: usize = 10;

/// Those before it are of the length, and those from it on of the baseline.
pub const OF_LENGTH: usize = 13;

/// Those whose size is told by the contacts after the change's start.
pub const OF_ANY_SIZE: [usize; 2] = [6, 9];

/// All that are looked for. Sizes of steps double: 0.25 to 8 mm of 70 shorter, since a change is found by the
/// neighbouring hypotheses too; for more, where one contact may be forty standard deviations off, the size is
/// estimated on the way. A weight w delays an alarm by ln(1/w) nats, and a contact gives few nats on a small cut
/// and many on a large one: so the small ones, which take longest anyway, have most of the weight (all weights
/// sum to one: then the threshold is the stated mean number of contacts between false alarms).
pub const ALL: [Hypothesis; COUNT] = [
    hypothesis(Kind::Shorter, -0.0036, 0.11),
    hypothesis(Kind::Shorter, -0.0072, 0.29),
    hypothesis(Kind::Shorter, -0.0144, 0.17),
    hypothesis(Kind::Shorter, -0.029, 0.14),
    hypothesis(Kind::Shorter, -0.06, 0.08),
    hypothesis(Kind::Shorter, -0.11, 0.05),
    of_any_size(Kind::Shorter, -0.25, 0.2, 0.04),
    hypothesis(Kind::LessSensitive, 0.01, 0.02),
    hypothesis(Kind::LessSensitive, 0.04, 0.02),
    of_any_size(Kind::LessSensitive, 0.2, 0.15, 0.02),
    hypothesis(Kind::Eroding, -1e-5, 0.01),
    hypothesis(Kind::Eroding, -3e-5, 0.01),
    hypothesis(Kind::Eroding, -1e-4, 0.01),
    hypothesis(Kind::Drifting, -1e-6, 0.0075),
    hypothesis(Kind::Drifting, -2e-7, 0.0075),
    hypothesis(Kind::Drifting, 2e-7, 0.0075),
    hypothesis(Kind::Drifting, 1e-6, 0.0075),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_in_the_order_that_is_stated() {
        for (index, one) in ALL.iter().enumerate() {
            assert_eq!(one.kind == Kind::Shorter, index < CUTS, "{one:?}");
            assert_eq!(one.kind.is_gradual(), index >= GRADUAL_FROM, "{one:?}");
            assert_eq!(one.kind.state() == LENGTH, index < OF_LENGTH, "{one:?}");
            assert_eq!(one.spread > 0.0, OF_ANY_SIZE.contains(&index), "{one:?}");
        }
    }

    #[test]
    fn property_the_weights_sum_to_one() {
        let sum: f64 = ALL.iter().map(|one| one.weight).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
}
