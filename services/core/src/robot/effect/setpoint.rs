//! Effects about setpoints: the commands to the robot and their states.

use borsh::{BorshDeserialize, BorshSerialize};

use super::{CommandKey, WhiskerIndex};
use crate::mechanics::CONTACT_RATIOS;
use crate::policy::Case;
use crate::units::{Megapascal, Micros};

/// A setpoint to publish.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct Command {
    /// Epoch and version, which identify the setpoint.
    pub key: CommandKey,
    /// Whisker that shall hold the pressure.
    pub whisker: WhiskerIndex,
    /// The only boot that may take it.
    pub robot_boot_id: String,
    /// Pressure to hold.
    pub pressure: Megapascal,
    /// Rate of change on the way to the pressure, MPa/s.
    pub slew_mpa_per_s: f64,
    /// Time of issue by the supervisor's clock.
    pub issued: Micros,
    /// Time by the robot's clock after which the robot rejects the setpoint.
    pub expires: Micros,
    /// Reason for the setpoint.
    pub reason: Reason,
    /// The compensation that it belongs to.
    pub compensation: Option<u32>,
    /// Residual gain at [`CONTACT_RATIOS`].
    pub gain: Option<[f64; CONTACT_RATIOS.len()]>,
}

/// Pressure and reason of a setpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// Pressure to hold.
    pub pressure: Megapascal,
    /// Reason for the setpoint.
    pub reason: Reason,
}

impl Command {
    /// Pressure and reason.
    #[must_use]
    pub fn asked(&self) -> Asked {
        Asked { pressure: self.pressure, reason: self.reason }
    }
}

/// Reason for a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Reason {
    /// A compensation begins.
    Compensation(Case),
    /// A compensation is over: back to the nominal pressure.
    Release,
    /// A compensation goes on at another pressure, or with another gain.
    Refinement,
    /// An operator asked for it.
    Operator,
}

/// State of a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum CommandState {
    /// Decided; not answered yet.
    Pending,
    /// The robot has it.
    Received,
    /// The robot is moving there.
    Applying,
    /// The robot is there.
    Applied,
    /// The robot will not take it.
    Rejected,
    /// The robot could not reach it.
    Failed,
    /// A newer one took its place.
    Superseded,
    /// No answer before its expiry.
    Expired,
    /// The robot started anew before it answered.
    Abandoned,
}
