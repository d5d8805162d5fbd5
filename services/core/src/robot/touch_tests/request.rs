//! Requests of touch tests, and the robot's answers.

use crate::policy::Mode;
use crate::robot::Robot;
use crate::robot::action::{ActionProblem, Place};
use crate::robot::effect::{CommandKey, Effect, TestKind, TestReason, TestState, TouchTest, WhiskerIndex};
use crate::robot::event::{Rejection, TestReport};
use crate::robot::params::Params;
use crate::robot::touch_tests::evidence::TESTS_MAX;
use crate::robot::touch_tests::{LengthTest, TestInFlight};
use crate::units::Micros;

/// Contacts of a test of the length. The next test of the same measurement is planned with them.
const LENGTH_CONTACTS: u16 = 10;
/// Contacts of a test after a setpoint, over the whole range of contact ratios.
const RESPONSE_CONTACTS: u16 = 36;
/// Contact ratios of a test after a setpoint.
const RESPONSE_RATIOS: [f64; 6] = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
/// Deflections of a test, mm: weak ones and those that most contacts have.
const DEFLECTIONS_MM: [f64; 3] = [1.0, 2.0, 3.0];

impl Robot {
    /// Requests a touch test of a whisker, if one is wanted and the robot can do it now.
    pub(in crate::robot) fn request_test(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &self.whiskers[index];
        let Some(test) = whisker.rare.length_test.as_ref().filter(|test| test.is_wanted()) else { return };
        let Some(reason) = test.wanted else { return };
        let may_ask = reason == TestReason::Operator || params.policy.mode == Mode::Automatic;
        let waits = now < test.not_before && test.not_before.since(now) <= params.touch_tests.pause;
        if !may_ask || waits || self.holds(index) || whisker.command.is_some() || !self.can_be_told(params, now) {
            return;
        }
        let kind = match (reason, self.head.touch_tests.tip, self.head.touch_tests.wall) {
            (TestReason::Setpoint, _, true) | (TestReason::Suspicion | TestReason::Operator, false, true) => {
                TestKind::Wall
            }
            (_, true, _) => TestKind::Tip,
            (_, false, false) => return,
        };
        let (Some(robot_time), Some(boot_id)) = (self.head.clock.robot_time(now), &self.head.boot_id) else { return };
        let robot_boot_id = boot_id.as_str().to_owned();
        let mut budget = self.head.tests;
        if !budget.take(now, params.touch_tests.per_hour) {
            return;
        }
        self.head.tests = budget;
        let key = CommandKey { epoch: self.head.epoch, version: self.head.next_version };
        self.head.next_version += 1;
        let whisker = &mut self.whiskers[index];
        let length_mm = whisker.filter.length().length.mm();
        let Some(test) = whisker.rare.get_mut().and_then(|rare| rare.length_test.as_mut()) else { return };
        let (distances_mm, contacts) = test.plan(kind, reason, length_mm);
        let valid_for = params.command.time_to_live;
        let takes = Micros(params.touch_tests.contact_time.0.saturating_mul(contacts.into()));
        test.in_flight = Some(TestInFlight {
            key,
            kind,
            reason,
            state: TestState::Pending,
            until: now.after(valid_for).after(takes),
        });
        let deflections_mm = if kind == TestKind::Wall { DEFLECTIONS_MM.to_vec() } else { Vec::new() };
        effects.push(Effect::Test(Box::new(TouchTest {
            key,
            whisker: index,
            robot_boot_id,
            kind,
            distances_mm,
            deflections_mm,
            contacts,
            issued: now,
            expires: robot_time.after(valid_for),
            reason,
        })));
    }

    /// Gives up a test without an answer or an end.
    pub(in crate::robot) fn follow_test(&mut self, now: Micros, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let in_flight = self.whiskers[index].rare.length_test.as_ref().and_then(|test| test.in_flight);
        if let Some(test) = in_flight.filter(|test| now > test.until) {
            self.end_test(now, index, TestState::Expired, None, Micros::from_s(60.0), effects);
            debug_assert!(self.whiskers[index].in_flight(test.key).is_none(), "an expired test goes on");
        }
    }

    /// Takes a robot's report on a touch test in.
    pub(in crate::robot) fn test_reported(
        &mut self,
        params: &Params,
        now: Micros,
        key: CommandKey,
        report: TestReport,
        effects: &mut Vec<Effect>,
    ) {
        let Some(index) = self.whiskers.iter().position(|one| one.in_flight(key).is_some()) else { return };
        let pause = params.touch_tests.pause;
        match report {
            TestReport::Accepted => self.test_goes_on(index, TestState::Accepted, effects),
            TestReport::Running => self.test_goes_on(index, TestState::Running, effects),
            TestReport::Done => self.test_done(now, index, pause, effects),
            TestReport::Failed => self.end_test(now, index, TestState::Failed, None, pause, effects),
            TestReport::Rejected(rejection) => {
                let wait = match rejection {
                    Rejection::NotReady | Rejection::Expired => params.command.time_to_live,
                    Rejection::Stale | Rejection::OutOfRange | Rejection::UnknownWhisker | Rejection::WrongBoot => {
                        pause
                    }
                };
                self.end_test(now, index, TestState::Rejected, Some(rejection), wait, effects);
                if matches!(rejection, Rejection::UnknownWhisker | Rejection::WrongBoot) {
                    effects.push(Effect::AskForFactsheet);
                }
            }
        }
        self.request_test(params, now, index, effects);
    }

    fn test_goes_on(&mut self, index: WhiskerIndex, state: TestState, effects: &mut Vec<Effect>) {
        let Some(test) = self.whiskers[index].in_flight_mut() else { return };
        if test.state != state && test.state != TestState::Running {
            test.state = state;
            effects.push(Effect::TestState { test: test.key, whisker: index, state, rejection: None });
        }
    }

    /// A robot has done a test. Unless it decided, another one follows at once, up to [`TESTS_MAX`]; then after a pause.
    fn test_done(&mut self, now: Micros, index: WhiskerIndex, pause: Micros, effects: &mut Vec<Effect>) {
        self.end_test(now, index, TestState::Done, None, Micros::default(), effects);
        let Some(test) = self.whiskers[index].length_test_mut() else { return };
        test.done = test.done.saturating_add(1);
        let is_for_length = test.wanted != Some(TestReason::Setpoint);
        self.judge_length(index, effects);
        let Some(test) = self.whiskers[index].length_test_mut() else { return };
        if !is_for_length {
            test.wanted = None;
        } else if test.done >= TESTS_MAX {
            (test.done, test.not_before) = (0, now.after(pause));
            test.wanted.take_if(|reason| *reason == TestReason::Operator);
        }
        if test.wanted.is_none() {
            self.whiskers[index].end_measurement();
        }
    }

    fn end_test(
        &mut self,
        now: Micros,
        index: WhiskerIndex,
        state: TestState,
        rejection: Option<Rejection>,
        wait: Micros,
        effects: &mut Vec<Effect>,
    ) {
        let Some(test) = self.whiskers[index].length_test_mut() else { return };
        let Some(ended) = test.in_flight.take() else { return };
        test.not_before = now.after(wait);
        effects.push(Effect::TestState { test: ended.key, whisker: index, state, rejection });
    }

    /// Tests that were under way in a boot that is no more. They are requested again.
    pub(in crate::robot) fn abandon_tests(&mut self, effects: &mut Vec<Effect>) {
        for index in 0..self.whiskers.len() {
            if self.whiskers[index].rare.length_test.as_ref().is_some_and(|test| test.in_flight.is_some()) {
                self.end_test(Micros::default(), index, TestState::Abandoned, None, Micros::default(), effects);
            }
        }
    }

    /// An operator asks for a test.
    pub(in crate::robot) fn test_by_hand(&mut self, place: Place<'_>) -> Result<(), ActionProblem> {
        let index = self.at(place)?;
        if !self.head.touch_tests.tip && !self.head.touch_tests.wall {
            return Err(ActionProblem::NoTouchTests);
        }
        if self.holds(index) {
            return Err(ActionProblem::TestOfHeld);
        }
        let whisker = &self.whiskers[index];
        if whisker.rare.length_test.as_ref().is_some_and(|test| test.in_flight.is_some()) {
            return Err(ActionProblem::TestUnderWay);
        }
        self.want_test(index, TestReason::Operator);
        Ok(())
    }

    /// A setpoint of a compensation was applied: its error is to be measured.
    pub(in crate::robot) fn test_after_setpoint(&mut self, index: WhiskerIndex) {
        if self.head.touch_tests.wall && self.whiskers[index].rare.length_test.is_none() {
            self.want_test(index, TestReason::Setpoint);
        }
    }

    fn want_test(&mut self, index: WhiskerIndex, reason: TestReason) {
        let whisker = &mut self.whiskers[index];
        let length_mm = whisker.filter.length().length.mm();
        let rare = whisker.rare.get_or_insert();
        let test = rare.length_test.get_or_insert_with(|| Box::new(LengthTest::new(length_mm)));
        (test.wanted, test.not_before) = (Some(reason), Micros::default());
    }
}

impl LengthTest {
    /// Distances from the base, mm, and number of contacts.
    fn plan(&self, kind: TestKind, reason: TestReason, length_mm: f64) -> (Vec<f64>, u16) {
        match (kind, reason) {
            (TestKind::Tip, _) => (Vec::new(), LENGTH_CONTACTS),
            (TestKind::Wall, TestReason::Setpoint) => {
                (RESPONSE_RATIOS.map(|ratio| ratio * length_mm).to_vec(), RESPONSE_CONTACTS)
            }
            (TestKind::Wall, TestReason::Suspicion | TestReason::Operator) => {
                (self.evidence.informative_mm(LENGTH_CONTACTS.into(), self.sd_mm), LENGTH_CONTACTS)
            }
        }
    }
}

impl crate::robot::Whisker {
    fn length_test_mut(&mut self) -> Option<&mut LengthTest> {
        self.rare.get_mut().and_then(|rare| rare.length_test.as_deref_mut())
    }

    fn in_flight(&self, key: CommandKey) -> Option<TestInFlight> {
        self.rare.length_test.as_ref().and_then(|test| test.in_flight).filter(|test| test.key == key)
    }

    fn in_flight_mut(&mut self) -> Option<&mut TestInFlight> {
        self.length_test_mut().and_then(|test| test.in_flight.as_mut())
    }
}
