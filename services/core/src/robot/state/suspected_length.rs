//! The length that is told, with losses that the contacts may hide.
//!
//! The filter is far behind a change until a verdict moves it. Until then both lengths are possible: that before the change
//! and that after it. And a cut that is too small for a verdict is followed as a wandering of the gain, as far as the gain
//! wanders. Decisions wait for the verdict, so they take the filter's length.

use crate::estimation::LengthEstimate;
use crate::robot::state::whisker::Whisker;

/// Standard deviation as a share of the suspected loss: the interval of 95 % reaches to 1.6 times the loss. A loss contact by
/// contact is up to half larger than the step that is fitted to it.
const SUSPECTED_SHARE: f64 = 0.8;
/// Log likelihood that a step must gain before it is reported, about: that of the alarm or that over a gradual change.
const REPORTED_FROM: f64 = 10.0;
/// Standard deviation of the log sensitivity of one contact with the usual noise.
const USUAL_NOISE: f64 = 0.03;
/// Usual -d ln sensitivity / d ln length.
const USUAL_SLOPE: f64 = 2.1;

impl Whisker {
    /// A length as it is told: its interval holds the length after a suspected loss, and after one that the gain's wandering
    /// hides.
    pub(in crate::robot) fn told(&self, length: LengthEstimate) -> LengthEstimate {
        let is_suspicious = self.detector.is_suspicious();
        let fit = || self.detector.suspected_shift().or_else(|| self.detector.felt(-1.0));
        let suspected = is_suspicious.then(fit).flatten();
        let suspected = SUSPECTED_SHARE * suspected.map_or(0.0, |fit| (-fit.size).max(0.0));
        let loss_mm = suspected.hypot(self.hidden_loss()) * length.length.mm();
        LengthEstimate { sd_mm: length.sd_mm.hypot(loss_mm), ..length }
    }

    /// Log length that a cut may take without a report, while the gain wanders as it does.
    ///
    /// A filter of a random walk with rate r and noise s takes the share r / s of each deviation into the gain. So a step c is
    /// gone after about s / r contacts, which gain c^2 / (4 s r) of log likelihood.
    fn hidden_loss(&self) -> f64 {
        let noise = USUAL_NOISE * (self.noise.variance() * self.noise.inflation()).sqrt();
        (4.0 * REPORTED_FROM * noise * self.walks.shown_rate()).sqrt() / USUAL_SLOPE
    }
}
