//! Responses averaged within contact-ratio bins.
//!
//! Single contacts are too noisy for Eq. 35: 4 % of noise on a difference of 17 %. Within a bin the mean of
//! `ln(measured sensitivity / model's)` is kept, each contact compared at its own contact ratio and pressure,
//! so that neither the slope within a bin nor a dithering regulator adds to the error.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::mechanics::CONTACT_RATIOS;
use crate::units::ContactRatio;

/// Width of a bin in contact ratio; bins are centred on [`CONTACT_RATIOS`].
pub const WIDTH: f64 = 0.05;

/// The mean log deviation from the model in one bin.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Bin {
    contacts: u32,
    weight: f64,
    sum: f64,
    ratios: f64,
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
        if self.weight > 0.0 { self.sum / self.weight } else { 0.0 }
    }

    /// Mean contact ratio of the contacts, weighted likewise: the outermost bins are half empty.
    #[must_use]
    pub fn mean_ratio(&self) -> f64 {
        if self.weight > 0.0 { self.ratios / self.weight } else { 0.0 }
    }

    /// Variance of the mean deviation; infinite while empty.
    #[must_use]
    pub fn variance(&self) -> f64 {
        1.0 / self.weight
    }
}

/// Contacts that wait before they count: the last ones before a cut is noticed are of the cut whisker already.
///
/// They wait for further contacts and not for what these say: whoever dropped contacts because of what followed
/// would choose among them, and learn a biased response.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Waiting {
    contacts: Vec<(ContactRatio, f64, f64)>,
}

impl Waiting {
    /// How many wait: trims of 2 mm and more are mostly noticed within so many.
    pub const CONTACTS: usize = 16;

    /// Takes one contact in, as [`ResponseBins::add`] does; the one that has waited longest goes to the bins.
    pub fn add(&mut self, bins: &mut ResponseBins, ratio: ContactRatio, log_deviation: f64, noise_variance: f64) {
        if self.contacts.len() == Self::CONTACTS {
            let (ratio, log_deviation, noise_variance) = self.contacts.remove(0);
            bins.add(ratio, log_deviation, noise_variance);
        }
        self.contacts.push((ratio, log_deviation, noise_variance));
    }
}

/// A response over the contact ratio, measured against one reference of the model.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct ResponseBins {
    bins: [Bin; CONTACT_RATIOS.len()],
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
            let bin = &mut self.bins[index];
            bin.contacts = bin.contacts.saturating_add(1);
            bin.weight += 1.0 / noise_variance;
            bin.sum += log_deviation / noise_variance;
            bin.ratios += ratio.a() / noise_variance;
        }
    }

    /// Every log deviation is another by this much: what was measured is brought to a new scale.
    pub fn shift(&mut self, log_shift: f64) {
        for bin in &mut self.bins {
            bin.sum += log_shift * bin.weight;
        }
    }

    /// The bin around `CONTACT_RATIOS[index]`.
    #[must_use]
    pub fn bin(&self, index: usize) -> &Bin {
        &self.bins[index]
    }

    /// The bin of a contact ratio, if it has at least `contacts`.
    #[must_use]
    pub fn measured(&self, ratio: ContactRatio, contacts: u32) -> Option<&Bin> {
        Self::index(ratio).map(|index| &self.bins[index]).filter(|bin| bin.contacts >= contacts)
    }

    /// The bins with contacts.
    pub fn felt(&self) -> impl Iterator<Item = &Bin> {
        self.bins.iter().filter(|bin| bin.contacts > 0)
    }

    /// Contacts in all bins.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.bins.iter().map(|bin| bin.contacts).fold(0, u32::saturating_add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_contacts_do_not_count_yet() {
        let (mut waiting, mut bins) = (Waiting::default(), ResponseBins::default());
        for k in 0..40 {
            waiting.add(&mut bins, ContactRatio::TIP, f64::from(k), 1.0);
        }
        assert_eq!(bins.contacts(), 24);
        assert_eq!(bins.bin(11).mean(), 11.5);
    }
}
