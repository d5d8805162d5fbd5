//! Quality of a compensation by contact ratio: eq. 35 and the remaining gain.

use borsh::{BorshDeserialize, BorshSerialize};

use super::model::Model;
use super::morphology::Morphology;
use crate::units::{ContactRatio, Millimetre};

/// The paper's contact ratios, a = 0.45 to 1 in steps of 0.05.
pub const CONTACT_RATIOS: [f64; 12] = [0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0];

/// One number for each of [`CONTACT_RATIOS`]; `None` where the contact would lie on the chamber.
pub type ByRatio = [Option<f64>; CONTACT_RATIOS.len()];

/// Weights of [`CONTACT_RATIOS`], each at least 0, at least one above 0. Only their ratios count.
pub type RatioWeights = [f64; CONTACT_RATIOS.len()];

/// All contact ratios count alike.
pub const EVEN_WEIGHTS: RatioWeights = [1.0; CONTACT_RATIOS.len()];

/// The contacts that a robot usually makes with a whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UsualContacts {
    /// Share of each contact ratio.
    pub weights: RatioWeights,
    /// Sensitivity up to which the gauge can read the largest deflection at each contact ratio, 1/mm; `None` without a limit.
    pub per_mm_max: ByRatio,
}

impl UsualContacts {
    /// Nothing is known of them.
    pub const UNKNOWN: Self = Self { weights: EVEN_WEIGHTS, per_mm_max: [None; CONTACT_RATIOS.len()] };
}

/// Deviation of a real whisker from its model, as a straight line over the contact ratio a:
/// `ln s_real = ln s_model + level + slope * (a - 0.725)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Offset {
    /// Offset of the log sensitivity at a = [`Offset::CENTRE`].
    pub level: f64,
    /// Change of the offset per unit of contact ratio.
    pub slope: f64,
}

impl Offset {
    /// No deviation from the model.
    pub const NONE: Self = Self { level: 0.0, slope: 0.0 };
    /// Centre of the contact ratios, 0.45 to 1.
    pub const CENTRE: f64 = 0.725;

    /// Offset of the log sensitivity at a contact ratio.
    #[must_use]
    pub fn at(self, ratio: ContactRatio) -> f64 {
        self.level + self.slope * (ratio.a() - Self::CENTRE)
    }

    /// The offset of the same whisker once only this share of its length is left. It belongs to the distance from the base,
    /// because a cut changes nothing between base and contact.
    #[must_use]
    pub fn shortened(self, share_left: f64) -> Self {
        let Self { level, slope } = self;
        Self { level: level + slope * Self::CENTRE * (share_left - 1.0), slope: slope * share_left }
    }

    /// Difference from another offset.
    #[must_use]
    pub fn beyond(self, other: Self) -> Self {
        Self { level: self.level - other.level, slope: self.slope - other.slope }
    }
}

/// Eq. 35 as a ratio (0.2 is 20 %): share of the difference to the target that remains after a compensation.
///
/// All arguments are sensitivities, or strains at equal deflection, in one unit. 0 is perfect, 1 is no better than
/// before. `None` if `before` equals `target`: there is nothing to compensate.
#[must_use]
pub fn compensation_error(after: f64, before: f64, target: f64) -> Option<f64> {
    let error = ((after - target) / (before - target)).abs();
    (before != target && error.is_finite()).then_some(error)
}

/// Eq. 35 by contact ratio.
///
/// Contact ratios at which the model or eq. 35 is undefined are excluded from the mean; `used` marks the others.
/// Excluded are contacts on the chamber of one of the whiskers (short whiskers at a = 0.45), and sensitivities
/// before the compensation within 0.5 % of the target's, because the ratio of two small differences would dominate.
/// There `by_ratio` repeats the nearest used value, so that all numbers are finite. If no contact ratio is used,
/// there is nothing to compensate and all values are 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorProfile {
    /// Error at [`CONTACT_RATIOS`], as a ratio: 0.2 is 20 %.
    pub by_ratio: [f64; CONTACT_RATIOS.len()],
    /// Whether each contact ratio counts in the mean.
    pub used: [bool; CONTACT_RATIOS.len()],
    /// Mean error of the used contact ratios, as a ratio. They count alike, or by their weights.
    pub mean: f64,
}

impl ErrorProfile {
    /// Least difference to divide by, as a share of the target.
    pub const LEAST_DIFFERENCE: f64 = 0.005;

    /// Number of contact ratios in the mean.
    #[must_use]
    pub fn ratios_used(&self) -> usize {
        self.used.iter().filter(|used| **used).count()
    }

    /// Computes the profile from sensitivities, or strains at one deflection, in one unit.
    #[must_use]
    pub fn new(after: &ByRatio, before: &ByRatio, target: &ByRatio) -> Self {
        Self::weighted(after, before, target, &EVEN_WEIGHTS)
    }

    /// The profile with the mean by weights.
    #[must_use]
    pub fn weighted(after: &ByRatio, before: &ByRatio, target: &ByRatio, weights: &RatioWeights) -> Self {
        let errors: ByRatio = std::array::from_fn(|k| match (after[k], before[k], target[k]) {
            (Some(after), Some(before), Some(target)) if distinct(before, target) => {
                compensation_error(after, before, target)
            }
            _ => None,
        });
        let used = errors.map(|error| error.is_some());
        let mean = weighted_mean(errors.iter().zip(weights).filter_map(|(error, weight)| Some((*weight, (*error)?))));
        Self { by_ratio: fill(&errors, 0.0), used, mean }
    }

    /// Only the mean of eq. 35, from sensitivities relative to the target's. Contact ratios with the weight 0 are left out.
    /// Cheaper than a profile where hundreds of means are needed.
    #[must_use]
    pub fn mean_against_target(
        after: &[f64; CONTACT_RATIOS.len()],
        before: &[f64; CONTACT_RATIOS.len()],
        weights: &RatioWeights,
    ) -> f64 {
        let used = (0..CONTACT_RATIOS.len()).filter(|&k| weights[k] > 0.0 && distinct(before[k], 1.0));
        weighted_mean(used.filter_map(|k| Some((weights[k], compensation_error(after[k], before[k], 1.0)?))))
    }
}

/// Mean of pairs of weight and value; 0 without any weight.
pub(super) fn weighted_mean(weighed: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, weights) = weighed.fold((0.0, 0.0), |(sum, all), (weight, value)| (sum + weight * value, all + weight));
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// Whether the difference is large enough to divide by in eq. 35.
pub(super) fn distinct(before: f64, target: f64) -> bool {
    (before - target).abs() > ErrorProfile::LEAST_DIFFERENCE * target
}

/// Remaining correction in software: target sensitivity / compensated sensitivity by contact ratio.
///
/// The compensator's strain times this gain is the strain that the target would have shown. Where a contact would
/// lie on the chamber, the gain is that of the nearest ratio beyond it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainProfile {
    /// Gain at [`CONTACT_RATIOS`]; above 0.
    pub by_ratio: [f64; CONTACT_RATIOS.len()],
}

impl GainProfile {
    /// Computes the gains from sensitivities in one unit.
    #[must_use]
    pub fn new(after: &ByRatio, target: &ByRatio) -> Self {
        let gains: ByRatio = std::array::from_fn(|k| Some(target[k]? / after[k]?));
        Self { by_ratio: fill(&gains, 1.0) }
    }
}

/// Sensitivities of a whisker at [`CONTACT_RATIOS`], offset included.
pub(super) fn sensitivities_per_mm(
    model: &Model,
    length: Millimetre,
    morphology: &Morphology,
    offset_factors: &[f64; CONTACT_RATIOS.len()],
) -> ByRatio {
    std::array::from_fn(|k| {
        let ratio = ContactRatio::known(CONTACT_RATIOS[k]);
        let modelled = model.sensitivity_per_mm(ratio, length, morphology).ok()?;
        Some(offset_factors[k] * modelled)
    })
}

/// Fills gaps with the nearest known number; ties go to the larger contact ratio.
fn fill(values: &ByRatio, if_none: f64) -> [f64; CONTACT_RATIOS.len()] {
    std::array::from_fn(|k| {
        let distance = |other: usize| (other.abs_diff(k), other < k);
        let nearest =
            || (0..values.len()).filter(|&other| values[other].is_some()).min_by_key(|&other| distance(other));
        values[k].or_else(|| values[nearest()?]).unwrap_or(if_none)
    })
}
