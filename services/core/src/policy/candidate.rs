//! One candidate: can this whisker compensate for that one, at which pressure, with what error?

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::{Belief, Weights};
use crate::mechanics::{
    CONTACT_RATIOS, Compensator, Deviation, Family, LogChanges, Model, Objective, Offset, Setpoint, Solution, Target,
    solve_setpoint_as_felt,
};
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// The paper's cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, BorshSerialize, BorshDeserialize)]
pub enum Case {
    /// Case 1, special: the trimmed whisker compensates for itself by a lower pressure.
    SelfCompensation,
    /// Case 1: a shorter neighbour compensates for a longer whisker.
    ShorterForLonger,
    /// Case 2: a longer neighbour compensates for a shorter whisker.
    LongerForShorter,
}

/// Whether case 2 is used: the paper measured 36.2 % for it against 20.4 % for case 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LongerForShorter {
    /// Never.
    Never,
    /// Only for a whisker that case 1 cannot serve.
    #[default]
    LastResort,
    /// Like case 1, by predicted error alone.
    Allowed,
}

/// Who says that a compensation begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// The decision: it begins at once.
    #[default]
    Automatic,
    /// An operator: a decision proposes, and nothing is sent before it is approved. What was approved is refined
    /// without asking again, and is not given up for a better assignment: only what breaks it ends it.
    Advise,
}

/// The policy's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolicyParams {
    /// Who says that a compensation begins. What was proposed stays proposed when this becomes automatic.
    pub mode: Mode,
    /// What the setpoint is solved for.
    pub objective: Objective,
    /// When a longer whisker may stand in for a shorter one.
    pub longer_for_shorter: LongerForShorter,
    /// Highest mean predicted error (Eq. 35) that a candidate may have, as a ratio.
    pub predicted_error_max: f64,
    /// What it costs that a neighbour gives up its own role, in units of mean error: the whisker itself is
    /// preferred unless a neighbour is better by more than this.
    pub own_role_cost: f64,
    /// An assignment in force is changed only for a gain above this, in units of mean error.
    pub change_margin: f64,
}

impl Default for PolicyParams {
    fn default() -> Self {
        Self {
            mode: Mode::Automatic,
            objective: Objective::Tip,
            longer_for_shorter: LongerForShorter::LastResort,
            predicted_error_max: 0.5,
            own_role_cost: 0.25,
            change_margin: 0.1,
        }
    }
}

/// Why a whisker cannot be asked at all, whatever the mechanics say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Ineligible {
    /// Its offset and noise are not learned yet.
    Learning,
    /// A change is suspected.
    Suspected,
    /// It is trimmed itself.
    Trimmed,
    /// It erodes.
    Eroding,
    /// It has lost sensitivity.
    SensitivityLoss,
    /// Nothing was heard of it for too long, or its robot is offline.
    Stale,
    /// Its gauge is faulty.
    GaugeFault,
    /// Its chamber leaks or its regulator fails.
    Leaking,
    /// Its last setpoint failed for good.
    SetpointFailed,
    /// An operator holds it.
    Held,
}

/// Why a candidate was not chosen.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub enum Refused {
    /// It could not be asked.
    Ineligible(Ineligible),
    /// The policy forbids a longer whisker for a shorter one.
    CaseNotAllowed,
    /// Eq. 34 has no root: even no pressure is too much.
    NeedsBelowRange,
    /// Eq. 34 has no root: the highest pressure is too little.
    NeedsAboveRange,
    /// The predicted error is over the limit.
    ErrorAboveLimit,
    /// Cut into the chamber: the model is invalid.
    CutIntoChamber,
    /// Another candidate costs less, or this one serves better elsewhere in the array.
    CostsMore,
    /// An operator has refused it for this target.
    Operator,
}

/// A whisker as the policy sees it, fit to be asked.
#[derive(Debug, Clone, Copy)]
pub struct Fitness<'a> {
    /// Its model.
    pub model: &'a Model,
    /// Present length.
    pub length: Millimetre,
    /// Present pressure.
    pub pressure: Megapascal,
    /// The highest pressure that its factsheet allows.
    pub pressure_max: Megapascal,
    /// Its offset from the model at the present pressure.
    pub offset: Offset,
    /// Its own calibration: how its offset changes with the pressure. All zero: not at all.
    pub own: Weights,
}

/// What a candidate offers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal {
    /// Which of the paper's cases it is.
    pub case: Case,
    /// The setpoint with its predicted error; the clamped one where Eq. 34 has no root in range.
    /// None where the model does not hold.
    pub setpoint: Option<Setpoint>,
    /// Why it cannot be taken, if it cannot.
    pub refused: Option<Refused>,
}

/// Asks the mechanics what `compensator` can do for `target`.
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
    let limit = compensator.pressure_max.mpa().min(Megapascal::EXAMINED_MAX.mpa());
    let highest = if is_self { limit.min(compensator.pressure.mpa()) } else { limit };
    let asked = Compensator {
        length: compensator.length,
        pressure: compensator.pressure,
        pressure_min: Megapascal::ZERO,
        pressure_max: Megapascal::known(highest),
    };
    let at_target = straight(target_offset);
    let solved = solve_setpoint_as_felt(
        (target_model, target, &|_: Megapascal| at_target),
        (compensator.model, asked, &AsFelt::new(compensator)),
        params.objective,
    );
    match solved {
        Err(_) => Proposal { case, setpoint: None, refused: Some(Refused::CutIntoChamber) },
        Ok(solution) => {
            let setpoint = *solution.setpoint();
            Proposal { case, setpoint: Some(setpoint), refused: refusal(params, case, &solution) }
        }
    }
}

/// The compensator's offset, with its change from the present pressure by its own calibration.
struct AsFelt<'a> {
    one: &'a Fitness<'a>,
    offset: [f64; CONTACT_RATIOS.len()],
    /// None where it is not known to have a calibration of its own.
    own: Option<(Family, LogChanges)>,
}

impl<'a> AsFelt<'a> {
    fn new(one: &'a Fitness<'a>) -> Self {
        let own = (one.own != Weights::default()).then(|| {
            let family = one.model.family();
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

fn refusal(params: &PolicyParams, case: Case, solution: &Solution) -> Option<Refused> {
    match solution {
        _ if case == Case::LongerForShorter && params.longer_for_shorter == LongerForShorter::Never => {
            Some(Refused::CaseNotAllowed)
        }
        Solution::NeedsBelow(_) => Some(Refused::NeedsBelowRange),
        Solution::NeedsAbove(_) => Some(Refused::NeedsAboveRange),
        Solution::InRange(setpoint) => {
            (setpoint.error.mean > params.predicted_error_max).then_some(Refused::ErrorAboveLimit)
        }
    }
}

impl Proposal {
    /// The predicted mean error, if it can be taken.
    #[must_use]
    pub fn predicted_error(&self) -> Option<f64> {
        self.setpoint.filter(|_| self.refused.is_none()).map(|setpoint| setpoint.error.mean)
    }
}

impl PolicyParams {
    /// What choosing a compensator costs in an assignment: its predicted error, that it gives up its own
    /// role, and that something changes.
    #[must_use]
    pub fn cost(&self, case: Case, predicted_error: f64, in_force: bool) -> f64 {
        let role = match (case, self.longer_for_shorter) {
            (Case::SelfCompensation, _) => 0.0,
            (Case::ShorterForLonger, _) | (Case::LongerForShorter, LongerForShorter::Allowed) => self.own_role_cost,
            // Any case 1, however bad, comes first.
            (Case::LongerForShorter, LongerForShorter::LastResort | LongerForShorter::Never) => {
                self.own_role_cost + 10.0
            }
        };
        let change = if in_force { 0.0 } else { self.change_margin };
        predicted_error + role + change
    }
}
