//! How fast a whisker erodes, and when it is too short to compensate for itself.
//!
//! The filter's estimates after the verdict are followed by a line over the contacts ([`super::trend`]). They hang
//! together over some tens of contacts, because a filter remembers; blocks of contacts take that into account. The
//! interval also has the error of the model by which lengths are told from sensitivities.

use borsh::{BorshDeserialize, BorshSerialize};

use super::LengthEstimate;
use super::trend::{Interval, Trend};
use crate::units::Millimetre;

/// Estimates so soon after the verdict are still on their way to the length, in contacts.
const SETTLING_CONTACTS: u32 = 60;
/// The rate is told from this many contacts on.
const LEAST_CONTACTS: u32 = 240;
/// At least eight blocks of so many contacts count: a rate that changes shows after that.
const CONTACTS_A_BLOCK_MAX: u32 = 128;
/// Lengths come from a model: with a calibration that is off by 3 %, or the other formulation, a change of length
/// comes out wrong by so much of itself (standard deviation).
const MODEL_SD: f64 = 0.04;
/// 1.96: half a 95 % interval in standard deviations.
const Z95: f64 = 1.959_963_985;

/// The length of one eroding whisker since the verdict.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct ErosionWatch {
    whole: Millimetre,
    shortest: Millimetre,
    wander_mm: f64,
    contacts: u32,
    lengths: Trend,
}

/// An erosion as it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Erosion {
    /// Loss of length, mm per contact.
    pub mm_per_contact: Interval,
    /// Contacts until the whisker is shorter than what can compensate for itself; 0 if it is already.
    pub contacts_left: ContactsLeft,
}

/// A number of contacts with a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactsLeft {
    /// At the estimated rate and length; none if it does not erode at all.
    pub mean: Option<f64>,
    /// At the highest rate and the least length.
    pub low: Option<f64>,
    /// At the lowest rate and the greatest length; none if it may not erode at all.
    pub high: Option<f64>,
}

impl ErosionWatch {
    /// From the verdict on. `shortest` is the least length that can still compensate for itself
    /// ([`crate::mechanics::compensable_range`] with the `whole` whisker as the target), `wander_mm` the random walk per
    /// square root of a contact that the filter allows while it erodes.
    #[must_use]
    pub fn new(whole: Millimetre, shortest: Millimetre, wander_mm: f64) -> Self {
        Self { whole, shortest, wander_mm, contacts: 0, lengths: Trend::new(CONTACTS_A_BLOCK_MAX) }
    }

    /// Takes the estimate after one contact in.
    pub fn follow(&mut self, length: &LengthEstimate) {
        self.contacts = self.contacts.saturating_add(1);
        if self.contacts > SETTLING_CONTACTS {
            self.lengths.add(f64::from(self.contacts), length.length.mm());
        }
    }

    /// Rate and reach, once there are contacts enough. `length` is the present estimate.
    #[must_use]
    pub fn erosion(&self, length: &LengthEstimate) -> Option<Erosion> {
        if self.lengths.readings() < LEAST_CONTACTS {
            return None;
        }
        let slope = self.lengths.slope()?.interval()?;
        let half = (slope.high - slope.mean).hypot(Z95 * MODEL_SD * slope.mean);
        let mm_per_contact = Interval { mean: -slope.mean, low: -slope.mean - half, high: -slope.mean + half };
        // A filter that expects a random walk lags behind a steady loss by 1 / gain contacts, and its gain is the
        // walk's variance over its own.
        let lag_mm = mm_per_contact.mean * (length.sd_mm / self.wander_mm).powi(2);
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

    /// The least length that can compensate for itself.
    #[must_use]
    pub fn shortest(&self) -> Millimetre {
        self.shortest
    }
}
