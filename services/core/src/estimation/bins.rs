//! Responses averaged within contact-ratio bins.
//!
//! Single contacts are too noisy for Eq. 35: 4 % noise on a difference of 17 %. Each bin holds the mean of
//! `ln(measured sensitivity / model's sensitivity)`. Each contact is compared with the model at its own contact
//! ratio and pressure, so that neither the slope within a bin nor a dithering regulator adds to the error.
//!
//! If the whisker's gain wanders, a mean over all contacts would tell its past. So each bin is the scalar Kalman filter of a
//! random walk: contacts lose weight as others follow, in whichever bin.

use borsh::io::{Error, ErrorKind, Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::encoding;
use crate::mechanics::CONTACT_RATIOS;
use crate::units::ContactRatio;

/// Width of a bin in contact ratio; bins are centred on [`CONTACT_RATIOS`].
pub const WIDTH: f64 = 0.05;

/// Mean log deviation from the model in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    contacts: u32,
    weight: f32,
    mean: f32,
    mean_ratio: f64,
}

impl Bin {
    /// Number of contacts in the bin.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Mean of ln(measured / model's sensitivity), weighted by the inverse of the contacts' noise variances.
    #[must_use]
    pub fn mean(&self) -> f64 {
        f64::from(self.mean)
    }

    /// Mean contact ratio of the contacts, with the same weights. It may be off the centre: the outermost bins are
    /// half empty.
    #[must_use]
    pub fn mean_ratio(&self) -> f64 {
        self.mean_ratio
    }

    /// Variance of the mean deviation; infinite while the bin is empty.
    #[must_use]
    pub fn variance(&self) -> f64 {
        1.0 / f64::from(self.weight)
    }
}

/// Stored form of a bin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Kept {
    /// Number of contacts (at most a million) in the upper bits. The lower [`RATIO_BITS`] hold the position of the
    /// mean contact ratio within the bin, to 1.2e-5; bins are 0.05 wide and a response hardly bends within one.
    contacts_and_ratio: u32,
    /// Sum of the inverse noise variances of the contacts.
    weight: f32,
    mean: f32,
}

const RATIO_BITS: u32 = 12;
const RATIO_STEPS: u32 = 1 << RATIO_BITS;
const CONTACTS_MAX: u32 = u32::MAX >> RATIO_BITS;
/// 2^32 divided by the golden ratio: its multiples modulo 2^32 are evenly spread.
const GOLDEN: u32 = 0x9e37_79b9;

impl Kept {
    fn contacts(self) -> u32 {
        self.contacts_and_ratio >> RATIO_BITS
    }

    /// Mean contact ratio; `index` is the bin's index.
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
        // Dithered rounding: otherwise the mean of many contacts, each of which moves it by less than a step, would
        // stand still.
        let fraction = f64::from(contacts.wrapping_mul(GOLDEN)) / f64::from(u32::MAX);
        let steps = (share.clamp(0.0, 1.0) * f64::from(RATIO_STEPS - 1) + fraction) as u32;
        let steps = steps.min(RATIO_STEPS - 1);
        self.contacts_and_ratio = contacts << RATIO_BITS | steps;
        self.weight = sum as f32;
        self.mean = nearer(f64::from(self.mean), log_deviation) as f32;
    }

    /// Forgets half of the number of contacts, and nothing that they told.
    fn halve(&mut self) {
        let contacts = self.contacts().div_ceil(2);
        self.contacts_and_ratio = (contacts << RATIO_BITS) | (self.contacts_and_ratio % RATIO_STEPS);
    }

    /// The mean becomes uncertain by this variance.
    fn widen(&mut self, variance: f64) {
        let weight = f64::from(self.weight);
        self.weight = (weight / (1.0 + weight * variance)) as f32;
    }
}

/// An empty bin takes one byte.
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

/// Queue of the newest contacts, which do not count yet: the last contacts before a cut is detected already belong
/// to the cut whisker.
///
/// A contact leaves the queue after a fixed number of further contacts, whatever their values. Dropping contacts
/// because of later ones would select among them and bias the learned response.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Waiting {
    contacts: [Waits; Waiting::CONTACTS],
    /// Next position to write, and the number of queued contacts.
    at: u8,
    count: u8,
}

/// A queued contact, rounded to the precision that an average over thousands needs.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Waits {
    /// Inverse of the noise variance, to 6 %, which is enough for a weight: octaves above [`LEAST_OCTAVE`] in
    /// eighths.
    weight: u8,
    /// Log deviation in 1/4096, from -8 to 8: steps of 2.4e-4, where single contacts scatter by 0.03.
    log_deviation: i16,
    /// Contact ratio in 1/255.
    ratio: u8,
}

const LOG_DEVIATION_STEPS: f64 = 4096.0;
/// Shift of an `f32`'s bits that leaves the exponent and three bits of the fraction: octaves in eighths.
const EIGHTHS_AT: u32 = 20;
/// The exponent of the smallest weight, 2^-8, in eighths.
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

    fn counts(self, bins: &mut ResponseBins, walk: f64) {
        let ratio = f64::from(self.ratio) / f64::from(u8::MAX);
        let log_deviation = f64::from(self.log_deviation) / LOG_DEVIATION_STEPS;
        let weight = f64::from(f32::from_bits((u32::from(self.weight) + LEAST_OCTAVE) << EIGHTHS_AT));
        if let Some(index) = ContactRatio::new(ratio).ok().and_then(ResponseBins::index) {
            bins.add_at(index, ratio, log_deviation, weight, walk);
        }
    }
}

impl Waiting {
    /// Capacity: trims of 2 mm and more are mostly detected within this many contacts.
    pub const CONTACTS: usize = 16;

    /// Queues one contact, with the arguments of [`ResponseBins::add`]. If the queue is full, its oldest contact
    /// moves to the bins.
    pub fn add(&mut self, bins: &mut ResponseBins, ratio: ContactRatio, log_deviation: f64, variance: f64, walk: f64) {
        let place = &mut self.contacts[usize::from(self.at) % Self::CONTACTS];
        let longest = std::mem::replace(place, Waits::new(ratio, log_deviation, variance));
        if usize::from(self.count) == Self::CONTACTS {
            longest.counts(bins, walk);
        } else {
            self.count += 1;
        }
        self.at = (self.at + 1) % Self::CONTACTS as u8;
    }

    /// The queued contacts, oldest first.
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
            return Err(Error::new(ErrorKind::InvalidData, "more contacts are queued than the queue holds"));
        }
        let mut read = Self { at, count, ..Self::default() };
        let first = usize::from(at) + Self::CONTACTS - usize::from(count);
        for place in first..first + usize::from(count) {
            read.contacts[place % Self::CONTACTS] = Waits::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}

/// Response over the contact ratio, measured against one reference model.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct ResponseBins {
    bins: [Kept; CONTACT_RATIOS.len()],
}

impl ResponseBins {
    /// Bin of a contact ratio; `None` below 0.425.
    #[must_use]
    pub fn index(ratio: ContactRatio) -> Option<usize> {
        let steps = ((ratio.a() - CONTACT_RATIOS[0]) / WIDTH).round();
        (steps >= 0.0 && steps < CONTACT_RATIOS.len() as f64).then_some(steps as usize)
    }

    /// Adds one contact: its log deviation from the model, the noise variance of that deviation, and the random walk of the
    /// whisker's gain, log sensitivity per square root of a contact.
    pub fn add(&mut self, ratio: ContactRatio, log_deviation: f64, noise_variance: f64, walk: f64) {
        if let Some(index) = Self::index(ratio) {
            self.add_at(index, ratio.a(), log_deviation, 1.0 / noise_variance, walk);
        }
    }

    fn add_at(&mut self, index: usize, ratio: f64, log_deviation: f64, weight: f64, walk: f64) {
        if walk > 0.0 {
            self.bins.iter_mut().for_each(|bin| bin.widen(walk * walk));
        }
        self.bins[index].add(index, ratio, log_deviation, weight);
        if self.bins[index].contacts() == CONTACTS_MAX {
            // At the end of the range all counts are halved, so that evaluations after so many contacts go on.
            self.bins.iter_mut().for_each(Kept::halve);
        }
    }

    /// Adds `log_shift` to all means: the measurements move to a new scale.
    pub fn shift(&mut self, log_shift: f64) {
        for bin in self.bins.iter_mut().filter(|bin| bin.contacts() > 0) {
            bin.mean = (f64::from(bin.mean) + log_shift) as f32;
        }
    }

    /// The common level of all means becomes uncertain by this standard deviation, log sensitivity.
    pub fn doubt_level(&mut self, log_sd: f64) {
        let felt = self.felt().count() as f64;
        self.bins.iter_mut().for_each(|bin| bin.widen(felt * log_sd.powi(2)));
    }

    /// The bin around `CONTACT_RATIOS[index]`.
    #[must_use]
    pub fn bin(&self, index: usize) -> Bin {
        self.bins[index].bin(index)
    }

    /// The bin of a contact ratio, if it holds at least `contacts` contacts.
    #[must_use]
    pub fn measured(&self, ratio: ContactRatio, contacts: u32) -> Option<Bin> {
        Self::index(ratio).map(|index| self.bin(index)).filter(|bin| bin.contacts >= contacts)
    }

    /// The bins that have contacts.
    pub fn felt(&self) -> impl Iterator<Item = Bin> + '_ {
        (0..self.bins.len()).map(|index| self.bin(index)).filter(|bin| bin.contacts > 0)
    }

    /// Number of contacts in all bins.
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
            waiting.add(&mut bins, ContactRatio::TIP, 0.125 * f64::from(k), 1.0, 0.0);
        }
        assert_eq!(bins.contacts(), 24);
        assert_eq!(bins.bin(11).mean(), 0.125 * 11.5);
    }

    #[test]
    fn property_the_doubt_of_the_level_adds_to_the_variance_of_its_estimate() {
        let mut bins = ResponseBins::default();
        for (ratio, variance) in [(0.5, 4e-6), (0.7, 4e-6), (0.9, 4e-6)] {
            bins.add(ContactRatio::known(ratio), 0.0, variance, 0.0);
        }
        let of_level = |bins: &ResponseBins| 1.0 / bins.felt().map(|bin| 1.0 / bin.variance()).sum::<f64>();
        let before = of_level(&bins);
        bins.doubt_level(0.003);
        assert!((of_level(&bins) / (before + 9e-6) - 1.0).abs() < 1e-6, "{before} {}", of_level(&bins));
    }

    /// At the end of its range the number of contacts stood still, and all that is due by it never came again.
    #[test]
    fn regress_the_number_of_contacts_goes_on_beyond_its_range() {
        let mut bins = ResponseBins::default();
        let mut add = |contacts: u32| {
            let before = bins.contacts();
            (0..contacts).for_each(|_| bins.add(ContactRatio::TIP, 0.1, 1e-3, 0.0));
            (before, bins.contacts())
        };
        let (_, most) = add(CONTACTS_MAX - 1);
        let (_, halved) = add(1);
        assert_eq!((most, halved), (CONTACTS_MAX - 1, CONTACTS_MAX.div_ceil(2)));
        assert_eq!(add(1000), (halved, halved + 1000));
        assert!((bins.bin(11).mean() - 0.1).abs() < 1e-3, "nothing that they told is forgotten");
    }

    /// The closed form of a random walk's filter in the long run: gain (sqrt(q^2 + 4 q) - q) / 2, with q the walk's variance
    /// between two contacts over the noise's.
    #[test]
    fn golden_a_bin_of_a_wandering_gain_forgets_as_a_kalman_filter_does() {
        let (noise, walk) = (0.05_f64.powi(2), 5e-4);
        let mut bins = ResponseBins::default();
        let mut add = |deviation: f64| bins.add(ContactRatio::TIP, deviation, noise, walk);
        (0..1000).for_each(|_| add(0.0));
        add(1.0);
        let q = walk * walk / noise;
        let gain = 0.5 * ((q * q + 4.0 * q).sqrt() - q);
        assert!((bins.bin(11).mean() / gain - 1.0).abs() < 1e-3, "{} {gain}", bins.bin(11).mean());
        assert!((bins.bin(11).variance() / (gain * noise) - 1.0).abs() < 1e-3);
    }
}
