//! Answers to the touch tests of a recording.
//!
//! A recording contains the original supervisor's requests, with its own test IDs, and the robots' answers to them. A test
//! of the replay gets the answers to the recorded tests of the same whisker. If none was recorded, it expires.

use std::collections::VecDeque;

use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::CommandKey;
use vibrissa_protocol::{TestState, TouchTest};

/// Number of recorded tests remembered per robot.
const REMEMBERED: usize = 64;

/// The newest recorded tests of one robot.
#[derive(Debug, Default)]
pub(super) struct RecordedTests {
    /// Test ID, array and whisker of each.
    tests: VecDeque<(String, String, u16)>,
}

impl RecordedTests {
    /// Notes a request of the recorded supervisor.
    pub(super) fn recorded(&mut self, test: &TouchTest) {
        if self.tests.len() >= REMEMBERED {
            self.tests.pop_front();
        }
        self.tests.push_back((test.test_id.clone(), test.array.to_string(), test.whisker));
    }

    /// The test of the replay to which a recorded answer belongs.
    pub(super) fn answered(&self, state: &TestState, robot: &Robot) -> Option<CommandKey> {
        let (_, array, whisker) = self.tests.iter().find(|(test_id, ..)| *test_id == state.test_id)?;
        let index = robot.find(array, *whisker)?;
        robot.tests_under_way().find(|(_, of)| *of == index).map(|(test, _)| test)
    }
}
