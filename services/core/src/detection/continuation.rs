//! Whether a supposed cut goes on: the slope beside the step, from the same start.
//!
//! Erosion that has gone on for a while looks like a step from some contact on, plus a slope. A cut has no
//! slope. So beside each supposed cut the sums for a slope from the same start are kept, and both are fitted
//! together.

use borsh::{BorshDeserialize, BorshSerialize};

use super::candidate::{Evidence, Felt};
use crate::estimation::Innovation;
use crate::estimation::filter::{LENGTH, STATES};

/// The sums for a slope: with g the signature of the step, r that of the slope and w the standardised innovation,
/// of r^2, r w and g r.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Continuation {
    lacking: [f64; STATES],
    rr: f64,
    rw: f64,
    gr: f64,
}

impl Continuation {
    /// Takes a contact in that the step's candidate has felt; none if that has given up its start.
    pub fn update(&mut self, seen: &Innovation, felt: Option<Felt>) {
        let Some(felt) = felt else {
            *self = Self::default();
            return;
        };
        let unlearned: f64 = (0..STATES).map(|state| seen.row[state] * self.lacking[state]).sum();
        let slope = unlearned / seen.variance.sqrt();
        for (lacks, gain) in self.lacking.iter_mut().zip(seen.gain) {
            *lacks -= gain * unlearned;
        }
        // The step itself is there from the first contact on; the slope adds its first share after it.
        self.lacking[LENGTH] += 1.0;
        self.rr += felt.sound * slope * slope;
        self.rw += felt.sound * slope * seen.standardised;
        self.gr += felt.sound * slope * felt.signature;
    }

    /// Log likelihood that a further loss of length gains beside the step; 0 where the length does not fall further.
    #[must_use]
    pub fn gain_of_going_on(&self, step: &Evidence) -> f64 {
        let (gg, gw) = step.sums();
        let determinant = gg * self.rr - self.gr * self.gr;
        if determinant <= 1e-9 * gg * self.rr {
            return 0.0;
        }
        let slope = (gg * self.rw - self.gr * gw) / determinant;
        if slope >= 0.0 { 0.0 } else { 0.5 * slope * slope * determinant / gg }
    }
}
