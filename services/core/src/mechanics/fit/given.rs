//! The given numbers of a fit, and the gauge that reads the strains.

use crate::mechanics::geometry::Geometry;
use crate::mechanics::model::Formulation;

/// The given numbers of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// Shape of the whisker.
    pub geometry: Geometry,
    /// Reading of the equations under pressure.
    pub formulation: Formulation,
    /// E in MPa; `None` to fit it, which needs readings of contacts.
    pub youngs_modulus_mpa: Option<f64>,
    /// Whether a factor on all strains is fitted; otherwise it is 1.
    pub fits_gauge_gain: bool,
}

/// Factor and offset of the gauge: `strain read = gain * strain + offset`. A contact's strain is a difference and has no
/// offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauge {
    /// Factor on all strains.
    pub gain: f64,
    /// Reading at zero pressure without contact, m/m.
    pub offset: f64,
}

impl Gauge {
    /// A gauge that reads true strains.
    pub const TRUE: Self = Self { gain: 1.0, offset: 0.0 };
}
