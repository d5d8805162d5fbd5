//! Estimation of a whisker's state from contacts: log sensitivity against the model's, and from that offset and
//! length; from many contacts also the whisker's own calibration.
//!
//! Knows numbers, not robots. [`noise`] gives the uncertainty of one contact and [`outlier`] its density.
//! [`spread`] expects the true contact ratio behind a stated one, [`temperature`] follows the thermometer. [`filter`] is the Kalman filter over (offset, offset's slope, log length, baseline, temperature coefficient, curvature). [`bins`] averages responses
//! by contact ratio, [`smooth`] fits a curve to them, [`own_calibration`] compares them between pressures,
//! [`uncertainty`] gives the uncertainty of Eq. 35 over the cases of [`cubature`]. [`trend`] fits lines to long series;
//! [`erosion`] and [`leak`] use it, and [`refill`] detects a regulator that refills a leak.

mod air_habit;
pub mod bins;
pub mod cubature;
pub mod erosion;
mod exponential;
mod fast_math;
pub mod filter;
pub mod gain_walk;
mod innovation;
pub mod leak;
mod leak_test;
pub mod length_evidence;
pub mod noise;
pub mod outlier;
pub mod own_calibration;
mod pool;
mod pressure_track;
pub mod reach;
pub mod refill;
mod sealed_interval;
pub mod smooth;
pub mod spread;
mod symmetric;
pub mod temperature;
pub mod trend;
pub mod uncertainty;

pub use bins::{Bin, ResponseBins, Waiting};
pub use erosion::{ContactsLeft, Erosion, ErosionWatch};
pub use filter::{Innovation, LengthEstimate, LengthFilter};
pub use gain_walk::GainWalks;
pub use leak::{LeakParams, LeakWatch};
pub use length_evidence::{ApparentLength, LengthEvidence, LengthPosterior};
pub use noise::{NoiseScale, SensorNoise};
pub use outlier::InnovationDensity;
pub use own_calibration::{Belief, Nominal, OwnCalibration, Visit, Weights};
pub use reach::Reach;
pub use smooth::{Carried, Smooth};
pub use spread::RatioSpread;
pub use temperature::{Temperatures, Warmth};
pub use trend::{Interval, Trend};

/// 1.96: half the width of a 95 % interval, in standard deviations.
pub const Z95: f64 = 1.959_963_985;
