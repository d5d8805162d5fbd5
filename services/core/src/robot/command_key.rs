//! The name of a setpoint or test, which its answer repeats.

use borsh::{BorshDeserialize, BorshSerialize};

/// Names a setpoint on its robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, BorshSerialize, BorshDeserialize)]
pub struct CommandKey {
    /// Epoch of the supervisor that decided it.
    pub epoch: u64,
    /// Number on this robot.
    pub version: u64,
}
