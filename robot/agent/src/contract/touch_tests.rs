//! Rules for accepting a touch test: those of setpoints, and a repeated one is answered again and not done again.

use std::collections::VecDeque;

use vibrissa_protocol::{BootId, TouchTest, TouchTestError, TouchTestKind, TouchTestOutcome};

/// Number of tests whose last answer is remembered.
const REMEMBERED: usize = 64;

/// Latest state of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TestAnswer {
    /// State of the test.
    pub outcome: TouchTestOutcome,
    /// Reason of a rejection.
    pub error: Option<TouchTestError>,
}

impl TestAnswer {
    /// An answer without an error.
    #[must_use]
    pub fn plain(outcome: TouchTestOutcome) -> Self {
        Self { outcome, error: None }
    }

    /// A rejection.
    #[must_use]
    pub fn rejected(error: TouchTestError) -> Self {
        Self { outcome: TouchTestOutcome::Rejected, error: Some(error) }
    }
}

/// Decision about a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestVerdict {
    /// Do it.
    Take,
    /// It was answered before: repeat the answer, do nothing.
    Again(TestAnswer),
    /// Reject it.
    Reject(TouchTestError),
}

/// The properties of the whisker that matter for the decision.
#[derive(Debug)]
pub struct Tested<'a> {
    /// Highest (epoch, version) seen for the whisker.
    pub seen: &'a mut Option<(u64, u64)>,
    /// Whether the whisker can be tested now: no setpoint is being applied.
    pub is_ready: bool,
    /// Tests that the robot can do.
    pub kinds: &'a [TouchTestKind],
}

/// Answers to the touch tests of one boot.
#[derive(Debug, Default)]
pub struct TouchTests {
    /// The last answer to each test, the oldest first.
    answers: VecDeque<(String, TestAnswer)>,
}

impl TouchTests {
    /// Decides about a test by the contract's rules; `tested` is `None` if the robot has no such whisker.
    pub fn judge(&self, test: &TouchTest, boot_id: &BootId, now_us: u64, tested: Option<Tested<'_>>) -> TestVerdict {
        if let Some((_, answer)) = self.answers.iter().find(|(id, _)| *id == test.test_id) {
            return TestVerdict::Again(*answer);
        }
        let Some(tested) = tested else {
            return TestVerdict::Reject(TouchTestError::UnknownWhisker);
        };
        // Checked before the order: a test for another boot must not change the highest order seen.
        if test.robot_boot_id != *boot_id {
            return TestVerdict::Reject(TouchTestError::WrongBoot);
        }
        let order = (test.epoch, test.version);
        if tested.seen.is_some_and(|seen| order <= seen) {
            return TestVerdict::Reject(TouchTestError::Stale);
        }
        *tested.seen = Some(order);
        if test.expires_us <= now_us {
            return TestVerdict::Reject(TouchTestError::Expired);
        }
        if tested.is_ready && tested.kinds.contains(&test.kind) {
            TestVerdict::Take
        } else {
            TestVerdict::Reject(TouchTestError::NotReady)
        }
    }

    /// Stores the latest state of a test.
    pub fn remember(&mut self, test_id: &str, answer: TestAnswer) {
        self.answers.retain(|(known, _)| known != test_id);
        self.answers.push_back((test_id.to_owned(), answer));
        if self.answers.len() > REMEMBERED {
            self.answers.pop_front();
        }
    }
}
