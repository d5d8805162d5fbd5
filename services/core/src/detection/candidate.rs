//! One supposed shift of log length, followed recursively: O(1) memory.
//!
//! A filter that goes on learning absorbs part of a real shift. By how much is known exactly: a unit shift
//! leaves the state wrong by `e = unit - absorbed`, is seen in the next innovation as `row . e`, and the
//! update absorbs `gain * (row . e)` more. So the expected innovations of a shift that began at a given
//! contact (its signature) are known, the innovations stay independent, and the sums over
//! signature^2 and signature * innovation give the shift's best estimate since then.

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
    /// State absorbed per unit of shift since that start.
    absorbed: [f64; 3],
    /// Sums since that start.
    evidence: Evidence,
}

/// Sums over the contacts since a supposed start, for a shift and for a slope.
///
/// With g the signature of a unit shift in standard deviations, w the standardised innovation and k the
/// number of the contact: sums of g^2, g w, g^2 k, g^2 k^2, g k w.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Evidence {
    contacts: u32,
    gg: f64,
    gw: f64,
    ggk: f64,
    ggkk: f64,
    gwk: f64,
}

impl Candidate {
    /// Takes one innovation in. `shift` is the supposed shift in lambda.
    pub fn update(&mut self, shift: f64, seen: &Innovation) {
        let missing = self.missing();
        let expected: f64 = (0..3).map(|i| seen.row[i] * missing[i]).sum();
        let signature = expected / seen.variance.sqrt();
        let log_ratio = log_likelihood_ratio(signature * shift, seen.standardised);
        let ratio = log_ratio.exp();
        self.shiryaev = ((1.0 + self.shiryaev) * ratio).min(SHIRYAEV_MAX);
        self.cusum += log_ratio;
        if self.cusum <= 0.0 {
            self.restart_window();
        } else {
            for (absorbed, gain) in self.absorbed.iter_mut().zip(seen.gain) {
                *absorbed += gain * expected;
            }
            self.evidence.add(signature, seen.standardised);
        }
    }

    /// What the state lacks per unit of shift since the likeliest start.
    fn missing(&self) -> [f64; 3] {
        let mut missing = self.absorbed.map(|absorbed| -absorbed);
        missing[LENGTH] += 1.0;
        missing
    }

    fn restart_window(&mut self) {
        self.cusum = 0.0;
        self.absorbed = [0.0; 3];
        self.evidence = Evidence::default();
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

    /// What the filter has absorbed of a unit shift since the likeliest start.
    #[must_use]
    pub fn absorbed(&self) -> [f64; 3] {
        self.absorbed
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
    fn add(&mut self, signature: f64, standardised: f64) {
        let k = f64::from(self.contacts);
        let (gg, gw) = (signature * signature, signature * standardised);
        self.contacts = self.contacts.saturating_add(1);
        self.gg += gg;
        self.gw += gw;
        self.ggk += gg * k;
        self.ggkk += gg * k * k;
        self.gwk += gw * k;
    }

    /// Contacts since the supposed start.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Best estimate of the shift in lambda, and its variance; none before the first contact.
    #[must_use]
    pub fn shift(&self) -> Option<(f64, f64)> {
        (self.gg > 0.0).then(|| (self.gw / self.gg, 1.0 / self.gg))
    }

    /// Slope of lambda per contact within the window when a shift is fitted as well, in its own standard
    /// deviations: about standard normal after a step, large after a slope began.
    #[must_use]
    pub fn slope(&self) -> Option<Slope> {
        let centred = self.ggkk - self.ggk * self.ggk / self.gg;
        let covered = self.gwk - self.ggk * self.gw / self.gg;
        (self.contacts >= 8 && centred > 0.0)
            .then(|| Slope { per_contact: covered / centred, sd: centred.recip().sqrt() })
    }
}

/// A fitted slope of lambda per contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Mean.
    pub per_contact: f64,
    /// Standard deviation.
    pub sd: f64,
}
