//! One whisker's chamber, as the agent knows it from the driver.

mod applying;
mod condition;

use std::collections::BTreeMap;

use vibrissa_protocol::{Gauge, Name, PlaceKind, Regulator, WhiskerFacts};
use vibrissa_regulator::{Command, Condition, Params};

use super::ABSENT_AFTER_US;
use super::gauge_watch::GaugeWatch;
use super::motion::Motion;
use super::partial::Partials;
use super::strain::Stream;
use crate::config::{DriverLimits, Sign, WhiskerConfig};
use crate::contract::{Moment, Now, ReadingGain, Response};
use crate::driver::{Opening, ToDriver};

use applying::Applying;

/// Most reasons for unused contacts that are told apart.
const REASONS_MAX: usize = 16;

/// Time without a reading after which a regulator of the agent is told that none comes. A driver reads 20 times a second.
const UNREAD_US: u64 = 1_000_000;
/// Time between its steps from then on.
const BLIND_US: u64 = 100_000;

/// A regulator that never exceeds this pressure.
fn new_valves(max_mpa: f64) -> vibrissa_regulator::Regulator {
    vibrissa_regulator::Regulator::new(Params { max_mpa: max_mpa as f32, ..Params::default() })
}

/// The newest reading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    pub(super) pressure_mpa: f64,
    pub(super) at: Moment,
}

/// One whisker.
#[derive(Debug)]
pub(super) struct Chamber {
    pub(super) array: Name,
    pub(super) number: u16,
    pub(super) nominal_mpa: f64,
    pub(super) max_mpa: f64,
    pub(super) place: PlaceKind,
    /// The way in which a touch moves the strain.
    pub(super) sign: Option<Sign>,
    /// Reading of the sensor at an empty chamber.
    pub(super) zero_mpa: f64,
    /// Highest (epoch, version) seen for the whisker, in earlier boots, too.
    pub(super) seen: Option<(u64, u64)>,
    pub(super) target_mpa: f64,
    pub(super) slew_mpa_per_s: f64,
    /// Moment at which the driver was last told the pressure.
    pub(super) sent_at: Moment,
    reading: Option<Reading>,
    /// The driver has gone since the newest reading, and may come back soon.
    is_waiting: bool,
    /// Condition of the regulator as the driver states it.
    regulator: Option<Regulator>,
    /// The condition of a line `fault`. Readings that state none do not end it.
    regulator_fault: Option<Regulator>,
    gauge: Gauge,
    /// The driver that has stated the condition of the gauge.
    gauge_from: Option<usize>,
    pub(super) temperature_c: Option<f64>,
    supply_mpa: Option<f64>,
    pub(super) applying: Option<Applying>,
    /// Factor on the readings, which the driver is told only if it applies gains.
    pub(super) gain: ReadingGain,
    /// The newest estimate, for a driver that starts later.
    pub(super) estimate: Option<ToDriver>,
    /// Response of the whisker in that estimate.
    pub(super) response: Option<Response>,
    /// Regulates the pressure with pulses of the valves, if the driver does not.
    valves: Option<Box<vibrissa_regulator::Regulator>>,
    /// Moment at which that regulator makes a step without a reading.
    blind_at: Moment,
    /// Samples of the gauge, if a driver sends them, and that driver.
    pub(super) stream: Option<Box<Stream>>,
    pub(super) strain_from: Option<usize>,
    /// The motion, if another driver than that of the strain sends it.
    pub(super) motion: Motion,
    /// Contacts of which one driver has said a part.
    pub(super) partials: Partials,
    pub(super) gauge_watch: GaugeWatch,
    /// The log names a reading below zero already.
    pub(super) told_below_zero: bool,
    /// The pressure that a driver has refused, and whether the log says so.
    refused: Option<(f64, bool)>,
    /// Contacts that could not be sent, by reason.
    pub(super) unused: BTreeMap<String, u64>,
    /// Moment of the last contact that was sent.
    pub(super) contact_at: Option<Moment>,
    /// The driver that reads the pressure.
    pub(super) holder: Option<usize>,
    /// Times and tolerances of that driver.
    pub(super) limits: DriverLimits,
    /// Condition in the last status.
    pub(super) reported: (Regulator, Gauge),
}

impl Chamber {
    /// `limits` are those of the first driver that serves the whisker, until one reads its pressure.
    pub(super) fn new(
        array: Name,
        facts: &WhiskerFacts,
        more: WhiskerConfig,
        seen: Option<(u64, u64)>,
        limits: DriverLimits,
    ) -> Self {
        Self {
            array,
            number: facts.whisker,
            nominal_mpa: facts.pressure_mpa,
            max_mpa: facts.pressure_max_mpa,
            place: facts.place.unwrap_or(PlaceKind::Ratio),
            sign: more.sign,
            zero_mpa: more.pressure_zero_mpa,
            seen,
            target_mpa: facts.pressure_mpa,
            slew_mpa_per_s: limits.own_slew_mpa_per_s,
            sent_at: Moment::BEFORE_ALL,
            reading: None,
            is_waiting: false,
            regulator: None,
            regulator_fault: None,
            gauge: Gauge::Ok,
            gauge_from: None,
            temperature_c: None,
            supply_mpa: None,
            applying: None,
            gain: ReadingGain::new(facts.pressure_mpa),
            estimate: None,
            response: None,
            valves: limits.regulate.then(|| Box::new(new_valves(facts.pressure_max_mpa))),
            blind_at: Moment::NEVER,
            stream: None,
            strain_from: None,
            motion: Motion::default(),
            partials: Partials::default(),
            gauge_watch: GaugeWatch::default(),
            told_below_zero: false,
            refused: None,
            unused: BTreeMap::new(),
            contact_at: None,
            holder: None,
            limits,
            reported: (Regulator::Ok, Gauge::Ok),
        }
    }

    /// A pressure as the driver's sensor reads it. An empty chamber is one whatever its sensor reads.
    pub(super) fn as_read(&self, mpa: f64) -> f64 {
        if mpa > 0.0 { (mpa + self.zero_mpa).max(0.0) } else { mpa }
    }

    /// The line that sets the pressure.
    pub(super) fn set_pressure(&self) -> ToDriver {
        ToDriver::SetPressure {
            array: self.array.clone(),
            whisker: self.number,
            pressure_mpa: self.as_read(self.target_mpa),
            slew_mpa_per_s: self.slew_mpa_per_s,
        }
    }

    /// The line with the factor on the readings.
    pub(super) fn reading_gain(&self) -> ToDriver {
        let (array, whisker) = (self.array.clone(), self.number);
        ToDriver::ReadingGain { array, whisker, reading_gain: self.gain.factor() }
    }

    /// Returns to the nominal pressure, as at a start.
    pub(super) fn restart(&mut self) {
        self.target_mpa = self.nominal_mpa;
        self.slew_mpa_per_s = self.limits.own_slew_mpa_per_s;
        self.applying = None;
        self.gain = ReadingGain::new(self.nominal_mpa);
        (self.estimate, self.response) = (None, None);
        self.sent_at = Moment::BEFORE_ALL;
    }

    /// Changes the pressure without a setpoint.
    pub(super) fn leave(&mut self, target_mpa: f64) {
        self.target_mpa = target_mpa;
        self.slew_mpa_per_s = self.limits.own_slew_mpa_per_s;
        self.gain.left(target_mpa);
    }

    /// Takes a reading.
    pub(super) fn read(&mut self, reading: Reading) {
        // A line that was on its way before the setpoint says nothing of it, nor does an older one than the newest.
        (self.reading, self.is_waiting) = (Some(reading), false);
        self.blind_at = reading.at + UNREAD_US;
        let is_near = (reading.pressure_mpa - self.target_mpa).abs() <= self.limits.tolerance_mpa;
        let settle_us = self.limits.settle_us;
        if let Some(applying) = &mut self.applying {
            applying.read(is_near, reading.at, settle_us);
        }
    }

    /// Takes conditions as the driver states them.
    pub(super) fn state(&mut self, regulator: Option<Regulator>, temperature_c: Option<f64>, supply_mpa: Option<f64>) {
        if regulator.is_some() {
            self.regulator_fault = None;
        }
        self.regulator = regulator.or(self.regulator_fault);
        self.temperature_c = temperature_c.or(self.temperature_c);
        self.supply_mpa = supply_mpa.or(self.supply_mpa);
    }

    /// The driver that reads the pressure has come, and has the time of its silence for its first reading. The agent's regulator
    /// begins anew: a person may have repaired the chamber, and the time without the driver is no time without a reading.
    pub(super) fn expect_reading(&mut self, now: Now) {
        self.renew_valves();
        self.blind_at = now.at + self.limits.silent_us;
    }

    /// Ends a fault of the agent's regulator. It begins anew, because its measurements are those of the broken chamber; the fault
    /// comes back if its cause is still there.
    pub(super) fn end_fault(&mut self) {
        if self.valves.as_ref().is_some_and(|valves| valves.fault().is_some()) {
            self.renew_valves();
        }
    }

    fn renew_valves(&mut self) {
        if let Some(valves) = &mut self.valves {
            **valves = new_valves(self.max_mpa);
        }
    }

    /// Moment at which the agent's regulator makes a step without a reading.
    pub(super) fn blind_at(&self) -> Option<Moment> {
        self.valves.as_ref().map(|_| self.blind_at)
    }

    /// The pulse of a valve without a usable reading: the regulator closes the valves, and soon vents.
    pub(super) fn pulse_blindly(&mut self, now: Now) -> Option<ToDriver> {
        self.blind_at = self.blind_at.max(now.at + BLIND_US);
        self.pulse(now, f64::NAN)
    }

    /// The pulse of a valve that a reading calls for, if the agent regulates. The regulator's condition is that of the chamber
    /// then.
    pub(super) fn pulse(&mut self, now: Now, pressure_mpa: f64) -> Option<ToDriver> {
        let valves = self.valves.as_mut()?;
        valves.set_target(self.target_mpa as f32, self.slew_mpa_per_s as f32);
        let command = valves.step(now.at.as_us(), pressure_mpa as f32, self.supply_mpa.map(|mpa| mpa as f32));
        self.regulator = Some(match valves.condition() {
            Condition::Ok => Regulator::Ok,
            Condition::Filling => Regulator::Filling,
            Condition::Venting => Regulator::Venting,
            Condition::SupplyLow => Regulator::SupplyLow,
            Condition::Leak => Regulator::Leak,
            Condition::Fault => Regulator::Fault,
        });
        let (open, length_us) = match command {
            Command::None => return None,
            Command::Fill(length_us) => (Opening::Fill, length_us),
            Command::Vent(length_us) => (Opening::Vent, length_us),
            Command::Close => (Opening::Close, 0),
        };
        let (array, whisker) = (self.array.clone(), self.number);
        Some(ToDriver::Valve { array, whisker, open, for_ms: f64::from(length_us) / 1000.0 })
    }

    /// Takes a fault.
    pub(super) fn fault(&mut self, from: usize, regulator: Option<Regulator>, gauge: Option<Gauge>) {
        if let Some(told) = regulator {
            self.regulator = regulator;
            self.regulator_fault = regulator.filter(|_| told != Regulator::Ok);
        }
        if let Some(gauge) = gauge {
            (self.gauge, self.gauge_from) = (gauge, Some(from));
        }
    }

    /// A driver begins anew. It reports what differs from a good gauge and a good regulator.
    pub(super) fn begin(&mut self, driver: usize) {
        if self.holder == Some(driver) {
            (self.regulator, self.regulator_fault) = (None, None);
        }
        if self.gauge_from == Some(driver) {
            (self.gauge, self.gauge_from) = (Gauge::Ok, None);
        }
    }

    /// The driver that reads the pressure is absent: nothing is known of the chamber.
    pub(super) fn forget(&mut self) {
        (self.reading, self.is_waiting) = (None, false);
        (self.regulator, self.regulator_fault) = (None, None);
    }

    /// Another driver reads the pressure from now on.
    pub(super) fn hand_over(&mut self, holder: usize, limits: DriverLimits) {
        self.holder = Some(holder);
        self.limits = limits;
        (self.regulator, self.regulator_fault) = (None, None);
        let max_mpa = self.max_mpa;
        self.valves = limits.regulate.then(|| Box::new(new_valves(max_mpa)));
    }

    /// A driver has gone, and with it its samples, its motion and its parts of contacts.
    pub(super) fn lose(&mut self, driver: usize) {
        if self.strain_from == Some(driver) {
            (self.stream, self.strain_from) = (None, None);
        }
        self.motion.lose(driver);
    }

    /// The driver has gone, as for a restart: the last reading is reported until it is known to be absent.
    pub(super) fn wait(&mut self, now: Now) {
        let silent_us = self.limits.silent_us;
        self.is_waiting |= self.present_reading().is_some_and(|reading| now.at < reading.at + silent_us);
        if !self.is_waiting {
            return self.forget();
        }
        if let Some(applying) = &mut self.applying {
            applying.unsettle();
        }
    }

    /// The newest reading of the present driver.
    pub(super) fn present_reading(&self) -> Option<Reading> {
        self.reading.filter(|_| !self.is_waiting)
    }

    /// Moment at which the newest reading becomes too old.
    fn reading_ends_at(&self) -> Option<Moment> {
        let silent_us = self.limits.silent_us;
        Some(self.reading?.at + if self.is_waiting { silent_us.max(ABSENT_AFTER_US) } else { silent_us })
    }

    /// Moment at which the newest reading becomes too old, if the condition in the last status does not say so yet.
    pub(super) fn silent_at(&self) -> Option<Moment> {
        let at = self.reading_ends_at()?;
        (self.reported.0 != Regulator::Fault).then_some(at)
    }

    /// Counts a contact that cannot be sent. A driver cannot make reasons without end.
    pub(super) fn count_unused(&mut self, reason: &str) {
        let is_known = self.unused.len() < REASONS_MAX || self.unused.contains_key(reason);
        *self.unused.entry(if is_known { reason } else { "other reasons" }.to_owned()).or_default() += 1;
    }

    /// Moment at which values wait no longer for those of another driver.
    pub(super) fn values_until(&self) -> Option<Moment> {
        self.motion.until().into_iter().chain(self.partials.until()).min()
    }
}
