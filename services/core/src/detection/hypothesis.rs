//! Change hypotheses: all kinds and sizes of changes of a whisker's state that the detector searches for.

use crate::estimation::filter::{BASELINE, LENGTH};

/// Kind of change that a hypothesis assumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HypothesisKind {
    /// The length falls at once: a cut. A rise of the whole array's sensitivity looks the same and is separated
    /// later.
    Shorter,
    /// The sensitivity falls at once, which no trim explains: a gauge that came loose, or a longer replacement
    /// whisker.
    LessSensitive,
    /// The length falls contact by contact: erosion.
    Eroding,
    /// The gauge's baseline drifts.
    Drifting,
}

impl HypothesisKind {
    /// Index of the filter state that changes.
    #[must_use]
    pub fn state(self) -> usize {
        match self {
            Self::Shorter | Self::LessSensitive | Self::Eroding => LENGTH,
            Self::Drifting => BASELINE,
        }
    }

    /// Likelihood ratio below which the assumed start is replaced by a later one.
    ///
    /// A step shows from its first contact on. A gradual change hardly shows at first: if its start were discarded
    /// at the first doubt, it would be placed much too late, where it looks like a step.
    #[must_use]
    pub const fn restarts_at(self) -> f64 {
        if self.is_gradual() { 0.05 } else { 1.0 }
    }

    /// Whether the change accumulates contact by contact.
    #[must_use]
    pub const fn is_gradual(self) -> bool {
        match self {
            Self::Shorter | Self::LessSensitive => false,
            Self::Eroding | Self::Drifting => true,
        }
    }
}

/// One hypothesis: a change of one kind and size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// Kind of the change.
    pub kind: HypothesisKind,
    /// Size: change of ln length, of ln length per contact, or of strain per contact.
    pub size: f64,
    /// Prior standard deviation of the size, if the contacts after the start estimate it. 0 if neighbouring
    /// hypotheses cover the other sizes.
    pub spread: f64,
    /// Weight in the mixture.
    pub weight: f64,
}

const fn hypothesis(kind: HypothesisKind, size: f64, weight: f64) -> Hypothesis {
    Hypothesis { kind, size, spread: 0.0, weight }
}

const fn of_any_size(kind: HypothesisKind, size: f64, spread: f64, weight: f64) -> Hypothesis {
    Hypothesis { kind, size, spread, weight }
}

/// Number of hypotheses.
pub const COUNT: usize = 17;

/// Number of cut hypotheses; they come first.
pub const CUTS: usize = 7;

/// Index of the first gradual hypothesis; steps come before it.
pub const GRADUAL_FROM: usize = 10;

/// Index of the first hypothesis on the baseline; those on the length come before it.
pub const OF_LENGTH: usize = 13;

/// Indices of the hypotheses whose size is estimated from the contacts after the start.
pub const OF_ANY_SIZE: [usize; 2] = [6, 9];

/// All hypotheses. Sizes of steps about double from 0.25 to 8 mm of 70 mm, since neighbouring hypotheses also find the
/// sizes between them. For larger steps, where one contact may be off by forty standard deviations, the size is
/// estimated from the contacts. A weight w delays an alarm by ln(1/w) nats; a contact gives few nats for a small
/// cut and many for a large one. So 0.5 mm, which takes long, and 5 mm, where one contact more is a third of the delay,
/// have most of the weight; 0.25 mm, which is never reported as a trim, has little. All weights sum to one, so that the
/// threshold follows from the mean number of contacts between false alarms.
pub const ALL: [Hypothesis; COUNT] = [
    hypothesis(HypothesisKind::Shorter, -0.0036, 0.02),
    hypothesis(HypothesisKind::Shorter, -0.0072, 0.22),
    hypothesis(HypothesisKind::Shorter, -0.0144, 0.12),
    hypothesis(HypothesisKind::Shorter, -0.029, 0.12),
    hypothesis(HypothesisKind::Shorter, -0.068, 0.29),
    hypothesis(HypothesisKind::Shorter, -0.12, 0.07),
    of_any_size(HypothesisKind::Shorter, -0.25, 0.2, 0.04),
    hypothesis(HypothesisKind::LessSensitive, 0.01, 0.02),
    hypothesis(HypothesisKind::LessSensitive, 0.04, 0.02),
    of_any_size(HypothesisKind::LessSensitive, 0.2, 0.15, 0.02),
    hypothesis(HypothesisKind::Eroding, -1e-5, 0.01),
    hypothesis(HypothesisKind::Eroding, -3e-5, 0.01),
    hypothesis(HypothesisKind::Eroding, -1e-4, 0.01),
    hypothesis(HypothesisKind::Drifting, -1e-6, 0.0075),
    hypothesis(HypothesisKind::Drifting, -2e-7, 0.0075),
    hypothesis(HypothesisKind::Drifting, 2e-7, 0.0075),
    hypothesis(HypothesisKind::Drifting, 1e-6, 0.0075),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_in_the_order_that_is_stated() {
        for (index, one) in ALL.iter().enumerate() {
            assert_eq!(one.kind == HypothesisKind::Shorter, index < CUTS, "{one:?}");
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
