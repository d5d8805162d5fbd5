//! What one contact says about a whisker: log sensitivity against the model's, hence offset and length; and what
//! many say about its own calibration.
//!
//! Knows numbers, not robots. [`noise`] says how uncertain one contact is and [`outlier`] what its density
//! is, [`filter`] is the Kalman filter over (offset, offset's slope, log length, baseline), [`bins`] averages
//! responses by contact ratio, [`smooth`] draws a curve through them, [`own_calibration`] compares them over
//! pressures, [`uncertainty`] tells how uncertain Eq. 35 is with all that, over the cases of [`cubature`]. [`trend`] fits lines to long series; [`erosion`] and
//! [`leak`] are such lines, and [`refill`] tells when a regulator makes a leak good.

pub mod bins;
pub mod cubature;
pub mod erosion;
mod exponential;
mod fast_math;
pub mod filter;
pub mod leak;
pub mod noise;
pub mod outlier;
pub mod own_calibration;
mod pool;
pub mod refill;
mod sealed_interval;
pub mod smooth;
mod symmetric;
pub mod trend;
pub mod uncertainty;

pub use bins::{Bin, ResponseBins, Waiting};
pub use cubature::CubatureCases;
pub use erosion::{ContactsLeft, Erosion, ErosionWatch};
pub use filter::{Innovation, LengthEstimate, LengthFilter};
pub use leak::{LeakParams, LeakWatch};
pub use noise::{NoiseScale, SensorNoise};
pub use outlier::InnovationDensity;
pub use own_calibration::{Belief, Nominal, OwnCalibration, Visit, Weights};
pub use smooth::{Carried, Smooth};
pub use trend::{Interval, Trend};
