//! The true whisker for the detection evaluation: contacts at random contact ratios with 5 % noise.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use vibrissa_core::mechanics::{Formulation, Model, Morphology};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

use crate::deviation::{deviating, with_calibration};

/// Range of the contact ratios.
pub const RATIOS: (f64, f64) = (0.45, 1.0);
/// Range of the deflections, mm.
pub const DEFLECTIONS_MM: (f64, f64) = (0.2, 6.0);
/// Length of a whole whisker, mm.
pub const WHOLE_MM: f64 = 70.0;
/// Standard deviation of the true whole length, mm.
pub const WHOLE_SD_MM: f64 = 0.1;
/// Chamber pressure, MPa.
pub const PRESSURE_MPA: f64 = 0.1;
/// Standard deviation of the log sensitivity of one contact.
pub const NOISE: f64 = 0.05;
/// Noise of an outlier, as a multiple of the normal noise.
pub const OUTLIER_FACTOR: f64 = 10.0;

/// One contact as the robot reads it, with a value for the oracle.
#[derive(Debug, Clone, Copy)]
pub struct Touch {
    /// Contact ratio a, above 0 and at most 1.
    pub ratio: ContactRatio,
    /// Deflection at the contact, mm.
    pub deflection_mm: f64,
    /// Measured strain, m/m.
    pub strain: f64,
    /// ln(measured / true whole sensitivity), without the outlier factor: without a guard of its own the oracle
    /// would take outliers for the change.
    pub log_deviation: f64,
}

/// A whisker whose parameters deviate from the model by up to `off`, in either formulation.
pub struct Plant {
    model: Model,
    morphology: Morphology,
    /// True length at installation, mm, close to the factsheet's.
    pub whole_mm: f64,
    /// Present length, mm.
    pub length_mm: f64,
    outliers: f64,
    random: ChaCha8Rng,
}

impl Plant {
    /// A whole whisker that deviates by at most `off` from the designed one. `outliers` is the share of contacts with ten times the noise.
    #[must_use]
    pub fn new(designed: &Model, seed: u64, off: f64, outliers: f64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let calibration =
            deviating(designed.calibration(), |value| value * (1.0 + off * random.random_range(-1.0..=1.0)));
        let formulation = if random.random() { Formulation::Published } else { Formulation::Consistent };
        let model = with_calibration(designed, calibration, formulation);
        let morphology = model.morphology(Megapascal::known(PRESSURE_MPA));
        let unit: f64 = StandardNormal.sample(&mut random);
        let whole_mm = WHOLE_MM + WHOLE_SD_MM * unit;
        Self { model, morphology, whole_mm, length_mm: whole_mm, outliers, random }
    }

    /// Makes the next contact.
    pub fn touch(&mut self) -> Touch {
        let ratio = ContactRatio::known((self.random.random_range(RATIOS.0..=RATIOS.1) * 1e4_f64).round() / 1e4);
        let deflection_mm = self.random.random_range(DEFLECTIONS_MM.0..=DEFLECTIONS_MM.1);
        let unit: f64 = StandardNormal.sample(&mut self.random);
        let outlier = self.random.random::<f64>() < self.outliers;
        let noise = NOISE * unit * if outlier { OUTLIER_FACTOR } else { 1.0 };
        let strain = self.per_mm(ratio, self.length_mm) * deflection_mm * noise.exp();
        let log_deviation = NOISE * unit + self.log_shift(ratio, self.length_mm);
        Touch { ratio, deflection_mm, strain, log_deviation }
    }

    /// ln(sensitivity at a length / at whole length).
    #[must_use]
    pub fn log_shift(&self, ratio: ContactRatio, length_mm: f64) -> f64 {
        (self.per_mm(ratio, length_mm) / self.per_mm(ratio, self.whole_mm)).ln()
    }

    fn per_mm(&self, ratio: ContactRatio, length_mm: f64) -> f64 {
        let length = Millimetre::known(length_mm);
        self.model.sensitivity_per_mm(ratio, length, &self.morphology).unwrap_or(f64::NAN)
    }
}
