//! Whether a supposed cut goes on: the slope beside the step, from the same start.
//!
//! Erosion that has gone on for a while looks like a step from some contact on, plus a slope. A cut has no
//! slope. So beside each supposed cut the sums for a slope from the same start are kept, and both are fitted
//! together.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::candidate::{Candidates, ContactSignature, Evidence};
use super::hypothesis::CUTS;
use super::start::STEPS;
use crate::estimation::Innovation;
use crate::estimation::filter::{LENGTH, STATES};

/// Step and slope are told apart where the determinant of their sums is more than this part of what it could be: below
/// it is the rounding of the sums.
const LEAST_DETERMINANT: f64 = 1e-5;

/// What slopes from the starts of supposed cuts let expect, and the sums for them by cut: with g the signature of the
/// step, r that of the slope and w the standardised innovation, of r^2, r w and g r. All 0 where no cut has such a start.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Continuations {
    /// By start.
    lacking: [[f32; STEPS]; STATES],
    rr: [f32; CUTS],
    rw: [f32; CUTS],
    gr: [f32; CUTS],
}

impl Continuations {
    /// Takes a contact in that the candidates have felt.
    pub fn update(&mut self, seen: &Innovation, candidates: &Candidates, felt: &ContactSignature) {
        let sd = seen.variance.sqrt();
        let standardised = seen.standardised as f32;
        let slope = self.slopes(seen, sd);
        let starts = candidates.starts();
        let (mut goes_on, mut begins) = (0_u32, 0_u32);
        for index in 0..CUTS {
            let (place, contacts) = (starts.place(index), starts.contacts(index));
            // The step itself is there from the first contact on; the slope adds its first share after it.
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

    /// What a unit of each slope lets expect, in standard deviations; the filter has learned from it.
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

    /// Log likelihood that a further loss of length gains beside a step; 0 where the length does not fall further, and
    /// for what is no cut.
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

    /// Writes what belongs to the cuts that were felt since they have begun.
    pub fn write<W: Write>(&self, candidates: &Candidates, writer: &mut W) -> Result<()> {
        for place in places(candidates) {
            self.lacking.iter().try_for_each(|one| one[place].serialize(writer))?;
        }
        for index in (0..CUTS).filter(|&index| candidates.contacts(index) > 1) {
            (self.rr[index], self.rw[index], self.gr[index]).serialize(writer)?;
        }
        Ok(())
    }

    /// Reads that again.
    pub fn read<R: Read>(candidates: &Candidates, reader: &mut R) -> Result<Self> {
        let mut read = Self::default();
        for place in places(candidates) {
            for one in &mut read.lacking {
                one[place] = f32::deserialize_reader(reader)?;
            }
        }
        for index in (0..CUTS).filter(|&index| candidates.contacts(index) > 1) {
            (read.rr[index], read.rw[index], read.gr[index]) = BorshDeserialize::deserialize_reader(reader)?;
        }
        Ok(read)
    }
}

/// Starts of cuts, each once.
fn places(candidates: &Candidates) -> impl Iterator<Item = usize> {
    let starts = candidates.starts();
    let bits = (0..CUTS).fold(0_u32, |bits, index| bits | 1 << starts.place(index));
    (0..STEPS).filter(move |place| bits & 1 << place != 0)
}
