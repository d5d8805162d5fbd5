//! Physics of one whisker: the strain of its gauge at each contact.
//!
//! The true whisker has its own calibration, slightly different from the built-in one, and
//! [`Formulation::Consistent`] unless the scenario states otherwise. So an estimator with the built-in calibration
//! has the same errors as with real whiskers.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use vibrissa_core::mechanics::{Calibration, ContactOnChamber, Formulation, Model, ModelError};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};
use vibrissa_protocol::Gauge;

use crate::places::{Places, Touch};
use crate::random::normal;
use crate::scenario::{Noise, Rubber, TrueFormulation};

/// Smallest contact ratio of simulated contacts; the largest is 1, the tip.
pub const RATIO_MIN: f64 = 0.45;
/// Smallest and largest deflection of a contact, in mm.
pub const DEFLECTION_MM: (f64, f64) = (0.2, 6.0);
/// Largest strain that the gauge's amplifier can read, in m/m, unless the scenario states another one.
pub const FULL_SCALE_STRAIN: f64 = 0.5;
/// Initial temperature, in degrees Celsius.
pub const TEMPERATURE_C: f64 = 24.0;

/// True state of one whisker.
#[derive(Debug)]
pub struct Plant {
    rubber: Rubber,
    /// Mechanics without deviations.
    designed: Model,
    model: Model,
    whole_length_mm: f64,
    whole_pressure_mpa: f64,
    length_mm: f64,
    contacts: u64,
    changes: Vec<LengthChange>,
    erosion: Option<Erosion>,
    gauge: GaugeCondition,
    /// Largest strain that the gauge's amplifier reads, in m/m.
    full_scale_strain: f64,
    baseline: Baseline,
    deflection_factor: f64,
    sensitivity_factor: f64,
    temperature_c: f64,
    noise: Noise,
    contact_stream: ChaCha8Rng,
    /// Contact ratio of all contacts; none if they are at random ones.
    fixed_ratio: Option<f64>,
    noise_stream: ChaCha8Rng,
    test_stream: ChaCha8Rng,
}

/// A change of a whisker's length, or the start of a gradual one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LengthChange {
    /// Time of the change, in microseconds since 1970 UTC by the robot's clock.
    pub t_us: u64,
    /// Index (from 0) of the first contact after the change.
    pub contact: u64,
    /// Final length, in mm.
    pub length_mm: f64,
    /// Whether the whisker wears gradually from here on.
    pub gradual: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Erosion {
    rate_mm_per_contact: f64,
    until_length_mm: f64,
}

/// Zero offset of the gauge and its drift.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Baseline {
    strain: f64,
    strain_per_contact: f64,
    until_strain: f64,
}

/// Fault of the gauge, if any.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "SCREAMING_SNAKE_CASE", deny_unknown_fields)]
pub(crate) enum GaugeCondition {
    Ok,
    Open,
    Short,
    Saturated { limit_strain: f64 },
}

/// Readings of one contact, except the pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Contact ratio, above 0 and at most 1.
    pub ratio: f64,
    /// Deflection in mm, above 0.
    pub deflection_mm: f64,
    /// Mean strain over the gauge grid, in m/m.
    pub strain: f64,
    /// Temperature in degrees Celsius.
    pub temperature_c: f64,
}

/// Source of a whisker's true calibration.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Truth {
    /// Given by the scenario.
    Known(Rubber),
    /// Random, within this relative error.
    Within(f64),
}

/// Independent random streams of one whisker.
pub(crate) struct Streams {
    pub(crate) calibration: ChaCha8Rng,
    pub(crate) contact: ChaCha8Rng,
    pub(crate) noise: ChaCha8Rng,
    pub(crate) test: ChaCha8Rng,
}

impl Plant {
    /// A whole whisker at its nominal pressure.
    ///
    /// # Errors
    /// Its calibration is invalid, which the permitted ranges of a scenario exclude.
    pub(crate) fn new(
        designed: Model,
        length_mm: f64,
        pressure_mpa: f64,
        truth: Truth,
        noise: Noise,
        mut streams: Streams,
    ) -> Result<Self, ModelError> {
        let rubber = match truth {
            Truth::Known(rubber) => rubber,
            Truth::Within(error) => drawn(error, &mut streams.calibration),
        };
        Ok(Self {
            rubber,
            model: rubber.model(&designed)?,
            designed,
            whole_length_mm: length_mm,
            whole_pressure_mpa: pressure_mpa,
            length_mm,
            contacts: 0,
            changes: Vec::new(),
            erosion: None,
            gauge: GaugeCondition::Ok,
            full_scale_strain: FULL_SCALE_STRAIN,
            baseline: Baseline::default(),
            deflection_factor: 1.0,
            sensitivity_factor: 1.0,
            temperature_c: TEMPERATURE_C,
            noise,
            contact_stream: streams.contact,
            fixed_ratio: None,
            noise_stream: streams.noise,
            test_stream: streams.test,
        })
    }

    /// The same plant with an amplifier that ends at this strain, in m/m.
    pub(crate) fn with_full_scale(self, full_scale_strain: f64) -> Self {
        Self { full_scale_strain, ..self }
    }

    /// Makes a contact at a random ratio of the present length while the chamber has the given true pressure.
    ///
    /// # Errors
    /// The contact would lie on the chamber, where the model is invalid; it still counts as a contact.
    pub(crate) fn touch(&mut self, pressure_mpa: f64) -> Result<Reading, ContactOnChamber> {
        let made = self.touch_at(Places::Ratio, pressure_mpa)?;
        Ok(made.map(|(reading, _)| reading).expect("a ratio of the present length is on the whisker"))
    }

    /// Makes each further contact at this ratio of the length at installation; `None`: at random ones.
    pub(crate) fn touch_at_place(&mut self, ratio: Option<f64>) {
        self.fixed_ratio = ratio;
    }

    /// Makes a contact where objects stand for robots with such places; `None` if the object is beyond the tip.
    ///
    /// # Errors
    /// The contact would lie on the chamber, where the model is invalid; it still counts as a contact.
    pub(crate) fn touch_at(
        &mut self,
        places: Places,
        pressure_mpa: f64,
    ) -> Result<Option<(Reading, Touch)>, ContactOnChamber> {
        // Each contact takes the same number of draws, so that an event never shifts the random numbers of later
        // contacts.
        let drawn = self.contact_stream.random_range(RATIO_MIN..=1.0);
        let deflection_mm = self.contact_stream.random_range(DEFLECTION_MM.0..=DEFLECTION_MM.1);
        let errors: [f64; 4] = std::array::from_fn(|_| normal(&mut self.noise_stream, 1.0));
        let drawn = self.fixed_ratio.unwrap_or(drawn);
        let Some(ratio) = places.ratio(drawn, self.length_mm, self.whole_length_mm) else { return Ok(None) };
        let touch = Touch {
            ratio,
            ratio_error: self.noise.ratio * errors[3],
            ratio_sd: self.noise.ratio,
            length_mm: self.length_mm,
            whole_length_mm: self.whole_length_mm,
        };
        let sensitivity_per_mm = self.sensitivity_per_mm(ratio, pressure_mpa);
        let baseline_strain = self.baseline.strain;
        self.contacts += 1;
        self.wear();

        let strain = sensitivity_per_mm? * deflection_mm * (1.0 + self.noise.strain_relative * errors[0])
            + self.noise.strain_floor * errors[1]
            + baseline_strain;
        let deflection_mm = self.deflection_factor * deflection_mm * (1.0 + self.noise.deflection_relative * errors[2]);
        let reading = Reading {
            ratio: rounded(ratio + touch.ratio_error, 1e4).clamp(0.01, 1.0),
            deflection_mm: rounded(deflection_mm, 1e4).clamp(0.01, 1000.0),
            strain: rounded(self.gauge.reads(strain, self.noise.strain_floor * errors[1], self.full_scale_strain), 1e8),
            temperature_c: self.temperature_c,
        };
        Ok(Some((reading, touch)))
    }

    /// One contact on request, at a distance from the base or at the tip, and at a deflection in mm or a random one. `None`
    /// if the whisker does not reach so far.
    ///
    /// # Errors
    /// The contact would lie on the chamber, where the model is invalid.
    pub(crate) fn touch_on_request(
        &mut self,
        distance_mm: Option<f64>,
        deflection_mm: Option<f64>,
        pressure_mpa: f64,
    ) -> Result<Option<(Reading, Touch)>, ContactOnChamber> {
        let drawn_mm = self.test_stream.random_range(DEFLECTION_MM.0..=DEFLECTION_MM.1);
        let errors: [f64; 5] = std::array::from_fn(|_| normal(&mut self.test_stream, 1.0));
        // The robot misses its distance by as much as it measures it wrong.
        let missed_by_mm = self.distance_sd_mm() * errors[4];
        let ratio = distance_mm.map_or(1.0, |mm| (mm + missed_by_mm) / self.length_mm);
        if ratio > 1.0 {
            return Ok(None);
        }
        let error = if distance_mm.is_some() { -missed_by_mm / self.length_mm } else { self.noise.ratio * errors[3] };
        let touch = Touch {
            ratio,
            ratio_error: error,
            ratio_sd: self.noise.ratio,
            length_mm: self.length_mm,
            whole_length_mm: self.whole_length_mm,
        };
        let deflection_mm = deflection_mm.unwrap_or(drawn_mm);
        let strain = self.sensitivity_per_mm(ratio, pressure_mpa)?
            * deflection_mm
            * (1.0 + self.noise.strain_relative * errors[0])
            + self.noise.strain_floor * errors[1]
            + self.baseline.strain;
        let deflection_mm = self.deflection_factor * deflection_mm * (1.0 + self.noise.deflection_relative * errors[2]);
        let reading = Reading {
            ratio: rounded(ratio, 1e4).clamp(0.01, 1.0),
            deflection_mm: rounded(deflection_mm, 1e4).clamp(0.01, 1000.0),
            strain: rounded(self.gauge.reads(strain, self.noise.strain_floor * errors[1], self.full_scale_strain), 1e8),
            temperature_c: self.temperature_c,
        };
        Ok(Some((reading, touch)))
    }

    /// Standard deviation of the robot's distances, mm.
    pub(crate) fn distance_sd_mm(&self) -> f64 {
        (self.noise.ratio * self.whole_length_mm).max(0.01)
    }

    fn wear(&mut self) {
        if let Some(erosion) = self.erosion {
            let worn_mm = (self.length_mm - erosion.rate_mm_per_contact).max(erosion.until_length_mm);
            self.length_mm = self.length_mm.min(worn_mm);
        }
        self.baseline.wander();
    }

    /// Cuts the whisker; a length above the present one has no effect.
    pub(crate) fn trim(&mut self, t_us: u64, length_mm: f64) {
        self.length_mm = self.length_mm.min(length_mm);
        self.erosion = None;
        self.record(t_us, self.length_mm, false);
    }

    /// Starts erosion: each contact removes some length.
    pub(crate) fn erode(&mut self, t_us: u64, rate_mm_per_contact: f64, until_length_mm: f64) {
        self.erosion = Some(Erosion { rate_mm_per_contact, until_length_mm });
        self.record(t_us, until_length_mm, true);
    }

    /// Installs a new whisker of the same rubber, with its first length and a new gauge.
    pub(crate) fn replace(&mut self, t_us: u64) {
        self.length_mm = self.whole_length_mm;
        self.erosion = None;
        self.gauge = GaugeCondition::Ok;
        self.baseline = Baseline::default();
        self.record(t_us, self.length_mm, false);
    }

    fn record(&mut self, t_us: u64, length_mm: f64, gradual: bool) {
        self.changes.push(LengthChange { t_us, contact: self.contacts, length_mm, gradual });
    }

    /// Starts a drift: each contact moves the gauge's zero until it reaches the limit.
    pub(crate) fn drift(&mut self, strain_per_contact: f64, until_strain: f64) {
        self.baseline.strain_per_contact = strain_per_contact;
        self.baseline.until_strain = until_strain;
    }

    pub(crate) fn set_deflection_factor(&mut self, factor: f64) {
        self.deflection_factor = factor;
    }

    /// Strain that the gauge reads without contact, in m/m.
    #[must_use]
    pub fn baseline_strain(&self) -> f64 {
        self.baseline.strain
    }

    pub(crate) fn set_gauge(&mut self, gauge: GaugeCondition) {
        self.gauge = gauge;
    }

    pub(crate) fn set_temperature(&mut self, sensitivity_factor: f64, temperature_c: f64) {
        self.sensitivity_factor = sensitivity_factor;
        self.temperature_c = temperature_c;
    }

    /// Present true strain per mm of deflection, at a contact ratio and a pressure in MPa.
    ///
    /// # Errors
    /// The contact would lie on the chamber, where the model is invalid.
    pub fn sensitivity_per_mm(&self, ratio: f64, pressure_mpa: f64) -> Result<f64, ContactOnChamber> {
        self.sensitivity_of(ratio, self.length_mm, pressure_mpa)
    }

    /// True strain per mm of deflection of the whisker as installed: at its first length and nominal pressure, and
    /// at the present temperature.
    ///
    /// # Errors
    /// The contact would lie on the chamber, where the model is invalid.
    pub fn whole_sensitivity_per_mm(&self, ratio: f64) -> Result<f64, ContactOnChamber> {
        self.sensitivity_of(ratio, self.whole_length_mm, self.whole_pressure_mpa)
    }

    fn sensitivity_of(&self, ratio: f64, length_mm: f64, pressure_mpa: f64) -> Result<f64, ContactOnChamber> {
        let ratio = ContactRatio::known(ratio.clamp(1e-9, 1.0));
        let morphology = self.model.morphology(Megapascal::known(pressure_mpa.clamp(0.0, 1.0)));
        let per_mm = self.model.sensitivity_per_mm(ratio, Millimetre::known(length_mm), &morphology)?;
        Ok(per_mm * self.sensitivity_factor)
    }

    /// Present length without the chamber's elongation, in mm.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        self.length_mm
    }

    /// Length at installation, in mm.
    #[must_use]
    pub fn whole_length_mm(&self) -> f64 {
        self.whole_length_mm
    }

    /// Nominal pressure, in MPa.
    #[must_use]
    pub fn whole_pressure_mpa(&self) -> f64 {
        self.whole_pressure_mpa
    }

    /// Number of contacts made so far.
    #[must_use]
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Changes of the length, in chronological order.
    #[must_use]
    pub fn changes(&self) -> &[LengthChange] {
        &self.changes
    }

    /// True model of the whisker, with its own calibration.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Present temperature, in degrees Celsius.
    #[must_use]
    pub fn temperature_c(&self) -> f64 {
        self.temperature_c
    }

    /// Condition of the gauge as the robot detects it.
    #[must_use]
    pub fn gauge(&self) -> Gauge {
        match self.gauge {
            GaugeCondition::Ok => Gauge::Ok,
            GaugeCondition::Open => Gauge::Open,
            GaugeCondition::Short => Gauge::Short,
            GaugeCondition::Saturated { .. } => Gauge::Saturated,
        }
    }
}

impl Baseline {
    fn wander(&mut self) {
        let left = self.until_strain - self.strain;
        if left * self.strain_per_contact > 0.0 {
            self.strain += self.strain_per_contact.abs().min(left.abs()).copysign(left);
        }
    }
}

impl GaugeCondition {
    /// Strain that the gauge reads for a true strain.
    fn reads(self, strain: f64, noise: f64, full_scale_strain: f64) -> f64 {
        let limit = match self {
            Self::Ok => full_scale_strain,
            Self::Open => return full_scale_strain,
            Self::Short => return noise,
            Self::Saturated { limit_strain } => limit_strain.min(full_scale_strain),
        };
        strain.clamp(-limit, limit)
    }
}

/// A random factor on each parameter of the calibration.
fn drawn(error: f64, stream: &mut ChaCha8Rng) -> Rubber {
    let mut factor = || 1.0 + stream.random_range(-1.0..=1.0) * error;
    Rubber { c: factor(), a: factor(), b: factor(), elongation: factor(), formulation: TrueFormulation::Consistent }
}

impl Rubber {
    /// Mechanics of a whisker made of this rubber, which deviates from the designed one.
    ///
    /// # Errors
    /// The factors are invalid, which the permitted ranges of a scenario exclude.
    pub fn model(&self, designed: &Model) -> Result<Model, ModelError> {
        let of = designed.calibration();
        let calibration = Calibration {
            c: of.c * self.c,
            a: of.a * self.a,
            b_per_mpa: of.b_per_mpa * self.b,
            youngs_modulus_mpa: of.youngs_modulus_mpa,
            elongation_gain_mm: of.elongation_gain_mm * self.elongation,
        };
        let formulation = match self.formulation {
            TrueFormulation::Published => Formulation::Published,
            TrueFormulation::Consistent => Formulation::Consistent,
        };
        Model::new(*designed.geometry(), calibration, formulation)
    }
}

/// Rounds to multiples of 1 / `per_unit`, like a sensor's digits; this also shortens messages.
fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}

mod state;

pub(crate) use state::PlantState;

#[cfg(test)]
mod tests;
