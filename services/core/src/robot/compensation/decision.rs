//! Decisions over a whole array: what ends, and what begins.

use std::collections::BTreeMap;

use crate::estimation::ResponseBins;
use crate::policy::{Case, Mode, Offer, Proposal, assign};
use crate::robot::Robot;
use crate::robot::compensation::Compensation;
use crate::robot::compensation::candidates::CandidateProposal;
use crate::robot::compensation::prediction::cases_for_each;
use crate::robot::compensation::refinement::Refining;
use crate::robot::effect::{CandidateRecord, Condition, Decision, Effect, EndReason, Fault, Reason, WhiskerIndex};
use crate::robot::event::Task;
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;

/// A whisker covers the reach of one that was longer by no more than this, mm.
const REACH_TOLERANCE_MM: f64 = 1.0;

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

    /// Whether decisions leave it as it is: its target is held, or it runs where compensations must be approved, and is
    /// not given up for one that nobody has approved.
    pub(super) fn is_fixed(&self, params: &Params, one: &Compensation) -> bool {
        self.holds(one.target()) || (params.policy.mode == Mode::Advise && !one.proposed)
    }

    /// Whether the choice differs from the present state: another compensator, or none any more.
    fn is_news(&self, target: WhiskerIndex, chosen: Option<WhiskerIndex>) -> bool {
        self.whiskers[target].undecided || self.server(target).map(|(_, compensator)| compensator) != chosen
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

    /// A compensation begins, or is proposed.
    fn begin(&mut self, params: &Params, id: u32, chosen: &CandidateProposal<'_>) {
        let Ok(Proposal { case, setpoint: Some(setpoint), .. }) = chosen.proposal else { return };
        let is_self = chosen.target == chosen.compensator;
        let one = &self.whiskers[chosen.compensator];
        let has_lost = one.condition == Condition::SensitivityLoss;
        let keeps_pressure = self.pressure_it_has(params, chosen.compensator).is_some();
        let mut carried = one.carried(params, &setpoint);
        if has_lost {
            carried.shift(one.whole_lag(one.filter.whole_offset()));
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
            length_sd_mm: one.filter.relative_length().sd_mm,
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
            Some(Fault::Leak) if self.has_doubtful_leak(params) => false,
            Some(Fault::Leak) if self.holds_setpoint(params) && serving.reading_gain().is_some() => false,
            Some(Fault::Leak | Fault::Regulator) => !serving.refining.keeps_pressure(),
            Some(Fault::Stale | Fault::SupplyLow) | None => false,
        };
        broken || faulty
    }
}

#[cfg(test)]
mod tests;
