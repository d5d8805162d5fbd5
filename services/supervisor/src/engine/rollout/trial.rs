//! Parameters of the robots that a roll-out has changed.

use std::sync::Arc;

use vibrissa_core::robot::Params;
use vibrissa_core::rollout::place;
use vibrissa_protocol::Name;

/// Parameters of the robots that a roll-out has changed.
#[derive(Debug, Clone)]
pub(crate) struct TrialParams {
    pub(crate) params: Arc<Params>,
    pub(super) seed: u64,
    pub(in crate::engine) place_max: u32,
}

impl TrialParams {
    /// Whether the roll-out has changed a robot.
    pub(crate) fn has(&self, robot: &Name) -> bool {
        place(self.seed, robot.as_str()) <= self.place_max
    }
}
