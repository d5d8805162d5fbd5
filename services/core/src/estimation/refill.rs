//! Detects from pressures alone that a regulator keeps refilling although its setpoint is constant.
//!
//! A leaking chamber with refills falls slowly and rises at once. Reversed in time that is another curve. A steady
//! chamber, its sensor's noise and steps, and valves that vent what they let in too much are the same in both
//! directions. So the cubes of the changes between readings add up to zero in a sound chamber, however coarse the
//! sensor, and to (loss per second) x (size of a refill)^2 x time in a leaking one. Averages over 1, 2, 4, 8 and 16
//! readings detect refills at such intervals. The sum of the sixth powers divided by that of the cubes is the cube
//! of a refill's size. So the loss can be estimated to a factor of about two, and rather too low.
//!
//! Refills faster than the readings leave no such trace, but make the readings leap: by more than one refill
//! between two readings, which noise alone hardly ever does.

use std::ops::RangeInclusive;

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::encoding;
use crate::units::Micros;

/// Number of scales: averages over 1, 2, 4, 8 and 16 readings.
const SCALES: usize = 5;
/// Number of readings in the longest average.
const LONGEST: u8 = 1 << (SCALES - 1);
/// Time constant with which old changes fade, in seconds.
const MEMORY_S: f64 = 150.0;
/// Least time that sums are divided by, in seconds.
const LEAST_S: f64 = 60.0;
/// Longest gap between readings, in seconds; after a longer one the averages start anew.
const GAP_MAX_S: f64 = 20.0;
/// A leap is a change of more than this many refills ...
const LEAP_REFILLS: f64 = 1.5;
/// ... between readings this far apart, in seconds. Noise makes the same share of the readings leap, however fast they come:
/// a hundred a second at the border of two sensor steps would leap as often as those of a leak.
const LEAP_GAP_S: RangeInclusive<f64> = 0.05..=2.5;
/// Changes are limited to this many refills, so that no single event dominates.
const CHANGE_MAX: f32 = 4.0;
/// Lower bounds lie this many standard deviations below the estimate, since they are tested again and again during
/// a chamber's life.
const BOUND_SDS: f64 = 3.0;

/// Statistics of one source's readings, which are in time order.
///
/// Partial averages are not stored: they follow from the last averages of the shorter scales, two of which make one
/// of the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Refills {
    /// Time of the last reading, if there is any average.
    last_at: Micros,
    leaps: f32,
    seconds: f32,
    scales: [Scale; SCALES],
    /// Readings since the last average of the longest scale.
    readings: u8,
    /// Bit mask of the scales that have an average.
    averaged: u8,
}

/// Changes between averages over a fixed number of readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Scale {
    /// Last average, in refills; 0 before the first.
    last: f32,
    cubes: f32,
    squared_cubes: f32,
}

impl Refills {
    /// Starts new averages: the pressure between the readings so far and the next ones is unknown.
    pub fn interrupt(&mut self) {
        (self.last_at, self.readings, self.averaged) = (Micros::default(), 0, 0);
        self.scales.iter_mut().for_each(|scale| scale.last = 0.0);
    }

    /// Adds one reading. Readings older than the last one are ignored.
    pub fn read(&mut self, refill_mpa: f64, at: Micros, mpa: f64) {
        let before = self.last_at;
        if self.averaged != 0 && at.since(before).as_s() > GAP_MAX_S {
            self.interrupt();
        }
        let refills = (mpa / refill_mpa) as f32;
        if self.averaged != 0 {
            if at <= before {
                return;
            }
            // The averages of the first scale are the readings.
            self.pass(at.since(before).as_s(), refills - self.scales[0].last);
        }
        self.last_at = at;
        let mut mean = refills;
        for (index, scale) in self.scales.iter_mut().enumerate() {
            let bit = 1 << index;
            let before = scale.take(mean, self.averaged & bit != 0);
            self.averaged |= bit;
            if self.readings & bit == 0 {
                break;
            }
            // The second half of an average of the next scale.
            mean = 0.5 * (before + mean);
        }
        self.readings = (self.readings + 1) % LONGEST;
    }

    fn pass(&mut self, seconds: f64, leap: f32) {
        let keep = fading(seconds / MEMORY_S) as f32;
        self.leaps *= keep;
        self.seconds = self.seconds * keep + seconds as f32;
        for scale in &mut self.scales {
            scale.cubes *= keep;
            scale.squared_cubes *= keep;
        }
        if LEAP_GAP_S.contains(&seconds) && f64::from(leap.abs()) > LEAP_REFILLS {
            self.leaps += 1.0;
        }
    }

    /// Lower bound of the pressure replaced by refills, MPa per second; 0 if there may be none. `refill_mpa` is the
    /// smallest refill.
    #[must_use]
    pub fn least_mpa_per_s(&self, refill_mpa: f64) -> f64 {
        let most = self.scales.iter().map(Scale::least_sum).fold(0.0, f64::max);
        refill_mpa * most / f64::from(self.seconds).max(LEAST_S)
    }

    /// Lower bound of the number of leaps per second.
    #[must_use]
    pub fn least_leaps_per_s(&self) -> f64 {
        let leaps = f64::from(self.leaps);
        (leaps - BOUND_SDS * leaps.sqrt()).max(0.0) / f64::from(self.seconds).max(LEAST_S)
    }
}

impl Scale {
    /// Lower bound of the sum of refills, in units of the smallest refill.
    fn least_sum(&self) -> f64 {
        let [cubes, squared_cubes] = [self.cubes, self.squared_cubes].map(f64::from);
        let surely = cubes - BOUND_SDS * squared_cubes.sqrt();
        if surely <= 0.0 {
            return 0.0;
        }
        let size = (squared_cubes / cubes).cbrt().max(1.0);
        surely / size.powi(2)
    }

    /// Adds an average and returns the one before it.
    fn take(&mut self, mean: f32, has_last: bool) -> f32 {
        if has_last {
            let cube = (mean - self.last).clamp(-CHANGE_MAX, CHANGE_MAX).powi(3);
            self.cubes += cube;
            self.squared_cubes += cube.powi(2);
        }
        std::mem::replace(&mut self.last, mean)
    }
}

impl Refills {
    /// Writes the statistics; the time is written relative to `from`.
    pub fn write<W: Write>(&self, from: Micros, writer: &mut W) -> Result<()> {
        encoding::write_time(self.last_at, from, writer)?;
        (self.leaps, self.seconds, self.readings, self.averaged).serialize(writer)?;
        for (index, scale) in self.scales.iter().enumerate() {
            (scale.cubes, scale.squared_cubes).serialize(writer)?;
            if self.averaged & 1 << index != 0 {
                scale.last.serialize(writer)?;
            }
        }
        Ok(())
    }

    /// Reads the output of [`Self::write`].
    ///
    /// # Errors
    /// The bytes are not a valid encoding.
    pub fn read_again<R: Read>(from: Micros, reader: &mut R) -> Result<Self> {
        let mut read = Self { last_at: encoding::read_time(from, reader)?, ..Self::default() };
        (read.leaps, read.seconds, read.readings, read.averaged) = BorshDeserialize::deserialize_reader(reader)?;
        if read.readings >= LONGEST || read.averaged >= 1 << SCALES {
            return Err(encoding::invalid("too many readings or scales in the refill statistics"));
        }
        for (index, scale) in read.scales.iter_mut().enumerate() {
            (scale.cubes, scale.squared_cubes) = BorshDeserialize::deserialize_reader(reader)?;
            if read.averaged & 1 << index != 0 {
                scale.last = f32::deserialize_reader(reader)?;
            }
        }
        Ok(read)
    }
}

/// exp(-x), by its series where that is exact; it is evaluated for each reading.
fn fading(x: f64) -> f64 {
    if x < 0.05 { 1.0 - x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)))) } else { (-x).exp() }
}
