//! The conditions on a shape and a calibration.

/// Why a shape and a calibration are invalid; the message names the failed condition.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A size or parameter is not finite or not above zero.
    #[error("{name} must be a number above 0, not {value}")]
    NotPositive {
        /// Name of the size or parameter in the paper.
        name: &'static str,
        /// The given value.
        value: f64,
    },
    /// A parameter is not finite or below zero.
    #[error("{name} must be a number not below 0, not {value}")]
    Negative {
        /// Name of the parameter in the paper.
        name: &'static str,
        /// The given value.
        value: f64,
    },
    /// Two sizes contradict each other.
    #[error("{0}")]
    Geometry(&'static str),
    /// At 0.2 MPa, the highest examined pressure, almost nothing of the wall would remain (Table 2's `t^q`).
    #[error(
        "at 0.2 MPa the chamber would stretch by {elongation_mm} mm and lose its wall: the elongation gain G is too large"
    )]
    WallVanishes {
        /// The elongation at 0.2 MPa, in mm.
        elongation_mm: f64,
    },
}
