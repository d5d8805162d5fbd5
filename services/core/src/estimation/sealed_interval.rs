//! A span of time in which a chamber's valves are shut: averages of its pressure, in blocks.
//!
//! The blocks are those of [`super::trend`], in a quarter of the memory: a full block is rounded to 1/64 s and to
//! 1.2e-4 of the pressure, a third of a sensor's noise in an average over many readings. The block being filled is
//! not rounded, or small changes would be lost.

use std::num::NonZeroU16;

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::trend::{BLOCKS, Slope};
use crate::encoding;
use crate::units::Micros;

/// Resolution of a full block's time, in steps per second; its range is 1024 s.
const STEPS_A_SECOND: f64 = 64.0;
/// Resolution of ln(pressure / first pressure), in steps per unit; its range is -4 to 4.
const LOG_STEPS: f64 = 8192.0;
const TWO: NonZeroU16 = NonZeroU16::MIN.saturating_add(1);
/// Averages in a block at which the interval is full; that many do not occur within its longest permitted time.
const AVERAGES_MAX: u16 = 1 << 14;

/// The interval; each average covers a few readings.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SealedInterval {
    /// Time of the first reading, by the robot's clock.
    pub since: Micros,
    /// First average, MPa.
    pub mpa: f32,
    /// Newest average, in seconds since the start and MPa. It is used only once the next one shows that no valve
    /// opened.
    pub waiting: (f32, f32),
    /// The average before it, MPa; valid if there is a block.
    before_mpa: f32,
    full: [(u16, i16); BLOCKS - 1],
    /// Means of the last block: seconds, and ln(pressure / first pressure).
    last: (f32, f32),
    blocks: u8,
    in_last: u16,
    in_each: NonZeroU16,
}

impl SealedInterval {
    pub(super) fn new(since: Micros, seconds: f64, mpa: f64) -> Self {
        Self {
            since,
            mpa: mpa as f32,
            waiting: (seconds as f32, mpa as f32),
            before_mpa: 0.0,
            full: [(0, 0); BLOCKS - 1],
            last: (0.0, 0.0),
            blocks: 0,
            in_last: 0,
            in_each: NonZeroU16::MIN,
        }
    }

    /// Adds the next average.
    pub(super) fn follow(&mut self, seconds: f64, mpa: f64) {
        let (waited_s, waited_mpa) = std::mem::replace(&mut self.waiting, (seconds as f32, mpa as f32));
        self.before_mpa = waited_mpa;
        if self.blocks == 0 || self.in_last >= self.in_each.get() {
            self.begin();
        }
        self.in_last += 1;
        let share = 1.0 / f64::from(self.in_last);
        let nearer = |mean: f32, to: f64| (f64::from(mean) + (to - f64::from(mean)) * share) as f32;
        let log = (f64::from(waited_mpa) / f64::from(self.mpa)).ln();
        self.last = (nearer(self.last.0, waited_s.into()), nearer(self.last.1, log));
    }

    /// Begins a new block.
    fn begin(&mut self) {
        if usize::from(self.blocks) == BLOCKS {
            self.merge();
        } else if let Some(filled) = self.blocks.checked_sub(1) {
            self.full[usize::from(filled)] = rounded(self.last.0.into(), self.last.1.into());
        }
        (self.last, self.in_last, self.blocks) = ((0.0, 0.0), 0, self.blocks + 1);
    }

    /// Merges pairs of blocks.
    fn merge(&mut self) {
        let mut means = [(0.0, 0.0); BLOCKS];
        for (kept, (_, x, y)) in means.iter_mut().zip(self.means()) {
            *kept = (x, y);
        }
        self.full = [(0, 0); BLOCKS - 1];
        for (full, pair) in self.full.iter_mut().zip(means.chunks_exact(2)) {
            *full = rounded(0.5 * (pair[0].0 + pair[1].0), 0.5 * (pair[0].1 + pair[1].1));
        }
        (self.blocks, self.in_each) = ((BLOCKS / 2) as u8, self.in_each.saturating_mul(TWO));
    }

    /// The blocks: number of averages, time in seconds, ln(pressure / first pressure).
    fn means(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let count = f64::from(self.in_each.get());
        let full = self.full.iter().take(usize::from(self.blocks).saturating_sub(1));
        let full = full.map(move |&(x, y)| (count, f64::from(x) / STEPS_A_SECOND, f64::from(y) / LOG_STEPS));
        let last = (f64::from(self.in_last), f64::from(self.last.0), f64::from(self.last.1));
        full.chain((self.blocks > 0).then_some(last))
    }

    /// Slope of the logarithm of the pressure, per second.
    pub(super) fn slope(&self) -> Option<Slope> {
        Slope::through(|| self.means(), self.blocks.into())
    }

    /// Last average but one, MPa.
    pub(super) fn before_mpa(&self) -> Option<f32> {
        (self.blocks > 0).then_some(self.before_mpa)
    }

    /// Whether no further average fits.
    pub(super) fn is_full(&self) -> bool {
        self.in_each.get() >= AVERAGES_MAX
    }

    /// Length of the interval, in seconds.
    pub(super) fn span_s(&self) -> f64 {
        f64::from(self.waiting.0)
    }

    /// Writes the interval with its used blocks; the time is written relative to `from`.
    pub(super) fn write<W: Write>(&self, from: Micros, writer: &mut W) -> Result<()> {
        encoding::write_time(self.since, from, writer)?;
        (self.mpa, self.waiting, self.blocks).serialize(writer)?;
        if self.blocks > 0 {
            encoding::write_u32(self.in_last.into(), writer)?;
            encoding::write_u32(self.in_each.get().into(), writer)?;
            (self.before_mpa, self.last).serialize(writer)?;
        }
        self.full.iter().take(usize::from(self.blocks).saturating_sub(1)).try_for_each(|block| block.serialize(writer))
    }

    /// Reads the output of [`Self::write`].
    pub(super) fn read<R: Read>(from: Micros, reader: &mut R) -> Result<Self> {
        let mut read = Self::new(encoding::read_time(from, reader)?, 0.0, 0.0);
        (read.mpa, read.waiting, read.blocks) = BorshDeserialize::deserialize_reader(reader)?;
        if usize::from(read.blocks) > BLOCKS {
            return Err(encoding::invalid("an interval has too many blocks"));
        }
        if read.blocks > 0 {
            let [in_last, in_each] = [encoding::read_u32(reader)?, encoding::read_u32(reader)?];
            let is_possible = in_each <= AVERAGES_MAX.into() && (1..=in_each).contains(&in_last);
            let in_each = NonZeroU16::new(in_each as u16).filter(|_| is_possible);
            read.in_each =
                in_each.ok_or_else(|| encoding::invalid("an interval has an impossible number of readings"))?;
            read.in_last = in_last as u16;
            (read.before_mpa, read.last) = BorshDeserialize::deserialize_reader(reader)?;
        }
        for block in &mut read.full[..usize::from(read.blocks).saturating_sub(1)] {
            *block = BorshDeserialize::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}

/// Stored form of a full block.
fn rounded(seconds: f64, log: f64) -> (u16, i16) {
    ((seconds * STEPS_A_SECOND).round() as u16, (log * LOG_STEPS).round() as i16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::Trend;

    #[test]
    fn property_its_line_is_that_of_blocks_in_full() {
        let mut sealed = SealedInterval::new(Micros(7), 0.0, 0.1);
        let mut trend = Trend::new(u32::MAX / 2);
        let mpa = |k: u32| 0.1 * (-3e-4 * f64::from(k)).exp() + 4e-4 * (f64::from(k * 37 % 23) / 11.0 - 1.0);
        for k in 1..400 {
            sealed.follow(0.5 * f64::from(k), mpa(k));
            let before = if k == 1 { 0.1 } else { mpa(k - 1) };
            trend.add(0.5 * f64::from(k - 1), before.ln());
            let (Some(one), Some(other)) = (sealed.slope(), trend.slope()) else { continue };
            let sd = (other.squares / other.freedom.max(1.0) / other.weight).sqrt();
            // A hundredth of the leak threshold.
            assert!((one.per_x - other.per_x).abs() <= 0.2 * sd + 5e-6, "{k}: {one:?} {other:?}");
            assert!((one.weight / other.weight - 1.0).abs() < 1e-2, "{k}: {one:?} {other:?}");
            assert_eq!(one.freedom, other.freedom);
        }
        let mut bytes = Vec::new();
        sealed.write(Micros(3), &mut bytes).unwrap();
        assert!(bytes.len() <= 90, "{}", bytes.len());
        assert_eq!(SealedInterval::read(Micros(3), &mut bytes.as_slice()).unwrap(), sealed);
    }
}
