//! A contact before and after its comparison with the length filter's prediction.

use std::ops::RangeInclusive;

use super::outlier::{InnovationDensity, Seen};
use super::spread::ExpectedRatio;
use crate::mechanics::ContactOnChamber;
use crate::units::ContactRatio;

/// Number of states.
pub const STATES: usize = 6;
/// Bounds of one contact's effect: far beyond any real whisker, and small enough for finite sums in single
/// precision. A strain of 1e-9 where 1 is expected has a residual of -21.
const RESIDUAL_MAX: f64 = 40.0;
pub(super) const VARIANCES: RangeInclusive<f64> = 1e-10..=1e6;
const ROW_AND_GAIN_MAX: f64 = 1e6;

/// Random walk of the state from one contact to the next, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wander {
    /// The length, mm.
    pub length_mm: f64,
    /// The baseline, m/m.
    pub baseline_strain: f64,
    /// The offset, log sensitivity.
    pub offset: f64,
}

/// One contact compared with the filter's prediction; see [`observe`](super::LengthFilter::observe).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// Observed minus predicted log strain.
    pub residual: f64,
    /// Variance of the residual: uncertainty of the state, plus noise.
    pub variance: f64,
    /// Variance of the contact's noise alone, inflated by the correlation between contacts.
    pub noise_variance: f64,
    /// residual / sqrt(variance), in standard deviations.
    pub standardised: f64,
    /// This contact by itself: the same without the inflation, of unit variance whatever the correlation.
    pub alone: Alone,
    /// Density of the standardised residual while nothing changes.
    pub density: InnovationDensity,
    /// That density at this contact, and the probability that the contact is not an outlier.
    pub seen: Seen,
    /// Contact ratio at which the contact was compared.
    pub ratio: ContactRatio,
    /// Share of the play in the noise variance.
    pub by_play: f64,
    /// d(log sensitivity) / d(contact ratio), if the contact tells of the size of the ratios' errors.
    pub tells_errors: Option<f64>,
    /// d(log strain) / d(state).
    pub row: [f64; STATES],
    /// Kalman gain, already reduced for a likely outlier.
    pub gain: [f64; STATES],
    /// Noise variance that corresponds to this gain.
    pub(super) gain_noise_variance: f64,
    /// Change of log sensitivity by temperature and deflection that the state predicts for this contact.
    pub by_circumstances: f64,
    /// The model's sensitivity corrected by the learned offset and by the circumstances, strain per mm.
    pub predicted_sensitivity_per_mm: f64,
}

/// The innovation of one contact by itself, whatever its correlation with others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alone {
    /// Residual in its standard deviations.
    pub standardised: f64,
    /// Probability that the contact is not an outlier.
    pub sound: f64,
    /// Share of the noise in the residual's variance.
    pub noise_share: f64,
}

/// Measurements of one contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Contact ratio.
    pub place: ExpectedRatio,
    /// Whether the contact ratio is one of the present length. A contact at a known distance from the base has the same
    /// sensitivity whatever lies beyond it.
    pub informs_length: bool,
    /// Deflection at the contact, mm, above 0.
    pub deflection_mm: f64,
    /// Measured strain, m/m.
    pub strain: f64,
    /// Temperature above the whisker's reference, K; 0 if the robot states none.
    pub warmer_k: f64,
}

/// Why a contact cannot update the length.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoInformation {
    /// By the present length estimate the contact lies on the chamber, where the model is invalid.
    #[error(transparent)]
    OnChamber(#[from] ContactOnChamber),
    /// The measured strain is negative by more than the gauge's noise, as of a gauge whose wires are exchanged.
    #[error("strain is negative")]
    Negative,
    /// The expected strain is close to the gauge's noise floor, or the measured strain is not positive.
    #[error("strain too small to determine a sensitivity")]
    TooWeak,
    /// The contact would move the estimate out of its bounds.
    #[error("readings outside the range of any real whisker")]
    Implausible,
}

impl Innovation {
    /// Whether all numbers are finite and within the bounds of one contact's effect.
    pub(super) fn is_bounded(&self) -> bool {
        let all_within = |numbers: &[f64; STATES]| numbers.iter().all(|one| one.abs() <= ROW_AND_GAIN_MAX);
        self.residual.abs() <= RESIDUAL_MAX
            && VARIANCES.contains(&self.variance)
            && VARIANCES.contains(&self.noise_variance)
            && self.predicted_sensitivity_per_mm.is_finite()
            && all_within(&self.row)
            && all_within(&self.gain)
    }
}
