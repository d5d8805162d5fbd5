//! 95 % intervals of estimates.

use vibrissa_core::estimation::LengthEstimate;
pub use vibrissa_core::estimation::Z95;

/// The 95 % interval of a length, in mm.
#[must_use]
pub fn length_interval_mm(estimate: &LengthEstimate) -> (f64, f64) {
    let half = Z95 * estimate.sd_mm;
    ((estimate.length.mm() - half).max(0.0), estimate.length.mm() + half)
}
