use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Checked;
use crate::{BootId, Refusal, SupervisorPresence, check, schema};

/// `whisker/v1/{fleet}/supervisor/state`: whether a supervisor owns the fleet, and in which epoch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SupervisorState {
    /// The supervisor's boot.
    pub boot_id: BootId,
    /// From 0 in each boot.
    #[schemars(transform = schema::exact_integer)]
    pub seq: u64,
    /// Whether it is there.
    pub state: SupervisorPresence,
    /// Grows by at least one at each start of a supervisor of this fleet: the higher one is in charge.
    #[schemars(transform = schema::exact_integer)]
    pub epoch: u64,
}

impl Checked for SupervisorState {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::integer("epoch", self.epoch)
    }
}
