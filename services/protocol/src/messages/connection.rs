use serde::{Deserialize, Serialize};

use super::Checked;
use crate::{BootId, ConnectionState, Refusal, Timestamp, check};

/// `connection`: birth or farewell of a robot, or (as last will) its broken connection.
///
/// The order of arrival counts, not `seq` or `timestamp`: those of a will are as old as its connection. A will
/// whose boot id is not the robot's newest is ignored.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Connection {
    /// Boot id of the robot.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Time at which the message was written.
    pub timestamp: Timestamp,
    /// State of the connection.
    pub state: ConnectionState,
}

impl Checked for Connection {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)
    }
}
