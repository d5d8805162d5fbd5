//! Compensations: decided over a whole array, begun, ended.

pub(in crate::robot) mod error_measurement;
mod following;
pub(in crate::robot) mod prediction;
pub mod refinement;
pub(in crate::robot) mod responses;

use std::collections::BTreeMap;

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::{Belief, ResponseBins};
use crate::mechanics::{CONTACT_RATIOS, Model, Objective};
use crate::policy::{Case, Fitness, Ineligible, Mode, Offer, Proposal, Refused, assign, propose};
use crate::robot::Robot;
use crate::robot::compensation::prediction::cases_for_each;
use crate::robot::compensation::refinement::Refining;
use crate::robot::effect::{CandidateRecord, Condition, Decision, Effect, EndReason, Fault, Reason, WhiskerIndex};
use crate::robot::event::{AirControl, ArrayKind, Task};
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::{Megapascal, Millimetre};

/// A whisker covers the reach of one that was longer by no more than this, mm.
const REACH_TOLERANCE_MM: f64 = 1.0;

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
    /// because air corrects the level, too ([`Objective::Tip`] and [`Objective::Mean`]).
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

/// The value of a gain that is the same at all contact ratios. Only [`Objective::Shape`] gives such gains.
#[must_use]
pub fn one_number(gain: &[f64; CONTACT_RATIOS.len()]) -> Option<f64> {
    gain.iter().all(|one| *one == gain[0]).then_some(gain[0])
}

/// One candidate for a target, and its proposal.
struct CandidateProposal<'p> {
    target: WhiskerIndex,
    compensator: WhiskerIndex,
    /// Case and predicted error of this compensation if it is in force: the candidate's pressure has changed since
    /// then.
    standing: Option<(Case, f64)>,
    /// Its properties and the belief about its own calibration, as the policy saw them; none if it is ineligible.
    fit: Option<(Fitness<'p>, Belief)>,
    proposal: Result<Proposal, Ineligible>,
    /// It serves in a compensation that decisions must not change.
    reserved: bool,
}

impl CandidateProposal<'_> {
    fn cost(&self, params: &Params) -> Option<f64> {
        if self.reserved {
            return None;
        }
        match (self.standing, self.proposal) {
            (Some((case, error)), _) => Some(params.policy.cost(case, error, true)),
            (None, Ok(proposal)) => Some(params.policy.cost(proposal.case, proposal.predicted_error()?, false)),
            (None, Err(_)) => None,
        }
    }
}

impl Robot {
    /// The parameters have changed.
    pub(in crate::robot) fn policy_changed(&mut self) {
        for index in 0..self.whiskers.len() {
            if !self.whiskers[index].refused_servers.is_empty() {
                self.whiskers[index].refused_servers.clear();
            }
        }
        // Limits of health may be others, too.
        self.tick_deadline.end();
    }

    /// Decides anew about all arrays.
    pub(in crate::robot) fn decide(&mut self, params: &Params, effects: &mut Vec<Effect>) {
        self.end_broken(params, effects);
        for array in 0..self.head.arrays.len() {
            self.decide_array(params, array as u16, effects);
        }
    }

    /// Ends the compensations that cannot go on.
    fn end_broken(&mut self, params: &Params, effects: &mut Vec<Effect>) {
        let mut over = Vec::new();
        for one in &self.head.compensations {
            let (target, compensator) = (&self.whiskers[one.target()], &self.whiskers[one.compensator()]);
            // A held target is not decided on: what serves it is better than nothing until it is.
            if target.undecided && !self.holds(one.target()) {
                over.push((one.id, EndReason::TargetTrimmedAgain));
            } else if compensator.is_unfit_to_go_on(params, one) {
                over.push((one.id, EndReason::CompensatorBroken));
            } else if self.may_have_air_again(one) && !self.is_fixed(params, one) {
                over.push((one.id, EndReason::Reassigned));
            }
        }
        for (id, reason) in over {
            self.end(id, reason, effects);
        }
    }

    /// Ends a compensation; its compensator returns to its nominal pressure unless it is wanted otherwise.
    pub(in crate::robot) fn end(&mut self, id: u32, reason: EndReason, effects: &mut Vec<Effect>) {
        let Some(at) = self.head.compensations.iter().position(|one| one.id == id) else { return };
        let ended = self.head.compensations.remove(at);
        self.whiskers[ended.target()].undecided = true;
        effects.push(Effect::Ended {
            compensation: id,
            target: ended.target(),
            case: ended.case,
            reason,
            was_proposed: ended.proposed,
        });
        // Nothing was sent for a proposed one.
        if reason != EndReason::SetpointFailed && !ended.proposed {
            self.release(ended.compensator());
        }
    }

    fn decide_array(&mut self, params: &Params, array: u16, effects: &mut Vec<Effect>) {
        let targets: Vec<usize> = (0..self.whiskers.len())
            .filter(|&index| self.whiskers[index].array == array && self.is_target(params, index))
            .filter(|&index| !self.holds(index) && !self.serving(index).any(|one| self.is_fixed(params, one)))
            .collect();
        if targets.is_empty() {
            return;
        }
        if self.head.arrays[usize::from(array)].task == Task::Distance {
            return self.cover_reach(&targets);
        }
        let asked: Vec<CandidateProposal<'_>> = targets.iter().flat_map(|&target| self.ask(params, target)).collect();
        let chosen = choose(params, &targets, &asked);
        let chosen_for = |target: usize| chosen.get(&target).copied();
        let news: Vec<usize> = targets.into_iter().filter(|&target| self.is_news(target, chosen_for(target))).collect();
        // Everything that ends, before anything begins: what one whisker lets go of, another may take.
        for &target in &news {
            if let Some((id, _)) = self.server(target) {
                self.end(id, EndReason::Reassigned, effects);
            }
        }
        for target in news {
            self.follow(params, target, chosen_for(target), &asked, effects);
        }
    }

    /// A cut whisker of an array that reads distances reads as before within its reach, so no pressure is changed. Its
    /// lost reach is covered if a sound neighbour is as long as it was.
    fn cover_reach(&mut self, targets: &[WhiskerIndex]) {
        for &target in targets {
            let whisker = &self.whiskers[target];
            let whole_mm = whisker.sheet.length.mm();
            let neighbours = whisker.sheet.neighbours.iter().filter_map(|&number| self.place(whisker.array, number));
            let is_covered = neighbours.map(|index| &self.whiskers[index]).any(|one| {
                one.ineligible(false, false, false).is_none()
                    && one.filter.length().length.mm() >= whole_mm - REACH_TOLERANCE_MM
            });
            let whisker = &mut self.whiskers[target];
            (whisker.undecided, whisker.unserved) = (false, !is_covered);
        }
    }

    /// Whether it needs a compensator: it is trimmed, or a gain can make up for its loss of sensitivity, or it is served and
    /// has become something else since. A served one keeps its compensator.
    fn is_target(&self, params: &Params, index: WhiskerIndex) -> bool {
        let one = &self.whiskers[index];
        one.condition == Condition::Trimmed
            || one.undecided
            || self.is_served_by_gain(params, index)
            || self.server(index).is_some()
    }

    /// Whether it has lost sensitivity, and its robot multiplies its readings: then a gain alone serves it. An array that reads
    /// distances gets no setpoints.
    fn is_served_by_gain(&self, params: &Params, index: WhiskerIndex) -> bool {
        let one = &self.whiskers[index];
        one.condition == Condition::SensitivityLoss
            && self.head.arrays[usize::from(one.array)].task != Task::Distance
            && params.policy.objective_for(self.head.applies_gain) == Objective::Shape
    }

    /// The only pressure at which a gain serves a whisker whose chamber leaks or whose regulator is broken. None if it has
    /// neither fault, or if its robot does not multiply its readings.
    ///
    /// - A leaking chamber that holds its setpoint, because it is filled again and again: that setpoint.
    /// - One that does not: the pressure of the room, which is sure. The measured one if the robot cannot vent.
    /// - A broken regulator: the measured pressure, at which the robot can report APPLIED without any air.
    pub(in crate::robot) fn pressure_it_has(&self, params: &Params, index: WhiskerIndex) -> Option<Megapascal> {
        let one = &self.whiskers[index];
        let pressure = match one.fault {
            Some(Fault::Leak) if one.holds_setpoint(params) => Some(one.air.setpoint),
            Some(Fault::Leak) if self.head.air_control != AirControl::None => Some(Megapascal::ZERO),
            Some(Fault::Leak | Fault::Regulator) => one.air.measured(),
            Some(Fault::Stale | Fault::Gauge(_) | Fault::SupplyLow) | None => None,
        };
        pressure.filter(|_| params.policy.objective_for(self.head.applies_gain) == Objective::Shape)
    }

    /// Whether a gain alone serves, and the fault that was the reason is gone. An empty chamber shows no leak, so an operator
    /// decides about it.
    fn may_have_air_again(&self, one: &Compensation) -> bool {
        one.refining.keeps_pressure()
            && one.pressure > Megapascal::ZERO
            && self.whiskers[one.compensator()].fault.is_none()
            && self.head.air_control != AirControl::None
            && !self.holds(one.compensator())
    }

    /// Whether decisions leave it as it is: its target is held, or it runs where compensations must be approved, and is
    /// not given up for one that nobody has approved.
    fn is_fixed(&self, params: &Params, one: &Compensation) -> bool {
        self.holds(one.target()) || (params.policy.mode == Mode::Advise && !one.proposed)
    }

    fn serving(&self, target: WhiskerIndex) -> impl Iterator<Item = &Compensation> {
        self.head.compensations.iter().filter(move |one| one.target() == target)
    }

    /// Number and compensator of the compensation that serves it.
    fn server(&self, target: WhiskerIndex) -> Option<(u32, WhiskerIndex)> {
        self.serving(target).next().map(|one| (one.id, one.compensator()))
    }

    /// Whether the choice differs from the present state: another compensator, or none any more.
    fn is_news(&self, target: WhiskerIndex, chosen: Option<WhiskerIndex>) -> bool {
        self.whiskers[target].undecided || self.server(target).map(|(_, compensator)| compensator) != chosen
    }

    /// Evaluates all candidates for a broken whisker: itself and, in a Type 1 array, its neighbours.
    fn ask<'p>(&self, params: &'p Params, target: WhiskerIndex) -> Vec<CandidateProposal<'p>> {
        let whisker = &self.whiskers[target];
        let is_cut = self.server(target).is_some() || !self.is_served_by_gain(params, target);
        let neighbours: &[u16] = match self.head.arrays[usize::from(whisker.array)].kind {
            ArrayKind::Type1 if is_cut => &whisker.sheet.neighbours,
            ArrayKind::Type1 | ArrayKind::Type2 => &[],
        };
        let candidates =
            std::iter::once(target).chain(neighbours.iter().filter_map(|&number| self.place(whisker.array, number)));
        candidates.map(|compensator| self.ask_one(params, target, compensator)).collect()
    }

    fn ask_one<'p>(
        &self,
        params: &'p Params,
        target: WhiskerIndex,
        compensator: WhiskerIndex,
    ) -> CandidateProposal<'p> {
        let (broken, one) = (&self.whiskers[target], &self.whiskers[compensator]);
        let running = self.head.compensations.iter();
        let standing = running
            .filter(|running| running.target() == target && running.compensator() == compensator)
            .map(|running| (running.case, running.predicted_error))
            .next();
        let held = self.holds(compensator).then_some(Ineligible::Held);
        let is_self = target == compensator;
        let by_gain = is_self && self.is_served_by_gain(params, compensator);
        let objective = params.policy.objective_for(self.head.applies_gain);
        let faulty_at = self.pressure_it_has(params, compensator);
        let only = faulty_at.or(by_gain.then_some(one.sheet.pressure));
        let reason = one.ineligible(is_self, by_gain, faulty_at.is_some()).or(held);
        let (fit, proposal) = match (reason, broken.model(params), one.model(params)) {
            (None, Some(target_model), Some(model)) => {
                let belief = one.belief(model);
                let pressures = only.map_or_else(|| one.pressures(self.head.air_control), |only| (only, only));
                let fitness = one.fitness(model, &belief, is_self, (objective, pressures));
                let asked = (broken.target(), broken.whole_offset());
                let proposal = propose(&params.policy, target_model, asked.0, asked.1, &fitness, is_self);
                let by_operator = broken.refused_servers.contains(&one.sheet.number).then_some(Refused::Operator);
                let refused = proposal.refused.or(by_operator);
                (Some((fitness, belief)), Ok(Proposal { refused, ..proposal }))
            }
            (reason, _, _) => (None, Err(reason.unwrap_or(Ineligible::Learning))),
        };
        let mut running = self.head.compensations.iter();
        let reserved = running.any(|one| one.compensator() == compensator && self.is_fixed(params, one));
        CandidateProposal { target, compensator, standing, fit, proposal, reserved }
    }

    /// Carries out the choice for one target that has no compensator.
    fn follow(
        &mut self,
        params: &Params,
        target: WhiskerIndex,
        chosen: Option<WhiskerIndex>,
        asked: &[CandidateProposal<'_>],
        effects: &mut Vec<Effect>,
    ) {
        self.whiskers[target].undecided = false;
        let compensation = self.head.next_compensation;
        self.head.next_compensation += 1;
        let cases = cases_for_each(asked.len());
        let of_target: Vec<&CandidateProposal<'_>> = asked.iter().filter(|one| one.target == target).collect();
        let candidates: Vec<CandidateRecord> =
            of_target.iter().map(|one| self.record(params, one, chosen, cases)).collect();
        let whole = self.whiskers[target].target();
        effects.push(Effect::Decided(Box::new(Decision {
            compensation,
            target,
            target_length: whole.length,
            target_pressure: whole.pressure,
            chosen: candidates.iter().position(|one| Some(one.whisker) == chosen),
            proposed: chosen.is_some() && params.policy.mode == Mode::Advise,
            candidates,
        })));
        match of_target.iter().find(|one| Some(one.compensator) == chosen) {
            Some(one) => self.begin(params, compensation, one),
            None => self.whiskers[target].unserved = true,
        }
    }

    fn record(
        &self,
        params: &Params,
        asked: &CandidateProposal<'_>,
        chosen: Option<WhiskerIndex>,
        cases: u32,
    ) -> CandidateRecord {
        let one = &self.whiskers[asked.compensator];
        let is_self = asked.target == asked.compensator;
        let proposal = asked.proposal.as_ref().ok();
        let setpoint = proposal.and_then(|proposal| proposal.setpoint);
        let lost = (Some(asked.compensator) != chosen).then_some(Refused::CostsMore);
        let target_length = self.whiskers[asked.target].sheet.length;
        let estimate = one.filter.length();
        let unasked_case = if is_self {
            Case::SelfCompensation
        } else if estimate.length <= target_length {
            Case::ShorterForLonger
        } else {
            Case::LongerForShorter
        };
        CandidateRecord {
            whisker: asked.compensator,
            case: proposal.map_or(unasked_case, |proposal| proposal.case),
            length: estimate,
            pressure_before: one.sheet.pressure,
            pressure: setpoint.map(|setpoint| setpoint.pressure),
            predicted_error_by_ratio: setpoint.map(|setpoint| setpoint.error.by_ratio),
            predicted_error: setpoint.map(|setpoint| setpoint.error.mean),
            predicted_error_interval: setpoint.as_ref().and_then(|setpoint| {
                let (fitness, belief) = asked.fit.as_ref()?;
                let pair = (asked.target, asked.compensator);
                self.predicted_interval(params, pair, (fitness, belief), setpoint, cases)
            }),
            gives_up_own_role: !is_self,
            refused: match asked.proposal {
                Err(reason) => Some(Refused::Ineligible(reason)),
                Ok(proposal) => proposal.refused.or(lost),
            },
        }
    }

    /// A compensation begins, or is proposed.
    fn begin(&mut self, params: &Params, id: u32, chosen: &CandidateProposal<'_>) {
        let Ok(Proposal { case, setpoint: Some(setpoint), .. }) = chosen.proposal else { return };
        let is_self = chosen.target == chosen.compensator;
        let one = &self.whiskers[chosen.compensator];
        let has_lost = one.condition == Condition::SensitivityLoss;
        let keeps_pressure = self.pressure_it_has(params, chosen.compensator).is_some();
        let mut carried = one.carried(params, &setpoint);
        if has_lost {
            carried.shift(one.whole_lag(one.filter.offset()));
        }
        let gain = setpoint.gain.by_ratio;
        let begun = Compensation {
            id,
            target: chosen.target as u32,
            compensator: chosen.compensator as u32,
            case,
            predicted_error: setpoint.error.mean,
            length: one.filter.length().length,
            pressure_before: one.sheet.pressure,
            pressure: setpoint.pressure,
            before: match (is_self, has_lost) {
                (true, false) => None,
                (true, true) => Some(one.whole_now()),
                (false, _) => Some(one.present_whole()),
            },
            after: ResponseBins::default(),
            settled: false,
            length_sd_mm: one.filter.length().sd_mm,
            refining: if keeps_pressure { Refining::of_gain(gain, carried) } else { Refining::new(gain, carried) },
            proposed: params.policy.mode == Mode::Advise,
        };
        self.whiskers[chosen.target].unserved = false;
        if !begun.proposed {
            self.desire(chosen.compensator, begun.desired(Reason::Compensation(case)));
        }
        self.head.compensations.push(begun);
    }
}

/// The assignment with the least total cost: for each served target its compensator.
fn choose(params: &Params, targets: &[usize], asked: &[CandidateProposal<'_>]) -> BTreeMap<usize, usize> {
    let able: Vec<(&CandidateProposal<'_>, f64)> =
        asked.iter().filter_map(|one| Some((one, one.cost(params)?))).collect();
    // Only those who can serve anybody: the others would be empty columns.
    let mut columns: Vec<usize> = able.iter().map(|(one, _)| one.compensator).collect();
    columns.sort_unstable();
    columns.dedup();
    let offers: Vec<Offer> = able
        .iter()
        .filter_map(|&(one, cost)| {
            let target = targets.binary_search(&one.target).ok()?;
            let compensator = columns.binary_search(&one.compensator).ok()?;
            Some(Offer { target, compensator, cost })
        })
        .collect();
    let assigned = assign(targets.len(), columns.len(), &offers);
    let served = targets.iter().zip(assigned);
    served.filter_map(|(&target, column)| Some((target, columns[column?]))).collect()
}

impl Whisker {
    /// Reason why it cannot be a candidate, if there is one. A trimmed whisker may still serve itself.
    fn ineligible(&self, for_itself: bool, by_gain: bool, serves_faulty: bool) -> Option<Ineligible> {
        match self.fault {
            Some(Fault::Stale) => return Some(Ineligible::Stale),
            Some(Fault::Gauge(_)) => return Some(Ineligible::GaugeFault),
            Some(Fault::Leak | Fault::Regulator) if serves_faulty => {}
            Some(Fault::Leak | Fault::Regulator | Fault::SupplyLow) => return Some(Ineligible::Leaking),
            None => {}
        }
        if self.given_up {
            return Some(Ineligible::SetpointFailed);
        }
        match self.condition {
            Condition::Healthy => None,
            // An eroding whisker is the only one whose pressure can follow its length.
            Condition::Trimmed | Condition::Eroding if for_itself => None,
            Condition::Trimmed => Some(Ineligible::Trimmed),
            Condition::Learning => Some(Ineligible::Learning),
            Condition::Suspected => Some(Ineligible::Suspected),
            Condition::Eroding => Some(Ineligible::Eroding),
            Condition::SensitivityLoss => (!by_gain).then_some(Ineligible::SensitivityLoss),
        }
    }

    /// Whether it can no longer serve. Silence alone ends nothing: the pressure is still in the chamber. A cut whisker
    /// that compensates for itself goes on when it erodes or loses sensitivity: it is still cut.
    fn is_unfit_to_go_on(&self, params: &Params, serving: &Compensation) -> bool {
        let broken = match self.condition {
            Condition::Trimmed | Condition::Eroding | Condition::SensitivityLoss => {
                serving.case != Case::SelfCompensation
            }
            Condition::Learning | Condition::Healthy | Condition::Suspected => false,
        };
        let faulty = match self.fault {
            Some(Fault::Gauge(_)) => true,
            Some(Fault::Leak) if self.holds_setpoint(params) && serving.reading_gain().is_some() => false,
            Some(Fault::Leak | Fault::Regulator) => !serving.refining.keeps_pressure(),
            Some(Fault::Stale | Fault::SupplyLow) | None => false,
        };
        broken || faulty
    }

    /// As the policy sees it: in its own role, at its nominal pressure. A compensation that is over may still
    /// hold its pressure, and the release be on its way: that must decide nothing.
    fn fitness<'p>(
        &self,
        model: &'p Model,
        belief: &Belief,
        is_self: bool,
        (objective, pressures): (Objective, (Megapascal, Megapascal)),
    ) -> Fitness<'p> {
        Fitness {
            model,
            length: self.filter.length().length,
            pressure: self.sheet.pressure,
            pressures,
            // A trimmed whisker's offset is best known as it is now.
            offset: if is_self { self.filter.offset() } else { self.whole_offset() },
            own: belief.predict,
            objective,
            usual: self.usual_contacts(),
        }
    }
}

#[cfg(test)]
mod tests;
