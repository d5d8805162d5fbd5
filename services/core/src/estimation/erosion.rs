//! Estimates how fast a whisker erodes and when it becomes too short to compensate for itself.
//!
//! A line is fitted to the filter's length estimates since the verdict, over the number of contacts
//! ([`super::trend`]). The estimates are correlated over some tens of contacts, because a filter has memory; the
//! fit over blocks of contacts takes that into account. The interval includes the error of the model that turns
//! sensitivities into lengths.

use borsh::io::{Read, Result};
use borsh::{BorshDeserialize, BorshSerialize};

use super::trend::{Interval, Trend};
use super::{LengthEstimate, Z95};
use crate::units::Millimetre;

/// Number of contacts after the verdict that are not used: their estimates have not settled yet.
const SETTLING_CONTACTS: u32 = 60;
/// Number of contacts from which on a rate is reported.
const LEAST_CONTACTS: u32 = 240;
/// Number of contacts from which on they tell the rate by which the length is followed. The verdict tells it before.
const RATE_CONTACTS: u32 = 60;
/// A filter that expects a random walk of q mm per contact lags behind a loss of v mm per contact by v r / q, with a standard
/// deviation of sqrt(q r), where one contact tells the length to r mm. This makes the lag a third of that.
const LAG_SHARE: f64 = 1.0 / 3.0;
/// Largest random walk, mm per square root of a contact.
const WANDER_MAX_MM: f64 = 0.3;
/// Largest block, in contacts. At least eight blocks count, so a changed rate shows after that.
const CONTACTS_A_BLOCK_MAX: u32 = 128;
/// Erosion is over if the loss per contact in the last contacts is certainly less than this share of that before ...
const STOPPED_SHARE: f64 = 0.6;
/// ... or than this, mm per contact, if hardly anything is known of the loss before.
const STOPPED_MM: f64 = 3e-4;
/// Standard deviations by which it must be less.
const STOPPED_SDS: f64 = 3.0;
/// Least number of the last contacts, and least number of blocks before them.
const STOPPED_CONTACTS: u32 = 160;
const BLOCKS_BEFORE: usize = 4;
/// Relative model error of a change of length (standard deviation), for a calibration that is off by 3 % or the
/// other formulation.
const MODEL_SD: f64 = 0.04;

/// Length estimates of one eroding whisker since the verdict.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct ErosionWatch {
    whole: Millimetre,
    shortest: Millimetre,
    wander_mm: f64,
    contacts: u32,
    lengths: Trend,
    /// Loss per contact by the verdict, mm.
    told_mm: f32,
}

/// Estimated erosion of a whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Erosion {
    /// Loss of length with its 95 % interval, mm per contact.
    pub mm_per_contact: Interval,
    /// Contacts until the whisker is too short to compensate for itself; 0 if it already is.
    pub contacts_left: ContactsLeft,
}

/// Number of contacts with a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactsLeft {
    /// Estimate; `None` if the estimated rate is not positive.
    pub mean: Option<f64>,
    /// Lower bound, from the highest rate and the least length; `None` if that rate is not positive.
    pub low: Option<f64>,
    /// Upper bound, from the lowest rate and the greatest length; `None` if that rate is not positive.
    pub high: Option<f64>,
}

impl ErosionWatch {
    /// Starts at the verdict of a loss of `told_mm` per contact. `shortest` is the least length that can still compensate
    /// for itself ([`crate::mechanics::compensable_range`] with the `whole` whisker as the target), `wander_mm` the random
    /// walk that the filter allows while the whisker erodes, in mm per square root of a contact.
    #[must_use]
    pub fn new(whole: Millimetre, shortest: Millimetre, wander_mm: f64, told_mm: f64) -> Self {
        let (lengths, told_mm) = (Trend::new(CONTACTS_A_BLOCK_MAX), told_mm as f32);
        Self { whole, shortest, wander_mm, contacts: 0, lengths, told_mm }
    }

    /// Reads it as it was stored before version 18 of the whisker, without the rate by the verdict.
    ///
    /// # Errors
    /// The bytes end, or are invalid.
    pub fn read_before_18<R: Read>(reader: &mut R) -> Result<Self> {
        let (whole, shortest, wander_mm, contacts, lengths) = BorshDeserialize::deserialize_reader(reader)?;
        Ok(Self { whole, shortest, wander_mm, contacts, lengths, told_mm: 0.0 })
    }

    /// Random walk of the length that the filter shall expect, mm per square root of a contact.
    #[must_use]
    pub fn wander_mm(&self) -> f64 {
        self.wander_mm
    }

    /// Loss per contact, mm, as far as it is known.
    fn rate_mm(&self) -> f64 {
        let by_contacts = self.lengths.slope().filter(|_| self.lengths.readings() >= RATE_CONTACTS);
        by_contacts.map_or(self.told_mm.into(), |slope| -slope.per_x)
    }

    /// Adds the length estimate after one contact, which tells a length with the standard deviation `contact_sd_mm`. The
    /// faster the whisker wears, the faster its length is followed, but at least with `least_mm`.
    pub fn follow(&mut self, length: &LengthEstimate, contact_sd_mm: f64, least_mm: f64) {
        self.contacts = self.contacts.saturating_add(1);
        if self.contacts > SETTLING_CONTACTS {
            self.lengths.add(f64::from(self.contacts), length.length.mm());
        }
        let fast = (self.rate_mm().max(0.0) * contact_sd_mm.sqrt() / LAG_SHARE).cbrt().powi(2);
        self.wander_mm = fast.min(WANDER_MAX_MM).max(least_mm);
    }

    /// Rate and contacts left, or `None` while there are too few contacts. `length` is the present estimate, and
    /// `learned_sd_mm` its standard deviation by contacts alone: a doubt that they do not reduce is no lag.
    #[must_use]
    pub fn erosion(&self, length: &LengthEstimate, learned_sd_mm: f64) -> Option<Erosion> {
        if self.lengths.readings() < LEAST_CONTACTS {
            return None;
        }
        let slope = self.lengths.slope()?.interval()?;
        let half = (slope.high - slope.mean).hypot(Z95 * MODEL_SD * slope.mean);
        let mm_per_contact = Interval { mean: -slope.mean, low: -slope.mean - half, high: -slope.mean + half };
        // A filter that expects a random walk lags behind a steady loss by 1 / gain contacts; its gain is the
        // walk's variance divided by its own.
        let lag_mm = mm_per_contact.mean * (learned_sd_mm / self.wander_mm).powi(2);
        let length_mm = length.length.mm() - lag_mm;
        let sd_mm = length.sd_mm.hypot(MODEL_SD * (self.whole.mm() - length_mm));
        let left = |sds: f64, rate: f64| {
            let left_mm = length_mm + sds * sd_mm - self.shortest.mm();
            (rate > 0.0).then(|| left_mm.max(0.0) / rate)
        };
        let contacts_left = ContactsLeft {
            mean: left(0.0, mm_per_contact.mean),
            low: left(-Z95, mm_per_contact.high),
            high: left(Z95, mm_per_contact.low),
        };
        Some(Erosion { mm_per_contact, contacts_left })
    }

    /// Whether the erosion has stopped. `contact_sd_mm` is the standard deviation of a length that one contact tells: that
    /// of a slope over n contacts is sqrt(12 / n^3) times as large.
    #[must_use]
    pub fn has_stopped(&self, contact_sd_mm: f64) -> bool {
        (2..=self.lengths.blocks()).any(|blocks| {
            let (before, Some(last), contacts) = self.lengths.split(blocks) else { return false };
            let sd_mm = |contacts: u32| contact_sd_mm * (12.0 / f64::from(contacts).powi(3)).sqrt();
            let earlier = self.lengths.readings().saturating_sub(contacts);
            let known = before.filter(|_| self.lengths.blocks() >= blocks + BLOCKS_BEFORE);
            let lost_mm = known.map_or(0.0, |before| -before.per_x - STOPPED_SDS * sd_mm(earlier));
            let limit_mm = (STOPPED_SHARE * lost_mm).max(STOPPED_MM);
            contacts >= STOPPED_CONTACTS && STOPPED_SDS * sd_mm(contacts) - last.per_x < limit_mm
        })
    }

    /// Least length that can compensate for itself.
    #[must_use]
    pub fn shortest(&self) -> Millimetre {
        self.shortest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_doubt_that_contacts_do_not_reduce_is_no_lag() {
        let estimate = |contact: u32, sd_mm| {
            let length = Millimetre::known(70.0 - 0.002 * f64::from(contact));
            LengthEstimate { length, sd_mm }
        };
        let mut watch = ErosionWatch::new(Millimetre::known(70.0), Millimetre::known(60.0), 0.03, 0.002);
        (1..=1000).for_each(|contact| watch.follow(&estimate(contact, 0.05), 0.3, 0.03));
        let left = |sd_mm| watch.erosion(&estimate(1000, sd_mm), 0.05).unwrap().contacts_left;
        let (without, with) = (left(0.05), left(4.5));
        // 8 mm are left, less a small lag.
        assert!((3_800.0..=4_000.0).contains(&without.mean.unwrap()), "{without:?}");
        assert_eq!(with.mean, without.mean);
        assert!(with.low < without.low && with.high > without.high, "the doubt is in the interval: {with:?}");
    }
}
