//! The strain without a touch, and its noise.
//!
//! A filter of first order whose input is limited to three standard deviations: drift and temperature are followed, and
//! a touch hardly moves it before it is found. After a contact it is fast at first and slows down with time, as the
//! rubber creeps back: fastest in the first tenths of a second, and for half a minute. The noise is known apart for a
//! whisker that shakes.

use crate::Params;
use crate::intake::Bin;

/// Time constant of the noise, and while the whisker shakes. s.
const NOISE_S: [f64; 2] = [3.0, 0.5];
/// The noise is measured so long after a contact. s.
const NOISE_AFTER_S: f64 = 1.0;
/// Fastest time constant of the baseline, right after a contact. s.
const FASTEST_S: f64 = 0.05;
/// Part of the time since a contact that is the time constant.
const OF_TIME: f64 = 0.3;
/// Time in which the strain must be still to learn its noise at the start; and when it was not for the third time. s.
const LEARN_S: (f64, f64, f64) = (0.4, 0.1, 3.0);
const LEARN_BINS: u32 = 8;
/// The strain is still if its variance is at most this multiple of that of neighbours' differences.
const STILL: f64 = 6.0;
/// And its standard deviation at most this multiple of the mean difference of samples, which glitches do not raise.
const ROUGH: f64 = 4.0;
/// Shaking in a range of fewer standard deviations is weak: the variance grows by this factor with each bin.
const WEAK: (f64, f64) = (14.0, 1.05);
/// Part of the range of the strain that is its noise when it begins to shake.
const OF_RANGE: f64 = 0.1;

/// Baseline of both gauges.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Baseline {
    pub(crate) strain: f64,
    pub(crate) strain_2: f64,
    /// Calm, and while the whisker shakes.
    variance: [f64; 2],
    shaking: usize,
    last_s: f64,
    /// Time since which it is followed.
    since_s: f64,
    learning: Option<Still>,
    learned: bool,
}

/// Sums of a time in which the strain may be still.
#[derive(Clone, Copy, Debug)]
struct Still {
    begin_s: f64,
    since_s: f64,
    bins: u32,
    strain: f64,
    strain_2: f64,
    variance: f64,
    differences: f64,
    last: f64,
}

impl Baseline {
    /// Begins at a level.
    pub(crate) fn begin(&mut self, t_s: f64, strain: f64, strain_2: f64) {
        self.strain = strain;
        self.strain_2 = strain_2;
        self.since_s = t_s;
        self.last_s = t_s;
    }

    /// Standard deviation of a bin.
    pub(crate) fn sd(&self, grain: f64) -> f64 {
        self.sd_of(self.shaking, grain)
    }

    /// The same without shaking.
    pub(crate) fn calm_sd(&self, grain: f64) -> f64 {
        self.sd_of(0, grain)
    }

    /// The same while it shakes.
    pub(crate) fn shaking_sd(&self, grain: f64) -> f64 {
        self.sd_of(1, grain)
    }

    fn sd_of(&self, shaking: usize, grain: f64) -> f64 {
        // Noise below the converter's step is not seen.
        (self.variance[shaking] + grain * grain / 12.0).sqrt()
    }

    /// Whether the noise is known.
    pub(crate) fn ready(&self) -> bool {
        self.learned
    }

    /// Takes note of whether the whisker shakes, in this range.
    pub(crate) fn shake(&mut self, shaking: bool, range: f64, grain: f64) {
        self.shaking = usize::from(shaking);
        // The noise may be larger than was learned: weak shaking that does not end.
        let calm_sd = self.calm_sd(grain);
        if shaking && range < WEAK.0 * calm_sd {
            self.variance[0] = WEAK.1 * calm_sd * calm_sd;
        }
        if shaking && self.variance[1] == 0.0 {
            self.variance[1] = self.variance[0].max((OF_RANGE * range).powi(2));
        }
    }

    /// Noise that was learned in a movement, or grew with touches, comes back: neighbours hardly differ.
    pub(crate) fn limit_noise(&mut self, roughness: f64, grain: f64) {
        if self.shaking == 0 {
            self.variance[0] = self.variance[0].min((ROUGH * roughness).powi(2) + grain * grain);
        }
    }

    /// Learns level and noise from the first time in which the strain is still.
    pub(crate) fn learn(&mut self, bin: &Bin, grain: f64, roughness: f64) {
        let still = self.learning.get_or_insert_with(|| Still::new(bin, bin.t_s));
        if bin.t_s > still.since_s {
            still.add(bin);
        }
        let long_s = if bin.t_s - still.begin_s > LEARN_S.2 { LEARN_S.1 } else { LEARN_S.0 };
        if bin.t_s - still.since_s < long_s || still.bins < LEARN_BINS {
            return;
        }
        let differences = still.differences / (2.0 * f64::from(still.bins - 1));
        let most = (STILL * differences).min((ROUGH * roughness).powi(2));
        if still.variance > most + grain * grain {
            self.learning = Some(Still::new(bin, still.begin_s));
            return;
        }
        let Still { strain, strain_2, variance, .. } = *still;
        self.begin(bin.t_s, strain, strain_2);
        self.variance[0] = variance;
        self.learning = None;
        self.learned = true;
    }

    /// Follows air that moves the baseline.
    pub(crate) fn follow_air(&mut self, bin: &Bin) {
        let dt_s = (bin.t_s - self.last_s).max(0.0);
        self.begin(bin.t_s, self.strain, self.strain_2);
        let weight = dt_s / (FASTEST_S + dt_s);
        self.strain += weight * (bin.strain - self.strain);
        self.strain_2 += weight * (bin.strain_2.unwrap_or(0.0) - self.strain_2);
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
        if age_s > NOISE_AFTER_S || self.shaking == 1 {
            // The beginning of a slow touch must not count as noise. Limited, noise seems 5 % smaller in variance.
            let sd = 2.5 * self.sd(grain);
            let limited = residual.clamp(-sd, sd);
            let variance = &mut self.variance[self.shaking];
            *variance += dt_s / (NOISE_S[self.shaking] + dt_s) * (1.05 * limited * limited - *variance);
        }
    }
}

impl Still {
    fn new(bin: &Bin, begin_s: f64) -> Still {
        Still {
            begin_s,
            since_s: bin.t_s,
            bins: 1,
            strain: bin.strain,
            strain_2: bin.strain_2.unwrap_or(0.0),
            variance: 0.0,
            differences: 0.0,
            last: bin.strain,
        }
    }

    fn add(&mut self, bin: &Bin) {
        self.bins += 1;
        let weight = 1.0 / f64::from(self.bins);
        let before = bin.strain - self.strain;
        self.strain += weight * before;
        self.variance += weight * (before * (bin.strain - self.strain) - self.variance);
        self.strain_2 += weight * (bin.strain_2.unwrap_or(0.0) - self.strain_2);
        self.differences += (bin.strain - self.last).powi(2);
        self.last = bin.strain;
    }
}
