//! One whisker with its chamber and the robot's knowledge of it.

use std::collections::VecDeque;

use vibrissa_core::mechanics::{ContactOnChamber, ModelError};
use vibrissa_protocol::{Gauge, Name, Regulator as Condition, WhiskerStatus};
use vibrissa_robot::contract::ReadingGain;

use super::RobotConfig;
use crate::plant::{FULL_SCALE_STRAIN, LengthChange, Plant, Streams, Truth};
use crate::random::{Purpose, stream};
use crate::regulator::Regulator;
use crate::scenario::{ArrayScenario, Change, WhiskerScenario};

/// Slew of pressure changes without a command, in MPa/s.
pub(super) const OWN_SLEW_MPA_PER_S: f64 = 0.02;

/// One whisker of a robot.
#[derive(Debug)]
pub struct Whisker {
    array: Name,
    facts: WhiskerScenario,
    pub(crate) plant: Plant,
    pub(crate) regulator: Regulator,
    pub(crate) leak_mpa_per_s: f64,
    /// Until this time by the robot's clock, the robot sends nothing about the whisker.
    pub(super) silent_until_us: u64,
    /// Whether the robot detects a leak or a broken gauge.
    notices_faults: bool,
    /// Highest (epoch, version) seen for the whisker in this boot.
    pub(super) seen: Option<(u64, u64)>,
    /// Length of the newest estimate, mm.
    pub(super) estimated_mm: Option<f64>,
    /// Factor on the readings, which the robot uses only if it applies gains.
    pub(super) gain: ReadingGain,
    applies_gain: bool,
    /// The setpoint that is being applied.
    pub(super) applying: Option<Applying>,
    /// Events by number of contacts, in order.
    pub(super) events: VecDeque<(u64, Change)>,
    /// Condition in the last status.
    pub(super) reported: (Condition, Gauge),
}

/// A setpoint that is being applied.
#[derive(Debug)]
pub(super) struct Applying {
    pub(super) command_id: String,
    pub(super) pressure_mpa: f64,
    pub(super) reading_gain: Option<f64>,
    pub(super) fails_at_us: u64,
}

impl Whisker {
    pub(crate) fn new(
        config: &RobotConfig,
        array: &ArrayScenario,
        facts: &WhiskerScenario,
        seed: u64,
    ) -> Result<Self, ModelError> {
        let stream = |purpose| stream(seed, config.robot.robot.as_str(), array.array.as_str(), facts.whisker, purpose);
        let streams = Streams {
            calibration: stream(Purpose::Calibration),
            contact: stream(Purpose::Contact),
            noise: stream(Purpose::Noise),
            test: stream(Purpose::Test),
        };
        Ok(Self {
            array: array.array.clone(),
            plant: Plant::new(
                config.model.clone(),
                facts.length_mm,
                facts.pressure_mpa,
                facts.rubber.map_or(Truth::Within(config.calibration_error), Truth::Known),
                config.noise.clone(),
                streams,
            )?
            .with_full_scale(facts.strain_max.unwrap_or(FULL_SCALE_STRAIN)),
            regulator: Regulator::new(facts.pressure_mpa, stream(Purpose::Regulator)),
            facts: facts.clone(),
            leak_mpa_per_s: 0.0,
            silent_until_us: 0,
            notices_faults: config.behaviour.notices_faults,
            seen: None,
            estimated_mm: None,
            gain: ReadingGain::new(facts.pressure_mpa),
            applies_gain: config.robot.applies_gain,
            applying: None,
            events: VecDeque::new(),
            reported: (Condition::Ok, Gauge::Ok),
        })
    }

    /// Resets everything except the whisker itself, as after a restart.
    pub(super) fn restart(&mut self) {
        self.seen = None;
        self.estimated_mm = None;
        self.gain = ReadingGain::new(self.facts.pressure_mpa);
        self.applying = None;
        self.regulator.set(self.facts.pressure_mpa, OWN_SLEW_MPA_PER_S);
    }

    /// Condition of regulator and gauge as the robot detects it.
    pub(super) fn condition(&self) -> (Condition, Gauge) {
        match (self.notices_faults, self.regulator.condition()) {
            (true, regulator) => (regulator, self.plant.gauge()),
            (false, Condition::Leak) => (Condition::Ok, Gauge::Ok),
            (false, regulator) => (regulator, Gauge::Ok),
        }
    }

    pub(super) fn is_silent(&self, at_us: u64) -> bool {
        at_us < self.silent_until_us
    }

    pub(super) fn status(&self) -> WhiskerStatus {
        let (regulator, gauge) = self.condition();
        WhiskerStatus {
            array: self.array.clone(),
            whisker: self.facts.whisker,
            pressure_mpa: self.regulator.reading_mpa(),
            setpoint_mpa: self.regulator.target_mpa(),
            regulator,
            gauge,
            segmenter: None,
        }
    }

    /// Array of the whisker.
    #[must_use]
    pub fn array(&self) -> &Name {
        &self.array
    }

    /// Number of the whisker in its array.
    #[must_use]
    pub fn number(&self) -> u16 {
        self.facts.whisker
    }

    /// Properties of the whisker as installed.
    #[must_use]
    pub fn facts(&self) -> &WhiskerScenario {
        &self.facts
    }

    /// Present length as the supervisor told the robot in this boot, in mm; `None` before the first estimate.
    #[must_use]
    pub fn estimated_length_mm(&self) -> Option<f64> {
        self.estimated_mm
    }

    /// Factor by which the robot multiplies the whisker's readings now; 1 for a robot that applies no gain.
    #[must_use]
    pub fn reading_gain(&self) -> f64 {
        if self.applies_gain { self.gain.factor() } else { 1.0 }
    }

    /// Takes the supervisor's estimate of the length, in mm.
    pub(crate) fn learn_length(&mut self, length_mm: f64) {
        self.estimated_mm = Some(length_mm);
    }

    /// Physics of the whisker.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Regulator of the chamber.
    #[must_use]
    pub fn regulator(&self) -> &Regulator {
        &self.regulator
    }

    /// Changes of the length, in chronological order.
    #[must_use]
    pub fn changes(&self) -> &[LengthChange] {
        self.plant.changes()
    }

    /// Present true strain per mm of deflection, at the chamber's true pressure.
    ///
    /// # Errors
    /// The contact would lie on the chamber, where the model is invalid.
    pub fn sensitivity_per_mm(&self, ratio: f64) -> Result<f64, ContactOnChamber> {
        self.plant.sensitivity_per_mm(ratio, self.regulator.pressure_mpa())
    }
}
