//! One supposed shift of log length, followed recursively: O(1) memory.
//!
//! A filter that goes on learning absorbs part of a real shift. By how much is known exactly: a unit shift
//! leaves the state wrong by `e = unit - absorbed`, is seen in the next innovation as `row . e`, and the
//! update absorbs `gain * (row . e)` more. So the expected innovations of a shift that began at a given
//! contact (its signature) are known, the innovations stay independent, and the sums over
//! signature^2 and signature * innovation give the shift's best estimate since then. A slope of one per contact
//! has a signature of the same kind: it adds a unit shift at every contact.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::Innovation;
use crate::estimation::filter::LENGTH;

/// Innovations count up to this many standard deviations, and so do expected shifts: bounded influence.
pub const INFLUENCE_BOUND: f64 = 4.0;
/// Keeps the statistic finite: far above any threshold.
const SHIRYAEV_MAX: f64 = 1e15;

/// The statistics of one supposed shift.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Candidate {
    /// Shiryaev-Roberts statistic: sum over all starts of the likelihood ratio.
    shiryaev: f64,
    /// CUSUM: log likelihood ratio since the likeliest start.
    cusum: f64,
    /// What the state lacks per unit of shift at that start; a unit of length at the start itself.
    lacks_by_step: Lacking,
    /// What the state lacks per unit of slope from that start on.
    lacks_by_slope: [f64; 3],
    /// Sums since that start.
    evidence: Evidence,
}

/// What the state lacks after a unit step of lambda.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct Lacking([f64; 3]);

impl Default for Lacking {
    fn default() -> Self {
        let mut unit = [0.0; 3];
        unit[LENGTH] = 1.0;
        Self(unit)
    }
}

/// Sums over the contacts since a supposed start, for a step and for a slope.
///
/// With g and r the signatures of a unit step and a unit slope in standard deviations, and w the standardised
/// innovation: sums of g^2, g w, r^2, r w.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Evidence {
    contacts: u32,
    gg: f64,
    gw: f64,
    rr: f64,
    rw: f64,
}

/// What the innovation of a contact would be with this lacking, and what is lacking after the update.
fn seen_and_learned(lacking: &mut [f64; 3], seen: &Innovation) -> f64 {
    let expected: f64 = (0..3).map(|i| seen.row[i] * lacking[i]).sum();
    for (lacks, gain) in lacking.iter_mut().zip(seen.gain) {
        *lacks -= gain * expected;
    }
    expected / seen.variance.sqrt()
}

impl Candidate {
    /// Takes one innovation in. `shift` is the supposed shift in lambda.
    pub fn update(&mut self, shift: f64, seen: &Innovation) {
        let step = seen_and_learned(&mut self.lacks_by_step.0, seen);
        let slope = seen_and_learned(&mut self.lacks_by_slope, seen);
        self.lacks_by_slope[LENGTH] += 1.0;
        let log_ratio = log_likelihood_ratio(step * shift, seen.standardised);
        self.shiryaev = ((1.0 + self.shiryaev) * log_ratio.exp()).min(SHIRYAEV_MAX);
        self.cusum += log_ratio;
        if self.cusum <= 0.0 {
            self.restart_window();
        } else {
            self.evidence.add(step, slope, seen.standardised);
        }
    }

    fn restart_window(&mut self) {
        *self = Self { shiryaev: self.shiryaev, ..Self::default() };
    }

    /// Sum over all possible starts of the likelihood ratio.
    #[must_use]
    pub fn shiryaev(&self) -> f64 {
        self.shiryaev
    }

    /// Log likelihood ratio since the likeliest start, at least 0.
    #[must_use]
    pub fn cusum(&self) -> f64 {
        self.cusum
    }

    /// What the state lacks per unit of a step at the likeliest start.
    #[must_use]
    pub fn lacks_by_step(&self) -> [f64; 3] {
        self.lacks_by_step.0
    }

    /// What the state lacks per unit of a slope from the likeliest start on.
    #[must_use]
    pub fn lacks_by_slope(&self) -> [f64; 3] {
        self.lacks_by_slope
    }

    /// The sums since the likeliest start.
    #[must_use]
    pub fn evidence(&self) -> &Evidence {
        &self.evidence
    }
}

/// ln of N(w; shift, 1) / N(w; 0, 1) with both cut at [`INFLUENCE_BOUND`].
///
/// Cutting w can only lower the mean of the ratio below the one that it has for a standard normal w, so a
/// threshold on Shiryaev-Roberts stays on the safe side.
#[must_use]
pub fn log_likelihood_ratio(shift: f64, standardised: f64) -> f64 {
    let shift = shift.clamp(-INFLUENCE_BOUND, INFLUENCE_BOUND);
    shift * standardised.clamp(-INFLUENCE_BOUND, INFLUENCE_BOUND) - shift * shift / 2.0
}

impl Evidence {
    fn add(&mut self, step: f64, slope: f64, standardised: f64) {
        self.contacts = self.contacts.saturating_add(1);
        self.gg += step * step;
        self.gw += step * standardised;
        self.rr += slope * slope;
        self.rw += slope * standardised;
    }

    /// Contacts since the supposed start.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Best estimate of a step of lambda, and its variance; none before the first contact.
    #[must_use]
    pub fn step(&self) -> Option<(f64, f64)> {
        (self.gg > 0.0).then(|| (self.gw / self.gg, 1.0 / self.gg))
    }

    /// Log likelihood that a step of any size at the window's start gains over no change.
    #[must_use]
    pub fn gain_of_step(&self) -> f64 {
        if self.gg > 0.0 { self.gw * self.gw / (2.0 * self.gg) } else { 0.0 }
    }

    /// The same for a slope from the window's start on, of lambda per contact between 0 and `limit` (which
    /// has the sign of the change), with that slope and its variance.
    #[must_use]
    pub fn slope(&self, limit: f64) -> SlopeFit {
        if self.rr <= 0.0 {
            return SlopeFit { gain: 0.0, per_contact: 0.0, variance: 0.0 };
        }
        let per_contact = (self.rw / self.rr).clamp(limit.min(0.0), limit.max(0.0));
        let gain = per_contact * self.rw - per_contact * per_contact * self.rr / 2.0;
        SlopeFit { gain, per_contact, variance: 1.0 / self.rr }
    }
}

/// A slope that was fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlopeFit {
    /// Log likelihood that it gains over no change.
    pub gain: f64,
    /// Change of lambda per contact.
    pub per_contact: f64,
    /// Its variance.
    pub variance: f64,
}
