use serde::{Deserialize, Serialize};

use super::Checked;
use crate::{BootId, Refusal, RequestKind, check};

/// `request`: the supervisor asks a robot to send a message again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Request {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    pub seq: u64,
    /// The requested message.
    pub request: RequestKind,
}

impl Checked for Request {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)
    }
}
