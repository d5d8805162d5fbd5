//! Requests of touch tests, and the robot's answers.

use crate::policy::Mode;
use crate::robot::Robot;
use crate::robot::action::{ActionProblem, Place};
use crate::robot::effect::{
    CommandKey, Effect, ProposedTest, TestKind, TestReason, TestState, TouchTest, WhiskerIndex,
};
use crate::robot::event::{Rejection, TestReport};
use crate::robot::params::Params;
use crate::robot::touch_tests::{LengthTest, TestInFlight};
use crate::units::Micros;

/// Contacts of a test of the length. The next test of the same measurement is planned with them.
const LENGTH_CONTACTS: u16 = 10;
/// The same of a test that measures more than whether there is a cut, where one gain follows from the length.
const MEASURING_CONTACTS: u16 = 30;
/// Contacts of a test after a setpoint, over the whole range of contact ratios.
const RESPONSE_CONTACTS: u16 = 36;
/// Contact ratios of a test after a setpoint. At the tip itself half of the touches would miss, and the others lie off it.
const RESPONSE_RATIOS: [f64; 6] = [0.5, 0.6, 0.7, 0.8, 0.9, 0.97];
/// Deflections of a test, mm: weak ones and those that most contacts have.
const DEFLECTIONS_MM: [f64; 3] = [1.0, 2.0, 3.0];

/// Least distance of a test, mm: the contract has no touch at the base.
const LEAST_DISTANCE_MM: f64 = 1.0;

/// Time in which messages arrive that waited while the supervisor was deaf.
const HEARD_AFTER_DEAFNESS: Micros = Micros(10_000_000);

/// Origin of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asking {
    /// The supervisor, which only proposes it in mode ADVISE.
    ByItself,
    /// An operator, whom no mode and no pause delays.
    ForAnOperator,
}

impl Robot {
    /// Requests a touch test of a whisker, if one is wanted and the robot can do it now.
    pub(in crate::robot) fn request_test(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        effects: &mut Vec<Effect>,
    ) {
        if self.whiskers[index].rare.length_test.is_some() {
            self.ask_for_test(params, now, index, Asking::ByItself, effects);
        }
    }

    /// Requests a wanted test, or proposes it in mode ADVISE. Returns whether it was requested.
    fn ask_for_test(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        asking: Asking,
        effects: &mut Vec<Effect>,
    ) -> bool {
        let whisker = &self.whiskers[index];
        let Some(test) = whisker.rare.length_test.as_ref() else { return false };
        let Some(reason) = test.wanted.filter(|_| test.under_way().is_none()) else { return false };
        let waits = now < test.not_before && test.not_before.since(now) <= params.touch_tests.pause;
        let waits = (waits || test.is_refused()) && asking == Asking::ByItself;
        if waits || !self.can_begin_test(params, now, index) {
            return false;
        }
        let kind = match (reason, self.head.touch_tests.tip, self.head.touch_tests.wall) {
            (TestReason::Setpoint, _, true) => TestKind::Wall,
            (
                TestReason::Suspicion
                | TestReason::Operator
                | TestReason::Pause
                | TestReason::Schedule
                | TestReason::Change,
                false,
                true,
            ) => TestKind::Wall,
            (_, true, _) => TestKind::Tip,
            (_, false, false) => return false,
        };
        // An operator who has started a test has started its row.
        let may_ask = asking == Asking::ForAnOperator || reason == TestReason::Operator || test.done > 0;
        if !may_ask && params.policy.mode == Mode::Advise {
            self.propose_test(params, now, index, (kind, reason), effects);
            return false;
        }
        let (Some(robot_time), Some(boot_id)) = (self.head.clock.robot_time(now), &self.head.boot_id) else {
            return false;
        };
        let robot_boot_id = boot_id.as_str().to_owned();
        let mut budget = self.head.tests;
        if !budget.take(now, params.touch_tests.per_hour) {
            return false;
        }
        self.head.tests = budget;
        self.withdraw_test(now, index, effects);
        let key = self.next_key();
        let Some((distances_mm, contacts)) = self.whiskers[index].plan_touches(
            params,
            kind,
            reason,
            (self.needs_exact_length(index), self.length_contacts(params, index)),
        ) else {
            return false;
        };
        let Some(test) = self.whiskers[index].length_test_mut() else { return false };
        let valid_for = params.command.time_to_live;
        let takes = Micros(params.touch_tests.contact_time.0.saturating_mul(contacts.into()));
        let until = now.after(valid_for).after(takes);
        test.in_flight = Some(TestInFlight { key, kind, reason, state: TestState::Pending, until });
        let deflections_mm = if kind == TestKind::Wall { DEFLECTIONS_MM.to_vec() } else { Vec::new() };
        self.note_test(now, index);
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
        true
    }

    /// Whether nothing keeps the robot from a touch test of a whisker now.
    pub(super) fn can_begin_test(&self, params: &Params, now: Micros, index: WhiskerIndex) -> bool {
        !self.holds(index) && self.whiskers[index].command.is_none() && self.can_be_told(params, now)
    }

    fn next_key(&mut self) -> CommandKey {
        let key = CommandKey { epoch: self.head.epoch, version: self.head.next_version };
        self.head.next_version += 1;
        key
    }

    /// Contacts of the next test of its length or of its zero. Where a gain follows from the length, each one but the first, which
    /// finds a cut, measures.
    fn length_contacts(&self, params: &Params, index: WhiskerIndex) -> u16 {
        let whisker = &self.whiskers[index];
        let is_again = whisker.rare.length_test.as_ref().is_some_and(|test| test.done > 0);
        let is_of_zero = whisker.is_test_of_zero(params, true);
        if self.needs_exact_length(index) && (is_again || is_of_zero) { MEASURING_CONTACTS } else { LENGTH_CONTACTS }
    }

    /// Proposes a test, once.
    fn propose_test(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        (kind, reason): (TestKind, TestReason),
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &self.whiskers[index];
        if whisker.rare.length_test.as_ref().is_none_or(|test| test.in_flight.is_some()) {
            return;
        }
        let Some((_, contacts)) = whisker.plan_touches(
            params,
            kind,
            reason,
            (self.needs_exact_length(index), self.length_contacts(params, index)),
        ) else {
            return;
        };
        let key = self.next_key();
        if let Some(test) = self.whiskers[index].length_test_mut() {
            let (state, until) = (TestState::Proposed, Micros(u64::MAX));
            test.in_flight = Some(TestInFlight { key, kind, reason, state, until });
        }
        self.note_test(now, index);
        effects.push(Effect::TestProposed(ProposedTest { key, whisker: index, kind, contacts, reason }));
    }

    /// Withdraws the proposal of a test, because it is requested or not needed any more.
    fn withdraw_test(&mut self, now: Micros, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        if self.whiskers[index].rare.length_test.as_ref().is_some_and(|test| test.proposal().is_some()) {
            self.end_test(now, index, TestState::Withdrawn, None, Micros::default(), effects);
        }
    }

    /// Gives up a test without an answer or an end, and withdraws a proposal without a reason. The end of a test may have
    /// come while the supervisor was deaf: it is waited for a little longer.
    pub(in crate::robot) fn follow_test(&mut self, now: Micros, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let is_heard_again = now.since(self.head.listening_since) > HEARD_AFTER_DEAFNESS;
        let Some(test) = self.whiskers[index].rare.length_test.as_ref() else { return };
        if test.proposal().is_some() && test.is_only_followed() {
            return self.withdraw_test(now, index, effects);
        }
        if let Some(test) = test.under_way().filter(|test| is_heard_again && now > test.until) {
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
            TestReport::Done => {
                self.test_done(params, now, index, effects);
                self.measure_test(params, index, effects);
            }
            TestReport::Failed => self.end_test(now, index, TestState::Failed, None, pause, effects),
            TestReport::Rejected(rejection) => {
                let wait = match rejection {
                    Rejection::NotReady | Rejection::Expired => params.command.time_to_live,
                    Rejection::Stale
                    | Rejection::OutOfRange
                    | Rejection::UnknownWhisker
                    | Rejection::WrongBoot
                    | Rejection::InTask => pause,
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
            effects.push(Effect::TestState { test: test.key, whisker: Some(index), state, rejection: None });
        }
    }

    /// A robot has done a test. Unless it decided, another one follows at once, up to a number in a row; then after a
    /// pause.
    fn test_done(&mut self, params: &Params, now: Micros, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let is_followed = self.whiskers[index].rare.length_test.as_ref().is_some_and(|test| test.is_only_followed());
        self.end_test(now, index, TestState::Done, None, Micros::default(), effects);
        let Some(test) = self.whiskers[index].length_test_mut().filter(|_| !is_followed) else { return };
        test.done = test.done.saturating_add(1);
        let is_for_length = test.wanted != Some(TestReason::Setpoint);
        if !self.learn_zero(params, index) {
            self.judge_length(params, index, effects);
        }
        if is_for_length {
            self.narrow_doubt(params, index);
        }
        let Some(test) = self.whiskers[index].length_test_mut() else { return };
        if !is_for_length {
            test.wanted = None;
        } else if test.done >= params.touch_tests.in_a_row {
            (test.done, test.not_before) = (0, now.after(params.touch_tests.pause));
            test.wanted.take_if(|reason| *reason != TestReason::Suspicion);
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
        let is_followed = test.is_only_followed();
        let Some(ended) = test.in_flight.take() else { return };
        if !is_followed {
            test.not_before = now.after(wait);
        }
        let could_be_done = matches!(state, TestState::Done | TestState::Withdrawn);
        if !could_be_done && matches!(ended.reason, TestReason::Pause | TestReason::Schedule) {
            // The whisker is due again after the next pause or interval.
            test.wanted.take_if(|reason| *reason == ended.reason);
        }
        if test.wanted.is_none() && (is_followed || test.contacts == 0) {
            self.whiskers[index].end_measurement();
        }
        effects.push(Effect::TestState { test: ended.key, whisker: Some(index), state, rejection });
    }

    /// Tests that were under way in a boot that is no more. They are requested again.
    pub(in crate::robot) fn abandon_tests(&mut self, effects: &mut Vec<Effect>) {
        for index in 0..self.whiskers.len() {
            if self.whiskers[index].rare.length_test.as_ref().is_some_and(|test| test.under_way().is_some()) {
                self.end_test(Micros::default(), index, TestState::Abandoned, None, Micros::default(), effects);
            }
        }
    }

    /// An operator asks for a test, or starts a proposed one.
    pub(in crate::robot) fn test_by_hand(
        &mut self,
        params: &Params,
        now: Micros,
        place: Place<'_>,
        effects: &mut Vec<Effect>,
    ) -> Result<(), ActionProblem> {
        let index = self.at(place)?;
        if !self.head.touch_tests.tip && !self.head.touch_tests.wall {
            return Err(ActionProblem::NoTouchTests);
        }
        if self.holds(index) {
            return Err(ActionProblem::TestOfHeld);
        }
        let test = self.whiskers[index].rare.length_test.as_ref();
        if test.is_some_and(|test| test.under_way().is_some()) {
            return Err(ActionProblem::TestUnderWay);
        }
        let is_proposed = test.is_some_and(|test| test.proposal().is_some());
        if !is_proposed {
            self.want_test(index, TestReason::Operator);
        }
        if !self.ask_for_test(params, now, index, Asking::ForAnOperator, effects) {
            // The request follows when the robot is back, its setpoint is applied, or the limit allows it.
            self.want_test(index, TestReason::Operator);
        }
        Ok(())
    }

    /// An operator refuses a proposed test. Silence goes on being suspected, and the refused test stays noted, so that it is
    /// not proposed again. All other reasons are gone with their proposal.
    pub(in crate::robot) fn refuse_test(
        &mut self,
        now: Micros,
        place: Place<'_>,
        effects: &mut Vec<Effect>,
    ) -> Result<(), ActionProblem> {
        let index = self.at(place)?;
        let test = self.whiskers[index].length_test_mut();
        let proposed = test.and_then(|test| test.proposal()).ok_or(ActionProblem::NoProposedTest)?;
        if proposed.reason != TestReason::Suspicion
            && let Some(test) = self.whiskers[index].length_test_mut()
        {
            test.wanted.take_if(|reason| *reason == proposed.reason);
        }
        self.end_test(now, index, TestState::Refused, None, Micros::default(), effects);
        if proposed.reason == TestReason::Suspicion
            && let Some(test) = self.whiskers[index].length_test_mut()
        {
            test.in_flight = Some(TestInFlight { state: TestState::Refused, ..proposed });
        }
        Ok(())
    }

    /// A setpoint of a compensation was applied: its error is to be measured.
    pub(in crate::robot) fn test_after_setpoint(&mut self, index: WhiskerIndex) {
        let is_free = self.whiskers[index].rare.length_test.as_ref().is_none_or(|test| test.is_only_followed());
        if self.head.touch_tests.wall && is_free {
            self.want_test(index, TestReason::Setpoint);
        }
    }

    pub(super) fn want_test(&mut self, index: WhiskerIndex, reason: TestReason) {
        let whisker = &mut self.whiskers[index];
        let length_mm = whisker.filter.length().length.mm();
        let rare = whisker.rare.get_or_insert();
        let test = rare.length_test.get_or_insert_with(|| Box::new(LengthTest::new(length_mm)));
        (test.wanted, test.not_before) = (Some(reason), Micros::default());
    }
}

impl crate::robot::Whisker {
    /// Distances from the base by the robot's own millimetres, and number of contacts.
    fn plan_touches(
        &self,
        params: &Params,
        kind: TestKind,
        reason: TestReason,
        (alone, length_contacts): (bool, u16),
    ) -> Option<(Vec<f64>, u16)> {
        let test = self.rare.length_test.as_ref()?;
        let (off_mm, zero_sd_mm) = self.zero(params);
        let contacts =
            if (kind, reason) == (TestKind::Wall, TestReason::Setpoint) { RESPONSE_CONTACTS } else { length_contacts };
        let true_mm = match (kind, reason) {
            (TestKind::Tip, _) => Vec::new(),
            (TestKind::Wall, TestReason::Setpoint) => {
                let length_mm = self.filter.length().length.mm();
                RESPONSE_RATIOS.map(|ratio| ratio * length_mm).to_vec()
            }
            (TestKind::Wall, _) if self.is_test_of_zero(params, alone) => {
                test.evidence.informative_of_zero_mm(contacts.into(), zero_sd_mm)
            }
            (
                TestKind::Wall,
                TestReason::Suspicion
                | TestReason::Operator
                | TestReason::Pause
                | TestReason::Schedule
                | TestReason::Change,
            ) => test.evidence.informative_mm(contacts.into(), test.sd_mm, zero_sd_mm),
        };
        let stated = |true_mm: f64| (true_mm - off_mm).max(LEAST_DISTANCE_MM);
        Some((true_mm.into_iter().map(stated).collect(), contacts))
    }

    /// The end of its test when the whisker leaves the robot or another one takes its place.
    pub(in crate::robot) fn abandoned_test(&self, whisker: Option<WhiskerIndex>) -> Option<Effect> {
        let test = self.rare.length_test.as_ref().and_then(|test| test.in_flight)?;
        if test.state == TestState::Refused {
            return None;
        }
        let state = if test.state == TestState::Proposed { TestState::Withdrawn } else { TestState::Abandoned };
        Some(Effect::TestState { test: test.key, whisker, state, rejection: None })
    }

    fn length_test_mut(&mut self) -> Option<&mut LengthTest> {
        self.rare.get_mut().and_then(|rare| rare.length_test.as_deref_mut())
    }

    /// Whether a requested test has not ended in time.
    pub(in crate::robot) fn has_overdue_test(&self, now: Micros) -> bool {
        let test = self.rare.length_test.as_ref().and_then(|test| test.under_way());
        test.is_some_and(|test| now > test.until)
    }

    fn in_flight(&self, key: CommandKey) -> Option<TestInFlight> {
        self.rare.length_test.as_ref().and_then(|test| test.under_way()).filter(|test| test.key == key)
    }

    fn in_flight_mut(&mut self) -> Option<&mut TestInFlight> {
        self.length_test_mut().and_then(|test| test.in_flight.as_mut())
    }
}
