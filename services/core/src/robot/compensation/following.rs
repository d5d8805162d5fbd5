//! A whisker that erodes compensates for itself, and its setpoint follows its length.
//!
//! The first setpoint comes once a step of length is lost, and a new one with each further step, but not more often than
//! the whisker has had a number of contacts. So the number of setpoints is bounded by the length that there is to lose.
//! Pressure and gain are those of a decision at the present length; nothing is measured meanwhile, because the response
//! moves on. When the erosion stops, the whisker is a cut one, and its setpoint is refined as usual.

use crate::mechanics::{Offset, Setpoint};
use crate::policy::{Case, Refused, propose};
use crate::robot::Robot;
use crate::robot::compensation::refinement::Refining;
use crate::robot::effect::{Condition, Effect, Reason, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;

impl Robot {
    /// Follows an eroding whisker after a contact.
    pub(in crate::robot) fn follow_wear(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &self.whiskers[index];
        if whisker.condition != Condition::Eroding || whisker.rare.pending_trim.is_some() {
            return;
        }
        let length = whisker.filter.relative_length();
        let step_mm = params.refinement.erosion_step_mm;
        let is_worn = whisker.sheet.length.mm() - length.length.mm() >= step_mm;
        let contact_sd_mm = whisker.contact_sd_mm(params);
        if whisker.rare.erosion.as_ref().is_some_and(|watch| watch.has_stopped(contact_sd_mm)) {
            self.stop_wearing(params, index, is_worn, effects);
            return;
        }
        let at = self.head.compensations.iter().position(|one| one.target() == index);
        match at.map(|at| &self.head.compensations[at]) {
            None if is_worn && !whisker.undecided && !whisker.unserved => self.whiskers[index].undecided = true,
            Some(running)
                if running.length.mm() - length.length.mm() >= step_mm
                    && running.after.contacts() >= params.refinement.erosion_contacts_min =>
            {
                self.renew_setpoint(params, index);
            }
            None | Some(_) => {}
        }
    }

    /// The erosion is over: what is left is a cut whisker, or a whole one if hardly anything was lost.
    fn stop_wearing(&mut self, params: &Params, index: WhiskerIndex, is_worn: bool, effects: &mut Vec<Effect>) {
        let is_served = self.head.compensations.iter().any(|one| one.target() == index);
        let whisker = &mut self.whiskers[index];
        // What it has of the erosion would look like a new one.
        whisker.detector = crate::detection::Detector::default();
        whisker.cannot_deny();
        // Its offset is known no better than after one move to the present pressure.
        let moved_mpa = whisker.air.learned_at.mpa() - whisker.sheet.pressure.mpa();
        whisker.filter.pressure_moved(moved_mpa, &params.filter);
        let to = if is_worn || is_served { Condition::Trimmed } else { Condition::Healthy };
        whisker.undecided |= to == Condition::Trimmed && !is_served;
        self.set_condition(index, to, effects);
        self.renew_setpoint(params, index);
    }

    /// A new setpoint for a whisker that compensates for itself, by its present length. A whisker that cannot any more is
    /// decided on anew.
    fn renew_setpoint(&mut self, params: &Params, index: WhiskerIndex) {
        let is_own = |one: &super::Compensation| {
            one.target() == index && one.case == Case::SelfCompensation && !one.proposed && one.settled
        };
        let Some(at) = self.head.compensations.iter().position(is_own) else { return };
        let whisker = &self.whiskers[index];
        let Some(model) = whisker.model(params) else { return };
        if whisker.command.is_some() || self.holds(index) {
            return;
        }
        let length = whisker.filter.relative_length();
        let belief = whisker.belief(model);
        let objective = params.policy.objective_for(self.head.applies_gain);
        let running = &self.head.compensations[at];
        let leaks = running.refining.keeps_pressure();
        let pressures =
            if leaks { (running.pressure, running.pressure) } else { whisker.pressures(self.head.air_control) };
        let fitness = whisker.fitness(model, &belief, true, self.usual_contacts(index), (objective, pressures));
        let proposal = propose(&params.policy, model, whisker.target(), whisker.whole_offset(), &fitness, true);
        // Where even zero pressure is too high, the gain makes up for the rest.
        let goes_on = matches!(proposal.refused, None | Some(Refused::NeedsBelowRange));
        let within = |setpoint: &Setpoint| goes_on && setpoint.error.mean <= params.policy.predicted_error_max;
        let Some(setpoint) = proposal.setpoint.filter(within) else {
            self.whiskers[index].undecided = true;
            return;
        };
        let carried = whisker.carried(params, &setpoint);
        let running = &mut self.head.compensations[at];
        (running.length, running.length_sd_mm) = (length.length, length.sd_mm);
        (running.pressure, running.predicted_error) = (setpoint.pressure, setpoint.error.mean);
        running.after = crate::estimation::ResponseBins::default();
        let gain = setpoint.gain.by_ratio;
        running.refining = if leaks { Refining::of_gain(gain, carried) } else { Refining::new(gain, carried) };
        // Not settled until the robot has taken it: that is what makes it be sent.
        running.settled = false;
        let desired = running.desired(Reason::Refinement);
        self.desire(index, desired);
    }
}

impl Whisker {
    /// Standard deviation of the length that one contact tells, mm.
    pub(in crate::robot) fn contact_sd_mm(&self, params: &Params) -> f64 {
        let slope = self.model(params).map_or(0.0, |model| self.log_slope_with_length(model).abs());
        let log_sd = self.contact_log_sd(params);
        if slope > 0.0 { log_sd / slope * self.filter.length().length.mm() } else { f64::INFINITY }
    }

    /// Standard deviation of the noise of one usual contact, log sensitivity.
    pub(in crate::robot) fn contact_log_sd(&self, params: &Params) -> f64 {
        let slope = self.model(params).map_or(0.0, |model| self.log_slope_with_length(model).abs());
        // The contact ratio moves the sensitivity as much as the length does.
        let by_ratio = slope * params.noise.ratio / Offset::CENTRE;
        let log_variance = params.noise.strain_relative.powi(2) + params.noise.deflection_relative.powi(2);
        (self.noise.variance() * (log_variance + by_ratio.powi(2))).sqrt()
    }
}
