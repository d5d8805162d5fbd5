//! What one contact says about a whisker: log sensitivity against the model's, hence offset and length.
//!
//! Knows numbers, not robots. [`noise`] says how uncertain one contact is and [`outlier`] what its density
//! is, [`filter`] is the Kalman filter over (offset, offset's slope, log length, baseline), [`bins`] averages
//! responses by contact ratio.

pub mod bins;
pub mod filter;
pub mod noise;
pub mod outlier;

pub use bins::{Bin, ResponseBins};
pub use filter::{Innovation, LengthEstimate, LengthFilter};
pub use noise::{NoiseScale, SensorNoise};
pub use outlier::InnovationDensity;
