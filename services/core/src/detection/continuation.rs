//! Whether a supposed cut goes on: the slope beside the step, from the same start.
//!
//! Erosion that has gone on for a while looks like a step from some contact on, plus a slope. A cut has no
//! slope. So beside each supposed cut the sums for a slope from the same start are kept, and both are fitted
//! together.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::candidate::{Candidates, Evidence, Felt};
use super::hypothesis::CUTS;
use crate::estimation::Innovation;
use crate::estimation::filter::{LENGTH, STATES};

/// Step and slope are told apart where the determinant of their sums is more than this part of what it could be: below
/// it is the rounding of the sums.
const LEAST_DETERMINANT: f64 = 1e-5;

/// The sums for slopes, by supposed cut: with g the signature of the step, r that of the slope and w the standardised
/// innovation, of r^2, r w and g r. All 0 where the cut has given up its start.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Continuations {
    lacking: [[f32; CUTS]; STATES],
    rr: [f32; CUTS],
    rw: [f32; CUTS],
    gr: [f32; CUTS],
}

impl Continuations {
    /// Takes a contact in that the candidates have felt.
    pub fn update(&mut self, seen: &Innovation, candidates: &Candidates, felt: &Felt) {
        let sd = seen.variance.sqrt();
        let standardised = seen.standardised as f32;
        let mut slope = [0.0; CUTS];
        for (one, row) in self.lacking.iter().zip(seen.row) {
            let row = (row / sd) as f32;
            for (slope, lacks) in slope.iter_mut().zip(one) {
                *slope += row * lacks;
            }
        }
        for (one, gain) in self.lacking.iter_mut().zip(seen.gain) {
            let gain = (gain * sd) as f32;
            for (lacks, slope) in one.iter_mut().zip(slope) {
                *lacks -= gain * slope;
            }
        }
        for index in 0..CUTS {
            let goes_on = candidates.contacts(index) > 0;
            let kept = |one: f32| if goes_on { one } else { 0.0 };
            let weighed = felt.sound[index] * slope[index];
            // The step itself is there from the first contact on; the slope adds its first share after it.
            self.lacking[LENGTH][index] += 1.0;
            for one in &mut self.lacking {
                one[index] = kept(one[index]);
            }
            self.rr[index] = kept(self.rr[index] + weighed * slope[index]);
            self.rw[index] = kept(self.rw[index] + weighed * standardised);
            self.gr[index] = kept(self.gr[index] + weighed * felt.signature[index]);
        }
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

    /// Writes what belongs to the cuts that have begun.
    pub fn write<W: Write>(&self, candidates: &Candidates, writer: &mut W) -> Result<()> {
        for index in (0..CUTS).filter(|&index| candidates.contacts(index) > 0) {
            (self.rr[index], self.rw[index], self.gr[index]).serialize(writer)?;
            self.lacking.iter().try_for_each(|one| one[index].serialize(writer))?;
        }
        Ok(())
    }

    /// Reads that again.
    pub fn read<R: Read>(candidates: &Candidates, reader: &mut R) -> Result<Self> {
        let mut read = Self::default();
        for index in (0..CUTS).filter(|&index| candidates.contacts(index) > 0) {
            (read.rr[index], read.rw[index], read.gr[index]) = BorshDeserialize::deserialize_reader(reader)?;
            for one in &mut read.lacking {
                one[index] = f32::deserialize_reader(reader)?;
            }
        }
        Ok(read)
    }
}
