//! The time until which a tick has nothing to do: most robots are heard in time and hold their setpoints.
//!
//! By time alone, a whisker becomes silent, a pressure is not held for too long, a fault is steady again, and a setpoint is sent, sent again or
//! expires. While no setpoint is under way, the earliest of these times is known after a look at all whiskers. Each
//! step lowers that time to the deadline of every whisker that it has accessed: a whisker that was not accessed has the
//! same deadline.

use crate::robot::Robot;
use crate::robot::effect::{Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::Micros;

/// From the last look at all whiskers until the first of them can have something to be done.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::robot) struct TickDeadline(Option<(Micros, Micros)>);

/// A cache does not make robots differ.
impl PartialEq for TickDeadline {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl TickDeadline {
    /// The next tick looks at all whiskers.
    pub(in crate::robot) fn end(&mut self) {
        self.0 = None;
    }

    /// Something can have to be done after `until`, or now.
    fn not_beyond(&mut self, until: Option<Micros>) {
        self.0 = self.0.zip(until).map(|((from, known), until)| (from, until.min(known)));
    }

    /// Whether a tick at `now` has nothing to do for any whisker.
    pub(in crate::robot) fn holds(self, now: Micros) -> bool {
        self.0.is_some_and(|(from, until)| from <= now && now <= until)
    }
}

impl Robot {
    /// Time has passed.
    pub(in crate::robot) fn tick(&mut self, params: &Params, now: Micros, effects: &mut Vec<Effect>) {
        self.tell_duplicate(now, effects);
        self.await_factsheet(now, effects);
        self.plan_tests(params, now, effects);
        if self.tick_deadline.holds(now) {
            return;
        }
        for index in 0..self.whiskers.len() {
            self.refresh_fault(params, now, index, effects);
            // The decision at the end of the step may want another pressure.
            if !self.try_again_in_time(params, now, index) {
                self.reconcile(params, now, index, effects);
            }
            self.follow_test(now, index, effects);
            self.request_test(params, now, index, effects);
        }
        self.tell_lone_silence(params, effects);
        let each = |index: WhiskerIndex| self.quiet_until(params, now, index);
        let until = (0..self.whiskers.len()).map(each).try_fold(Micros(u64::MAX), |least, one| Some(least.min(one?)));
        self.tick_deadline = TickDeadline(until.map(|until| (now, until)));
    }

    /// Takes the deadline of a whisker into account that this step has accessed.
    pub(in crate::robot) fn meet_deadline(&mut self, params: &Params, now: Micros, index: WhiskerIndex) {
        self.tick_deadline.not_beyond(self.quiet_until(params, now, index));
    }

    /// Until when a tick has nothing to do for a whisker; none if it has something to do now.
    fn quiet_until(&self, params: &Params, now: Micros, index: WhiskerIndex) -> Option<Micros> {
        let whisker = &self.whiskers[index];
        let is_up_to_date = self.is_fault_up_to_date(params, now, index) && !self.may_be_silent_alone(index);
        whisker.quiet_until(params, now, self.head.listening_since).filter(|_| is_up_to_date)
    }
}

impl Whisker {
    /// Until when nothing comes about by time alone; none if something is under way.
    fn quiet_until(&self, params: &Params, now: Micros, listening_since: Micros) -> Option<Micros> {
        if self.desired.is_some() || self.command.is_some() || self.rare.length_test.is_some() || self.waits_for_retry()
        {
            return None;
        }
        let silent = self.heard.map(|heard| heard.max(listening_since).after(params.health.stale_after));
        let unheld = self.air.unheld_since.map(|since| since.after(params.health.unheld_after));
        // Deadlines that have passed have had their effect.
        let flapping = self.flapping_times(&params.health.flapping);
        let to_come = [silent, unheld].into_iter().flatten().chain(flapping).filter(|&at| now <= at);
        Some(to_come.min().unwrap_or(Micros(u64::MAX)))
    }
}
