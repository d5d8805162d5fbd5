//! The strain without a touch, and its noise.
//!
//! A filter of first order whose input is limited to three standard deviations: drift and temperature are followed, and
//! a touch hardly moves it before it is found. After a contact it is fast at first and slows down with time, as the
//! rubber creeps back: fastest in the first tenths of a second, and for half a minute.

use crate::Params;
use crate::intake::Bin;

/// Time constant of the noise. s.
const NOISE_S: f64 = 3.0;
/// The noise is measured so long after a contact. s.
const NOISE_AFTER_S: f64 = 1.0;
/// Fastest time constant of the baseline, right after a contact. s.
const FASTEST_S: f64 = 0.05;
/// Part of the time since a contact that is the time constant.
const OF_TIME: f64 = 0.3;
/// Time to learn baseline and noise at the start. s.
const LEARN_S: f64 = 0.4;

/// Baseline of both gauges.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Baseline {
    pub(crate) strain: f64,
    pub(crate) strain_2: f64,
    variance: f64,
    last_s: f64,
    /// Time since which it is followed.
    since_s: f64,
    bins: u32,
    begun: bool,
    learned: bool,
}

impl Baseline {
    /// Begins at a bin, keeping the noise if it is known.
    pub(crate) fn begin(&mut self, bin: &Bin, strain: f64, strain_2: f64) {
        self.strain = strain;
        self.strain_2 = strain_2;
        self.since_s = bin.t_s;
        self.last_s = bin.t_s;
        self.bins = 0;
        self.begun = true;
    }

    pub(crate) fn begun(&self) -> bool {
        self.begun
    }

    /// Standard deviation of a bin.
    pub(crate) fn sd(&self, grain: f64) -> f64 {
        // Noise below the converter's step is not seen.
        (self.variance + grain * grain / 12.0).sqrt()
    }

    /// Whether enough is known to find contacts.
    pub(crate) fn ready(&self) -> bool {
        self.learned
    }

    /// Learns from bins before the first contact.
    pub(crate) fn learn(&mut self, bin: &Bin) {
        self.bins += 1;
        let weight = 1.0 / f64::from(self.bins);
        let before = bin.strain - self.strain;
        self.strain += weight * before;
        // Welford's sum. Differences of neighbours would be too small: the median of three makes them alike.
        self.variance += weight * (before * (bin.strain - self.strain) - self.variance);
        self.strain_2 += weight * (bin.strain_2.unwrap_or(0.0) - self.strain_2);
        self.last_s = bin.t_s;
        self.learned = bin.t_s - self.since_s > LEARN_S && self.bins >= 8;
    }

    /// Follows the strain while nothing touches.
    pub(crate) fn follow(&mut self, params: &Params, bin: &Bin, grain: f64) {
        let dt_s = (bin.t_s - self.last_s).max(0.0);
        self.last_s = bin.t_s;
        let age_s = bin.t_s - self.since_s;
        let constant_s = (OF_TIME * age_s).clamp(FASTEST_S, params.baseline_s);
        let settled = constant_s >= params.baseline_s;
        let residual = bin.strain - self.strain;
        let most = 3.0 * self.sd(grain).max(f64::MIN_POSITIVE);
        let limited = if settled { residual.clamp(-most, most) } else { residual };
        let weight = dt_s / (constant_s + dt_s);
        self.strain += weight * limited;
        if let Some(strain_2) = bin.strain_2 {
            self.strain_2 += weight * (strain_2 - self.strain_2);
        }
        if age_s > NOISE_AFTER_S {
            // The beginning of a slow touch must not count as noise. Limited, noise seems 5 % smaller in variance.
            let sd = 2.5 * self.sd(grain);
            let limited = residual.clamp(-sd, sd);
            self.variance += dt_s / (NOISE_S + dt_s) * (1.05 * limited * limited - self.variance);
        }
    }
}
