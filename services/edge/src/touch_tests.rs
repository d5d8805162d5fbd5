//! Touch tests in the words of the contract.

use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::TouchTest;
use vibrissa_core::robot::event::{Rejection, TestReport};
use vibrissa_protocol::{self as protocol, BootId, Name, RequestKind, Timestamp};

use crate::contract::{touch_test_kind, touch_test_reason};

/// The request for a touch test of one of the robot's whiskers; `None` if the robot has no such whisker.
#[must_use]
pub fn request(
    robot: &Robot,
    test: &TouchTest,
    test_id: String,
    (boot_id, seq): (BootId, u64),
) -> Option<protocol::Request> {
    let whisker = robot.whisker(test.whisker)?;
    let touch_test = protocol::TouchTest {
        test_id,
        epoch: test.key.epoch,
        version: test.key.version,
        robot_boot_id: BootId::new(&test.robot_boot_id).ok()?,
        array: Name::new(whisker.array).ok()?,
        whisker: whisker.sheet.number,
        kind: touch_test_kind(test.kind),
        distances_mm: test.distances_mm.iter().map(|mm| rounded(*mm)).collect(),
        deflections_mm: test.deflections_mm.clone(),
        contacts: test.contacts,
        issued: Timestamp(test.issued.0),
        expires_us: test.expires.0,
        reason: touch_test_reason(test.reason),
    };
    Some(protocol::Request { boot_id, seq, request: RequestKind::TouchTest, touch_test: Some(touch_test) })
}

/// No robot touches more exactly than to a hundredth of a millimetre.
fn rounded(mm: f64) -> f64 {
    (mm * 100.0).round() / 100.0
}

/// Progress or result of a touch test.
#[must_use]
pub fn report(state: &protocol::TestState) -> TestReport {
    use protocol::TouchTestError as Told;
    match state.state {
        protocol::TouchTestOutcome::Accepted => TestReport::Accepted,
        protocol::TouchTestOutcome::Running => TestReport::Running,
        protocol::TouchTestOutcome::Done => TestReport::Done,
        protocol::TouchTestOutcome::Failed => TestReport::Failed,
        protocol::TouchTestOutcome::Rejected => TestReport::Rejected(match state.error {
            Some(Told::Stale) => Rejection::Stale,
            Some(Told::Expired) => Rejection::Expired,
            Some(Told::UnknownWhisker) => Rejection::UnknownWhisker,
            Some(Told::WrongBoot) => Rejection::WrongBoot,
            Some(Told::InTask) => Rejection::InTask,
            Some(Told::NotReady) | None => Rejection::NotReady,
        }),
    }
}
