//! A straight line through a series of any length, in bounded memory, with a realistic interval.
//!
//! Readings are averaged in at most [`BLOCKS`] blocks of equal counts. When they are full, neighbours are merged
//! and blocks become twice as long (batch means, as for the output of simulations). The line is fitted to the means
//! of the blocks. Neighbouring readings with correlated errors (a filter's estimates, a wandering sensor) fall into
//! one block, so the scatter of the blocks about the line shows the slope's true uncertainty, which the scatter of
//! the readings does not. The remaining correlation r of neighbouring blocks widens the variance by (1 + r) / (1 -
//! r).

use borsh::io::{Error, ErrorKind, Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Largest number of blocks.
pub const BLOCKS: usize = 16;
/// Upper limit of the estimated correlation of neighbouring blocks; few blocks cannot prove a larger one.
const CORRELATION_MAX: f64 = 0.8;

/// The blocks of a series: means over equal numbers of readings; the last block may be incomplete.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    x: [f32; BLOCKS],
    y: [f32; BLOCKS],
    blocks: u8,
    readings_in_last: u32,
    readings_per_block: u32,
    readings_per_block_max: u32,
}

/// Slope of a fitted line with its statistics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Change of y per unit of x.
    pub per_x: f64,
    /// Sum over readings of the squared distance from the mean of x: the slope's weight.
    pub weight: f64,
    /// Sum over blocks of readings times squared residual, widened for correlation. Divided by `freedom` and
    /// `weight` it is the slope's variance.
    pub squares: f64,
    /// Degrees of freedom of `squares`.
    pub freedom: f64,
}

/// A quantity with a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Interval {
    /// The estimated value.
    pub mean: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Trend {
    /// Empty series. At least the last `BLOCKS / 2 * readings_per_block_max` readings count.
    #[must_use]
    pub fn new(readings_per_block_max: u32) -> Self {
        Self {
            x: [0.0; BLOCKS],
            y: [0.0; BLOCKS],
            blocks: 0,
            readings_in_last: 0,
            readings_per_block: 1,
            readings_per_block_max: readings_per_block_max.max(1).next_power_of_two(),
        }
    }

    /// Adds one reading; x must not decrease.
    pub fn add(&mut self, x: f64, y: f64) {
        if self.blocks == 0 || self.readings_in_last >= self.readings_per_block {
            if usize::from(self.blocks) == BLOCKS {
                self.make_room();
            }
            let new = usize::from(self.blocks);
            (self.x[new], self.y[new]) = (0.0, 0.0);
            (self.blocks, self.readings_in_last) = (self.blocks + 1, 0);
        }
        self.readings_in_last += 1;
        let (last, share) = (usize::from(self.blocks) - 1, 1.0 / f64::from(self.readings_in_last));
        let nearer = |mean: f32, to: f64| (f64::from(mean) + (to - f64::from(mean)) * share) as f32;
        (self.x[last], self.y[last]) = (nearer(self.x[last], x), nearer(self.y[last], y));
    }

    /// Merges pairs of blocks, or drops the oldest block if blocks have their maximum length.
    fn make_room(&mut self) {
        if self.readings_per_block >= self.readings_per_block_max {
            self.x.copy_within(1.., 0);
            self.y.copy_within(1.., 0);
            self.blocks -= 1;
        } else {
            for one in [&mut self.x, &mut self.y] {
                for pair in 0..BLOCKS / 2 {
                    one[pair] = 0.5 * (one[2 * pair] + one[2 * pair + 1]);
                }
            }
            self.readings_per_block *= 2;
            self.blocks = (BLOCKS / 2) as u8;
        }
        self.readings_in_last = self.readings_per_block;
    }

    /// Number of readings in the blocks.
    #[must_use]
    pub fn readings(&self) -> u32 {
        let full = u32::from(self.blocks.saturating_sub(1));
        self.readings_per_block.saturating_mul(full).saturating_add(self.readings_in_last)
    }

    /// The blocks: number of readings, means of x and y.
    fn means(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let last = usize::from(self.blocks).saturating_sub(1);
        let readings = move |at| f64::from(if at == last { self.readings_in_last } else { self.readings_per_block });
        let blocks = self.x.iter().zip(&self.y).take(usize::from(self.blocks)).enumerate();
        blocks.map(move |(at, (x, y))| (readings(at), f64::from(*x), f64::from(*y)))
    }

    /// Slopes of the line before the last `blocks` blocks and through them, and the number of readings in these.
    #[must_use]
    pub fn split(&self, blocks: usize) -> (Option<Slope>, Option<Slope>, u32) {
        let before = usize::from(self.blocks).saturating_sub(blocks);
        let after = usize::from(self.blocks) - before;
        let readings = self.readings() - self.readings_per_block.saturating_mul(before as u32).min(self.readings());
        let first = Slope::through(|| self.means().take(before), before);
        (first, Slope::through(|| self.means().skip(before), after), readings)
    }

    /// Number of blocks.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.blocks.into()
    }

    /// Slope of the line; `None` with fewer than two blocks.
    #[must_use]
    pub fn slope(&self) -> Option<Slope> {
        Slope::through(|| self.means(), usize::from(self.blocks))
    }
}

/// Only the used blocks are written.
impl BorshSerialize for Trend {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        (self.blocks, self.readings_in_last, self.readings_per_block, self.readings_per_block_max).serialize(writer)?;
        let blocks = self.x.iter().zip(&self.y).take(usize::from(self.blocks));
        blocks.map(|(x, y)| (*x, *y)).try_for_each(|block| block.serialize(writer))
    }
}

impl BorshDeserialize for Trend {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let mut read = Self::new(1);
        (read.blocks, read.readings_in_last, read.readings_per_block, read.readings_per_block_max) =
            BorshDeserialize::deserialize_reader(reader)?;
        if usize::from(read.blocks) > BLOCKS {
            return Err(Error::new(ErrorKind::InvalidData, "a series has too many blocks"));
        }
        for at in 0..usize::from(read.blocks) {
            (read.x[at], read.y[at]) = BorshDeserialize::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}

/// Corrected correlation of neighbouring blocks, between 0 and [`CORRELATION_MAX`]: about a fitted line the raw
/// value is too low by (2 + 4 r) / n.
fn unbiased(correlation: f64, blocks: f64) -> f64 {
    let unbiased = if blocks > 6.0 { (blocks * correlation + 2.0) / (blocks - 4.0) } else { correlation };
    unbiased.clamp(0.0, CORRELATION_MAX)
}

impl Slope {
    /// Fits a line through `blocks` blocks, each given by its number of readings and the means of x and y.
    pub(super) fn through<B: Iterator<Item = (f64, f64, f64)>>(means: impl Fn() -> B, blocks: usize) -> Option<Self> {
        let sums = means().fold((0.0, 0.0, 0.0), |(n, x, y), one| (n + one.0, x + one.0 * one.1, y + one.0 * one.2));
        let (mean_x, mean_y) = (sums.1 / sums.0, sums.2 / sums.0);
        let at = || means().map(|(count, x, y)| (count, x - mean_x, y - mean_y));
        let (weight, product) =
            at().fold((0.0, 0.0), |(weight, product), (count, x, y)| (weight + count * x * x, product + count * x * y));
        if blocks < 2 || weight <= 0.0 {
            return None;
        }
        let per_x = product / weight;
        let (mut squares, mut neighbours, mut before) = (0.0, 0.0, 0.0);
        for (count, x, y) in at() {
            let residual = count.sqrt() * (y - per_x * x);
            squares += residual * residual;
            neighbours += before * residual;
            before = residual;
        }
        let blocks = blocks as f64;
        let correlation = if squares > 0.0 { unbiased(neighbours / squares, blocks) } else { 0.0 };
        let squares = squares * (1.0 + correlation) / (1.0 - correlation);
        Some(Self { per_x, weight, squares, freedom: blocks - 2.0 })
    }

    /// Slope with its 95 % interval; `None` without a degree of freedom.
    #[must_use]
    pub fn interval(&self) -> Option<Interval> {
        Interval::of(self.per_x, self.squares / self.freedom / self.weight, self.freedom)
    }
}

impl Interval {
    /// The 95 % interval of a mean whose variance was estimated with `freedom` degrees of freedom (Student's t).
    /// `None` with less than one.
    #[must_use]
    pub fn of(mean: f64, variance: f64, freedom: f64) -> Option<Self> {
        if freedom < 1.0 || !variance.is_finite() {
            return None;
        }
        let half = student_t975(freedom)? * variance.max(0.0).sqrt();
        Some(Self { mean, low: mean - half, high: mean + half })
    }
}

/// From this many degrees of freedom on the series expansion is accurate enough.
const MANY: f64 = 8.0;

/// The 97.5 % quantile of Student's t; it is evaluated every few pressure readings.
fn student_t975(freedom: f64) -> Option<f64> {
    if freedom < MANY {
        return Some(StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975));
    }
    // Cornish and Fisher's expansion in 1 / degrees of freedom (Abramowitz and Stegun 26.7.5) at the normal's 1.96.
    [1.589_0, 2.556_0, 2.822_5, 2.372_3, 1.959_963_985].into_iter().reduce(|sum, one| sum / freedom + one)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_the_quantile_is_that_of_the_library() {
        for k in 0..400 {
            let freedom = 1.0 + 0.25 * f64::from(k);
            let truth = StudentsT::new(0.0, 1.0, freedom).unwrap().inverse_cdf(0.975);
            let off = student_t975(freedom).unwrap() / truth - 1.0;
            assert!(off.abs() < 5e-5, "{freedom}: {off}");
        }
    }
}
