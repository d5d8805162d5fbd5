//! Contacts messages, assembled from precomputed pieces.
//!
//! Readings of whole whiskers are drawn from readings that a [`Plant`] made in advance with the simulator's noise.
//! The robot and the sequence number determine the readings of a message, so that the same message can be written
//! again. Cut whiskers have a plant of their own, see [`super::cuts`].

use std::io::Write;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{Formulation, Model, ModelError};

use super::plan::LoadPlan;
use crate::plant::{Plant, Reading, Streams, Truth};
use crate::random::{Purpose, normal, stream};
use crate::scenario::{Noise, Rubber, WhiskerScenario};

/// Number of precomputed readings.
const READINGS: usize = 16_384;
/// Noise of a chamber's pressure sensor (standard deviation), in MPa.
const PRESSURE_NOISE_MPA: f64 = 0.0003;

/// Precomputed pieces of the messages of one fleet.
#[derive(Debug)]
pub struct Texts {
    boot_id: String,
    /// The start of each whisker's contact, up to the time; the same for all robots.
    places: Vec<Vec<u8>>,
    /// The rest of a contact, after the time.
    readings: Vec<Vec<u8>>,
}

impl Texts {
    /// The pieces for a plan, with one boot id for all robots.
    ///
    /// # Errors
    /// The mechanics of the whiskers are invalid; cannot happen.
    pub fn new(plan: &LoadPlan, boot_id: &str) -> Result<Self, ModelError> {
        let place = |whisker| {
            let (array, number) = plan.place(whisker);
            format!(r#"{{"array":"{array}","whisker":{number},"t_us":"#).into_bytes()
        };
        let mut touching = Touching::new("", 0)?;
        Ok(Self {
            boot_id: boot_id.to_owned(),
            places: (0..plan.whiskers).map(place).collect(),
            readings: (0..READINGS).map(|_| touching.touch()).collect(),
        })
    }

    /// Writes an ordinary contacts message of a robot; its contacts cycle through the robot's whiskers.
    pub fn ordinary(&self, out: &mut Vec<u8>, (robot, seq): (usize, u64), felt_us: u64, contacts: usize) {
        self.head(out, seq);
        for position in 0..contacts {
            let number = seq * contacts as u64 + position as u64;
            let whisker = (number % self.places.len() as u64) as usize;
            let reading = mixed((robot as u64) << 40 ^ number) as usize % self.readings.len();
            // In chronological order; the last contact is the newest.
            let felt_us = felt_us - (contacts - 1 - position) as u64;
            self.contact(out, position, whisker, felt_us, &self.readings[reading]);
        }
        out.extend_from_slice(b"]}");
    }

    /// Writes a message with one contact and a given reading.
    pub fn single(&self, out: &mut Vec<u8>, seq: u64, whisker: usize, felt_us: u64, reading: &[u8]) {
        self.head(out, seq);
        self.contact(out, 0, whisker, felt_us, reading);
        out.extend_from_slice(b"]}");
    }

    fn head(&self, out: &mut Vec<u8>, seq: u64) {
        out.extend_from_slice(br#"{"boot_id":""#);
        out.extend_from_slice(self.boot_id.as_bytes());
        out.extend_from_slice(br#"","seq":"#);
        decimal(out, seq);
        out.extend_from_slice(br#","contacts":["#);
    }

    fn contact(&self, out: &mut Vec<u8>, position: usize, whisker: usize, felt_us: u64, reading: &[u8]) {
        if position > 0 {
            out.push(b',');
        }
        out.extend_from_slice(&self.places[whisker]);
        decimal(out, felt_us);
        out.extend_from_slice(reading);
    }
}

/// A simulated whisker with its chamber.
#[derive(Debug)]
pub struct Touching {
    plant: Plant,
    pressure_mpa: f64,
    sensor: ChaCha8Rng,
}

impl Touching {
    /// A whole whisker; all whiskers of the load have the same rubber.
    ///
    /// # Errors
    /// The mechanics are invalid; cannot happen.
    pub fn new(robot: &str, whisker: u16) -> Result<Self, ModelError> {
        let stream = |purpose| stream(0, robot, "", whisker, purpose);
        let streams = Streams {
            calibration: stream(Purpose::Calibration),
            contact: stream(Purpose::Contact),
            noise: stream(Purpose::Noise),
            test: stream(Purpose::Test),
        };
        let WhiskerScenario { length_mm, pressure_mpa, .. } = WhiskerScenario::default();
        let truth = Truth::Known(Rubber::default());
        let plant = Plant::new(
            Model::nguyen_2021(Formulation::Consistent),
            length_mm,
            pressure_mpa,
            truth,
            Noise::default(),
            streams,
        )?;
        let sensor = ChaCha8Rng::from_rng(&mut stream(Purpose::Regulator));
        Ok(Self { plant, pressure_mpa, sensor })
    }

    /// Cuts the whisker.
    pub fn trim(&mut self, now_us: u64, length_mm: f64) {
        self.plant.trim(now_us, length_mm);
    }

    /// Sets the chamber's pressure.
    pub fn set_pressure(&mut self, pressure_mpa: f64) {
        self.pressure_mpa = pressure_mpa;
    }

    /// The encoded reading of the next contact, after its time.
    pub fn touch(&mut self) -> Vec<u8> {
        loop {
            // The gauge cannot measure a contact on the chamber.
            let Ok(reading) = self.plant.touch(self.pressure_mpa) else { continue };
            let Reading { ratio, deflection_mm, strain, temperature_c } = reading;
            let pressure_mpa = (self.pressure_mpa + normal(&mut self.sensor, PRESSURE_NOISE_MPA)).max(0.0);
            return format!(
                r#","ratio":{ratio},"deflection_mm":{deflection_mm},"strain":{strain:.8},"pressure_mpa":{pressure_mpa:.4},"temperature_c":{temperature_c:.1}}}"#
            )
            .into_bytes();
        }
    }
}

/// Appends a number in decimal.
fn decimal(out: &mut Vec<u8>, number: u64) {
    // Writing to memory cannot fail.
    let _ = write!(out, "{number}");
}

/// A pseudo-random number (the finaliser of SplitMix64): the results of neighbours differ in half of all bits.
fn mixed(number: u64) -> u64 {
    let number = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let number = (number ^ number >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ number >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ number >> 31
}
