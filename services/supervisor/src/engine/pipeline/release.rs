//! The last check of a publication before it leaves the engine: the transaction that made it is committed.

use vibrissa_edge::full_name::FullName;
use vibrissa_edge::invariants::{Invariant, is_committed};
use vibrissa_protocol::Name;
use vibrissa_store::fault::{self, Fault};

use crate::metrics::FleetMetrics;
use crate::outbox::{Publication, ToRobot};

/// Whether a publication may go out after the commit of the transaction `committed`. One that may not is counted as a violation:
/// robots would delete contacts that are not recorded, or apply setpoints that nobody knows.
pub(super) fn may_go_out(publication: &Publication, committed: i64, fleet: &Name, metrics: &FleetMetrics) -> bool {
    let number = publication.transaction;
    if is_committed(number, committed) {
        return true;
    }
    let robot = FullName::robot(fleet.as_str(), publication.robot.as_str());
    match &publication.message {
        ToRobot::Receipt(receipt) => {
            let (boot_id, next) = (&receipt.robot_boot_id, receipt.next);
            let what = format!("a receipt of boot {boot_id} below {next} in transaction {number} after {committed}");
            metrics.violations.count(Invariant::ReceiptAfterCommit, &robot, &what);
        }
        ToRobot::Setpoint(setpoint) => {
            let at = robot.whisker(setpoint.array.as_str(), setpoint.whisker);
            let what = format!("setpoint {} in transaction {number} after {committed}", setpoint.command_id);
            metrics.violations.count(Invariant::SetpointCommitted, &at, &what);
        }
        ToRobot::Request(_) | ToRobot::Estimate(_) | ToRobot::Maintenance(_) | ToRobot::Cleared(_) => {}
    }
    // A fault planted by a test publishes it nevertheless.
    fault::is(Fault::ReceiptBeforeCommit)
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::{self as protocol, BootId, RobotTopic};

    use super::*;
    use crate::metrics::Metrics;

    fn setpoint() -> protocol::Setpoint {
        protocol::Setpoint {
            boot_id: BootId::new("s").unwrap(),
            seq: 0,
            command_id: "c".to_owned(),
            epoch: 7,
            version: 1,
            robot_boot_id: BootId::new("b").unwrap(),
            array: Name::new("left").unwrap(),
            whisker: 3,
            pressure_mpa: 0.1,
            slew_mpa_per_s: 0.02,
            issued: protocol::Timestamp(1),
            expires_us: 2,
            reason: protocol::SetpointReason::Release,
            gain: Vec::new(),
            reading_gain: None,
        }
    }

    fn receipt() -> protocol::Receipt {
        let [boot_id, robot_boot_id] = ["s", "b"].map(|boot_id| BootId::new(boot_id).unwrap());
        protocol::Receipt { boot_id, seq: 0, robot_boot_id, next: 9, held: Vec::new() }
    }

    #[test]
    fn a_publication_before_its_commit_is_counted_and_kept_back() {
        let (fleet, robot) = (Name::new("f").unwrap(), Name::robot("r").unwrap());
        let metrics = Metrics::new(false).unwrap().of_fleet(&fleet);
        let counts =
            || [Invariant::ReceiptAfterCommit, Invariant::SetpointCommitted].map(|one| metrics.violations.of(one));
        let goes_out = |message: ToRobot, committed: i64| {
            let publication = Publication { transaction: 8, ..Publication::new(robot.clone(), message) };
            may_go_out(&publication, committed, &fleet, &metrics)
        };
        for committed in [8, 9] {
            assert!(goes_out(ToRobot::Receipt(receipt()), committed));
            assert!(goes_out(ToRobot::Setpoint(Box::new(setpoint())), committed));
        }
        assert_eq!(counts(), [0, 0]);
        assert!(!goes_out(ToRobot::Receipt(receipt()), 7));
        assert_eq!(counts(), [1, 0]);
        assert!(!goes_out(ToRobot::Setpoint(Box::new(setpoint())), 7));
        assert!(!goes_out(ToRobot::Cleared(RobotTopic::Estimate), 7));
        assert_eq!(counts(), [1, 1]);
    }
}
