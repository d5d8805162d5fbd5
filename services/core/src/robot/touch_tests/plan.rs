//! Tests after a pause of a whisker's contacts, after a restart of its robot, and on a schedule.
//!
//! A whisker whose contacts state distances, or no place at all, may have been cut while nothing touched it, and its
//! contacts show that late or never. Without a place no contact tells anything, so such whiskers are tested by default.
//! One whose robot states ratios to the present length is not tested: its robot knows the length. Tests of this kind
//! follow one after another on a robot, so that its work goes on.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::policy::Mode;
use crate::robot::Robot;
use crate::robot::effect::{Effect, TestReason, WhiskerIndex};
use crate::robot::event::{Contact, ContactPlace};
use crate::robot::params::{Params, TouchTestParams};
use crate::units::Micros;

/// Times of a whisker's touches and tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct TestTimes {
    /// Time of its last contact, by the robot's clock of this boot; 0 before the first one.
    touched: Micros,
    /// Time of the last request or proposal of a test, by the supervisor's clock; before the first one, the time at which
    /// the schedule began, or 0.
    tested: Micros,
    need: Need,
    /// A pause is over, or the robot has started anew, and it was not tested since.
    is_due: bool,
}

/// Need for planned tests, by the place that the whisker's last contact stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
enum Need {
    /// A ratio to the present length: its robot knows the length. Or no contact yet.
    #[default]
    None,
    /// A distance or the tip.
    Reach,
    /// No place: only tests tell anything about the whisker.
    Place,
}

impl Need {
    fn of(place: ContactPlace) -> Self {
        match place {
            ContactPlace::Ratio { .. } => Self::None,
            ContactPlace::Distance(_) | ContactPlace::Tip(_) => Self::Reach,
            ContactPlace::Unknown => Self::Place,
        }
    }
}

crate::optional_parts::optional_fields!(TestTimes: ;
    touched: *touched > Micros::default(),
    tested: *tested > Micros::default(),
    need: *need != Need::None,
    is_due: *is_due,
);

impl TouchTestParams {
    fn plans(&self, need: Need) -> bool {
        need != Need::None && (self.after_pause > Micros(0) || self.every(need) > Micros(0))
    }

    /// Time between two tests by the schedule; 0 for none.
    fn every(&self, need: Need) -> Micros {
        match need {
            Need::None => Micros(0),
            Need::Place if self.every == Micros(0) => self.every_without_place,
            Need::Reach | Need::Place => self.every,
        }
    }
}

impl TestTimes {
    /// Reason for a test that is due now.
    fn due(&self, params: &TouchTestParams, now: Micros) -> Option<TestReason> {
        let every = params.every(self.need);
        if self.need == Need::None {
            None
        } else if self.is_due && params.after_pause > Micros(0) {
            Some(TestReason::Pause)
        } else {
            (every > Micros(0) && now.since(self.tested) >= every).then_some(TestReason::Schedule)
        }
    }
}

impl Robot {
    /// Notes the time of a contact, and whether a pause has ended with it.
    pub(in crate::robot) fn note_touch(&mut self, params: &Params, contact: &Contact<'_>) {
        let can_test = self.head.touch_tests.tip || self.head.touch_tests.wall;
        let begins = can_test && !contact.is_test && params.touch_tests.plans(Need::of(contact.place));
        if self.head.test_times.is_empty() && !begins {
            return;
        }
        let Some(index) = self.find(contact.array, contact.whisker) else { return };
        let whiskers = self.whiskers.len();
        let times = &mut self.head.test_times;
        times.resize(whiskers, TestTimes::default());
        let Some(times) = times.get_mut(index) else { return };
        let pause = params.touch_tests.after_pause;
        if !contact.is_test {
            times.need = Need::of(contact.place);
            let is_over = times.touched > Micros(0) && contact.robot_time.since(times.touched) >= pause;
            times.is_due |= is_over && pause > Micros(0);
        }
        times.touched = times.touched.max(contact.robot_time);
    }

    /// The robot has started anew, and its clock may be another one.
    pub(in crate::robot) fn test_after_restart(&mut self, params: &Params) {
        let after_restart = params.touch_tests.after_pause > Micros(0);
        for times in &mut self.head.test_times {
            times.touched = Micros(0);
            times.is_due |= after_restart;
        }
    }

    /// Begins the measurement of the next whisker that is due.
    pub(in crate::robot) fn plan_tests(&mut self, params: &Params, now: Micros, effects: &mut Vec<Effect>) {
        self.plan_zero(params, now, effects);
        let can_test = self.head.touch_tests.tip || self.head.touch_tests.wall;
        if !can_test || self.head.test_times.is_empty() {
            return;
        }
        if self.head.test_times.iter().any(|times| times.tested == Micros(0)) {
            let unknown = |times: &&mut TestTimes| times.tested == Micros(0);
            self.head.test_times.iter_mut().filter(unknown).for_each(|times| times.tested = now);
        }
        let Some((index, reason)) = self.next_due(params, now) else { return };
        let waits = params.policy.mode == Mode::Automatic
            && (self.tests_under_way().next().is_some()
                || !self.head.tests.is_left(now, params.touch_tests.per_hour)
                || !self.can_be_told(params, now));
        if waits {
            return;
        }
        self.want_test(index, reason);
        self.request_test(params, now, index, effects);
    }

    /// The whisker that is due, those after a pause first, then the one whose last test is longest ago.
    fn next_due(&self, params: &Params, now: Micros) -> Option<(WhiskerIndex, TestReason)> {
        let is_free = |index: WhiskerIndex| {
            let whisker = &self.whiskers[index];
            whisker.rare.length_test.is_none() && whisker.command.is_none() && !self.holds(index)
        };
        let due = self.head.test_times.iter().enumerate().take(self.whiskers.len());
        let due = due.filter_map(|(index, times)| Some((index, times.due(&params.touch_tests, now)?, times.tested)));
        let due = due.filter(|(index, ..)| is_free(*index));
        let next = due.min_by_key(|(_, reason, tested)| (*reason != TestReason::Pause, *tested));
        next.map(|(index, reason, _)| (index, reason))
    }

    /// Whether the last contact of the whisker stated no place.
    pub(in crate::robot) fn states_no_place(&self, index: WhiskerIndex) -> bool {
        self.head.test_times.get(index).is_some_and(|times| times.need == Need::Place)
    }

    /// A test of the whisker is requested or proposed: the next one is due an interval later.
    pub(super) fn note_test(&mut self, now: Micros, index: WhiskerIndex) {
        if let Some(times) = self.head.test_times.get_mut(index) {
            (times.tested, times.is_due) = (now, false);
        }
    }
}
