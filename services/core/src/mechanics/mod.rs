//! The paper's equations, from a whisker's shape to the pressure that gives it the sensitivity of another whisker.
//!
//! Equation and table numbers are those of "Mechanics and Morphological Compensation Strategy for Trimmed Soft
//! Whisker Sensor" (Nguyen and Ho). Lengths are in mm, pressures in MPa, strains in m/m.
//!
//! Read in this order: [`Geometry`] and [`Calibration`] (parameters of a whisker), [`Model`] (both, checked once),
//! [`Morphology`] (the chamber under pressure, Table 2), [`Response`] (strain caused by a deflection, eq. 10-17 and
//! 26-31), the two inverses [`Model::length_from_sensitivity`] and [`solve_setpoint`] (eq. 34), and
//! [`fit_bench`] (eq. 32-33, and readings of contacts).
//!
//! Where the paper has a misprint, the documentation of the item states the correction. In short: the strain is the
//! mean over the gauge grid (eq. 15-17 and 29-31 omit the division by its length e); eq. 3 means `L3`; the inner
//! diameter in Table 2 is the one at x = c; and a factor of eq. 27, 29 and 31 is printed without its superscript,
//! which leaves two readings: see [`Formulation`].
//!
//! The response to a contact at distance A from the base depends on A alone, not on the length of whisker beyond
//! it. So a trimmed whisker differs from an intact one at the same contact *ratio* a, not at the same distance.
//! Therefore sensitivities are compared at equal a, and a drift of the sensitivity at a known a measures the
//! length.

mod calibration;
mod family;
mod fit;
mod geometry;
mod length;
mod model;
mod model_error;
mod modulus;
mod morphology;
mod profile;
mod range;
pub(crate) mod root;
mod sensitivity;
mod setpoint;
mod taper;

pub use calibration::Calibration;
pub use family::{FAMILY, FAMILY_STEP, Family, LOG_MODULUS, LogChanges, OTHER_FORMULATION};
pub use fit::{
    Advice, BenchContact, BenchFit, BenchReading, CalibrationRow, Fit, FitError, Gauge, Given, Kind, Parameter, Place,
    Quantity, RowResidual, Scatter, UNKNOWNS, Unknown, fit_bench, fit_calibration, student_t,
};
pub use geometry::Geometry;
pub use length::{CutIntoChamber, LengthError};
pub use model::{Formulation, Model};
pub use model_error::ModelError;
pub use morphology::Morphology;
pub use profile::{
    ByRatio, CONTACT_RATIOS, EVEN_WEIGHTS, ErrorProfile, GainProfile, Offset, RatioWeights, UsualContacts,
    compensation_error,
};
pub use range::compensable_range;
pub use sensitivity::{ContactOnChamber, Response};
pub use setpoint::{
    Compensator, Deviation, Objective, Setpoint, Solution, Target, least_error, solve_setpoint, solve_setpoint_as_felt,
};
