//! Whether a regulator keeps filling although its setpoint stands, from pressures alone.
//!
//! A leaking chamber that is refilled falls slowly and rises at once. Played backwards that would be another curve,
//! while a chamber that stands still, its sensor's noise and steps, and valves that let out what they let in too
//! much, are the same in either direction. So the cubes of the changes from one reading to the next add up to
//! nothing in a sound chamber, however coarse the sensor, and to (loss per second) x (size of a refill)^2 x time in
//! a leaking one. Averages over 1, 2, 4, 8 and 16 readings see refills that are as far apart. In units of the
//! sensor's step, which is about what cheap valves let in, the sum over the time estimates the loss itself, to a
//! factor of two or so.
//!
//! Refills that come faster than readings leave no such trace, but make the readings leap: by more than one step
//! of the sensor from one reading to the next, which its noise alone hardly ever does.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::units::Micros;

/// Averages of so many readings are compared.
const SCALES: [u32; 5] = [1, 2, 4, 8, 16];
/// Time constant with which changes fade, in seconds.
const MEMORY_S: f64 = 150.0;
/// Nothing is told sooner, and counts are spread over no less, in seconds.
const LEAST_S: f64 = 60.0;
/// Readings further apart than this say nothing about what was between them, in seconds.
const GAP_MAX_S: f64 = 20.0;
/// A leap is one by more than this many steps of the sensor ...
const LEAP_STEPS: f64 = 1.5;
/// ... between readings no further apart than this, in seconds.
const LEAP_GAP_S: f64 = 2.5;
/// Lower bounds are so many standard deviations below the estimate: one-sided 97.5 %.
const BOUND_SDS: f64 = 2.0;

/// One source's readings: each is in order by itself.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Refills {
    last: Option<(Micros, f64)>,
    scales: [Scale; SCALES.len()],
    leaps: f64,
    seconds: f64,
}

/// Changes of averages over one number of readings.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Scale {
    readings: u32,
    steps: f64,
    last: Option<f64>,
    cubes: f64,
    squared_cubes: f64,
}

impl Refills {
    /// What was between the readings before and those to come is not known.
    pub fn interrupt(&mut self) {
        self.last = None;
        for scale in &mut self.scales {
            (scale.readings, scale.steps, scale.last) = (0, 0.0, None);
        }
    }

    /// Takes one reading in. Those that are older than the last one change nothing.
    pub fn read(&mut self, sensor_step_mpa: f64, at: Micros, mpa: f64) {
        if self.last.is_some_and(|(before, _)| at.since(before).as_s() > GAP_MAX_S) {
            self.interrupt();
        }
        let steps = mpa / sensor_step_mpa;
        if let Some((before, before_steps)) = self.last {
            if at <= before {
                return;
            }
            self.pass(at.since(before).as_s(), steps - before_steps);
        }
        self.last = Some((at, steps));
        for (scale, readings) in self.scales.iter_mut().zip(SCALES) {
            scale.add(readings, steps);
        }
    }

    fn pass(&mut self, seconds: f64, leap: f64) {
        let keep = (-seconds / MEMORY_S).exp();
        self.leaps *= keep;
        self.seconds = self.seconds * keep + seconds;
        for scale in &mut self.scales {
            scale.cubes *= keep;
            scale.squared_cubes *= keep.powi(2);
        }
        if seconds <= LEAP_GAP_S && leap.abs() > LEAP_STEPS {
            self.leaps += 1.0;
        }
    }

    /// Lower bound of the pressure that refills make good, MPa per second; 0 where there may be none.
    #[must_use]
    pub fn least_mpa_per_s(&self, sensor_step_mpa: f64) -> f64 {
        if self.seconds < LEAST_S {
            return 0.0;
        }
        let bound = |scale: &Scale| scale.cubes - BOUND_SDS * scale.squared_cubes.sqrt();
        sensor_step_mpa * self.scales.iter().map(bound).fold(0.0, f64::max) / self.seconds
    }

    /// Lower bound of the leaps per second.
    #[must_use]
    pub fn least_leaps_per_s(&self) -> f64 {
        (self.leaps - BOUND_SDS * self.leaps.sqrt()).max(0.0) / self.seconds.max(LEAST_S)
    }
}

impl Scale {
    fn add(&mut self, readings: u32, steps: f64) {
        self.readings += 1;
        self.steps += steps;
        if self.readings < readings {
            return;
        }
        let mean = self.steps / f64::from(readings);
        if let Some(last) = self.last {
            let cube = (mean - last).powi(3);
            self.cubes += cube;
            self.squared_cubes += cube.powi(2);
        }
        (self.readings, self.steps, self.last) = (0, 0.0, Some(mean));
    }
}
