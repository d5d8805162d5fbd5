//! A simulated chamber: flow by ISO 6358, valves that take time to move, and a sensor with steps and noise.

use vibrissa_regulator::{Command, Condition, Params, Regulator, Valves};

/// Step of a 10-bit converter with MPa = (V - 1) / 4.
pub(crate) const STEP_MPA: f64 = 5.0 / 1024.0 / 4.0;
const AIR_MPA: f64 = 0.101_325;
/// Step of the simulation. µs.
const DT_US: u64 = 100;

/// Random numbers by SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }
}

/// Behaviour of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sensor {
    Good,
    /// Always the same reading.
    Frozen(f32),
    /// At the lower or the upper end of the converter.
    Dead,
    Saturated,
    NotANumber,
}

/// The chamber with its valves, and the regulator.
pub(crate) struct Rig {
    pub(crate) regulator: Regulator,
    valves: Valves,
    random: Random,
    pub(crate) now_us: u64,
    pub(crate) true_mpa: f64,
    pub(crate) supply_mpa: f64,
    /// Whether the regulator reads the supply.
    pub(crate) supply_sensor: bool,
    /// Time constant of the chamber with an open valve. s.
    pub(crate) tau_s: f64,
    /// Leak at 0.1 MPa, in MPa per second; it is proportional to the pressure.
    pub(crate) leak_mpa_per_s: f64,
    /// Part of a change that is lost as the air cools, within a second.
    pub(crate) cooling: f64,
    warmth_mpa: f64,
    pub(crate) noise_steps: f64,
    pub(crate) sensor: Sensor,
    pub(crate) fill_stuck: Option<f64>,
    pub(crate) vent_stuck: Option<f64>,
    open_ms: f64,
    close_ms: f64,
    fill_open: f64,
    vent_open: f64,
    pub(crate) reading_us: u64,
    pub(crate) highest_mpa: f64,
    pub(crate) pulses: u32,
    /// Times of commands and readings, for the vectors of the C++ regulator.
    pub(crate) log: Vec<(u64, f32, Option<f32>, Command, Condition)>,
    pub(crate) keep_log: bool,
}

impl Rig {
    pub(crate) fn new(params: Params, seed: u64) -> Rig {
        let mut random = Random(seed);
        Rig {
            regulator: Regulator::new(params),
            valves: Valves::new(),
            now_us: 0,
            true_mpa: 0.0,
            supply_mpa: 0.25,
            supply_sensor: false,
            tau_s: 0.3 * 10f64.powf(random.unit()),
            leak_mpa_per_s: 0.0,
            cooling: random.between(0.0, 0.05),
            warmth_mpa: 0.0,
            noise_steps: random.between(0.0, 0.5),
            sensor: Sensor::Good,
            fill_stuck: None,
            vent_stuck: None,
            open_ms: random.between(3.0, 8.0),
            close_ms: random.between(2.0, 5.0),
            fill_open: 0.0,
            vent_open: 0.0,
            reading_us: [1_000, 2_000, 10_000][(random.unit() * 3.0) as usize],
            highest_mpa: 0.0,
            pulses: 0,
            log: Vec::new(),
            keep_log: false,
            random,
        }
    }

    fn reading(&mut self) -> f32 {
        match self.sensor {
            Sensor::Frozen(mpa) => mpa,
            Sensor::Dead => -0.25,
            Sensor::Saturated => 1.0,
            Sensor::NotANumber => f32::NAN,
            Sensor::Good => {
                let mpa = self.true_mpa + self.random.normal() * self.noise_steps * STEP_MPA;
                // The middle of the converter's step.
                (((mpa / STEP_MPA).floor() + 0.5) * STEP_MPA) as f32
            }
        }
    }

    /// Runs for so many seconds; calls `each` after each reading.
    pub(crate) fn run(&mut self, seconds: f64, mut each: impl FnMut(&Rig)) {
        let end_us = self.now_us + (seconds * 1e6) as u64;
        let mut reads_us = self.now_us.next_multiple_of(self.reading_us);
        while self.now_us < end_us {
            if self.now_us == reads_us {
                reads_us += self.reading_us;
                let reading = self.reading();
                let supply = self.supply_sensor.then_some(self.supply_mpa as f32);
                let command = self.regulator.step(self.now_us, reading, supply);
                if let Command::Fill(us) | Command::Vent(us) = command {
                    assert!(us <= 1_000_000, "a pulse of {us} us");
                    self.pulses += 1;
                }
                self.valves.apply(self.now_us, command);
                if self.keep_log {
                    self.log.push((self.now_us, reading, supply, command, self.regulator.condition()));
                }
                each(self);
            }
            let (fill, vent) = self.valves.outputs(self.now_us);
            self.flow(fill, vent);
            self.now_us += DT_US;
        }
    }

    fn flow(&mut self, fill: bool, vent: bool) {
        let dt_s = DT_US as f64 * 1e-6;
        let (open_ms, close_ms) = (self.open_ms, self.close_ms);
        let towards = |position: f64, open: bool, stuck: Option<f64>| {
            let moved = if open { dt_s * 1e3 / open_ms } else { -dt_s * 1e3 / close_ms };
            stuck.unwrap_or((position + moved).clamp(0.0, 1.0))
        };
        self.fill_open = towards(self.fill_open, fill, self.fill_stuck);
        self.vent_open = towards(self.vent_open, vent, self.vent_stuck);
        // Both valves are closed nearly all the time.
        let through = |open: f64, from_mpa| if open > 0.0 { open * orifice(from_mpa, self.true_mpa) } else { 0.0 };
        let rate = (through(self.fill_open, self.supply_mpa) + through(self.vent_open, 0.0)) / self.tau_s;
        let cooled = self.warmth_mpa * dt_s / 0.5;
        self.warmth_mpa += self.cooling * rate * dt_s - cooled;
        self.true_mpa += rate * dt_s - cooled - self.leak_mpa_per_s * (self.true_mpa / 0.1).max(0.0) * dt_s;
        self.highest_mpa = self.highest_mpa.max(self.true_mpa);
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
