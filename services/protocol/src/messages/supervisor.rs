use serde::{Deserialize, Serialize};

use super::Checked;
use crate::{BootId, Refusal, SupervisorPresence, SupervisorRequestKind, Timestamp, check};

/// `whisker/v1/{fleet}/supervisor/state`: states whether a supervisor owns the fleet, and its epoch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct SupervisorState {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Whether the supervisor owns the fleet.
    pub state: SupervisorPresence,
    /// Epoch of the supervisor; it rises by at least one at each start of a supervisor of this fleet, and the
    /// highest one owns the fleet.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub epoch: u64,
}

impl Checked for SupervisorState {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::integer("epoch", self.epoch)
    }
}

/// `whisker/v1/{fleet}/supervisor/request`: the supervisor asks all robots of the fleet for something.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct SupervisorRequest {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Epoch of the supervisor, as in `supervisor/state`.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub epoch: u64,
    /// Time at which the message was written, by the supervisor's clock.
    pub timestamp: Timestamp,
    /// The messages that every robot of the fleet shall send.
    pub request: SupervisorRequestKind,
}

impl Checked for SupervisorRequest {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::integer("epoch", self.epoch)
    }
}
