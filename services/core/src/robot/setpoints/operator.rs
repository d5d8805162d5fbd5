//! Operators' actions.

use crate::robot::action::{ActionProblem, OperatorAction, Place, Scope};
use crate::robot::effect::{Effect, EndReason, Reason, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::whisker::Desired;
use crate::robot::{Outcome, Robot};
use crate::units::{Megapascal, Micros};

impl Robot {
    /// Carries out an action, or refuses it without any change.
    pub(in crate::robot) fn operate(
        &mut self,
        params: &Params,
        now: Micros,
        action: &OperatorAction<'_>,
        effects: &mut Vec<Effect>,
    ) -> Outcome {
        let done = match *action {
            OperatorAction::Approve { compensation } => self.approve(compensation, effects),
            OperatorAction::Refuse { compensation } => self.refuse(compensation, effects),
            OperatorAction::Setpoint { whisker, pressure_mpa } => {
                self.set_by_hand(params, now, whisker, pressure_mpa, effects)
            }
            OperatorAction::Hold(scope) => self.hold(scope),
            OperatorAction::Release(scope) => self.end_hold(scope),
            OperatorAction::Retry(place) => self.retry(place),
            OperatorAction::RefuseTouchTest(place) => self.refuse_test(now, place, effects),
            OperatorAction::TouchTest(place) => self.test_by_hand(params, now, place, effects),
            OperatorAction::Replaced(place) => self.at(place).map(|index| {
                self.replaced(params, index, effects);
                self.forget_misfit(index);
                self.changed_now(now, index);
            }),
            OperatorAction::Rebaseline(place) => self.at(place).map(|index| {
                self.rebaseline(params, index, effects);
                self.forget_misfit(index);
                self.changed_now(now, index);
            }),
        };
        done.map_or_else(Outcome::Refused, |()| Outcome::Taken)
    }

    pub(in crate::robot) fn at(&self, place: Place<'_>) -> Result<WhiskerIndex, ActionProblem> {
        self.find(place.array, place.whisker).ok_or(ActionProblem::UnknownWhisker)
    }

    /// Whether no automatic setpoint may go to a whisker: an operator holds it, or must confirm a change first.
    pub(in crate::robot) fn holds(&self, index: WhiskerIndex) -> bool {
        self.head.held || self.whiskers[index].held || self.awaits_confirmation(index)
    }

    fn approve(&mut self, id: u32, effects: &mut Vec<Effect>) -> Result<(), ActionProblem> {
        let at = self.proposed(id)?;
        let compensator = self.head.compensations[at].compensator();
        if self.holds(compensator) {
            return Err(ActionProblem::Held);
        }
        let approved = &mut self.head.compensations[at];
        approved.proposed = false;
        let desired = approved.desired(Reason::Compensation(approved.case));
        self.desire(compensator, desired);
        effects.push(Effect::Approved { compensation: id });
        Ok(())
    }

    fn refuse(&mut self, id: u32, effects: &mut Vec<Effect>) -> Result<(), ActionProblem> {
        let at = self.proposed(id)?;
        let (target, compensator) = (self.head.compensations[at].target(), self.head.compensations[at].compensator());
        let number = self.whiskers[compensator].sheet.number;
        self.whiskers[target].refused_servers.push(number);
        self.end(id, EndReason::Refused, effects);
        Ok(())
    }

    fn proposed(&self, id: u32) -> Result<usize, ActionProblem> {
        let waits = self.head.compensations.iter().position(|one| one.id == id && one.proposed);
        waits.ok_or(ActionProblem::NotProposed)
    }

    fn set_by_hand(
        &mut self,
        params: &Params,
        now: Micros,
        place: Place<'_>,
        pressure_mpa: f64,
        effects: &mut Vec<Effect>,
    ) -> Result<(), ActionProblem> {
        let index = self.at(place)?;
        let one = &self.whiskers[index];
        let (limit, (_, own)) = (one.pressure_limit(), one.pressures(self.head.air_control));
        let highest = if own < limit { own } else { limit };
        let in_range = Megapascal::new(pressure_mpa).ok().filter(|pressure| *pressure <= highest);
        let pressure = in_range.ok_or(ActionProblem::PressureOutOfRange { asked_mpa: pressure_mpa, highest })?;
        if self.has_wrong_time_unit() {
            return Err(ActionProblem::WrongTimeUnit);
        }
        if !self.can_be_told(params, now) {
            return Err(ActionProblem::RobotOffline);
        }
        self.end_as_compensator(index, EndReason::Operator, |_| true, effects);
        let whisker = &mut self.whiskers[index];
        whisker.held = true;
        whisker.given_up = false;
        whisker.rare.forget_tries();
        whisker.rare.forget_vents();
        self.desire(index, Desired { pressure, reason: Reason::Operator, compensation: None, gain: None });
        Ok(())
    }

    fn hold(&mut self, scope: Scope<'_>) -> Result<(), ActionProblem> {
        match scope {
            Scope::Robot => self.head.held = true,
            Scope::Whisker(place) => {
                let index = self.at(place)?;
                self.whiskers[index].held = true;
            }
        }
        Ok(())
    }

    fn end_hold(&mut self, scope: Scope<'_>) -> Result<(), ActionProblem> {
        match scope {
            Scope::Robot => self.head.held = false,
            Scope::Whisker(_) if self.head.held => return Err(ActionProblem::RobotHeld),
            Scope::Whisker(place) => {
                let index = self.at(place)?;
                self.whiskers[index].held = false;
            }
        }
        let released = match scope {
            Scope::Robot => 0..self.whiskers.len(),
            Scope::Whisker(place) => self.at(place).map(|index| index..index + 1)?,
        };
        for index in released {
            if !self.whiskers[index].held {
                let rare = &mut self.whiskers[index].rare;
                rare.forget_tries();
                rare.forget_vents();
                self.back_to_automatic(index);
            }
        }
        Ok(())
    }

    /// Tries a failed setpoint again at once, as if it were the first one.
    fn retry(&mut self, place: Place<'_>) -> Result<(), ActionProblem> {
        let index = self.at(place)?;
        if !self.whiskers[index].has_failed_setpoint() {
            return Err(ActionProblem::NoFailedSetpoint);
        }
        if self.holds(index) {
            return Err(ActionProblem::RetryOfHeld);
        }
        self.whiskers[index].rare.forget_tries();
        self.back_to_automatic(index);
        Ok(())
    }

    /// Sets the pressure that a whisker shall hold after the end of its hold, or of a pause after failed setpoints.
    pub(in crate::robot) fn back_to_automatic(&mut self, index: WhiskerIndex) {
        let running = self.head.compensations.iter().find(|one| one.compensator() == index && !one.proposed);
        let running = running.map(|one| one.desired(Reason::Compensation(one.case)));
        let whisker = &mut self.whiskers[index];
        whisker.given_up = false;
        let wanted = whisker.desired.take().map(|wanted| *wanted);
        match running {
            // As it was wanted before: it may be a refinement.
            Some(own) => self.desire(index, wanted.filter(|one| one.compensation == own.compensation).unwrap_or(own)),
            None => self.release(index),
        }
    }

    /// Ends the compensations that a whisker serves in, of those that `which` names.
    pub(in crate::robot) fn end_as_compensator(
        &mut self,
        index: WhiskerIndex,
        reason: EndReason,
        which: impl Fn(&crate::robot::Compensation) -> bool,
        effects: &mut Vec<Effect>,
    ) {
        let served = self.head.compensations.iter().filter(|one| one.compensator() == index && which(one));
        let over: Vec<u32> = served.map(|one| one.id).collect();
        for id in over {
            self.end(id, reason, effects);
        }
    }
}
