//! The pressure regulator of one chamber, modelled on the cheap ones of small robots.
//!
//! Every 50 ms it reads a coarse sensor and opens the fill valve, the vent valve or none. A reference moves to the
//! target at the commanded slew. With on/off valves and a sensor of 1.2 kPa steps it overshoots and dithers by
//! about a step, as real ones do. It derives its condition (filling, leaking etc.) from its own sensor and valves
//! alone.

use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::{Regulator as Condition, SetpointError};

use crate::random::normal;

/// Period of the regulator, in microseconds.
pub const TICK_US: u64 = 50_000;
/// Resolution of the pressure sensor, in MPa.
pub const SENSOR_STEP_MPA: f64 = 0.0012;
/// Pressure of an intact air supply, in MPa.
pub const SUPPLY_MPA: f64 = 0.3;
/// Largest deviation from the target of a settled chamber, in MPa.
pub const SETTLED_WITHIN_MPA: f64 = 0.003;

const TICK_S: f64 = TICK_US as f64 / 1e6;
const SENSOR_NOISE_MPA: f64 = 0.0003;
/// Share of the pressure difference to the supply that an open fill valve closes per second.
const FILL_PER_S: f64 = 0.2;
/// Share of the pressure that an open vent valve releases per second.
const VENT_PER_S: f64 = 0.5;
/// The valves stay closed while the reading is this close to the reference.
const DEADBAND_MPA: f64 = 1.1 * SENSOR_STEP_MPA;
/// Ticks at the target before it counts as settled: half a second.
const SETTLED_TICKS: u32 = 10;
/// Ticks behind the reference after which the regulator counts as struggling: two seconds.
const STRUGGLING_TICKS: u32 = 40;
const STRUGGLING_BEHIND_MPA: f64 = 0.004;
/// Excess of fill over vent and pressure rise that counts as a leak, in MPa/s.
const LEAK_MPA_PER_S: f64 = 0.0005;
/// Averaging time of that excess, in seconds; dithering averages out.
const LEAK_OVER_S: f64 = 20.0;
/// Least excess of the supply over the target, in MPa.
const SUPPLY_MARGIN_MPA: f64 = 0.005;

/// One chamber with its valves and sensor.
#[derive(Debug, Clone)]
pub struct Regulator {
    pressure_mpa: f64,
    reading_mpa: f64,
    reference_mpa: f64,
    target_mpa: f64,
    slew_mpa_per_s: f64,
    supply_mpa: f64,
    settled_ticks: u32,
    struggling_ticks: u32,
    lost_mpa_per_s: f64,
    /// Its valves open no more.
    is_broken: bool,
    noise: ChaCha8Rng,
}

impl Regulator {
    /// A chamber at its nominal pressure.
    pub(crate) fn new(nominal_mpa: f64, noise: ChaCha8Rng) -> Self {
        Self {
            pressure_mpa: nominal_mpa,
            reading_mpa: stepped(nominal_mpa),
            reference_mpa: nominal_mpa,
            target_mpa: nominal_mpa,
            slew_mpa_per_s: 0.02,
            supply_mpa: SUPPLY_MPA,
            settled_ticks: SETTLED_TICKS,
            struggling_ticks: 0,
            lost_mpa_per_s: 0.0,
            is_broken: false,
            noise,
        }
    }

    /// Starts with a pressure that was set before a restart.
    pub(crate) fn find(&mut self, pressure_mpa: f64) {
        self.pressure_mpa = pressure_mpa;
        self.reading_mpa = stepped(pressure_mpa);
        self.reference_mpa = self.reading_mpa;
    }

    /// Sets a new target, to be approached at the given rate.
    pub fn set(&mut self, target_mpa: f64, slew_mpa_per_s: f64) {
        self.target_mpa = target_mpa;
        self.slew_mpa_per_s = slew_mpa_per_s;
        self.settled_ticks = 0;
    }

    /// Breaks its valves, or repairs them.
    pub(crate) fn set_broken(&mut self, is_broken: bool) {
        self.is_broken = is_broken;
    }

    /// Whether its valves are broken.
    pub(crate) fn is_broken(&self) -> bool {
        self.is_broken
    }

    /// Time after which a new target counts as failed, in microseconds: the time for the pressure change at the
    /// commanded rate, or at the valves' rate if that is slower, plus a margin to settle.
    #[must_use]
    pub fn patience_us(&self) -> u64 {
        let way_mpa = (self.target_mpa - self.reading_mpa).abs();
        ((way_mpa / self.slew_mpa_per_s.min(0.02) + 6.0) * 1e6) as u64
    }

    /// Simulates 50 ms with the given leak rate and supply pressure.
    pub fn tick(&mut self, leak_mpa_per_s: f64, supply_mpa: f64) {
        self.supply_mpa = supply_mpa;
        let step_mpa = self.slew_mpa_per_s * TICK_S;
        self.reference_mpa += (self.target_mpa - self.reference_mpa).clamp(-step_mpa, step_mpa);

        let behind_mpa = self.reference_mpa - self.reading_mpa;
        let fill = behind_mpa > DEADBAND_MPA && !self.is_broken;
        let vent = behind_mpa < -DEADBAND_MPA && !self.is_broken;
        let filled_mpa = if fill { (FILL_PER_S * (supply_mpa - self.pressure_mpa) * TICK_S).max(0.0) } else { 0.0 };
        let vented_mpa = if vent { VENT_PER_S * self.pressure_mpa * TICK_S } else { 0.0 };
        let lost_mpa = leak_mpa_per_s * TICK_S;
        self.pressure_mpa = (self.pressure_mpa + filled_mpa - vented_mpa - lost_mpa).max(0.0);
        let before_mpa = self.reading_mpa;
        self.reading_mpa = stepped(self.pressure_mpa + normal(&mut self.noise, SENSOR_NOISE_MPA));
        self.watch(filled_mpa - vented_mpa - (self.reading_mpa - before_mpa));
    }

    /// Updates the conclusions from the regulator's own readings.
    fn watch(&mut self, lost_mpa: f64) {
        let near = (self.reading_mpa - self.target_mpa).abs() <= SETTLED_WITHIN_MPA;
        let holding = self.reference_mpa == self.target_mpa;
        self.settled_ticks = if near && holding { self.settled_ticks.saturating_add(1) } else { 0 };
        let behind = self.reference_mpa - self.reading_mpa > STRUGGLING_BEHIND_MPA;
        self.struggling_ticks = if behind { self.struggling_ticks.saturating_add(1) } else { 0 };
        let weight = TICK_S / LEAK_OVER_S;
        self.lost_mpa_per_s += weight * (lost_mpa / TICK_S - self.lost_mpa_per_s);
    }

    /// Condition that the regulator reports.
    #[must_use]
    pub fn condition(&self) -> Condition {
        let below_mpa = self.target_mpa - self.reading_mpa;
        if self.is_broken {
            Condition::Fault
        } else if self.supply_mpa < self.target_mpa + SUPPLY_MARGIN_MPA && below_mpa > SETTLED_WITHIN_MPA {
            Condition::SupplyLow
        } else if self.struggling_ticks >= STRUGGLING_TICKS || self.lost_mpa_per_s > LEAK_MPA_PER_S {
            Condition::Leak
        } else if below_mpa > SETTLED_WITHIN_MPA {
            Condition::Filling
        } else if below_mpa < -SETTLED_WITHIN_MPA {
            Condition::Venting
        } else {
            Condition::Ok
        }
    }

    /// Reason why the target was not reached in time.
    #[must_use]
    pub fn failure(&self) -> SetpointError {
        match self.condition() {
            Condition::SupplyLow => SetpointError::SupplyLow,
            Condition::Leak => SetpointError::Leak,
            Condition::Ok | Condition::Filling | Condition::Venting | Condition::Fault => SetpointError::Fault,
        }
    }

    /// Whether the chamber is settled at its target.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.settled_ticks >= SETTLED_TICKS
    }

    /// True pressure, in MPa.
    #[must_use]
    pub fn pressure_mpa(&self) -> f64 {
        self.pressure_mpa
    }

    /// Pressure by the sensor, in MPa.
    #[must_use]
    pub fn reading_mpa(&self) -> f64 {
        self.reading_mpa
    }

    /// Target pressure, in MPa.
    #[must_use]
    pub fn target_mpa(&self) -> f64 {
        self.target_mpa
    }
}

/// Reading of the coarse sensor: never below zero, and without the trailing digits of a binary multiple of a step.
fn stepped(pressure_mpa: f64) -> f64 {
    let steps = (pressure_mpa / SENSOR_STEP_MPA).round().max(0.0);
    (steps * SENSOR_STEP_MPA * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, stream};

    fn regulator(nominal_mpa: f64) -> Regulator {
        Regulator::new(nominal_mpa, stream(1, "r", "a", 0, Purpose::Regulator))
    }

    /// Runs for a time and returns the lowest and highest true pressure.
    fn run(regulator: &mut Regulator, seconds: f64, leak_mpa_per_s: f64, supply_mpa: f64) -> (f64, f64) {
        let mut range = (f64::INFINITY, 0.0_f64);
        for _ in 0..(seconds / TICK_S) as usize {
            regulator.tick(leak_mpa_per_s, supply_mpa);
            range = (range.0.min(regulator.pressure_mpa()), range.1.max(regulator.pressure_mpa()));
        }
        range
    }

    #[test]
    fn settles_within_its_patience_and_overshoots_by_less_than_4_kpa() {
        for (from_mpa, to_mpa) in [(0.1, 0.048), (0.1, 0.192), (0.05, 0.2), (0.2, 0.02), (0.1, 0.0), (0.1, 0.101)] {
            let mut regulator = regulator(from_mpa);
            regulator.set(to_mpa, 0.02);
            let patience_s = regulator.patience_us() as f64 / 1e6;
            let (lowest, highest) = run(&mut regulator, patience_s, 0.0, SUPPLY_MPA);
            assert!(regulator.is_settled(), "{from_mpa} to {to_mpa}: at {}", regulator.pressure_mpa());
            assert!(lowest > from_mpa.min(to_mpa) - 0.004 && highest < from_mpa.max(to_mpa) + 0.004);
        }
    }

    #[test]
    fn dithers_around_its_target_and_stays_within_3_kpa() {
        let mut regulator = regulator(0.1);
        let (lowest, highest) = run(&mut regulator, 600.0, 0.0, SUPPLY_MPA);
        assert!(highest - lowest > SENSOR_STEP_MPA / 2.0, "a cheap valve does not stand still");
        assert!(lowest > 0.097 && highest < 0.103, "{lowest}..{highest}");
        assert_eq!(regulator.condition(), Condition::Ok);
    }

    #[test]
    fn regress_a_tight_chamber_never_leaks_whatever_is_asked_of_it() {
        for seed in 0..200 {
            let mut regulator = Regulator::new(0.1, stream(seed, "r", "a", 0, Purpose::Regulator));
            for step in 0..12 {
                // At some pressures the chamber fills often and little, and vents seldom and much.
                let to_mpa = 0.02 + 0.0147 * f64::from((5 * step) % 12) + 1e-5 * seed as f64;
                regulator.set(to_mpa, 0.02);
                for _ in 0..600 {
                    regulator.tick(0.0, SUPPLY_MPA);
                    assert_ne!(regulator.condition(), Condition::Leak, "seed {seed}, {to_mpa} MPa");
                }
            }
        }
    }

    #[test]
    fn follows_the_commanded_slew() {
        let mut regulator = regulator(0.05);
        regulator.set(0.15, 0.01);
        run(&mut regulator, 5.0, 0.0, SUPPLY_MPA);
        assert!((regulator.pressure_mpa() - 0.1).abs() < 0.004, "{}", regulator.pressure_mpa());
        assert_eq!(regulator.condition(), Condition::Filling);
    }

    #[test]
    fn a_leak_lowers_the_pressure_between_fills_and_is_noticed() {
        let mut regulator = regulator(0.1);
        let (lowest, _) = run(&mut regulator, 60.0, 0.002, SUPPLY_MPA);
        assert!(lowest > 0.095, "it is refilled");
        assert_eq!(regulator.condition(), Condition::Leak);
        assert!(regulator.is_settled(), "it still holds its target");
    }

    #[test]
    fn a_leak_that_the_valve_cannot_make_good_is_the_reason_of_the_failure() {
        let mut regulator = regulator(0.1);
        regulator.set(0.15, 0.02);
        run(&mut regulator, 30.0, 0.05, SUPPLY_MPA);
        assert!(!regulator.is_settled());
        assert_eq!((regulator.condition(), regulator.failure()), (Condition::Leak, SetpointError::Leak));
    }

    #[test]
    fn a_low_supply_is_the_reason_of_the_failure() {
        let mut regulator = regulator(0.1);
        regulator.set(0.15, 0.02);
        run(&mut regulator, 30.0, 0.0, 0.12);
        assert!(!regulator.is_settled());
        assert_eq!((regulator.condition(), regulator.failure()), (Condition::SupplyLow, SetpointError::SupplyLow));
    }

    #[test]
    fn the_reading_comes_in_steps_and_is_never_negative() {
        let mut regulator = regulator(0.1);
        regulator.set(0.0, 0.05);
        for _ in 0..1000 {
            regulator.tick(0.0, SUPPLY_MPA);
            let steps = regulator.reading_mpa() / SENSOR_STEP_MPA;
            assert!(steps >= 0.0 && (steps - steps.round()).abs() < 1e-3);
        }
    }
}
