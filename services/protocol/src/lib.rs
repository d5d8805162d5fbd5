//! Topics and messages of the whisker MQTT contract, version 1.
//!
//! Defines the messages between robots, the supervisor and other tools, but not their transport: no MQTT client, no
//! clock. Read in this order: [`topic`], [`messages`], then [`mod@decode`], which turns bytes into a checked
//! message or a labelled [`Refusal`].
//!
//! A message is checked once, when it is received. Unknown fields are ignored; a message with a missing or wrong
//! field is refused, without effect on other messages. Contacts, missed touches and the entries of a status are checked
//! one by one: a wrong one is refused alone.

mod check;
pub mod decode;
pub mod document;
pub mod messages;
pub mod name;
pub mod plain;
pub mod refusal;
pub mod rules;
#[cfg(feature = "documents")]
mod schema;
mod shape;
pub mod text_file;
pub mod timestamp;
pub mod topic;
pub mod words;

pub use decode::{
    Envelope, Message, Received, as_json, decode, decode_contacts, encode, encode_cbor, envelope, receive,
    receive_contacts,
};
pub use messages::{
    ArrayFacts, Connection, Contact, ContactPlace, Contacts, Distance, Estimate, Factsheet, Maintenance, MissedTouch,
    Receipt, Request, Setpoint, SetpointState, Software, Status, SupervisorRequest, SupervisorState, TestState,
    TouchTest, WhiskerEstimate, WhiskerFacts, WhiskerMaintenance, WhiskerStatus,
};
pub use name::{BadName, BootId, Name};
pub use refusal::Refusal;
pub use rules::Rule;
pub use timestamp::Timestamp;
pub use topic::{QualityOfService, RobotTopic, Topic};
pub use words::{
    AirControl, ArrayType, ConnectionState, Gauge, OnSupervisorLoss, PlaceKind, Regulator, RequestKind, Segmenter,
    SetpointError, SetpointOutcome, SetpointReason, SoftwareKind, SupervisorPresence, SupervisorRequestKind, Task,
    TouchTestError, TouchTestKind, TouchTestOutcome, TouchTestReason, WhiskerCondition,
};

/// Upper limit of sequence numbers and times (2^53), exclusive: every JSON reader represents smaller integers
/// exactly.
pub const INTEGER_LIMIT: u64 = 1 << 53;
/// Largest payload of a message, in bytes (256 KiB).
pub const PAYLOAD_MAX_BYTES: usize = 256 * 1024;
/// Largest number of contacts in one `contacts` message.
pub const CONTACTS_MAX: usize = 1000;
/// Largest number of arrays in one `factsheet`.
pub const ARRAYS_MAX: usize = 64;
/// Largest number of programs in one `factsheet`.
pub const SOFTWARE_MAX: usize = 64;
/// Largest number of whiskers in one array.
pub const WHISKERS_MAX: usize = 1024;
/// Largest number of `held` ranges in one `receipt`.
pub const HELD_MAX: usize = 1000;
/// Largest number of distances, and of deflections, in one touch test.
pub const TEST_POINTS_MAX: usize = 100;
/// Largest number of points in the `gain` of one whisker.
pub const GAIN_POINTS_MAX: usize = 64;
/// Most points of a whisker's response in an estimate.
pub const RESPONSE_POINTS_MAX: usize = 16;
