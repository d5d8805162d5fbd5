//! Setpoints, touch tests and estimates from the supervisor, and its loss.

use vibrissa_protocol::{
    Estimate, RobotTopic, Setpoint, SetpointError, SetpointOutcome, TouchTest, TouchTestError, TouchTestOutcome, encode,
};

use super::motion::WAIT_US;
use super::{Agent, Output};
use crate::contract::supervision::pressure_without;
use crate::contract::{Addressee, CommandAnswer, Moment, Now, Response, TestAnswer, TestVerdict, Tested, Verdict};
use crate::driver::ToDriver;
use crate::store::Record;

/// Time that a driver has for a touch test, and for each of its touches, in microseconds.
const TEST_US: u64 = 30_000_000;
const TOUCH_US: u64 = 5_000_000;

/// Time after which no touch of a test that the driver has done comes any more, in microseconds: its strain may come late, and
/// wait for its motion.
const LAST_TOUCH_US: u64 = 2 * WAIT_US;

/// A touch test that the driver is doing.
#[derive(Debug)]
pub(super) struct UnderWay {
    pub(super) test_id: String,
    pub(super) whisker: usize,
    pub(super) until: Moment,
    pub(super) is_running: bool,
    /// The driver has done it. Strain of its last touches may still be on its way, until `until`.
    pub(super) is_done: bool,
    /// The driver that does it, once one has said so.
    pub(super) driver: Option<usize>,
    /// Touches that may still come.
    pub(super) touches_left: u16,
}

impl UnderWay {
    fn is_over(&self, now: Now) -> bool {
        self.until <= now.at || (self.is_done && self.touches_left == 0)
    }
}

impl Agent {
    /// Decides about a setpoint. This is the only way to a new pressure, besides the loss of the supervisor.
    pub(super) fn setpoint(&mut self, setpoint: &Setpoint, now: Now, out: &mut Vec<Output>) {
        let at = self.places.get(&(setpoint.array.clone(), setpoint.whisker)).copied();
        let before = at.and_then(|at| self.chambers[at].seen);
        let addressee = at
            .map(|at| &mut self.chambers[at])
            .map(|chamber| Addressee { pressure_max_mpa: chamber.max_mpa, seen: &mut chamber.seen });
        let verdict = self.commands.judge(setpoint, self.voice.boot_id(), now.stamp_us, addressee);
        self.note_seen(at, before, out);
        let id = setpoint.command_id.as_str();
        match (verdict, at) {
            (Verdict::Take, Some(at)) if !self.is_held(at) => {
                self.answer(id, Some(at), CommandAnswer::rejected(SetpointError::NotReady), now, out);
            }
            (Verdict::Take, Some(at)) if self.is_in_task() => {
                self.answer(id, Some(at), CommandAnswer::rejected(SetpointError::InTask), now, out);
            }
            (Verdict::Take, Some(at)) => self.take(setpoint, at, now, out),
            (Verdict::Again(answer), _) => self.answer(id, at, answer, now, out),
            (Verdict::Reject(error), _) => self.answer(id, at, CommandAnswer::rejected(error), now, out),
            // Only a setpoint for an existing whisker is accepted.
            (Verdict::Take, None) => {
                self.answer(id, at, CommandAnswer::rejected(SetpointError::UnknownWhisker), now, out);
            }
        }
    }

    /// Stores an order that is higher than all before it.
    fn note_seen(&self, at: Option<usize>, before: Option<(u64, u64)>, out: &mut Vec<Output>) {
        let Some(chamber) = at.map(|at| &self.chambers[at]) else { return };
        if let Some((epoch, version)) = chamber.seen.filter(|_| chamber.seen != before) {
            let (array, whisker) = (chamber.array.clone(), chamber.number);
            out.push(Output::Store(Record::Seen { array, whisker, epoch, version }));
        }
    }

    fn take(&mut self, setpoint: &Setpoint, at: usize, now: Now, out: &mut Vec<Output>) {
        let id = setpoint.command_id.as_str();
        self.answer(id, Some(at), CommandAnswer::plain(SetpointOutcome::Received), now, out);
        self.supersede(at, now, out);
        if let Some(other) = self.chambers[at].ends_fault(setpoint) {
            self.tell(at, &other, out);
        }
        self.chambers[at].apply(setpoint, now);
        self.tell_pressure(at, now, out);
        self.answer(id, Some(at), CommandAnswer::plain(SetpointOutcome::Applying), now, out);
    }

    fn supersede(&mut self, at: usize, now: Now, out: &mut Vec<Output>) {
        if let Some(replaced) = self.chambers[at].applying.take() {
            let answer = CommandAnswer::plain(SetpointOutcome::Superseded);
            self.answer(&replaced.command_id, Some(at), answer, now, out);
        }
    }

    fn answer(&mut self, id: &str, at: Option<usize>, answer: CommandAnswer, now: Now, out: &mut Vec<Output>) {
        self.commands.remember(id, answer);
        if !self.connected {
            return;
        }
        let pressure_mpa = at.and_then(|at| self.chambers[at].present_reading()).map(|reading| reading.pressure_mpa);
        let state = self.voice.setpoint_state(id, answer, now.stamp_us, pressure_mpa);
        self.publish(RobotTopic::SetpointState, encode(&state), out);
    }

    /// Tells the drivers of a whisker what to hold.
    pub(super) fn tell_pressure(&mut self, at: usize, now: Now, out: &mut Vec<Output>) {
        self.chambers[at].sent_at = now.at;
        self.tell(at, &self.chambers[at].set_pressure(), out);
        self.tell_gain(at, out);
    }

    /// Tells the drivers the factor on the readings, if they apply gains. Older drivers do not know the line.
    pub(super) fn tell_gain(&self, at: usize, out: &mut Vec<Output>) {
        if self.facts.applies_gain {
            self.tell(at, &self.chambers[at].reading_gain(), out);
        }
    }

    /// Tells the drivers again what to hold, and the factor on their readings, so that they can notice a dead agent by
    /// its silence.
    pub(super) fn repeat_pressures(&mut self, now: Now, out: &mut Vec<Output>) {
        for at in 0..self.chambers.len() {
            let chamber = &self.chambers[at];
            if now.at >= chamber.sent_at + chamber.limits.repeat_us && self.is_served(at) {
                self.tell_pressure(at, now, out);
            }
        }
    }

    /// Moment of the next repetition.
    pub(super) fn repeat_at(&self) -> Option<Moment> {
        let served = (0..self.chambers.len()).filter(|&at| self.is_served(at));
        served.map(|at| self.chambers[at].sent_at + self.chambers[at].limits.repeat_us).min()
    }

    /// Reports setpoints that have been reached, and those that have failed.
    pub(super) fn follow_setpoints(&mut self, now: Now, out: &mut Vec<Output>) {
        for at in 0..self.chambers.len() {
            let chamber = &mut self.chambers[at];
            let Some(fails_at) = chamber.fails_at() else { continue };
            let (answer, id) = if chamber.is_settled() {
                (CommandAnswer::plain(SetpointOutcome::Applied), chamber.applied())
            } else if now.at >= fails_at {
                let error = Some(chamber.failure(now));
                let id = chamber.applying.take().map(|applying| applying.command_id);
                (CommandAnswer { outcome: SetpointOutcome::Failed, error }, id)
            } else {
                continue;
            };
            if answer.outcome == SetpointOutcome::Applied {
                self.tell_gain(at, out);
            }
            if let Some(id) = id {
                self.answer(&id, Some(at), answer, now, out);
            }
        }
    }

    /// Advice if no supervisor answers.
    pub(super) fn unanswered(&self) -> String {
        let fleet = &self.fleet;
        let receipts = RobotTopic::Receipt.of(fleet, &self.robot);
        format!(
            "no supervisor answers for fleet {fleet}: start one with this fleet, or let the robot read {receipts} in the broker's \
             access list"
        )
    }

    /// Behaves as the factsheet states after a long time without messages from the supervisor.
    pub(super) fn miss_supervisor(&mut self, now: Now, out: &mut Vec<Output>) {
        if !self.supervision.is_lost(now.at) {
            return;
        }
        for at in 0..self.chambers.len() {
            let nominal_mpa = self.chambers[at].nominal_mpa;
            let Some(target_mpa) = pressure_without(self.facts.on_supervisor_loss, nominal_mpa) else {
                return;
            };
            self.supersede(at, now, out);
            self.chambers[at].leave(target_mpa);
            if self.is_served(at) {
                self.tell_pressure(at, now, out);
            }
        }
    }

    /// Takes an estimate that is newer than all of this boot.
    pub(super) fn estimate(&mut self, estimate: &Estimate, out: &mut Vec<Output>) {
        self.chambers.iter_mut().for_each(|chamber| (chamber.estimate, chamber.response) = (None, None));
        for one in &estimate.whiskers {
            let Some(&at) = self.places.get(&(one.array.clone(), one.whisker)) else { continue };
            let line = ToDriver::Estimate {
                array: one.array.clone(),
                whisker: one.whisker,
                length_mm: one.length_mm,
                length_low_mm: one.length_low_mm,
                length_high_mm: one.length_high_mm,
                condition: one.condition,
                gain: one.gain.clone(),
            };
            let chamber = &mut self.chambers[at];
            chamber.estimate = Some(line.clone());
            chamber.response = Response::new(one.pressure_mpa, &one.response);
            let before = chamber.gain.factor();
            chamber.gain.estimated(one.pressure_mpa, one.reading_gain);
            let has_other_gain = chamber.gain.factor() != before;
            self.tell(at, &line, out);
            if has_other_gain {
                self.tell_gain(at, out);
            }
        }
    }

    /// Accepts or rejects a touch test. A repeated one is answered again and not done again.
    pub(super) fn touch_test(&mut self, test: TouchTest, now: Now, out: &mut Vec<Output>) {
        let at = self.places.get(&(test.array.clone(), test.whisker)).copied();
        let is_busy = self.under_way.iter().any(|one| Some(one.whisker) == at);
        let before = at.and_then(|at| self.chambers[at].seen);
        let is_there = at.is_some_and(|at| self.is_served(at));
        let is_in_task = self.is_in_task();
        let tested = at.map(|at| &mut self.chambers[at]).map(|chamber| Tested {
            is_ready: is_there && !is_busy && !is_in_task && chamber.applying.is_none(),
            seen: &mut chamber.seen,
            kinds: &self.facts.touch_tests,
        });
        let verdict = self.touch_tests.judge(&test, self.voice.boot_id(), now.stamp_us, tested);
        self.note_seen(at, before, out);
        match (verdict, at) {
            (TestVerdict::Take, Some(whisker)) => {
                self.answer_test(&test.test_id, TestAnswer::plain(TouchTestOutcome::Accepted), now, out);
                self.under_way.push_back(UnderWay {
                    test_id: test.test_id.clone(),
                    whisker,
                    until: now.at + TEST_US + TOUCH_US * u64::from(test.contacts),
                    is_running: false,
                    is_done: false,
                    driver: None,
                    touches_left: test.contacts,
                });
                let line = ToDriver::Test {
                    test_id: test.test_id,
                    array: test.array,
                    whisker: test.whisker,
                    kind: test.kind,
                    distances_mm: test.distances_mm,
                    deflections_mm: test.deflections_mm,
                    contacts: test.contacts,
                };
                self.tell(whisker, &line, out);
            }
            (TestVerdict::Reject(TouchTestError::NotReady), _) if is_in_task => {
                self.answer_test(&test.test_id, TestAnswer::rejected(TouchTestError::InTask), now, out);
            }
            (TestVerdict::Again(answer), _) => self.answer_test(&test.test_id, answer, now, out),
            (TestVerdict::Reject(error), _) => {
                self.answer_test(&test.test_id, TestAnswer::rejected(error), now, out);
            }
            // Only a test of an existing whisker is accepted.
            (TestVerdict::Take, None) => {
                let error = TouchTestError::UnknownWhisker;
                self.answer_test(&test.test_id, TestAnswer::rejected(error), now, out);
            }
        }
    }

    pub(super) fn answer_test(&mut self, test_id: &str, answer: TestAnswer, now: Now, out: &mut Vec<Output>) {
        self.touch_tests.remember(test_id, answer);
        if !self.connected {
            return;
        }
        let state = self.voice.test_state(test_id, answer, now.stamp_us);
        self.publish(RobotTopic::TestState, encode(&state), out);
    }

    /// The test has begun, if the driver has not said so before.
    pub(super) fn run_test(&mut self, at: usize, now: Now, out: &mut Vec<Output>) {
        if !std::mem::replace(&mut self.under_way[at].is_running, true) {
            let id = self.under_way[at].test_id.clone();
            self.answer_test(&id, TestAnswer::plain(TouchTestOutcome::Running), now, out);
        }
    }

    /// The driver has done a test. If the agent makes its contacts from strain, the last ones may still come.
    pub(super) fn test_done(&mut self, at: usize, now: Now, out: &mut Vec<Output>) {
        self.run_test(at, now, out);
        let test = &mut self.under_way[at];
        test.is_done = true;
        let may_come = self.chambers[test.whisker].stream.is_some();
        test.until = test.until.min(if may_come { now.at + LAST_TOUCH_US } else { now.at });
        self.follow_tests(now, out);
    }

    /// Ends a test; its contacts are sent before.
    pub(super) fn end_test(&mut self, at: usize, outcome: TouchTestOutcome, now: Now, out: &mut Vec<Output>) {
        self.run_test(at, now, out);
        self.flush(now, out);
        // Even if the driver goes while strain of the last touch is awaited.
        let outcome = if self.under_way[at].is_done { TouchTestOutcome::Done } else { outcome };
        if let Some(test) = self.under_way.remove(at) {
            self.answer_test(&test.test_id, TestAnswer::plain(outcome), now, out);
        }
    }

    /// Ends tests that the driver has done, and fails those that it does not end.
    pub(super) fn follow_tests(&mut self, now: Now, out: &mut Vec<Output>) {
        while let Some(at) = self.under_way.iter().position(|one| one.is_over(now)) {
            self.end_test(at, TouchTestOutcome::Failed, now, out);
        }
    }
}
