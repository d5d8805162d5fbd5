//! Identifiers that several modules must derive in the same way.

use uuid::Uuid;
use vibrissa_core::robot::effect::CommandKey;
use vibrissa_protocol::Name;

/// Namespace of the identifiers of setpoints, which are derived from fleet, robot, epoch and version: a setpoint that
/// is sent again, by whichever supervisor, has the same identifier.
const COMMAND_NAMESPACE: Uuid = Uuid::from_u128(0x6f1d_6c0e_41b0_5d83_9a1e_7769_6272_6973);

/// Identifier of a setpoint, as text.
#[must_use]
pub fn command_id(fleet: &Name, robot: &Name, key: CommandKey) -> String {
    command_uuid(fleet, robot, key).to_string()
}

/// Identifier of a setpoint; its trace has the same one.
pub fn command_uuid(fleet: &Name, robot: &Name, key: CommandKey) -> Uuid {
    let name = format!("{fleet}/{robot}/{}/{}", key.epoch, key.version);
    Uuid::new_v5(&COMMAND_NAMESPACE, name.as_bytes())
}

/// Identifier of the trace of a decision that is not followed by a setpoint at once.
pub fn compensation_uuid(fleet: &Name, robot: &Name, number: u32) -> Uuid {
    let name = format!("{fleet}/{robot}/compensation/{number}");
    Uuid::new_v5(&COMMAND_NAMESPACE, name.as_bytes())
}

/// Number of a robot's trim or compensation in the database: the robot's number in the upper 32 bits, a count in the
/// lower.
pub fn wide_id(robot_id: i64, number: u32) -> i64 {
    (robot_id << 32) | i64::from(number)
}
