use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Checked;
use crate::{BootId, ConnectionState, Refusal, Timestamp, check, schema};

/// `connection`: a robot's birth, its farewell, or (as last will) that its connection broke.
///
/// The order of receipt counts, not `seq` or `timestamp`: a will's are as old as its connection. A will
/// whose boot id is not the robot's newest is ignored.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Connection {
    /// The robot's boot.
    pub boot_id: BootId,
    /// From 0 in each boot.
    #[schemars(transform = schema::exact_integer)]
    pub seq: u64,
    /// When it was written.
    pub timestamp: Timestamp,
    /// Whether the robot is there.
    pub state: ConnectionState,
}

impl Checked for Connection {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)
    }
}
