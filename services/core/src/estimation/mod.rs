//! What one contact says about a whisker: log sensitivity against the model's, hence offset and length.
//!
//! Knows numbers, not robots. [`noise`] says how uncertain one contact is, [`filter`] is the Kalman
//! filter over (offset, offset's slope, log length), [`bins`] averages responses by contact ratio, [`trend`] fits
//! lines to long series; [`erosion`] and [`leak`] are such lines,
//! and [`refill`] tells when a regulator makes a leak good.

pub mod bins;
pub mod erosion;
pub mod filter;
pub mod leak;
pub mod noise;
pub mod refill;
pub mod trend;

pub use bins::{Bin, ResponseBins};
pub use erosion::{ContactsLeft, Erosion, ErosionWatch};
pub use filter::{Innovation, LengthEstimate, LengthFilter};
pub use leak::{LeakParams, LeakWatch};
pub use noise::{NoiseScale, SensorNoise};
pub use trend::{Interval, Trend};
