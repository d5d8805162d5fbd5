//! The length that is told while a change is suspected.
//!
//! The filter is far behind a change until a verdict moves it. Until then both lengths are possible: that before the change
//! and that after it. Decisions wait for the verdict, so they take the filter's length.

use crate::estimation::LengthEstimate;
use crate::robot::state::whisker::Whisker;

/// Standard deviation as a share of the suspected loss: the interval of 95 % reaches to 1.6 times the loss. A loss contact by
/// contact is up to half larger than the step that is fitted to it.
const SUSPECTED_SHARE: f64 = 0.8;

impl Whisker {
    /// A length as it is told: its interval holds the length after a suspected loss, too.
    pub(in crate::robot) fn told(&self, length: LengthEstimate) -> LengthEstimate {
        let is_suspicious = self.detector.is_suspicious();
        let fit = || self.detector.suspected_shift().or_else(|| self.detector.felt(-1.0));
        let suspected = is_suspicious.then(fit).flatten();
        let loss_mm = suspected.map_or(0.0, |fit| (-fit.size).max(0.0) * length.length.mm());
        LengthEstimate { sd_mm: length.sd_mm.hypot(SUSPECTED_SHARE * loss_mm), ..length }
    }
}
