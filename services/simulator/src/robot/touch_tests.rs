//! Touch tests: accepted under the rules of setpoints, done one contact per tick, answered.

use std::collections::VecDeque;

use vibrissa_protocol::{
    MissedTouch, RobotTopic, TestState, TouchTest, TouchTestError, TouchTestKind, TouchTestOutcome, encode,
};

use super::timers::contact_of;
use super::{Outgoing, Robot};
use crate::places::Places;
use crate::scenario::Misbehaviour;

/// Number of tests whose last answer is remembered.
const REMEMBERED: usize = 64;

/// Touch tests of one boot.
#[derive(Debug, Default)]
pub(super) struct TouchTests {
    under_way: VecDeque<UnderWay>,
    /// The last answer to each test, the oldest first.
    answers: VecDeque<(String, TouchTestOutcome, Option<TouchTestError>)>,
}

#[derive(Debug)]
struct UnderWay {
    test: TouchTest,
    whisker: usize,
    /// Touches so far, those that did not come included.
    touches: u16,
}

impl Robot {
    /// Accepts or rejects a touch test. A repeated one is answered again and not done again.
    pub(super) fn touch_test(&mut self, test: TouchTest, now_us: u64, out: &mut Vec<Outgoing>) {
        let known = self.touch_tests.answers.iter().find(|(id, ..)| *id == test.test_id);
        if let Some((_, state, error)) = known.cloned() {
            return self.answer_test(&test.test_id, state, error, now_us, out);
        }
        match self.judge_test(&test, now_us) {
            Ok(whisker) => {
                self.answer_test(&test.test_id, TouchTestOutcome::Accepted, None, now_us, out);
                self.touch_tests.under_way.push_back(UnderWay { test, whisker, touches: 0 });
            }
            Err(error) => self.answer_test(&test.test_id, TouchTestOutcome::Rejected, Some(error), now_us, out),
        }
    }

    fn judge_test(&mut self, test: &TouchTest, now_us: u64) -> Result<usize, TouchTestError> {
        let at = self.places.get(&(test.array.clone(), test.whisker)).copied();
        let at = at.ok_or(TouchTestError::UnknownWhisker)?;
        if test.robot_boot_id != self.boot_id && !self.breaks(Misbehaviour::TestsForOtherBoots) {
            return Err(TouchTestError::WrongBoot);
        }
        let (order, seen) = ((test.epoch, test.version), &mut self.whiskers[at].seen);
        if seen.is_some_and(|seen| order <= seen) {
            return Err(TouchTestError::Stale);
        }
        *seen = Some(order);
        if test.expires_us <= now_us {
            return Err(TouchTestError::Expired);
        }
        let can = self.config.behaviour.touch_tests.contains(&test.kind);
        if can && self.whiskers[at].applying.is_none() { Ok(at) } else { Err(TouchTestError::NotReady) }
    }

    /// Makes the next touch of each test under way.
    pub(super) fn follow_tests(&mut self, at_us: u64, out: &mut Vec<Outgoing>) {
        if self.touch_tests.under_way.is_empty() || !self.connected {
            return;
        }
        for mut one in std::mem::take(&mut self.touch_tests.under_way) {
            if one.touches == 0 {
                self.answer_test(&one.test.test_id, TouchTestOutcome::Running, None, at_us, out);
            }
            if !self.breaks(Misbehaviour::TestsWithoutTouch) {
                self.touch_on_request(&one, at_us);
            }
            one.touches += 1;
            if one.touches < one.test.contacts {
                self.touch_tests.under_way.push_back(one);
                continue;
            }
            // The contacts are sent before the end of their test.
            self.flush(at_us, out);
            self.answer_test(&one.test.test_id, TouchTestOutcome::Done, None, at_us, out);
        }
    }

    fn touch_on_request(&mut self, one: &UnderWay, at_us: u64) {
        let test = &one.test;
        let turn = |list: &[f64]| list.get(usize::from(one.touches) % list.len().max(1)).copied();
        let whisker = &mut self.whiskers[one.whisker];
        let pressure_mpa = whisker.regulator.pressure_mpa();
        let distance_mm = turn(&test.distances_mm).filter(|_| test.kind == TouchTestKind::Wall);
        let felt = whisker.plant.touch_on_request(distance_mm, turn(&test.deflections_mm), pressure_mpa);
        let test_id = Some(test.test_id.clone());
        match (felt, distance_mm) {
            (Ok(Some((reading, touch))), _) => {
                let mut contact = contact_of(whisker, &reading, at_us);
                contact.test_id = test_id;
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

    fn answer_test(
        &mut self,
        test_id: &str,
        state: TouchTestOutcome,
        error: Option<TouchTestError>,
        now_us: u64,
        out: &mut Vec<Outgoing>,
    ) {
        let answers = &mut self.touch_tests.answers;
        answers.retain(|(known, ..)| known != test_id);
        answers.push_back((test_id.to_owned(), state, error));
        if answers.len() > REMEMBERED {
            answers.pop_front();
        }
        let (boot_id, seq) = (self.boot_id.clone(), self.sequences.test_state());
        let state = TestState { boot_id, seq, test_id: test_id.to_owned(), state, t_us: now_us, error };
        self.publish(RobotTopic::TestState, encode(&state), out);
    }
}
