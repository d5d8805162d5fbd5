//! The length that a filter states, with what no number of contacts tells of it.
//!
//! The filter's own uncertainty falls with each contact. Some errors are the same in all of them: that of the model, that of
//! the factory length, and another explanation that the contacts do not tell apart. They are added here, after the filter.

use super::{FilterParams, LENGTH, LengthFilter, OFFSET_SHARE, SLOPE};
use crate::estimation::Z95;
use crate::units::Millimetre;

/// Relative standard deviation of the model's d ln s / d ln L. Calibrations and formulations make 0.006, with the offset at
/// its distance from the base, and an error of 0.01 that all contact ratios share makes 0.014. Contacts cannot reduce it,
/// so every change of length keeps this uncertainty.
const MODEL_SLOPE_SD: f64 = 0.015;

/// Estimated length with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthEstimate {
    /// Estimated present length, mm.
    pub length: Millimetre,
    /// Standard deviation, mm.
    pub sd_mm: f64,
}

/// Uncertainty of the length that contacts do not reduce.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Untold {
    /// Least standard deviation of the length, mm; 0 for none.
    least_sd_mm: f32,
    /// Standard deviation of the whole length beyond that of the prior, mm.
    whole_sd_mm: f32,
}

impl LengthFilter {
    /// Present length with its standard deviation. The error of the factory length is a part of it.
    #[must_use]
    pub fn length(&self) -> LengthEstimate {
        let relative = self.relative_length();
        let by_whole = f64::from(self.untold.whole_sd_mm) * relative.length.mm() / self.whole_length_mm;
        LengthEstimate { sd_mm: relative.sd_mm.hypot(by_whole), ..relative }
    }

    /// [`Self::length`] as a share of the whole length, in mm of the factsheet. The error of the factory length is no part
    /// of it: it moves the lengths before and after a change alike, and no contact tells it. Decisions take this one.
    #[must_use]
    pub fn relative_length(&self) -> LengthEstimate {
        let learned = self.learned_length();
        LengthEstimate { sd_mm: learned.sd_mm.max(self.untold.least_sd_mm.into()), ..learned }
    }

    /// [`Self::relative_length`] without the doubt that contacts do not reduce.
    #[must_use]
    pub fn learned_length(&self) -> LengthEstimate {
        let log_length = self.log_length() * self.per_log();
        let length_mm = (self.whole_length_mm * log_length.exp()).clamp(1.0, 1000.0);
        let by_slope = OFFSET_SHARE * self.covariance.variance(SLOPE).max(0.0).sqrt();
        let by_model = MODEL_SLOPE_SD.hypot(by_slope) * log_length;
        let learned_sd = self.covariance.variance(LENGTH).max(0.0).sqrt() * self.per_log();
        LengthEstimate { length: Millimetre::known(length_mm), sd_mm: length_mm * learned_sd.hypot(by_model) }
    }

    /// The factsheet states the whole length within this, mm, with 95 % probability. The prior of the length is a part of it.
    pub fn keep_tolerance(&mut self, tolerance_mm: f64, params: &FilterParams) {
        self.keep_whole_sd(Self::whole_sd_of(tolerance_mm, params));
    }

    /// [`Self::whole_sd_mm`] for a tolerance of the factsheet.
    #[must_use]
    pub fn whole_sd_of(tolerance_mm: f64, params: &FilterParams) -> f32 {
        let variance = (tolerance_mm / Z95).powi(2) - params.length_mm.powi(2);
        if variance > 0.0 { variance.sqrt() as f32 } else { 0.0 }
    }

    /// Standard deviation of the whole length beyond that of the prior, mm.
    #[must_use]
    pub fn whole_sd_mm(&self) -> f32 {
        self.untold.whole_sd_mm
    }

    /// Sets [`Self::whole_sd_mm`].
    pub fn keep_whole_sd(&mut self, sd_mm: f32) {
        self.untold.whole_sd_mm = sd_mm;
    }

    /// The length itself was measured, in millimetres that share an error of this standard deviation, mm. Without such an error
    /// the length owes nothing to the factory length any more.
    pub fn measured_in(&mut self, shared_sd_mm: f64) {
        let factory_mm = f64::from(self.untold.whole_sd_mm);
        if factory_mm > 0.0 {
            self.keep_whole_sd((factory_mm * shared_sd_mm / factory_mm.hypot(shared_sd_mm)) as f32);
        }
    }

    /// Least standard deviation of the length, mm; 0 for none. Contacts do not reduce it.
    #[must_use]
    pub fn least_sd_mm(&self) -> f32 {
        self.untold.least_sd_mm
    }

    /// Two explanations differ by about this standard deviation of the length, mm, and contacts do not tell them apart, as
    /// they take errors that all of them share for independent noise. So no number of contacts makes the length more
    /// certain, until it is measured otherwise. 0 if nothing is in doubt.
    pub fn keep_doubt(&mut self, sd_mm: f64) {
        self.untold.least_sd_mm = if sd_mm.is_finite() { sd_mm.clamp(0.0, 1000.0) as f32 } else { 0.0 };
    }
}
