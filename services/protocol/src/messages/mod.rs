//! One struct per message, with exactly the contract's field names.
//!
//! Each carries `boot_id` (new at each start of its sender) and `seq` (from 0, per boot and topic, without
//! gaps): (robot, boot id, topic, seq) names a message, and a second one of that name changes nothing.

mod connection;
mod contacts;
mod factsheet;
mod receipt;
mod request;
mod setpoint;
mod status;
mod supervisor;

pub use connection::Connection;
pub use contacts::{Contact, Contacts};
pub use factsheet::{ArrayFacts, Factsheet, WhiskerFacts};
pub use receipt::Receipt;
pub use request::Request;
pub use setpoint::{Setpoint, SetpointState};
pub use status::{Status, WhiskerStatus};
pub use supervisor::SupervisorState;

use crate::Refusal;

/// What a message must hold beyond the types of its fields.
pub(crate) trait Checked {
    /// Refuses what no sender that keeps the contract would send.
    fn check(&self) -> Result<(), Refusal>;
}
