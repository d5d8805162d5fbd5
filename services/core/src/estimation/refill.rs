//! Whether a regulator keeps filling although its setpoint stands, from pressures alone.
//!
//! A leaking chamber that is refilled falls slowly and rises at once. Played backwards that would be another curve,
//! while a chamber that stands still, its sensor's noise and steps, and valves that let out what they let in too
//! much, are the same in either direction. So the cubes of the changes from one reading to the next add up to
//! nothing in a sound chamber, however coarse the sensor, and to (loss per second) x (size of a refill)^2 x time in
//! a leaking one. Averages over 1, 2, 4, 8 and 16 readings see refills that are as far apart. The sum of the sixth
//! powers, over that of the cubes, is the cube of a refill's size; so the loss itself comes out, to a factor of two
//! or so, and rather too low.
//!
//! Refills that come faster than readings leave no such trace, but make the readings leap: by more than one
//! refill from one reading to the next, which its noise alone hardly ever does.

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
/// A leap is one by more than this many refills ...
const LEAP_REFILLS: f64 = 1.5;
/// ... between readings no further apart than this, in seconds.
const LEAP_GAP_S: f64 = 2.5;
/// A change by more than this many refills counts as so many: nothing that happens once weighs more.
const CHANGE_MAX: f64 = 4.0;
/// Lower bounds are so many standard deviations below the estimate. They are asked for again and again for as long
/// as a chamber lives.
const BOUND_SDS: f64 = 3.0;

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
    sum: f64,
    last: Option<f64>,
    cubes: f64,
    squared_cubes: f64,
}

impl Refills {
    /// What was between the readings before and those to come is not known.
    pub fn interrupt(&mut self) {
        self.last = None;
        for scale in &mut self.scales {
            (scale.readings, scale.sum, scale.last) = (0, 0.0, None);
        }
    }

    /// Takes one reading in. Those that are older than the last one change nothing.
    pub fn read(&mut self, refill_mpa: f64, at: Micros, mpa: f64) {
        if self.last.is_some_and(|(before, _)| at.since(before).as_s() > GAP_MAX_S) {
            self.interrupt();
        }
        let refills = mpa / refill_mpa;
        if let Some((before, before_refills)) = self.last {
            if at <= before {
                return;
            }
            self.pass(at.since(before).as_s(), refills - before_refills);
        }
        self.last = Some((at, refills));
        for (scale, readings) in self.scales.iter_mut().zip(SCALES) {
            scale.add(readings, refills);
        }
    }

    fn pass(&mut self, seconds: f64, leap: f64) {
        let keep = (-seconds / MEMORY_S).exp();
        self.leaps *= keep;
        self.seconds = self.seconds * keep + seconds;
        for scale in &mut self.scales {
            scale.cubes *= keep;
            scale.squared_cubes *= keep;
        }
        if seconds <= LEAP_GAP_S && leap.abs() > LEAP_REFILLS {
            self.leaps += 1.0;
        }
    }

    /// Lower bound of the pressure that refills make good, MPa per second; 0 where there may be none. `refill_mpa` is
    /// the least refill.
    #[must_use]
    pub fn least_mpa_per_s(&self, refill_mpa: f64) -> f64 {
        if self.seconds < LEAST_S {
            return 0.0;
        }
        refill_mpa * self.scales.iter().map(Scale::least_sum).fold(0.0, f64::max) / self.seconds
    }

    /// Lower bound of the leaps per second.
    #[must_use]
    pub fn least_leaps_per_s(&self) -> f64 {
        (self.leaps - BOUND_SDS * self.leaps.sqrt()).max(0.0) / self.seconds.max(LEAST_S)
    }
}

impl Scale {
    /// Lower bound of the sum of refills.
    fn least_sum(&self) -> f64 {
        let cubes = self.cubes - BOUND_SDS * self.squared_cubes.sqrt();
        if cubes <= 0.0 {
            return 0.0;
        }
        let size = (self.squared_cubes / self.cubes).cbrt().max(1.0);
        cubes / size.powi(2)
    }

    fn add(&mut self, readings: u32, refills: f64) {
        self.readings += 1;
        self.sum += refills;
        if self.readings < readings {
            return;
        }
        let mean = self.sum / f64::from(readings);
        if let Some(last) = self.last {
            let cube = (mean - last).clamp(-CHANGE_MAX, CHANGE_MAX).powi(3);
            self.cubes += cube;
            self.squared_cubes += cube.powi(2);
        }
        (self.readings, self.sum, self.last) = (0, 0.0, Some(mean));
    }
}
