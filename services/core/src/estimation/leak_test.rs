//! Does a chamber behind on/off valves leak? A sequential test, while a regulator refills it within a dead band.
//!
//! Each hypothesis predicts the next reading from the last ones ([`super::pressure_track`]).
//! - A rate of loss predicts a fall at that rate, or one of the rare jumps of valves, up by a refill or down by venting.
//!   A faster leak makes more refills, as many as replace the loss. So falling lines and refills are judged together: a
//!   line that falls without refills, a step down without a line, or refills without falls suit no leak.
//! - A leak that is refilled every few readings or faster shows no line. Its readings scatter over the dead band, so the
//!   hypothesis is the width of that band.
//!
//! The likelihood ratios of the hypotheses against a sound chamber add up over the readings. A leak is called at
//! [`super::air_habit::CALLED_AT`], and is over at [`ENDED_AT`] in favour of a sound chamber against each hypothesis. The sensor's noise is
//! learned while the chamber is sound: a noisy sensor scatters, too. So is its step: a finer sensor shows a leak sooner.
//!
//! Dither, hunting and ripple resemble leaks. So a rate of loss must also be likelier than the same rate of gain, which no
//! chamber has, and each hypothesis counts beyond the regulator's own pattern ([`super::air_habit`]).
//!
//! Only statuses are evaluated: they come at a steady pace, also when the whisker is not touched.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::air_habit::{GAINS, Habit, LEAKS, OTHERS};
use super::pressure_track::{Loss, Reading, Track, rounding};
use super::trend::Interval;
use crate::encoding;
use crate::units::Micros;

/// Loss of a sound chamber: the highest that is sound, so that the ratio changes its sign at half of the least leak.
/// Most sound chambers lose less.
const SOUND: Loss = Loss { per_s: 1e-4, sd: 0.7 };
/// Rates of leaks, per second, and their relative error: rates between the hypotheses.
pub(super) const RATES: usize = 5;
const RATES_PER_S: [f64; RATES] = [1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2];
const RATE_SD: f64 = 0.35;
/// Places of the rates at which air may also be gained, for comparison; each rate is compared with one of them.
const GAINS_AT: [usize; GAINS] = [0, 2, 4];
const COMPARED_WITH: [usize; RATES] = [0, 1, 1, 2, 2];
/// Log likelihood ratio for a gain of air that is usual in a sound chamber. Beyond it the difference from a loss has a standard
/// deviation of this times the root of the excess.
const GAIN_SOUND: f32 = 8.0;
const GAIN_SD: f32 = 3.0;
/// Widths of bands, in smallest refills.
const WIDTHS: usize = LEAKS - RATES;
const WIDTHS_REFILLS: [f64; WIDTHS] = [1.7, 3.0, 6.0];
/// Longest gap between two readings whose scatter counts, in seconds. Over longer gaps a sound chamber's own loss and
/// refills scatter the readings.
const SCATTER_GAP_S: f64 = 5.0;
/// Longest time from refill to refill of a leak whose readings scatter, in seconds.
const SCATTER_CYCLE_S: f64 = 10.0;
/// Largest and least step of a sensor, in smallest refills.
const STEP_MAX: f32 = 1.0;
const STEP_MIN: f32 = 0.02;
/// Factors on the step after a change that is smaller, and after one that is not: a single odd reading shows no finer sensor.
const STEP_SHRINKS: f32 = 0.9;
const STEP_GROWS: f32 = 1.005;
/// Noise that a sensor has until it is known, and least noise, in smallest refills.
const NOISE: f64 = 0.36;
const NOISE_MIN: f64 = 0.25;
/// Number of readings that the noise in advance is worth, and number of readings that the learned noise remembers.
const NOISE_READINGS: f64 = 50.0;
const NOISE_READINGS_MAX: f64 = 2000.0;
/// Distances from the prediction count up to this in the noise, in refills: refills are no noise.
const NOISE_OFF_MAX: f64 = 1.2;
/// Log likelihood ratio from which on no noise is learned: a leak that is slow to show would become noise.
const SUSPECTED_AT: f32 = 5.0;
/// The same in favour of a sound chamber that ends a leak. Leaks with bands of a sensor's step look sound for some time.
const ENDED_AT: f32 = 60.0;
/// Bound of the ratios while a leak is called, so that another hypothesis can become the likeliest.
const RATIO_MAX: f32 = 2.0 * ENDED_AT;
/// Bounds of one reading's contribution.
const CONTRIBUTION_MAX: f64 = 4.0;
/// Least and largest gap between two readings, in seconds; after a longer one the predictions begin anew.
const GAP_S: (f64, f64) = (0.5, 20.0);

/// The test's state for one chamber.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct LeakTest {
    /// Last reading, in smallest refills.
    last: f32,
    /// Time of the last reading; 0 before the first, and after a valve was moved on purpose.
    at: Micros,
    sound: Track,
    rates: [Track; RATES],
    widths: [Track; WIDTHS],
    /// Of chambers that gain air at some of the rates.
    rises: [Track; GAINS],
    /// Log likelihood ratios of these, at least 0.
    rise_ratios: [f32; GAINS],
    /// Of each hypothesis against a sound chamber, rates first: at least 0 while no leak is called, at most 0 while one is.
    log_ratios: [f32; LEAKS],
    noise: Noise,
    step: Step,
    /// Pattern of the regulator while the chamber is sound.
    habit: Habit,
}

/// Step of the sensor, in smallest refills: about the smallest usual change between two readings.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct Step(f32);

impl Default for Step {
    fn default() -> Self {
        Self(STEP_MAX)
    }
}

/// Noise of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Noise {
    readings: f32,
    /// Mean square, in smallest refills squared, apart from rounding.
    square: f32,
}

/// Rate by the likeliest hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Likeliest {
    /// Least rate, per second.
    pub least_per_s: f64,
    /// Bounds of the rate: a factor of two in either direction. None if refills are faster than readings.
    pub rate: Option<Interval>,
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
            (self.at, self.last) = (at, refills as f32);
            let error = self.noise.variance() + rounding(self.step.half());
            self.sound = Track::new(refills, error);
            self.rates = [self.sound; RATES];
            self.widths = WIDTHS_REFILLS.map(|width| Track::new(refills, width.powi(2) / 12.0 + error));
            self.rises = [self.sound; GAINS];
            return None;
        }
        if gap_s < GAP_S.0 {
            return None;
        }
        self.at = at;
        // A test that was stored without it has no last reading.
        if self.last != 0.0 {
            self.step.see(refills - f64::from(self.last));
        }
        self.last = refills as f32;
        let reading = Reading { refills, gap_s, noise: self.noise.variance(), half_step: self.step.half() };
        if !is_leaking && self.log_ratios.iter().all(|&ratio| ratio < SUSPECTED_AT) {
            self.noise.learn(self.sound.off(refills), rounding(reading.half_step));
        }
        let is_new = !is_leaking && !self.habit.knows_noise();
        let sound = self.sound.fall(SOUND, &reading);
        let loss = |index: usize| Loss { per_s: RATES_PER_S[index], sd: RATE_SD };
        let falls: [f64; RATES] = std::array::from_fn(|index| self.rates[index].fall(loss(index), &reading));
        let rises: [f64; GAINS] = std::array::from_fn(|at| self.rises[at].rise(loss(GAINS_AT[at]), &reading));
        let likeliest = falls.iter().copied().fold(0.0, f64::max);
        let mut densities = [sound; LEAKS];
        densities[..RATES].copy_from_slice(&falls);
        for ((density, track), width) in densities[RATES..].iter_mut().zip(&mut self.widths).zip(WIDTHS_REFILLS) {
            let scattered = track.scatter(width, &reading);
            if gap_s > SCATTER_GAP_S && is_leaking {
                // Refills as fast as the statuses are not seen over longer gaps: a leak that shows no rate either may end.
                *density = likeliest.min(sound);
            } else if gap_s <= SCATTER_GAP_S && !is_new {
                *density = scattered;
            }
        }
        let against_sound = |one: f64| (one / sound).ln().clamp(-CONTRIBUTION_MAX, CONTRIBUTION_MAX) as f32;
        let more = densities.map(against_sound);
        if !is_leaking {
            self.habit.learn(gap_s, &more, std::array::from_fn(|at| (falls[GAINS_AT[at]] / rises[at]).ln()));
        }
        let usual = self.habit.gains();
        let least = if is_leaking { -RATIO_MAX } else { 0.0 };
        for ((log_ratio, more), usual) in self.log_ratios.iter_mut().zip(more).zip(usual) {
            *log_ratio = (*log_ratio + more - usual).max(least);
        }
        for ((log_ratio, rise), at) in self.rise_ratios.iter_mut().zip(rises).zip(GAINS_AT) {
            *log_ratio = (*log_ratio + against_sound(rise) - usual[at]).clamp(0.0, RATIO_MAX);
        }
        if is_leaking {
            self.bound();
        }
        let turns = if is_leaking {
            self.log_ratios.iter().all(|&ratio| ratio <= -ENDED_AT)
        } else {
            self.habit.exceeded(&self.against_rises())
        };
        turns.then(|| {
            self.begin(!is_leaking);
            !is_leaking
        })
    }

    /// Rate by the likeliest hypothesis.
    pub(super) fn likeliest(&self) -> Likeliest {
        let (rates, widths) = self.log_ratios.split_at(RATES);
        let best = |of: &[f32]| (0..of.len()).max_by(|&one, &other| of[one].total_cmp(&of[other])).unwrap_or_default();
        let (rate, width) = (best(rates), best(widths));
        if rates[rate] >= widths[width] {
            let mean = RATES_PER_S[rate];
            let bounds = Interval { mean, low: 0.5 * mean, high: 2.0 * mean };
            return Likeliest { least_per_s: bounds.low, rate: Some(bounds) };
        }
        Likeliest { least_per_s: WIDTHS_REFILLS[width] / SCATTER_CYCLE_S / self.sound.refills().max(1.0), rate: None }
    }

    /// Log likelihood ratios, those of rates against gains of air. The more speaks for a gain, the more chance has part in the
    /// difference.
    fn against_rises(&self) -> [f32; LEAKS] {
        let mut ratios = self.log_ratios;
        for (loss, compared) in ratios.iter_mut().zip(COMPARED_WITH) {
            let gain = self.rise_ratios[compared];
            *loss -= gain + GAIN_SD * (gain - GAIN_SOUND).max(0.0).sqrt();
        }
        ratios
    }

    /// Whether other evidence, relative to its thresholds, shows a leak that the regulator's pattern does not explain.
    /// `quick` are the leaps between contacts, and `part` of each threshold counts.
    pub(super) fn is_exceeded_by(&self, others: [f64; OTHERS], quick: f64, part: f64) -> bool {
        self.habit.is_exceeded_by(others, quick, part)
    }

    /// Takes other evidence from a chamber that is not called leaking, relative to its thresholds.
    pub(super) fn learn_others(&mut self, others: [f64; OTHERS]) {
        self.habit.learn_others(others);
    }

    /// The readings say nothing of the same chamber any more, but its regulator is the same.
    pub(super) fn begun_anew(self) -> Self {
        Self { noise: self.noise, step: self.step, habit: self.habit, ..Self::default() }
    }

    /// The verdict has changed.
    pub(super) fn begin(&mut self, is_leaking: bool) {
        if is_leaking {
            self.bound();
        } else {
            self.rise_ratios = [0.0; GAINS];
            self.log_ratios = [0.0; LEAKS];
        }
    }

    /// While a leak is called, the ratio of its likeliest hypothesis is at most 0.
    fn bound(&mut self) {
        let most = self.log_ratios.iter().fold(0.0_f32, |most, &one| most.max(one));
        self.log_ratios.iter_mut().for_each(|one| *one -= most);
    }
}

impl Step {
    fn half(self) -> f64 {
        0.5 * f64::from(self.0)
    }

    /// Readings differ by this many refills.
    fn see(&mut self, by: f64) {
        let by = by.abs() as f32;
        if by >= self.0 {
            self.0 = (self.0 * STEP_GROWS).min(STEP_MAX);
        } else if by >= STEP_MIN {
            self.0 = by.max(self.0 * STEP_SHRINKS);
        }
    }
}

impl Noise {
    fn variance(&self) -> f64 {
        let [readings, square] = [self.readings, self.square].map(f64::from);
        let blended = (NOISE_READINGS * NOISE.powi(2) + readings * square) / (NOISE_READINGS + readings);
        blended.max(NOISE_MIN.powi(2))
    }

    fn learn(&mut self, off: f64, rounding: f64) {
        self.readings = (f64::from(self.readings) + 1.0).min(NOISE_READINGS_MAX) as f32;
        let square = off.abs().min(NOISE_OFF_MAX).powi(2) - rounding;
        self.square += (square as f32 - self.square) / self.readings;
    }
}

impl LeakTest {
    /// Writes the state; the time is written relative to `from`. A negative number of readings tells that the reference
    /// follows, which tests did not have before.
    pub(super) fn write<W: Write>(&self, from: Micros, writer: &mut W) -> Result<()> {
        encoding::write_time(self.at, from, writer)?;
        let Self { sound, rates, widths, log_ratios, noise, .. } = self;
        let has_reference = !self.is_without_reference();
        let readings = if has_reference { -noise.readings } else { noise.readings };
        (sound, rates, widths, log_ratios, Noise { readings, ..*noise }).serialize(writer)?;
        if has_reference {
            (self.last, self.rises, self.rise_ratios, self.step).serialize(writer)?;
            self.habit.write(writer)?;
        }
        Ok(())
    }

    /// Whether it has nothing that tests did not have before.
    fn is_without_reference(&self) -> bool {
        let Self { last, rises, rise_ratios, step, habit, .. } = self;
        *last == 0.0
            && *rises == [self.sound; GAINS]
            && *rise_ratios == [0.0; GAINS]
            && *step == Step::default()
            && *habit == Habit::Unknown
    }

    /// Reads a test as it was stored before version 8 of the whisker. It had a sixth rate, which counts for the fifth
    /// now, and neither widths nor a learned noise. Predictions begin anew.
    pub(super) fn read_before_8<R: Read>(from: Micros, reader: &mut R) -> Result<Self> {
        let _at = encoding::read_time(from, reader)?;
        let _tracks: [Track; 1 + RATES + 1] = BorshDeserialize::deserialize_reader(reader)?;
        let [rates @ .., sixth]: [f32; RATES + 1] = BorshDeserialize::deserialize_reader(reader)?;
        // A width must not be likelier than the rates of a leak that was called.
        let least = rates.into_iter().fold(0.0, f32::min);
        let mut read = Self { log_ratios: [least; LEAKS], ..Self::default() };
        read.log_ratios[..RATES].copy_from_slice(&rates);
        read.log_ratios[RATES - 1] = rates[RATES - 1].max(sixth);
        Ok(read)
    }

    /// Reads the output of [`Self::write`].
    pub(super) fn read_again<R: Read>(from: Micros, reader: &mut R) -> Result<Self> {
        let at = encoding::read_time(from, reader)?;
        let (sound, rates, widths, log_ratios) = BorshDeserialize::deserialize_reader(reader)?;
        let noise = Noise::deserialize_reader(reader)?;
        let mut read = Self { at, sound, rates, widths, log_ratios, noise, rises: [sound; GAINS], ..Self::default() };
        if noise.readings.is_sign_negative() {
            read.noise.readings = noise.readings.abs();
            (read.last, read.rises, read.rise_ratios, read.step) = BorshDeserialize::deserialize_reader(reader)?;
            read.habit = Habit::read_again(reader)?;
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_a_stored_test_goes_on_as_before_while_the_pattern_is_learned_and_later() {
        let from = Micros(1_000_000);
        let mut test = LeakTest::default();
        for reading in 1..900_u32 {
            let at = Micros(from.0 + 1_000_000 * u64::from(reading));
            // Slow hunting by three refills: a pattern.
            let refills = 80.0 + if reading / 7 % 2 == 0 { 1.5 } else { -1.5 } + 0.02 * f64::from(reading % 5);
            let mut bytes = Vec::new();
            test.write(from, &mut bytes).unwrap();
            let mut rest = bytes.as_slice();
            let mut restored = LeakTest::read_again(from, &mut rest).unwrap();
            assert!(rest.is_empty() && restored == test, "{reading}");
            assert_eq!(restored.read(false, at, refills), test.read(false, at, refills), "{reading}");
        }
        assert!(matches!(test.habit, Habit::Pattern(_)), "{:?}", test.habit);
    }

    #[test]
    fn regress_a_test_without_a_reference_is_written_as_it_was() {
        let from = Micros(1_000_000);
        let sound = Track::new(80.0, 0.2);
        let noise = Noise { readings: 300.0, square: 0.1 };
        let mut bytes = Vec::new();
        encoding::write_time(Micros(3_000_000), from, &mut bytes).unwrap();
        ([sound; 1 + RATES + WIDTHS], [0.5_f32; LEAKS], noise).serialize(&mut bytes).unwrap();
        let test = LeakTest::read_again(from, &mut bytes.as_slice()).unwrap();
        let mut again = Vec::new();
        test.write(from, &mut again).unwrap();
        assert_eq!((again, test.habit), (bytes, Habit::Unknown));
    }

    #[test]
    fn regress_a_test_before_version_8_is_read_with_its_likeliest_rate() {
        let from = Micros(1_000_000);
        for (log_ratios, per_s) in
            [([-9.0, -3.0, 0.0, -2.0, -5.0, -7.0_f32], 4e-3), ([-9.0, -9.0, -9.0, -9.0, -5.0, 0.0], 1.6e-2)]
        {
            let mut bytes = Vec::new();
            encoding::write_time(Micros(3_000_000), from, &mut bytes).unwrap();
            ([Track::default(); 7], log_ratios).serialize(&mut bytes).unwrap();
            let mut rest = bytes.as_slice();
            let test = LeakTest::read_before_8(from, &mut rest).unwrap();
            assert!(rest.is_empty());
            assert_eq!(test.likeliest().rate.map(|rate| rate.mean), Some(per_s));
        }
    }
}
