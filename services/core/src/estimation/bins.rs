//! Responses averaged within contact-ratio bins.
//!
//! Single contacts are too noisy for Eq. 35: 4 % of noise on a difference of 17 %. Within a bin the mean of
//! `ln(measured sensitivity / model's)` is kept, each contact compared at its own contact ratio and pressure,
//! so that neither the slope within a bin nor a dithering regulator adds to the error.

use borsh::io::{Error, ErrorKind, Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::encoding;
use crate::mechanics::CONTACT_RATIOS;
use crate::units::ContactRatio;

/// Width of a bin in contact ratio; bins are centred on [`CONTACT_RATIOS`].
pub const WIDTH: f64 = 0.05;

/// The mean log deviation from the model in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    contacts: u32,
    weight: f32,
    mean: f32,
    mean_ratio: f64,
}

impl Bin {
    /// Contacts in the bin.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Mean of ln(measured / model's sensitivity), weighted by the contacts' stated noise.
    #[must_use]
    pub fn mean(&self) -> f64 {
        f64::from(self.mean)
    }

    /// Mean contact ratio of the contacts, weighted likewise: the outermost bins are half empty.
    #[must_use]
    pub fn mean_ratio(&self) -> f64 {
        self.mean_ratio
    }

    /// Variance of the mean deviation; infinite while empty.
    #[must_use]
    pub fn variance(&self) -> f64 {
        1.0 / f64::from(self.weight)
    }
}

/// A bin as it is kept.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Kept {
    /// Contacts, at most a million, and below them in [`RATIO_BITS`] where in the bin their mean contact ratio is: to
    /// 1.2e-5, where the means of two bins are 0.05 apart and a response hardly bends.
    contacts_and_ratio: u32,
    /// Sum of the inverse of the contacts' noise variances.
    weight: f32,
    mean: f32,
}

const RATIO_BITS: u32 = 12;
const RATIO_STEPS: u32 = 1 << RATIO_BITS;
const CONTACTS_MAX: u32 = u32::MAX >> RATIO_BITS;
/// Multiples of it, as parts of 2^32, are spread evenly: the golden ratio.
const GOLDEN: u32 = 0x9e37_79b9;

impl Kept {
    fn contacts(self) -> u32 {
        self.contacts_and_ratio >> RATIO_BITS
    }

    /// Mean contact ratio; `index` is that of the bin.
    fn mean_ratio(self, index: usize) -> f64 {
        let share = f64::from(self.contacts_and_ratio % RATIO_STEPS) / f64::from(RATIO_STEPS - 1);
        CONTACT_RATIOS[index] + (share - 0.5) * WIDTH
    }

    fn bin(self, index: usize) -> Bin {
        let Self { weight, mean, .. } = self;
        Bin { contacts: self.contacts(), weight, mean, mean_ratio: self.mean_ratio(index) }
    }

    fn add(&mut self, index: usize, ratio: f64, log_deviation: f64, weight: f64) {
        let sum = f64::from(self.weight) + weight;
        let nearer = |mean: f64, to: f64| mean + (to - mean) * (weight / sum);
        let share = (nearer(self.mean_ratio(index), ratio) - CONTACT_RATIOS[index]) / WIDTH + 0.5;
        let contacts = (self.contacts() + 1).min(CONTACTS_MAX);
        // Rounded up as often as its fraction says, or a mean over many would stand still where each moves it by little.
        let fraction = f64::from(contacts.wrapping_mul(GOLDEN)) / f64::from(u32::MAX);
        let steps = (share.clamp(0.0, 1.0) * f64::from(RATIO_STEPS - 1) + fraction) as u32;
        let steps = steps.min(RATIO_STEPS - 1);
        self.contacts_and_ratio = contacts << RATIO_BITS | steps;
        self.weight = sum as f32;
        self.mean = nearer(f64::from(self.mean), log_deviation) as f32;
    }
}

/// An empty one takes one byte.
impl BorshSerialize for Kept {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        encoding::write_u32(self.contacts_and_ratio, writer)?;
        if self.contacts() > 0 {
            (self.weight, self.mean).serialize(writer)?;
        }
        Ok(())
    }
}

impl BorshDeserialize for Kept {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let mut read = Self { contacts_and_ratio: encoding::read_u32(reader)?, ..Self::default() };
        if read.contacts() > 0 {
            (read.weight, read.mean) = BorshDeserialize::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}

/// Contacts that wait before they count: the last ones before a cut is noticed are of the cut whisker already.
///
/// They wait for further contacts and not for what these say: whoever dropped contacts because of what followed
/// would choose among them, and learn a biased response.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Waiting {
    contacts: [Waits; Waiting::CONTACTS],
    /// The next place, and how many are taken.
    at: u8,
    count: u8,
}

/// One contact that waits, with as many digits as an average of thousands can show.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Waits {
    /// The inverse of the noise variance, to 6 %: what a contact counts for needs no more. Octaves from
    /// [`LEAST_OCTAVE`] on, and eighths of them.
    weight: u8,
    /// In 4096ths, at most 8 to either side: 2.4e-4 where contacts scatter by 0.03.
    log_deviation: i16,
    /// Contact ratio in 255ths.
    ratio: u8,
}

const LOG_DEVIATION_STEPS: f64 = 4096.0;
/// Where the octave begins among the bits of a single, with its eighths.
const EIGHTHS_AT: u32 = 20;
/// The exponent of the least weight, 2^-8, in eighths.
const LEAST_OCTAVE: u32 = (127 - 8) << 3;

impl Waits {
    fn new(ratio: ContactRatio, log_deviation: f64, noise_variance: f64) -> Self {
        let eighths = ((1.0 / noise_variance) as f32).to_bits().saturating_add(1 << (EIGHTHS_AT - 1)) >> EIGHTHS_AT;
        Self {
            ratio: (ratio.a() * f64::from(u8::MAX)).round() as u8,
            weight: eighths.saturating_sub(LEAST_OCTAVE).min(u8::MAX.into()) as u8,
            log_deviation: (log_deviation * LOG_DEVIATION_STEPS).round() as i16,
        }
    }

    fn counts(self, bins: &mut ResponseBins) {
        let ratio = f64::from(self.ratio) / f64::from(u8::MAX);
        let log_deviation = f64::from(self.log_deviation) / LOG_DEVIATION_STEPS;
        let weight = f64::from(f32::from_bits((u32::from(self.weight) + LEAST_OCTAVE) << EIGHTHS_AT));
        if let Some(index) = ContactRatio::new(ratio).ok().and_then(ResponseBins::index) {
            bins.bins[index].add(index, ratio, log_deviation, weight);
        }
    }
}

impl Waiting {
    /// How many wait: trims of 2 mm and more are mostly noticed within so many.
    pub const CONTACTS: usize = 16;

    /// Takes one contact in, as [`ResponseBins::add`] does; the one that has waited longest goes to the bins.
    pub fn add(&mut self, bins: &mut ResponseBins, ratio: ContactRatio, log_deviation: f64, noise_variance: f64) {
        let place = &mut self.contacts[usize::from(self.at) % Self::CONTACTS];
        let longest = std::mem::replace(place, Waits::new(ratio, log_deviation, noise_variance));
        if usize::from(self.count) == Self::CONTACTS {
            longest.counts(bins);
        } else {
            self.count += 1;
        }
        self.at = (self.at + 1) % Self::CONTACTS as u8;
    }

    /// From the one that has waited longest on.
    fn in_order(&self) -> impl Iterator<Item = &Waits> {
        let first = usize::from(self.at) + Self::CONTACTS - usize::from(self.count);
        (first..first + usize::from(self.count)).map(|at| &self.contacts[at % Self::CONTACTS])
    }
}

impl BorshSerialize for Waiting {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        (self.at, self.count).serialize(writer)?;
        self.in_order().try_for_each(|one| one.serialize(writer))
    }
}

impl BorshDeserialize for Waiting {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (at, count) = <(u8, u8)>::deserialize_reader(reader)?;
        if usize::from(at) >= Self::CONTACTS || usize::from(count) > Self::CONTACTS {
            return Err(Error::new(ErrorKind::InvalidData, "too many contacts wait"));
        }
        let mut read = Self { at, count, ..Self::default() };
        let first = usize::from(at) + Self::CONTACTS - usize::from(count);
        for place in first..first + usize::from(count) {
            read.contacts[place % Self::CONTACTS] = Waits::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}

/// A response over the contact ratio, measured against one reference of the model.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct ResponseBins {
    bins: [Kept; CONTACT_RATIOS.len()],
}

impl ResponseBins {
    /// The bin that a contact ratio belongs to; none below 0.425.
    #[must_use]
    pub fn index(ratio: ContactRatio) -> Option<usize> {
        let steps = ((ratio.a() - CONTACT_RATIOS[0]) / WIDTH).round();
        (steps >= 0.0 && steps < CONTACT_RATIOS.len() as f64).then_some(steps as usize)
    }

    /// Takes one contact in: its log deviation from the model and that deviation's noise variance.
    pub fn add(&mut self, ratio: ContactRatio, log_deviation: f64, noise_variance: f64) {
        if let Some(index) = Self::index(ratio) {
            self.bins[index].add(index, ratio.a(), log_deviation, 1.0 / noise_variance);
        }
    }

    /// Every log deviation is another by this much: what was measured is brought to a new scale.
    pub fn shift(&mut self, log_shift: f64) {
        for bin in self.bins.iter_mut().filter(|bin| bin.contacts() > 0) {
            bin.mean = (f64::from(bin.mean) + log_shift) as f32;
        }
    }

    /// The bin around `CONTACT_RATIOS[index]`.
    #[must_use]
    pub fn bin(&self, index: usize) -> Bin {
        self.bins[index].bin(index)
    }

    /// The bin of a contact ratio, if it has at least `contacts`.
    #[must_use]
    pub fn measured(&self, ratio: ContactRatio, contacts: u32) -> Option<Bin> {
        Self::index(ratio).map(|index| self.bin(index)).filter(|bin| bin.contacts >= contacts)
    }

    /// The bins with contacts.
    pub fn felt(&self) -> impl Iterator<Item = Bin> + '_ {
        (0..self.bins.len()).map(|index| self.bin(index)).filter(|bin| bin.contacts > 0)
    }

    /// Contacts in all bins.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.bins.iter().map(|bin| bin.contacts()).fold(0, u32::saturating_add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_contacts_do_not_count_yet() {
        let (mut waiting, mut bins) = (Waiting::default(), ResponseBins::default());
        for k in 0..40 {
            waiting.add(&mut bins, ContactRatio::TIP, 0.125 * f64::from(k), 1.0);
        }
        assert_eq!(bins.contacts(), 24);
        assert_eq!(bins.bin(11).mean(), 0.125 * 11.5);
    }
}
