//! A straight line through a series of any length, in bounded memory, with an honest interval.
//!
//! Readings are averaged in at most [`BLOCKS`] blocks of equal counts; when they are full, neighbours are merged
//! and the blocks become twice as long (batch means, as for the output of simulations). The line goes through
//! the blocks' means. Neighbouring readings whose errors hang together (a filter's estimates, a sensor that
//! wanders) fall into one block, so that the scatter of the blocks about the line tells the slope's true
//! uncertainty, and the scatter of the readings does not come into it. What still hangs together from block to
//! block widens the interval by (1 + r) / (1 - r) of the variance, r being the correlation of neighbours.

use borsh::{BorshDeserialize, BorshSerialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The most blocks that are kept.
pub const BLOCKS: usize = 16;
/// A correlation of neighbouring blocks beyond this is not believed: too few blocks to tell.
const CORRELATION_MAX: f64 = 0.8;

/// The series' blocks.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Trend {
    blocks: Vec<Block>,
    readings_per_block: u32,
    readings_per_block_max: u32,
}

/// Sums over one block.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Block {
    readings: u32,
    x: f64,
    y: f64,
}

/// A fitted line's slope with what it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Change of y per unit of x.
    pub per_x: f64,
    /// Sum over readings of the squared distance from the mean of x: the slope's weight.
    pub weight: f64,
    /// Sum over blocks of readings times squared residual, widened for their correlation; over its degrees of
    /// freedom and the weight it is the slope's variance.
    pub squares: f64,
    /// Degrees of freedom of `squares`.
    pub freedom: f64,
}

/// A quantity with a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Interval {
    /// Estimate.
    pub mean: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl Trend {
    /// An empty series, of which at least the last `BLOCKS / 2 * readings_per_block_max` readings count.
    #[must_use]
    pub fn new(readings_per_block_max: u32) -> Self {
        Self {
            blocks: Vec::new(),
            readings_per_block: 1,
            readings_per_block_max: readings_per_block_max.max(1).next_power_of_two(),
        }
    }

    /// Takes one reading in; x must not fall.
    pub fn add(&mut self, x: f64, y: f64) {
        let full = self.blocks.last().is_none_or(|block| block.readings >= self.readings_per_block);
        if full && self.blocks.len() == BLOCKS {
            self.make_room();
        }
        if full {
            self.blocks.push(Block::default());
        }
        if let Some(block) = self.blocks.last_mut() {
            block.readings += 1;
            block.x += x;
            block.y += y;
        }
    }

    /// Longer blocks, or if they may not grow the oldest goes.
    fn make_room(&mut self) {
        if self.readings_per_block >= self.readings_per_block_max {
            self.blocks.remove(0);
            return;
        }
        self.readings_per_block *= 2;
        let merged = self.blocks.chunks(2).map(|pair| Block {
            readings: pair.iter().map(|block| block.readings).sum(),
            x: pair.iter().map(|block| block.x).sum(),
            y: pair.iter().map(|block| block.y).sum(),
        });
        self.blocks = merged.collect();
    }

    /// Readings that count.
    #[must_use]
    pub fn readings(&self) -> u32 {
        self.blocks.iter().map(|block| block.readings).sum()
    }

    /// The line's slope; none with fewer than two blocks.
    #[must_use]
    pub fn slope(&self) -> Option<Slope> {
        let readings = f64::from(self.readings());
        let mean_x = self.blocks.iter().map(|block| block.x).sum::<f64>() / readings;
        let mean_y = self.blocks.iter().map(|block| block.y).sum::<f64>() / readings;
        let at: Vec<(f64, f64, f64)> = self
            .blocks
            .iter()
            .map(|block| (f64::from(block.readings), block))
            .map(|(count, block)| (count, block.x / count - mean_x, block.y / count - mean_y))
            .collect();
        let weight: f64 = at.iter().map(|(count, x, _)| count * x * x).sum();
        if at.len() < 2 || weight <= 0.0 {
            return None;
        }
        let per_x = at.iter().map(|(count, x, y)| count * x * y).sum::<f64>() / weight;
        let residuals: Vec<f64> = at.iter().map(|(count, x, y)| count.sqrt() * (y - per_x * x)).collect();
        let squares: f64 = residuals.iter().map(|residual| residual * residual).sum();
        let neighbours: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let correlation = if squares > 0.0 { unbiased(neighbours / squares, at.len() as f64) } else { 0.0 };
        let squares = squares * (1.0 + correlation) / (1.0 - correlation);
        Some(Slope { per_x, weight, squares, freedom: at.len() as f64 - 2.0 })
    }
}

/// The correlation of neighbours among that many blocks, between 0 and [`CORRELATION_MAX`]: about a fitted line it comes
/// out too low by (2 + 4 r) / n.
fn unbiased(correlation: f64, blocks: f64) -> f64 {
    let unbiased = if blocks > 6.0 { (blocks * correlation + 2.0) / (blocks - 4.0) } else { correlation };
    unbiased.clamp(0.0, CORRELATION_MAX)
}

impl Slope {
    /// The slope with its 95 % interval; none without a degree of freedom.
    #[must_use]
    pub fn interval(&self) -> Option<Interval> {
        Interval::of(self.per_x, self.squares / self.freedom / self.weight, self.freedom)
    }
}

impl Interval {
    /// The 95 % interval of a mean whose variance was estimated with that many degrees of freedom (Student's t);
    /// none with less than one.
    #[must_use]
    pub fn of(mean: f64, variance: f64, freedom: f64) -> Option<Self> {
        if freedom < 1.0 || !variance.is_finite() {
            return None;
        }
        let half = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975) * variance.max(0.0).sqrt();
        Some(Self { mean, low: mean - half, high: mean + half })
    }
}
