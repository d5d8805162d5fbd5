//! Identifiers that several parts must derive alike.

use uuid::Uuid;
use vibrissa_core::robot::effect::CommandKey;
use vibrissa_protocol::Name;

use crate::clock::wall_clock;

/// Names of setpoints are made from this and (fleet, robot, epoch, version): the same setpoint has the same
/// name whenever and wherever it is sent again.
const COMMAND_NAMESPACE: Uuid = Uuid::from_u128(0x6f1d_6c0e_41b0_5d83_9a1e_7769_6272_6973);

/// The name of a setpoint.
#[must_use]
pub fn command_id(fleet: &Name, robot: &Name, key: CommandKey) -> String {
    command_uuid(fleet, robot, key).to_string()
}

/// The same as a number, which its trace has, too.
pub fn command_uuid(fleet: &Name, robot: &Name, key: CommandKey) -> Uuid {
    let name = format!("{fleet}/{robot}/{}/{}", key.epoch, key.version);
    Uuid::new_v5(&COMMAND_NAMESPACE, name.as_bytes())
}

/// The name of the trace of a decision from which no setpoint follows at once.
pub fn compensation_uuid(fleet: &Name, robot: &Name, number: u32) -> Uuid {
    let name = format!("{fleet}/{robot}/compensation/{number}");
    Uuid::new_v5(&COMMAND_NAMESPACE, name.as_bytes())
}

/// Numbers of a robot's trims and compensations are unique in the database: robot, then count.
pub fn wide_id(robot_id: i64, number: u32) -> i64 {
    (robot_id << 32) | i64::from(number)
}

/// Bytes that differ at each start of a program: the time, the process, and random bytes of the kernel.
pub fn start_seed() -> Vec<u8> {
    let mut seed = wall_clock().0.to_le_bytes().to_vec();
    seed.extend(std::process::id().to_le_bytes());
    seed.extend(std::fs::read("/proc/sys/kernel/random/uuid").unwrap_or_default());
    seed
}
