//! Contacts that arrive late: sent again, delayed, or read from a log.
//!
//! While nothing changes, the order of contacts says nothing. A contact from before a change that is known already would count
//! as evidence of a further change. So each whisker remembers the time of its newest change by the robot's clock: of
//! the contact that raised, confirmed or dismissed a suspicion, of the report of a setpoint, and of a replacement. Earlier
//! contacts are recorded and not learned from.

use crate::robot::Robot;
use crate::robot::effect::WhiskerIndex;
use crate::units::Micros;

/// Error of the estimated clock while messages are delayed.
const DELAY_MAX: Micros = Micros(60_000_000);

impl Robot {
    /// Whether a contact is from before a change of its whisker that is known already; 0 stands for a time that is not trusted.
    ///
    /// A robot's clock that has gone back says nothing of the order.
    pub(in crate::robot) fn is_late(&self, now: Micros, index: WhiskerIndex, robot_time: Micros) -> bool {
        let rare = &self.whiskers[index].rare;
        let changed_at = rare.changed_at.max(rare.set_at);
        robot_time != Micros::default()
            && robot_time < changed_at
            && self.head.clock.robot_time(now).is_none_or(|present| present.after(DELAY_MAX) >= changed_at)
    }

    /// Evidence about a whisker begins anew with the contact of this time; 0 stands for a time that is not trusted.
    pub(in crate::robot) fn changed_at(&mut self, index: WhiskerIndex, robot_time: Micros) {
        if robot_time != Micros::default() {
            self.whiskers[index].rare.get_or_insert().changed_at = robot_time;
        }
    }

    /// Evidence about a whisker begins anew now. Where the robot's clock is not known yet, it is the supervisor's, as the
    /// contract demands.
    pub(in crate::robot) fn changed_now(&mut self, now: Micros, index: WhiskerIndex) {
        let present = self.head.clock.robot_time(now).unwrap_or(now);
        self.changed_at(index, present);
    }
}
