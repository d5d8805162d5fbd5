//! Touch tests: accepted under the rules of setpoints, done one contact per tick, answered.

use vibrissa_protocol::{MissedTouch, RobotTopic, TouchTest, TouchTestError, TouchTestKind, TouchTestOutcome, encode};
use vibrissa_robot::contract::{TestAnswer, TestVerdict};

use super::timers::contact_of;
use super::{Outgoing, Robot};
use crate::places::Places;
use crate::scenario::Misbehaviour;

/// A test that the robot is doing.
#[derive(Debug)]
pub(super) struct UnderWay {
    test: TouchTest,
    whisker: usize,
    /// Touches so far, those that did not come included.
    touches: u16,
}

impl Robot {
    /// Accepts or rejects a touch test. A repeated one is answered again and not done again.
    pub(super) fn touch_test(&mut self, test: TouchTest, now_us: u64, out: &mut Vec<Outgoing>) {
        let at = self.places.get(&(test.array.clone(), test.whisker)).copied();
        match (self.decide_test(&test, at, now_us), at) {
            (TestVerdict::Take, Some(whisker)) => {
                let accepted = TestAnswer::plain(TouchTestOutcome::Accepted);
                self.answer_test(&test.test_id, accepted, now_us, out);
                self.tests_under_way.push_back(UnderWay { test, whisker, touches: 0 });
            }
            (TestVerdict::Again(answer), _) => self.answer_test(&test.test_id, answer, now_us, out),
            (TestVerdict::Reject(error), _) => {
                self.answer_test(&test.test_id, TestAnswer::rejected(error), now_us, out);
            }
            // Only a test of an existing whisker is accepted.
            (TestVerdict::Take, None) => {
                let error = TouchTestError::UnknownWhisker;
                self.answer_test(&test.test_id, TestAnswer::rejected(error), now_us, out);
            }
        }
    }

    /// Makes the next touch of each test under way.
    pub(super) fn follow_tests(&mut self, at_us: u64, out: &mut Vec<Outgoing>) {
        if self.tests_under_way.is_empty() || !self.connected {
            return;
        }
        for mut one in std::mem::take(&mut self.tests_under_way) {
            if one.touches == 0 {
                self.answer_test(&one.test.test_id, TestAnswer::plain(TouchTestOutcome::Running), at_us, out);
            }
            if !self.breaks(Misbehaviour::TestsWithoutTouch) {
                self.touch_on_request(&one, at_us);
            }
            one.touches += 1;
            if one.touches < one.test.contacts {
                self.tests_under_way.push_back(one);
                continue;
            }
            // The contacts are sent before the end of their test.
            self.flush(at_us, out);
            self.answer_test(&one.test.test_id, TestAnswer::plain(TouchTestOutcome::Done), at_us, out);
        }
    }

    fn touch_on_request(&mut self, one: &UnderWay, at_us: u64) {
        let test = &one.test;
        let turn = |list: &[f64]| list.get(usize::from(one.touches) % list.len().max(1)).copied();
        let factor = self.strain_factor(one.whisker);
        let whisker = &mut self.whiskers[one.whisker];
        let pressure_mpa = whisker.regulator.pressure_mpa();
        let distance_mm = turn(&test.distances_mm).filter(|_| test.kind == TouchTestKind::Wall);
        let felt = whisker.plant.touch_on_request(distance_mm, turn(&test.deflections_mm), pressure_mpa);
        let test_id = Some(test.test_id.clone());
        match (felt, distance_mm) {
            (Ok(Some((reading, touch))), _) => {
                let mut contact = contact_of(whisker, &reading, at_us);
                contact.test_id = test_id;
                contact.strain *= factor;
                let places = if test.kind == TouchTestKind::Tip { Places::TipDistance } else { Places::Distance };
                places.state(&mut contact, &touch, whisker.estimated_mm);
                self.batch.push(contact);
            }
            (Ok(None), Some(distance_mm)) => self.missed.push(MissedTouch {
                array: test.array.clone(),
                whisker: test.whisker,
                t_us: at_us,
                distance_mm,
                distance_sd_mm: Some(whisker.plant.distance_sd_mm()),
                test_id,
            }),
            // A touch on the chamber gives no strain.
            (Ok(None), None) | (Err(_), _) => {}
        }
    }

    fn answer_test(&mut self, test_id: &str, answer: TestAnswer, now_us: u64, out: &mut Vec<Outgoing>) {
        self.touch_tests.remember(test_id, answer);
        let state = self.voice.test_state(test_id, answer, now_us);
        self.publish(RobotTopic::TestState, encode(&state), out);
    }
}
