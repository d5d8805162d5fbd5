//! Chambers of a board that has only valves: it opens one for the time that the agent states, and reports pressures.
//!
//! Flow by ISO 6358, valves that take time to move, and a 10-bit sensor with steps of 1.22 kPa. The board itself closes a
//! valve when its time is over, also if nobody can be heard any more.

use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use crate::random::normal;

/// Step of a 10-bit converter with MPa = (V - 1) / 4.
const STEP_MPA: f64 = 5.0 / 1024.0 / 4.0;
const AIR_MPA: f64 = 0.101_325;
/// Standard deviation of a reading, in steps.
const NOISE_STEPS: f64 = 0.2;
/// Step of the simulation, and time between two readings, in microseconds.
const DT_US: u64 = 100;
pub(super) const READ_EVERY_US: u64 = 20_000;
/// Times that a valve takes to open and to close, in milliseconds.
const OPEN_MS: f64 = 5.0;
const CLOSE_MS: f64 = 3.0;
/// Time constant of a chamber with an open valve, in seconds.
const TAU_S: f64 = 1.0;
/// Longest pulse that the board obeys, in microseconds.
const PULSE_MAX_US: u64 = 1_000_000;

/// Order of the agent to the valves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub(super) enum Opening {
    Fill,
    Vent,
    Close,
}

/// A pulse that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pulse {
    pub(super) is_fill: bool,
    /// Time for which the valve had current, in microseconds.
    pub(super) lasted_us: u64,
}

#[derive(Debug, Clone, Copy)]
struct Open {
    is_fill: bool,
    since_us: u64,
    until_us: u64,
}

/// One chamber with two valves and a sensor.
#[derive(Debug)]
pub(super) struct Chamber {
    pressure_mpa: f64,
    open: Option<Open>,
    fill: f64,
    vent: f64,
    supply_mpa: f64,
    /// Leak at 0.1 MPa; it is proportional to the pressure.
    leak_mpa_per_s: f64,
    at_us: u64,
    noise: ChaCha8Rng,
}

impl Chamber {
    pub(super) fn new(pressure_mpa: f64, supply_mpa: f64, leak_mpa_per_s: f64, noise: ChaCha8Rng, now_us: u64) -> Self {
        Self { pressure_mpa, open: None, fill: 0.0, vent: 0.0, supply_mpa, leak_mpa_per_s, at_us: now_us, noise }
    }

    /// Pressure without the error of the sensor, MPa.
    pub(super) fn pressure_mpa(&self) -> f64 {
        self.pressure_mpa
    }

    pub(super) fn supply_mpa(&self) -> f64 {
        self.supply_mpa
    }

    pub(super) fn set_supply(&mut self, supply_mpa: f64) {
        self.supply_mpa = supply_mpa;
    }

    /// A reading of the sensor, which is not negative.
    pub(super) fn reading_mpa(&mut self) -> f64 {
        let steps = self.pressure_mpa / STEP_MPA + normal(&mut self.noise, NOISE_STEPS);
        // The middle of the converter's step, without the trailing digits of a binary fraction.
        (((steps.floor() + 0.5) * STEP_MPA).max(0.0) * 1e7).round() / 1e7
    }

    /// Obeys the agent; both valves are never open.
    pub(super) fn obey(&mut self, opening: Opening, for_ms: f64, now_us: u64) -> Option<Pulse> {
        let ended = self.advance(now_us).or_else(|| self.close(now_us));
        let length_us = ((for_ms.max(0.0) * 1e3) as u64).min(PULSE_MAX_US);
        if opening != Opening::Close && length_us > 0 {
            let (is_fill, until_us) = (opening == Opening::Fill, self.at_us + length_us);
            self.open = Some(Open { is_fill, since_us: self.at_us, until_us });
        }
        ended
    }

    fn close(&mut self, at_us: u64) -> Option<Pulse> {
        let open = self.open.take()?;
        Some(Pulse { is_fill: open.is_fill, lasted_us: at_us.min(open.until_us) - open.since_us })
    }

    /// Lets time pass. Returns the pulse that has ended.
    pub(super) fn advance(&mut self, now_us: u64) -> Option<Pulse> {
        let mut ended = None;
        while self.at_us + DT_US <= now_us {
            if self.open.is_some_and(|open| self.at_us >= open.until_us) {
                ended = self.close(self.at_us);
            }
            let (fill, vent) = self.open.map_or((false, false), |open| (open.is_fill, !open.is_fill));
            self.flow(fill, vent);
            self.at_us += DT_US;
        }
        ended
    }

    fn flow(&mut self, fill: bool, vent: bool) {
        let dt_s = DT_US as f64 * 1e-6;
        let towards = |position: f64, open: bool| {
            let moved = if open { dt_s * 1e3 / OPEN_MS } else { -dt_s * 1e3 / CLOSE_MS };
            (position + moved).clamp(0.0, 1.0)
        };
        (self.fill, self.vent) = (towards(self.fill, fill), towards(self.vent, vent));
        // A check valve keeps the air of the chamber from an empty supply.
        let filled = (self.fill * orifice(self.supply_mpa, self.pressure_mpa)).max(0.0);
        let rate = (filled + self.vent * orifice(0.0, self.pressure_mpa)) / TAU_S;
        let leak = self.leak_mpa_per_s * (self.pressure_mpa / 0.1);
        self.pressure_mpa = (self.pressure_mpa + (rate - leak) * dt_s).max(0.0);
    }
}

/// Change of the pressure per second of a chamber with a time constant of a second, from one pressure to the other.
fn orifice(from_mpa: f64, chamber_mpa: f64) -> f64 {
    let (from, to) = (from_mpa + AIR_MPA, chamber_mpa + AIR_MPA);
    let (up, down, sign) = if from > to { (from, to, 1.0) } else { (to, from, -1.0) };
    let ratio = down / up;
    let part = if ratio < 0.528 { 1.0 } else { (1.0 - ((ratio - 0.528) / 0.472).powi(2)).max(0.0).sqrt() };
    sign * up * part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, stream};

    fn chamber(pressure_mpa: f64, supply_mpa: f64, leak_mpa_per_s: f64) -> Chamber {
        Chamber::new(pressure_mpa, supply_mpa, leak_mpa_per_s, stream(1, "r", "a", 0, Purpose::Regulator), 0)
    }

    #[test]
    fn a_valve_closes_by_itself_after_its_pulse_and_after_a_second_at_the_latest() {
        for (for_ms, lasted_us) in [(50.0, 50_000), (5000.0, 1_000_000)] {
            let mut chamber = chamber(0.05, 0.25, 0.0);
            assert_eq!(chamber.obey(Opening::Fill, for_ms, 0), None);
            assert_eq!(chamber.advance(3_000_000), Some(Pulse { is_fill: true, lasted_us }));
            let full_mpa = chamber.pressure_mpa();
            chamber.advance(6_000_000);
            assert_eq!(chamber.pressure_mpa(), full_mpa);
            assert!(full_mpa > 0.05);
        }
    }

    #[test]
    fn another_pulse_and_close_end_the_one_before() {
        let mut chamber = chamber(0.1, 0.25, 0.0);
        chamber.obey(Opening::Fill, 100.0, 0);
        assert_eq!(chamber.obey(Opening::Vent, 100.0, 20_000), Some(Pulse { is_fill: true, lasted_us: 20_000 }));
        assert_eq!(chamber.obey(Opening::Close, 0.0, 50_000), Some(Pulse { is_fill: false, lasted_us: 30_000 }));
        assert_eq!(chamber.advance(500_000), None);
    }

    #[test]
    fn a_chamber_leaks_and_an_empty_supply_takes_no_air() {
        let mut leaking = chamber(0.1, 0.25, 0.001);
        leaking.advance(1_000_000);
        assert!((leaking.pressure_mpa() - 0.099).abs() < 1e-4);
        let mut empty = chamber(0.1, 0.02, 0.0);
        empty.obey(Opening::Fill, 1000.0, 0);
        empty.advance(2_000_000);
        assert_eq!(empty.pressure_mpa(), 0.1);
    }
}
