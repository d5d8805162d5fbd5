//! Topics and messages of the whisker MQTT contract, version 1.
//!
//! What robots, the supervisor and other people's tools say to each other, and nothing about how it
//! travels: no MQTT client, no clock. Read in this order: [`topic`], [`messages`], then [`mod@decode`], where
//! bytes become a checked message or a labelled [`Refusal`].
//!
//! A message is checked once, on its way in. Fields that a receiver does not know are ignored; a missing
//! or wrong one refuses that message and nothing else.

mod check;
pub mod decode;
pub mod document;
pub mod messages;
pub mod name;
pub mod refusal;
pub mod rules;
mod schema;
pub mod timestamp;
pub mod topic;
pub mod words;

pub use decode::{Envelope, Message, decode, decode_contacts, encode, envelope};
pub use messages::{
    ArrayFacts, Connection, Contact, Contacts, Factsheet, Receipt, Request, Setpoint, SetpointState, Status,
    SupervisorState, WhiskerFacts, WhiskerStatus,
};
pub use name::{BadName, BootId, Name};
pub use refusal::Refusal;
pub use rules::Rule;
pub use timestamp::Timestamp;
pub use topic::{QualityOfService, RobotTopic, Topic};
pub use words::{
    ArrayType, ConnectionState, Gauge, OnSupervisorLoss, Regulator, RequestKind, SetpointError, SetpointOutcome,
    SetpointReason, SupervisorPresence,
};

/// Sequence numbers and times stay below this (2^53), so that every JSON reader keeps them exact.
pub const INTEGER_LIMIT: u64 = 1 << 53;
/// The largest payload of any message, in bytes (256 KiB).
pub const PAYLOAD_MAX_BYTES: usize = 256 * 1024;
/// The most contacts in one `contacts` message.
pub const CONTACTS_MAX: usize = 1000;
/// The most arrays in one `factsheet`.
pub const ARRAYS_MAX: usize = 64;
/// The most whiskers in one array.
pub const WHISKERS_MAX: usize = 1024;
/// The most `held` ranges in one `receipt`.
pub const HELD_MAX: usize = 1000;
/// The most points in the `gain` of one `setpoint`.
pub const GAIN_POINTS_MAX: usize = 64;
