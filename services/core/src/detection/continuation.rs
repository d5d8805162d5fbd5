//! Tells a cut from erosion: fits a slope beside the step, from the same start.
//!
//! Long-lasting erosion looks like a step at some contact plus a slope; a cut has no slope. So each cut hypothesis
//! also carries the sums for a slope from the same start, and both are fitted together.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::candidate::{Candidates, ContactSignature, Evidence};
use super::hypothesis::CUTS;
use super::start::{STEPS, Stored};
use crate::estimation::Innovation;
use crate::estimation::filter::{LENGTH, STATES};

/// Lower limit of the determinant of the joint fit, relative to the product of its diagonal. Below it the
/// determinant is only rounding error of the sums, and step and slope cannot be separated.
const LEAST_DETERMINANT: f64 = 1e-5;

/// State errors of slopes from the starts of the cut hypotheses, and the sums for the joint fit by cut: r^2, r w
/// and g r, with g the signature of the step, r that of the slope and w the standardised innovation. All are 0 for
/// a cut without a start.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Continuations {
    /// State error per unit slope, by state and by start.
    lacking: [[f32; STEPS]; STATES],
    rr: [f32; CUTS],
    rw: [f32; CUTS],
    gr: [f32; CUTS],
}

impl Continuations {
    /// Adds a contact that the candidates have already evaluated.
    pub fn update(&mut self, seen: &Innovation, candidates: &Candidates, felt: &ContactSignature) {
        let sd = seen.variance.sqrt();
        let standardised = seen.standardised as f32;
        let slope = self.slopes(seen, sd);
        let starts = candidates.starts();
        let (mut goes_on, mut begins) = (0_u32, 0_u32);
        for index in 0..CUTS {
            let (place, contacts) = (starts.place(index), starts.contacts(index));
            // The step is present from the first contact on; the slope adds its first share after it.
            let is_felt = contacts > 1;
            goes_on |= u32::from(is_felt) << place;
            begins |= u32::from(contacts == 1) << place;
            let kept = |one: f32| if is_felt { one } else { 0.0 };
            let slope = slope.get(place).copied().unwrap_or(0.0);
            let weighed = felt.sound[index] * slope;
            self.rr[index] = kept(self.rr[index] + weighed * slope);
            self.rw[index] = kept(self.rw[index] + weighed * standardised);
            self.gr[index] = kept(self.gr[index] + weighed * felt.signature[index]);
        }
        for (state, one) in self.lacking.iter_mut().enumerate() {
            let more = if state == LENGTH { 1.0 } else { 0.0 };
            for (place, lacks) in one.iter_mut().enumerate() {
                *lacks = match (goes_on >> place & 1, begins >> place & 1) {
                    (1, _) => *lacks + more,
                    (_, 1) => more,
                    _ => 0.0,
                };
            }
        }
    }

    /// Expected innovation per unit of each slope, in standard deviations. Also subtracts what the filter has
    /// absorbed of it.
    fn slopes(&mut self, seen: &Innovation, sd: f64) -> [f32; STEPS] {
        let mut slopes = [0.0; STEPS];
        for (one, row) in self.lacking.iter().zip(seen.row) {
            let row = (row / sd) as f32;
            for (slope, lacks) in slopes.iter_mut().zip(one) {
                *slope += row * lacks;
            }
        }
        for (one, gain) in self.lacking.iter_mut().zip(seen.gain) {
            let gain = (gain * sd) as f32;
            for (lacks, slope) in one.iter_mut().zip(slopes) {
                *lacks -= gain * slope;
            }
        }
        slopes
    }

    /// Log likelihood gained by a further loss of length beside the step. 0 if the length does not fall further,
    /// and for hypotheses other than cuts.
    #[must_use]
    pub fn gain_of_going_on(&self, index: usize, step: &Evidence) -> f64 {
        if index >= CUTS {
            return 0.0;
        }
        let [rr, rw, gr] = [self.rr[index], self.rw[index], self.gr[index]].map(f64::from);
        let (gg, gw) = step.sums();
        let determinant = gg * rr - gr * gr;
        if determinant <= LEAST_DETERMINANT * gg * rr {
            return 0.0;
        }
        let slope = (gg * rw - gr * gw) / determinant;
        if slope >= 0.0 { 0.0 } else { 0.5 * slope * slope * determinant / gg }
    }

    /// Writes the slopes and sums of the cuts that have at least two contacts.
    pub fn write<W: Write>(&self, candidates: &Candidates, writer: &mut W) -> Result<()> {
        for place in places(candidates) {
            self.lacking.iter().try_for_each(|one| one[place].serialize(writer))?;
        }
        for index in (0..CUTS).filter(|&index| candidates.contacts(index) > 1) {
            (self.rr[index], self.rw[index], self.gr[index]).serialize(writer)?;
        }
        Ok(())
    }

    /// Reads the output of [`Self::write`].
    pub fn read<R: Read>(stored: &Stored, candidates: &Candidates, reader: &mut R) -> Result<Self> {
        let mut read = Self::default();
        for place in places(candidates) {
            for one in read.lacking.iter_mut().take(stored.states) {
                one[place] = f32::deserialize_reader(reader)?;
            }
        }
        for index in (0..CUTS).filter(|&index| candidates.contacts(index) > 1) {
            (read.rr[index], read.rw[index], read.gr[index]) = BorshDeserialize::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}

/// Places of the starts that cut hypotheses use, each once.
fn places(candidates: &Candidates) -> impl Iterator<Item = usize> {
    let starts = candidates.starts();
    let bits = (0..CUTS).fold(0_u32, |bits, index| bits | 1 << starts.place(index));
    (0..STEPS).filter(move |place| bits & 1 << place != 0)
}
