//! The supposed changes, each followed recursively: O(1) memory.
//!
//! A filter that goes on learning absorbs part of a real change. By how much is known exactly: a unit step
//! leaves the state wrong by `e = unit - absorbed`, is seen in the next innovation as `row . e`, and the
//! update absorbs `gain * (row . e)` more. So the expected innovations of a change that began at a given
//! contact (its signature) are known, the innovations stay independent, and the sums over
//! signature^2 and signature * innovation give the change's best estimate since then. A gradual change has a
//! signature of the same kind: it adds a unit step at every contact.
//!
//! All are followed at once, in single precision and in arrays by hypothesis, so that one instruction serves four of
//! them: their rounding is a millionth of a likelihood ratio, and they are most of what a whisker takes in time and room.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::hypothesis::{ALL, COUNT, GRADUAL_FROM, Hypothesis, OF_ANY_SIZE};
use super::start::Starts;
use crate::estimation::Innovation;
use crate::estimation::filter::{LENGTH, STATES};
use crate::estimation::outlier::{Densities, LANES};

/// Keeps the statistic finite: far above any threshold.
const SHIRYAEV_MAX: f32 = 1e15;
/// Lanes beyond the hypotheses: those of any size as if they began with this contact, ...
const BEGUN: usize = COUNT;
/// ... and no change at all.
const NO_CHANGE: usize = LANES - 1;
const _: () = assert!(BEGUN + OF_ANY_SIZE.len() <= NO_CHANGE);

/// The statistics of all supposed changes, by [`ALL`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Candidates {
    /// Shiryaev-Roberts statistic: sum over all starts of the likelihood ratio.
    shiryaev: [f32; COUNT],
    /// CUSUM: likelihood ratio since the likeliest start; 0 before the first contact, as are the sums.
    cusum: [f32; COUNT],
    /// Sums since that start: with g the signature of a unit change in standard deviations, and w the standardised
    /// innovation, of g^2 and g w, each contact by its probability of being no outlier.
    gg: [f32; COUNT],
    gw: [f32; COUNT],
    /// When each is supposed to have begun, and what the state lacks since.
    starts: Starts,
}

/// What a contact says under each supposed change.
#[derive(Debug, Clone)]
pub struct ContactSignature {
    /// What a unit of the change lets expect, in standard deviations.
    pub signature: [f32; LANES],
    /// Probability that it is no outlier.
    pub sound: [f32; LANES],
}

/// Sums over the contacts since a supposed start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    contacts: u32,
    gg: f64,
    gw: f64,
}

/// Sizes that are supposed, and what their spread takes from a standardised innovation.
struct Supposed {
    size: [f32; LANES],
    narrowed: [f32; LANES],
}

impl Candidates {
    /// Takes one innovation in; what it was under each.
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

    /// How much likelier the contact is under each supposed change than without, and whether it is an outlier.
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

    /// Where this contact alone, as the first one of a change of any size, is likelier than all since the supposed
    /// start, it is the start: an estimate that took chance for a small change would take a large one for outliers.
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

    /// How likely each has become, and whether it goes on: where it has become less likely than none its start is given
    /// up.
    fn judge(&mut self, ratio: &[f32; LANES]) -> [bool; COUNT] {
        let mut goes_on = [false; COUNT];
        for index in 0..COUNT {
            let ratio = ratio[index];
            self.shiryaev[index] = least((1.0 + self.shiryaev[index]) * ratio, SHIRYAEV_MAX);
            // It is above 0 from the first contact on.
            let so_far = if self.cusum[index] > 0.0 { self.cusum[index] } else { 1.0 };
            self.cusum[index] = least(so_far * ratio, SHIRYAEV_MAX);
            goes_on[index] = self.cusum[index] > RESTARTS_AT[index];
        }
        goes_on
    }

    /// Adds up, for those that go on.
    fn add_up(&mut self, goes_on: &[bool; COUNT], felt: &ContactSignature, standardised: f32) {
        for (index, goes_on) in goes_on.iter().enumerate() {
            let kept = |one: f32| if *goes_on { one } else { 0.0 };
            let (signature, sound) = (felt.signature[index], felt.sound[index]);
            self.cusum[index] = kept(self.cusum[index]);
            self.gg[index] = kept(self.gg[index] + sound * signature * signature);
            self.gw[index] = kept(self.gw[index] + sound * signature * standardised);
        }
    }

    /// Gives up the start of a step.
    fn forget(&mut self, index: usize) {
        (self.cusum[index], self.gg[index], self.gw[index]) = (0.0, 0.0, 0.0);
        self.starts.forget(index);
    }

    /// An alarm is over. Slow changes forget how likely it was, but not since when there may be something; steps forget
    /// everything.
    pub fn dismiss(&mut self) {
        self.shiryaev = [0.0; COUNT];
        (0..GRADUAL_FROM).for_each(|index| self.forget(index));
        self.starts.forget_steps();
    }

    /// The innovation that a unit of the change lets expect at this contact, in standard deviations.
    #[must_use]
    pub fn signature(&self, index: usize, seen: &Innovation) -> f64 {
        let expected: f64 = self.lacking(index).iter().zip(seen.row).map(|(lacks, row)| lacks * row).sum();
        expected / seen.variance.sqrt()
    }

    /// Sum over all possible starts of the likelihood ratio.
    #[must_use]
    pub fn shiryaev(&self, index: usize) -> f64 {
        f64::from(self.shiryaev[index])
    }

    /// The largest likelihood ratio since a likeliest start.
    #[must_use]
    pub fn cusum_max(&self) -> f64 {
        f64::from(self.cusum.iter().fold(0.0, |most, &one| if one > most { one } else { most }))
    }

    /// What the state lacks per unit of the change since the likeliest start.
    #[must_use]
    pub fn lacking(&self, index: usize) -> [f64; STATES] {
        self.starts.lacking(index)
    }

    /// Contacts since the likeliest start, at most [`super::start::CONTACTS_MAX`].
    #[must_use]
    pub fn contacts(&self, index: usize) -> u32 {
        self.starts.contacts(index)
    }

    /// When the changes are supposed to have begun.
    pub(super) fn starts(&self) -> &Starts {
        &self.starts
    }

    /// The sums since the likeliest start.
    #[must_use]
    pub fn evidence(&self, index: usize) -> Evidence {
        let [gg, gw] = [self.gg[index], self.gw[index]].map(f64::from);
        Evidence { contacts: self.contacts(index), gg, gw }
    }
}

/// Likelihood ratios at which supposed starts are given up.
const RESTARTS_AT: [f32; COUNT] = {
    let mut at = [0.0; COUNT];
    let mut index = 0;
    while index < COUNT {
        at[index] = ALL[index].kind.restarts_at() as f32;
        index += 1;
    }
    at
};

/// The smaller of two numbers that are no NaN.
fn least(one: f32, other: f32) -> f32 {
    if one < other { one } else { other }
}

/// What has not begun takes no room.
impl BorshSerialize for Candidates {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        self.shiryaev.serialize(writer)?;
        self.starts.serialize(writer)?;
        let begun = (0..COUNT).filter(|&index| self.contacts(index) > 0);
        begun.map(|index| (self.cusum[index], self.gg[index], self.gw[index])).try_for_each(|one| one.serialize(writer))
    }
}

impl BorshDeserialize for Candidates {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (shiryaev, starts) = BorshDeserialize::deserialize_reader(reader)?;
        let mut read = Self { shiryaev, starts, ..Self::default() };
        for index in 0..COUNT {
            if read.contacts(index) > 0 {
                (read.cusum[index], read.gg[index], read.gw[index]) = BorshDeserialize::deserialize_reader(reader)?;
            }
        }
        Ok(read)
    }
}

impl Evidence {
    /// Sums of g^2 and g w.
    #[must_use]
    pub fn sums(&self) -> (f64, f64) {
        (self.gg, self.gw)
    }

    /// The size that the contacts since the start let expect, and its variance.
    fn posterior(&self, supposed: &Hypothesis) -> (f64, f64) {
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
