//! Compensations in force. `decision` begins and ends them, over a whole array.

mod candidates;
mod decision;
pub(in crate::robot) mod error_measurement;
mod following;
pub(in crate::robot) mod prediction;
pub(in crate::robot) mod refinement;
pub(in crate::robot) mod responses;

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::ResponseBins;
use crate::mechanics::CONTACT_RATIOS;
use crate::policy::Case;
use crate::robot::Robot;
use crate::robot::compensation::refinement::Refining;
use crate::robot::effect::WhiskerIndex;
use crate::robot::state::whisker::Whisker;
use crate::units::{Megapascal, Millimetre};

/// A compensation in force.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Compensation {
    pub(in crate::robot) id: u32,
    pub(in crate::robot) target: u32,
    pub(in crate::robot) compensator: u32,
    pub(in crate::robot) case: Case,
    pub(in crate::robot) predicted_error: f64,
    /// The compensator as it was decided on.
    pub(in crate::robot) length: Millimetre,
    pub(in crate::robot) pressure_before: Megapascal,
    pub(in crate::robot) pressure: Megapascal,
    /// The compensator's own response before, for a neighbour against the model at whole length, for a whisker that has lost
    /// sensitivity at `length`; its model serves for the trimmed one itself.
    pub(in crate::robot) before: Option<ResponseBins>,
    /// Its response at the setpoint, against the model at `length`.
    pub(in crate::robot) after: ResponseBins,
    /// The setpoint was applied.
    pub(in crate::robot) settled: bool,
    /// Standard deviation of `length` as it was decided on, mm.
    pub(in crate::robot) length_sd_mm: f64,
    pub(in crate::robot) refining: Refining,
    /// It waits for an operator's approval: it holds its place in the assignment, and nothing was sent for it.
    pub(in crate::robot) proposed: bool,
}

impl Compensation {
    /// Length of the model that `before` is against.
    pub(in crate::robot) fn length_before(&self, compensator: &Whisker) -> Millimetre {
        if self.target == self.compensator { self.length } else { compensator.sheet.length }
    }

    /// Pressure of the model that a contact is compared with. One gain serves the pressure that the regulator really holds, and
    /// a coarse sensor hides that: with the setpoint as the reference, the means contain the difference. Whatever has no such
    /// gain, or drifts with a fault, is compared at the pressure of each contact.
    pub(in crate::robot) fn compared_at(&self, contact: Megapascal) -> Megapascal {
        if self.averages_alone() { self.pressure } else { contact }
    }

    /// Whether averages tell the level of its response, and not the length filter, which takes the pressure of each contact for
    /// the true one.
    pub(in crate::robot) fn averages_alone(&self) -> bool {
        self.reading_gain().is_some() && !self.refining.keeps_pressure()
    }

    /// Number on this robot.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.id
    }

    /// The broken whisker.
    #[must_use]
    pub fn target(&self) -> WhiskerIndex {
        self.target as usize
    }

    /// The whisker that serves as compensator.
    #[must_use]
    pub fn compensator(&self) -> WhiskerIndex {
        self.compensator as usize
    }

    /// Case of the paper.
    #[must_use]
    pub fn case(&self) -> Case {
        self.case
    }

    /// Pressure that the compensator shall hold.
    #[must_use]
    pub fn pressure(&self) -> Megapascal {
        self.pressure
    }

    /// Mean error (Eq. 35) that was predicted when it was decided, as a ratio.
    #[must_use]
    pub fn predicted_error(&self) -> f64 {
        self.predicted_error
    }

    /// Factors on the compensator's strain at [`CONTACT_RATIOS`], as published last.
    #[must_use]
    pub fn gain(&self) -> &[f64; CONTACT_RATIOS.len()] {
        &self.refining.gain
    }

    /// Factor on each of the compensator's readings, as published last; `None` if the gain depends on the contact ratio,
    /// because air corrects the level, too ([`Tip`](crate::mechanics::Objective::Tip) and
    /// [`Mean`](crate::mechanics::Objective::Mean)).
    #[must_use]
    pub fn reading_gain(&self) -> Option<f64> {
        one_number(&self.refining.gain)
    }

    /// Whether the robot has applied the setpoint with this pressure and gain.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// Whether it waits for an operator's approval: no setpoint was sent for it.
    #[must_use]
    pub fn is_proposed(&self) -> bool {
        self.proposed
    }
}

/// The value of a gain that is the same at all contact ratios. Only [`Shape`](crate::mechanics::Objective::Shape) gives
/// such gains.
#[must_use]
pub fn one_number(gain: &[f64; CONTACT_RATIOS.len()]) -> Option<f64> {
    gain.iter().all(|one| *one == gain[0]).then_some(gain[0])
}

impl Robot {
    fn serving(&self, target: WhiskerIndex) -> impl Iterator<Item = &Compensation> {
        self.head.compensations.iter().filter(move |one| one.target() == target)
    }

    /// Number and compensator of the compensation that serves it.
    fn server(&self, target: WhiskerIndex) -> Option<(u32, WhiskerIndex)> {
        self.serving(target).next().map(|one| (one.id, one.compensator()))
    }
}
