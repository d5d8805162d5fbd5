//! Rows of touch tests, and the touches that robots send for them.

use std::collections::BTreeMap;

use vibrissa_core::robot::effect::{ProposedTest, TestState, TouchTest};
use vibrissa_core::units::Micros;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::ids::command_id;
use vibrissa_edge::words::Word;
use vibrissa_protocol::{self as protocol, Name};
use vibrissa_store::batch::{Record, TouchTestProgressRow, TouchTestRow};
use vibrissa_store::events::write::EventRow;

use super::stepper::Stepper;
use crate::engine::robot::KnownRobot;
use crate::events::{Parts, TouchTestPart, event};

pub(super) fn test_row(robot_id: i64, fleet: &Name, robot: &Name, test: &TouchTest, whisker_id: i64) -> TouchTestRow {
    TouchTestRow {
        test_id: command_id(fleet, robot, test.key),
        robot_id,
        whisker_id,
        kind: test.kind.word(),
        reason: test.reason.word(),
        contacts: test.contacts.into(),
        state: TestState::Pending.word(),
        requested_us: test.issued.0 as i64,
    }
}

pub(super) fn proposed_test_row(
    (robot_id, whisker_id): (i64, i64),
    proposed_us: i64,
    fleet: &Name,
    robot: &Name,
    test: &ProposedTest,
) -> TouchTestRow {
    TouchTestRow {
        test_id: command_id(fleet, robot, test.key),
        robot_id,
        whisker_id,
        kind: test.kind.word(),
        reason: test.reason.word(),
        contacts: test.contacts.into(),
        state: TestState::Proposed.word(),
        requested_us: proposed_us,
    }
}

/// Progress without a new state or touches.
pub(super) fn progress_row(robot_id: i64, test_id: String, updated_us: i64) -> TouchTestProgressRow {
    TouchTestProgressRow {
        test_id,
        robot_id,
        updated_us,
        state: None,
        error: None,
        ended_us: None,
        touches: 0,
        missed: 0,
        length_mm: None,
        length_sd_mm: None,
    }
}

/// Whether a test in this state has ended.
pub(super) fn is_over(state: TestState) -> bool {
    match state {
        TestState::Pending | TestState::Accepted | TestState::Running | TestState::Proposed => false,
        TestState::Done
        | TestState::Rejected
        | TestState::Failed
        | TestState::Expired
        | TestState::Abandoned
        | TestState::Withdrawn
        | TestState::Refused => true,
    }
}

impl Stepper {
    /// Progress of the tests under way by the touches of a message. Touches of other tests are not counted, so a robot can
    /// cause no more rows than it has tests.
    pub(super) fn test_progress(
        &self,
        known: &KnownRobot,
        message: &protocol::Contacts,
        now: Micros,
    ) -> Vec<(Option<i64>, TouchTestProgressRow)> {
        let touches = message.contacts.iter().filter_map(|one| Some((one.test_id.as_deref()?, 1, 0)));
        let missed = message.missed.iter().filter_map(|one| Some((one.test_id.as_deref()?, 0, 1)));
        let mut counts: BTreeMap<&str, (i64, i64)> = BTreeMap::new();
        for (test_id, touches, missed) in touches.chain(missed) {
            let count = counts.entry(test_id).or_default();
            *count = (count.0 + touches, count.1 + missed);
        }
        if counts.is_empty() {
            return Vec::new();
        }
        let progress = known.robot.tests_under_way().filter_map(|(test, whisker)| {
            let test_id = command_id(&self.fleet, &known.name, test);
            let (touches, missed) = counts.get(test_id.as_str()).copied()?;
            let whisker_id = Some(known.whisker_id(whisker));
            let row = progress_row(known.robot_id, test_id, now.0 as i64);
            Some((whisker_id, TouchTestProgressRow { touches, missed, ..row }))
        });
        progress.collect()
    }

    pub(super) fn record_progress(&mut self, progress: Vec<(Option<i64>, TouchTestProgressRow)>) {
        for (whisker_id, row) in progress {
            let part =
                TouchTestPart { test_id: row.test_id.clone(), state: None, touches: row.touches, missed: row.missed };
            let parts = Parts { touch_test: Some(part), ..Parts::default() };
            let entry = event(EventKind::TouchTest, row.updated_us, &parts).of_robot(row.robot_id);
            self.batch.rows_mut().events.push(EventRow { whisker_id, ..entry });
            self.batch.rows_mut().records.push(Record::TouchTestProgress(Box::new(row)));
        }
    }
}
