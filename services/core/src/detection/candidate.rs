//! One supposed change, followed recursively: O(1) memory.
//!
//! A filter that goes on learning absorbs part of a real change. By how much is known exactly: a unit step
//! leaves the state wrong by `e = unit - absorbed`, is seen in the next innovation as `row . e`, and the
//! update absorbs `gain * (row . e)` more. So the expected innovations of a change that began at a given
//! contact (its signature) are known, the innovations stay independent, and the sums over
//! signature^2 and signature * innovation give the change's best estimate since then. A gradual change has a
//! signature of the same kind: it adds a unit step at every contact.

use borsh::{BorshDeserialize, BorshSerialize};

use super::hypothesis::Hypothesis;
use crate::estimation::Innovation;
use crate::estimation::filter::STATES;

/// Keeps the statistic finite: far above any threshold.
const SHIRYAEV_MAX: f64 = 1e15;

/// The statistics of one supposed change.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Candidate {
    /// Shiryaev-Roberts statistic: sum over all starts of the likelihood ratio.
    shiryaev: f64,
    /// CUSUM: likelihood ratio since the likeliest start; 0 before the first contact.
    cusum: f64,
    /// What the state lacks per unit of the change since that start.
    lacking: [f64; STATES],
    /// Sums since that start.
    evidence: Evidence,
}

/// Sums over the contacts since a supposed start: with g the signature of a unit change in standard deviations
/// and w the standardised innovation, sums of g^2 and g w, each contact by its probability of being no outlier.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Evidence {
    contacts: u32,
    gg: f64,
    gw: f64,
}

impl Candidate {
    /// Takes one innovation in. None where the supposed start was given up.
    pub fn update(&mut self, supposed: &Hypothesis, seen: &Innovation) -> Option<Felt> {
        let state = supposed.kind.state();
        if self.would_rather_begin(supposed, seen) {
            *self = Self { shiryaev: self.shiryaev, ..Self::default() };
        }
        if supposed.kind.is_gradual() || self.evidence.contacts == 0 {
            self.lacking[state] += 1.0;
        }
        let signature = self.signature(seen);
        let unlearned = signature * seen.variance.sqrt();
        for (lacks, gain) in self.lacking.iter_mut().zip(seen.gain) {
            *lacks -= gain * unlearned;
        }
        let (size, variance) = self.evidence.posterior(supposed);
        let spread = (1.0 + signature * signature * variance).sqrt();
        let under = seen.density.at((seen.standardised - signature * size) / spread);
        let ratio = under.density / spread / seen.seen.density;
        self.shiryaev = ((1.0 + self.shiryaev) * ratio).min(SHIRYAEV_MAX);
        let so_far = if self.evidence.contacts == 0 { 1.0 } else { self.cusum };
        self.cusum = (so_far * ratio).min(SHIRYAEV_MAX);
        if self.cusum <= supposed.kind.restarts_at() {
            *self = Self { shiryaev: self.shiryaev, ..Self::default() };
            None
        } else {
            self.evidence.add(signature, seen.standardised, under.sound);
            Some(Felt { signature, sound: under.sound })
        }
    }

    /// Whether this contact alone, as the first one of a change of any size, is likelier than all since the supposed
    /// start: an estimate that took chance for a small change would take a large one for outliers.
    fn would_rather_begin(&self, supposed: &Hypothesis, seen: &Innovation) -> bool {
        if supposed.spread == 0.0 || self.evidence.contacts == 0 {
            return false;
        }
        let ratio = |candidate: &Self| {
            let signature = candidate.signature(seen);
            let (size, variance) = candidate.evidence.posterior(supposed);
            let spread = (1.0 + signature * signature * variance).sqrt();
            seen.density.at((seen.standardised - signature * size) / spread).density / spread
        };
        let mut begun = Self::default();
        begun.lacking[supposed.kind.state()] = 1.0;
        ratio(&begun) > self.cusum * ratio(self)
    }

    /// Forgets how likely an alarm was, but not since when there may be something.
    pub fn calm(&mut self) {
        self.shiryaev = 0.0;
    }

    /// The innovation that a unit of the change lets expect at this contact, in standard deviations.
    #[must_use]
    pub fn signature(&self, seen: &Innovation) -> f64 {
        let expected: f64 = (0..STATES).map(|state| seen.row[state] * self.lacking[state]).sum();
        expected / seen.variance.sqrt()
    }

    /// Sum over all possible starts of the likelihood ratio.
    #[must_use]
    pub fn shiryaev(&self) -> f64 {
        self.shiryaev
    }

    /// Likelihood ratio since the likeliest start.
    #[must_use]
    pub fn cusum(&self) -> f64 {
        self.cusum
    }

    /// What the state lacks per unit of the change since the likeliest start.
    #[must_use]
    pub fn lacking(&self) -> [f64; STATES] {
        self.lacking
    }

    /// The sums since the likeliest start.
    #[must_use]
    pub fn evidence(&self) -> &Evidence {
        &self.evidence
    }
}

/// One contact under a supposed change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Felt {
    /// What a unit of the change lets expect, in standard deviations.
    pub signature: f64,
    /// Probability that it is no outlier.
    pub sound: f64,
}

impl Evidence {
    /// Sums of g^2 and g w.
    #[must_use]
    pub fn sums(&self) -> (f64, f64) {
        (self.gg, self.gw)
    }

    fn add(&mut self, signature: f64, standardised: f64, sound: f64) {
        self.contacts = self.contacts.saturating_add(1);
        self.gg += sound * signature * signature;
        self.gw += sound * signature * standardised;
    }

    /// The size that the contacts since the start let expect, and its variance.
    fn posterior(&self, supposed: &Hypothesis) -> (f64, f64) {
        if supposed.spread == 0.0 {
            return (supposed.size, 0.0);
        }
        let prior = supposed.spread.powi(-2);
        let precision = prior + self.gg;
        ((prior * supposed.size + self.gw) / precision, 1.0 / precision)
    }

    /// Contacts since the supposed start.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Best estimate of the change's size between two limits, its variance, and the log likelihood that it
    /// gains over no change. None before the first contact.
    #[must_use]
    pub fn fit(&self, (least, most): (f64, f64)) -> Option<Fit> {
        (self.gg > 0.0).then(|| {
            let size = (self.gw / self.gg).clamp(least, most);
            Fit { size, variance: 1.0 / self.gg, gain: size * self.gw - 0.5 * size * size * self.gg }
        })
    }
}

/// A size that was fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Size, in the hypothesis' unit.
    pub size: f64,
    /// Its variance.
    pub variance: f64,
    /// Log likelihood that it gains over no change.
    pub gain: f64,
}
