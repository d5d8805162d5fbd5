//! Robots that leave for good.

use tracing::info;
use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_core::robot::event::Link;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::full_name::FullName;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::actions::Action;
use vibrissa_store::batch::Record;

use super::Engine;
use super::commit::committer::LeaseLost;
use super::robot::KnownRobot;

/// Whether an action takes a robot out of service.
pub(super) fn leaves(action: &Action) -> bool {
    action.kind == RecordedKind::Decommission.word()
}

impl Engine {
    /// Takes a robot out of service: the database, this engine and the broker forget it, and its history stays.
    pub(super) async fn decommission(&mut self, action: &Action) -> Result<(), LeaseLost> {
        // Nothing of the robot may be written afterwards.
        self.settle().await?;
        self.begin_commit();
        self.settle().await?;
        let name = action.robot.as_deref().and_then(|name| Name::robot(name).ok());
        let Some((name, known)) = name.and_then(|name| Some((name.clone(), self.workers.robot(&name)?))) else {
            let problem = "UNKNOWN_ROBOT: there is no such robot in the fleet".to_owned();
            self.answer(action, 0, Some(Err(problem)));
            return Ok(());
        };
        let robot_id = known.robot_id;
        if wall_clock().0 as i64 >= action.expires_us {
            self.answer(action, robot_id, None);
            return Ok(());
        }
        if self.suspects.has(&name) {
            return Ok(());
        }
        if is_in_service(known) {
            let problem = "ROBOT_CONNECTED: the robot is connected and heard: switch it off first, or take it off the \
                           fleet's allow list";
            self.answer(action, robot_id, Some(Err(problem.to_owned())));
            return Ok(());
        }
        self.workers.record(Record::Decommissioned { robot_id, left_us: wall_clock().0 as i64 }, None);
        self.answer(action, robot_id, Some(Ok(())));
        // Out of its worker, so that the transaction has no checkpoint of it.
        let Some(known) = self.workers.of(&name).take_out(&name) else { return Ok(()) };
        // Before anything else is heard of it: a factsheet would register it again.
        self.begin_commit();
        if self.settle_naming().await?.contains(&robot_id) {
            // Nothing of it was written, not even the answer.
            self.workers.of(&name).put_back(known);
            let problem = "DATABASE_REFUSES: the database refuses to take the robot out of service, see the log";
            self.answer(action, 0, Some(Err(problem.to_owned())));
            return Ok(());
        }
        info!(robot = %FullName::robot(self.fleet.as_str(), name.as_str()), actor = action.actor, "robot decommissioned");
        self.workers.of(&name).forget(known);
        self.begin_commit();
        self.settle().await
    }
}

/// Whether a robot works: this supervisor hears it.
fn is_in_service(known: &KnownRobot) -> bool {
    let is_silent = known.robot.standing().any(|kind| kind == AlarmKind::RobotSilent);
    known.robot.connection_state().1 == Link::Online && known.is_heard && !is_silent && !known.is_excluded
}
