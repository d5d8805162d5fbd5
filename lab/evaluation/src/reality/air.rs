//! The chamber of a whisker with its valves and sensor, from event to event.

use std::f64::consts::TAU;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use vibrissa_core::robot::event::RegulatorState;

use super::nuisances::Nuisances;
use super::whisker::{NOMINAL_MPA, normal, stream};

/// Resolution of the pressure sensor with on/off valves, and standard deviation of its noise, MPa.
const COARSE_MPA: (f64, f64) = (0.00122, 0.0003);
/// The same with an ideal regulator, MPa.
const FINE_MPA: (f64, f64) = (0.0002, 0.0004);
/// Range of the dead bands, MPa: the largest distance from the target at which the valves stay closed.
const DEAD_BAND_MPA: (f64, f64) = (0.0015, 0.003);
/// Part of its pressure that a tight chamber behind on/off valves loses per second.
const TIGHT_PER_S: f64 = 5e-5;
/// Range of the same for a leaking chamber.
const LEAK_PER_S: (f64, f64) = (0.001, 0.03);
/// Range of the periods with which regulators hunt, s.
const HUNTING_S: (f64, f64) = (3.0, 80.0);
/// Random stream of the first whisker's period; the others follow downwards.
const HUNTING_STREAM: u64 = u64::MAX - 40;
/// Time from the arrival at the target until it counts as held, s.
const SETTLING_S: f64 = 0.5;
/// Refills that one call of `advance` follows one by one. After more, the pressure is drawn from a cycle of loss and
/// refill.
const REFILLS_MAX: u32 = 100;

/// Chamber of one whisker with its valves and sensor.
#[derive(Debug)]
pub(super) struct Air {
    pressure_mpa: f64,
    target_mpa: f64,
    slew_mpa_per_s: f64,
    /// Time that is left until the target counts as held, s; `None` once it does.
    settling_s: Option<f64>,
    dead_band_mpa: f64,
    loss_per_s: f64,
    leak_per_s: f64,
    sensor_mpa: (f64, f64),
    /// Amplitude with which the regulator hunts.
    hunting_mpa: f64,
    /// Period with which it hunts.
    hunting_s: f64,
    /// Time since the start.
    now_s: f64,
    random: ChaCha8Rng,
}

impl Air {
    /// A tight chamber at the nominal pressure.
    #[must_use]
    pub(super) fn new(nuisances: &Nuisances, seed: u64, number: u64) -> Self {
        let mut random = stream(seed, 4 + 4 * number);
        let band_mpa = random.random_range(DEAD_BAND_MPA.0..=DEAD_BAND_MPA.1);
        let leak_per_s = LEAK_PER_S.0 * (LEAK_PER_S.1 / LEAK_PER_S.0).powf(random.random());
        let has_valves = nuisances.valves > 0.0;
        let hunting: f64 = stream(seed, HUNTING_STREAM - number).random();
        let hunting_s = HUNTING_S.0 * (HUNTING_S.1 / HUNTING_S.0).powf(hunting);
        Self {
            pressure_mpa: NOMINAL_MPA,
            target_mpa: NOMINAL_MPA,
            slew_mpa_per_s: 0.02,
            settling_s: None,
            dead_band_mpa: nuisances.valves * band_mpa,
            loss_per_s: if has_valves { TIGHT_PER_S } else { 0.0 },
            leak_per_s: nuisances.leak * leak_per_s,
            sensor_mpa: if has_valves { COARSE_MPA } else { FINE_MPA },
            hunting_mpa: nuisances.hunting_mpa,
            hunting_s,
            now_s: 0.0,
            random,
        }
    }

    /// From now on the chamber leaks.
    pub(super) fn start_leak(&mut self) {
        self.loss_per_s = self.leak_per_s;
    }

    /// A new target, to be approached at a rate in MPa/s.
    pub(super) fn set(&mut self, target_mpa: f64, slew_mpa_per_s: f64) {
        self.target_mpa = target_mpa;
        self.slew_mpa_per_s = slew_mpa_per_s;
        self.settling_s = Some(SETTLING_S);
    }

    /// Lets a time pass: the chamber approaches its target, and then loses air and is refilled.
    pub(super) fn advance(&mut self, seconds: f64) {
        self.now_s += seconds;
        let mut left_s = seconds;
        if let Some(settling_s) = self.settling_s {
            let way_mpa = self.target_mpa - self.pressure_mpa;
            let way_s = way_mpa.abs() / self.slew_mpa_per_s;
            if way_s > left_s {
                self.pressure_mpa += (self.slew_mpa_per_s * left_s).copysign(way_mpa);
                return;
            }
            left_s -= way_s;
            self.settling_s = (settling_s > left_s).then_some(settling_s - left_s);
            // When the target counts as held, the valves have stopped somewhere in the dead band.
            let stop_mpa = if self.settling_s.is_some() { 0.0 } else { self.dead_band_mpa };
            self.pressure_mpa = (self.target_mpa + stop_mpa * self.random.random_range(-1.0..=1.0)).max(0.0);
        }
        self.lose(left_s);
    }

    /// Loses air for a time; the valves refill from the lower end of the dead band.
    fn lose(&mut self, seconds: f64) {
        let low_mpa = self.target_mpa - self.dead_band_mpa;
        if self.loss_per_s == 0.0 || low_mpa <= 0.0 {
            return;
        }
        let mut left_s = seconds;
        for _ in 0..REFILLS_MAX {
            let until_refill_s = ((self.pressure_mpa / low_mpa).ln() / self.loss_per_s).max(0.0);
            if left_s < until_refill_s {
                self.pressure_mpa *= (-self.loss_per_s * left_s).exp();
                return;
            }
            left_s -= until_refill_s;
            self.pressure_mpa = self.target_mpa + self.dead_band_mpa * self.random.random_range(0.0..=0.5);
        }
        self.pressure_mpa = self.random.random_range(low_mpa..=self.target_mpa);
    }

    /// True pressure, MPa.
    #[must_use]
    pub(super) fn pressure_mpa(&self) -> f64 {
        (self.pressure_mpa + self.hunting_mpa * (TAU * self.now_s / self.hunting_s).sin()).max(0.0)
    }

    /// Target pressure, MPa.
    #[must_use]
    pub(super) fn target_mpa(&self) -> f64 {
        self.target_mpa
    }

    /// Pressure by the sensor, MPa.
    pub(super) fn reading_mpa(&mut self) -> f64 {
        let (step_mpa, noise_mpa) = self.sensor_mpa;
        let noisy_mpa = self.pressure_mpa() + noise_mpa * normal(&mut self.random);
        ((noisy_mpa / step_mpa).round() * step_mpa).clamp(0.0, 1.0)
    }

    /// Whether the target counts as held.
    #[must_use]
    pub(super) fn is_settled(&self) -> bool {
        self.settling_s.is_none()
    }

    /// Condition that the regulator reports; it notices no leaks.
    #[must_use]
    pub(super) fn condition(&self) -> RegulatorState {
        match (self.settling_s, self.target_mpa > self.pressure_mpa) {
            (None, _) => RegulatorState::Ok,
            (Some(_), true) => RegulatorState::Filling,
            (Some(_), false) => RegulatorState::Venting,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setpoint_is_approached_at_its_slew_and_then_held() {
        let mut air = Air::new(&Nuisances::NONE, 1, 0);
        air.set(0.06, 0.02);
        air.advance(1.0);
        assert!((air.pressure_mpa() - 0.08).abs() < 1e-12 && !air.is_settled());
        assert_eq!(air.condition(), RegulatorState::Venting);
        air.advance(2.0);
        assert!(air.is_settled() && air.pressure_mpa() == 0.06);
    }

    #[test]
    fn a_leak_is_refilled_within_the_dead_band() {
        let nuisances = Nuisances { valves: 1.0, leak: 1.0, ..Nuisances::NONE };
        let mut air = Air::new(&nuisances, 1, 0);
        air.start_leak();
        let mut refills = 0;
        for _ in 0..2000 {
            let before_mpa = air.pressure_mpa();
            air.advance(0.5);
            refills += u32::from(air.pressure_mpa() > before_mpa);
            assert!((air.pressure_mpa() - NOMINAL_MPA).abs() <= DEAD_BAND_MPA.1);
            let steps = air.reading_mpa() / COARSE_MPA.0;
            assert!((steps - steps.round()).abs() < 1e-9);
        }
        assert!(refills > 10, "{refills}");
    }
}
