//! Predicts the readings of a chamber's pressure, for one hypothesis of [`super::leak_test`].
//!
//! A reading is the pressure plus noise, rounded to a step of the sensor. So a reading tells in which step the pressure
//! lies, and the density of a reading is the probability of that step.

use borsh::{BorshDeserialize, BorshSerialize};

/// Random walk of a pressure behind shut valves, in refills per square root of a second: temperature, creep.
const WALK: f64 = 0.01;
/// The same for the middle of a band.
const MIDDLE_WALK: f64 = 0.02;
/// Mean and standard deviation of a refill, in smallest refills; venting is the same downwards.
const REFILL: (f64, f64) = (2.0, 1.5);
/// Probability of a jump at any reading: valves tremble, robots are moved.
const RARE: f64 = 0.001;
/// Density of a reading that has nothing to do with the last one, per refill.
const ANYWHERE: f64 = 2e-4;
/// Largest probability of a refill between two readings, and largest fall, in refills: a regulator holds the band.
const REFILLED_MAX: f64 = 0.7;
const FALL_MAX: f64 = 3.0;
/// Least share of a case that counts, and least variance of a pressure, in refills squared.
const LEAST_SHARE: f64 = 1e-5;
const LEAST_VARIANCE: f64 = 1e-4;

/// Rate of loss that a hypothesis assumes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loss {
    /// Share of the gauge pressure, per second.
    pub per_s: f64,
    /// Relative standard deviation.
    pub sd: f64,
}

/// Pressure that a hypothesis predicts: mean and variance, in smallest refills.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(super) struct Track {
    refills: f32,
    variance: f32,
}

/// A reading, in smallest refills, with the time since the last one and the variance of the sensor's noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    pub refills: f64,
    pub gap_s: f64,
    pub noise: f64,
    /// Half a step of the sensor, in smallest refills.
    pub half_step: f64,
}

impl Reading {
    /// Variance of its error, in smallest refills squared: noise, and the rounding to a step.
    pub(super) fn variance(&self) -> f64 {
        self.noise + rounding(self.half_step)
    }
}

/// Variance of the rounding to a step, in smallest refills squared.
pub(super) fn rounding(half_step: f64) -> f64 {
    half_step.powi(2) / 3.0
}

impl Track {
    /// A pressure known from one reading, with this variance.
    pub(super) fn new(refills: f64, variance: f64) -> Self {
        Self { refills: refills as f32, variance: variance as f32 }
    }

    /// Predicted pressure, in refills.
    pub(super) fn refills(&self) -> f64 {
        self.refills.into()
    }

    /// Distance of a reading from the prediction, in refills.
    pub(super) fn off(&self, refills: f64) -> f64 {
        refills - f64::from(self.refills)
    }

    /// The pressure falls, and jumps at times. Predicts a reading, learns from it, and returns its density.
    pub(super) fn fall(&mut self, loss: Loss, reading: &Reading) -> f64 {
        self.drift(loss, reading, 1.0)
    }

    /// The same for a pressure that rises at the rate of a loss, and is vented.
    pub(super) fn rise(&mut self, loss: Loss, reading: &Reading) -> f64 {
        self.drift(loss, reading, -1.0)
    }

    /// The pressure falls if `down` is 1, and rises if it is -1.
    fn drift(&mut self, loss: Loss, reading: &Reading, down: f64) -> f64 {
        let fallen = loss.per_s * reading.gap_s * f64::from(self.refills);
        let fall = fallen.min(FALL_MAX);
        let variance = f64::from(self.variance) + WALK.powi(2) * reading.gap_s + (loss.sd * fall).powi(2);
        // Relative to the reading, so that small numbers remain.
        let mean = -self.off(reading.refills) - down * fall;
        let refilled = RARE + (fallen / REFILL.0).min(REFILLED_MAX);
        let jumped = variance + REFILL.1.powi(2);
        let cases = [
            (1.0 - refilled - RARE - ANYWHERE, mean, variance),
            (refilled, mean + down * REFILL.0, jumped),
            (RARE, mean - down * REFILL.0, jumped),
        ];
        let anywhere = ANYWHERE * 2.0 * reading.half_step;
        let (mut density, mut first, mut second) = (anywhere, 0.0, anywhere * reading.variance());
        for (share, mean, variance) in cases {
            let Some(seen) = Seen::new(mean, variance, reading) else { continue };
            let weight = share * seen.share;
            density += weight;
            first += weight * seen.mean;
            second += weight * (seen.variance + seen.mean.powi(2));
        }
        let mean = first / density;
        let variance = (second / density - mean.powi(2)).max(LEAST_VARIANCE);
        *self = Self::new(reading.refills + mean, variance);
        density
    }

    /// The pressure is anywhere in a band of this width, whatever it was at the last reading. Predicts a reading, learns the
    /// middle of the band from it, and returns its density.
    pub(super) fn scatter(&mut self, width: f64, reading: &Reading) -> f64 {
        let (step, error) = (2.0 * reading.half_step, reading.variance());
        let variance = f64::from(self.variance) + MIDDLE_WALK.powi(2) * reading.gap_s;
        let off = self.off(reading.refills);
        let sd = (variance + error).sqrt();
        let [low, high] = [off - 0.5 * width, off + 0.5 * width].map(|edge| normal(edge / sd).0);
        let density = step * (1.0 - ANYWHERE) * (high - low) / width;
        let spread = width.powi(2) / 12.0 + error;
        *self = if density < step * ANYWHERE {
            Self::new(reading.refills, spread)
        } else {
            let gain = variance / (variance + spread);
            Self::new(reading.refills - off * (1.0 - gain), variance * (1.0 - gain))
        };
        density + step * ANYWHERE
    }
}

/// A normal pressure of which a step is read.
struct Seen {
    /// Probability of the step.
    share: f64,
    /// Mean and variance of the pressure, given the step.
    mean: f64,
    variance: f64,
}

impl Seen {
    /// The step's middle is 0. None if the step is too improbable.
    fn new(mean: f64, variance: f64, reading: &Reading) -> Option<Self> {
        let all = variance + reading.noise;
        let sd = all.sqrt();
        let [low, high] = [-reading.half_step - mean, reading.half_step - mean].map(|edge| edge / sd);
        let ([below, at_low], [until, at_high]) = (normal(low).into(), normal(high).into());
        let share: f64 = until - below;
        if share < LEAST_SHARE * 2.0 * reading.half_step {
            return None;
        }
        let first: f64 = (at_low - at_high) / share;
        let second: f64 = (low * at_low - high * at_high) / share;
        let narrower = variance * (1.0 + variance / all * (second - first.powi(2)));
        Some(Self { share, mean: mean + variance / sd * first, variance: narrower.max(LEAST_VARIANCE) })
    }
}

/// Distribution and density of a standard normal number. The distribution is exact to 1e-7 (Abramowitz and Stegun, 7.1.26).
fn normal(x: f64) -> (f64, f64) {
    const BY_POWER: [f64; 5] = [0.254_829_592, -0.284_496_736, 1.421_413_741, -1.453_152_027, 1.061_405_429];
    let bell = (-0.5 * x.powi(2)).exp();
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs() * std::f64::consts::FRAC_1_SQRT_2);
    let beyond = 0.5 * bell * BY_POWER.iter().rev().fold(0.0, |sum, power| (sum + power) * t);
    let density = bell * 0.5 * std::f64::consts::FRAC_2_SQRT_PI * std::f64::consts::FRAC_1_SQRT_2;
    (if x < 0.0 { beyond } else { 1.0 - beyond }, density)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_the_normal_distribution_is_that_of_tables() {
        for (x, below) in
            [(-3.0, 0.001_349_90), (-1.0, 0.158_655_25), (0.0, 0.5), (0.5, 0.691_462_46), (2.0, 0.977_249_87)]
        {
            assert!((normal(x).0 - below).abs() < 2e-7, "{x}: {:?}", normal(x));
        }
        assert!((normal(1.0).1 - 0.241_970_72).abs() < 1e-8);
    }

    #[test]
    fn property_a_step_that_is_read_leaves_the_mean_and_variance_that_sums_give() {
        for (mean, variance, noise, half_step) in [
            (0.0, 0.01, 0.06, 0.5),
            (0.4, 0.3, 0.06, 0.5),
            (-1.2, 2.0, 0.1, 0.5),
            (0.9, 0.05, 0.2, 0.5),
            (0.3, 0.2, 0.1, 0.1),
        ] {
            let (mut share, mut first, mut second) = (0.0, 0.0, 0.0);
            let (sd, noise_sd) = (f64::sqrt(variance), f64::sqrt(noise));
            for k in -6000..6000 {
                let z = f64::from(k) / 1000.0;
                let x = mean + sd * z;
                let read = normal((half_step - x) / noise_sd).0 - normal((-half_step - x) / noise_sd).0;
                let weight = normal(z).1 * read / 1000.0;
                share += weight;
                first += weight * x;
                second += weight * x * x;
            }
            let (first, second) = (first / share, second / share);
            let reading = Reading { refills: 0.0, gap_s: 1.0, noise, half_step };
            let seen = Seen::new(mean, variance, &reading).expect("a likely step");
            assert!((seen.share - share).abs() < 1e-5, "{share} {}", seen.share);
            assert!((seen.mean - first).abs() < 1e-4, "{first} {}", seen.mean);
            assert!((seen.variance - (second - first * first)).abs() < 1e-4, "{second} {}", seen.variance);
        }
    }
}
