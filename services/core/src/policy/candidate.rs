//! One candidate: can this whisker compensate for the target, at which pressure, and with what error?

use std::ops::RangeInclusive;

use borsh::{BorshDeserialize, BorshSerialize};

use super::params::{LongerForShorter, PolicyParams};
use crate::estimation::{Belief, Weights};
use crate::mechanics::{
    CONTACT_RATIOS, Compensator, Deviation, Family, LOG_MODULUS, LogChanges, Model, Objective, Offset, Setpoint,
    Solution, Target, UsualContacts, solve_setpoint_as_felt,
};
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Factors on readings that a robot takes: a weaker whisker tells hardly anything but noise.
pub const READING_GAINS: RangeInclusive<f64> = 0.05..=20.0;

/// The paper's cases of compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, BorshSerialize, BorshDeserialize)]
pub enum Case {
    /// Case 1, special: the trimmed whisker compensates for itself at a lower pressure.
    SelfCompensation,
    /// Case 1: a shorter neighbour compensates for a longer whisker.
    ShorterForLonger,
    /// Case 2: a longer neighbour compensates for a shorter whisker.
    LongerForShorter,
}

/// Why a whisker cannot be a candidate at all, whatever the mechanics say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Ineligible {
    /// Its offset and noise have not been learned yet.
    Learning,
    /// A change is suspected.
    Suspected,
    /// It is trimmed.
    Trimmed,
    /// It is eroding.
    Eroding,
    /// It has lost sensitivity.
    SensitivityLoss,
    /// It has sent nothing for too long, or its robot is offline.
    Stale,
    /// Its gauge is faulty.
    GaugeFault,
    /// Its chamber leaks or its regulator is faulty.
    Leaking,
    /// Its last setpoint failed permanently.
    SetpointFailed,
    /// An operator holds it.
    Held,
}

/// Why a candidate was not chosen.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub enum Refused {
    /// The whisker was not eligible.
    Ineligible(Ineligible),
    /// The policy forbids a longer whisker for a shorter one.
    CaseNotAllowed,
    /// Eq. 34 has no root: even zero pressure is too high.
    NeedsBelowRange,
    /// Eq. 34 has no root: the highest pressure is too low.
    NeedsAboveRange,
    /// The predicted error exceeds the limit.
    ErrorAboveLimit,
    /// The cut reaches the chamber, where the model is invalid. With a gain: so little is left that contacts at some of
    /// [`CONTACT_RATIOS`] would lie on the chamber.
    CutIntoChamber,
    /// Another candidate costs less, or this one serves better elsewhere in the array.
    CostsMore,
    /// An operator has rejected it for this target.
    Operator,
    /// The factor on the readings is not within [`READING_GAINS`].
    GainOutOfRange,
}

/// An eligible candidate as the policy sees it.
#[derive(Debug, Clone, Copy)]
pub struct Fitness<'a> {
    /// Model of the whisker.
    pub model: &'a Model,
    /// Present length by the estimate.
    pub length: Millimetre,
    /// Present pressure of the whisker.
    pub pressure: Megapascal,
    /// Lowest and highest pressure that the robot can hold.
    pub pressures: (Megapascal, Megapascal),
    /// Offset from the model at the present pressure.
    pub offset: Offset,
    /// The whisker's own calibration: change of its offset with pressure. All zero if none is known.
    pub own: Weights,
    /// The policy's objective for its robot.
    pub objective: Objective,
    /// The robot's usual contacts.
    pub usual: UsualContacts,
}

/// Result for one candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal {
    /// The paper's case that applies.
    pub case: Case,
    /// The setpoint with its predicted error, clamped to the range where Eq. 34 has no root. `None` where the model
    /// is invalid.
    pub setpoint: Option<Setpoint>,
    /// Reason for the refusal, if it is refused.
    pub refused: Option<Refused>,
}

/// Solves for the setpoint of `compensator` that serves `target`.
///
/// `is_self`: the trimmed whisker itself, which may only lower its pressure.
#[must_use]
pub fn propose(
    params: &PolicyParams,
    target_model: &Model,
    target: Target,
    target_offset: Offset,
    compensator: &Fitness<'_>,
    is_self: bool,
) -> Proposal {
    let case = if is_self {
        Case::SelfCompensation
    } else if compensator.length.mm() <= target.length.mm() {
        Case::ShorterForLonger
    } else {
        Case::LongerForShorter
    };
    let (pressure_min, highest) = compensator.pressures;
    let limit = highest.mpa().min(Megapascal::EXAMINED_MAX.mpa());
    let highest = if is_self { limit.min(compensator.pressure.mpa()) } else { limit };
    let asked = Compensator {
        length: compensator.length,
        pressure: compensator.pressure,
        pressure_min,
        pressure_max: Megapascal::known(highest),
    };
    let at_target = straight(target_offset);
    let solved = solve_setpoint_as_felt(
        (target_model, target, &|_: Megapascal| at_target),
        (compensator.model, asked, &AsFelt::new(compensator)),
        compensator.objective,
        &compensator.usual,
    );
    match solved {
        Err(_) => Proposal { case, setpoint: None, refused: Some(Refused::CutIntoChamber) },
        Ok(solution) => {
            let setpoint = *solution.setpoint();
            // Where its chamber is, no gain gives a reading.
            let (model, length) = (compensator.model, compensator.length);
            let lacks_places = compensator.objective == Objective::Shape
                && model.log_sensitivities(length, setpoint.pressure).contains(&None);
            let refused = refusal(params, case, compensator.objective, &solution)
                .or(lacks_places.then_some(Refused::CutIntoChamber));
            Proposal { case, setpoint: Some(setpoint), refused }
        }
    }
}

/// The compensator's offset, changed from the present pressure by its own calibration.
struct AsFelt<'a> {
    one: &'a Fitness<'a>,
    offset: [f64; CONTACT_RATIOS.len()],
    /// `None` if no calibration of its own is known.
    own: Option<(Family, LogChanges)>,
}

impl<'a> AsFelt<'a> {
    fn new(one: &'a Fitness<'a>) -> Self {
        let own = (one.own != Weights::default()).then(|| {
            let family = one.model.family(one.own[LOG_MODULUS]);
            let from = family.log_changes(one.model, one.length, one.pressure);
            (family, from)
        });
        Self { one, offset: straight(one.offset), own }
    }
}

impl Deviation for AsFelt<'_> {
    fn at(&self, pressure: Megapascal) -> [f64; CONTACT_RATIOS.len()] {
        let Some((family, from)) = &self.own else { return self.offset };
        let to = family.log_changes(self.one.model, self.one.length, pressure);
        let change = Belief::change(&self.one.own, from, &to);
        std::array::from_fn(|k| self.offset[k] + change[k])
    }

    fn at_tip(&self, pressure: Megapascal) -> f64 {
        let [.., offset] = self.offset;
        let Some((family, [.., from])) = &self.own else { return offset };
        let to = family.log_changes_at_tip(self.one.model, self.one.length, pressure);
        offset + Belief::change_at(&self.one.own, from, &to)
    }
}

fn straight(offset: Offset) -> [f64; CONTACT_RATIOS.len()] {
    CONTACT_RATIOS.map(|a| offset.at(ContactRatio::known(a)))
}

fn refusal(params: &PolicyParams, case: Case, objective: Objective, solution: &Solution) -> Option<Refused> {
    match solution {
        _ if case == Case::LongerForShorter && params.longer_for_shorter == LongerForShorter::Never => {
            Some(Refused::CaseNotAllowed)
        }
        Solution::NeedsBelow(_) if objective != Objective::Shape => Some(Refused::NeedsBelowRange),
        Solution::NeedsAbove(_) if objective != Objective::Shape => Some(Refused::NeedsAboveRange),
        _ if !READING_GAINS.contains(&solution.setpoint().reading_gain) => Some(Refused::GainOutOfRange),
        // A gain makes up for air out of range, as far as the predicted error says.
        Solution::InRange(setpoint) | Solution::NeedsBelow(setpoint) | Solution::NeedsAbove(setpoint) => {
            (setpoint.error.mean > params.predicted_error_max).then_some(Refused::ErrorAboveLimit)
        }
    }
}

impl Proposal {
    /// The predicted mean error, if the candidate is acceptable.
    #[must_use]
    pub fn predicted_error(&self) -> Option<f64> {
        self.setpoint.filter(|_| self.refused.is_none()).map(|setpoint| setpoint.error.mean)
    }
}

impl PolicyParams {
    /// Cost of a compensator in an assignment: its predicted error, plus the loss of its own role, plus the margin
    /// for a change.
    #[must_use]
    pub fn cost(&self, case: Case, predicted_error: f64, in_force: bool) -> f64 {
        let role = match (case, self.longer_for_shorter) {
            (Case::SelfCompensation, _) => 0.0,
            (Case::ShorterForLonger, _) | (Case::LongerForShorter, LongerForShorter::Allowed) => self.own_role_cost,
            // Any candidate of case 1, however bad, comes first.
            (Case::LongerForShorter, LongerForShorter::LastResort | LongerForShorter::Never) => {
                self.own_role_cost + 10.0
            }
        };
        let change = if in_force { 0.0 } else { self.change_margin };
        predicted_error + role + change
    }
}
