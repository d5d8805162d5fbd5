//! Pattern of a regulator while its chamber is sound: dither, hunting, ripple, overshoot. A leak is what this pattern does
//! not explain.
//!
//! Valves differ in more ways than a model can have, so each chamber is its own reference. In its first minutes the readings
//! are compared with the hypotheses of a leak, as later, and hardly anything is called. The gain of each hypothesis per
//! reading over a sound chamber is part of the pattern, and so are its largest excursions. In most chambers no hypothesis
//! gains: their pattern is plain, and takes no room. Where one gains, the same gain counts for nothing from then on, and a
//! leak must exceed the excursions.
//!
//! A chamber that leaks from the start must not pass for a pattern. A leak that is refilled falls slowly and rises at once;
//! dither, hunting and ripple do so as little as the reverse. So each rate of loss is compared with the same rate of gain,
//! which no chamber has. The sum over the readings decides while the pattern is learned. A leak whose refills are about as
//! fast as the statuses has no direction: from the start it passes for a dither.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::encoding;

/// Number of hypotheses of a leak: rates, and widths of bands.
pub(super) const LEAKS: usize = 8;
/// Number of rates at which air may also be gained.
pub(super) const GAINS: usize = 3;
/// Log likelihood ratio that calls a leak. The test is repeated all life long: sound chambers reached 12 in hours.
pub(super) const CALLED_AT: f32 = 14.0;
/// Kinds of other evidence: refills, leaps, a falling line.
pub(super) const OTHERS: usize = 3;
/// Times in which the noise is learned, then the mean gain, then the excursions, in seconds, and the readings that each needs.
const LEARNED_S: [f32; 3] = [100.0, 150.0, 250.0];
const LEARNED_READINGS: [f32; 3] = [20.0, 30.0, 50.0];
/// Log likelihood ratio of a loss against the same gain that calls a leak meanwhile: beyond the swing of a ripple.
const DIRECTED_AT: f32 = 50.0;
/// The same per reading: a dither that beats with the statuses has a direction, too.
const DIRECTED_MEAN: f32 = 0.28;
/// Bound of one reading's contribution to it.
const DIRECTED_MAX: f64 = 2.0;
/// Logarithm of a mean likelihood ratio above which it is a pattern's, per reading. In a chamber as the hypotheses assume it
/// is 0.
const GAIN_MIN: f32 = 0.05;
/// The more a pattern gains per reading, the higher is the log likelihood ratio that calls a leak: this per gain, up to the
/// second number. Minutes of learning must hold for the regulator's life.
const PATTERN_DOUBT: (f32, f32) = (50.0, 26.0);
/// A leak must exceed the excursions of the pattern by this factor, and other evidence by the second one.
const EXCURSIONS: f32 = 2.0;
const OTHER_EXCURSIONS: f32 = 5.0;
/// Other evidence below this share of its threshold is no pattern.
const OTHER_MIN: f32 = 0.4;

/// Pattern of one regulator.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) enum Habit {
    /// Nothing was read yet.
    #[default]
    Unknown,
    Learning(Box<Learning>),
    /// A sound chamber gains nothing.
    Plain,
    Pattern(Box<Pattern>),
}

/// Present part of the learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
enum Phase {
    #[default]
    Noise,
    Gains,
    Excursions,
}

/// Sums while a pattern is learned.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(super) struct Learning {
    seconds: f32,
    readings: f32,
    phase: Phase,
    /// Readings of all phases.
    all_readings: f32,
    /// Sums of the gains, later their allowance.
    pattern: Pattern,
    /// Log likelihood ratios of losses against gains of air.
    directed: [f32; GAINS],
}

/// Gains that count for nothing, and the largest excursions beyond them.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(super) struct Pattern {
    gains: [f32; LEAKS],
    excursions: [f32; LEAKS],
    /// Height of the present excursion. An excursion ends by itself if it is no leak.
    present: [f32; LEAKS],
    /// Of other evidence, relative to its threshold.
    others: [f32; OTHERS],
}

impl Pattern {
    fn is_plain(&self) -> bool {
        self.gains.iter().all(|&gain| gain == 0.0)
            && self.excursions.iter().all(|&one| EXCURSIONS * one <= CALLED_AT)
            && self.others.iter().all(|&one| OTHER_EXCURSIONS * one <= 1.0)
    }
}

impl Habit {
    /// Learns from a reading, after this gap: log likelihood ratios of each hypothesis against a sound chamber, and of each rate
    /// of loss against the same rate of gain.
    pub(super) fn learn(&mut self, gap_s: f64, gains: &[f32; LEAKS], directed: [f64; GAINS]) {
        if matches!(self, Self::Unknown) {
            *self = Self::Learning(Box::default());
        }
        let Self::Learning(learning) = self else { return };
        for (sum, more) in learning.directed.iter_mut().zip(directed) {
            *sum += more.clamp(-DIRECTED_MAX, DIRECTED_MAX) as f32;
        }
        learning.seconds += gap_s as f32;
        learning.readings += 1.0;
        learning.all_readings += 1.0;
        if learning.phase == Phase::Gains {
            learning.pattern.gains.iter_mut().zip(gains).for_each(|(sum, gain)| *sum += gain.exp());
        }
        let phase = learning.phase as usize;
        if learning.seconds < LEARNED_S[phase] || learning.readings < LEARNED_READINGS[phase] {
            return;
        }
        match learning.phase {
            Phase::Noise => learning.phase = Phase::Gains,
            Phase::Gains => {
                learning.phase = Phase::Excursions;
                for sum in &mut learning.pattern.gains {
                    let gain = (*sum / learning.readings).ln();
                    *sum = if gain > GAIN_MIN { gain } else { 0.0 };
                }
            }
            Phase::Excursions => {
                let pattern = std::mem::take(&mut learning.pattern);
                *self = if pattern.is_plain() { Self::Plain } else { Self::Pattern(Box::new(pattern)) };
                return;
            }
        }
        (learning.seconds, learning.readings) = (0.0, 0.0);
    }

    /// Whether the noise is known well enough for scatter to count.
    pub(super) fn knows_noise(&self) -> bool {
        match self {
            Self::Unknown => false,
            Self::Learning(learning) => learning.phase != Phase::Noise,
            Self::Plain | Self::Pattern(_) => true,
        }
    }

    /// Gain per reading that counts for nothing.
    pub(super) fn gains(&self) -> [f32; LEAKS] {
        match self {
            Self::Learning(learning) if learning.phase == Phase::Excursions => learning.pattern.gains,
            Self::Unknown | Self::Learning(_) | Self::Plain => [0.0; LEAKS],
            Self::Pattern(pattern) => pattern.gains,
        }
    }

    /// Whether log likelihood ratios show a leak that the pattern does not explain. While it is learned the ratios become
    /// part of it.
    pub(super) fn exceeded(&mut self, log_ratios: &[f32; LEAKS]) -> bool {
        if let Self::Learning(learning) = self {
            if learning.phase == Phase::Excursions {
                let excursions = learning.pattern.excursions.iter_mut().zip(log_ratios);
                excursions.for_each(|(most, &ratio)| *most = most.max(ratio));
            }
            return learning.is_directed() && log_ratios.iter().any(|&ratio| ratio >= CALLED_AT);
        }
        let Self::Pattern(pattern) = self else { return log_ratios.iter().any(|&ratio| ratio >= CALLED_AT) };
        let excursions = pattern.excursions.iter_mut().zip(&mut pattern.present).zip(log_ratios);
        excursions.zip(pattern.gains).fold(false, |is_exceeded, (((most, present), &ratio), gain)| {
            let doubt = (PATTERN_DOUBT.0 * gain).min(PATTERN_DOUBT.1);
            if ratio <= 0.0 {
                *most = most.max(std::mem::take(present));
            }
            *present = present.max(ratio);
            is_exceeded || ratio >= (CALLED_AT + doubt).max(EXCURSIONS * *most)
        })
    }

    /// The same for other evidence, relative to its thresholds. While the pattern is learned, refills
    /// count, which have a direction, and leaps between contacts (`quick`), which follow each other quickly.
    pub(super) fn is_exceeded_by(&self, others: [f64; OTHERS], quick: f64, part: f64) -> bool {
        if let Self::Learning(learning) = self {
            let [refilled, ..] = others;
            return refilled > 1.0 || quick > 1.0 || learning.is_directed() && others.iter().any(|&one| one > part);
        }
        let Self::Pattern(pattern) = self else { return others.iter().any(|&one| one > part) };
        let mut most = others.iter().zip(pattern.others);
        most.any(|(&one, most)| one > part * f64::from(OTHER_EXCURSIONS * most.max(1.0)))
    }

    /// Other evidence, relative to its thresholds, becomes part of the pattern while it is learned.
    pub(super) fn learn_others(&mut self, others: [f64; OTHERS]) {
        let Self::Learning(learning) = self else { return };
        for (most, one) in learning.pattern.others.iter_mut().zip(others) {
            if one as f32 > OTHER_MIN {
                *most = most.max(one as f32);
            }
        }
    }

    /// Writes the pattern, after its kind.
    pub(super) fn write<W: Write>(&self, writer: &mut W) -> Result<()> {
        match self {
            Self::Unknown => 0_u8.serialize(writer),
            Self::Learning(learning) => (1_u8, learning).serialize(writer),
            Self::Plain => 2_u8.serialize(writer),
            Self::Pattern(pattern) => (3_u8, pattern).serialize(writer),
        }
    }

    /// Reads what [`Self::write`] wrote.
    pub(super) fn read_again<R: Read>(reader: &mut R) -> Result<Self> {
        Ok(match u8::deserialize_reader(reader)? {
            0 => Self::Unknown,
            1 => Self::Learning(BorshDeserialize::deserialize_reader(reader)?),
            2 => Self::Plain,
            3 => Self::Pattern(BorshDeserialize::deserialize_reader(reader)?),
            _ => return Err(encoding::invalid("an unknown pattern of a regulator")),
        })
    }
}

impl Learning {
    /// Whether the readings fall slowly and rise at once, as no pattern does.
    fn is_directed(&self) -> bool {
        let least = DIRECTED_AT.max(DIRECTED_MEAN * self.all_readings);
        self.directed.iter().any(|&one| one >= least)
    }
}
