//! Does a chamber behind on/off valves leak? A sequential test, while a regulator refills it within a dead band.
//!
//! Each hypothesis assumes a rate of loss. It predicts the next pressure from the last ones: a fall at that rate, or one
//! of the rare jumps of valves, up by a refill or down by venting. A faster leak makes more refills, as many as replace the
//! loss. So falling lines and refills are judged together: a line that falls without refills, a step down without a line,
//! or refills without falls suit no leak. The likelihood ratios of the rates against a sound chamber add up over the
//! readings. A leak is called at [`CALLED_AT`], and is over at [`ENDED_AT`] in favour of a sound chamber against each
//! rate.
//!
//! Only statuses are evaluated: they come at a steady pace, also when the whisker is not touched.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::trend::Interval;
use crate::encoding;
use crate::units::Micros;

/// Rate of a sound chamber, per second: the highest that is sound, so that the ratio changes its sign at half of the least
/// leak.
const SOUND_PER_S: f64 = 1e-4;
/// Rates of leaks, per second.
const LEAKS: usize = 6;
const LEAKS_PER_S: [f64; LEAKS] = [1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2, 3.2e-2];
/// Relative error of a fall: rates between the hypotheses.
const RATE_SD: f64 = 0.35;
/// Standard deviation of a reading's error, in smallest refills: rounding and noise.
const NOISE: f64 = 0.42;
/// Random walk of a pressure behind shut valves, in refills per square root of a second: temperature, creep.
const WALK: f64 = 0.01;
/// Mean and standard deviation of a refill, in smallest refills; venting is the same downwards.
const REFILL: (f64, f64) = (2.0, 2.0);
/// Probability of a jump at any reading: valves tremble, robots are moved.
const RARE: f64 = 0.003;
/// Largest probability of a refill between two readings, and largest fall, in refills: a regulator holds the band.
const REFILLED_MAX: f64 = 0.7;
const FALL_MAX: f64 = 3.0;
/// Log likelihood ratio that calls a leak. The test is repeated all life long: sound chambers reached 7 in hours.
const CALLED_AT: f32 = 14.0;
/// The same in favour of a sound chamber that ends a leak. Leaks that are refilled faster than statuses come look sound
/// for some time.
const ENDED_AT: f32 = 60.0;
/// Bound of the ratios while a leak is called, so that another rate can become the likeliest.
const RATIO_MAX: f32 = 2.0 * ENDED_AT;
/// Bounds of one reading's contribution.
const CONTRIBUTION_MAX: f64 = 4.0;
/// Least and largest gap between two readings, in seconds; after a longer one the predictions begin anew.
const GAP_S: (f64, f64) = (0.5, 20.0);

/// Pressure that a hypothesis predicts: mean and variance, in smallest refills.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Track {
    refills: f32,
    variance: f32,
}

/// The test's state for one chamber.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct LeakTest {
    /// Time of the last reading; 0 before the first, and after a valve was moved on purpose.
    at: Micros,
    sound: Track,
    leaks: [Track; LEAKS],
    /// Of each rate against a sound chamber: at least 0 while no leak is called, at most 0 while one is.
    log_ratios: [f32; LEAKS],
}

impl LeakTest {
    /// The pressure may have changed on purpose: predictions begin anew.
    pub(super) fn interrupt(&mut self) {
        self.at = Micros::default();
    }

    /// Adds a status. Returns whether the chamber leaks from now on, if that has changed.
    pub(super) fn read(&mut self, is_leaking: bool, at: Micros, refills: f64) -> Option<bool> {
        let gap_s = at.since(self.at).as_s();
        if self.at == Micros::default() || gap_s > GAP_S.1 {
            let begun = Track { refills: refills as f32, variance: NOISE.powi(2) as f32 };
            (self.at, self.sound, self.leaks) = (at, begun, [begun; LEAKS]);
            return None;
        }
        if gap_s < GAP_S.0 {
            return None;
        }
        self.at = at;
        let sound = self.sound.follow(SOUND_PER_S * gap_s, gap_s, refills).ln();
        for ((track, log_ratio), per_s) in self.leaks.iter_mut().zip(&mut self.log_ratios).zip(LEAKS_PER_S) {
            let more = track.follow(per_s * gap_s, gap_s, refills).ln() - sound;
            let sum = *log_ratio + more.clamp(-CONTRIBUTION_MAX, CONTRIBUTION_MAX) as f32;
            *log_ratio = if is_leaking { sum.max(-RATIO_MAX) } else { sum.max(0.0) };
        }
        if is_leaking {
            self.bound();
        }
        let turns = if is_leaking {
            self.log_ratios.iter().all(|&ratio| ratio <= -ENDED_AT)
        } else {
            self.log_ratios.iter().any(|&ratio| ratio >= CALLED_AT)
        };
        turns.then(|| {
            self.begin(!is_leaking);
            !is_leaking
        })
    }

    /// Bounds of the rate with the largest likelihood: a factor of two in either direction.
    pub(super) fn likeliest(&self) -> Interval {
        let rates = LEAKS_PER_S.into_iter().zip(self.log_ratios);
        let mean = rates.max_by(|one, other| one.1.total_cmp(&other.1)).map_or(0.0, |(per_s, _)| per_s);
        Interval { mean, low: 0.5 * mean, high: 2.0 * mean }
    }

    /// The verdict has changed.
    pub(super) fn begin(&mut self, is_leaking: bool) {
        if is_leaking {
            self.bound();
        } else {
            self.log_ratios = [0.0; LEAKS];
        }
    }

    /// While a leak is called, the ratio of its likeliest rate is at most 0.
    fn bound(&mut self) {
        let most = self.log_ratios.iter().fold(0.0_f32, |most, &one| most.max(one));
        self.log_ratios.iter_mut().for_each(|one| *one -= most);
    }
}

impl Track {
    /// Predicts a reading, learns from it, and returns its density under the hypothesis. `fall` is the relative fall since
    /// the last reading.
    fn follow(&mut self, fall: f64, gap_s: f64, refills: f64) -> f64 {
        let fallen = fall * f64::from(self.refills);
        let fall = fallen.min(FALL_MAX);
        let mean = f64::from(self.refills) - fall;
        let variance = f64::from(self.variance) + WALK.powi(2) * gap_s + (RATE_SD * fall).powi(2);
        let refilled = RARE + (fallen / REFILL.0).min(REFILLED_MAX);
        let shut = (1.0 - refilled - RARE, 0.0, 0.0);
        let cases = [shut, (refilled, REFILL.0, REFILL.1), (RARE, -REFILL.0, REFILL.1)];
        let (mut density, mut first, mut second) = (0.0, 0.0, 0.0);
        for (share, jump, sd) in cases {
            let (before, prior) = (mean + jump, variance + sd.powi(2));
            let (off, all) = (refills - before, prior + NOISE.powi(2));
            let weight = share * (-0.5 * off.powi(2) / all).exp() / all.sqrt();
            let after = before + off * prior / all;
            density += weight;
            first += weight * after;
            second += weight * (prior * NOISE.powi(2) / all + after.powi(2));
        }
        if density < LEAST_DENSITY {
            *self = Self { refills: refills as f32, variance: NOISE.powi(2) as f32 };
            return LEAST_DENSITY;
        }
        let mean = first / density;
        self.refills = mean as f32;
        self.variance = (second / density - mean.powi(2)).max(0.0) as f32;
        density
    }
}

/// Densities below this are those of a pressure that has nothing to do with the last one.
const LEAST_DENSITY: f64 = 1e-12;

impl LeakTest {
    /// Writes the state; the time is written relative to `from`.
    pub(super) fn write<W: Write>(&self, from: Micros, writer: &mut W) -> Result<()> {
        encoding::write_time(self.at, from, writer)?;
        (self.sound, self.leaks, self.log_ratios).serialize(writer)
    }

    /// Reads the output of [`Self::write`].
    pub(super) fn read_again<R: Read>(from: Micros, reader: &mut R) -> Result<Self> {
        let at = encoding::read_time(from, reader)?;
        let (sound, leaks, log_ratios) = BorshDeserialize::deserialize_reader(reader)?;
        Ok(Self { at, sound, leaks, log_ratios })
    }
}
