//! The candidates for a broken whisker, and their proposals.

use crate::estimation::Belief;
use crate::mechanics::{Model, Objective, UsualContacts};
use crate::policy::{Case, Fitness, Ineligible, Proposal, Refused, propose};
use crate::robot::Robot;
use crate::robot::compensation::Compensation;
use crate::robot::effect::{CandidateRecord, Condition, Fault, WhiskerIndex};
use crate::robot::event::{AirControl, ArrayKind, Task};
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::Megapascal;

/// One candidate for a target, and its proposal.
pub(super) struct CandidateProposal<'p> {
    pub(super) target: WhiskerIndex,
    pub(super) compensator: WhiskerIndex,
    /// Case and predicted error of this compensation if it is in force: the candidate's pressure has changed since
    /// then.
    pub(super) standing: Option<(Case, f64)>,
    /// Its properties and the belief about its own calibration, as the policy saw them; none if it is ineligible.
    pub(super) fit: Option<(Fitness<'p>, Belief)>,
    pub(super) proposal: Result<Proposal, Ineligible>,
    /// It serves in a compensation that decisions must not change.
    pub(super) reserved: bool,
}

impl CandidateProposal<'_> {
    pub(super) fn cost(&self, params: &Params) -> Option<f64> {
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
    /// Evaluates all candidates for a broken whisker: itself and, in a Type 1 array, its neighbours.
    pub(super) fn ask<'p>(&self, params: &'p Params, target: WhiskerIndex) -> Vec<CandidateProposal<'p>> {
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
                let usual = self.usual_contacts(compensator);
                let fitness = one.fitness(model, &belief, is_self, usual, (objective, pressures));
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

    /// Whether it has lost sensitivity, and its robot multiplies its readings: then a gain alone serves it. An array that reads
    /// distances gets no setpoints.
    pub(super) fn is_served_by_gain(&self, params: &Params, index: WhiskerIndex) -> bool {
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
    pub(super) fn may_have_air_again(&self, one: &Compensation) -> bool {
        one.refining.keeps_pressure()
            && one.pressure > Megapascal::ZERO
            && self.whiskers[one.compensator()].fault.is_none()
            && self.head.air_control != AirControl::None
            && !self.holds(one.compensator())
    }

    pub(super) fn record(
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
        let estimate = one.filter.relative_length();
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
}

impl Whisker {
    /// Reason why it cannot be a candidate, if there is one. A trimmed whisker may still serve itself.
    pub(super) fn ineligible(&self, for_itself: bool, by_gain: bool, serves_faulty: bool) -> Option<Ineligible> {
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

    /// As the policy sees it: in its own role, at its nominal pressure. A compensation that is over may still
    /// hold its pressure, and the release be on its way: that must decide nothing.
    pub(super) fn fitness<'p>(
        &self,
        model: &'p Model,
        belief: &Belief,
        is_self: bool,
        usual: UsualContacts,
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
            usual,
        }
    }
}
