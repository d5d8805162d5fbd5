//! Alarms stand as long as their cause. The alarms that are due follow from the state alone, at the end of each step;
//! differences from the standing alarms become effects.

use crate::robot::effect::{AlarmKind, Condition, Effect, Fault, WhiskerIndex};
use crate::robot::health::duplicate::DuplicateWatch;
use crate::robot::health::misfit::Cause;
use crate::robot::health::standing::Standing;
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::robot::{Compensation, Robot};
use crate::units::Micros;

const STALE: Option<Fault> = Some(Fault::Stale);

impl Robot {
    /// Raises the alarms of a whisker that are due and do not stand, and clears those that stand and are not due.
    pub(in crate::robot) fn tell_alarms(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        self.let_stand(index, self.alarms_due(index), effects);
    }

    fn let_stand(&mut self, index: WhiskerIndex, due: Standing, effects: &mut Vec<Effect>) {
        let was = self.whiskers[index].standing;
        if due == was {
            return;
        }
        self.whiskers[index].standing = due;
        let (cleared, raised) = (was.without(&due), due.without(&was));
        effects.extend(cleared.kinds().map(|kind| Effect::AlarmCleared { whisker: index, kind }));
        effects.extend(raised.kinds().map(|kind| Effect::Alarm { whisker: index, kind }));
    }

    /// The alarms that the state of a whisker asks for.
    pub(in crate::robot) fn alarms_due(&self, index: WhiskerIndex) -> Standing {
        let is_proposed = self.head.compensations.iter().any(|one| one.proposed && one.target() == index);
        let is_own = |one: &Compensation| one.target() == index && one.compensator() == index && !one.settled;
        let is_tried = self.whiskers[index].rare.tries.is_failing() && self.head.compensations.iter().any(is_own);
        let whisker = &self.whiskers[index];
        let due = whisker.due(is_proposed, is_tried, self.misfit(index));
        let stands = !self.head.silent && whisker.fault == STALE && whisker.standing.fault == STALE;
        if stands { due.with_silence() } else { due }
    }

    /// Raises or clears the alarm for the robot's silence. Returns whether the silence has begun: then no whisker's own
    /// silence is an alarm any more.
    pub(in crate::robot) fn tell_silence(&mut self, now: Micros, effects: &mut Vec<Effect>) -> bool {
        let (was, is) = (self.head.silent, self.is_silent());
        if was == is || self.is_duplicated() {
            return false;
        }
        self.head.silent = is;
        let kind = AlarmKind::RobotSilent;
        if is {
            effects.push(Effect::RobotAlarm { kind });
        } else {
            self.head.heard_again = now;
            // Ticks follow the whiskers that stay silent.
            self.tick_deadline.end();
            effects.push(Effect::RobotAlarmCleared { kind });
        }
        is
    }

    /// Whether no whisker is heard.
    fn is_silent(&self) -> bool {
        // First a whisker of this step, because it is in the processor's cache.
        let is_heard = self.whiskers.first_touched().is_some_and(|index| self.whiskers[index].fault != STALE);
        !is_heard && !self.whiskers.is_empty() && self.whiskers.iter().all(|whisker| whisker.fault == STALE)
    }

    /// Raises the alarms of whiskers that are silent alone. Whiskers of a robot that falls silent are not: they become
    /// stale one after the other, and nothing comes from any of them.
    pub(in crate::robot) fn tell_lone_silence(&mut self, params: &Params, effects: &mut Vec<Effect>) {
        if self.is_duplicated()
            || self.is_silent()
            || !(0..self.whiskers.len()).any(|index| self.may_be_silent_alone(index))
        {
            return;
        }
        let newest = self.whiskers.iter().filter_map(|whisker| whisker.heard).max().unwrap_or_default();
        for index in 0..self.whiskers.len() {
            let heard = self.whiskers[index].heard.unwrap_or_default().max(self.head.heard_again);
            if self.may_be_silent_alone(index) && newest.since(heard) > params.health.stale_after {
                self.let_stand(index, self.alarms_due(index).with_silence(), effects);
            }
        }
    }

    /// Whether a whisker is silent, and whether it is so alone is not known yet.
    pub(in crate::robot) fn may_be_silent_alone(&self, index: WhiskerIndex) -> bool {
        let whisker = &self.whiskers[index];
        !self.head.silent && whisker.fault == STALE && whisker.standing.fault != STALE
    }

    /// Takes back all alarms without effects, because nobody is responsible for the robot for now. Returns whether any
    /// stood. [`Self::review_alarms`] must follow before the next step.
    pub fn withdraw_alarms(&mut self) -> bool {
        let mut any = std::mem::take(&mut self.head.silent) || self.is_duplicated();
        self.head.duplicate = DuplicateWatch::default();
        for index in 0..self.whiskers.len() {
            if self.whiskers[index].standing != Standing::default() {
                self.whiskers[index].standing = Standing::default();
                any = true;
            }
        }
        any
    }

    /// Makes the next step raise the alarms that are due: the robot is supervised again. Silence counts from `now` on.
    pub fn review_alarms(&mut self, now: Micros) {
        self.listen_from(now);
        self.whiskers.review();
    }

    /// The standing alarms about the robot as a whole.
    pub fn standing(&self) -> impl Iterator<Item = AlarmKind> + '_ {
        let silent = self.head.silent.then_some(AlarmKind::RobotSilent);
        silent.into_iter().chain(self.is_duplicated().then_some(AlarmKind::DuplicateRobot))
    }
}

impl Whisker {
    /// The alarms that its state asks for, but for its silence; `is_tried` if its own compensation has failed and is tried
    /// again, `misfit` if its readings do not fit.
    fn due(&self, proposed: bool, is_tried: bool, misfit: Option<Cause>) -> Standing {
        let is = [
            self.condition == Condition::SensitivityLoss,
            self.condition == Condition::Eroding,
            self.shift_told,
            self.drift_told,
            self.has_failed_setpoint(),
            self.unserved || is_tried,
            proposed,
            self.rare.reach.as_ref().is_some_and(|reach| reach.is_lost()),
            self.has_vented_alarm(),
            misfit == Some(Cause::CablesExchanged),
            misfit == Some(Cause::WhiskerReplaced),
            misfit == Some(Cause::GaugeReversed),
            misfit == Some(Cause::Unknown),
        ];
        Standing::new(self.fault_with_alarm(), is)
    }
}
