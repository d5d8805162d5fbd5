//! 95 % intervals of estimates.

use vibrissa_core::estimation::LengthEstimate;

/// 1.96: half the width of a 95 % interval, in standard deviations.
pub const Z95: f64 = 1.959_963_985;

/// The 95 % interval of a length, in mm.
#[must_use]
pub fn length_interval_mm(estimate: &LengthEstimate) -> (f64, f64) {
    let half = Z95 * estimate.sd_mm;
    ((estimate.length.mm() - half).max(0.0), estimate.length.mm() + half)
}
