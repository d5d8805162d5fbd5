//! Times in which the supervisor could receive nothing. Silence in them is not the robot's.

use crate::robot::Robot;
use crate::robot::effect::Fault;
use crate::robot::params::Params;
use crate::units::Micros;

impl Robot {
    /// Excuses silence before `deaf_until`, in which nothing could be received, if an event at `now` would count it: if
    /// a whisker would become silent, if a setpoint or a touch test has no answer, or if a gap in the message numbers has
    /// stood since then. Returns whether it has changed the state; the events after it must not be replayed without it.
    ///
    /// Most robots are heard again before, so the state of a large fleet need not be written after an outage.
    pub fn excuse_silence(&mut self, params: &Params, now: Micros, deaf_until: Micros) -> bool {
        if self.head.listening_since >= deaf_until || !self.counts_silence(params, now, deaf_until) {
            return false;
        }
        self.listen_from(deaf_until);
        self.head.mark();
        true
    }

    fn counts_silence(&self, params: &Params, now: Micros, deaf_until: Micros) -> bool {
        let since = self.head.listening_since;
        let is_about_to = || {
            self.whiskers.iter().any(|whisker| {
                let becomes_silent = whisker.fault != Some(Fault::Stale)
                    && whisker.heard.is_some_and(|heard| heard < deaf_until)
                    && whisker.is_silent(params, now, since);
                becomes_silent || whisker.has_unanswered_setpoint(deaf_until) || whisker.has_overdue_test(now)
            })
        };
        self.head.sequences.have_stood_before(deaf_until) || !self.tick_deadline.holds(now) && is_about_to()
    }
}
