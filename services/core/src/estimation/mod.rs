//! What one contact says about a whisker: log sensitivity against the model's, hence offset and length; and what
//! many say about its own calibration.
//!
//! Knows numbers, not robots. [`noise`] says how uncertain one contact is, [`filter`] is the Kalman
//! filter over (offset, offset's slope, log length), [`bins`] averages responses by contact ratio, [`smooth`]
//! draws a curve through them, [`own_calibration`] compares them over pressures, [`spread`] tells how uncertain
//! Eq. 35 is with all that.

pub mod bins;
pub mod filter;
pub mod noise;
pub mod own_calibration;
pub mod smooth;
pub mod spread;

pub use bins::{Bin, ResponseBins, Waiting};
pub use filter::{Innovation, LengthEstimate, LengthFilter};
pub use noise::{NoiseScale, SensorNoise};
pub use own_calibration::{Belief, Nominal, OwnCalibration, Visit, Weights};
pub use smooth::{Carried, Smooth};
