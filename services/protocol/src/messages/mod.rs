//! One struct for each message, with the contract's field names.
//!
//! Each has `boot_id` (new at each start of its sender) and `seq` (from 0, per boot and topic, without gaps).
//! (robot, boot id, topic, seq) identifies a message; a duplicate changes nothing.

mod connection;
mod contacts;
mod estimate;
mod factsheet;
mod maintenance;
mod receipt;
mod request;
mod setpoint;
mod status;
mod supervisor;
mod touch_test;

pub use connection::Connection;
pub use contacts::{Contact, ContactPlace, Contacts, Distance, MissedTouch};
#[cfg(test)]
#[cfg(feature = "documents")]
pub(crate) use estimate::WITHIN_INTERVAL;
pub use estimate::{Estimate, WhiskerEstimate};
pub use factsheet::{ArrayFacts, Factsheet, Software, WhiskerFacts};
pub use maintenance::{Maintenance, WhiskerMaintenance};
pub use receipt::Receipt;
pub use request::Request;
pub use setpoint::{Setpoint, SetpointState};
pub use status::{Status, WhiskerStatus};
pub use supervisor::{SupervisorRequest, SupervisorState};
pub use touch_test::{TestState, TouchTest};

use crate::Refusal;

/// Checks beyond the types of a message's fields.
pub(crate) trait Checked {
    /// Returns a refusal if the message violates the contract.
    fn check(&self) -> Result<(), Refusal>;
}
