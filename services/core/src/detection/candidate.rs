//! Recursive statistics of each change hypothesis, in constant memory.
//!
//! The filter keeps learning and so absorbs part of a real change; the absorbed part is known exactly. A unit step
//! leaves the state wrong by `e = unit - absorbed`. It appears in the next innovation as `row . e`, and the update
//! absorbs `gain * (row . e)` more. So the expected innovations of a change that began at a given contact (its
//! signature) are known, the innovations stay independent, and the sums of signature^2 and signature * innovation
//! give the best estimate of the change since then. A gradual change has a signature of the same kind: it adds a
//! unit step at every contact.
//!
//! All hypotheses are updated together, in single precision and in arrays indexed by hypothesis, so that one SIMD
//! instruction serves four of them. The rounding error is a millionth of a likelihood ratio, and these arrays take
//! most of a whisker's time and memory.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::hypothesis::{ALL, COUNT, GRADUAL_FROM, Hypothesis, OF_ANY_SIZE};
use super::start::{Starts, Stored};
use crate::estimation::Innovation;
use crate::estimation::filter::{LENGTH, STATES};
use crate::estimation::outlier::{Densities, LANES};

/// Upper limit that keeps the statistic finite; far above any threshold.
const SHIRYAEV_MAX: f32 = 1e15;
/// First lane of the hypotheses of any size evaluated as if they began with this contact.
const BEGUN: usize = COUNT;
/// Lane of the hypothesis that nothing has changed.
const NO_CHANGE: usize = LANES - 1;
const _: () = assert!(BEGUN + OF_ANY_SIZE.len() <= NO_CHANGE);

/// Statistics of all change hypotheses, in the order of [`ALL`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Candidates {
    /// Shiryaev-Roberts statistic: sum of the likelihood ratios over all possible starts.
    shiryaev: [f32; COUNT],
    /// CUSUM: likelihood ratio since the most likely start. 0 before the first contact, as are the sums below.
    cusum: [f32; COUNT],
    /// Sums since that start: g^2 and g w, with g the signature of a unit change in standard deviations and w the
    /// standardised innovation. Each contact is weighted by its probability of not being an outlier.
    gg: [f32; COUNT],
    gw: [f32; COUNT],
    /// Most likely start of each hypothesis, and the state error that a unit change has left since then.
    starts: Starts,
}

/// Evaluation of one contact under each hypothesis.
#[derive(Debug, Clone)]
pub struct ContactSignature {
    /// Expected innovation for a unit of the change, in standard deviations.
    pub signature: [f32; LANES],
    /// Probability that the contact is not an outlier.
    pub sound: [f32; LANES],
}

/// Sums over the contacts since the most likely start of a hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    contacts: u32,
    gg: f64,
    gw: f64,
}

/// Assumed size of each hypothesis, and the factor by which the uncertainty of that size scales an innovation.
struct Supposed {
    size: [f32; LANES],
    narrowed: [f32; LANES],
}

impl Candidates {
    /// Updates all statistics with one innovation and returns its evaluation under each hypothesis.
    pub fn update(&mut self, seen: &Innovation) -> ContactSignature {
        let sd = seen.variance.sqrt();
        let row: [f32; STATES] = seen.row.map(|one| (one / sd) as f32);
        let gain: [f32; STATES] = seen.gain.map(|one| (one * sd) as f32);
        let expected = self.starts.expect(&row);
        let mut signature = [0.0; LANES];
        self.starts.by_change(&expected, &mut signature);
        signature[BEGUN..BEGUN + OF_ANY_SIZE.len()].fill(row[LENGTH]);
        let (ratio, sound) = self.likelihood_ratios(seen, &signature);
        let mut felt = ContactSignature { signature, sound };
        let ratio = self.rather_begin(&mut felt, ratio);
        let mut goes_on = self.judge(&ratio);
        self.starts.follow(&gain, &expected, &mut goes_on);
        self.add_up(&goes_on, &felt, seen.standardised as f32);
        felt
    }

    /// Likelihood ratio of the contact under each hypothesis against no change, and the probability that it is not
    /// an outlier.
    fn likelihood_ratios(&self, seen: &Innovation, signature: &[f32; LANES]) -> ([f32; LANES], [f32; LANES]) {
        let supposed = self.supposed(signature);
        let mut off = [seen.standardised as f32; LANES];
        for index in 0..NO_CHANGE {
            off[index] = (off[index] - signature[index] * supposed.size[index]) * supposed.narrowed[index];
        }
        let Densities { mut density, sound } = seen.density.at_each(&off);
        let unchanged = 1.0 / density[NO_CHANGE];
        for (density, narrowed) in density.iter_mut().zip(supposed.narrowed) {
            *density *= narrowed * unchanged;
        }
        (density, sound)
    }

    fn supposed(&self, signature: &[f32; LANES]) -> Supposed {
        let mut supposed = Supposed { size: [0.0; LANES], narrowed: [1.0; LANES] };
        for (size, one) in supposed.size.iter_mut().zip(&ALL) {
            *size = one.size as f32;
        }
        for (lane, index) in OF_ANY_SIZE.into_iter().enumerate() {
            let one = &ALL[index];
            for (lane, (size, variance)) in
                [(index, self.evidence(index).posterior(one)), (BEGUN + lane, (one.size, one.spread.powi(2)))]
            {
                let signature = f64::from(signature[lane]);
                supposed.size[lane] = size as f32;
                supposed.narrowed[lane] = (1.0 / (1.0 + signature * signature * variance).sqrt()) as f32;
            }
        }
        supposed
    }

    /// Restarts a hypothesis of any size at this contact if the contact alone, as the first one of a change, is
    /// more likely than all contacts since the present start. Otherwise a size estimate that mistook chance for a
    /// small change would treat a large change as outliers.
    fn rather_begin(&mut self, felt: &mut ContactSignature, mut ratio: [f32; LANES]) -> [f32; LANES] {
        for (lane, index) in OF_ANY_SIZE.into_iter().enumerate() {
            let begun = BEGUN + lane;
            if self.contacts(index) > 0 && ratio[begun] > self.cusum[index] * ratio[index] {
                self.forget(index);
                ratio[index] = ratio[begun];
                felt.signature[index] = felt.signature[begun];
                felt.sound[index] = felt.sound[begun];
            }
        }
        ratio
    }

    /// Updates the likelihood ratios and returns whether each hypothesis continues. A hypothesis less likely than
    /// its restart threshold loses its start.
    fn judge(&mut self, ratio: &[f32; LANES]) -> [bool; COUNT] {
        let mut goes_on = [false; COUNT];
        for index in 0..COUNT {
            let ratio = ratio[index];
            self.shiryaev[index] = least((1.0 + self.shiryaev[index]) * ratio, SHIRYAEV_MAX);
            // CUSUM is positive from the first contact on.
            let so_far = if self.cusum[index] > 0.0 { self.cusum[index] } else { 1.0 };
            self.cusum[index] = least(so_far * ratio, SHIRYAEV_MAX);
            goes_on[index] = self.cusum[index] > RESTARTS_AT[index];
        }
        goes_on
    }

    /// Adds the contact to the sums of the hypotheses that continue, and clears the others.
    fn add_up(&mut self, goes_on: &[bool; COUNT], felt: &ContactSignature, standardised: f32) {
        for (index, goes_on) in goes_on.iter().enumerate() {
            let kept = |one: f32| if *goes_on { one } else { 0.0 };
            let (signature, sound) = (felt.signature[index], felt.sound[index]);
            self.cusum[index] = kept(self.cusum[index]);
            self.gg[index] = kept(self.gg[index] + sound * signature * signature);
            self.gw[index] = kept(self.gw[index] + sound * signature * standardised);
        }
    }

    /// Discards the start of a step.
    fn forget(&mut self, index: usize) {
        (self.cusum[index], self.gg[index], self.gw[index]) = (0.0, 0.0, 0.0);
        self.starts.forget(index);
    }

    /// Ends an alarm. Gradual changes lose their Shiryaev-Roberts statistic but keep their starts; steps lose
    /// everything.
    pub fn dismiss(&mut self) {
        self.shiryaev = [0.0; COUNT];
        (0..GRADUAL_FROM).for_each(|index| self.forget(index));
        self.starts.forget_steps();
    }

    /// Expected innovation at this contact for a unit of the change, in standard deviations.
    #[must_use]
    pub fn signature(&self, index: usize, seen: &Innovation) -> f64 {
        let expected: f64 = self.lacking(index).iter().zip(seen.row).map(|(lacks, row)| lacks * row).sum();
        expected / seen.variance.sqrt()
    }

    /// Shiryaev-Roberts statistic: sum of the likelihood ratios over all possible starts.
    #[must_use]
    pub fn shiryaev(&self, index: usize) -> f64 {
        f64::from(self.shiryaev[index])
    }

    /// Log likelihood ratio of a hypothesis against no change since its most likely start; minus infinity before the
    /// first contact.
    #[must_use]
    pub fn log_ratio(&self, index: usize) -> f64 {
        f64::from(self.cusum[index]).ln()
    }

    /// Largest CUSUM likelihood ratio over all hypotheses.
    #[must_use]
    pub fn cusum_max(&self) -> f64 {
        f64::from(self.cusum.iter().fold(0.0, |most, &one| if one > most { one } else { most }))
    }

    /// State error per unit of the change since the most likely start.
    #[must_use]
    pub fn lacking(&self, index: usize) -> [f64; STATES] {
        self.starts.lacking(index)
    }

    /// Contacts since the most likely start, at most [`super::start::CONTACTS_MAX`].
    #[must_use]
    pub fn contacts(&self, index: usize) -> u32 {
        self.starts.contacts(index)
    }

    /// Starts of all hypotheses.
    pub(super) fn starts(&self) -> &Starts {
        &self.starts
    }

    /// Sums since the most likely start.
    #[must_use]
    pub fn evidence(&self, index: usize) -> Evidence {
        let [gg, gw] = [self.gg[index], self.gw[index]].map(f64::from);
        Evidence { contacts: self.contacts(index), gg, gw }
    }
}

/// Likelihood ratio of each hypothesis below which its start is discarded.
const RESTARTS_AT: [f32; COUNT] = {
    let mut at = [0.0; COUNT];
    let mut index = 0;
    while index < COUNT {
        at[index] = ALL[index].kind.restarts_at() as f32;
        index += 1;
    }
    at
};

/// The smaller of two numbers, neither of which may be NaN.
fn least(one: f32, other: f32) -> f32 {
    if one < other { one } else { other }
}

/// Hypotheses that have not begun take no space.
impl BorshSerialize for Candidates {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        self.shiryaev.serialize(writer)?;
        self.starts.serialize(writer)?;
        let begun = (0..COUNT).filter(|&index| self.contacts(index) > 0);
        begun.map(|index| (self.cusum[index], self.gg[index], self.gw[index])).try_for_each(|one| one.serialize(writer))
    }
}

impl Candidates {
    /// Reads stored bytes.
    pub fn read<R: Read>(stored: &Stored, reader: &mut R) -> Result<Self> {
        let shiryaev = BorshDeserialize::deserialize_reader(reader)?;
        let mut read = Self { shiryaev, starts: Starts::read(stored, reader)?, ..Self::default() };
        for index in 0..COUNT {
            if read.contacts(index) > 0 {
                (read.cusum[index], read.gg[index], read.gw[index]) = BorshDeserialize::deserialize_reader(reader)?;
            }
        }
        Ok(read)
    }
}

impl Evidence {
    /// The sums of g^2 and g w.
    #[must_use]
    pub fn sums(&self) -> (f64, f64) {
        (self.gg, self.gw)
    }

    /// Posterior mean and variance of the size, given the contacts since the start.
    fn posterior(&self, supposed: &Hypothesis) -> (f64, f64) {
        let prior = supposed.spread.powi(-2);
        let precision = prior + self.gg;
        ((prior * supposed.size + self.gw) / precision, 1.0 / precision)
    }

    /// Sums over the contacts before a later step, whose signature is nearly the same since then.
    #[must_use]
    pub(super) fn before(&self, later: &Self) -> Self {
        let contacts = self.contacts.saturating_sub(later.contacts);
        Self { contacts, gg: self.gg - later.gg, gw: self.gw - later.gw }
    }

    /// Contacts since the most likely start.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Maximum-likelihood size within the limits, its variance, and its log likelihood gain over no change. `None`
    /// before the first contact.
    #[must_use]
    pub fn fit(&self, (least, most): (f64, f64)) -> Option<Fit> {
        (self.gg > 0.0).then(|| {
            let size = (self.gw / self.gg).clamp(least, most);
            Fit { size, variance: 1.0 / self.gg, gain: size * self.gw - 0.5 * size * size * self.gg }
        })
    }
}

/// Fitted size of a change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Fitted size, in the unit of the hypothesis.
    pub size: f64,
    /// Variance of the size.
    pub variance: f64,
    /// Log likelihood gain over no change.
    pub gain: f64,
}
