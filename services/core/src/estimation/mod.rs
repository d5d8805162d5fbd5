//! What one contact says about a whisker: log sensitivity against the model's, hence offset and length.
//!
//! Knows numbers, not robots. [`noise`] says how uncertain one contact is and [`outlier`] what its density
//! is, [`filter`] is the Kalman filter over (offset, offset's slope, log length, baseline), [`bins`] averages
//! responses by contact ratio, [`trend`] fits lines to long series; [`erosion`] and [`leak`] are such lines,
//! and [`refill`] tells when a regulator makes a leak good.

pub mod bins;
pub mod erosion;
pub mod filter;
pub mod leak;
pub mod noise;
pub mod outlier;
pub mod refill;
pub mod trend;

pub use bins::{Bin, ResponseBins};
pub use erosion::{ContactsLeft, Erosion, ErosionWatch};
pub use filter::{Innovation, LengthEstimate, LengthFilter};
pub use leak::{LeakParams, LeakWatch};
pub use noise::{NoiseScale, SensorNoise};
pub use outlier::InnovationDensity;
pub use trend::{Interval, Trend};
