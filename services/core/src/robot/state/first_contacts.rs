//! The first contacts of a whisker, as they were felt while it was learned.
//!
//! The filter that learns the offset takes a step among them for the offset, or for noise that lasts from contact to
//! contact, and then follows it for hundreds of contacts. So they are kept apart from it, in blocks of a few contacts, and
//! the step is fitted to the blocks.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use smallvec::SmallVec;

use crate::encoding;
use crate::mechanics::Offset;

/// Contacts of a block.
pub(in crate::robot) const BLOCK: usize = 5;
/// Number of blocks: those of the cold start.
const BLOCKS: usize = 30;
/// Least number of blocks after a step.
const AFTER_MIN: usize = 2;
/// Largest correlation between neighbouring blocks that counts.
const CORRELATION_MAX: f64 = 0.8;
/// A fitted line leaves a correlation that is too small by about so many over the number of blocks.
const CORRELATION_BIAS: f64 = 2.0;

/// Sums of contact ratios and of deviations from the model at whole length, log sensitivity.
type Sums = [f32; 2];

/// Response of a whisker's first contacts.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::robot) struct FirstContacts {
    contacts: u8,
    blocks: [Sums; BLOCKS],
}

/// A rise of log sensitivity among the first contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::robot) struct Step {
    /// Kept contacts before it.
    pub contacts_before: usize,
    pub rise: f64,
    /// Standard deviation of the rise, from the scatter of the blocks.
    pub rise_sd: f64,
    /// Level after it, with its standard deviation.
    pub level: f64,
    pub level_sd: f64,
}

impl Default for FirstContacts {
    fn default() -> Self {
        Self { contacts: 0, blocks: [[0.0; 2]; BLOCKS] }
    }
}

impl FirstContacts {
    /// Whether its numbers are finite.
    pub(in crate::robot) fn is_sound(&self) -> bool {
        self.blocks.iter().flatten().all(|one| one.is_finite())
    }

    /// Takes in a contact with its deviation from the model, log sensitivity. Those after the last block do not count.
    pub(in crate::robot) fn add(&mut self, ratio: f64, deviation: f64) {
        let Some(block) = self.blocks.get_mut(usize::from(self.contacts) / BLOCK) else { return };
        self.contacts += 1;
        block[0] += ratio as f32;
        block[1] += deviation as f32;
    }

    /// The most likely rise, with its uncertainty. `slope` is that of the learned offset.
    pub(in crate::robot) fn step(&self, slope: f64) -> Option<Step> {
        let filled = usize::from(self.contacts) / BLOCK;
        let level = |[ratio, deviation]: &Sums| {
            let count = BLOCK as f64;
            f64::from(*deviation) / count - slope * (f64::from(*ratio) / count - Offset::CENTRE)
        };
        let levels: SmallVec<[f64; BLOCKS]> = self.blocks[..filled].iter().map(level).collect();
        let mean = |levels: &[f64]| levels.iter().sum::<f64>() / levels.len() as f64;
        let rise_at = |at: usize| mean(&levels[at..]) - mean(&levels[..at]);
        let explained = |at: usize| (at * (filled - at)) as f64 * rise_at(at) * rise_at(at).abs();
        let places = 1..(filled + 1).saturating_sub(AFTER_MIN);
        let at = places.max_by(|&one, &other| explained(one).total_cmp(&explained(other)))?;
        let (before, after) = levels.split_at(at);
        let off: SmallVec<[f64; BLOCKS]> =
            [before, after].iter().flat_map(|part| part.iter().map(|level| level - mean(part))).collect();
        let square = off.iter().map(|off| off * off).sum::<f64>();
        let together: f64 = off.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let correlation = (together / square + CORRELATION_BIAS / filled as f64).clamp(0.0, CORRELATION_MAX);
        let variance = square / filled.checked_sub(3)? as f64 * (1.0 + correlation) / (1.0 - correlation);
        let sd_of = |blocks: usize| (variance / blocks as f64).sqrt();
        Some(Step {
            contacts_before: at * BLOCK,
            rise: rise_at(at),
            rise_sd: sd_of(before.len()).hypot(sd_of(after.len())),
            level: mean(after),
            level_sd: sd_of(after.len()),
        })
    }

    /// Reads what a whisker before version 19 had of its first contacts: sums of too few to tell a step. They do not count.
    ///
    /// # Errors
    /// The bytes end.
    pub(in crate::robot) fn read_before_19<R: Read>(reader: &mut R) -> Result<Self> {
        let _: (u8, [f32; 3]) = BorshDeserialize::deserialize_reader(reader)?;
        Ok(Self::default())
    }

    fn used(contacts: u8) -> usize {
        usize::from(contacts).div_ceil(BLOCK).min(BLOCKS)
    }
}

/// Blocks that are empty take no bytes.
impl BorshSerialize for FirstContacts {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        self.contacts.serialize(writer)?;
        self.blocks[..Self::used(self.contacts)].iter().try_for_each(|block| block.serialize(writer))
    }
}

impl BorshDeserialize for FirstContacts {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let contacts = u8::deserialize_reader(reader)?;
        if usize::from(contacts) > BLOCK * BLOCKS {
            return Err(encoding::invalid("too many first contacts"));
        }
        let mut read = Self { contacts, ..Self::default() };
        for block in &mut read.blocks[..Self::used(contacts)] {
            *block = Sums::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}
