//! What one contact says about a whisker: log sensitivity against the model's, hence offset and length; and what
//! many say about its own calibration.
//!
//! Knows numbers, not robots. [`noise`] says how uncertain one contact is and [`outlier`] what its density
//! is, [`filter`] is the Kalman filter over (offset, offset's slope, log length, baseline), [`bins`] averages
//! responses by contact ratio, [`smooth`] draws a curve through them, [`own_calibration`] compares them over
//! pressures, [`spread`] tells how uncertain Eq. 35 is with all that, over the cases of [`even`]. [`trend`] fits lines to long series; [`erosion`] and
//! [`leak`] are such lines, and [`refill`] tells when a regulator makes a leak good.

pub mod bins;
pub mod erosion;
pub mod even;
mod exponential;
pub mod filter;
pub mod leak;
pub mod noise;
pub mod outlier;
pub mod own_calibration;
mod pool;
pub mod refill;
mod single;
pub mod smooth;
pub mod spread;
mod stretch;
mod symmetric;
pub mod trend;

pub use bins::{Bin, ResponseBins, Waiting};
pub use erosion::{ContactsLeft, Erosion, ErosionWatch};
pub use even::EvenCases;
pub use filter::{Innovation, LengthEstimate, LengthFilter};
pub use leak::{LeakParams, LeakWatch};
pub use noise::{NoiseScale, SensorNoise};
pub use outlier::InnovationDensity;
pub use own_calibration::{Belief, Nominal, OwnCalibration, Visit, Weights};
pub use smooth::{Carried, Smooth};
pub use trend::{Interval, Trend};
